const F32_MAX: f32 = 340282350000000000000000000000000000000f;

const NONE: u32 = 4294967295u;

const PI: f32 = 3.1415927f;

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

struct Params {
    base: u32,
    count: u32,
    flag: u32,
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
var<storage> points: array<Point>;

@group(0) @binding(4) 
var<storage, read_write> values: array<f32>;

@group(0) @binding(5) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> unfinished: bool = false;

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
    let p = select(b_1, a_1, ordered);
    let q = select(a_1, b_1, ordered);
    let area = ((p.x * q.y) - (p.y * q.x));
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

fn geometric(cos_x: f32, cos_y: f32, r: f32) -> f32 {
    return (((cos_x / r) * (cos_y / r)) / PI);
}

fn kernel_g(x: vec3<f32>, nx: vec3<f32>, y: vec3<f32>, ny: vec3<f32>) -> f32 {
    let d = (y - x);
    let _e5 = dot3_(d, d);
    if !((_e5 > 0f)) {
        return 0f;
    }
    let r_1 = sqrt(_e5);
    let _e11 = dot3_(nx, d);
    let cos_x_1 = max((_e11 / r_1), 0f);
    let _e15 = dot3_(ny, d);
    let cos_y_1 = max((-(_e15) / r_1), 0f);
    let _e20 = geometric(cos_x_1, cos_y_1, r_1);
    return _e20;
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

fn nonzero(x_1: f32) -> f32 {
    return select(x_1, select(0.00000000000000000001f, -0.00000000000000000001f, (x_1 < 0f)), (abs(x_1) < 0.00000000000000000001f));
}

fn pair(x_2: u32, y_1: u32) -> f32 {
    var local_21: bool;
    var local_22: bool;
    let tx = points[x_2].tri;
    let ty = points[y_1].tri;
    if !((tx == NONE)) {
        local_21 = (ty == NONE);
    } else {
        local_21 = true;
    }
    let _e18 = local_21;
    if _e18 {
        return 0f;
    }
    let _e20 = tri_plane(tx);
    let _e21 = tri_plane(ty);
    let planes = vec2<u32>(_e20, _e21);
    if (planes.x == planes.y) {
        return 0f;
    }
    let _e30 = points[x_2].p;
    let _e31 = tri_normal(tx);
    let _e35 = points[y_1].p;
    let _e36 = tri_normal(ty);
    let _e37 = kernel_g(_e30, _e31, _e35, _e36);
    if (_e37 > 0f) {
        let _e45 = points[x_2].p;
        let _e49 = points[y_1].p;
        let _e50 = segment_blocked(_e45, _e49, planes);
        local_22 = !(_e50);
    } else {
        local_22 = false;
    }
    let _e53 = local_22;
    if _e53 {
        return _e37;
    }
    return 0f;
}

fn segment_blocked(a_2: vec3<f32>, b_2: vec3<f32>, skip_1: vec2<u32>) -> bool {
    let _e7 = walk(a_2, (b_2 - a_2), 1f, skip_1, true, vec3<f32>());
    return (_e7.tri != NONE);
}

fn shear(direction: vec3<f32>) -> Shear {
    var kz_1: u32 = 2u;
    var local: bool;
    let a_3 = abs(direction);
    if (a_3.x > a_3.y) {
        local = (a_3.x > a_3.z);
    } else {
        local = false;
    }
    let _e13 = local;
    if _e13 {
        kz_1 = 0u;
    } else {
        if (a_3.y > a_3.z) {
            kz_1 = 1u;
        }
    }
    let _e19 = kz_1;
    let _e20 = turned(direction, _e19);
    let _e21 = kz_1;
    return Shear(_e21, (_e20.x / _e20.z), (_e20.y / _e20.z), (1f / _e20.z));
}

fn tri_normal(i_1: u32) -> vec3<f32> {
    let _e4 = tris[i_1].normal;
    return _e4;
}

fn tri_plane(i: u32) -> u32 {
    let _e4 = tris[i].plane;
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
    var at: u32 = 0u;
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
                            let behind = select(((t_max_2 - _e106) * -(_e86)), (_e111 * _e86), (_e86 > 0f));
                            if (behind < 0.0000004f) {
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
        local_20 = _e204;
    } else {
        local_20 = true;
    }
    let _e206 = local_20;
    unfinished = _e206;
    let _e207 = hit;
    return _e207;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let i_13 = (_e8 + gid.x);
    let _e19 = pair((2u * i_13), ((2u * i_13) + 1u));
    values[i_13] = _e19;
    finish();
    return;
}
