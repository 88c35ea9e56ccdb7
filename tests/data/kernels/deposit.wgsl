const FRONT: u32 = 1u;

const WORDS: u32 = 18u;

struct DirectSum {
    sum: vec3<f32>,
    rounds: u32,
    square: f32,
    pad0_: array<u32, 3>,
}

struct Material {
    rho: vec3<f32>,
    pad0_: u32,
    emit: vec3<f32>,
    pad1_: u32,
}

struct Node {
    p: vec3<f32>,
    material: u32,
    n: vec3<f32>,
    plane: u32,
    mean: vec2<f32>,
    gain: f32,
    clear: f32,
}

struct Params {
    base: u32,
    count: u32,
    known: u32,
    normalise: f32,
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
var<storage> points: array<Point>;

@group(0) @binding(2) 
var<storage> psi: array<Psi>;

@group(0) @binding(3) 
var<storage> nodes: array<Node>;

@group(0) @binding(4) 
var<storage> tris: array<Tri>;

@group(0) @binding(5) 
var<storage> materials: array<Material>;

@group(0) @binding(6) 
var<storage> direct: array<DirectSum>;

@group(0) @binding(7) 
var<storage> light: array<vec4<f32>>;

@group(0) @binding(8) 
var<storage, read_write> sums: array<atomic<u32>>;

fn add_sum(word: u32, value_1: f32, power_1: i32) {
    let _e3 = encode(value_1, power_1);
    let _e7 = atomicAdd((&sums[word]), _e3.x);
    let _e10 = carry(_e7, _e3.x);
    let hi_1 = (_e3.y + _e10);
    if (hi_1 != 0u) {
        let _e18 = atomicAdd((&sums[(word + 1u)]), hi_1);
        return;
    } else {
        return;
    }
}

fn add_sum3_(word_1: u32, value_2: vec3<f32>, power_2: i32) {
    add_sum(word_1, value_2.x, power_2);
    add_sum((word_1 + 2u), value_2.y, power_2);
    add_sum((word_1 + 4u), value_2.z, power_2);
    return;
}

fn carry(old: u32, add: u32) -> u32 {
    return select(0u, 1u, ((old + add) < old));
}

fn dot3_(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return (((a.x * b.x) + (a.y * b.y)) + (a.z * b.z));
}

fn encode(value: f32, power: i32) -> vec2<u32> {
    var lo: u32 = 0u;
    var hi: u32 = 0u;
    var local: bool;
    let bits = bitcast<u32>(value);
    let exponent = i32(((bits >> 23u) & 255u));
    let mantissa = ((bits & 8388607u) | 8388608u);
    let shift = ((exponent - 150i) + power);
    if !((exponent == 0i)) {
        local = (shift <= -24i);
    } else {
        local = true;
    }
    let _e27 = local;
    if _e27 {
        return vec2<u32>(0u, 0u);
    } else {
        if (shift < 0i) {
            lo = (mantissa >> u32(-(shift)));
        } else {
            if (shift == 0i) {
                lo = mantissa;
            } else {
                if (shift < 32i) {
                    lo = (mantissa << u32(shift));
                    hi = (mantissa >> u32((32i - shift)));
                } else {
                    if (shift < 40i) {
                        hi = (mantissa << u32((shift - 32i)));
                    } else {
                        lo = 4294967295u;
                        hi = 2147483647u;
                    }
                }
            }
        }
    }
    if ((bits >> 31u) != 0u) {
        let _e58 = lo;
        lo = (~(_e58) + 1u);
        let _e62 = hi;
        let _e66 = lo;
        hi = (~(_e62) + select(0u, 1u, (_e66 == 0u)));
    }
    let _e71 = lo;
    let _e72 = hi;
    return vec2<u32>(_e71, _e72);
}

fn tangents(n: vec3<f32>) -> Tangents {
    let s = select(-1f, 1f, (n.z >= 0f));
    let a_1 = (-1f / (s + n.z));
    let b_1 = ((n.x * n.y) * a_1);
    return Tangents(vec3<f32>((1f + (((s * n.x) * n.x) * a_1)), (s * b_1), (-(s) * n.x)), vec3<f32>(b_1, (s + ((n.y * n.y) * a_1)), -(n.y)));
}

fn tri_material(i: u32) -> u32 {
    let _e4 = tris[i].material;
    return _e4;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var h: vec3<f32> = vec3(0f);
    var sent: vec3<f32>;
    var k: u32 = 0u;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let d = (_e8 + gid.x);
    let y = points[d];
    if (y.kind != FRONT) {
        return;
    }
    let x = (d ^ 1u);
    let _e24 = params.known;
    if ((_e24 & 1u) != 0u) {
        let _e31 = light[x];
        h = _e31.xyz;
    }
    let _e37 = points[x].tri;
    let _e38 = tri_material(_e37);
    let material = materials[_e38];
    let _e42 = h;
    sent = ((material.rho * _e42) + material.emit);
    let _e49 = params.known;
    if ((_e49 & 2u) != 0u) {
        let _e58 = direct[x].sum;
        let _e62 = direct[x].rounds;
        let _e68 = h;
        sent = (material.rho * ((_e58 / vec3(f32(max(_e62, 1u)))) + _e68));
    }
    loop {
        let _e73 = k;
        if (_e73 < 4u) {
        } else {
            break;
        }
        {
            let _e79 = k;
            let weight = psi[d].weight[_e79];
            if (weight > 0f) {
                let _e87 = k;
                let node = psi[d].node[_e87];
                let _e93 = nodes[node].n;
                let _e94 = tangents(_e93);
                let _e99 = nodes[node].p;
                let e = (y.p - _e99);
                let _e104 = params.normalise;
                let _e110 = nodes[node].gain;
                let v = (((y.weight * _e104) * weight) * _e110);
                let _e112 = sent;
                let s_1 = (v * _e112);
                let at = (WORDS * node);
                add_sum3_(at, s_1, 58i);
                let _e120 = dot3_(e, _e94.t1_);
                add_sum3_((at + 6u), (s_1 * _e120), 58i);
                let _e126 = dot3_(e, _e94.t2_);
                add_sum3_((at + 12u), (s_1 * _e126), 58i);
            }
        }
        continuing {
            let _e130 = k;
            k = (_e130 + 1u);
        }
    }
    return;
}
