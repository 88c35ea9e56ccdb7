//! The random sequences of a bake, each from the seed and a number of its own.

use crate::twin::math::seed_of;

/// A sequence of a bake or of a read-out.
#[derive(Clone, Copy)]
pub(crate) enum Stream {
    TileDirect = 1,
    TilePlace,
    PilotNodes,
    PilotRays,
    PilotEnds,
    Nodes,
    Rays,
    Ends,
    Emission,
    PointDirect,
    PointProbe,
    PointGather,
    HitDirect,
    Patches,
    TestPoints,
    TestRays,
    TestHits,
    TestDirect,
    TestLandings,
}

pub(crate) fn stream(seed: u32, which: Stream) -> u32 {
    seed_of(seed, which as u32)
}
