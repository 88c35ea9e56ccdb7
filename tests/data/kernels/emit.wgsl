const BACK: u32 = 3u;

const F32_MAX: f32 = 340282350000000000000000000000000000000f;

const FRONT: u32 = 1u;

const NONE: u32 = 4294967295u;

const SKY: u32 = 2u;

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
    total: u32,
    tiles: u32,
    rays: u32,
    bits: u32,
    pad0_: u32,
    pad1_: u32,
    pad2_: u32,
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

struct Tile {
    cdf: u32,
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
var<storage> bvh: array<BvhNode>;

@group(0) @binding(2) 
var<storage> tris: array<Tri>;

@group(0) @binding(3) 
var<storage> tiles: array<Tile>;

@group(0) @binding(4) 
var<storage> tile_tri: array<u32>;

@group(0) @binding(5) 
var<storage, read_write> points: array<Point>;

@group(0) @binding(6) 
var<storage, read_write> suspects: array<atomic<u32>>;

@group(0) @binding(7) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> unfinished: bool = false;

fn box_count(i_10: u32) -> u32 {
    let _e4 = bvh[i_10].count;
    return _e4;
}

fn box_first(i_11: u32) -> u32 {
    let _e4 = bvh[i_11].first;
    return _e4;
}

fn box_max(i_8: u32) -> vec3<f32> {
    let _e4 = bvh[i_8].max;
    return _e4;
}

fn box_min(i_7: u32) -> vec3<f32> {
    let _e4 = bvh[i_7].min;
    return _e4;
}

fn cdf(i: u32) -> u32 {
    let _e4 = tiles[i].cdf;
    return _e4;
}

fn cos_sin_turn(u: f32) -> vec2<f32> {
    let quarter = floor(((4f * u) + 0.5f));
    let x_6 = ((u - (0.25f * quarter)) * 6.2831855f);
    let x2_ = (x_6 * x_6);
    let s_4 = (x_6 * (1f + (x2_ * (-0.16666667f + (x2_ * (0.008333334f + (x2_ * (-0.0001984127f + (x2_ * 0.0000027557319f)))))))));
    let c = (1f + (x2_ * (-0.5f + (x2_ * (0.041666668f + (x2_ * (-0.0013888889f + (x2_ * 0.000024801588f))))))));
    let q = (u32(quarter) & 3u);
    if (q == 0u) {
        return vec2<f32>(c, s_4);
    }
    if (q == 1u) {
        return vec2<f32>(-(s_4), c);
    }
    if (q == 2u) {
        return vec2<f32>(-(c), -(s_4));
    }
    return vec2<f32>(s_4, -(c));
}

fn cosine_direction(n_2: vec3<f32>, u_1: f32, v_3: f32) -> vec3<f32> {
    let _e3 = tangents(n_2);
    let _e4 = cos_sin_turn(v_3);
    let r = sqrt(u_1);
    let z = sqrt(max((1f - u_1), 0f));
    return (((_e3.t1_ * (r * _e4.x)) + (_e3.t2_ * (r * _e4.y))) + (n_2 * z));
}

fn dot3_(a_1: vec3<f32>, b_1: vec3<f32>) -> f32 {
    return (((a_1.x * b_1.x) + (a_1.y * b_1.y)) + (a_1.z * b_1.z));
}

fn edge(a_2: vec2<f32>, b_2: vec2<f32>) -> f32 {
    var local_5: bool;
    var local_6: bool;
    if !((a_2.x < b_2.x)) {
        if (a_2.x == b_2.x) {
            local_6 = (a_2.y < b_2.y);
        } else {
            local_6 = false;
        }
        let _e17 = local_6;
        local_5 = _e17;
    } else {
        local_5 = true;
    }
    let ordered = local_5;
    let p_2 = select(b_2, a_2, ordered);
    let q_1 = select(a_2, b_2, ordered);
    let area = ((p_2.x * q_1.y) - (p_2.y * q_1.x));
    return select(-(area), area, ordered);
}

fn enter(i_9: u32, origin: vec3<f32>, inv: vec3<f32>, t_max: f32) -> f32 {
    var local_4: bool;
    let _e4 = box_min(i_9);
    let t0_ = ((_e4 - origin) * inv);
    let _e7 = box_max(i_9);
    let t1_ = ((_e7 - origin) * inv);
    let low_1 = min(t0_, t1_);
    let high_1 = max(t0_, t1_);
    let near = max(max(max(low_1.x, low_1.y), low_1.z), 0f);
    let far = (min(min(high_1.x, high_1.y), high_1.z) * 1.0000005f);
    if ((near * 0.9999995f) <= far) {
        local_4 = ((near * 0.9999995f) < t_max);
    } else {
        local_4 = false;
    }
    let _e36 = local_4;
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

fn first_hit(tri_1: u32, p: vec3<f32>, direction_2: vec3<f32>) -> Met {
    let _e4 = tri_plane(tri_1);
    let _e8 = tri_normal(tri_1);
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

fn invert_cdf(len: u32, v_2: u32) -> Place {
    var low: u32 = 0u;
    var high: u32;
    var local_2: bool;
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
        local_2 = (_e27 < _e28);
    } else {
        local_2 = true;
    }
    let _e31 = local_2;
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

fn lies_on(i_14: u32, origin_2: vec3<f32>, base: vec3<f32>) -> bool {
    var local_14: bool;
    let _e3 = tri_normal(i_14);
    let _e4 = dot3_(_e3, base);
    if (_e4 < -0.99999f) {
        let _e9 = tri_normal(i_14);
        let _e10 = tri_v0_(i_14);
        let _e12 = dot3_(_e9, (_e10 - origin_2));
        local_14 = (abs(_e12) < 0.000001f);
    } else {
        local_14 = false;
    }
    let _e17 = local_14;
    return _e17;
}

fn meet_triangle(i_13: u32, origin_1: vec3<f32>, s_1: Shear, t_max_1: f32) -> Hit {
    var local_7: bool;
    var local_8: bool;
    var local_9: bool;
    var local_10: bool;
    var local_11: bool;
    var local_12: bool;
    var local_13: bool;
    let _e4 = tri_v0_(i_13);
    let _e7 = turned((_e4 - origin_1), s_1.kz);
    let _e8 = tri_v1_(i_13);
    let _e11 = turned((_e8 - origin_1), s_1.kz);
    let _e12 = tri_v2_(i_13);
    let _e15 = turned((_e12 - origin_1), s_1.kz);
    let pa = vec2<f32>((_e7.x - (s_1.sx * _e7.z)), (_e7.y - (s_1.sy * _e7.z)));
    let pb = vec2<f32>((_e11.x - (s_1.sx * _e11.z)), (_e11.y - (s_1.sy * _e11.z)));
    let pc = vec2<f32>((_e15.x - (s_1.sx * _e15.z)), (_e15.y - (s_1.sy * _e15.z)));
    let _e49 = edge(pc, pb);
    let _e50 = edge(pa, pc);
    let _e51 = edge(pb, pa);
    if !((_e49 < 0f)) {
        local_7 = (_e50 < 0f);
    } else {
        local_7 = true;
    }
    let _e60 = local_7;
    if !(_e60) {
        local_8 = (_e51 < 0f);
    } else {
        local_8 = true;
    }
    let _e67 = local_8;
    if _e67 {
        if !((_e49 > 0f)) {
            local_10 = (_e50 > 0f);
        } else {
            local_10 = true;
        }
        let _e78 = local_10;
        if !(_e78) {
            local_11 = (_e51 > 0f);
        } else {
            local_11 = true;
        }
        let _e85 = local_11;
        local_9 = _e85;
    } else {
        local_9 = false;
    }
    let outside = local_9;
    let det = ((_e49 + _e50) + _e51);
    if !(outside) {
        local_12 = (det == 0f);
    } else {
        local_12 = true;
    }
    let _e96 = local_12;
    if _e96 {
        return Hit(t_max_1, NONE, 0f, 0f);
    }
    let t_1 = ((((_e49 * (s_1.sz * _e7.z)) + (_e50 * (s_1.sz * _e11.z))) + (_e51 * (s_1.sz * _e15.z))) / det);
    if (t_1 > 0f) {
        local_13 = (t_1 < t_max_1);
    } else {
        local_13 = false;
    }
    let _e122 = local_13;
    if _e122 {
        return Hit(t_1, i_13, (_e50 / det), (_e51 / det));
    }
    return Hit(t_max_1, NONE, 0f, 0f);
}

fn nonzero(x_5: f32) -> f32 {
    return select(x_5, select(0.00000000000000000001f, -0.00000000000000000001f, (x_5 < 0f)), (abs(x_5) < 0.00000000000000000001f));
}

fn place_in_tile(n: u32, k: u32, a: f32, b: f32) -> vec2<f32> {
    var rows: u32;
    let left = ((n * n) - k);
    rows = u32(ceil(sqrt(f32(left))));
    let _e11 = rows;
    let _e14 = rows;
    let _e17 = rows;
    rows = (_e11 - select(0u, 1u, (((_e14 - 1u) * (_e17 - 1u)) >= left)));
    let _e24 = rows;
    let _e27 = rows;
    let _e28 = rows;
    rows = (_e24 + select(0u, 1u, ((_e27 * _e28) < left)));
    let _e33 = rows;
    let i_16 = (n - _e33);
    let in_row = (k - (i_16 * ((2u * n) - i_16)));
    let j = (in_row / 2u);
    let root = sqrt(a);
    let s_2 = (root * (1f - b));
    let t = (root * b);
    let scale = (1f / f32(n));
    if ((in_row % 2u) == 0u) {
        return vec2<f32>(((f32(i_16) + s_2) * scale), ((f32(j) + t) * scale));
    }
    return vec2<f32>((((f32(i_16) + 1f) - s_2) * scale), (((f32(j) + 1f) - t) * scale));
}

fn position(tri: u32, b1_: f32, b2_: f32) -> vec3<f32> {
    var middle: vec3<f32>;
    let _e3 = tri_v0_(tri);
    let _e4 = tri_v1_(tri);
    let _e5 = tri_v2_(tri);
    let p_1 = ((_e3 + ((_e4 - _e3) * b1_)) + ((_e5 - _e3) * b2_));
    middle = ((_e3 + _e4) * 0.5f);
    middle = (((_e3 + _e4) + _e5) * 0.33333334f);
    let _e20 = middle;
    let d = (_e20 - p_1);
    let _e22 = dot3_(d, d);
    return (p_1 + (d * (0.000001f / max(sqrt(_e22), 0.000002f))));
}

fn scramble(x_2: u32, seed_1: u32) -> u32 {
    let _e3 = laine_karras(reverseBits(x_2), seed_1);
    return reverseBits(_e3);
}

fn shear(direction: vec3<f32>) -> Shear {
    var kz_1: u32 = 2u;
    var local_3: bool;
    let a_4 = abs(direction);
    if (a_4.x > a_4.y) {
        local_3 = (a_4.x > a_4.z);
    } else {
        local_3 = false;
    }
    let _e13 = local_3;
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

fn surface_point(tri_3: u32, b1_2: f32, b2_2: f32) -> Point {
    let _e3 = position(tri_3, b1_2, b2_2);
    let _e4 = tile_of(tri_3, b1_2, b2_2);
    return Point(_e3, tri_3, _e4, 0u, 0f, 0f);
}

fn tangents(n_1: vec3<f32>) -> Tangents {
    let s_3 = select(-1f, 1f, (n_1.z >= 0f));
    let a_3 = (-1f / (s_3 + n_1.z));
    let b_3 = ((n_1.x * n_1.y) * a_3);
    return Tangents(vec3<f32>((1f + (((s_3 * n_1.x) * n_1.x) * a_3)), (s_3 * b_3), (-(s_3) * n_1.x)), vec3<f32>(b_3, (s_3 + ((n_1.y * n_1.y) * a_3)), -(n_1.y)));
}

fn tile_of(tri_2: u32, b1_1: f32, b2_1: f32) -> u32 {
    var local_24: bool;
    let _e3 = tri_split(tri_2);
    let x_7 = (max(b1_1, 0f) * f32(_e3));
    let y = (max(b2_1, 0f) * f32(_e3));
    let i_17 = min(u32(x_7), (_e3 - 1u));
    let j_1 = min(u32(y), ((_e3 - 1u) - i_17));
    if (((x_7 - f32(i_17)) + (y - f32(j_1))) > 1f) {
        local_24 = ((j_1 + 1u) < (_e3 - i_17));
    } else {
        local_24 = false;
    }
    let upper = local_24;
    let _e36 = tri_first_tile(tri_2);
    return (((_e36 + (i_17 * ((2u * _e3) - i_17))) + (2u * j_1)) + select(0u, 1u, upper));
}

fn tri_first_tile(i_2: u32) -> u32 {
    let _e4 = tris[i_2].first_tile;
    return _e4;
}

fn tri_normal(i_6: u32) -> vec3<f32> {
    let _e4 = tris[i_6].normal;
    return _e4;
}

fn tri_plane(i_12: u32) -> u32 {
    let _e4 = tris[i_12].plane;
    return _e4;
}

fn tri_split(i_1: u32) -> u32 {
    let _e4 = tris[i_1].split;
    return _e4;
}

fn tri_v0_(i_3: u32) -> vec3<f32> {
    let _e4 = tris[i_3].v0_;
    return _e4;
}

fn tri_v1_(i_4: u32) -> vec3<f32> {
    let _e4 = tris[i_4].v1_;
    return _e4;
}

fn tri_v2_(i_5: u32) -> vec3<f32> {
    let _e4 = tris[i_5].v2_;
    return _e4;
}

fn turned(v_4: vec3<f32>, kz: u32) -> vec3<f32> {
    return select(select(v_4.xyz, v_4.zxy, (kz == 1u)), v_4.yzx, (kz == 0u));
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
    var i_15: u32;
    var local_15: bool;
    var local_16: bool;
    var met: Hit;
    var local_17: bool;
    var local_18: bool;
    var local_19: bool;
    var local_20: bool;
    var local_21: bool;
    var local_22: bool;
    var local_23: bool;
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
                i_15 = _e41;
                loop {
                    let _e47 = i_15;
                    if (_e47 < (_e41 + _e39)) {
                    } else {
                        break;
                    }
                    {
                        let _e50 = i_15;
                        let _e51 = tri_plane(_e50);
                        if !((_e51 == skip.x)) {
                            local_15 = (_e51 == skip.y);
                        } else {
                            local_15 = true;
                        }
                        let _e60 = local_15;
                        if _e60 {
                            continue;
                        }
                        if ((_e51 & TWIN) != 0u) {
                            let _e67 = i_15;
                            let _e68 = tri_normal(_e67);
                            let _e69 = dot3_(_e68, direction_1);
                            local_16 = (_e69 >= 0f);
                        } else {
                            local_16 = false;
                        }
                        let _e73 = local_16;
                        if _e73 {
                            continue;
                        }
                        met = Hit();
                        let _e76 = i_15;
                        let _e78 = hit.t;
                        let _e79 = meet_triangle(_e76, origin_3, _e6, _e78);
                        met = _e79;
                        let _e81 = met.tri;
                        if (_e81 != NONE) {
                            let _e84 = i_15;
                            let _e85 = tri_normal(_e84);
                            let _e86 = dot3_(_e85, direction_1);
                            if (_e86 < 0f) {
                                let _e92 = met.t;
                                local_17 = ((_e92 * -(_e86)) < 0.000001f);
                            } else {
                                local_17 = false;
                            }
                            let _e98 = local_17;
                            if _e98 {
                                let _e101 = i_15;
                                let _e102 = lies_on(_e101, origin_3, base_1);
                                local_18 = _e102;
                            } else {
                                local_18 = false;
                            }
                            let _e104 = local_18;
                            if _e104 {
                                continue;
                            }
                            let _e106 = met.t;
                            let _e111 = met.t;
                            let behind = select(((t_max_2 - _e106) * -(_e86)), (_e111 * _e86), (_e86 > 0f));
                            if (behind < 0.0000004f) {
                                if !((_e86 > 0f)) {
                                    local_20 = any_hit;
                                } else {
                                    local_20 = true;
                                }
                                let _e126 = local_20;
                                local_19 = _e126;
                            } else {
                                local_19 = false;
                            }
                            let _e128 = local_19;
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
                        let _e132 = i_15;
                        i_15 = (_e132 + 1u);
                    }
                }
                let _e136 = unfinished;
                if !(_e136) {
                    let _e140 = i_15;
                    local_21 = (_e140 < (_e41 + _e39));
                } else {
                    local_21 = true;
                }
                let _e144 = local_21;
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
                            local_22 = (_e166 >= STACK);
                        } else {
                            local_22 = true;
                        }
                        let _e170 = local_22;
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
        local_23 = _e204;
    } else {
        local_23 = true;
    }
    let _e206 = local_23;
    unfinished = _e206;
    let _e207 = hit;
    return _e207;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var local: bool;
    var s: Point;
    var end: Point;
    let _e3 = params.base;
    let _e10 = params.bits;
    let item = (reverseBits((_e3 + gid.x)) >> (32u - _e10));
    let _e16 = params.count;
    if !((gid.x >= _e16)) {
        let _e23 = params.rays;
        local = (item >= _e23);
    } else {
        local = true;
    }
    let _e26 = local;
    if _e26 {
        return;
    }
    let _e29 = params.first;
    let i_18 = (_e29 + item);
    let _e33 = params.seed;
    let _e34 = sobol4_(i_18, _e33);
    let _e37 = params.tiles;
    let _e39 = invert_cdf(_e37, _e34.x);
    let tri_4 = tile_tri[_e39.index];
    let _e44 = tri_split(tri_4);
    let _e46 = tri_first_tile(tri_4);
    let _e50 = unit(_e34.y);
    let _e51 = place_in_tile(_e44, (_e39.index - _e46), _e39.place, _e50);
    let _e54 = position(tri_4, _e51.x, _e51.y);
    let _e55 = tri_normal(tri_4);
    let _e57 = unit(_e34.z);
    let _e59 = unit(_e34.w);
    let _e60 = cosine_direction(_e55, _e57, _e59);
    let _e61 = first_hit(tri_4, _e54, _e60);
    let density = tiles[_e39.index].density;
    let _e69 = params.total;
    let n_3 = f32(_e69);
    s = Point(_e54, tri_4, _e39.index, _e61.kind, 0f, density);
    end = Point(_e60, NONE, NONE, _e61.kind, 0f, 0f);
    if (_e61.kind == FRONT) {
        let _e92 = surface_point(_e61.hit.tri, _e61.hit.b1_, _e61.hit.b2_);
        end = _e92;
        end.kind = _e61.kind;
        let _e98 = end.tile;
        let _e101 = tiles[_e98].density;
        end.density = _e101;
        let _e104 = end.density;
        s.weight = (1f / (n_3 * (density + _e104)));
        let _e111 = s.weight;
        end.weight = _e111;
    } else {
        s.weight = (1f / (n_3 * density));
        let _e121 = atomicAdd((&suspects[0]), 1u);
        atomicStore((&suspects[(1u + _e121)]), item);
    }
    let _e128 = s;
    points[(2u * item)] = _e128;
    let _e135 = end;
    points[((2u * item) + 1u)] = _e135;
    finish();
    return;
}
