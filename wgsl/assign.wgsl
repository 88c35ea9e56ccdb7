// Pass assign: the nodes that speak for a surface point. Twin: src/twin/assign.rs.
#import layout
#import ray

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    inv_unit: f32, // 1/L
    lambda: f32, // weight of normals
    first_list: u32, // where the candidates begin
    joint: u32, // where the starts of shared lists begin, after each tile's group; 0: each tile has its own
    pad1: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> bvh: array<BvhNode>;
@group(0) @binding(2) var<storage, read> tris: array<Tri>;
@group(0) @binding(3) var<storage, read> nodes: array<Node>;
// Start of each tile's candidates, then all candidates, two words each. Where tiles share lists, each one's group comes first.
@group(0) @binding(4) var<storage, read> lists: array<u32>;
@group(0) @binding(5) var<storage, read> points: array<Point>;
@group(0) @binding(6) var<storage, read> order: array<u32>;
@group(0) @binding(7) var<storage, read_write> psi: array<Psi>;
@group(0) @binding(8) var<storage, read_write> status: array<atomic<u32>>;
@group(0) @binding(9) var texels: texture_2d_array<u32>;

const CONE = 0.7; // normals must agree to this cosine
const NEAREST = 9u; // candidates looked at
const PLANE = 0.3; // share of the distance by which one point may lie off the other's plane
const PLANE_FLOOR = 1e-3; // the same in units of L
const LIFT = 0.1; // share of the distance by which the segment is lifted
const FLOOR = 2e-6; // least lift; what lies this little behind a plane lies on it

fn candidate_node(c: u32) -> u32 {
    return lists[params.first_list + 2u * c];
}

// Whether nothing can stand between the tile and the node.
fn candidate_free(c: u32) -> bool {
    return lists[params.first_list + 2u * c + 1u] == 1u;
}

// Squared distance in the metric (y/L, lambda n).
fn distance2(p: vec3<f32>, n: vec3<f32>, node: u32) -> f32 {
    let d = (p - nodes[node].p) * params.inv_unit;
    let m = (n - nodes[node].n) * params.lambda;
    return dot3(d, d) + dot3(m, m);
}

// How a point and a node lie to each other.
struct Between {
    behind: vec2<f32>, // how far the node lies behind the point's plane, and the point behind the node's
    turn: f32, // how far behind the turn of their normals explains, as of an edge or a curve between them
    cosine: f32, // between their normals
    lift: f32, // how far the segment is lifted at both ends: by LIFT, and over such an edge
}

fn between(p: vec3<f32>, n: vec3<f32>, node: u32) -> Between {
    let d = p - nodes[node].p;
    let m = nodes[node].n;
    let turn = sqrt(dot3(n - m, n - m) * dot3(d, d)) + FLOOR;
    let behind = vec2<f32>(dot3(d, n), -dot3(d, m));
    let cosine = dot3(n, m);
    let over = select(vec2<f32>(), behind, behind <= vec2<f32>(turn));
    let lift = max(max(LIFT * sqrt(dot3(d, d)), FLOOR), max(over.x, over.y) / cosine);
    return Between(behind, turn, cosine, lift);
}

// The planes that the segment need not look at, of those of the point and the node, where they are lifted so far: the plane
// that the other end lies behind only as an edge explains it, and is lifted over. Of two sheets that face the same way, or where
// one surface runs into another, the plane hides what lies behind.
fn crossed(at: Between, plane: u32, node: u32, own: f32, other: f32) -> vec2<u32> {
    let hides = at.behind > vec2<f32>(min(at.turn, other * at.cosine + FLOOR), min(at.turn, own * at.cosine + FLOOR));
    return select(vec2<u32>(plane, nodes[node].plane), vec2<u32>(NONE), hides);
}

// What a point sees: the ray up to where segments are lifted, or a segment to a node, lifted along both normals.
struct Look {
    origin: vec3<f32>,
    direction: vec3<f32>,
    t_max: f32,
    skip: vec2<u32>,
}

// Whether a node lies near a point's plane, and the point near the node's.
fn compatible(p: vec3<f32>, n: vec3<f32>, node: u32) -> bool {
    let d = p - nodes[node].p;
    let length = sqrt(dot3(d, d));
    let off = max(abs(dot3(d, nodes[node].n)), abs(dot3(d, n)));
    return !(off * params.inv_unit >= PLANE * length * params.inv_unit + PLANE_FLOOR);
}

// What was found so far: compatible nodes with their squared distances, or one for an orphan.
var<private> found: u32;
var<private> found_d: array<f32, 5>;
var<private> found_n: array<u32, 5>;
var<private> orphan: u32 = NONE;

fn take(k: u32, d2: f32, node: u32) {
    if k >= NEAREST {
        orphan = node;
    } else {
        found_d[found] = d2;
        found_n[found] = node;
        found++;
    }
}

