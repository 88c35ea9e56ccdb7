const F32_MAX: f32 = 340282350000000000000000000000000000000f;

const NEAREST: u32 = 9u;

const NONE: u32 = 4294967295u;

const STACK: u32 = 48u;

const TWIN: u32 = 2147483648u;

struct Between {
    behind: vec2<f32>,
    turn: f32,
    cosine: f32,
    lift: f32,
}

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

struct Look {
    origin: vec3<f32>,
    direction: vec3<f32>,
    t_max: f32,
    skip: vec2<u32>,
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
    flag: u32,
    inv_unit: f32,
    lambda: f32,
    first_list: u32,
    joint: u32,
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

struct Shear {
    kz: u32,
    sx: f32,
    sy: f32,
    sz: f32,
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
var<storage> nodes: array<Node>;

@group(0) @binding(4) 
var<storage> lists: array<u32>;

@group(0) @binding(5) 
var<storage> points: array<Point>;

@group(0) @binding(6) 
var<storage> order: array<u32>;

@group(0) @binding(7) 
var<storage, read_write> psi: array<Psi>;

@group(0) @binding(8) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> found: u32;

var<private> found_d: array<f32, 5>;

var<private> found_n: array<u32, 5>;

var<private> orphan: u32 = 4294967295u;

var<private> unfinished: bool = false;

fn between(p_1: vec3<f32>, n_1: vec3<f32>, node_1: u32) -> Between {
    let _e6 = nodes[node_1].p;
    let d_1 = (p_1 - _e6);
    let m_1 = nodes[node_1].n;
    let _e14 = dot3_((n_1 - m_1), (n_1 - m_1));
    let _e15 = dot3_(d_1, d_1);
    let turn = (sqrt((_e14 * _e15)) + 0.000002f);
    let _e20 = dot3_(d_1, n_1);
    let _e21 = dot3_(d_1, m_1);
    let behind = vec2<f32>(_e20, -(_e21));
    let _e24 = dot3_(n_1, m_1);
    let over = select(vec2<f32>(), behind, (behind <= vec2(turn)));
    let _e29 = dot3_(d_1, d_1);
    let lift = max(max((0.1f * sqrt(_e29)), 0.000002f), (max(over.x, over.y) / _e24));
    return Between(behind, turn, _e24, lift);
}

fn box_count(i_5: u32) -> u32 {
    let _e4 = bvh[i_5].count;
    return _e4;
}

fn box_first(i_6: u32) -> u32 {
    let _e4 = bvh[i_6].first;
    return _e4;
}

fn box_max(i_3: u32) -> vec3<f32> {
    let _e4 = bvh[i_3].max;
    return _e4;
}

fn box_min(i_2: u32) -> vec3<f32> {
    let _e4 = bvh[i_2].min;
    return _e4;
}

fn candidate_free(c_1: u32) -> bool {
    let _e4 = params.first_list;
    let _e11 = lists[((_e4 + (2u * c_1)) + 1u)];
    return (_e11 == 1u);
}

fn candidate_node(c: u32) -> u32 {
    let _e4 = params.first_list;
    let _e9 = lists[(_e4 + (2u * c))];
    return _e9;
}

fn compatible(p_2: vec3<f32>, n_2: vec3<f32>, node_3: u32) -> bool {
    let _e6 = nodes[node_3].p;
    let d_2 = (p_2 - _e6);
    let _e8 = dot3_(d_2, d_2);
    let length_ = sqrt(_e8);
    let _e13 = nodes[node_3].n;
    let _e14 = dot3_(d_2, _e13);
    let _e16 = dot3_(d_2, n_2);
    let off = max(abs(_e14), abs(_e16));
    let _e21 = params.inv_unit;
    let _e27 = params.inv_unit;
    return !(((off * _e21) >= (((0.3f * length_) * _e27) + 0.001f)));
}

fn crossed(at: Between, plane: u32, node_2: u32, own: f32, other: f32) -> vec2<u32> {
    let hides = (at.behind > vec2<f32>(min(at.turn, ((other * at.cosine) + 0.000002f)), min(at.turn, ((own * at.cosine) + 0.000002f))));
    let _e23 = nodes[node_2].plane;
    return select(vec2<u32>(plane, _e23), vec2(4294967295u), hides);
}

fn distance2_(p: vec3<f32>, n: vec3<f32>, node: u32) -> f32 {
    let _e6 = nodes[node].p;
    let _e10 = params.inv_unit;
    let d = ((p - _e6) * _e10);
    let _e15 = nodes[node].n;
    let _e19 = params.lambda;
    let m = ((n - _e15) * _e19);
    let _e21 = dot3_(d, d);
    let _e22 = dot3_(m, m);
    return (_e21 + _e22);
}

fn dot3_(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return (((a.x * b.x) + (a.y * b.y)) + (a.z * b.z));
}

fn edge(a_1: vec2<f32>, b_1: vec2<f32>) -> f32 {
    var local_2: bool;
    var local_3: bool;
    if !((a_1.x < b_1.x)) {
        if (a_1.x == b_1.x) {
            local_3 = (a_1.y < b_1.y);
        } else {
            local_3 = false;
        }
        let _e17 = local_3;
        local_2 = _e17;
    } else {
        local_2 = true;
    }
    let ordered = local_2;
    let p_3 = select(b_1, a_1, ordered);
    let q = select(a_1, b_1, ordered);
    let area = ((p_3.x * q.y) - (p_3.y * q.x));
    return select(-(area), area, ordered);
}

fn enter(i_4: u32, origin: vec3<f32>, inv: vec3<f32>, t_max: f32) -> f32 {
    var local_1: bool;
    let _e4 = box_min(i_4);
    let t0_ = ((_e4 - origin) * inv);
    let _e7 = box_max(i_4);
    let t1_ = ((_e7 - origin) * inv);
    let low = min(t0_, t1_);
    let high = max(t0_, t1_);
    let near = max(max(max(low.x, low.y), low.z), 0f);
    let far = (min(min(high.x, high.y), high.z) * 1.0000005f);
    if ((near * 0.9999995f) <= far) {
        local_1 = ((near * 0.9999995f) < t_max);
    } else {
        local_1 = false;
    }
    let _e36 = local_1;
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

fn lies_on(i_11: u32, origin_2: vec3<f32>, base: vec3<f32>) -> bool {
    var local_11: bool;
    let _e3 = tri_normal(i_11);
    let _e4 = dot3_(_e3, base);
    if (_e4 < -0.99999f) {
        let _e9 = tri_normal(i_11);
        let _e10 = tri_v0_(i_11);
        let _e12 = dot3_(_e9, (_e10 - origin_2));
        local_11 = (abs(_e12) < 0.000001f);
    } else {
        local_11 = false;
    }
    let _e17 = local_11;
    return _e17;
}

fn meet_triangle(i_10: u32, origin_1: vec3<f32>, s: Shear, t_max_1: f32) -> Hit {
    var local_4: bool;
    var local_5: bool;
    var local_6: bool;
    var local_7: bool;
    var local_8: bool;
    var local_9: bool;
    var local_10: bool;
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
        local_4 = (_e50 < 0f);
    } else {
        local_4 = true;
    }
    let _e60 = local_4;
    if !(_e60) {
        local_5 = (_e51 < 0f);
    } else {
        local_5 = true;
    }
    let _e67 = local_5;
    if _e67 {
        if !((_e49 > 0f)) {
            local_7 = (_e50 > 0f);
        } else {
            local_7 = true;
        }
        let _e78 = local_7;
        if !(_e78) {
            local_8 = (_e51 > 0f);
        } else {
            local_8 = true;
        }
        let _e85 = local_8;
        local_6 = _e85;
    } else {
        local_6 = false;
    }
    let outside = local_6;
    let det = ((_e49 + _e50) + _e51);
    if !(outside) {
        local_9 = (det == 0f);
    } else {
        local_9 = true;
    }
    let _e96 = local_9;
    if _e96 {
        return Hit(t_max_1, NONE, 0f, 0f);
    }
    let t = ((((_e49 * (s.sz * _e7.z)) + (_e50 * (s.sz * _e11.z))) + (_e51 * (s.sz * _e15.z))) / det);
    if (t > 0f) {
        local_10 = (t < t_max_1);
    } else {
        local_10 = false;
    }
    let _e122 = local_10;
    if _e122 {
        return Hit(t, i_10, (_e50 / det), (_e51 / det));
    }
    return Hit(t_max_1, NONE, 0f, 0f);
}

fn nonzero(x: f32) -> f32 {
    return select(x, select(0.00000000000000000001f, -0.00000000000000000001f, (x < 0f)), (abs(x) < 0.00000000000000000001f));
}

fn shear(direction: vec3<f32>) -> Shear {
    var kz_1: u32 = 2u;
    var local: bool;
    let a_2 = abs(direction);
    if (a_2.x > a_2.y) {
        local = (a_2.x > a_2.z);
    } else {
        local = false;
    }
    let _e13 = local;
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

fn take(k: u32, d2_: f32, node_4: u32) {
    if (k >= NEAREST) {
        orphan = node_4;
        return;
    } else {
        let _e8 = found;
        found_d[_e8] = d2_;
        let _e12 = found;
        found_n[_e12] = node_4;
        let _e16 = found;
        found = (_e16 + 1u);
        return;
    }
}

fn tri_normal(i: u32) -> vec3<f32> {
    let _e4 = tris[i].normal;
    return _e4;
}

fn tri_plane(i_1: u32) -> u32 {
    let _e4 = tris[i_1].plane;
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

fn turned(v: vec3<f32>, kz: u32) -> vec3<f32> {
    return select(select(v.xyz, v.zxy, (kz == 1u)), v.yzx, (kz == 0u));
}

fn walk(origin_3: vec3<f32>, direction_1: vec3<f32>, t_max_2: f32, skip: vec2<u32>, any_hit: bool, base_1: vec3<f32>) -> Hit {
    var hit: Hit;
    var stack: array<u32, 48>;
    var top: u32 = 0u;
    var at_1: u32 = 0u;
    var open: bool;
    var pop: bool;
    var i_12: u32;
    var local_12: bool;
    var local_13: bool;
    var met: Hit;
    var local_14: bool;
    var local_15: bool;
    var local_16: bool;
    var local_17: bool;
    var local_18: bool;
    var local_19: bool;
    var local_20: bool;
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
            let _e38 = at_1;
            let _e39 = box_count(_e38);
            let _e40 = at_1;
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
                            local_12 = (_e51 == skip.y);
                        } else {
                            local_12 = true;
                        }
                        let _e60 = local_12;
                        if _e60 {
                            continue;
                        }
                        if ((_e51 & TWIN) != 0u) {
                            let _e67 = i_12;
                            let _e68 = tri_normal(_e67);
                            let _e69 = dot3_(_e68, direction_1);
                            local_13 = (_e69 >= 0f);
                        } else {
                            local_13 = false;
                        }
                        let _e73 = local_13;
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
                                local_14 = ((_e92 * -(_e86)) < 0.000001f);
                            } else {
                                local_14 = false;
                            }
                            let _e98 = local_14;
                            if _e98 {
                                let _e101 = i_12;
                                let _e102 = lies_on(_e101, origin_3, base_1);
                                local_15 = _e102;
                            } else {
                                local_15 = false;
                            }
                            let _e104 = local_15;
                            if _e104 {
                                continue;
                            }
                            let _e106 = met.t;
                            let _e111 = met.t;
                            let behind_1 = select(((t_max_2 - _e106) * -(_e86)), (_e111 * _e86), (_e86 > 0f));
                            if (behind_1 < 0.0000004f) {
                                if !((_e86 > 0f)) {
                                    local_17 = any_hit;
                                } else {
                                    local_17 = true;
                                }
                                let _e126 = local_17;
                                local_16 = _e126;
                            } else {
                                local_16 = false;
                            }
                            let _e128 = local_16;
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
                    local_18 = (_e140 < (_e41 + _e39));
                } else {
                    local_18 = true;
                }
                let _e144 = local_18;
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
                            local_19 = (_e166 >= STACK);
                        } else {
                            local_19 = true;
                        }
                        let _e170 = local_19;
                        unfinished = _e170;
                        let _e171 = top;
                        stack[min(_e171, 47u)] = select((_e41 + 1u), _e41, swap);
                        let _e179 = top;
                        top = (_e179 + 1u);
                    }
                    at_1 = select(_e41, (_e41 + 1u), swap);
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
                    at_1 = _e197;
                }
            }
        }
    }
    let _e200 = unfinished;
    if !(_e200) {
        let _e204 = open;
        local_20 = _e204;
    } else {
        local_20 = true;
    }
    let _e206 = local_20;
    unfinished = _e206;
    let _e207 = hit;
    return _e207;
}

