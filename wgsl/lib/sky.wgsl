// The sky's part of pass direct: the twin of src/twin/sky.rs. The kernel binds `sky: texture_2d_array<u32>`, whose texels
// src/scene/sky.rs describes.
#import layout
#import surface
#import sobol

// Whether the scene has an environment that shines, and whether that is a map.
override ENVIRONMENT: bool = false;
override ENVIRONMENT_MAP: bool = false;

// Texels before the rows.
const SKY_HEAD = 2u;
// What tells its sequence from that of the emitters.
const SKY_STREAM = 0x5ca1ab1eu;
// 2^-32: a step of a fixed-point distribution.
const INTERVAL = 1.0 / 4294967296.0;

// Whether anything stands in the way from a point of triangle `tri`; in a convex scene, too.
fn ray_blocked(tri: u32, p: vec3<f32>, direction: vec3<f32>, t_max: f32) -> bool {
    return walk(p, direction, t_max, vec2<u32>(tri_plane(tri), NONE), true, tri_normal(tri)).tri != NONE;
}

// What arrives of light that comes to a point from a direction (unit), from `length` away: beyond the box there is no medium.
fn from_without(p: vec3<f32>, direction: vec3<f32>, length: f32) -> f32 {
    return fade(SIGMA * min(length, way_out(p, direction)));
}

fn sky_texel(t: u32) -> vec4<u32> {
    return textureLoad(sky, vec2<u32>(t % ROW, t / ROW % ROW), t / (ROW * ROW), 0);
}

struct Seen {
    direction: vec3<f32>,
    radiosity: vec3<f32>, // pi L, scaled
    density: f32, // with which the map draws it, 1/sr
}

// A texel of the map, seen in a direction within it.
fn sky_seen(row: u32, column: u32, direction: vec3<f32>) -> Seen {
    let head = sky_texel(0u);
    let at = SKY_HEAD + head.y + row * head.x + column;
    let texel = sky_texel(at);
    let band = sky_texel(SKY_HEAD + row);
    var above = 0u;
    if row > 0u {
        above = sky_texel(SKY_HEAD + row - 1u).x;
    }
    var before = 0u;
    if column > 0u {
        before = sky_texel(at - 1u).w;
    }
    // Shares as the integers have them, over the texel's solid angle.
    let share = f32(band.x - above) * INTERVAL * (f32(texel.w - before) * INTERVAL);
    let angle = bitcast<f32>(band.z) * (2.0 * PI / f32(head.x));
    return Seen(direction, bitcast<vec3<f32>>(texel.xyz), share / angle);
}

struct Drawn {
    index: u32,
    place: f32, // within the interval, in [0, 1)
}

// The end of interval i: of rows, or of the texels of a row, whose first texel is `first`.
fn sky_cdf(i: u32, first: u32, rows: bool) -> u32 {
    let texel = sky_texel(first + i);
    return select(texel.w, texel.x, rows);
}

