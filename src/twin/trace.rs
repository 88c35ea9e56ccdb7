//! Ray traversal (`wgsl/lib/ray.wgsl`, pass `trace`): watertight triangles, or flatland's segments, in a binary
//! hierarchy.
//!
//! Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. An edge's sign must
//! come out opposite for the two triangles that share it; a compiler that fuses multiply-adds breaks
//! that, so each edge is evaluated with its ends in a fixed order (`edge`). Planar pieces are
//! excluded by number, never by an offset (design, 5).

use crate::layout::{BvhNode, NONE, Point, TWIN, Tri};
use crate::scene::Geometry;
use glam::Vec3;

/// Depth of the traversal stack; a deeper hierarchy raises an error before any ray is shot.
pub const STACK: usize = 48;
/// A point behind a plane by less than this is on it, local: rounding has moved it there. Some six units in the last place
/// of the largest coordinate; walls thinner than twice this cannot be told from sheets.
pub const BEHIND: f32 = 4e-7;
/// Surfaces this close, face to face or back to back, lie on one another.
const CONTACT: f32 = 1e-6;
/// Cosine of normals below which they look opposite ways.
const OPPOSED: f32 = -0.99999;
/// How far points of a triangle are moved towards its middle, local: farther than rounding can move them over an edge.
pub const INWARD: f32 = 1e-6;

/// A ray `origin + t direction`, 0 < t < t_max, that ignores two planar pieces.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin, local.
    pub origin: Vec3,
    /// Direction, any length.
    pub direction: Vec3,
    /// Upper end of t.
    pub t_max: f32,
    /// Pieces that are not met ([`NONE`]: nothing is skipped).
    pub skip: [u32; 2],
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the direction's length.
    pub t: f32,
    /// Triangle, or [`NONE`].
    pub tri: u32,
    /// Barycentric coordinate of the second vertex.
    pub b1: f32,
    /// Barycentric coordinate of the third vertex.
    pub b2: f32,
}

impl Hit {
    /// No hit before `t`.
    pub fn none(t: f32) -> Hit {
        Hit { t, tri: NONE, b1: 0.0, b2: 0.0 }
    }
}

/// The shear that maps a direction to +z, and the axis order that keeps it well conditioned.
#[derive(Clone, Copy)]
struct Shear {
    kx: usize,
    ky: usize,
    kz: usize,
    s: Vec3,
}

fn shear(d: Vec3) -> Shear {
    let a = d.abs();
    let kz = if a.x > a.y && a.x > a.z {
        0
    } else if a.y > a.z {
        1
    } else {
        2
    };
    let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
    Shear { kx, ky, kz, s: Vec3::new(d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]) }
}

/// Twice the signed area of (0, a, b), the same bits but for the sign if a and b swap.
fn edge(ax: f32, ay: f32, bx: f32, by: f32) -> f32 {
    let ordered = ax < bx || (ax == bx && ay < by);
    let (px, py, qx, qy) = if ordered { (ax, ay, bx, by) } else { (bx, by, ax, ay) };
    let area = px * qy - py * qx;
    if ordered { area } else { -area }
}

fn intersect(tri: &Tri, origin: Vec3, sh: &Shear, t_max: f32) -> Option<(f32, f32, f32)> {
    let a = Vec3::from(tri.v0) - origin;
    let b = Vec3::from(tri.v1) - origin;
    let c = Vec3::from(tri.v2) - origin;
    let (ax, ay) = (a[sh.kx] - sh.s.x * a[sh.kz], a[sh.ky] - sh.s.y * a[sh.kz]);
    let (bx, by) = (b[sh.kx] - sh.s.x * b[sh.kz], b[sh.ky] - sh.s.y * b[sh.kz]);
    let (cx, cy) = (c[sh.kx] - sh.s.x * c[sh.kz], c[sh.ky] - sh.s.y * c[sh.kz]);
    let (u, v, w) = (edge(cx, cy, bx, by), edge(ax, ay, cx, cy), edge(bx, by, ax, ay));
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let det = u + v + w;
    if det == 0.0 {
        return None;
    }
    let t = (u * (sh.s.z * a[sh.kz]) + v * (sh.s.z * b[sh.kz]) + w * (sh.s.z * c[sh.kz])) / det;
    if t > 0.0 && t < t_max { Some((t, v / det, w / det)) } else { None }
}

