// Pass kernel: G V on consecutive pairs of surface points, per local area. Twin: src/twin/kernel.rs.
#import layout
#import ray
#import medium

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    pad0: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> bvh: array<BvhNode>;
@group(0) @binding(2) var<storage, read> tris: array<Tri>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read_write> values: array<f32>;
@group(0) @binding(5) var<storage, read_write> status: array<atomic<u32>>;
@group(0) @binding(6) var texels: texture_2d_array<u32>;

fn pair(x: u32, y: u32) -> f32 {
    let tx = points[x].tri;
    let ty = points[y].tri;
    if tx == NONE || ty == NONE {
        return 0.0;
    }
    let planes = vec2<u32>(tri_plane(tx), tri_plane(ty));
    if planes.x == planes.y {
        return 0.0;
    }
    let g = kernel_g(points[x].p, tri_normal(tx), points[y].p, tri_normal(ty));
    if g > 0.0 && !segment_blocked(points[x].p, points[y].p, planes) {
        if SIGMA > 0.0 {
            return g * between(points[x].p, points[y].p);
        }
        return g;
    }
    return 0.0;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let i = params.base + gid.x;
    values[i] = pair(2u * i, 2u * i + 1u);
    finish();
}
