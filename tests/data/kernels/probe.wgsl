const BACK: u32 = 3u;

const DEAD: u32 = 0u;

const F32_MAX: f32 = 340282350000000000000000000000000000000f;

const FRONT: u32 = 1u;

const NONE: u32 = 4294967295u;

const PROBES: u32 = 11u;

const SKY: u32 = 2u;

const SKY_PROBES: u32 = 4u;

const STACK: u32 = 48u;

const TWIN: u32 = 2147483648u;

struct BvhNode {
    min: vec3<f32>,
    count: u32,
    max: vec3<f32>,
    first: u32,
}

struct Hit {
    t: f32,
    tri: u32,
    b1_: f32,
    b2_: f32,
}

struct Met {
    kind: u32,
    hit: Hit,
}

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    seed: u32,
    first: u32,
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

struct Shear {
    kz: u32,
    sx: f32,
    sy: f32,
    sz: f32,
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
var<storage> bvh: array<BvhNode>;

@group(0) @binding(2) 
var<storage> tris: array<Tri>;

@group(0) @binding(3) 
var<storage> suspects: array<u32>;

@group(0) @binding(4) 
var<storage, read_write> points: array<Point>;

@group(0) @binding(5) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> unfinished: bool = false;

fn box_count(i_4: u32) -> u32 {
    let _e4 = bvh[i_4].count;
    return _e4;
}

fn box_first(i_5: u32) -> u32 {
    let _e4 = bvh[i_5].first;
    return _e4;
}

fn box_max(i_2: u32) -> vec3<f32> {
    let _e4 = bvh[i_2].max;
    return _e4;
}

fn box_min(i_1: u32) -> vec3<f32> {
    let _e4 = bvh[i_1].min;
    return _e4;
}

fn cos_sin_turn(u: f32) -> vec2<f32> {
    let quarter = floor(((4f * u) + 0.5f));
    let x_6 = ((u - (0.25f * quarter)) * 6.2831855f);
    let x2_ = (x_6 * x_6);
    let s_2 = (x_6 * (1f + (x2_ * (-0.16666667f + (x2_ * (0.008333334f + (x2_ * (-0.0001984127f + (x2_ * 0.0000027557319f)))))))));
    let c = (1f + (x2_ * (-0.5f + (x2_ * (0.041666668f + (x2_ * (-0.0013888889f + (x2_ * 0.000024801588f))))))));
    let q_1 = (u32(quarter) & 3u);
    if (q_1 == 0u) {
        return vec2<f32>(c, s_2);
    }
    if (q_1 == 1u) {
        return vec2<f32>(-(s_2), c);
    }
    if (q_1 == 2u) {
        return vec2<f32>(-(c), -(s_2));
    }
    return vec2<f32>(s_2, -(c));
}

fn cosine_direction(n_1: vec3<f32>, u_1: f32, v_3: f32) -> vec3<f32> {
    let _e3 = tangents(n_1);
    let _e4 = cos_sin_turn(v_3);
    let r = sqrt(u_1);
    let z = sqrt(max((1f - u_1), 0f));
    return (((_e3.t1_ * (r * _e4.x)) + (_e3.t2_ * (r * _e4.y))) + (n_1 * z));
}

fn dot3_(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return (((a.x * b.x) + (a.y * b.y)) + (a.z * b.z));
}

fn edge(a_1: vec2<f32>, b_1: vec2<f32>) -> f32 {
    var local_4: bool;
    var local_5: bool;
    if !((a_1.x < b_1.x)) {
        if (a_1.x == b_1.x) {
            local_5 = (a_1.y < b_1.y);
        } else {
            local_5 = false;
        }
        let _e17 = local_5;
        local_4 = _e17;
    } else {
        local_4 = true;
    }
    let ordered = local_4;
    let p_2 = select(b_1, a_1, ordered);
    let q = select(a_1, b_1, ordered);
    let area = ((p_2.x * q.y) - (p_2.y * q.x));
    return select(-(area), area, ordered);
}

fn enter(i_3: u32, origin: vec3<f32>, inv: vec3<f32>, t_max: f32) -> f32 {
    var local_3: bool;
    let _e4 = box_min(i_3);
    let t0_ = ((_e4 - origin) * inv);
    let _e7 = box_max(i_3);
    let t1_ = ((_e7 - origin) * inv);
    let low = min(t0_, t1_);
    let high = max(t0_, t1_);
    let near = max(max(max(low.x, low.y), low.z), 0f);
    let far = (min(min(high.x, high.y), high.z) * 1.0000005f);
    if ((near * 0.9999995f) <= far) {
        local_3 = ((near * 0.9999995f) < t_max);
    } else {
        local_3 = false;
    }
    let _e36 = local_3;
    return select(F32_MAX, near, _e36);
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

fn first_hit(tri: u32, p: vec3<f32>, direction_2: vec3<f32>) -> Met {
    let _e4 = tri_plane(tri);
    let _e8 = tri_normal(tri);
    let _e9 = walk(p, direction_2, F32_MAX, vec2<u32>(_e4, NONE), false, _e8);
    if (_e9.tri == NONE) {
        return Met(SKY, _e9);
    }
    let _e16 = tri_normal(_e9.tri);
    let _e17 = dot3_(_e16, direction_2);
    if (_e17 < 0f) {
        return Met(FRONT, _e9);
    }
    return Met(BACK, _e9);
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

fn is_dead(tri_1: u32, p_1: vec3<f32>, seed_3: u32, first: u32) -> bool {
    var back: u32;
    var k: u32 = 0u;
    var local_23: bool;
    var local_24: bool;
    let _e4 = tri_normal(tri_1);
    back = select(0u, 1u, (first == BACK));
    loop {
        let _e13 = k;
        if (_e13 < PROBES) {
        } else {
            break;
        }
        {
            let _e16 = k;
            let _e17 = sobol4_(_e16, seed_3);
            let _e19 = unit(_e17.z);
            let _e21 = unit(_e17.w);
            let _e22 = cosine_direction(_e4, _e19, _e21);
            let _e23 = first_hit(tri_1, p_1, _e22);
            if (_e23.kind == FRONT) {
                return false;
            }
            let _e28 = back;
            back = (_e28 + select(0u, 1u, (_e23.kind == BACK)));
            let _e36 = back;
            if (_e36 == 0u) {
                let _e41 = k;
                local_23 = ((_e41 + 1u) == SKY_PROBES);
            } else {
                local_23 = false;
            }
            let _e47 = local_23;
            if _e47 {
                return false;
            }
        }
        continuing {
            let _e50 = k;
            k = (_e50 + 1u);
        }
    }
    let _e54 = unfinished;
    if !(_e54) {
        let _e58 = k;
        local_24 = (_e58 < PROBES);
    } else {
        local_24 = true;
    }
    let _e62 = local_24;
    unfinished = _e62;
    let _e64 = back;
    return ((4u * _e64) >= 12u);
}

fn laine_karras(v_1: u32, seed: u32) -> u32 {
    var x_1: u32;
    x_1 = (v_1 + seed);
    let _e4 = x_1;
    let _e5 = x_1;
    x_1 = (_e4 ^ (_e5 * 1817228412u));
    let _e9 = x_1;
    let _e10 = x_1;
    x_1 = (_e9 ^ (_e10 * 3090095698u));
    let _e14 = x_1;
    let _e15 = x_1;
    x_1 = (_e14 ^ (_e15 * 3350193720u));
    let _e19 = x_1;
    let _e20 = x_1;
    return (_e19 ^ (_e20 * 2367878886u));
}

fn lies_on(i_11: u32, origin_2: vec3<f32>, base: vec3<f32>) -> bool {
    var local_13: bool;
    let _e3 = tri_normal(i_11);
    let _e4 = dot3_(_e3, base);
    if (_e4 < -0.99999f) {
        let _e9 = tri_normal(i_11);
        let _e10 = tri_v0_(i_11);
        let _e12 = dot3_(_e9, (_e10 - origin_2));
        local_13 = (abs(_e12) < 0.000001f);
    } else {
        local_13 = false;
    }
    let _e17 = local_13;
    return _e17;
}

fn meet_triangle(i_10: u32, origin_1: vec3<f32>, s: Shear, t_max_1: f32) -> Hit {
    var local_6: bool;
    var local_7: bool;
    var local_8: bool;
    var local_9: bool;
    var local_10: bool;
    var local_11: bool;
    var local_12: bool;
    let _e4 = tri_v0_(i_10);
    let _e7 = turned((_e4 - origin_1), s.kz);
    let _e8 = tri_v1_(i_10);
    let _e11 = turned((_e8 - origin_1), s.kz);
    let _e12 = tri_v2_(i_10);
    let _e15 = turned((_e12 - origin_1), s.kz);
    let pa = vec2<f32>((_e7.x - (s.sx * _e7.z)), (_e7.y - (s.sy * _e7.z)));
    let pb = vec2<f32>((_e11.x - (s.sx * _e11.z)), (_e11.y - (s.sy * _e11.z)));
    let pc = vec2<f32>((_e15.x - (s.sx * _e15.z)), (_e15.y - (s.sy * _e15.z)));
    let _e49 = edge(pc, pb);
    let _e50 = edge(pa, pc);
    let _e51 = edge(pb, pa);
    if !((_e49 < 0f)) {
        local_6 = (_e50 < 0f);
    } else {
        local_6 = true;
    }
    let _e60 = local_6;
    if !(_e60) {
        local_7 = (_e51 < 0f);
    } else {
        local_7 = true;
    }
    let _e67 = local_7;
    if _e67 {
        if !((_e49 > 0f)) {
            local_9 = (_e50 > 0f);
        } else {
            local_9 = true;
        }
        let _e78 = local_9;
        if !(_e78) {
            local_10 = (_e51 > 0f);
        } else {
            local_10 = true;
        }
        let _e85 = local_10;
        local_8 = _e85;
    } else {
        local_8 = false;
    }
    let outside = local_8;
    let det = ((_e49 + _e50) + _e51);
    if !(outside) {
        local_11 = (det == 0f);
    } else {
        local_11 = true;
    }
    let _e96 = local_11;
    if _e96 {
        return Hit(t_max_1, NONE, 0f, 0f);
    }
    let t = ((((_e49 * (s.sz * _e7.z)) + (_e50 * (s.sz * _e11.z))) + (_e51 * (s.sz * _e15.z))) / det);
    if (t > 0f) {
        local_12 = (t < t_max_1);
    } else {
        local_12 = false;
    }
    let _e122 = local_12;
    if _e122 {
        return Hit(t, i_10, (_e50 / det), (_e51 / det));
    }
    return Hit(t_max_1, NONE, 0f, 0f);
}

fn nonzero(x_4: f32) -> f32 {
    return select(x_4, select(0.00000000000000000001f, -0.00000000000000000001f, (x_4 < 0f)), (abs(x_4) < 0.00000000000000000001f));
}

fn scramble(x_2: u32, seed_1: u32) -> u32 {
    let _e3 = laine_karras(reverseBits(x_2), seed_1);
    return reverseBits(_e3);
}

fn seed_of(seed_4: u32, i_13: u32) -> u32 {
    let _e4 = hash((i_13 + 2654435769u));
    let _e6 = hash((seed_4 ^ _e4));
    return _e6;
}

fn shear(direction: vec3<f32>) -> Shear {
    var kz_1: u32 = 2u;
    var local_2: bool;
    let a_2 = abs(direction);
    if (a_2.x > a_2.y) {
        local_2 = (a_2.x > a_2.z);
    } else {
        local_2 = false;
    }
    let _e13 = local_2;
    if _e13 {
        kz_1 = 0u;
    } else {
        if (a_2.y > a_2.z) {
            kz_1 = 1u;
        }
    }
    let _e19 = kz_1;
    let _e20 = turned(direction, _e19);
    let _e21 = kz_1;
    return Shear(_e21, (_e20.x / _e20.z), (_e20.y / _e20.z), (1f / _e20.z));
}

fn sobol4_(index: u32, seed_2: u32) -> vec4<u32> {
    var x_3: vec4<u32>;
    var d1_: u32 = 2147483648u;
    var d2a: u32 = 2147483648u;
    var d2b: u32 = 3221225472u;
    var d3a: u32 = 2147483648u;
    var d3b: u32 = 3221225472u;
    var d3c: u32 = 536870912u;
    var bits: u32;
    var local_1: bool;
    x_3 = vec4<u32>(reverseBits(index), 0u, 0u, 0u);
    bits = index;
    loop {
        let _e21 = bits;
        if (_e21 != 0u) {
        } else {
            break;
        }
        {
            let _e25 = bits;
            let mask = (0u - (_e25 & 1u));
            let _e30 = x_3.y;
            let _e31 = d1_;
            x_3.y = (_e30 ^ (_e31 & mask));
            let _e35 = x_3.z;
            let _e36 = d2a;
            x_3.z = (_e35 ^ (_e36 & mask));
            let _e40 = x_3.w;
            let _e41 = d3a;
            x_3.w = (_e40 ^ (_e41 & mask));
            let _e44 = bits;
            bits = (_e44 >> 1u);
            let _e47 = d1_;
            let _e48 = d1_;
            d1_ = (_e47 ^ (_e48 >> 1u));
            let _e52 = d2b;
            let _e53 = d2a;
            let _e55 = d2a;
            let d2c = ((_e52 ^ _e53) ^ (_e55 >> 2u));
            let _e59 = d2b;
            d2a = _e59;
            d2b = d2c;
            let _e60 = d3b;
            let _e61 = d3a;
            let _e63 = d3a;
            let d3d = ((_e60 ^ _e61) ^ (_e63 >> 3u));
            let _e67 = d3b;
            d3a = _e67;
            let _e68 = d3c;
            d3b = _e68;
            d3c = d3d;
        }
    }
    let _e71 = unfinished;
    if !(_e71) {
        let _e75 = bits;
        local_1 = (_e75 != 0u);
    } else {
        local_1 = true;
    }
    let _e79 = local_1;
    unfinished = _e79;
    let _e80 = hash(seed_2);
    let _e82 = x_3.x;
    let _e83 = scramble(_e82, _e80);
    let _e85 = x_3.y;
    let _e88 = hash((_e80 ^ 1u));
    let _e89 = scramble(_e85, _e88);
    let _e91 = x_3.z;
    let _e94 = hash((_e80 ^ 2u));
    let _e95 = scramble(_e91, _e94);
    let _e97 = x_3.w;
    let _e100 = hash((_e80 ^ 3u));
    let _e101 = scramble(_e97, _e100);
    return vec4<u32>(_e83, _e89, _e95, _e101);
}

fn tangents(n: vec3<f32>) -> Tangents {
    let s_1 = select(-1f, 1f, (n.z >= 0f));
    let a_3 = (-1f / (s_1 + n.z));
    let b_2 = ((n.x * n.y) * a_3);
    return Tangents(vec3<f32>((1f + (((s_1 * n.x) * n.x) * a_3)), (s_1 * b_2), (-(s_1) * n.x)), vec3<f32>(b_2, (s_1 + ((n.y * n.y) * a_3)), -(n.y)));
}

fn tri_normal(i: u32) -> vec3<f32> {
    let _e4 = tris[i].normal;
    return _e4;
}

fn tri_plane(i_6: u32) -> u32 {
    let _e4 = tris[i_6].plane;
    return _e4;
}

fn tri_v0_(i_7: u32) -> vec3<f32> {
    let _e4 = tris[i_7].v0_;
    return _e4;
}

fn tri_v1_(i_8: u32) -> vec3<f32> {
    let _e4 = tris[i_8].v1_;
    return _e4;
}

fn tri_v2_(i_9: u32) -> vec3<f32> {
    let _e4 = tris[i_9].v2_;
    return _e4;
}

fn turned(v_2: vec3<f32>, kz: u32) -> vec3<f32> {
    return select(select(v_2.xyz, v_2.zxy, (kz == 1u)), v_2.yzx, (kz == 0u));
}

fn unit(x_5: u32) -> f32 {
    return (f32((x_5 >> 8u)) * 0.000000059604645f);
}

fn walk(origin_3: vec3<f32>, direction_1: vec3<f32>, t_max_2: f32, skip: vec2<u32>, any_hit: bool, base_1: vec3<f32>) -> Hit {
    var hit: Hit;
    var stack: array<u32, 48>;
    var top: u32 = 0u;
    var at: u32 = 0u;
    var open: bool;
    var pop: bool;
    var i_12: u32;
    var local_14: bool;
    var local_15: bool;
    var met: Hit;
    var local_16: bool;
    var local_17: bool;
    var local_18: bool;
    var local_19: bool;
    var local_20: bool;
    var local_21: bool;
    var local_22: bool;
    let _e6 = shear(direction_1);
    let _e8 = nonzero(direction_1.x);
    let _e12 = nonzero(direction_1.y);
    let _e16 = nonzero(direction_1.z);
    let inv_1 = vec3<f32>((1f / _e8), (1f / _e12), (1f / _e16));
    hit = Hit(t_max_2, NONE, 0f, 0f);
    let _e32 = hit.t;
    let _e33 = enter(0u, origin_3, inv_1, _e32);
    open = (_e33 < F32_MAX);
    loop {
        let _e37 = open;
        if _e37 {
        } else {
            break;
        }
        {
            let _e38 = at;
            let _e39 = box_count(_e38);
            let _e40 = at;
            let _e41 = box_first(_e40);
            pop = true;
            if (_e39 > 0u) {
                i_12 = _e41;
                loop {
                    let _e47 = i_12;
                    if (_e47 < (_e41 + _e39)) {
                    } else {
                        break;
                    }
                    {
                        let _e50 = i_12;
                        let _e51 = tri_plane(_e50);
                        if !((_e51 == skip.x)) {
                            local_14 = (_e51 == skip.y);
                        } else {
                            local_14 = true;
                        }
                        let _e60 = local_14;
                        if _e60 {
                            continue;
                        }
                        if ((_e51 & TWIN) != 0u) {
                            let _e67 = i_12;
                            let _e68 = tri_normal(_e67);
                            let _e69 = dot3_(_e68, direction_1);
                            local_15 = (_e69 >= 0f);
                        } else {
                            local_15 = false;
                        }
                        let _e73 = local_15;
                        if _e73 {
                            continue;
                        }
                        met = Hit();
                        let _e76 = i_12;
                        let _e78 = hit.t;
                        let _e79 = meet_triangle(_e76, origin_3, _e6, _e78);
                        met = _e79;
                        let _e81 = met.tri;
                        if (_e81 != NONE) {
                            let _e84 = i_12;
                            let _e85 = tri_normal(_e84);
                            let _e86 = dot3_(_e85, direction_1);
                            if (_e86 < 0f) {
                                let _e92 = met.t;
                                local_16 = ((_e92 * -(_e86)) < 0.000001f);
                            } else {
                                local_16 = false;
                            }
                            let _e98 = local_16;
                            if _e98 {
                                let _e101 = i_12;
                                let _e102 = lies_on(_e101, origin_3, base_1);
                                local_17 = _e102;
                            } else {
                                local_17 = false;
                            }
                            let _e104 = local_17;
                            if _e104 {
                                continue;
                            }
                            let _e106 = met.t;
                            let _e111 = met.t;
                            let behind = select(((t_max_2 - _e106) * -(_e86)), (_e111 * _e86), (_e86 > 0f));
                            if (behind < 0.0000004f) {
                                if !((_e86 > 0f)) {
                                    local_19 = any_hit;
                                } else {
                                    local_19 = true;
                                }
                                let _e126 = local_19;
                                local_18 = _e126;
                            } else {
                                local_18 = false;
                            }
                            let _e128 = local_18;
                            if _e128 {
                                continue;
                            }
                            let _e129 = met;
                            hit = _e129;
                            if any_hit {
                                let _e130 = hit;
                                return _e130;
                            }
                        }
                    }
                    continuing {
                        let _e132 = i_12;
                        i_12 = (_e132 + 1u);
                    }
                }
                let _e136 = unfinished;
                if !(_e136) {
                    let _e140 = i_12;
                    local_20 = (_e140 < (_e41 + _e39));
                } else {
                    local_20 = true;
                }
                let _e144 = local_20;
                unfinished = _e144;
            } else {
                let _e146 = hit.t;
                let _e147 = enter(_e41, origin_3, inv_1, _e146);
                let _e151 = hit.t;
                let _e152 = enter((_e41 + 1u), origin_3, inv_1, _e151);
                let swap = (_e147 > _e152);
                let far_1 = max(_e147, _e152);
                if (min(_e147, _e152) < F32_MAX) {
                    if (far_1 < F32_MAX) {
                        let _e162 = unfinished;
                        if !(_e162) {
                            let _e166 = top;
                            local_21 = (_e166 >= STACK);
                        } else {
                            local_21 = true;
                        }
                        let _e170 = local_21;
                        unfinished = _e170;
                        let _e171 = top;
                        stack[min(_e171, 47u)] = select((_e41 + 1u), _e41, swap);
                        let _e179 = top;
                        top = (_e179 + 1u);
                    }
                    at = select(_e41, (_e41 + 1u), swap);
                    pop = false;
                }
            }
            let _e185 = pop;
            if _e185 {
                let _e186 = top;
                if (_e186 == 0u) {
                    open = false;
                } else {
                    let _e191 = top;
                    top = (_e191 - 1u);
                    let _e193 = top;
                    let _e197 = stack[min(_e193, 47u)];
                    at = _e197;
                }
            }
        }
    }
    let _e200 = unfinished;
    if !(_e200) {
        let _e204 = open;
        local_22 = _e204;
    } else {
        local_22 = true;
    }
    let _e206 = local_22;
    unfinished = _e206;
    let _e207 = hit;
    return _e207;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var local: bool;
    let _e3 = params.base;
    let i_14 = (_e3 + gid.x);
    let _e9 = params.count;
    if !((gid.x >= _e9)) {
        let _e16 = suspects[0];
        local = (i_14 >= _e16);
    } else {
        local = true;
    }
    let _e19 = local;
    if _e19 {
        return;
    }
    let item = suspects[(1u + i_14)];
    let s_3 = (2u * item);
    let _e30 = points[s_3].tri;
    let _e34 = points[s_3].p;
    let _e37 = params.seed;
    let _e40 = params.first;
    let _e42 = seed_of(_e37, (_e40 + item));
    let _e46 = points[s_3].kind;
    let _e47 = is_dead(_e30, _e34, _e42, _e46);
    if _e47 {
        points[s_3].kind = DEAD;
        points[s_3].weight = 0f;
        points[(s_3 + 1u)].kind = DEAD;
    }
    finish();
    return;
}
