// Integer accumulators: an u64 is two u32, low first.

// What the high word gains when `add` was added to a low word that held `old`.
fn carry(old: u32, add: u32) -> u32 {
    return select(0u, 1u, old + add < old);
}
