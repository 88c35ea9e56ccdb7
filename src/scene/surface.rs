//! Looking up the surface at a given point (for queries).
