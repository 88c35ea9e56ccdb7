// What varies over a triangle: reflectance, emission, and what is cut out. Twin: src/twin/texture.rs, which tells how texels
// are laid out. The kernel binds `texels: texture_2d_array<u32>`, and triangles and materials as lib/ray.wgsl and its own
// passes ask for.
#import layout
#import triangles
#import math

// Whether reflectance or emission varies over any triangle, and whether any is cut out. Set by the host.
override TEXTURES: bool = false;
override CUTOUTS: bool = false;

const RECORD = 6u; // texels of a triangle's maps
const RHO = 0u; // maps by their place in it
const EMIT = 1u;
const MASK = 2u;
const SIDE = 0x7fffu; // bits of an image's side
const CLAMP = 0x8000u; // the bit that says that it is clamped to its edge

fn texel(t: u32) -> vec4<u32> {
    return textureLoad(texels, vec2<u32>(t % ROW, t / ROW % ROW), t / (ROW * ROW), 0);
}

// A map at a place of a triangle.
struct MapPlace {
    at: u32, // first texel of the image, or NONE
    size: u32, // width, and height from bit 16 on
    u: f32,
    v: f32,
}

fn map_place(tri: u32, slot: u32, b: vec2<f32>) -> MapPlace {
    let first = RECORD * tri + 2u * slot;
    let p = bitcast<vec4<f32>>(texel(first));
    let rest = texel(first + 1u);
    let u2 = bitcast<f32>(rest.x);
    let v2 = bitcast<f32>(rest.y);
    return MapPlace(rest.z, rest.w, p.x + (p.z - p.x) * b.x + (u2 - p.x) * b.y, p.y + (p.w - p.y) * b.x + (v2 - p.y) * b.y);
}

// The two texels beside a coordinate, and the share of the second.
struct Beside {
    low: u32,
    high: u32,
    share: f32,
}

fn beside(u: f32, side: u32) -> Beside {
    let n = i32(side & SIDE);
    var x = u * f32(n) - 0.5;
    if (side & CLAMP) != 0u {
        x = min(max(x, -0.5), f32(n) - 0.5);
        let low = floor(x);
        let i = i32(low);
        return Beside(u32(max(i, 0)), u32(min(i + 1, n - 1)), x - low);
    }
    let low = floor(x);
    let i = (i32(low) % n + n) % n;
    return Beside(u32(i), u32(select(i + 1, 0, i + 1 == n)), x - low);
}

// The texel that holds a coordinate.
fn nearest_texel(u: f32, side: u32) -> u32 {
    let n = i32(side & SIDE);
    let x = u * f32(n);
    if (side & CLAMP) != 0u {
        return u32(min(max(x, 0.0), f32(n) - 1.0));
    }
    return u32((i32(floor(x)) % n + n) % n);
}

// An image between its texels.
fn bilinear(p: MapPlace) -> vec3<f32> {
    let x = beside(p.u, p.size);
    let y = beside(p.v, p.size >> 16u);
    let top = p.at + y.low * (p.size & SIDE);
    let bottom = p.at + y.high * (p.size & SIDE);
    let upper = bitcast<vec3<f32>>(texel(top + x.low).xyz) * (1.0 - x.share) + bitcast<vec3<f32>>(texel(top + x.high).xyz) * x.share;
    let lower =
        bitcast<vec3<f32>>(texel(bottom + x.low).xyz) * (1.0 - x.share) + bitcast<vec3<f32>>(texel(bottom + x.high).xyz) * x.share;
    return upper * (1.0 - y.share) + lower * y.share;
}

// Whether a triangle has a map of a sort.
fn has_map(tri: u32, slot: u32) -> bool {
    return texel(RECORD * tri + 2u * slot + 1u).z != NONE;
}

// What a map makes of a value of the material at barycentric coordinates.
fn mapped(plain: vec3<f32>, tri: u32, slot: u32, b: vec2<f32>) -> vec3<f32> {
    let p = map_place(tri, slot, b);
    if p.at == NONE {
        return plain;
    }
    return bilinear(p);
}

// Whether a triangle is there at barycentric coordinates: not cut out.
fn is_there(tri: u32, b: vec2<f32>) -> bool {
    let p = map_place(tri, MASK, b);
    if p.at == NONE {
        return true;
    }
    let bit = nearest_texel(p.v, p.size >> 16u) * (p.size & SIDE) + nearest_texel(p.u, p.size);
    let word = texel(p.at + bit / 128u)[bit / 32u % 4u];
    return (word >> (bit % 32u) & 1u) == 1u;
}

// Barycentric coordinates of a position on a triangle: shares of its area.
fn shares(tri: u32, p: vec3<f32>) -> vec2<f32> {
    let v0 = tri_v0(tri);
    let e1 = tri_v1(tri) - v0;
    let e2 = tri_v2(tri) - v0;
    let d = p - v0;
    if FLATLAND {
        return vec2<f32>(clamp(dot3(d, e1) / dot3(e1, e1), 0.0, 1.0), 0.0);
    }
    let n = tri_normal(tri);
    let all = max(dot3(cross(e1, e2), n), 1e-30);
    let b1 = clamp(dot3(cross(d, e2), n) / all, 0.0, 1.0);
    let b2 = clamp(dot3(cross(e1, d), n) / all, 0.0, 1.0 - b1);
    return vec2<f32>(b1, b2);
}
