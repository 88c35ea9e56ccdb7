//! Geometry: cases A of `docs/hard_cases.md`.
