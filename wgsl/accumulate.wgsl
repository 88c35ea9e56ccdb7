// Pass accumulate: what the rays of a training epoch leave in their cells. Twin: src/twin/accumulate.rs.
#import layout
#import fixed
#import sums

struct Params {
    base: u32,
    count: u32,
    start: u32, // first directed ray
    pad0: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> points: array<Point>;
@group(0) @binding(2) var<storage, read> features: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> winners: array<u32>;
@group(0) @binding(4) var<storage, read> cells: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> sums: array<atomic<u32>>; // CellSums, by words

const WORDS = 32u; // of CellSums
const DISTORTION = 26u;
const COUNT = 28u;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let d = params.start + params.base + gid.x;
    let cell = winners[d];
    if points[d].kind != FRONT || cell == NONE {
        return;
    }
    let at = WORDS * cell;
    var distance = 0.0;
    for (var k = 0u; k < 13u; k++) {
        let f = features[4u * d + k / 4u][k % 4u];
        add_sum(at + 2u * k, f, FEATURE_POWER);
        let e = f - cells[4u * cell + k / 4u][k % 4u];
        distance += e * e;
    }
    add_sum(at + DISTORTION, distance, FEATURE_POWER);
    let old = atomicAdd(&sums[at + COUNT], 1u);
    atomicAdd(&sums[at + COUNT + 1u], carry(old, 1u));
}
