const ACTIVATION: u32 = 34u;

const COUNT: u32 = 26u;

const ERROR: u32 = 30u;

const GAIN: u32 = 32u;

const NONE: u32 = 4294967295u;

const SHARE: u32 = 28u;

const WORDS: u32 = 36u;

struct CellOutput {
    slope: array<f32, 13>,
    value: f32,
    width: f32,
    pad0_: f32,
}

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    linear: u32,
    rows: u32,
    pad0_: u32,
    pad1_: u32,
    pad2_: u32,
}

struct Sample {
    winner: u32,
    goal: f32,
    weight: f32,
    output: f32,
}

@group(0) @binding(0) 
var<uniform> params: Params;

@group(0) @binding(1) 
var<storage> inputs: array<vec4<f32>>;

@group(0) @binding(2) 
var<storage, read_write> samples: array<Sample>;

@group(0) @binding(3) 
var<storage> cells: array<vec4<f32>>;

@group(0) @binding(4) 
var<storage> outputs: array<CellOutput>;

@group(0) @binding(5) 
var<storage> graph: array<u32>;

@group(0) @binding(6) 
var<storage, read_write> sums: array<atomic<u32>>;

@group(0) @binding(7) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> least: f32 = 340282350000000000000000000000000000000f;

var<private> nearest: u32 = 0u;

var<private> unfinished: bool = false;

fn activation(input_1: u32, winner_1: u32, i_2: u32) -> f32 {
    let _e4 = nearest;
    if (i_2 == _e4) {
        return 1f;
    }
    let _e8 = least;
    let _e9 = answering(winner_1, i_2);
    let _e10 = exponent(input_1, _e9);
    return exp(min((_e8 - _e10), 0f));
}

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

fn answering(winner: u32, i_1: u32) -> u32 {
    if (i_1 == 0u) {
        return winner;
    }
    let _e7 = params.rows;
    let _e10 = graph[winner];
    let _e16 = graph[(((_e7 + _e10) + i_1) - 1u)];
    return _e16;
}

fn carry(old: u32, add: u32) -> u32 {
    return select(0u, 1u, ((old + add) < old));
}

