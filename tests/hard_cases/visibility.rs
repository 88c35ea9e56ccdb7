//! Visibility: cases D of `docs/hard_cases.md`.
