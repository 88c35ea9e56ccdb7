const ACTIVATION: u32 = 34u;

const COUNT: u32 = 26u;

const ERROR: u32 = 30u;

const F32_MAX: f32 = 340282350000000000000000000000000000000f;

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

var<private> unfinished: bool = false;

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
    var least: f32 = F32_MAX;
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
    let input_1 = (_e8 + gid.x);
    let winner_1 = samples[input_1].winner;
    if (winner_1 == NONE) {
        samples[input_1].output = 0f;
        return;
    }
    let _e26 = graph[(winner_1 + 1u)];
    let _e30 = graph[winner_1];
    let _e35 = params.linear;
    let count = select(((1u + _e26) - _e30), 1u, (_e35 == 1u));
    loop {
        let _e43 = i;
        if (_e43 < count) {
        } else {
            break;
        }
        {
            let _e45 = least;
            let _e46 = i;
            let _e47 = answering(winner_1, _e46);
            let _e48 = exponent(input_1, _e47);
            least = min(_e45, _e48);
        }
        continuing {
            let _e51 = i;
            i = (_e51 + 1u);
        }
    }
    let _e55 = unfinished;
    if !(_e55) {
        let _e59 = i;
        local = (_e59 < count);
    } else {
        local = true;
    }
    let _e62 = local;
    unfinished = _e62;
    i = 0u;
    loop {
        let _e66 = i;
        if (_e66 < count) {
        } else {
            break;
        }
        {
            let _e68 = all_;
            let _e69 = least;
            let _e70 = i;
            let _e71 = answering(winner_1, _e70);
            let _e72 = exponent(input_1, _e71);
            all_ = (_e68 + exp((_e69 - _e72)));
        }
        continuing {
            let _e77 = i;
            i = (_e77 + 1u);
        }
    }
    let _e81 = unfinished;
    if !(_e81) {
        let _e85 = i;
        local_1 = (_e85 < count);
    } else {
        local_1 = true;
    }
    let _e88 = local_1;
    unfinished = _e88;
    let _e93 = params.linear;
    if (_e93 == 1u) {
        let _e99 = outputs[winner_1].value;
        output = _e99;
        loop {
            let _e102 = k;
            if (_e102 < 13u) {
            } else {
                break;
            }
            {
                let _e108 = k;
                let _e113 = k;
                let _e117 = inputs[((4u * input_1) + (_e108 / 4u))][(_e113 % 4u)];
                let _e121 = k;
                let _e126 = k;
                let _e130 = cells[((4u * winner_1) + (_e121 / 4u))][(_e126 % 4u)];
                let e_1 = (_e117 - _e130);
                let _e132 = output;
                let _e136 = k;
                let _e138 = outputs[winner_1].slope[_e136];
                output = (_e132 + (_e138 * e_1));
            }
            continuing {
                let _e142 = k;
                k = (_e142 + 1u);
            }
        }
    } else {
        i = 0u;
        loop {
            let _e145 = i;
            if (_e145 < count) {
            } else {
                break;
            }
            {
                let _e147 = i;
                let _e148 = answering(winner_1, _e147);
                let _e149 = output;
                let _e150 = least;
                let _e151 = exponent(input_1, _e148);
                let _e154 = all_;
                let _e159 = outputs[_e148].value;
                output = (_e149 + ((exp((_e150 - _e151)) / _e154) * _e159));
            }
            continuing {
                let _e163 = i;
                i = (_e163 + 1u);
            }
        }
        let _e167 = unfinished;
        if !(_e167) {
            let _e171 = i;
            local_2 = (_e171 < count);
        } else {
            local_2 = true;
        }
        let _e174 = local_2;
        unfinished = _e174;
    }
    let _e178 = output;
    samples[input_1].output = _e178;
    let _e182 = samples[input_1].goal;
    let _e183 = output;
    let error = (_e182 - _e183);
    let weight = samples[input_1].weight;
    let at = (WORDS * winner_1);
    loop {
        let _e193 = k_1;
        if (_e193 < 13u) {
        } else {
            break;
        }
        {
            let _e197 = k_1;
            let _e203 = k_1;
            let _e208 = k_1;
            let _e212 = inputs[((4u * input_1) + (_e203 / 4u))][(_e208 % 4u)];
            add_sum((at + (2u * _e197)), _e212, 32i);
        }
        continuing {
            let _e215 = k_1;
            k_1 = (_e215 + 1u);
        }
    }
    let _e222 = atomicAdd((&sums[(at + COUNT)]), 1u);
    let _e230 = carry(_e222, 1u);
    let _e231 = atomicAdd((&sums[((at + COUNT) + 1u)]), _e230);
    add_sum((at + SHARE), weight, 32i);
    add_sum((at + ERROR), (weight * (error * error)), 32i);
    i = 0u;
    loop {
        let _e241 = i;
        if (_e241 < count) {
        } else {
            break;
        }
        {
            let _e243 = i;
            let _e244 = answering(winner_1, _e243);
            let _e245 = least;
            let _e246 = exponent(input_1, _e244);
            let _e249 = all_;
            let activation = (weight * (exp((_e245 - _e246)) / _e249));
            add_sum(((WORDS * _e244) + GAIN), (activation * error), 32i);
            add_sum(((WORDS * _e244) + ACTIVATION), activation, 32i);
        }
        continuing {
            let _e264 = i;
            i = (_e264 + 1u);
        }
    }
    let _e268 = unfinished;
    if !(_e268) {
        let _e272 = i;
        local_3 = (_e272 < count);
    } else {
        local_3 = true;
    }
    let _e275 = local_3;
    unfinished = _e275;
    finish();
    return;
}
