// Pass deposit: what rays bring to the nodes from emitter ends whose light is known. Twin: src/twin/deposit.rs.
#import layout
#import math
#import fixed

struct Params {
    base: u32,
    count: u32,
    lit: u32, // 1: the network's light at the ends is known
    normalise: f32, // what weights are multiplied by
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> points: array<Point>;
@group(0) @binding(2) var<storage, read> psi: array<Psi>;
@group(0) @binding(3) var<storage, read> tris: array<Tri>;
@group(0) @binding(4) var<storage, read> materials: array<Material>;
@group(0) @binding(5) var<storage, read> direct: array<DirectSum>;
@group(0) @binding(6) var<storage, read> light: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> nodes: array<Node>;
@group(0) @binding(8) var<storage, read_write> sums: array<atomic<u32>>; // NodeSources, by words

const WORDS = 18u; // of NodeSource

fn add(word: u32, value: f32) {
    let v = encode(value, POWER);
    let old = atomicAdd(&sums[word], v.x);
    let hi = v.y + carry(old, v.x);
    if hi != 0u {
        atomicAdd(&sums[word + 1u], hi);
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let d = params.base + gid.x;
    if points[d].kind != FRONT {
        return;
    }
    let x = d ^ 1u;
    var h = vec3<f32>();
    if params.lit == 1u {
        h = light[x].xyz;
    }
    let known = direct[x].sum / f32(max(direct[x].rounds, 1u)) + h;
    let sent = materials[tris[points[x].tri].material].rho * known;
    let here = psi[d];
    for (var k = 0u; k < 4u; k++) {
        if here.weight[k] > 0.0 {
            let node = here.node[k];
            let t = tangents(nodes[node].n);
            let from_node = points[d].p - nodes[node].p;
            let a = dot3(from_node, t.t1);
            let b = dot3(from_node, t.t2);
            let v = (points[d].weight * params.normalise) * here.weight[k];
            for (var band = 0u; band < 3u; band++) {
                let s = v * sent[band];
                let at = WORDS * node + 2u * band;
                add(at, s);
                add(at + 6u, s * a);
                add(at + 12u, s * b);
            }
        }
    }
}
