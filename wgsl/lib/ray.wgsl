// Traversal: the twin of src/twin/trace.rs. The kernel binds `bvh: array<BvhNode>`, `tris: array<Tri>` and `texels`.
#import layout
#import boxes
#import triangles
#import math
#import texture
#import finish

// Depth of the stack; the host refuses deeper hierarchies.
const STACK = 48u;
// A point behind a plane by less than this is on it: rounding has moved it there.
const BEHIND = 4e-7;
// Surfaces this close, face to face or back to back, lie on one another.
const CONTACT = 1e-6;
const OPPOSED = -0.99999;

struct Hit {
    t: f32, // in units of the direction's length
    tri: u32, // or NONE
    b1: f32,
    b2: f32,
}

// The axes turned so that axis kz comes last.
fn turned(v: vec3<f32>, kz: u32) -> vec3<f32> {
    return select(select(v.xyz, v.zxy, kz == 1u), v.yzx, kz == 0u);
}

// Twice the signed area of (0, a, b), the same bits but for the sign if a and b swap. The ends are put in order first, so that
// there is one difference of products: of two, drivers fuse one multiply-add each, not the same, and rays slip through.
fn edge(a: vec2<f32>, b: vec2<f32>) -> f32 {
    let ordered = a.x < b.x || (a.x == b.x && a.y < b.y);
    let p = select(b, a, ordered);
    let q = select(a, b, ordered);
    let area = p.x * q.y - p.y * q.x;
    return select(-area, area, ordered);
}

fn nonzero(x: f32) -> f32 {
    return select(x, select(1e-20, -1e-20, x < 0.0), abs(x) < 1e-20);
}

// Entry distance into a box, or F32_MAX; widened by 4 ulp so that rounding never loses a box.
fn enter(i: u32, origin: vec3<f32>, inv: vec3<f32>, t_max: f32) -> f32 {
    let t0 = (box_min(i) - origin) * inv;
    let t1 = (box_max(i) - origin) * inv;
    let low = min(t0, t1);
    let high = max(t0, t1);
    let near = max(max(max(low.x, low.y), low.z), 0.0);
    let far = min(min(high.x, high.y), high.z) * 1.0000005;
    return select(F32_MAX, near, near * 0.9999995 <= far && near * 0.9999995 < t_max);
}

// The frame of a ray in which it meets triangles: the direction sheared to +z, its largest axis last.
struct Shear {
    kz: u32,
    sx: f32,
    sy: f32,
    sz: f32,
}

fn shear(direction: vec3<f32>) -> Shear {
    let a = abs(direction);
    var kz = 2u;
    if a.x > a.y && a.x > a.z {
        kz = 0u;
    } else if a.y > a.z {
        kz = 1u;
    }
    let d = turned(direction, kz);
    return Shear(kz, d.x / d.z, d.y / d.z, 1.0 / d.z);
}

// Where a ray meets triangle i before t_max, or NONE.
fn meet_triangle(i: u32, origin: vec3<f32>, s: Shear, t_max: f32) -> Hit {
    let va = turned(tri_v0(i) - origin, s.kz);
    let vb = turned(tri_v1(i) - origin, s.kz);
    let vc = turned(tri_v2(i) - origin, s.kz);
    let pa = vec2<f32>(va.x - s.sx * va.z, va.y - s.sy * va.z);
    let pb = vec2<f32>(vb.x - s.sx * vb.z, vb.y - s.sy * vb.z);
    let pc = vec2<f32>(vc.x - s.sx * vc.z, vc.y - s.sy * vc.z);
    let u = edge(pc, pb);
    let v = edge(pa, pc);
    let w = edge(pb, pa);
    let outside = (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0);
    let det = u + v + w;
    if outside || det == 0.0 {
        return Hit(t_max, NONE, 0.0, 0.0);
    }
    let t = (u * (s.sz * va.z) + v * (s.sz * vb.z) + w * (s.sz * vc.z)) / det;
    if t > 0.0 && t < t_max {
        return Hit(t, i, v / det, w / det);
    }
    return Hit(t_max, NONE, 0.0, 0.0);
}

