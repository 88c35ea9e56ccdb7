// Pass coefficients, second kernel: flux and source of the cells. Twin: src/twin/coefficients.rs.
#import layout
#import triangles
#import texture
#import fixed
#import sums

struct Params {
    base: u32,
    count: u32,
    exact: u32, // 1: emitter ends send rho D, 0: E
    normalise: f32, // what weights are multiplied by
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> points: array<Point>;
@group(0) @binding(2) var<storage, read> winners: array<u32>;
@group(0) @binding(3) var<storage, read> tris: array<Tri>;
@group(0) @binding(4) var<storage, read> materials: array<Material>;
@group(0) @binding(5) var<storage, read> direct: array<DirectSum>;
@group(0) @binding(6) var<storage, read_write> sums: array<atomic<u32>>; // CellFlux, by words
@group(0) @binding(7) var texels: texture_2d_array<u32>;

const WORDS = 8u; // of CellFlux

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let d = params.base + gid.x;
    let w = points[d].weight * params.normalise;
    if w <= 0.0 || points[d].kind != FRONT || winners[d] == NONE {
        return;
    }
    let x = d ^ 1u;
    let material = tri_material(points[x].tri);
    var source = materials[material].emit;
    if params.exact == 1u {
        source = materials[material].rho * (direct[x].sum / f32(max(direct[x].rounds, 1u)));
    }
    if TEXTURES {
        let b = shares(points[x].tri, points[x].p);
        source = mapped(materials[material].emit, points[x].tri, EMIT, b);
        if params.exact == 1u {
            source = mapped(materials[material].rho, points[x].tri, RHO, b) * (direct[x].sum / f32(max(direct[x].rounds, 1u)));
        }
    }
    let at = WORDS * winners[d];
    if LOSSY {
        let carried = w * points[d | 1u].density;
        add_sum(at, carried, POWER);
        add_sum3(at + 2u, carried * source, POWER);
    } else {
        add_sum(at, w, POWER);
        add_sum3(at + 2u, w * source, POWER);
    }
}
