const FRONT: u32 = 1u;

const NODE_WORDS: u32 = 16u;

const NONE: u32 = 4294967295u;

const SLOT_WORDS: u32 = 8u;

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
    flag: u32,
    first: u32,
    end: u32,
    slots: u32,
    masses: u32,
    normalise: f32,
    rays: f32,
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
var<storage> points: array<Point>;

@group(0) @binding(2) 
var<storage> psi: array<Psi>;

@group(0) @binding(3) 
var<storage> winners: array<u32>;

@group(0) @binding(4) 
var<storage> nodes: array<Node>;

@group(0) @binding(5) 
var<storage, read_write> rows: array<atomic<u32>>;

@group(0) @binding(6) 
var<storage, read_write> sums: array<atomic<u32>>;

@group(0) @binding(7) 
var<storage, read_write> overflow: array<atomic<u32>>;

@group(0) @binding(8) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> unfinished: bool = false;

fn add_1(row: u32, node_1: u32, value_2: f32, first: f32, second: f32) {
    var probe: u32;
    var at: u32 = 0u;
    var found: bool = false;
    var k_2: u32 = 0u;
    var local_3: bool;
    var held: u32;
    var local_4: bool;
    let key = (node_1 + 1u);
    let _e7 = hash(node_1);
    let _e10 = params.slots;
    probe = (_e7 & (_e10 - 1u));
    loop {
        let _e21 = k_2;
        let _e25 = params.slots;
        if (_e21 < (2u * _e25)) {
            let _e30 = found;
            local_3 = !(_e30);
        } else {
            local_3 = false;
        }
        let _e33 = local_3;
        if _e33 {
        } else {
            break;
        }
        {
            let _e37 = params.slots;
            let _e39 = probe;
            at = (SLOT_WORDS * ((row * _e37) + _e39));
            let _e43 = at;
            let _e45 = atomicLoad((&rows[_e43]));
            held = _e45;
            let _e47 = held;
            if (_e47 == 0u) {
                let _e51 = at;
                let _e54 = atomicCompareExchangeWeak((&rows[_e51]), 0u, key);
                held = select(_e54.old_value, key, _e54.exchanged);
            }
            let _e58 = held;
            found = (_e58 == key);
            let _e60 = held;
            if (_e60 != 0u) {
                let _e65 = found;
                local_4 = !(_e65);
            } else {
                local_4 = false;
            }
            let _e68 = local_4;
            if _e68 {
                let _e69 = probe;
                let _e74 = params.slots;
                probe = ((_e69 + 1u) & (_e74 - 1u));
            }
        }
        continuing {
            let _e79 = k_2;
            k_2 = (_e79 + 1u);
        }
    }
    let _e81 = found;
    if !(_e81) {
        let _e86 = atomicMax((&overflow[0]), 1u);
        return;
    }
    let _e87 = at;
    add_row((_e87 + 2u), value_2);
    let _e90 = at;
    add_row((_e90 + 4u), first);
    let _e93 = at;
    add_row((_e93 + 6u), second);
    return;
}

fn add_row(word: u32, value_1: f32) {
    let _e3 = encode(value_1, 58i);
    let _e7 = atomicAdd((&rows[word]), _e3.x);
    let _e10 = carry(_e7, _e3.x);
    let hi_1 = (_e3.y + _e10);
    if (hi_1 != 0u) {
        let _e18 = atomicAdd((&rows[(word + 1u)]), hi_1);
        return;
    } else {
        return;
    }
}

