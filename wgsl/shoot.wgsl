// Pass shoot: cosine rays from given points; the hits are points again. Twin: src/twin/shoot.rs.
#import layout
#import surface
#import sobol

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    seed: u32,
    first: u32, // first ray of each point's sequence
    rays: u32, // consecutive hits a point
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> bvh: array<BvhNode>;
@group(0) @binding(2) var<storage, read> tris: array<Tri>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read_write> hits: array<Point>;
@group(0) @binding(5) var<storage, read_write> status: array<atomic<u32>>;
@group(0) @binding(6) var texels: texture_2d_array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let r = params.base + gid.x;
    let i = r / params.rays;
    let k = params.first + r % params.rays;
    let tri = points[i].tri;
    var p = Point(vec3<f32>(), NONE, NONE, DEAD, 0.0, 0.0);
    if tri != NONE {
        let u = sobol4(k, seed_of(params.seed, i));
        let met = first_hit(tri, points[i].p, cosine_direction(tri_normal(tri), unit(u.x), unit(u.y)));
        if LOSSY {
            if met.hit.tri != NONE {
                p = surface_point(met.hit.tri, met.hit.b1, met.hit.b2);
                p.weight = met.hit.t;
            }
            p.density = way.share;
        } else if met.kind != SKY {
            p = surface_point(met.hit.tri, met.hit.b1, met.hit.b2);
            p.weight = met.hit.t;
        }
        p.kind = met.kind;
    }
    hits[r] = p;
    finish();
}
