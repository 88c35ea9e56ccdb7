const BACK: u32 = 3u;

const F32_MAX: f32 = 340282350000000000000000000000000000000f;

const FEW: u32 = 64u;

const FRONT: u32 = 1u;

const NONE: u32 = 4294967295u;

const PI: f32 = 3.1415927f;

const SKY: u32 = 2u;

const STACK: u32 = 48u;

const TWIN: u32 = 2147483648u;

struct BvhNode {
    min: vec3<f32>,
    count: u32,
    max: vec3<f32>,
    first: u32,
}

struct DirectSum {
    sum: vec3<f32>,
    rounds: u32,
    square: f32,
    pad0_: array<u32, 3>,
}

struct Emitter {
    tri: u32,
    cdf: u32,
    density: f32,
    near2_: f32,
}

struct Hit {
    t: f32,
    tri: u32,
    b1_: f32,
    b2_: f32,
}

struct Material {
    rho: vec3<f32>,
    pad0_: u32,
    emit: vec3<f32>,
    pad1_: u32,
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
    rounds: u32,
    emitter: u32,
    cosine: u32,
    emitters: u32,
    emitter_density: f32,
    pad0_: u32,
    pad1_: u32,
}

struct Place {
    index: u32,
    place: f32,
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
var<storage> materials: array<Material>;

@group(0) @binding(4) 
var<storage> emitters: array<Emitter>;

@group(0) @binding(5) 
var<storage> points: array<Point>;

@group(0) @binding(6) 
var<storage> active_points: array<u32>;

@group(0) @binding(7) 
var<storage, read_write> sums: array<DirectSum>;

@group(0) @binding(8) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> unfinished: bool = false;

fn area_sample(k_1: u32, seed_3: u32, tri_1: u32, p_1: vec3<f32>, cosine: u32) -> vec3<f32> {
    var local_28: bool;
    var local_29: bool;
    let _e7 = params.emitter;
    let ne = f32(_e7);
    let nc = f32(cosine);
    let _e10 = sobol4_(k_1, seed_3);
    let _e13 = params.emitters;
    let _e15 = invert_cdf(_e13, _e10.x);
    let there = emitters[_e15.index].tri;
    let _e23 = unit(_e10.y);
    let _e24 = place_on(_e15.place, _e23);
    let _e27 = position(there, _e24.x, _e24.y);
    let _e28 = tri_normal(there);
    let _e29 = tri_normal(tri_1);
    let _e30 = kernel_g(_e27, _e28, p_1, _e29);
    let _e31 = tri_plane(tri_1);
    let _e32 = tri_plane(there);
    let planes = vec2<u32>(_e31, _e32);
    if (_e30 > 0f) {
        local_28 = (planes.x != planes.y);
    } else {
        local_28 = false;
    }
    let _e42 = local_28;
    if _e42 {
        let _e45 = segment_blocked(p_1, _e27, planes);
        local_29 = !(_e45);
    } else {
        local_29 = false;
    }
    let _e48 = local_29;
    if _e48 {
        let _e50 = tri_material(there);
        let _e53 = materials[_e50].emit;
        let _e58 = emitters[_e15.index].density;
        return (_e53 * (_e30 / ((ne * _e58) + (nc * _e30))));
    }
    return vec3<f32>();
}

fn box_count(i_9: u32) -> u32 {
    let _e4 = bvh[i_9].count;
    return _e4;
}

fn box_first(i_10: u32) -> u32 {
    let _e4 = bvh[i_10].first;
    return _e4;
}

fn box_max(i_7: u32) -> vec3<f32> {
    let _e4 = bvh[i_7].max;
    return _e4;
}

fn box_min(i_6: u32) -> vec3<f32> {
    let _e4 = bvh[i_6].min;
    return _e4;
}

fn cdf(i: u32) -> u32 {
    let _e4 = emitters[i].cdf;
    return _e4;
}

fn cos_sin_turn(u: f32) -> vec2<f32> {
    let quarter = floor(((4f * u) + 0.5f));
    let x_7 = ((u - (0.25f * quarter)) * 6.2831855f);
    let x2_ = (x_7 * x_7);
    let s_2 = (x_7 * (1f + (x2_ * (-0.16666667f + (x2_ * (0.008333334f + (x2_ * (-0.0001984127f + (x2_ * 0.0000027557319f)))))))));
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

fn cosine_direction(n_1: vec3<f32>, u_1: f32, v_4: f32) -> vec3<f32> {
    let _e3 = tangents(n_1);
    let _e4 = cos_sin_turn(v_4);
    let r_3 = sqrt(u_1);
    let z = sqrt(max((1f - u_1), 0f));
    return (((_e3.t1_ * (r_3 * _e4.x)) + (_e3.t2_ * (r_3 * _e4.y))) + (n_1 * z));
}

fn cosine_sample(k_2: u32, seed_4: u32, tri_3: u32, p_3: vec3<f32>) -> vec3<f32> {
    let _e6 = params.emitter;
    let ne_1 = f32(_e6);
    let _e10 = params.cosine;
    let nc_1 = f32(_e10);
    let _e12 = tri_normal(tri_3);
    let _e13 = sobol4_(k_2, seed_4);
    let _e15 = unit(_e13.z);
    let _e17 = unit(_e13.w);
    let _e18 = cosine_direction(_e12, _e15, _e17);
    let _e19 = first_hit(tri_3, p_3, _e18);
    if (_e19.kind == FRONT) {
        let _e26 = tri_material(_e19.hit.tri);
        let emit = materials[_e26].emit;
        let total = ((emit.x + emit.y) + emit.z);
        if (total > 0f) {
            let _e37 = dot3_(_e12, _e18);
            let _e40 = tri_normal(_e19.hit.tri);
            let _e41 = dot3_(_e40, _e18);
            let cos_x_2 = -(_e41);
            let _e45 = geometric(cos_x_2, _e37, _e19.hit.t);
            let _e49 = params.emitter_density;
            return (emit * (_e45 / (((ne_1 * total) * _e49) + (nc_1 * _e45))));
        }
    }
    return vec3<f32>();
}

fn dot3_(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return (((a.x * b.x) + (a.y * b.y)) + (a.z * b.z));
}

fn edge(a_2: vec2<f32>, b_2: vec2<f32>) -> f32 {
    var local_9: bool;
    var local_10: bool;
    if !((a_2.x < b_2.x)) {
        if (a_2.x == b_2.x) {
            local_10 = (a_2.y < b_2.y);
        } else {
            local_10 = false;
        }
        let _e17 = local_10;
        local_9 = _e17;
    } else {
        local_9 = true;
    }
    let ordered = local_9;
    let p_5 = select(b_2, a_2, ordered);
    let q = select(a_2, b_2, ordered);
    let area = ((p_5.x * q.y) - (p_5.y * q.x));
    return select(-(area), area, ordered);
}

fn enter(i_8: u32, origin: vec3<f32>, inv: vec3<f32>, t_max: f32) -> f32 {
    var local_8: bool;
    let _e4 = box_min(i_8);
    let t0_ = ((_e4 - origin) * inv);
    let _e7 = box_max(i_8);
    let t1_ = ((_e7 - origin) * inv);
    let low_1 = min(t0_, t1_);
    let high_1 = max(t0_, t1_);
    let near_1 = max(max(max(low_1.x, low_1.y), low_1.z), 0f);
    let far = (min(min(high_1.x, high_1.y), high_1.z) * 1.0000005f);
    if ((near_1 * 0.9999995f) <= far) {
        local_8 = ((near_1 * 0.9999995f) < t_max);
    } else {
        local_8 = false;
    }
    let _e36 = local_8;
    return select(F32_MAX, near_1, _e36);
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

fn first_hit(tri_2: u32, p_2: vec3<f32>, direction_2: vec3<f32>) -> Met {
    let _e4 = tri_plane(tri_2);
    let _e8 = tri_normal(tri_2);
    let _e9 = walk(p_2, direction_2, F32_MAX, vec2<u32>(_e4, NONE), false, _e8);
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

fn geometric(cos_x: f32, cos_y: f32, r_1: f32) -> f32 {
    return (((cos_x / r_1) * (cos_y / r_1)) / PI);
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

fn invert_cdf(len: u32, v_2: u32) -> Place {
    var low: u32 = 0u;
    var high: u32;
    var local_6: bool;
    var start: u32 = 0u;
    let u_2 = min(v_2, 4294967294u);
    high = (len - 1u);
    loop {
        let _e9 = low;
        let _e10 = high;
        if (_e9 < _e10) {
        } else {
            break;
        }
        {
            let _e12 = low;
            let _e13 = high;
            let middle_1 = ((_e12 + _e13) / 2u);
            let _e17 = cdf(middle_1);
            if (_e17 > u_2) {
                high = middle_1;
            } else {
                low = (middle_1 + 1u);
            }
        }
    }
    let _e23 = unfinished;
    if !(_e23) {
        let _e27 = low;
        let _e28 = high;
        local_6 = (_e27 < _e28);
    } else {
        local_6 = true;
    }
    let _e31 = local_6;
    unfinished = _e31;
    let _e34 = low;
    if (_e34 > 0u) {
        let _e37 = low;
        let _e40 = cdf((_e37 - 1u));
        start = _e40;
    }
    let _e41 = low;
    let _e42 = cdf(_e41);
    let _e43 = start;
    let width = max((_e42 - _e43), 1u);
    let _e47 = start;
    let place = ((f32((u_2 - _e47)) + 0.5f) / f32(width));
    let _e54 = low;
    return Place(_e54, min(place, 0.99999994f));
}

fn is_near(p: vec3<f32>) -> bool {
    var near: bool = false;
    var e: u32 = 0u;
    var local_3: bool;
    var local_4: bool;
    let _e3 = params.emitters;
    if (_e3 > FEW) {
        return true;
    }
    loop {
        let _e11 = e;
        let _e14 = params.emitters;
        if (_e11 < _e14) {
        } else {
            break;
        }
        {
            let _e17 = e;
            let _e20 = emitters[_e17].tri;
            let _e21 = tri_v0_(_e20);
            let d_1 = (p - _e21);
            let _e23 = near;
            if !(_e23) {
                let _e27 = dot3_(d_1, d_1);
                let _e29 = e;
                let _e32 = emitters[_e29].near2_;
                local_3 = (_e27 < _e32);
            } else {
                local_3 = true;
            }
            let _e35 = local_3;
            near = _e35;
        }
        continuing {
            let _e37 = e;
            e = (_e37 + 1u);
        }
    }
    let _e41 = unfinished;
    if !(_e41) {
        let _e45 = e;
        let _e48 = params.emitters;
        local_4 = (_e45 < _e48);
    } else {
        local_4 = true;
    }
    let _e51 = local_4;
    unfinished = _e51;
    let _e52 = near;
    return _e52;
}

fn kernel_g(x_5: vec3<f32>, nx: vec3<f32>, y: vec3<f32>, ny: vec3<f32>) -> f32 {
    let d_3 = (y - x_5);
    let _e5 = dot3_(d_3, d_3);
    if !((_e5 > 0f)) {
        return 0f;
    }
    let r_2 = sqrt(_e5);
    let _e11 = dot3_(nx, d_3);
    let cos_x_1 = max((_e11 / r_2), 0f);
    let _e15 = dot3_(ny, d_3);
    let cos_y_1 = max((-(_e15) / r_2), 0f);
    let _e20 = geometric(cos_x_1, cos_y_1, r_2);
    return _e20;
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

fn lies_on(i_12: u32, origin_2: vec3<f32>, base: vec3<f32>) -> bool {
    var local_18: bool;
    let _e3 = tri_normal(i_12);
    let _e4 = dot3_(_e3, base);
    if (_e4 < -0.99999f) {
        let _e9 = tri_normal(i_12);
        let _e10 = tri_v0_(i_12);
        let _e12 = dot3_(_e9, (_e10 - origin_2));
        local_18 = (abs(_e12) < 0.000001f);
    } else {
        local_18 = false;
    }
    let _e17 = local_18;
    return _e17;
}

fn meet_triangle(i_11: u32, origin_1: vec3<f32>, s: Shear, t_max_1: f32) -> Hit {
    var local_11: bool;
    var local_12: bool;
    var local_13: bool;
    var local_14: bool;
    var local_15: bool;
    var local_16: bool;
    var local_17: bool;
    let _e4 = tri_v0_(i_11);
    let _e7 = turned((_e4 - origin_1), s.kz);
    let _e8 = tri_v1_(i_11);
    let _e11 = turned((_e8 - origin_1), s.kz);
    let _e12 = tri_v2_(i_11);
    let _e15 = turned((_e12 - origin_1), s.kz);
    let pa = vec2<f32>((_e7.x - (s.sx * _e7.z)), (_e7.y - (s.sy * _e7.z)));
    let pb = vec2<f32>((_e11.x - (s.sx * _e11.z)), (_e11.y - (s.sy * _e11.z)));
    let pc = vec2<f32>((_e15.x - (s.sx * _e15.z)), (_e15.y - (s.sy * _e15.z)));
    let _e49 = edge(pc, pb);
    let _e50 = edge(pa, pc);
    let _e51 = edge(pb, pa);
    if !((_e49 < 0f)) {
        local_11 = (_e50 < 0f);
    } else {
        local_11 = true;
    }
    let _e60 = local_11;
    if !(_e60) {
        local_12 = (_e51 < 0f);
    } else {
        local_12 = true;
    }
    let _e67 = local_12;
    if _e67 {
        if !((_e49 > 0f)) {
            local_14 = (_e50 > 0f);
        } else {
            local_14 = true;
        }
        let _e78 = local_14;
        if !(_e78) {
            local_15 = (_e51 > 0f);
        } else {
            local_15 = true;
        }
        let _e85 = local_15;
        local_13 = _e85;
    } else {
        local_13 = false;
    }
    let outside = local_13;
    let det = ((_e49 + _e50) + _e51);
    if !(outside) {
        local_16 = (det == 0f);
    } else {
        local_16 = true;
    }
    let _e96 = local_16;
    if _e96 {
        return Hit(t_max_1, NONE, 0f, 0f);
    }
    let t = ((((_e49 * (s.sz * _e7.z)) + (_e50 * (s.sz * _e11.z))) + (_e51 * (s.sz * _e15.z))) / det);
    if (t > 0f) {
        local_17 = (t < t_max_1);
    } else {
        local_17 = false;
    }
    let _e122 = local_17;
    if _e122 {
        return Hit(t, i_11, (_e50 / det), (_e51 / det));
    }
    return Hit(t_max_1, NONE, 0f, 0f);
}

fn nonzero(x_6: f32) -> f32 {
    return select(x_6, select(0.00000000000000000001f, -0.00000000000000000001f, (x_6 < 0f)), (abs(x_6) < 0.00000000000000000001f));
}

fn place_on(a_1: f32, b_1: f32) -> vec2<f32> {
    let root = sqrt(a_1);
    return vec2<f32>((root * (1f - b_1)), (root * b_1));
}

fn position(tri: u32, b1_: f32, b2_: f32) -> vec3<f32> {
    var middle: vec3<f32>;
    let _e3 = tri_v0_(tri);
    let _e4 = tri_v1_(tri);
    let _e5 = tri_v2_(tri);
    let p_4 = ((_e3 + ((_e4 - _e3) * b1_)) + ((_e5 - _e3) * b2_));
    middle = ((_e3 + _e4) * 0.5f);
    middle = (((_e3 + _e4) + _e5) * 0.33333334f);
    let _e20 = middle;
    let d_2 = (_e20 - p_4);
    let _e22 = dot3_(d_2, d_2);
    return (p_4 + (d_2 * (0.000001f / max(sqrt(_e22), 0.000002f))));
}

fn scramble(x_2: u32, seed_1: u32) -> u32 {
    let _e3 = laine_karras(reverseBits(x_2), seed_1);
    return reverseBits(_e3);
}

fn seed_of(seed_5: u32, i_15: u32) -> u32 {
    let _e4 = hash((i_15 + 2654435769u));
    let _e6 = hash((seed_5 ^ _e4));
    return _e6;
}

fn segment_blocked(a_3: vec3<f32>, b_3: vec3<f32>, skip_1: vec2<u32>) -> bool {
    let _e7 = walk(a_3, (b_3 - a_3), 1f, skip_1, true, vec3<f32>());
    return (_e7.tri != NONE);
}

fn shear(direction: vec3<f32>) -> Shear {
    var kz_1: u32 = 2u;
    var local_7: bool;
    let a_4 = abs(direction);
    if (a_4.x > a_4.y) {
        local_7 = (a_4.x > a_4.z);
    } else {
        local_7 = false;
    }
    let _e13 = local_7;
    if _e13 {
        kz_1 = 0u;
    } else {
        if (a_4.y > a_4.z) {
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
    var local_5: bool;
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
        local_5 = (_e75 != 0u);
    } else {
        local_5 = true;
    }
    let _e79 = local_5;
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
    let a_5 = (-1f / (s_1 + n.z));
    let b_4 = ((n.x * n.y) * a_5);
    return Tangents(vec3<f32>((1f + (((s_1 * n.x) * n.x) * a_5)), (s_1 * b_4), (-(s_1) * n.x)), vec3<f32>(b_4, (s_1 + ((n.y * n.y) * a_5)), -(n.y)));
}

fn tri_material(i_14: u32) -> u32 {
    let _e4 = tris[i_14].material;
    return _e4;
}

fn tri_normal(i_4: u32) -> vec3<f32> {
    let _e4 = tris[i_4].normal;
    return _e4;
}

fn tri_plane(i_5: u32) -> u32 {
    let _e4 = tris[i_5].plane;
    return _e4;
}

fn tri_v0_(i_1: u32) -> vec3<f32> {
    let _e4 = tris[i_1].v0_;
    return _e4;
}

fn tri_v1_(i_2: u32) -> vec3<f32> {
    let _e4 = tris[i_2].v1_;
    return _e4;
}

fn tri_v2_(i_3: u32) -> vec3<f32> {
    let _e4 = tris[i_3].v2_;
    return _e4;
}

fn turned(v_3: vec3<f32>, kz: u32) -> vec3<f32> {
    return select(select(v_3.xyz, v_3.zxy, (kz == 1u)), v_3.yzx, (kz == 0u));
}

fn unit(x_4: u32) -> f32 {
    return (f32((x_4 >> 8u)) * 0.000000059604645f);
}

fn walk(origin_3: vec3<f32>, direction_1: vec3<f32>, t_max_2: f32, skip: vec2<u32>, any_hit: bool, base_1: vec3<f32>) -> Hit {
    var hit: Hit;
    var stack: array<u32, 48>;
    var top: u32 = 0u;
    var at: u32 = 0u;
    var open: bool;
    var pop: bool;
    var i_13: u32;
    var local_19: bool;
    var local_20: bool;
    var met: Hit;
    var local_21: bool;
    var local_22: bool;
    var local_23: bool;
    var local_24: bool;
    var local_25: bool;
    var local_26: bool;
    var local_27: bool;
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
                i_13 = _e41;
                loop {
                    let _e47 = i_13;
                    if (_e47 < (_e41 + _e39)) {
                    } else {
                        break;
                    }
                    {
                        let _e50 = i_13;
                        let _e51 = tri_plane(_e50);
                        if !((_e51 == skip.x)) {
                            local_19 = (_e51 == skip.y);
                        } else {
                            local_19 = true;
                        }
                        let _e60 = local_19;
                        if _e60 {
                            continue;
                        }
                        if ((_e51 & TWIN) != 0u) {
                            let _e67 = i_13;
                            let _e68 = tri_normal(_e67);
                            let _e69 = dot3_(_e68, direction_1);
                            local_20 = (_e69 >= 0f);
                        } else {
                            local_20 = false;
                        }
                        let _e73 = local_20;
                        if _e73 {
                            continue;
                        }
                        met = Hit();
                        let _e76 = i_13;
                        let _e78 = hit.t;
                        let _e79 = meet_triangle(_e76, origin_3, _e6, _e78);
                        met = _e79;
                        let _e81 = met.tri;
                        if (_e81 != NONE) {
                            let _e84 = i_13;
                            let _e85 = tri_normal(_e84);
                            let _e86 = dot3_(_e85, direction_1);
                            if (_e86 < 0f) {
                                let _e92 = met.t;
                                local_21 = ((_e92 * -(_e86)) < 0.000001f);
                            } else {
                                local_21 = false;
                            }
                            let _e98 = local_21;
                            if _e98 {
                                let _e101 = i_13;
                                let _e102 = lies_on(_e101, origin_3, base_1);
                                local_22 = _e102;
                            } else {
                                local_22 = false;
                            }
                            let _e104 = local_22;
                            if _e104 {
                                continue;
                            }
                            let _e106 = met.t;
                            let _e111 = met.t;
                            let behind = select(((t_max_2 - _e106) * -(_e86)), (_e111 * _e86), (_e86 > 0f));
                            if (behind < 0.0000004f) {
                                if !((_e86 > 0f)) {
                                    local_24 = any_hit;
                                } else {
                                    local_24 = true;
                                }
                                let _e126 = local_24;
                                local_23 = _e126;
                            } else {
                                local_23 = false;
                            }
                            let _e128 = local_23;
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
                        let _e132 = i_13;
                        i_13 = (_e132 + 1u);
                    }
                }
                let _e136 = unfinished;
                if !(_e136) {
                    let _e140 = i_13;
                    local_25 = (_e140 < (_e41 + _e39));
                } else {
                    local_25 = true;
                }
                let _e144 = local_25;
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
                            local_26 = (_e166 >= STACK);
                        } else {
                            local_26 = true;
                        }
                        let _e170 = local_26;
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
        local_27 = _e204;
    } else {
        local_27 = true;
    }
    let _e206 = local_27;
    unfinished = _e206;
    let _e207 = hit;
    return _e207;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var sum: vec3<f32>;
    var square: f32;
    var r: u32;
    var d: vec3<f32>;
    var k: u32;
    var local: bool;
    var local_1: bool;
    var local_2: bool;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e9 = params.base;
    let i_16 = active_points[(_e9 + gid.x)];
    let _e16 = params.emitters;
    if (_e16 == 0u) {
        let _e22 = sums[i_16].rounds;
        let _e25 = params.rounds;
        sums[i_16].rounds = (_e22 + _e25);
        return;
    }
    let tri_4 = points[i_16].tri;
    if (tri_4 == NONE) {
        return;
    }
    let p_6 = points[i_16].p;
    let _e39 = params.seed;
    let _e40 = seed_of(_e39, i_16);
    let _e44 = params.cosine;
    let _e45 = is_near(p_6);
    let cosine_1 = select(0u, _e44, _e45);
    let _e50 = sums[i_16].sum;
    sum = _e50;
    let _e55 = sums[i_16].square;
    square = _e55;
    let _e59 = params.first;
    r = _e59;
    loop {
        let _e61 = r;
        let _e64 = params.first;
        let _e67 = params.rounds;
        if (_e61 < (_e64 + _e67)) {
        } else {
            break;
        }
        {
            d = vec3<f32>();
            let _e72 = r;
            let _e75 = params.emitter;
            k = (_e72 * _e75);
            loop {
                let _e78 = k;
                let _e79 = r;
                let _e84 = params.emitter;
                if (_e78 < ((_e79 + 1u) * _e84)) {
                } else {
                    break;
                }
                {
                    let _e87 = d;
                    let _e88 = k;
                    let _e89 = area_sample(_e88, _e40, tri_4, p_6, cosine_1);
                    d = (_e87 + _e89);
                }
                continuing {
                    let _e92 = k;
                    k = (_e92 + 1u);
                }
            }
            let _e96 = unfinished;
            if !(_e96) {
                let _e100 = k;
                let _e101 = r;
                let _e106 = params.emitter;
                local = (_e100 < ((_e101 + 1u) * _e106));
            } else {
                local = true;
            }
            let _e110 = local;
            unfinished = _e110;
            let _e111 = r;
            k = (_e111 * cosine_1);
            loop {
                let _e113 = k;
                let _e114 = r;
                if (_e113 < ((_e114 + 1u) * cosine_1)) {
                } else {
                    break;
                }
                {
                    let _e119 = d;
                    let _e120 = k;
                    let _e121 = cosine_sample(_e120, _e40, tri_4, p_6);
                    d = (_e119 + _e121);
                }
                continuing {
                    let _e124 = k;
                    k = (_e124 + 1u);
                }
            }
            let _e128 = unfinished;
            if !(_e128) {
                let _e132 = k;
                let _e133 = r;
                local_1 = (_e132 < ((_e133 + 1u) * cosine_1));
            } else {
                local_1 = true;
            }
            let _e139 = local_1;
            unfinished = _e139;
            let _e141 = d.x;
            let _e143 = d.y;
            let _e146 = d.z;
            let mean = (((_e141 + _e143) + _e146) * 0.33333334f);
            let _e150 = sum;
            let _e151 = d;
            sum = (_e150 + _e151);
            let _e153 = square;
            square = (_e153 + (mean * mean));
        }
        continuing {
            let _e157 = r;
            r = (_e157 + 1u);
        }
    }
    let _e161 = unfinished;
    if !(_e161) {
        let _e165 = r;
        let _e168 = params.first;
        let _e171 = params.rounds;
        local_2 = (_e165 < (_e168 + _e171));
    } else {
        local_2 = true;
    }
    let _e175 = local_2;
    unfinished = _e175;
    let _e179 = sum;
    sums[i_16].sum = _e179;
    let _e183 = square;
    sums[i_16].square = _e183;
    let _e187 = sums[i_16].rounds;
    let _e190 = params.rounds;
    sums[i_16].rounds = (_e187 + _e190);
    finish();
    return;
}
