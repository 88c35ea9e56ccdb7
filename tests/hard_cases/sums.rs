//! Sums: cases G of `docs/hard_cases.md`.