// The same of flatland's segment i: the ray passes it where both ends lie strictly on one side.
fn meet_segment(i: u32, origin: vec3<f32>, d: vec3<f32>, t_max: f32) -> Hit {
    let a = tri_v0(i) - origin;
    let b = tri_v1(i) - origin;
    let fa = d.x * a.y - d.y * a.x;
    let fb = d.x * b.y - d.y * b.x;
    let det = fa - fb;
    if (fa < 0.0 && fb < 0.0) || (fa > 0.0 && fb > 0.0) || det == 0.0 {
        return Hit(t_max, NONE, 0.0, 0.0);
    }
    let along = d.x * d.x + d.y * d.y;
    let ta = (d.x * a.x + d.y * a.y) / along;
    let tb = (d.x * b.x + d.y * b.y) / along;
    let t = (fa * tb - fb * ta) / det;
    if t > 0.0 && t < t_max {
        return Hit(t, i, fa / det, 0.0);
    }
    return Hit(t_max, NONE, 0.0, 0.0);
}

// Whether triangle i lies on the surface of normal `base` that a ray starts on, looking the other way: a box's bottom on the
// floor, or the other side of a sheet. The ray leaves it behind, whichever side of the start rounding puts it on.
fn lies_on(i: u32, origin: vec3<f32>, base: vec3<f32>) -> bool {
    return dot3(tri_normal(i), base) < OPPOSED && abs(dot3(tri_normal(i), tri_v0(i) - origin)) < CONTACT;
}

// Walks the hierarchy, ignoring two planar pieces; `any` stops at the first hit. `base`: the normal of the surface that the ray
// starts on, or 0.
fn walk(origin: vec3<f32>, direction: vec3<f32>, t_max: f32, skip: vec2<u32>, any_hit: bool, base: vec3<f32>) -> Hit {
    let frame = shear(direction);
    let inv = vec3<f32>(1.0 / nonzero(direction.x), 1.0 / nonzero(direction.y), 1.0 / nonzero(direction.z));

    var hit = Hit(t_max, NONE, 0.0, 0.0);
    var stack: array<u32, STACK>;
    var top = 0u;
    var at = 0u;
    var open = enter(0u, origin, inv, hit.t) < F32_MAX;
    while open {
        let count = box_count(at);
        let first = box_first(at);
        var pop = true;
        if count > 0u {
            var i = first;
            for (; i < first + count; i++) {
                let plane = tri_plane(i);
                if plane == skip.x || plane == skip.y {
                    continue;
                }
                // Of two that coincide only the one in front is there: no rounding decides between them.
                if (plane & TWIN) != 0u && dot3(tri_normal(i), direction) >= 0.0 {
                    continue;
                }
                var met: Hit;
                if FLATLAND {
                    met = meet_segment(i, origin, direction, hit.t);
                } else {
                    met = meet_triangle(i, origin, frame, hit.t);
                }
                if met.tri != NONE {
                    // The start, and the end of a segment, may lie behind the planes beside them by their rounding.
                    let across = dot3(tri_normal(i), direction);
                    if across < 0.0 && met.t * -across < CONTACT && lies_on(i, origin, base) {
                        continue;
                    }
                    let behind = select((t_max - met.t) * -across, met.t * across, across > 0.0);
                    if behind < BEHIND && (across > 0.0 || any_hit) {
                        continue;
                    }
                    if CUTOUTS {
                        if !is_there(i, vec2<f32>(met.b1, met.b2)) {
                            continue;
                        }
                    }
                    hit = met;
                    if any_hit {
                        return hit;
                    }
                }
            }
            unfinished = unfinished || i < first + count;
        } else {
            // Go to the nearer child, keep the farther.
            let near0 = enter(first, origin, inv, hit.t);
            let near1 = enter(first + 1u, origin, inv, hit.t);
            let swap = near0 > near1;
            let far = max(near0, near1);
            if min(near0, near1) < F32_MAX {
                if far < F32_MAX {
                    unfinished = unfinished || top >= STACK;
                    stack[min(top, STACK - 1u)] = select(first + 1u, first, swap);
                    top++;
                }
                at = select(first, first + 1u, swap);
                pop = false;
            }
        }
        if pop {
            if top == 0u {
                open = false;
            } else {
                top--;
                at = stack[min(top, STACK - 1u)];
            }
        }
    }
    // Left early by the driver.
    unfinished = unfinished || open;
    return hit;
}

// Whether anything may stand between two points that face each other; the host knows convex scenes.
override OCCLUSION: bool = true;

// Whether the open segment from a to b is blocked, two pieces apart.
fn segment_blocked(a: vec3<f32>, b: vec3<f32>, skip: vec2<u32>) -> bool {
    if !OCCLUSION {
        return false;
    }
    return walk(a, b - a, 1.0, skip, true, vec3<f32>()).tri != NONE;
}
