// Pass feature: a directed ray, from point d^1 to point d, as a point of ray space. Twin: src/twin/winner.rs.
#import layout
#import triangles

struct Params {
    base: u32,
    count: u32,
    inv_unit: f32, // 1/L
    lambda: f32, // weight of normals
    mu: f32, // weight of the emitter end's brightness
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> tris: array<Tri>;
@group(0) @binding(2) var<storage, read> points: array<Point>;
@group(0) @binding(3) var<storage, read> brightness: array<f32>; // B/B_rms of each tile
@group(0) @binding(4) var<storage, read_write> features: array<vec4<f32>>; // four a ray

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let d = params.base + gid.x;
    let at = 4u * d;
    if points[d].kind != FRONT {
        features[at] = vec4<f32>();
        features[at + 1u] = vec4<f32>();
        features[at + 2u] = vec4<f32>();
        features[at + 3u] = vec4<f32>();
        return;
    }
    let e = d ^ 1u;
    let x = points[e].p * params.inv_unit;
    let nx = tri_normal(points[e].tri) * params.lambda;
    let y = points[d].p * params.inv_unit;
    let ny = tri_normal(points[d].tri) * params.lambda;
    features[at] = vec4<f32>(x, nx.x);
    features[at + 1u] = vec4<f32>(nx.yz, y.xy);
    features[at + 2u] = vec4<f32>(y.z, ny);
    features[at + 3u] = vec4<f32>(params.mu * min(brightness[points[e].tile], 3.0), 0.0, 0.0, 0.0);
}
