// Pass emit, second kernel: takes dead starts out. Twin: src/twin/emit.rs.
//
// Only the few rays that met no front face are looked at, packed together: among all rays, one such
// would keep its neighbours waiting.
#import layout
#import surface
#import sobol

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    seed: u32,
    first: u32, // first ray of the sequence
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> bvh: array<BvhNode>;
@group(0) @binding(2) var<storage, read> tris: array<Tri>;
@group(0) @binding(3) var<storage, read> suspects: array<u32>; // their number first
@group(0) @binding(4) var<storage, read_write> points: array<Point>;
@group(0) @binding(5) var<storage, read_write> status: array<atomic<u32>>;
@group(0) @binding(6) var texels: texture_2d_array<u32>;

const PROBES = 11u; // cosine rays that decide whether a start is dead
const SKY_PROBES = 4u; // probes after which a start that has seen sky only is alive

// Whether a point that has not yet seen a front face is dead.
fn is_dead(tri: u32, p: vec3<f32>, seed: u32, first: u32) -> bool {
    let n = tri_normal(tri);
    var back = select(0u, 1u, first == BACK);
    var k = 0u;
    for (; k < PROBES; k++) {
        let u = sobol4(k, seed);
        let met = first_hit(tri, p, cosine_direction(n, unit(u.z), unit(u.w)));
        if met.kind == FRONT {
            return false;
        }
        back += select(0u, 1u, met.kind == BACK);
        if back == 0u && k + 1u == SKY_PROBES {
            return false;
        }
    }
    unfinished = unfinished || k < PROBES;
    return 4u * back >= PROBES + 1u;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    let i = params.base + gid.x;
    if gid.x >= params.count || i >= suspects[0] {
        return;
    }
    let item = suspects[1u + i];
    let s = 2u * item;
    if is_dead(points[s].tri, points[s].p, seed_of(params.seed, params.first + item), points[s].kind) {
        points[s].kind = DEAD;
        points[s].weight = 0.0;
        points[s + 1u].kind = DEAD;
    }
    finish();
}
