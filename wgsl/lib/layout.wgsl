// Records shared with the host byte for byte: the twins of src/layout.rs (tests/wgsl.rs compares them).

const NONE = 0xffffffffu;

// Point.kind
const DEAD = 0u; // a start that sees only back faces: takes no part
const FRONT = 1u; // both ends on front faces
const SKY = 2u; // the ray left the scene
const BACK = 3u; // the ray ended on a back face
const LOST = 4u; // the ray was given up between mirrors

// Whether light is lost on its way, at mirrors or to a medium. The density of a ray's end, and of a shot ray's hit, is then
// the share of its light that arrives, that of a ray's start the share that mirrors take.
override LOSSY: bool = false;

// Texels in a row, and rows in a layer, of records that are paged.
const ROW = 2048u;

const TWIN = 0x80000000u; // bit of a triangle's plane: its mirror image is there too

struct BvhNode {
    min: vec3<f32>,
    count: u32, // triangles in a leaf, 0 for an inner node
    max: vec3<f32>,
    first: u32, // first child or first triangle
}

struct Tri {
    v0: vec3<f32>,
    material: u32,
    v1: vec3<f32>,
    plane: u32, // planar piece, maybe with TWIN
    v2: vec3<f32>,
    first_tile: u32,
    normal: vec3<f32>,
    split: u32, // tiles along an edge
}

struct Material {
    rho: vec3<f32>, // reflectance
    pad0: u32,
    emit: vec3<f32>, // emitted radiosity, scaled
    pad1: u32,
}

struct Emitter {
    tri: u32,
    cdf: u32, // upper end of its interval, in 2^-32
    density: f32, // per local area
    near2: f32, // square of the distance from its first corner beyond which it is far
}

struct Tile {
    cdf: u32,
    density: f32,
}

struct Point {
    p: vec3<f32>, // position, or direction where the ray escaped
    tri: u32,
    tile: u32,
    kind: u32,
    weight: f32, // local area
    density: f32, // per local area
}

struct Node {
    p: vec3<f32>,
    material: u32,
    n: vec3<f32>,
    plane: u32,
    mean: vec2<f32>, // mean of the deposit minus p, along the tangents
    gain: f32, // power of two that brings the sources of light around it near 1
    clear: f32, // way along the normal until something stands in it
}

struct Psi {
    node: vec4<u32>,
    weight: vec4<f32>,
}

struct NodeLight {
    h: vec3<f32>, // irradiance at the deposit mean
    pad0: u32,
    g0: vec3<f32>, // gradients along the tangents
    pad1: u32,
    g1: vec3<f32>,
    pad2: u32,
}

struct Candidate {
    node: u32,
    free: u32, // 1: nothing can stand between
}

struct DirectSum {
    sum: vec3<f32>, // of the rounds' estimates of D
    rounds: u32,
    square: f32, // sum of the squares of the rounds' band means
    pad0: array<u32, 3>,
}

struct Fixed {
    lo: u32,
    hi: u32,
}

struct CellSums {
    feature: array<Fixed, 13>,
    distortion: Fixed,
    count: Fixed,
    pad0: Fixed,
}

struct Slot {
    key: u32, // node + 1; 0: empty
    pad0: u32,
    value: Fixed,
    first: Fixed,
    second: Fixed,
}

struct CellFlux {
    flux: Fixed,
    source: array<Fixed, 3>,
}

struct NodeSums {
    mass: Fixed,
    first: array<Fixed, 2>,
    second: array<Fixed, 3>,
    square: Fixed,
    pad0: Fixed,
}

struct NodeSource {
    value: array<Fixed, 3>,
    first: array<Fixed, 3>,
    second: array<Fixed, 3>,
}

struct Link {
    other: u32,
    value: f32,
    first: f32,
    second: f32,
}

struct Plane {
    i11: f32,
    i12: f32,
    i22: f32,
    material: u32,
}

struct Sample {
    winner: u32,
    goal: f32,
    weight: f32, // importance
    output: f32,
}

struct CellOutput {
    slope: array<f32, 13>,
    value: f32,
    width: f32,
    pad0: f32,
}

struct ResponseSums {
    feature: array<Fixed, 13>,
    count: Fixed,
    share: Fixed,
    error: Fixed,
    gain: Fixed,
    activation: Fixed,
}
