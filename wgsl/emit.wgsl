// Pass emit, first kernel: start points by importance, cosine directions, first hits. Twin: src/twin/emit.rs.
#import layout
#import surface
#import sobol
#import invert

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    seed: u32,
    first: u32, // first ray of the sequence
    total: u32, // rays that the weights are divided by
    tiles: u32,
    rays: u32,
    bits: u32, // of the number of invocations, a power of two >= 2
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> bvh: array<BvhNode>;
@group(0) @binding(2) var<storage, read> tris: array<Tri>;
@group(0) @binding(3) var<storage, read> tiles: array<Tile>;
@group(0) @binding(4) var<storage, read> tile_tri: array<u32>;
@group(0) @binding(5) var<storage, read_write> points: array<Point>;
// Rays whose start may be dead, in any order; their number comes first.
@group(0) @binding(6) var<storage, read_write> suspects: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> status: array<atomic<u32>>;
@group(0) @binding(8) var texels: texture_2d_array<u32>;

fn cdf(i: u32) -> u32 {
    return tiles[i].cdf;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    // Take the rays in the order of their starts: the first dimension of the sequence reverses the
    // index's bits. Neighbouring invocations then walk the same part of the hierarchy.
    let item = reverseBits(params.base + gid.x) >> (32u - params.bits);
    if gid.x >= params.count || item >= params.rays {
        return;
    }
    let i = params.first + item;

    // Draw the start and the direction.
    let u = sobol4(i, params.seed);
    let drawn = invert_cdf(params.tiles, u.x);
    let tri = tile_tri[drawn.index];
    let b = place_in_tile(tri_split(tri), drawn.index - tri_first_tile(tri), drawn.place, unit(u.y));
    let p = position(tri, b.x, b.y);
    let direction = cosine_direction(tri_normal(tri), unit(u.z), unit(u.w));

    if CUTOUTS {
        // What is cut out sends nothing and receives nothing.
        if !is_there(tri, b) {
            points[2u * item] = Point(p, tri, drawn.index, DEAD, 0.0, tiles[drawn.index].density);
            points[2u * item + 1u] = Point(direction, NONE, NONE, DEAD, 0.0, 0.0);
            finish();
            return;
        }
    }

    // Trace, and weigh by what was met.
    let met = first_hit(tri, p, direction);
    let density = tiles[drawn.index].density;
    let n = f32(params.total);
    var s = Point(p, tri, drawn.index, met.kind, 0.0, density);
    var end = Point(direction, NONE, NONE, met.kind, 0.0, 0.0);
    if met.kind == FRONT {
        end = surface_point(met.hit.tri, met.hit.b1, met.hit.b2);
        end.kind = met.kind;
        end.density = tiles[end.tile].density;
        s.weight = 1.0 / (n * (density + end.density));
        end.weight = s.weight;
    } else {
        s.weight = 1.0 / (n * density);
        atomicStore(&suspects[1u + atomicAdd(&suspects[0], 1u)], item);
    }
    if LOSSY {
        s.density = way.mirrored;
        end.density = way.share;
        if met.kind == SKY {
            end.p = way.direction;
        }
    }
    points[2u * item] = s;
    points[2u * item + 1u] = end;
    finish();
}