fn weights(i_13: u32) -> Psi {
    var result: Psi = Psi(vec4<u32>(4294967295u, 4294967295u, 4294967295u, 4294967295u), vec4<f32>());
    var local_21: bool;
    var d0_: f32 = F32_MAX;
    var d1_: f32 = F32_MAX;
    var d2_1: f32 = F32_MAX;
    var d3_: f32 = F32_MAX;
    var d4_: f32 = F32_MAX;
    var d5_: f32 = F32_MAX;
    var d6_: f32 = F32_MAX;
    var d7_: f32 = F32_MAX;
    var d8_: f32 = F32_MAX;
    var c0_: u32 = NONE;
    var c1_: u32 = NONE;
    var c2_: u32 = NONE;
    var c3_: u32 = NONE;
    var c4_: u32 = NONE;
    var c5_: u32 = NONE;
    var c6_: u32 = NONE;
    var c7_: u32 = NONE;
    var c8_: u32 = NONE;
    var list: u32;
    var c_2: u32;
    var local_22: bool;
    var local_23: bool;
    var near_d: array<f32, 9>;
    var near_c: array<u32, 9>;
    var reach: f32 = -1f;
    var k_1: u32 = 0u;
    var pending: bool = true;
    var node_5: u32;
    var local_24: bool;
    var local_25: bool;
    var local_26: bool;
    var local_27: bool;
    var local_28: bool;
    var local_29: bool;
    var look: Look;
    var most: f32;
    var c_3: u32;
    var sum: f32 = 0f;
    var k_2: u32 = 0u;
    let tri = points[i_13].tri;
    let tile = points[i_13].tile;
    if !((tri == NONE)) {
        local_21 = (tile == NONE);
    } else {
        local_21 = true;
    }
    let _e25 = local_21;
    if _e25 {
        let _e26 = result;
        return _e26;
    }
    let p_4 = points[i_13].p;
    let _e31 = tri_normal(tri);
    let _e32 = tri_plane(tri);
    list = tile;
    let _e72 = params.joint;
    if (_e72 != 0u) {
        let _e77 = params.joint;
        let _e80 = lists[tile];
        list = (_e77 + _e80);
    }
    let _e83 = list;
    let end = lists[(_e83 + 1u)];
    let _e89 = list;
    let _e91 = lists[_e89];
    c_2 = _e91;
    loop {
        let _e93 = c_2;
        if (_e93 < end) {
        } else {
            break;
        }
        {
            let _e95 = c_2;
            let _e96 = candidate_node(_e95);
            let _e97 = distance2_(p_4, _e31, _e96);
            let _e98 = d8_;
            if (_e97 < _e98) {
                let _e102 = params.joint;
                if (_e102 != 0u) {
                    let _e108 = c_2;
                    let _e109 = candidate_node(_e108);
                    let _e112 = nodes[_e109].n;
                    let _e113 = dot3_(_e31, _e112);
                    local_22 = (_e113 <= 0.7f);
                } else {
                    local_22 = false;
                }
                let _e117 = local_22;
                if _e117 {
                    continue;
                }
                let _e118 = d0_;
                let b0_ = (_e97 < _e118);
                let _e120 = d1_;
                let b1_ = (_e97 < _e120);
                let _e122 = d2_1;
                let b2_ = (_e97 < _e122);
                let _e124 = d3_;
                let b3_ = (_e97 < _e124);
                let _e126 = d4_;
                let b4_ = (_e97 < _e126);
                let _e128 = d5_;
                let b5_ = (_e97 < _e128);
                let _e130 = d6_;
                let b6_ = (_e97 < _e130);
                let _e132 = d7_;
                let b7_ = (_e97 < _e132);
                let _e134 = d7_;
                d8_ = select(_e97, _e134, b7_);
                let _e136 = c_2;
                let _e137 = c7_;
                c8_ = select(_e136, _e137, b7_);
                let _e139 = d7_;
                let _e141 = d6_;
                d7_ = select(select(_e139, _e97, b7_), _e141, b6_);
                let _e143 = c7_;
                let _e144 = c_2;
                let _e146 = c6_;
                c7_ = select(select(_e143, _e144, b7_), _e146, b6_);
                let _e148 = d6_;
                let _e150 = d5_;
                d6_ = select(select(_e148, _e97, b6_), _e150, b5_);
                let _e152 = c6_;
                let _e153 = c_2;
                let _e155 = c5_;
                c6_ = select(select(_e152, _e153, b6_), _e155, b5_);
                let _e157 = d5_;
                let _e159 = d4_;
                d5_ = select(select(_e157, _e97, b5_), _e159, b4_);
                let _e161 = c5_;
                let _e162 = c_2;
                let _e164 = c4_;
                c5_ = select(select(_e161, _e162, b5_), _e164, b4_);
                let _e166 = d4_;
                let _e168 = d3_;
                d4_ = select(select(_e166, _e97, b4_), _e168, b3_);
                let _e170 = c4_;
                let _e171 = c_2;
                let _e173 = c3_;
                c4_ = select(select(_e170, _e171, b4_), _e173, b3_);
                let _e175 = d3_;
                let _e177 = d2_1;
                d3_ = select(select(_e175, _e97, b3_), _e177, b2_);
                let _e179 = c3_;
                let _e180 = c_2;
                let _e182 = c2_;
                c3_ = select(select(_e179, _e180, b3_), _e182, b2_);
                let _e184 = d2_1;
                let _e186 = d1_;
                d2_1 = select(select(_e184, _e97, b2_), _e186, b1_);
                let _e188 = c2_;
                let _e189 = c_2;
                let _e191 = c1_;
                c2_ = select(select(_e188, _e189, b2_), _e191, b1_);
                let _e193 = d1_;
                let _e195 = d0_;
                d1_ = select(select(_e193, _e97, b1_), _e195, b0_);
                let _e197 = c1_;
                let _e198 = c_2;
                let _e200 = c0_;
                c1_ = select(select(_e197, _e198, b1_), _e200, b0_);
                let _e202 = d0_;
                d0_ = select(_e202, _e97, b0_);
                let _e204 = c0_;
                let _e205 = c_2;
                c0_ = select(_e204, _e205, b0_);
            }
        }
        continuing {
            let _e208 = c_2;
            c_2 = (_e208 + 1u);
        }
    }
    let _e212 = unfinished;
    if !(_e212) {
        let _e216 = c_2;
        local_23 = (_e216 < end);
    } else {
        local_23 = true;
    }
    let _e219 = local_23;
    unfinished = _e219;
    let _e220 = d0_;
    let _e221 = d1_;
    let _e222 = d2_1;
    let _e223 = d3_;
    let _e224 = d4_;
    let _e225 = d5_;
    let _e226 = d6_;
    let _e227 = d7_;
    let _e228 = d8_;
    near_d = array<f32, 9>(_e220, _e221, _e222, _e223, _e224, _e225, _e226, _e227, _e228);
    let _e231 = c0_;
    let _e232 = c1_;
    let _e233 = c2_;
    let _e234 = c3_;
    let _e235 = c4_;
    let _e236 = c5_;
    let _e237 = c6_;
    let _e238 = c7_;
    let _e239 = c8_;
    near_c = array<u32, 9>(_e231, _e232, _e233, _e234, _e235, _e236, _e237, _e238, _e239);
    loop {
        let _e248 = pending;
        if _e248 {
        } else {
            break;
        }
        {
            pending = false;
            node_5 = NONE;
            loop {
                let _e252 = pending;
                if !(_e252) {
                    let _e256 = k_1;
                    local_24 = (_e256 < 18u);
                } else {
                    local_24 = false;
                }
                let _e260 = local_24;
                if _e260 {
                    let _e264 = found;
                    local_25 = (_e264 < 5u);
                } else {
                    local_25 = false;
                }
                let _e268 = local_25;
                if _e268 {
                    let _e272 = orphan;
                    local_26 = (_e272 == NONE);
                } else {
                    local_26 = false;
                }
                let _e276 = local_26;
                if _e276 {
                    let _e279 = k_1;
                    if !((_e279 < NEAREST)) {
                        let _e286 = found;
                        local_28 = (_e286 == 0u);
                    } else {
                        local_28 = true;
                    }
                    let _e290 = local_28;
                    local_27 = _e290;
                } else {
                    local_27 = false;
                }
                let _e292 = local_27;
                if _e292 {
                } else {
                    break;
                }
                {
                    let _e293 = k_1;
                    let at_2 = near_c[(_e293 % NEAREST)];
                    if (at_2 != NONE) {
                        let _e300 = candidate_node(at_2);
                        node_5 = _e300;
                        let _e301 = k_1;
                        if !((_e301 >= NEAREST)) {
                            let _e307 = node_5;
                            let _e308 = compatible(p_4, _e31, _e307);
                            local_29 = _e308;
                        } else {
                            local_29 = true;
                        }
                        let _e310 = local_29;
                        if _e310 {
                            let _e311 = candidate_free(at_2);
                            pending = !(_e311);
                            let _e313 = pending;
                            if !(_e313) {
                                let _e315 = k_1;
                                let _e316 = k_1;
                                let _e320 = near_d[(_e316 % NEAREST)];
                                let _e321 = node_5;
                                take(_e315, _e320, _e321);
                            }
                        }
                    }
                    let _e323 = k_1;
                    k_1 = (_e323 + 1u);
                }
            }
            let _e325 = pending;
            if _e325 {
                let _e326 = node_5;
                let _e327 = between(p_4, _e31, _e326);
                let _e328 = reach;
                let up = (_e328 < 0f);
                let _e332 = reach;
                let own_1 = min(_e327.lift, (0.5f * _e332));
                let _e338 = node_5;
                let _e341 = nodes[_e338].clear;
                let other_1 = min(_e327.lift, (0.5f * _e341));
                let start = (p_4 + (_e31 * own_1));
                let _e348 = node_5;
                let _e351 = nodes[_e348].p;
                let _e353 = node_5;
                let _e356 = nodes[_e353].n;
                let stop = (_e351 + (_e356 * other_1));
                let _e360 = node_5;
                let _e361 = crossed(_e327, _e32, _e360, own_1, other_1);
                look = Look(start, (stop - start), 1f, _e361);
                if up {
                    most = 0f;
                    c_3 = 0u;
                    loop {
                        let _e369 = c_3;
                        if (_e369 < NEAREST) {
                        } else {
                            break;
                        }
                        {
                            let _e372 = c_3;
                            let _e374 = near_c[_e372];
                            if (_e374 != NONE) {
                                let _e377 = most;
                                let _e378 = c_3;
                                let _e380 = near_c[_e378];
                                let _e381 = candidate_node(_e380);
                                let _e382 = between(p_4, _e31, _e381);
                                most = max(_e377, _e382.lift);
                            }
                        }
                        continuing {
                            let _e386 = c_3;
                            c_3 = (_e386 + 1u);
                        }
                    }
                    let _e388 = most;
                    look = Look(p_4, _e31, (2f * ((1.001f * _e388) + 0.000004f)), vec2<u32>(_e32, NONE));
                }
                let _e399 = look.origin;
                let _e401 = look.direction;
                let _e403 = look.t_max;
                let _e405 = look.skip;
                let _e408 = walk(_e399, _e401, _e403, _e405, !(up), vec3<f32>());
                if up {
                    reach = _e408.t;
                    let _e411 = k_1;
                    k_1 = (_e411 - 1u);
                } else {
                    if (_e408.tri == NONE) {
                        let _e416 = k_1;
                        let _e419 = k_1;
                        let _e425 = near_d[((_e419 - 1u) % NEAREST)];
                        let _e426 = node_5;
                        take((_e416 - 1u), _e425, _e426);
                    }
                }
            }
        }
    }
    let _e428 = found;
    if (_e428 == 0u) {
        let _e434 = orphan;
        result.node.x = _e434;
        let _e435 = result;
        return _e435;
    }
    let _e438 = found;
    let _e442 = found_d[(_e438 - 1u)];
    let _e447 = found_d[4];
    let _e449 = found;
    let radius2_ = max(select((2.25f * _e442), _e447, (_e449 == 5u)), 0.00000000000000000001f);
    loop {
        let _e459 = k_2;
        let _e461 = found;
        if (_e459 < min(_e461, 4u)) {
        } else {
            break;
        }
        {
            let _e466 = k_2;
            let _e468 = found_d[_e466];
            let t_1 = (max((1f - (_e468 / radius2_)), 0f) + 0.000001f);
            let _e477 = k_2;
            let _e480 = k_2;
            let _e482 = found_n[_e480];
            result.node[_e477] = _e482;
            let _e484 = k_2;
            result.weight[_e484] = (t_1 * t_1);
            let _e487 = sum;
            sum = (_e487 + (t_1 * t_1));
        }
        continuing {
            let _e491 = k_2;
            k_2 = (_e491 + 1u);
        }
    }
    let _e495 = result.weight;
    let _e496 = sum;
    result.weight = (_e495 / vec4(_e496));
    let _e499 = result;
    return _e499;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e9 = params.base;
    let i_14 = order[(_e9 + gid.x)];
    let _e16 = weights(i_14);
    psi[i_14] = _e16;
    finish();
    return;
}
