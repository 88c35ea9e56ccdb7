//! Input: cases B of `docs/hard_cases.md`.
