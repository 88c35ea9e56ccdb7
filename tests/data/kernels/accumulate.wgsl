const COUNT: u32 = 28u;

const DISTORTION: u32 = 26u;

const FRONT: u32 = 1u;

const NONE: u32 = 4294967295u;

const WORDS: u32 = 32u;

struct Params {
    base: u32,
    count: u32,
    start: u32,
    pad0_: u32,
}

struct Point {
    p: vec3<f32>,
    tri: u32,
    tile: u32,
    kind: u32,
    weight: f32,
    density: f32,
}

@group(0) @binding(0) 
var<uniform> params: Params;

@group(0) @binding(1) 
var<storage> points: array<Point>;

@group(0) @binding(2) 
var<storage> features: array<vec4<f32>>;

@group(0) @binding(3) 
var<storage> winners: array<u32>;

@group(0) @binding(4) 
var<storage> cells: array<vec4<f32>>;

@group(0) @binding(5) 
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

fn carry(old: u32, add: u32) -> u32 {
    return select(0u, 1u, ((old + add) < old));
}

fn encode(value: f32, power: i32) -> vec2<u32> {
    var lo: u32 = 0u;
    var hi: u32 = 0u;
    var local_1: bool;
    let bits = bitcast<u32>(value);
    let exponent = i32(((bits >> 23u) & 255u));
    let mantissa = ((bits & 8388607u) | 8388608u);
    let shift = ((exponent - 150i) + power);
    if !((exponent == 0i)) {
        local_1 = (shift <= -24i);
    } else {
        local_1 = true;
    }
    let _e27 = local_1;
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

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var local: bool;
    var distance_: f32 = 0f;
    var k: u32 = 0u;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.start;
    let _e11 = params.base;
    let d = ((_e8 + _e11) + gid.x);
    let cell = winners[d];
    let _e21 = points[d].kind;
    if !((_e21 != FRONT)) {
        local = (cell == NONE);
    } else {
        local = true;
    }
    let _e30 = local;
    if _e30 {
        return;
    }
    let at = (WORDS * cell);
    loop {
        let _e37 = k;
        if (_e37 < 13u) {
        } else {
            break;
        }
        {
            let _e43 = k;
            let _e48 = k;
            let f = features[((4u * d) + (_e43 / 4u))][(_e48 % 4u)];
            let _e54 = k;
            add_sum((at + (2u * _e54)), f, 32i);
            let _e61 = k;
            let _e66 = k;
            let _e70 = cells[((4u * cell) + (_e61 / 4u))][(_e66 % 4u)];
            let e = (f - _e70);
            let _e72 = distance_;
            distance_ = (_e72 + (e * e));
        }
        continuing {
            let _e76 = k;
            k = (_e76 + 1u);
        }
    }
    let _e80 = distance_;
    add_sum((at + DISTORTION), _e80, 32i);
    let _e87 = atomicAdd((&sums[(at + COUNT)]), 1u);
    let _e95 = carry(_e87, 1u);
    let _e96 = atomicAdd((&sums[((at + COUNT) + 1u)]), _e95);
    return;
}
