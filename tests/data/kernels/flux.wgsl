const FRONT: u32 = 1u;

const NONE: u32 = 4294967295u;

const WORDS: u32 = 8u;

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

struct Params {
    base: u32,
    count: u32,
    exact: u32,
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
var<storage> winners: array<u32>;

@group(0) @binding(3) 
var<storage> tris: array<Tri>;

@group(0) @binding(4) 
var<storage> materials: array<Material>;

@group(0) @binding(5) 
var<storage> direct: array<DirectSum>;

@group(0) @binding(6) 
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

fn encode(value: f32, power: i32) -> vec2<u32> {
    var lo: u32 = 0u;
    var hi: u32 = 0u;
    var local_2: bool;
    let bits = bitcast<u32>(value);
    let exponent = i32(((bits >> 23u) & 255u));
    let mantissa = ((bits & 8388607u) | 8388608u);
    let shift = ((exponent - 150i) + power);
    if !((exponent == 0i)) {
        local_2 = (shift <= -24i);
    } else {
        local_2 = true;
    }
    let _e27 = local_2;
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

fn tri_material(i: u32) -> u32 {
    let _e4 = tris[i].material;
    return _e4;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var local: bool;
    var local_1: bool;
    var source: vec3<f32>;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let d = (_e8 + gid.x);
    let _e14 = points[d].weight;
    let _e17 = params.normalise;
    let w = (_e14 * _e17);
    if !((w <= 0f)) {
        let _e27 = points[d].kind;
        local = (_e27 != FRONT);
    } else {
        local = true;
    }
    let _e31 = local;
    if !(_e31) {
        let _e37 = winners[d];
        local_1 = (_e37 == NONE);
    } else {
        local_1 = true;
    }
    let _e41 = local_1;
    if _e41 {
        return;
    }
    let x = (d ^ 1u);
    let _e47 = points[x].tri;
    let _e48 = tri_material(_e47);
    let _e52 = materials[_e48].emit;
    source = _e52;
    let _e56 = params.exact;
    if (_e56 == 1u) {
        let _e62 = materials[_e48].rho;
        let _e66 = direct[x].sum;
        let _e70 = direct[x].rounds;
        source = (_e62 * (_e66 / vec3(f32(max(_e70, 1u)))));
    }
    let _e80 = winners[d];
    let at = (WORDS * _e80);
    add_sum(at, w, 58i);
    let _e85 = source;
    add_sum3_((at + 2u), (w * _e85), 58i);
    return;
}