/// A segment in the plane: a ray passes it where both ends lie strictly on one side. An end that two segments share
/// gives both the same bits, so nothing passes between them.
fn intersect_segment(tri: &Tri, origin: Vec3, d: Vec3, t_max: f32) -> Option<(f32, f32, f32)> {
    let a = Vec3::from(tri.v0) - origin;
    let b = Vec3::from(tri.v1) - origin;
    let (fa, fb) = (d.x * a.y - d.y * a.x, d.x * b.y - d.y * b.x);
    let det = fa - fb;
    if (fa < 0.0 && fb < 0.0) || (fa > 0.0 && fb > 0.0) || det == 0.0 {
        return None;
    }
    let along = d.x * d.x + d.y * d.y;
    let (ta, tb) = ((d.x * a.x + d.y * a.y) / along, (d.x * b.x + d.y * b.y) / along);
    let t = (fa * tb - fb * ta) / det;
    if t > 0.0 && t < t_max { Some((t, fa / det, 0.0)) } else { None }
}

/// 1/d with zeros replaced, so that slabs never see 0 * inf (hard case D07).
fn safe_inverse(d: Vec3) -> Vec3 {
    let f = |x: f32| 1.0 / if x.abs() < 1e-20 { if x < 0.0 { -1e-20 } else { 1e-20 } } else { x };
    Vec3::new(f(d.x), f(d.y), f(d.z))
}

/// Entry distance into a box, or `f32::MAX`; widened by 4 ulp so that rounding never loses a box.
fn enter(node: &BvhNode, origin: Vec3, inv: Vec3, t_max: f32) -> f32 {
    let t0 = (Vec3::from(node.min) - origin) * inv;
    let t1 = (Vec3::from(node.max) - origin) * inv;
    let near = t0.min(t1).max_element().max(0.0);
    let far = t0.max(t1).min_element() * 1.0000005;
    if near * 0.9999995 <= far && near * 0.9999995 < t_max { near } else { f32::MAX }
}

/// Whether a triangle lies on the surface of normal `base` that a ray starts on, looking the other way: a box's bottom on the
/// floor, or the other side of a sheet. The ray leaves it behind, whichever side of the start rounding puts it on.
fn lies_on(tri: &Tri, origin: Vec3, base: Vec3) -> bool {
    let n = Vec3::from(tri.normal);
    n.dot(base) < OPPOSED && n.dot(Vec3::from(tri.v0) - origin).abs() < CONTACT
}

