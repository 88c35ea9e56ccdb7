// Pass deposit: what rays bring to the nodes from emitter ends whose light is known. Twin: src/twin/deposit.rs.
#import layout
#import triangles
#import texture
#import math
#import fixed
#import sums

struct Params {
    base: u32,
    count: u32,
    known: u32, // bit 0: H is known at every point; bit 1: D is, and emitter ends send rho D, not E
    normalise: f32, // what weights are multiplied by
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> points: array<Point>;
@group(0) @binding(2) var<storage, read> psi: array<Psi>;
@group(0) @binding(3) var<storage, read> nodes: array<Node>;
@group(0) @binding(4) var<storage, read> tris: array<Tri>;
@group(0) @binding(5) var<storage, read> materials: array<Material>;
@group(0) @binding(6) var<storage, read> direct: array<DirectSum>;
@group(0) @binding(7) var<storage, read> light: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> sums: array<atomic<u32>>; // NodeSource, by words
@group(0) @binding(9) var texels: texture_2d_array<u32>;

const WORDS = 18u; // of NodeSource

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let d = params.base + gid.x;
    let y = points[d];
    if y.kind != FRONT {
        return;
    }
    let x = d ^ 1u;
    var h = vec3<f32>(0.0);
    if (params.known & 1u) != 0u {
        h = light[x].xyz;
    }
    let material = materials[tri_material(points[x].tri)];
    var sent = material.rho * h + material.emit;
    if (params.known & 2u) != 0u {
        sent = material.rho * (direct[x].sum / f32(max(direct[x].rounds, 1u)) + h);
    }
    if TEXTURES {
        let b = shares(points[x].tri, points[x].p);
        let rho = mapped(material.rho, points[x].tri, RHO, b);
        sent = rho * h + mapped(material.emit, points[x].tri, EMIT, b);
        if (params.known & 2u) != 0u {
            sent = rho * (direct[x].sum / f32(max(direct[x].rounds, 1u)) + h);
        }
    }
    if LOSSY {
        sent *= points[d | 1u].density;
    }
    for (var k = 0u; k < 4u; k++) {
        let weight = psi[d].weight[k];
        if weight > 0.0 {
            let node = psi[d].node[k];
            let t = tangents(nodes[node].n);
            let e = y.p - nodes[node].p;
            let v = ((y.weight * params.normalise) * weight) * nodes[node].gain;
            let s = v * sent;
            let at = WORDS * node;
            add_sum3(at, s, POWER);
            add_sum3(at + 6u, s * dot3(e, t.t1), POWER);
            add_sum3(at + 12u, s * dot3(e, t.t2), POWER);
        }
    }
}