// As invert_cdf (lib/invert.wgsl), of these.
fn sky_invert(len: u32, first: u32, rows: bool, v: u32) -> Drawn {
    let u = min(v, 0xfffffffeu);
    var low = 0u;
    var high = len - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if sky_cdf(middle, first, rows) > u {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    unfinished = unfinished || low < high;
    var start = 0u;
    if low > 0u {
        start = sky_cdf(low - 1u, first, rows);
    }
    let width = max(sky_cdf(low, first, rows) - start, 1u);
    let place = (f32(u - start) + 0.5) / f32(width);
    return Drawn(low, min(place, 1.0 - 1.0 / 16777216.0));
}

// A direction of the map, drawn by radiance and solid angle.
fn sky_draw(u: u32, v: u32) -> Seen {
    let head = sky_texel(0u);
    let row = sky_invert(head.y, SKY_HEAD, true, u);
    let column = sky_invert(head.x, SKY_HEAD + head.y + row.index * head.x, false, v);
    let turn = (f32(column.index) + column.place) / f32(head.x) - bitcast<f32>(head.z);
    let cs = cos_sin_turn(turn - floor(turn));
    let band = sky_texel(SKY_HEAD + row.index);
    let up = bitcast<f32>(band.y) - bitcast<f32>(band.z) * row.place;
    let flat_part = sqrt(max(1.0 - up * up, 0.0));
    return sky_seen(row.index, column.index, vec3<f32>(-cs.y * flat_part, up, cs.x * flat_part));
}

// The angle of (c, s), in turns, in [0, 1).
fn turn_of(c: f32, s: f32) -> f32 {
    let a = abs(c);
    let b = abs(s);
    let most = max(a, b);
    if most == 0.0 {
        return 0.0;
    }
    let ratio = min(a, b) / most;
    let beyond = ratio > 0.41421357;
    let x = select(ratio, (ratio - 1.0) / (ratio + 1.0), beyond);
    let z = x * x;
    let arc = (((8.0537445e-2 * z - 1.3877686e-1) * z + 1.9977711e-1) * z - 3.333295e-1) * z * x + x;
    var turn = arc * (0.5 / PI) + select(0.0, 0.125, beyond);
    if b > a {
        turn = 0.25 - turn;
    }
    if c < 0.0 {
        turn = 0.5 - turn;
    }
    if s < 0.0 {
        turn = 1.0 - turn;
    }
    return select(turn, 0.0, turn >= 1.0);
}

// What is seen of the map in a direction of unit length.
fn sky_look(direction: vec3<f32>) -> Seen {
    let head = sky_texel(0u);
    let turn = turn_of(direction.z, -direction.x) + bitcast<f32>(head.z);
    let column = min(u32((turn - floor(turn)) * f32(head.x)), head.x - 1u);
    let flat_part = sqrt(direction.x * direction.x + direction.z * direction.z);
    let row = min(u32(2.0 * turn_of(direction.y, flat_part) * f32(head.y)), head.y - 1u);
    return sky_seen(row, column, direction);
}

// What a direction of the map, or a cosine direction, brings where nothing stands before it, by the balance heuristic.
fn weighted(seen: Seen, cosine: f32, nm: f32, nc: f32) -> vec3<f32> {
    if cosine <= 0.0 {
        return vec3<f32>();
    }
    let density = cosine / PI;
    return seen.radiosity * (density / (nm * seen.density + nc * density));
}

// One round's estimate of the sky's irradiance at a surface point.
fn from_sky(tri: u32, p: vec3<f32>, point_seed: u32, round: u32, emitter: u32, cosine: u32) -> vec3<f32> {
    let n = tri_normal(tri);
    let seed = seed_of(point_seed, SKY_STREAM);
    var sum = vec3<f32>();
    if ENVIRONMENT_MAP {
        let nm = emitter;
        let nc = max(cosine, 1u);
        var k = round * nm;
        for (; k < (round + 1u) * nm; k++) {
            let u = sobol4(k, seed);
            let seen = sky_draw(u.x, u.y);
            let light = weighted(seen, dot3(n, seen.direction), f32(nm), f32(nc));
            if any(light != vec3<f32>()) && !ray_blocked(tri, p, seen.direction, F32_MAX) {
                if SIGMA > 0.0 {
                    sum += light * from_without(p, seen.direction, F32_MAX);
                } else {
                    sum += light;
                }
            }
        }
        unfinished = unfinished || k < (round + 1u) * nm;
        k = round * nc;
        for (; k < (round + 1u) * nc; k++) {
            let u = sobol4(k, seed);
            let direction = cosine_direction(n, unit(u.z), unit(u.w));
            if MIRRORS {
                // No direction of the map goes over a mirror.
                if along(tri, p, direction).kind == SKY {
                    if way.mirrors > 0u {
                        sum += sky_look(way.direction).radiosity * (way.share / f32(nc));
                    } else {
                        sum += weighted(sky_look(direction), dot3(n, direction), f32(nm), f32(nc)) * way.share;
                    }
                }
            } else if !ray_blocked(tri, p, direction, F32_MAX) {
                if SIGMA > 0.0 {
                    sum += weighted(sky_look(direction), dot3(n, direction), f32(nm), f32(nc)) * from_without(p, direction, F32_MAX);
                } else {
                    sum += weighted(sky_look(direction), dot3(n, direction), f32(nm), f32(nc));
                }
            }
        }
        unfinished = unfinished || k < (round + 1u) * nc;
        return sum;
    }
    let radiosity = bitcast<vec3<f32>>(sky_texel(1u).xyz);
    let nc = max(emitter + cosine, 1u);
    var k = round * nc;
    for (; k < (round + 1u) * nc; k++) {
        let u = sobol4(k, seed);
        let direction = cosine_direction(n, unit(u.z), unit(u.w));
        if MIRRORS {
            if along(tri, p, direction).kind == SKY {
                sum += radiosity * (way.share / f32(nc));
            }
        } else if !ray_blocked(tri, p, direction, F32_MAX) {
            if SIGMA > 0.0 {
                sum += radiosity * (from_without(p, direction, F32_MAX) / f32(nc));
            } else {
                sum += radiosity / f32(nc);
            }
        }
    }
    unfinished = unfinished || k < (round + 1u) * nc;
    return sum;
}