/// Walks the hierarchy; `any` stops at the first hit. `base`: the normal of the surface that the ray starts on, or 0.
fn walk(geometry: &Geometry, ray: &Ray, any: bool, base: Vec3) -> Hit {
    let (nodes, tris) = (&geometry.nodes, &geometry.tris);
    let sh = shear(ray.direction);
    let inv = safe_inverse(ray.direction);
    let mut hit = Hit::none(ray.t_max);
    let mut stack = [0u32; STACK];
    let mut top = 0;
    let mut at = 0u32;
    if enter(&nodes[0], ray.origin, inv, hit.t) == f32::MAX {
        return hit;
    }
    loop {
        let node = &nodes[at as usize];
        if node.count > 0 {
            for i in node.first..node.first + node.count {
                let tri = &tris[i as usize];
                if tri.plane == ray.skip[0] || tri.plane == ray.skip[1] {
                    continue;
                }
                // Of two that coincide only the one in front is there: no rounding decides between them.
                if tri.plane & TWIN != 0 && Vec3::from(tri.normal).dot(ray.direction) >= 0.0 {
                    continue;
                }
                let met = if geometry.flatland {
                    intersect_segment(tri, ray.origin, ray.direction, hit.t)
                } else {
                    intersect(tri, ray.origin, &sh, hit.t)
                };
                if let Some((t, b1, b2)) = met {
                    // The start, and the end of a segment, may lie behind the planes beside them by their rounding.
                    let across = Vec3::from(tri.normal).dot(ray.direction);
                    if across < 0.0 && t * -across < CONTACT && lies_on(tri, ray.origin, base) {
                        continue;
                    }
                    let behind = if across > 0.0 { t * across } else { (ray.t_max - t) * -across };
                    if behind < BEHIND && (across > 0.0 || any) {
                        continue;
                    }
                    if geometry.cut && !super::texture::is_there(geometry, i, b1, b2) {
                        continue;
                    }
                    hit = Hit { t, tri: i, b1, b2 };
                    if any {
                        return hit;
                    }
                }
            }
        } else {
            // Go to the nearer child, keep the farther.
            let near0 = enter(&nodes[node.first as usize], ray.origin, inv, hit.t);
            let near1 = enter(&nodes[node.first as usize + 1], ray.origin, inv, hit.t);
            let first = if near0 <= near1 { node.first } else { node.first + 1 };
            let (a, b) = if near0 <= near1 { (near0, near1) } else { (near1, near0) };
            if a < f32::MAX {
                if b < f32::MAX {
                    stack[top] = 2 * node.first + 1 - first;
                    top += 1;
                }
                at = first;
                continue;
            }
        }
        if top == 0 {
            return hit;
        }
        top -= 1;
        at = stack[top];
    }
}

/// The nearest triangle a ray meets, from either side.
pub fn closest(geometry: &Geometry, ray: &Ray) -> Hit {
    walk(geometry, ray, false, Vec3::ZERO)
}

/// The same of a ray that starts on a surface of this normal, and so meets nothing that lies on it.
pub fn closest_from(geometry: &Geometry, ray: &Ray, normal: Vec3) -> Hit {
    walk(geometry, ray, false, normal)
}

/// Whether anything stands in a ray's way.
pub fn occluded(geometry: &Geometry, ray: &Ray) -> bool {
    walk(geometry, ray, true, Vec3::ZERO).tri != NONE
}

/// Whether the open segment from `a` to `b` is blocked, `skip` apart; in a convex scene none can be.
pub fn segment_blocked(geometry: &Geometry, a: Vec3, b: Vec3, skip: [u32; 2]) -> bool {
    geometry.occludes && occluded(geometry, &Ray { origin: a, direction: b - a, t_max: 1.0, skip })
}

/// Whether anything stands in the way from a point of triangle `tri`, up to `t_max` times the direction's length. In a
/// convex scene, too: what comes from without may be blocked by a closed room's wall.
pub fn ray_blocked(geometry: &Geometry, tri: &Tri, p: Vec3, direction: Vec3, t_max: f32) -> bool {
    let ray = Ray { origin: p, direction, t_max, skip: [tri.plane, NONE] };
    walk(geometry, &ray, true, Vec3::from(tri.normal)).tri != NONE
}

/// The tile of a triangle that holds barycentric coordinates (b1, b2). Rows run along b1; row i has
/// `2(split - i) - 1` tiles, lower and upper triangles in turn. In flatland tiles follow one another along the segment.
pub fn tile_of(flatland: bool, tri: &Tri, b1: f32, b2: f32) -> u32 {
    let n = tri.cuts();
    if flatland {
        return tri.first_tile + ((b1.max(0.0) * n as f32) as u32).min(n - 1);
    }
    let (x, y) = (b1.max(0.0) * n as f32, b2.max(0.0) * n as f32);
    let i = (x as u32).min(n - 1);
    let j = (y as u32).min(n - 1 - i);
    let upper = (x - i as f32) + (y - j as f32) > 1.0 && j + 1 < n - i;
    tri.first_tile + i * (2 * n - i) + 2 * j + upper as u32
}

