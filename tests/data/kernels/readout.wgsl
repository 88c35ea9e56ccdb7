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
    var mean: f32 = 0f;
    var square: f32 = 0f;
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
            let _e33 = light[s_1.node.x].h;
            sum = _e33;
        }
    } else {
        loop {
            let _e36 = k;
            if (_e36 < 4u) {
            } else {
                break;
            }
            {
                let _e40 = k;
                if (s_1.weight[_e40] > 0f) {
                    let _e45 = k;
                    let j = s_1.node[_e45];
                    let _e50 = nodes[j].n;
                    let _e51 = tangents(_e50);
                    let _e55 = points[i].p;
                    let _e59 = nodes[j].p;
                    let d = (_e55 - _e59);
                    let _e62 = dot3_(d, _e51.t1_);
                    let _e67 = nodes[j].mean.x;
                    let a_2 = (_e62 - _e67);
                    let _e70 = dot3_(d, _e51.t2_);
                    let _e75 = nodes[j].mean.y;
                    let b_2 = (_e70 - _e75);
                    let _e80 = light[j].h;
                    let _e84 = light[j].g0_;
                    let _e90 = light[j].g1_;
                    let says = ((_e80 + (_e84 * a_2)) + (_e90 * b_2));
                    let _e93 = sum;
                    let _e95 = k;
                    sum = (_e93 + (says * s_1.weight[_e95]));
                    let grey = (((says.x + says.y) + says.z) / 3f);
                    let _e106 = mean;
                    let _e108 = k;
                    mean = (_e106 + (grey * s_1.weight[_e108]));
                    let _e112 = square;
                    let _e115 = k;
                    square = (_e112 + ((grey * grey) * s_1.weight[_e115]));
                }
            }
            continuing {
                let _e120 = k;
                k = (_e120 + 1u);
            }
        }
    }
    let _e124 = sum;
    let _e127 = square;
    let _e128 = mean;
    let _e129 = mean;
    irradiance[i] = vec4<f32>(max(_e124, vec3<f32>()), sqrt(max((_e127 - (_e128 * _e129)), 0f)));
    return;
}
