// Lights without a surface in pass direct: the twin of src/twin/lights.rs. The kernel binds `lights: texture_2d_array<u32>`: a texel
// with the number of suns and of all lights, then three texels a light (Lamp in lib/layout.wgsl), suns first.
#import layout
#import sky
#import sobol

// Whether there are lights, and whether there is anything that shines without a surface: lights, or a sky.
override LIGHTS: bool = false;
override SURFACELESS: bool = false;

// Points and spots that a round asks; where there are no more, all.
const FEW_LIGHTS = 8u;
// What tells their sequences from those of emitters and sky.
const LIGHT_STREAM = 0x50f711feu;

fn light_texel(t: u32) -> vec4<u32> {
    return textureLoad(lights, vec2<u32>(t % ROW, t / ROW % ROW), t / (ROW * ROW), 0);
}

fn light_at(i: u32) -> Lamp {
    let a = light_texel(3u * i + 1u);
    let b = light_texel(3u * i + 2u);
    let c = light_texel(3u * i + 3u);
    return Lamp(
        bitcast<vec3<f32>>(a.xyz), bitcast<f32>(a.w), bitcast<vec3<f32>>(b.xyz), bitcast<f32>(b.w), bitcast<vec3<f32>>(c.xyz), c.w,
    );
}

struct Arriving {
    way: vec3<f32>, // to the light
    light: vec3<f32>, // what comes from there
}

// A direction towards a sun, and what comes from there to a surface of normal n.
fn from_sun(sun: Lamp, n: vec3<f32>, u: f32, v: f32) -> Arriving {
    let t = tangents(sun.p);
    let cs = cos_sin_turn(v);
    let r = sun.slope * sqrt(u);
    let up = sqrt(max(1.0 - r * r, 0.0));
    let direction = t.t1 * (r * cs.x) + t.t2 * (r * cs.y) + sun.p * up;
    return Arriving(direction, sun.value * (max(dot3(n, direction), 0.0) / up));
}

// The way to a point or spot light, and what comes from there to a surface of normal n.
fn from_point(light: Lamp, p: vec3<f32>, n: vec3<f32>) -> Arriving {
    let way = light.p - p;
    let r2 = dot3(way, way);
    if !(r2 > 0.0) {
        return Arriving(way, vec3<f32>());
    }
    let r = sqrt(r2);
    let cosine = max(dot3(n, way) / r, 0.0);
    let fall = clamp((-dot3(light.d, way) / r) * light.slope + light.offset, 0.0, 1.0);
    return Arriving(way, light.value * (fall * fall * ((cosine / r) / r)));
}

fn bands(v: vec3<f32>) -> f32 {
    return v.x + v.y + v.z;
}

// One round's estimate of the lights' irradiance at a surface point.
fn from_lights(tri: u32, p: vec3<f32>, point_seed: u32, round: u32, emitter: u32) -> vec3<f32> {
    let n = tri_normal(tri);
    let seed = seed_of(point_seed, LIGHT_STREAM);
    let suns = light_texel(0u).x;
    let count = light_texel(0u).y;
    var sum = vec3<f32>();
    var i = 0u;
    for (; i < suns; i++) {
        let sun = light_at(i);
        let rays = select(1u, max(emitter / 4u, 1u), sun.slope > 0.0);
        var k = round * rays;
        for (; k < (round + 1u) * rays; k++) {
            let u = sobol4(k, seed_of(seed, i));
            let arriving = from_sun(sun, n, unit(u.x), unit(u.y));
            if any(arriving.light != vec3<f32>()) && !ray_blocked(tri, p, arriving.way, F32_MAX) {
                if SIGMA > 0.0 {
                    sum += arriving.light * (from_without(p, arriving.way, F32_MAX) / f32(rays));
                } else {
                    sum += arriving.light * (1.0 / f32(rays));
                }
            }
        }
        unfinished = unfinished || k < (round + 1u) * rays;
    }
    unfinished = unfinished || i < suns;
    // All of them, or as many as FEW_LIGHTS, drawn at even steps along the sum of what they bring.
    let all = count - suns <= FEW_LIGHTS;
    var step_width = 0.0;
    if !all {
        for (i = suns; i < count; i++) {
            step_width += bands(from_point(light_at(i), p, n).light);
        }
        unfinished = unfinished || i < count;
        step_width *= 1.0 / f32(FEW_LIGHTS);
    }
    var next = step_width * unit(sobol4(round, seed).z);
    var passed = 0.0;
    for (i = suns; i < count; i++) {
        let arriving = from_point(light_at(i), p, n);
        let brings = bands(arriving.light);
        if brings <= 0.0 {
            continue;
        }
        var share = 1.0;
        if !all {
            passed += brings;
            let times = max(ceil((passed - next) / step_width), 0.0);
            next += times * step_width;
            share = times * step_width / brings;
        }
        if share > 0.0 && !ray_blocked(tri, p, arriving.way, 1.0) {
            if SIGMA > 0.0 {
                let r = sqrt(dot3(arriving.way, arriving.way));
                sum += arriving.light * (share * from_without(p, arriving.way * (1.0 / r), r));
            } else {
                sum += arriving.light * share;
            }
        }
    }
    unfinished = unfinished || i < count;
    return sum;
}

// One round's estimate of the irradiance from lights and sky at a surface point: what no surface sends.
fn surfaceless(tri: u32, p: vec3<f32>, seed: u32, round: u32, emitter: u32, cosine: u32) -> vec3<f32> {
    var sum = vec3<f32>();
    if ENVIRONMENT {
        sum += from_sky(tri, p, seed, round, emitter, cosine);
    }
    if LIGHTS {
        sum += from_lights(tri, p, seed, round, emitter);
    }
    return sum;
}