/// Barycentric coordinates (b1, b2) of a place (a, b) in [0,1)^2 of tile `k` of a triangle, or segment, cut `n` times.
pub fn place_in_tile(flatland: bool, n: u32, k: u32, a: f32, b: f32) -> (f32, f32) {
    if flatland {
        return ((k as f32 + a) * (1.0 / n as f32), 0.0);
    }
    // Row i holds indices i(2n - i) onwards, so (n - i)^2 = n^2 - k at its start.
    let i = n - ((n * n - k) as f32).sqrt().ceil() as u32;
    let in_row = k - i * (2 * n - i);
    let j = in_row / 2;
    let root = a.sqrt();
    let (s, t) = (root * (1.0 - b), root * b);
    let scale = 1.0 / n as f32;
    if in_row.is_multiple_of(2) {
        ((i as f32 + s) * scale, (j as f32 + t) * scale)
    } else {
        ((i as f32 + 1.0 - s) * scale, (j as f32 + 1.0 - t) * scale)
    }
}

/// Barycentric coordinates (b1, b2) of a uniform place (a, b) in [0,1)^2 of a triangle or segment.
pub fn place_on(flatland: bool, a: f32, b: f32) -> (f32, f32) {
    if flatland {
        return (a, 0.0);
    }
    let root = a.sqrt();
    (root * (1.0 - b), root * b)
}

/// The position of barycentric coordinates on a triangle, to the last digit.
pub fn corner_position(tri: &Tri, b1: f32, b2: f32) -> Vec3 {
    let v0 = Vec3::from(tri.v0);
    v0 + (Vec3::from(tri.v1) - v0) * b1 + (Vec3::from(tri.v2) - v0) * b2
}

/// The position of barycentric coordinates on a triangle, off its edges by more than rounding.
pub fn position(flatland: bool, tri: &Tri, b1: f32, b2: f32) -> Vec3 {
    inward(flatland, tri, corner_position(tri, b1, b2))
}

/// A point of a triangle moved towards its middle by [`INWARD`]: a point that rounding has put beyond an edge, and so
/// behind a wall that stands there, would see what is on the other side.
pub fn inward(flatland: bool, tri: &Tri, p: Vec3) -> Vec3 {
    let (a, b, c) = (Vec3::from(tri.v0), Vec3::from(tri.v1), Vec3::from(tri.v2));
    let middle = if flatland { (a + b) * 0.5 } else { (a + b + c) * (1.0 / 3.0) };
    let d = middle - p;
    p + d * (INWARD / d.dot(d).sqrt().max(2.0 * INWARD))
}

/// Barycentric coordinates of a position on a triangle (least squares, f64 where it costs nothing).
pub fn barycentric(flatland: bool, tri: &Tri, p: Vec3) -> (f32, f32) {
    let v0 = Vec3::from(tri.v0).as_dvec3();
    let (e1, e2, d) = (Vec3::from(tri.v1).as_dvec3() - v0, Vec3::from(tri.v2).as_dvec3() - v0, p.as_dvec3() - v0);
    let (a, b, c, f, g) = (e1.dot(e1), e1.dot(e2), e2.dot(e2), e1.dot(d), e2.dot(d));
    if flatland {
        return ((f / a) as f32, 0.0);
    }
    let det = a * c - b * b;
    (((c * f - b * g) / det) as f32, ((a * g - b * f) / det) as f32)
}

/// A surface point from barycentric coordinates, with its tile; `kind`, `weight` and `density` are left 0.
pub fn surface_point(geometry: &Geometry, tri: u32, b1: f32, b2: f32) -> Point {
    let t = &geometry.tris[tri as usize];
    Point {
        p: position(geometry.flatland, t, b1, b2).to_array(),
        tri,
        tile: tile_of(geometry.flatland, t, b1, b2),
        ..Point::default()
    }
}
