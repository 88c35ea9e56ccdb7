const NONE: u32 = 4294967295u;

struct Node {
    p: vec3<f32>,
    material: u32,
    n: vec3<f32>,
    plane: u32,
    mean: vec2<f32>,
    gain: f32,
    clear: f32,
}

struct NodeLight {
    h: vec3<f32>,
    pad0_: u32,
    g0_: vec3<f32>,
    pad1_: u32,
    g1_: vec3<f32>,
    pad2_: u32,
}

struct Params {
    base: u32,
    count: u32,
    pad0_: u32,
    pad1_: u32,
}

struct Point {
    p: vec3<f32>,
    tri: u32,
    tile: u32,
    kind: u32,
    weight: f32,
    density: f32,
}

struct Psi {
    node: vec4<u32>,
    weight: vec4<f32>,
}

struct Tangents {
    t1_: vec3<f32>,
    t2_: vec3<f32>,
}

@group(0) @binding(0) 
var<uniform> params: Params;

@group(0) @binding(1) 
var<storage> nodes: array<Node>;

@group(0) @binding(2) 
var<storage> light: array<NodeLight>;

@group(0) @binding(3) 
var<storage> points: array<Point>;

@group(0) @binding(4) 
var<storage> psi: array<Psi>;

@group(0) @binding(5) 
var<storage, read_write> irradiance: array<vec4<f32>>;

fn dot3_(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return (((a.x * b.x) + (a.y * b.y)) + (a.z * b.z));
}

fn tangents(n: vec3<f32>) -> Tangents {
    let s = select(-1f, 1f, (n.z >= 0f));
    let a_1 = (-1f / (s + n.z));
    let b_1 = ((n.x * n.y) * a_1);
    return Tangents(vec3<f32>((1f + (((s * n.x) * n.x) * a_1)), (s * b_1), (-(s) * n.x)), vec3<f32>(b_1, (s + ((n.y * n.y) * a_1)), -(n.y)));
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var sum: vec3<f32> = vec3<f32>();
    var k: u32 = 0u;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let i = (_e8 + gid.x);
    let s_1 = psi[i];
    if (s_1.weight.x == 0f) {
        if (s_1.node.x != NONE) {
            let _e29 = light[s_1.node.x].h;
            sum = _e29;
        }
    } else {
        loop {
            let _e32 = k;
            if (_e32 < 4u) {
            } else {
                break;
            }
            {
                let _e36 = k;
                if (s_1.weight[_e36] > 0f) {
                    let _e41 = k;
                    let j = s_1.node[_e41];
                    let _e46 = nodes[j].n;
                    let _e47 = tangents(_e46);
                    let _e51 = points[i].p;
                    let _e55 = nodes[j].p;
                    let d = (_e51 - _e55);
                    let _e58 = dot3_(d, _e47.t1_);
                    let _e63 = nodes[j].mean.x;
                    let a_2 = (_e58 - _e63);
                    let _e66 = dot3_(d, _e47.t2_);
                    let _e71 = nodes[j].mean.y;
                    let b_2 = (_e66 - _e71);
                    let _e73 = sum;
                    let _e77 = light[j].h;
                    let _e81 = light[j].g0_;
                    let _e87 = light[j].g1_;
                    let _e91 = k;
                    sum = (_e73 + (((_e77 + (_e81 * a_2)) + (_e87 * b_2)) * s_1.weight[_e91]));
                }
            }
            continuing {
                let _e96 = k;
                k = (_e96 + 1u);
            }
        }
    }
    let _e100 = sum;
    irradiance[i] = vec4<f32>(max(_e100, vec3<f32>()), 0f);
    return;
}
