//! A first small kernel that finds drivers which do not do what the others rely on.

use super::{Access, Gpu, Kernel};
use crate::error::{Error, Result};
use bytemuck::{Pod, Zeroable};

/// Loop trips that any kernel may make in one invocation.
pub const LOOP_BUDGET: u32 = 30_000;
/// Invocations of [`check`].
const COUNT: u32 = 192;

/// Parameters of `wgsl/sentinel.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Params {
    /// First item.
    pub base: u32,
    /// Items in the dispatch.
    pub count: u32,
    /// Loop trips to make.
    pub trips: u32,
    /// Bits of a float to cast there and back.
    pub bits: u32,
}

pub(crate) const KERNEL: Kernel = Kernel::new("sentinel", &[Access::Write]);

/// What the sentinel counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// Sum over the items of 0xC0000000, with carry.
    pub sum: u64,
    /// Loop trips made, modulo 2^32.
    pub trips: u32,
    /// Items whose bit casts came out right.
    pub items: u32,
    /// Sum of the items' numbers, modulo 2^32.
    pub index_sum: u32,
}

impl Counts {
    /// What a faithful driver counts.
    pub fn expected(items: u32, trips: u32) -> Counts {
        let n = u64::from(items);
        Counts { sum: n * 0xC000_0000, trips: items.wrapping_mul(trips), items, index_sum: (n * n.saturating_sub(1) / 2) as u32 }
    }
}

/// Runs the sentinel over `items` items of `trips` loop trips each, `chunk` items a dispatch.
pub fn count(gpu: &Gpu, items: u32, trips: u32, chunk: u32) -> Result<Counts> {
    let out = gpu.alloc::<u32>("sentinel", 5)?;
    let params = Params { trips, bits: 1.5f32.to_bits(), ..Default::default() };
    gpu.run(&KERNEL, &params, &[out.buffer()], items as usize, chunk)?;
    let got = gpu.read(&out)?;
    Ok(Counts { sum: u64::from(got[1]) << 32 | u64::from(got[0]), trips: got[2], items: got[3], index_sum: got[4] })
}

/// Checks loops as long as the budget, integer atomics with carry, bit casts, and dispatches in parts.
///
/// Errors: [`Error::Unfinished`] with what was counted.
pub fn check(gpu: &Gpu) -> Result<()> {
    check_trips(gpu, LOOP_BUDGET)
}

/// The same with loops of so many trips.
pub fn check_trips(gpu: &Gpu, trips: u32) -> Result<()> {
    judge(count(gpu, COUNT, trips, 128)?, Counts::expected(COUNT, trips))
}

/// What a driver counted against what a faithful one does.
pub fn judge(got: Counts, want: Counts) -> Result<()> {
    if got != want {
        return Err(Error::Unfinished { kernel: "sentinel", why: format!("it counted {got:?} instead of {want:?}") });
    }
    Ok(())
}
