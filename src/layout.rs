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
}

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
    /// Planar piece the triangle belongs to; rays never meet the piece that they leave.
    pub plane: u32,
    /// Third vertex.
    pub v2: [f32; 3],
    /// First of the `split * split` equal-area tiles on which start densities are tabled.
    pub first_tile: u32,
    /// Unit normal from the winding, computed in f64.
    pub normal: [f32; 3],
    /// Tiles along an edge.
    pub split: u32,
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
    /// Padding.
    pub pad0: u32,
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
    /// Padding.
    pub pad0: [u32; 2],
}

/// The interpolation weights psi of a point: at most four compatible nodes (32 bytes).
///
/// An *orphan* has no compatible node: all weights are 0, and `node[0]` names the nearest node whose
/// normal agrees, or [`NONE`].
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
