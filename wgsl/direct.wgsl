// Pass direct: irradiance straight from emitters, by multiple importance sampling. Twin: src/twin/direct.rs.
#import layout
#import surface
#import sobol
#import invert
#import sky
#import lights

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    seed: u32,
    first: u32, // first round
    rounds: u32,
    emitter: u32, // samples of the emitters' area a round
    cosine: u32, // cosine directions a round
    emitters: u32,
    emitter_density: f32, // per unit of summed emission, per local area
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> bvh: array<BvhNode>;
@group(0) @binding(2) var<storage, read> tris: array<Tri>;
@group(0) @binding(3) var<storage, read> materials: array<Material>;
@group(0) @binding(4) var<storage, read> emitters: array<Emitter>;
@group(0) @binding(5) var<storage, read> points: array<Point>;
@group(0) @binding(6) var<storage, read> active_points: array<u32>;
@group(0) @binding(7) var<storage, read_write> sums: array<DirectSum>;
@group(0) @binding(8) var<storage, read_write> status: array<atomic<u32>>;
// What no surface sends (lib/sky.wgsl, lib/lights.wgsl).
@group(0) @binding(9) var sky: texture_2d_array<u32>;
@group(0) @binding(10) var lights: texture_2d_array<u32>;
@group(0) @binding(11) var texels: texture_2d_array<u32>;

fn cdf(i: u32) -> u32 {
    return emitters[i].cdf;
}

// Emitters up to which each is asked whether it is near.
const FEW: u32 = 64u;

// Whether cosine directions have a share in what is found at p: near an emitter, or among many.
fn is_near(p: vec3<f32>) -> bool {
    // Light over mirrors comes from cosine directions alone.
    if MIRRORS {
        return true;
    }
    if params.emitters > FEW {
        return true;
    }
    var near = false;
    var e = 0u;
    for (; e < params.emitters; e++) {
        let d = p - tri_v0(emitters[e].tri);
        near = near || dot3(d, d) < emitters[e].near2;
    }
    unfinished = unfinished || e < params.emitters;
    return near;
}

// One sample of the emitters' area, beside `cosine` directions.
fn area_sample(k: u32, seed: u32, tri: u32, p: vec3<f32>, cosine: u32) -> vec3<f32> {
    let ne = f32(params.emitter);
    let nc = f32(cosine);
    let u = sobol4(k, seed);
    let drawn = invert_cdf(params.emitters, u.x);
    let there = emitters[drawn.index].tri;
    let b = place_on(drawn.place, unit(u.y));
    let x = position(there, b.x, b.y);
    let g = kernel_g(x, tri_normal(there), p, tri_normal(tri));
    let planes = vec2<u32>(tri_plane(tri), tri_plane(there));
    if CUTOUTS {
        if !is_there(there, b) {
            return vec3<f32>();
        }
    }
    if g > 0.0 && planes.x != planes.y && !segment_blocked(p, x, planes) {
        if SIGMA > 0.0 {
            var emit = materials[tri_material(there)].emit;
            if TEXTURES {
                emit = mapped(emit, there, EMIT, b);
            }
            return (emit * (g / (ne * emitters[drawn.index].density + nc * g))) * between(p, x);
        }
        if TEXTURES {
            let emit = mapped(materials[tri_material(there)].emit, there, EMIT, b);
            return emit * (g / (ne * emitters[drawn.index].density + nc * g));
        }
        return materials[tri_material(there)].emit * (g / (ne * emitters[drawn.index].density + nc * g));
    }
    return vec3<f32>();
}

