//! Scale: cases C of `docs/hard_cases.md`.
