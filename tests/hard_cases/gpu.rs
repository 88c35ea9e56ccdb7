//! GPU: cases H of `docs/hard_cases.md`.
