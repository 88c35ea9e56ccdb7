//! Records that the host, the plain-Rust twins and the WGSL kernels share, byte for byte.
//!
//! Each `#[repr(C)]` struct here has a WGSL twin of the same name in `wgsl/lib/layout.wgsl`;
//! `tests/wgsl.rs` compares their members, offsets and sizes through naga.
//!
//! All lengths are in **local units**: the scene recentred and scaled by a power of two so that its
//! largest half extent lies in (0.5, 1] (see [`crate::scene::Geometry`]). Radiosities are scaled by
//! [`crate::scene::Geometry::emission_scale`].

use bytemuck::{Pod, Zeroable};

/// "No such index": an unused slot, a ray that met nothing.
pub const NONE: u32 = u32::MAX;

/// Dimensions of a ray feature `xi = (x/L, lambda n_x, y/L, lambda n_y, mu B(x))` (design, 1.2).
pub const FEATURE_DIM: usize = 13;
/// Floats a feature or a cell takes in a buffer: [`FEATURE_DIM`] padded to four `vec4`.
pub const FEATURE_STRIDE: usize = 16;

/// What became of a ray; stored in [`Point::kind`] of both its ends.
pub mod kind {
    /// The start is dead (covered: it sees only back faces); the ray takes no part.
    pub const DEAD: u32 = 0;
    /// Both ends lie on front faces: the ray counts both ways.
    pub const FRONT: u32 = 1;
    /// The ray left the scene; one way only.
    pub const SKY: u32 = 2;
    /// The ray ended on a black back face; one way only.
    pub const BACK: u32 = 3;
    /// The ray was lost between mirrors ([`crate::twin::way`]); one way only.
    pub const LOST: u32 = 4;
}

/// Bit of [`Tri::plane`]: a triangle with the same corners and opposite winding is there too. A ray then meets
/// the one that faces it, and its back never.
pub const TWIN: u32 = 1 << 31;

/// A node of the bounding volume hierarchy (32 bytes, as obvhs builds it).
/// `count == 0`: an inner node whose children are `first` and `first + 1`; else a leaf of `count`
/// triangles from `first`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct BvhNode {
    /// Lower corner.
    pub min: [f32; 3],
    /// Triangles in a leaf, 0 for an inner node.
    pub count: u32,
    /// Upper corner.
    pub max: [f32; 3],
    /// First child or first triangle.
    pub first: u32,
}

/// A triangle, in the order of the hierarchy's leaves (64 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Tri {
    /// First vertex.
    pub v0: [f32; 3],
    /// Index into the materials.
    pub material: u32,
    /// Second vertex.
    pub v1: [f32; 3],
    /// Planar piece the triangle belongs to, maybe with [`TWIN`]; rays never meet the piece that they leave.
    pub plane: u32,
    /// Third vertex.
    pub v2: [f32; 3],
    /// First of the `split * split` equal-area tiles on which start densities are tabled.
    pub first_tile: u32,
    /// Unit normal from the winding, computed in f64.
    pub normal: [f32; 3],
    /// Tiles along an edge. Of a mirror, which has one tile, its reflectance instead, as a normal `f32`'s bits: kernels
    /// that shoot rays then need no more of a mirror than its triangle.
    pub split: u32,
}

/// What [`Tri::split`] is less than where it is no mirror's reflectance, and more than where it is.
pub const MIRROR: u32 = 1 << 20;

impl Tri {
    /// Reflectance of a mirror; 0: none.
    pub fn mirror(&self) -> f32 {
        if self.split < MIRROR { 0.0 } else { f32::from_bits(self.split) }
    }

    /// Tiles along an edge.
    pub fn cuts(&self) -> u32 {
        if self.split < MIRROR { self.split } else { 1 }
    }
}

/// A material (32 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Diffuse reflectance rho, linear Rec.709, each in [0, 1).
    pub rho: [f32; 3],
    /// Padding.
    pub pad0: u32,
    /// Emitted radiosity E = pi Ke, scaled.
    pub emit: [f32; 3],
    /// Padding.
    pub pad1: u32,
}

