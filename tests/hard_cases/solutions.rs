//! Solutions: cases E of `docs/hard_cases.md`.