fn weights(i: u32) -> Psi {
    var result = Psi(vec4<u32>(NONE, NONE, NONE, NONE), vec4<f32>());
    let tri = points[i].tri;
    let tile = points[i].tile;
    if tri == NONE || tile == NONE {
        return result;
    }
    let p = points[i].p;
    let n = tri_normal(tri);
    let plane = tri_plane(tri);

    // Keep the nearest candidates in order; the earlier of two equals comes first. The slots are named
    // one by one, so that they stay in registers.
    var d0 = F32_MAX;
    var d1 = F32_MAX;
    var d2 = F32_MAX;
    var d3 = F32_MAX;
    var d4 = F32_MAX;
    var d5 = F32_MAX;
    var d6 = F32_MAX;
    var d7 = F32_MAX;
    var d8 = F32_MAX;
    var c0 = NONE;
    var c1 = NONE;
    var c2 = NONE;
    var c3 = NONE;
    var c4 = NONE;
    var c5 = NONE;
    var c6 = NONE;
    var c7 = NONE;
    var c8 = NONE;
    var list = tile;
    if params.joint != 0u {
        list = params.joint + lists[tile];
    }
    let end = lists[list + 1u];
    var c = lists[list];
    for (; c < end; c++) {
        let d = distance2(p, n, candidate_node(c));
        if d < d8 {
            // A list of several tiles holds nodes of other cones, too.
            if params.joint != 0u && dot3(n, nodes[candidate_node(c)].n) <= CONE {
                continue;
            }
            let b0 = d < d0;
            let b1 = d < d1;
            let b2 = d < d2;
            let b3 = d < d3;
            let b4 = d < d4;
            let b5 = d < d5;
            let b6 = d < d6;
            let b7 = d < d7;
            d8 = select(d, d7, b7);
            c8 = select(c, c7, b7);
            d7 = select(select(d7, d, b7), d6, b6);
            c7 = select(select(c7, c, b7), c6, b6);
            d6 = select(select(d6, d, b6), d5, b5);
            c6 = select(select(c6, c, b6), c5, b5);
            d5 = select(select(d5, d, b5), d4, b4);
            c5 = select(select(c5, c, b5), c4, b4);
            d4 = select(select(d4, d, b4), d3, b3);
            c4 = select(select(c4, c, b4), c3, b3);
            d3 = select(select(d3, d, b3), d2, b2);
            c3 = select(select(c3, c, b3), c2, b2);
            d2 = select(select(d2, d, b2), d1, b1);
            c2 = select(select(c2, c, b2), c1, b1);
            d1 = select(select(d1, d, b1), d0, b0);
            c1 = select(select(c1, c, b1), c0, b0);
            d0 = select(d0, d, b0);
            c0 = select(c0, c, b0);
        }
    }
    unfinished = unfinished || c < end;
    var near_d = array<f32, NEAREST>(d0, d1, d2, d3, d4, d5, d6, d7, d8);
    var near_c = array<u32, NEAREST>(c0, c1, c2, c3, c4, c5, c6, c7, c8);

    // Take the first five that are compatible; the fifth only sets the radius. If none is, a second
    // round names the nearest in sight, whatever its plane. Each trip goes on to the next candidate that
    // needs a ray, so that neighbouring invocations shoot together.
    //
    // A node is in sight if the segment to it, lifted along both normals, is free; neither end by more than half of the way
    // up that is free there. The first ray of a point tells how far its way up is.
    var reach = -1.0;
    var k = 0u;
    var pending = true;
    while pending {
        pending = false;
        var node = NONE;
        while !pending && k < 2u * NEAREST && found < 5u && orphan == NONE && (k < NEAREST || found == 0u) {
            let at = near_c[k % NEAREST];
            if at != NONE {
                node = candidate_node(at);
                if k >= NEAREST || compatible(p, n, node) {
                    pending = !candidate_free(at);
                    if !pending {
                        take(k, near_d[k % NEAREST], node);
                    }
                }
            }
            k++;
        }
        if pending {
            let at = between(p, n, node);
            let up = reach < 0.0;
            let own = min(at.lift, 0.5 * reach);
            let other = min(at.lift, 0.5 * nodes[node].clear);
            let start = p + n * own;
            let stop = nodes[node].p + nodes[node].n * other;
            var look = Look(start, stop - start, 1.0, crossed(at, plane, node, own, other));
            if up {
                var most = 0.0;
                for (var c = 0u; c < NEAREST; c++) {
                    if near_c[c] != NONE {
                        most = max(most, between(p, n, candidate_node(near_c[c])).lift);
                    }
                }
                look = Look(p, n, 2.0 * (1.001 * most + 2.0 * FLOOR), vec2<u32>(plane, NONE));
            }
            let met = walk(look.origin, look.direction, look.t_max, look.skip, !up, vec3<f32>());
            if up {
                // The same candidate again.
                reach = met.t;
                k--;
            } else if met.tri == NONE {
                take(k - 1u, near_d[(k - 1u) % NEAREST], node);
            }
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
    let i = order[params.base + gid.x];
    psi[i] = weights(i);
    finish();
}