fn encode(value: f32, power: i32) -> vec2<u32> {
    var lo: u32 = 0u;
    var hi: u32 = 0u;
    var local_4: bool;
    let bits = bitcast<u32>(value);
    let exponent_1 = i32(((bits >> 23u) & 255u));
    let mantissa = ((bits & 8388607u) | 8388608u);
    let shift = ((exponent_1 - 150i) + power);
    if !((exponent_1 == 0i)) {
        local_4 = (shift <= -24i);
    } else {
        local_4 = true;
    }
    let _e27 = local_4;
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

fn exponent(input: u32, cell: u32) -> f32 {
    var sum: f32 = 0f;
    var k_2: u32 = 0u;
    loop {
        let _e6 = k_2;
        if (_e6 < 13u) {
        } else {
            break;
        }
        {
            let _e12 = k_2;
            let _e17 = k_2;
            let _e21 = inputs[((4u * input) + (_e12 / 4u))][(_e17 % 4u)];
            let _e25 = k_2;
            let _e30 = k_2;
            let _e34 = cells[((4u * cell) + (_e25 / 4u))][(_e30 % 4u)];
            let e = (_e21 - _e34);
            let _e36 = sum;
            sum = (_e36 + (e * e));
        }
        continuing {
            let _e40 = k_2;
            k_2 = (_e40 + 1u);
        }
    }
    let width = outputs[cell].width;
    let _e46 = sum;
    return (_e46 / (width * width));
}

fn finish() {
    let _e1 = unfinished;
    if _e1 {
        let _e5 = params.flag;
        let _e8 = atomicMax((&status[_e5]), 1u);
        return;
    } else {
        return;
    }
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var i: u32 = 0u;
    var local: bool;
    var all_: f32 = 0f;
    var local_1: bool;
    var output: f32 = 0f;
    var k: u32 = 0u;
    var local_2: bool;
    var k_1: u32 = 0u;
    var local_3: bool;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let input_2 = (_e8 + gid.x);
    let winner_2 = samples[input_2].winner;
    if (winner_2 == NONE) {
        samples[input_2].output = 0f;
        return;
    }
    let _e26 = graph[(winner_2 + 1u)];
    let _e30 = graph[winner_2];
    let _e35 = params.linear;
    let count = select(((1u + _e26) - _e30), 1u, (_e35 == 1u));
    loop {
        let _e41 = i;
        if (_e41 < count) {
        } else {
            break;
        }
        {
            let _e43 = i;
            let _e44 = answering(winner_2, _e43);
            let _e45 = exponent(input_2, _e44);
            let _e47 = least;
            if (_e45 < _e47) {
                least = _e45;
                let _e51 = i;
                nearest = _e51;
            }
        }
        continuing {
            let _e53 = i;
            i = (_e53 + 1u);
        }
    }
    let _e57 = unfinished;
    if !(_e57) {
        let _e61 = i;
        local = (_e61 < count);
    } else {
        local = true;
    }
    let _e64 = local;
    unfinished = _e64;
    i = 0u;
    loop {
        let _e68 = i;
        if (_e68 < count) {
        } else {
            break;
        }
        {
            let _e70 = all_;
            let _e71 = i;
            let _e72 = activation(input_2, winner_2, _e71);
            all_ = (_e70 + _e72);
        }
        continuing {
            let _e75 = i;
            i = (_e75 + 1u);
        }
    }
    let _e79 = unfinished;
    if !(_e79) {
        let _e83 = i;
        local_1 = (_e83 < count);
    } else {
        local_1 = true;
    }
    let _e86 = local_1;
    unfinished = _e86;
    let _e91 = params.linear;
    if (_e91 == 1u) {
        let _e97 = outputs[winner_2].value;
        output = _e97;
        loop {
            let _e100 = k;
            if (_e100 < 13u) {
            } else {
                break;
            }
            {
                let _e106 = k;
                let _e111 = k;
                let _e115 = inputs[((4u * input_2) + (_e106 / 4u))][(_e111 % 4u)];
                let _e119 = k;
                let _e124 = k;
                let _e128 = cells[((4u * winner_2) + (_e119 / 4u))][(_e124 % 4u)];
                let e_1 = (_e115 - _e128);
                let _e130 = output;
                let _e134 = k;
                let _e136 = outputs[winner_2].slope[_e134];
                output = (_e130 + (_e136 * e_1));
            }
            continuing {
                let _e140 = k;
                k = (_e140 + 1u);
            }
        }
    } else {
        i = 0u;
        loop {
            let _e143 = i;
            if (_e143 < count) {
            } else {
                break;
            }
            {
                let _e145 = output;
                let _e146 = i;
                let _e147 = activation(input_2, winner_2, _e146);
                let _e148 = all_;
                let _e151 = i;
                let _e152 = answering(winner_2, _e151);
                let _e155 = outputs[_e152].value;
                output = (_e145 + ((_e147 / _e148) * _e155));
            }
            continuing {
                let _e159 = i;
                i = (_e159 + 1u);
            }
        }
        let _e163 = unfinished;
        if !(_e163) {
            let _e167 = i;
            local_2 = (_e167 < count);
        } else {
            local_2 = true;
        }
        let _e170 = local_2;
        unfinished = _e170;
    }
    let _e174 = output;
    samples[input_2].output = _e174;
    let _e178 = samples[input_2].goal;
    let _e179 = output;
    let error = (_e178 - _e179);
    let weight = samples[input_2].weight;
    let at = (WORDS * winner_2);
    loop {
        let _e189 = k_1;
        if (_e189 < 13u) {
        } else {
            break;
        }
        {
            let _e193 = k_1;
            let _e199 = k_1;
            let _e204 = k_1;
            let _e208 = inputs[((4u * input_2) + (_e199 / 4u))][(_e204 % 4u)];
            add_sum((at + (2u * _e193)), _e208, 32i);
        }
        continuing {
            let _e211 = k_1;
            k_1 = (_e211 + 1u);
        }
    }
    let _e218 = atomicAdd((&sums[(at + COUNT)]), 1u);
    let _e226 = carry(_e218, 1u);
    let _e227 = atomicAdd((&sums[((at + COUNT) + 1u)]), _e226);
    add_sum((at + SHARE), weight, 32i);
    add_sum((at + ERROR), (weight * (error * error)), 32i);
    i = 0u;
    loop {
        let _e237 = i;
        if (_e237 < count) {
        } else {
            break;
        }
        {
            let _e239 = i;
            let _e240 = answering(winner_2, _e239);
            let _e241 = i;
            let _e242 = activation(input_2, winner_2, _e241);
            let _e243 = all_;
            let share = (weight * (_e242 / _e243));
            add_sum(((WORDS * _e240) + GAIN), (share * error), 32i);
            add_sum(((WORDS * _e240) + ACTIVATION), share, 32i);
        }
        continuing {
            let _e258 = i;
            i = (_e258 + 1u);
        }
    }
    let _e262 = unfinished;
    if !(_e262) {
        let _e266 = i;
        local_3 = (_e266 < count);
    } else {
        local_3 = true;
    }
    let _e269 = local_3;
    unfinished = _e269;
    finish();
    return;
}
