// Pass gather: the mean over a point's cosine rays of what their hits reflect. Twin: src/twin/gather.rs.
#import layout
#import triangles
#import texture
#import finish

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    rays: u32, // consecutive hits a point
    first: u32, // hits of this dispatch: [first, end) of each point
    end: u32,
    lit: u32, // 1: the hits' irradiance is known
    exact: u32, // 1: so is their direct light
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> tris: array<Tri>;
@group(0) @binding(2) var<storage, read> materials: array<Material>;
@group(0) @binding(3) var<storage, read> hits: array<Point>;
@group(0) @binding(4) var<storage, read> light: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> direct: array<DirectSum>;
// Two a point: irradiance and nearness; shares of front and of back hits, and the mean square of what a ray brings.
@group(0) @binding(6) var<storage, read_write> gathered: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> status: array<atomic<u32>>;
@group(0) @binding(8) var texels: texture_2d_array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let i = params.base + gid.x;
    var sum = vec3<f32>();
    var square = 0.0;
    var nearness = 0.0;
    var front = 0.0;
    var back = 0.0;
    if params.first > 0u {
        sum = gathered[2u * i].xyz;
        nearness = gathered[2u * i].w;
        front = gathered[2u * i + 1u].x;
        back = gathered[2u * i + 1u].y;
        square = gathered[2u * i + 1u].z;
    }
    var k = params.first;
    for (; k < params.end; k++) {
        let at = i * params.rays + k;
        let kind = hits[at].kind;
        if kind == FRONT || kind == BACK {
            nearness += 1.0 / max(hits[at].weight, 1e-12);
        }
        back += select(0.0, 1.0, kind == BACK);
        front += select(0.0, 1.0, kind == FRONT);
        if kind == FRONT && params.lit == 1u {
            let rho = materials[tri_material(hits[at].tri)].rho;
            var d = vec3<f32>();
            if params.exact == 1u {
                d = direct[at].sum / f32(max(direct[at].rounds, 1u));
            }
            var brought = d + light[at].xyz;
            if TEXTURES {
                brought = mapped(rho, hits[at].tri, RHO, shares(hits[at].tri, hits[at].p)) * brought;
            } else {
                brought = rho * brought;
            }
            if LOSSY {
                brought *= hits[at].density;
            }
            sum += brought;
            let grey = (brought.x + brought.y + brought.z) / 3.0;
            square += grey * grey;
        }
    }
    unfinished = unfinished || k < params.end;
    var inv = 1.0;
    if params.end == params.rays {
        inv = 1.0 / f32(params.rays);
    }
    gathered[2u * i] = vec4<f32>(sum * inv, nearness * inv);
    gathered[2u * i + 1u] = vec4<f32>(front * inv, back * inv, square * inv, 0.0);
    finish();
}
