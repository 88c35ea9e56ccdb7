const FRONT: u32 = 1u;

struct Params {
    base: u32,
    count: u32,
    inv_unit: f32,
    lambda: f32,
    mu: f32,
    pad0_: u32,
    pad1_: u32,
    pad2_: u32,
}

struct Point {
    p: vec3<f32>,
    tri: u32,
    tile: u32,
    kind: u32,
    weight: f32,
    density: f32,
}

struct Tri {
    v0_: vec3<f32>,
    material: u32,
    v1_: vec3<f32>,
    plane: u32,
    v2_: vec3<f32>,
    first_tile: u32,
    normal: vec3<f32>,
    split: u32,
}

@group(0) @binding(0) 
var<uniform> params: Params;

@group(0) @binding(1) 
var<storage> tris: array<Tri>;

@group(0) @binding(2) 
var<storage> points: array<Point>;

@group(0) @binding(3) 
var<storage> brightness: array<f32>;

@group(0) @binding(4) 
var<storage, read_write> features: array<vec4<f32>>;

fn tri_normal(i: u32) -> vec3<f32> {
    let _e4 = tris[i].normal;
    return _e4;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let d = (_e8 + gid.x);
    let at = (4u * d);
    let _e16 = points[d].kind;
    if (_e16 != FRONT) {
        features[at] = vec4<f32>();
        features[(at + 1u)] = vec4<f32>();
        features[(at + 2u)] = vec4<f32>();
        features[(at + 3u)] = vec4<f32>();
        return;
    }
    let e = (d ^ 1u);
    let _e42 = points[e].p;
    let _e45 = params.inv_unit;
    let x = (_e42 * _e45);
    let _e50 = points[e].tri;
    let _e51 = tri_normal(_e50);
    let _e54 = params.lambda;
    let nx = (_e51 * _e54);
    let _e59 = points[d].p;
    let _e62 = params.inv_unit;
    let y = (_e59 * _e62);
    let _e67 = points[d].tri;
    let _e68 = tri_normal(_e67);
    let _e71 = params.lambda;
    let ny = (_e68 * _e71);
    features[at] = vec4<f32>(x, nx.x);
    features[(at + 1u)] = vec4<f32>(nx.yz, y.xy);
    features[(at + 2u)] = vec4<f32>(y.z, ny);
    let _e96 = params.mu;
    let _e101 = points[e].tile;
    let _e103 = brightness[_e101];
    features[(at + 3u)] = vec4<f32>((_e96 * min(_e103, 3f)), 0f, 0f, 0f);
    return;
}