// Sampling density of an emitter that does not shine evenly: that of its mean. Emitters are in the order of triangles.
fn uneven_density(tri: u32) -> f32 {
    var low = 0u;
    var high = params.emitters - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if emitters[middle].tri < tri {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    unfinished = unfinished || low < high;
    return select(0.0, emitters[low].density, emitters[low].tri == tri);
}

// What a cosine direction brings from a surface that does not shine evenly.
fn uneven_light(hit: Hit, n: vec3<f32>, direction: vec3<f32>) -> vec3<f32> {
    let emit = mapped(materials[tri_material(hit.tri)].emit, hit.tri, EMIT, vec2<f32>(hit.b1, hit.b2));
    if emit.x + emit.y + emit.z > 0.0 {
        if MIRRORS {
            if way.mirrors > 0u {
                return emit * (way.share / f32(params.cosine));
            }
        }
        let g = geometric(-dot3(tri_normal(hit.tri), direction), dot3(n, direction), hit.t);
        if SIGMA > 0.0 {
            return (emit * (g / (f32(params.emitter) * uneven_density(hit.tri) + f32(params.cosine) * g))) * way.share;
        }
        return emit * (g / (f32(params.emitter) * uneven_density(hit.tri) + f32(params.cosine) * g));
    }
    return vec3<f32>();
}

// One cosine direction; only front faces of emitters count.
fn cosine_sample(k: u32, seed: u32, tri: u32, p: vec3<f32>) -> vec3<f32> {
    let ne = f32(params.emitter);
    let nc = f32(params.cosine);
    let n = tri_normal(tri);
    let u = sobol4(k, seed);
    let direction = cosine_direction(n, unit(u.z), unit(u.w));
    let met = first_hit(tri, p, direction);
    if met.kind == FRONT {
        if TEXTURES {
            if has_map(met.hit.tri, EMIT) || has_map(met.hit.tri, MASK) {
                return uneven_light(met.hit, n, direction);
            }
        }
        if CUTOUTS {
            if has_map(met.hit.tri, MASK) {
                return uneven_light(met.hit, n, direction);
            }
        }
        let emit = materials[tri_material(met.hit.tri)].emit;
        let total = emit.x + emit.y + emit.z;
        if total > 0.0 {
            if MIRRORS {
                if way.mirrors > 0u {
                    return emit * (way.share / nc);
                }
            }
            let cos_y = dot3(n, direction);
            let cos_x = -dot3(tri_normal(met.hit.tri), direction);
            let g = geometric(cos_x, cos_y, met.hit.t);
            if SIGMA > 0.0 {
                return (emit * (g / (ne * total * params.emitter_density + nc * g))) * way.share;
            }
            return emit * (g / (ne * total * params.emitter_density + nc * g));
        }
    }
    return vec3<f32>();
}

// Rounds of what no surface sends, where no surface shines.
fn surfaceless_only(i: u32) {
    let tri = points[i].tri;
    if tri == NONE {
        return;
    }
    let seed = seed_of(params.seed, i);
    var sum = sums[i].sum;
    var square = sums[i].square;
    var r = params.first;
    for (; r < params.first + params.rounds; r++) {
        let d = surfaceless(tri, points[i].p, seed, r, params.emitter, params.cosine);
        let mean = (d.x + d.y + d.z) * (1.0 / 3.0);
        sum += d;
        square += mean * mean;
    }
    unfinished = unfinished || r < params.first + params.rounds;
    sums[i].sum = sum;
    sums[i].square = square;
    sums[i].rounds += params.rounds;
    finish();
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let i = active_points[params.base + gid.x];
    if SURFACELESS {
        if params.emitters == 0u {
            surfaceless_only(i);
            return;
        }
    }
    if params.emitters == 0u {
        sums[i].rounds += params.rounds;
        return;
    }
    let tri = points[i].tri;
    if tri == NONE {
        return;
    }
    let p = points[i].p;
    let seed = seed_of(params.seed, i);
    let cosine = select(0u, params.cosine, is_near(p));
    var sum = sums[i].sum;
    var square = sums[i].square;
    var r = params.first;
    for (; r < params.first + params.rounds; r++) {
        var d = vec3<f32>();
        if SURFACELESS {
            d = surfaceless(tri, p, seed, r, params.emitter, params.cosine);
        }
        var k = r * params.emitter;
        for (; k < (r + 1u) * params.emitter; k++) {
            d += area_sample(k, seed, tri, p, cosine);
        }
        unfinished = unfinished || k < (r + 1u) * params.emitter;
        k = r * cosine;
        for (; k < (r + 1u) * cosine; k++) {
            d += cosine_sample(k, seed, tri, p);
        }
        unfinished = unfinished || k < (r + 1u) * cosine;
        let mean = (d.x + d.y + d.z) * (1.0 / 3.0);
        sum += d;
        square += mean * mean;
    }
    unfinished = unfinished || r < params.first + params.rounds;
    sums[i].sum = sum;
    sums[i].square = square;
    sums[i].rounds += params.rounds;
    finish();
}