/// An emitting triangle and its share of the light sampling (16 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Emitter {
    /// Triangle index.
    pub tri: u32,
    /// Upper end of its interval of the cumulative distribution, in 2^-32 (the last is `u32::MAX`).
    pub cdf: u32,
    /// Sampling density over the triangle, per local area.
    pub density: f32,
    /// Square of the local distance from its first corner beyond which it takes up little of any direction's share:
    /// see [`crate::twin::direct::near2`].
    pub near2: f32,
}

/// A tile's share of the start distribution (8 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Tile {
    /// Upper end of its interval of the cumulative distribution, in 2^-32 (the last live one is `u32::MAX`).
    pub cdf: u32,
    /// Start density p over the tile, per local area.
    pub density: f32,
}

/// A surface point; two consecutive ones are the two ends of a ray (32 bytes).
///
/// Where light is lost on its way ([`crate::scene::Geometry::is_lossy`]) the densities of a ray, once its weight is known, are
/// others: its end's is the share T of its light that arrives, also at a hit of pass `shoot`; its start's the share that
/// mirrors take.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Point {
    /// Position; for the far end of an escaped ray its direction.
    pub p: [f32; 3],
    /// Triangle, or [`NONE`].
    pub tri: u32,
    /// Tile, or [`NONE`].
    pub tile: u32,
    /// One of [`kind`].
    pub kind: u32,
    /// The ray's weight w in local area (already divided by the number of rays), 0 where the ray takes no part.
    pub weight: f32,
    /// Start density p at the point, per local area.
    pub density: f32,
}

/// A node of the surface network: a live surface point (48 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Node {
    /// Position.
    pub p: [f32; 3],
    /// Material index: nodes serve only points of their own material.
    pub material: u32,
    /// Unit normal.
    pub n: [f32; 3],
    /// Planar piece.
    pub plane: u32,
    /// Mean of the node's deposit minus `p`, along the two tangents (see [`crate::twin::math::tangents`]).
    pub mean: [f32; 2],
    /// Power of two that brings the sources of light around it near 1, so that dim rooms keep their digits
    /// (see [`crate::radiosity::components`]); negative where no ray has met the node, which then speaks for no point.
    pub gain: f32,
    /// Way along the normal until something stands in it, local; found anew where a network is read.
    pub clear: f32,
}

/// The interpolation weights psi of a point: at most four compatible nodes (32 bytes).
///
/// An *orphan* has no compatible node: all weights are 0, and `node[0]` names the nearest node in sight
/// whose normal and material agree, or [`NONE`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Psi {
    /// Node indices, [`NONE`] where unused.
    pub node: [u32; 4],
    /// Weights, summing to 1 unless the point is an orphan.
    pub weight: [f32; 4],
}

impl Psi {
    /// No node at all.
    pub const EMPTY: Psi = Psi { node: [NONE; 4], weight: [0.0; 4] };

    /// Whether no node was compatible.
    pub fn is_orphan(&self) -> bool {
        self.weight[0] == 0.0
    }
}

/// The solved light at a node: irradiance and its tangential gradient, a band each (48 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct NodeLight {
    /// Irradiance H at the node's deposit mean, W/m² scaled.
    pub h: [f32; 3],
    /// Padding.
    pub pad0: u32,
    /// Gradient along the first tangent, per local length.
    pub g0: [f32; 3],
    /// Padding.
    pub pad1: u32,
    /// Gradient along the second tangent, per local length.
    pub g1: [f32; 3],
    /// Padding.
    pub pad2: u32,
}

/// A candidate list entry: nodes that may be among the nearest nine of any point of a tile (8 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Candidate {
    /// Node index.
    pub node: u32,
    /// 1 where nothing can stand between the tile and the node, so that no ray need be shot.
    pub free: u32,
}

/// Running sums of a point's direct light, a round of samples a term (32 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct DirectSum {
    /// Sum of the rounds' estimates of the direct irradiance D, W/m² scaled.
    pub sum: [f32; 3],
    /// Rounds so far.
    pub rounds: u32,
    /// Sum of the squares of the rounds' band means.
    pub square: f32,
    /// Padding.
    pub pad0: [u32; 3],
}

/// A 64-bit two's-complement sum, as two words (8 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Fixed {
    /// Lower word.
    pub lo: u32,
    /// Upper word.
    pub hi: u32,
}

