// The way of a ray: along ideal mirrors to what is no mirror, through an absorbing medium. Twin: src/twin/way.rs.
#import surface
#import medium

// Whether there are mirrors.
override MIRRORS: bool = false;

const MOST_MIRRORS = 64u; // on a way
const LEAST = 1e-4; // product of reflectances below which a way is given up
const REFLECTS = 0x100000u; // a triangle's split from here on is a mirror's reflectance

struct Way {
    direction: vec3<f32>, // on arrival
    mirrors: u32, // that it met
    share: f32, // T: what of the light arrives
    mirrored: f32, // what mirrors took
}

// The way of the ray that was traced last, where light is lost on it.
var<private> way: Way;

// Reflectance of a mirror; 0: none.
fn tri_mirror(i: u32) -> f32 {
    let bits = tri_split(i);
    if bits < REFLECTS {
        return 0.0;
    }
    return bitcast<f32>(bits);
}

// How far it is along one axis to where an interval ends.
fn side_out(p: f32, d: f32, low: f32, high: f32) -> f32 {
    if abs(d) > 1e-20 {
        return (select(low, high, d > 0.0) - p) / d;
    }
    return F32_MAX;
}

// How far it is in a direction to where the scene's bounding box ends.
fn way_out(p: vec3<f32>, d: vec3<f32>) -> f32 {
    let low = box_min(0u);
    let high = box_max(0u);
    let x = side_out(p.x, d.x, low.x, high.x);
    let y = side_out(p.y, d.y, low.y, high.y);
    let z = side_out(p.z, d.z, low.z, high.z);
    return max(min(min(x, y), z), 0.0);
}

// Where a way goes on from a mirror: `position`, once more. A hack: shared, it would come before `first_hit` in every
// kernel, and naga numbers the names of all arguments by the order of their functions.
fn mirror_place(mirror: u32, u: f32, v: f32) -> vec3<f32> {
    let v0 = tri_v0(mirror);
    let v1 = tri_v1(mirror);
    let v2 = tri_v2(mirror);
    let p = v0 + (v1 - v0) * u + (v2 - v0) * v;
    var middle = (v0 + v1) * 0.5;
    if !FLATLAND {
        middle = (v0 + v1 + v2) * (1.0 / 3.0);
    }
    let d = middle - p;
    return p + d * (INWARD / max(sqrt(dot3(d, d)), 2.0 * INWARD));
}

// Follows a direction from a point of a triangle.
fn along(start: u32, p: vec3<f32>, direction: vec3<f32>) -> Met {
    var at = p;
    var left = start;
    var length = 0.0;
    var gloss = 1.0;
    var met = Met(SKY, Hit(F32_MAX, NONE, 0.0, 0.0));
    way = Way(direction, 0u, 1.0, 0.0);
    var going = true;
    for (var trip = 0u; going && trip < MOST_MIRRORS; trip++) {
        let hit = walk(at, way.direction, F32_MAX, vec2<u32>(tri_plane(left), NONE), false, tri_normal(left));
        if SIGMA > 0.0 {
            var leg = hit.t;
            if hit.tri == NONE {
                leg = way_out(at, way.direction);
            }
            way.share *= fade(SIGMA * leg);
        }
        going = false;
        if hit.tri != NONE {
            let across = dot3(tri_normal(hit.tri), way.direction);
            length += hit.t;
            var mirror = 0.0;
            if MIRRORS {
                mirror = tri_mirror(hit.tri);
            }
            if across >= 0.0 || mirror <= 0.0 {
                met = Met(select(BACK, FRONT, across < 0.0), Hit(length, hit.tri, hit.b1, hit.b2));
            } else if MIRRORS {
                // Reflect, unless next to nothing is left.
                way.mirrors++;
                gloss *= mirror;
                let on = way.share * mirror;
                way.mirrored += way.share - on;
                way.share = on;
                if gloss < LEAST || way.mirrors == MOST_MIRRORS {
                    met.kind = LOST;
                    way.mirrored += way.share;
                    way.share = 0.0;
                } else {
                    going = true;
                    at = mirror_place(hit.tri, hit.b1, hit.b2);
                    left = hit.tri;
                    way.direction -= tri_normal(hit.tri) * (2.0 * across);
                }
            }
        }
    }
    unfinished = unfinished || going;
    return met;
}