fn add_sum(word_1: u32, value_3: f32, power_1: i32) {
    let _e3 = encode(value_3, power_1);
    let _e7 = atomicAdd((&sums[word_1]), _e3.x);
    let _e10 = carry(_e7, _e3.x);
    let hi_2 = (_e3.y + _e10);
    if (hi_2 != 0u) {
        let _e18 = atomicAdd((&sums[(word_1 + 1u)]), hi_2);
        return;
    } else {
        return;
    }
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

fn hash(v: u32) -> u32 {
    var x: u32;
    x = v;
    let _e2 = x;
    let _e3 = x;
    x = (_e2 ^ (_e3 >> 16u));
    let _e7 = x;
    x = (_e7 * 2146121005u);
    let _e10 = x;
    let _e11 = x;
    x = (_e10 ^ (_e11 >> 15u));
    let _e15 = x;
    x = (_e15 * 2221713035u);
    let _e18 = x;
    let _e19 = x;
    return (_e18 ^ (_e19 >> 16u));
}

fn offsets(node: u32, p: vec3<f32>) -> vec2<f32> {
    let _e5 = nodes[node].n;
    let _e6 = tangents(_e5);
    let _e10 = nodes[node].p;
    let d = (p - _e10);
    let _e13 = dot3_(d, _e6.t1_);
    let _e15 = dot3_(d, _e6.t2_);
    return vec2<f32>(_e13, _e15);
}

fn tangents(n: vec3<f32>) -> Tangents {
    let s = select(-1f, 1f, (n.z >= 0f));
    let a_1 = (-1f / (s + n.z));
    let b_1 = ((n.x * n.y) * a_1);
    return Tangents(vec3<f32>((1f + (((s * n.x) * n.x) * a_1)), (s * b_1), (-(s) * n.x)), vec3<f32>(b_1, (s + ((n.y * n.y) * a_1)), -(n.y)));
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var local: bool;
    var local_1: bool;
    var k: u32 = 0u;
    var k_1: u32 = 0u;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let d_1 = (_e8 + gid.x);
    let _e14 = points[d_1].weight;
    let _e17 = params.normalise;
    let w = (_e14 * _e17);
    if (w <= 0f) {
        return;
    }
    let cell = winners[d_1];
    let _e27 = points[d_1].kind;
    if (_e27 == FRONT) {
        let _e34 = params.first;
        local = (cell >= _e34);
    } else {
        local = false;
    }
    let _e37 = local;
    if _e37 {
        let _e42 = params.end;
        local_1 = (cell < _e42);
    } else {
        local_1 = false;
    }
    let counts = local_1;
    let _e49 = params.first;
    let row_1 = (2u * (cell - _e49));
    let here = psi[d_1];
    loop {
        let _e57 = k;
        if (_e57 < 4u) {
        } else {
            break;
        }
        {
            let _e61 = k;
            if (here.weight[_e61] > 0f) {
                let _e66 = k;
                let node_2 = here.node[_e66];
                let _e71 = points[d_1].p;
                let _e72 = offsets(node_2, _e71);
                let _e74 = k;
                let v_1 = (w * here.weight[_e74]);
                let _e79 = params.masses;
                if (_e79 == 1u) {
                    let at_1 = (NODE_WORDS * node_2);
                    add_sum(at_1, v_1, 58i);
                    add_sum((at_1 + 2u), (v_1 * _e72.x), 58i);
                    add_sum((at_1 + 4u), (v_1 * _e72.y), 58i);
                    add_sum((at_1 + 6u), ((v_1 * _e72.x) * _e72.x), 58i);
                    add_sum((at_1 + 8u), ((v_1 * _e72.x) * _e72.y), 58i);
                    add_sum((at_1 + 10u), ((v_1 * _e72.y) * _e72.y), 58i);
                    let _e120 = params.rays;
                    add_sum((at_1 + 12u), ((v_1 * _e120) * v_1), 58i);
                }
                if counts {
                    add_1((row_1 + 1u), node_2, v_1, (v_1 * _e72.x), (v_1 * _e72.y));
                }
            }
        }
        continuing {
            let _e131 = k;
            k = (_e131 + 1u);
        }
    }
    if counts {
        let there = psi[(d_1 ^ 1u)];
        if (there.weight.x == 0f) {
            if (there.node.x != NONE) {
                add_1(row_1, there.node.x, w, 0f, 0f);
            }
        } else {
            loop {
                let _e152 = k_1;
                if (_e152 < 4u) {
                } else {
                    break;
                }
                {
                    let _e156 = k_1;
                    if (there.weight[_e156] > 0f) {
                        let _e161 = k_1;
                        let node_3 = there.node[_e161];
                        let _e168 = points[(d_1 ^ 1u)].p;
                        let _e169 = offsets(node_3, _e168);
                        let _e171 = k_1;
                        let v_2 = (w * there.weight[_e171]);
                        add_1(row_1, node_3, v_2, (v_2 * _e169.x), (v_2 * _e169.y));
                    }
                }
                continuing {
                    let _e179 = k_1;
                    k_1 = (_e179 + 1u);
                }
            }
        }
    }
    finish();
    return;
}