/// What a training epoch leaves in a cell: the sums of its rays' features and their squared
/// distances to the cell, in units of 2^-32, and their number (128 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CellSums {
    /// Sums of the features' components.
    pub feature: [Fixed; FEATURE_DIM],
    /// Sum of squared distances to the cell: its resource.
    pub distortion: Fixed,
    /// Number of rays, in whole units of `lo`.
    pub count: Fixed,
    /// Padding.
    pub pad0: Fixed,
}

/// One coefficient being summed: a node seen from a cell, in units of [`crate::twin::fixed::UNIT`] (32 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Slot {
    /// Node index plus one; 0 where the slot is empty.
    pub key: u32,
    /// Padding.
    pub pad0: u32,
    /// Sum of w psi.
    pub value: Fixed,
    /// Sum of w psi (y - p) along the first tangent.
    pub first: Fixed,
    /// Sum of w psi (y - p) along the second tangent.
    pub second: Fixed,
}

/// What a cell's rays carry as a whole, in units of [`crate::twin::fixed::UNIT`] (32 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct CellFlux {
    /// Sum of w: the flux Phi.
    pub flux: Fixed,
    /// Sum of w s, a band each, where s is what the emitter end sends by itself.
    pub source: [Fixed; 3],
}

/// What arrives around a node as a whole, in units of [`crate::twin::fixed::UNIT`] (64 bytes).
/// Rays to the sky and to back faces count here too.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct NodeSums {
    /// Sum of w psi: the mass m.
    pub mass: Fixed,
    /// First moments of w psi (y - p) along both tangents.
    pub first: [Fixed; 2],
    /// Second moments: 11, 12, 22.
    pub second: [Fixed; 3],
    /// Sum of n (w psi)^2, for the effective number of samples.
    pub square: Fixed,
    /// Padding.
    pub pad0: Fixed,
}

/// A coefficient of the solve (16 bytes): between a cell and a node, value and tangential parts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Link {
    /// The node (in a cell's gather row) or the cell (in a node's deposit row).
    pub other: u32,
    /// a_ci or o_cj/m_j.
    pub value: f32,
    /// a'_ci or o'_cj/m_j along the first tangent.
    pub first: f32,
    /// The same along the second tangent.
    pub second: f32,
}

/// The inverse of a node's ridged second moments (16 bytes): turns moments into a gradient.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Plane {
    /// Element 11; all are 0 where the node has too few samples for a gradient.
    pub i11: f32,
    /// Element 12.
    pub i12: f32,
    /// Element 22.
    pub i22: f32,
    /// Material of the node.
    pub material: u32,
}

/// What is known to arrive around a node, in units of [`crate::twin::fixed::UNIT`] (72 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct NodeSource {
    /// Sum of w psi s, a band each, where s is what the emitter end sends.
    pub value: [Fixed; 3],
    /// The same times (y - p) along the first tangent.
    pub first: [Fixed; 3],
    /// The same along the second tangent.
    pub second: [Fixed; 3],
}

/// What a supervised network is shown: an input's best-matching cell, and the value to learn (16 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Sample {
    /// Best-matching cell of the input, or [`NONE`].
    pub winner: u32,
    /// Value to learn, in [-1, 1].
    pub goal: f32,
    /// Importance weight, 0 to 32: one over the chance that the input was taken.
    pub weight: f32,
    /// What the network answers; `respond` sets it.
    pub output: f32,
}

/// A cell's part of the output (64 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CellOutput {
    /// Slope about the cell's centre; 0 unless cells are linear.
    pub slope: [f32; FEATURE_DIM],
    /// Value at the cell's centre.
    pub value: f32,
    /// Width of the activation.
    pub width: f32,
    /// Padding.
    pub pad0: f32,
}

/// What a batch of samples leaves in a cell, in units of 2^-32 (144 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ResponseSums {
    /// Sums of the components of the inputs that it won.
    pub feature: [Fixed; FEATURE_DIM],
    /// Number of inputs won, in whole units of `lo`.
    pub count: Fixed,
    /// Sum of their weights.
    pub share: Fixed,
    /// Sum of weight times squared error: what the resource gains.
    pub error: Fixed,
    /// Sum of weight times activation times error, over all inputs that it answered.
    pub gain: Fixed,
    /// Sum of weight times activation.
    pub activation: Fixed,
}
