// Pass assign: the nodes that speak for a surface point. Twin: src/twin/assign.rs.
#import layout
#import ray

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    inv_unit: f32, // 1/L
    lambda: f32, // weight of normals
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> bvh: array<BvhNode>;
@group(0) @binding(2) var<storage, read> tris: array<Tri>;
@group(0) @binding(3) var<storage, read> nodes: array<Node>;
@group(0) @binding(4) var<storage, read> offsets: array<u32>; // a tile's candidates
@group(0) @binding(5) var<storage, read> candidates: array<Candidate>;
@group(0) @binding(6) var<storage, read> points: array<Point>;
@group(0) @binding(7) var<storage, read_write> psi: array<Psi>;
@group(0) @binding(8) var<storage, read_write> status: array<atomic<u32>>;

const NEAREST = 9u; // candidates looked at
const PLANE = 0.3; // share of the distance by which one point may lie off the other's plane
const PLANE_FLOOR = 1e-3; // the same in units of L
const LIFT = 0.1; // share of the distance by which the segment is lifted

// Squared distance in the metric (y/L, lambda n).
fn distance2(p: vec3<f32>, n: vec3<f32>, node: u32) -> f32 {
    let d = (p - nodes[node].p) * params.inv_unit;
    let m = (n - nodes[node].n) * params.lambda;
    return dot3(d, d) + dot3(m, m);
}

// Whether the segment from a point to a node, lifted along both normals, is free.
fn in_sight(p: vec3<f32>, n: vec3<f32>, plane: u32, node: u32) -> bool {
    let q = nodes[node].p;
    let d = p - q;
    let lift = max(LIFT * sqrt(dot3(d, d)), 2e-6);
    return !segment_blocked(p + n * lift, q + nodes[node].n * lift, vec2<u32>(plane, nodes[node].plane));
}

fn weights(i: u32) -> Psi {
    var result = Psi(vec4<u32>(NONE, NONE, NONE, NONE), vec4<f32>());
    let tri = points[i].tri;
    let tile = points[i].tile;
    if tri == NONE || tile == NONE {
        return result;
    }
    let p = points[i].p;
    let n = tris[tri].normal;
    let plane = tris[tri].plane;

    // Keep the nearest candidates in order; the earlier of two equals comes first.
    var near_d: array<f32, NEAREST>;
    var near_c: array<u32, NEAREST>;
    for (var k = 0u; k < NEAREST; k++) {
        near_d[k] = F32_MAX;
        near_c[k] = NONE;
    }
    let end = offsets[tile + 1u];
    var c = offsets[tile];
    for (; c < end; c++) {
        var d = distance2(p, n, candidates[c].node);
        var id = c;
        if d < near_d[NEAREST - 1u] {
            for (var k = 0u; k < NEAREST; k++) {
                if d < near_d[k] {
                    let other_d = near_d[k];
                    let other_c = near_c[k];
                    near_d[k] = d;
                    near_c[k] = id;
                    d = other_d;
                    id = other_c;
                }
            }
        }
    }
    unfinished = unfinished || c < end;

    // Take the first five that are compatible; the fifth only sets the radius. If none is, the second
    // round names the nearest in sight, whatever its plane.
    var found_d: array<f32, 5>;
    var found_n: array<u32, 5>;
    var found = 0u;
    var orphan = NONE;
    for (var k = 0u; k < 2u * NEAREST; k++) {
        let second = k >= NEAREST;
        let slot = select(k, k - NEAREST, second);
        let at = near_c[slot];
        if found == 5u || (second && (found > 0u || orphan != NONE)) {
            break;
        }
        if at == NONE {
            continue;
        }
        let node = candidates[at].node;
        if !second {
            let d = p - nodes[node].p;
            let length = sqrt(dot3(d, d));
            let off = max(abs(dot3(d, nodes[node].n)), abs(dot3(d, n)));
            if off * params.inv_unit >= PLANE * length * params.inv_unit + PLANE_FLOOR {
                continue;
            }
        }
        if candidates[at].free == 0u && !in_sight(p, n, plane, node) {
            continue;
        }
        if second {
            orphan = node;
        } else {
            found_d[found] = near_d[slot];
            found_n[found] = node;
            found++;
        }
    }
    if found == 0u {
        result.node.x = orphan;
        return result;
    }

    // Weigh them, and let the weights sum to 1.
    let radius2 = max(select(2.25 * found_d[found - 1u], found_d[4], found == 5u), 1e-20);
    var sum = 0.0;
    for (var k = 0u; k < min(found, 4u); k++) {
        let t = max(1.0 - found_d[k] / radius2, 0.0) + 1e-6;
        result.node[k] = found_n[k];
        result.weight[k] = t * t;
        sum += t * t;
    }
    result.weight = result.weight / sum;
    return result;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let i = params.base + gid.x;
    psi[i] = weights(i);
    finish();
}
