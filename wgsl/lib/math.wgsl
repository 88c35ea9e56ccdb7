// Small maths: the twin of src/twin/math.rs, operation by operation.

// Whether the scene lies in flatland: segments in the plane z = 0. Set by the host for each pipeline.
override FLATLAND: bool = false;

const PI: f32 = 3.14159265358979;
const F32_MAX: f32 = 0x1.fffffep+127f;

// Sum in a fixed order, which the built-in does not promise.
fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// lowbias32: a counter into a seed.
fn hash(v: u32) -> u32 {
    var x = v;
    x ^= x >> 16u;
    x *= 0x7feb352du;
    x ^= x >> 15u;
    x *= 0x846ca68bu;
    return x ^ (x >> 16u);
}

// The seed of item i of stream `seed`.
fn seed_of(seed: u32, i: u32) -> u32 {
    return hash(seed ^ hash(i + 0x9e3779b9u));
}

// A u32 as a number in [0, 1), from its upper 24 bits.
fn unit(x: u32) -> f32 {
    return f32(x >> 8u) * (1.0 / 16777216.0);
}

struct Tangents {
    t1: vec3<f32>,
    t2: vec3<f32>,
}

// Two tangents of a unit normal (Duff et al. 2017).
fn tangents(n: vec3<f32>) -> Tangents {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return Tangents(vec3<f32>(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3<f32>(b, s + n.y * n.y * a, -n.y));
}

// (cos, sin) of a turn u in [0, 1), by polynomials.
fn cos_sin_turn(u: f32) -> vec2<f32> {
    let quarter = floor(4.0 * u + 0.5);
    let x = (u - 0.25 * quarter) * (2.0 * PI);
    let x2 = x * x;
    let s = x * (1.0 + x2 * (-1.0 / 6.0 + x2 * (1.0 / 120.0 + x2 * (-1.0 / 5040.0 + x2 * (1.0 / 362880.0)))));
    let c = 1.0 + x2 * (-0.5 + x2 * (1.0 / 24.0 + x2 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0))));
    let q = u32(quarter) & 3u;
    if q == 0u {
        return vec2<f32>(c, s);
    }
    if q == 1u {
        return vec2<f32>(-s, c);
    }
    if q == 2u {
        return vec2<f32>(-c, -s);
    }
    return vec2<f32>(s, -c);
}

// A cosine-distributed direction about n; in flatland within the plane, its sine uniform.
fn cosine_direction(n: vec3<f32>, u: f32, v: f32) -> vec3<f32> {
    if FLATLAND {
        return vec3<f32>(n.y, -n.x, 0.0) * (2.0 * u - 1.0) + n * (2.0 * sqrt(u * (1.0 - u)));
    }
    let t = tangents(n);
    let cs = cos_sin_turn(v);
    let r = sqrt(u);
    let z = sqrt(max(1.0 - u, 0.0));
    return t.t1 * (r * cs.x) + t.t2 * (r * cs.y) + n * z;
}

// G of two cosines at distance r: cos cos / (pi r^2), in flatland cos cos / (2 r).
fn geometric(cos_x: f32, cos_y: f32, r: f32) -> f32 {
    if FLATLAND {
        return (cos_x / r) * cos_y * 0.5;
    }
    return (cos_x / r) * (cos_y / r) / PI;
}

// G(x, y) of both ends' cosines.
fn kernel_g(x: vec3<f32>, nx: vec3<f32>, y: vec3<f32>, ny: vec3<f32>) -> f32 {
    let d = y - x;
    let r2 = dot3(d, d);
    if !(r2 > 0.0) {
        return 0.0;
    }
    let r = sqrt(r2);
    let cos_x = max(dot3(nx, d) / r, 0.0);
    let cos_y = max(-dot3(ny, d) / r, 0.0);
    return geometric(cos_x, cos_y, r);
}
