//! Network: cases F of `docs/hard_cases.md`.
