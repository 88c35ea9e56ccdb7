// Points on triangles and what their rays meet: the rest of src/twin/trace.rs, and the helpers of
// src/twin/emit.rs. The kernel binds what lib/ray.wgsl asks for.
#import ray
#import way

// The tile of a triangle, or flatland segment, that holds barycentric coordinates.
fn tile_of(tri: u32, b1: f32, b2: f32) -> u32 {
    let n = tri_split(tri);
    if FLATLAND {
        return tri_first_tile(tri) + min(u32(max(b1, 0.0) * f32(n)), n - 1u);
    }
    let x = max(b1, 0.0) * f32(n);
    let y = max(b2, 0.0) * f32(n);
    let i = min(u32(x), n - 1u);
    let j = min(u32(y), n - 1u - i);
    let upper = (x - f32(i)) + (y - f32(j)) > 1.0 && j + 1u < n - i;
    return tri_first_tile(tri) + i * (2u * n - i) + 2u * j + select(0u, 1u, upper);
}

// Barycentric coordinates of a place (a, b) in [0,1)^2 of tile k of a triangle, or segment, cut n times.
fn place_in_tile(n: u32, k: u32, a: f32, b: f32) -> vec2<f32> {
    if FLATLAND {
        return vec2<f32>((f32(k) + a) * (1.0 / f32(n)), 0.0);
    }
    // Row i starts at i(2n - i): n - i is the root of n^2 - k rounded up, exactly.
    let left = n * n - k;
    var rows = u32(ceil(sqrt(f32(left))));
    rows -= select(0u, 1u, (rows - 1u) * (rows - 1u) >= left);
    rows += select(0u, 1u, rows * rows < left);
    let i = n - rows;
    let in_row = k - i * (2u * n - i);
    let j = in_row / 2u;
    let root = sqrt(a);
    let s = root * (1.0 - b);
    let t = root * b;
    let scale = 1.0 / f32(n);
    if in_row % 2u == 0u {
        return vec2<f32>((f32(i) + s) * scale, (f32(j) + t) * scale);
    }
    return vec2<f32>((f32(i) + 1.0 - s) * scale, (f32(j) + 1.0 - t) * scale);
}

// Barycentric coordinates of a uniform place (a, b) in [0,1)^2 of a triangle or segment.
fn place_on(a: f32, b: f32) -> vec2<f32> {
    if FLATLAND {
        return vec2<f32>(a, 0.0);
    }
    let root = sqrt(a);
    return vec2<f32>(root * (1.0 - b), root * b);
}

// How far points of a triangle are moved towards its middle: farther than rounding can move them over an edge.
const INWARD = 1e-6;

fn position(tri: u32, b1: f32, b2: f32) -> vec3<f32> {
    let v0 = tri_v0(tri);
    let v1 = tri_v1(tri);
    let v2 = tri_v2(tri);
    let p = v0 + (v1 - v0) * b1 + (v2 - v0) * b2;
    var middle = (v0 + v1) * 0.5;
    if !FLATLAND {
        middle = (v0 + v1 + v2) * (1.0 / 3.0);
    }
    let d = middle - p;
    return p + d * (INWARD / max(sqrt(dot3(d, d)), 2.0 * INWARD));
}

// A surface point with its tile; kind, weight and density are left 0.
fn surface_point(tri: u32, b1: f32, b2: f32) -> Point {
    return Point(position(tri, b1, b2), tri, tile_of(tri, b1, b2), 0u, 0.0, 0.0);
}

struct Met {
    kind: u32,
    hit: Hit,
}

// What a ray from a point on triangle `tri` meets, along mirrors.
fn first_hit(tri: u32, p: vec3<f32>, direction: vec3<f32>) -> Met {
    if LOSSY {
        return along(tri, p, direction);
    }
    let hit = walk(p, direction, F32_MAX, vec2<u32>(tri_plane(tri), NONE), false, tri_normal(tri));
    if hit.tri == NONE {
        return Met(SKY, hit);
    }
    if dot3(tri_normal(hit.tri), direction) < 0.0 {
        return Met(FRONT, hit);
    }
    return Met(BACK, hit);
}
