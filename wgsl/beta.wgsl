// Pass jacobi, first kernel: what each cell sends. Twin: src/twin/jacobi.rs.
#import layout
#import bands
#import finish

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    pad0: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> offsets: array<u32>;
@group(0) @binding(2) var<storage, read> links: array<Link>;
@group(0) @binding(3) var<storage, read> source: array<Packed>;
@group(0) @binding(4) var<storage, read> planes: array<Plane>;
@group(0) @binding(5) var<storage, read> materials: array<Material>;
@group(0) @binding(6) var<storage, read> light: array<Light>;
@group(0) @binding(7) var<storage, read_write> beta: array<Packed>;
@group(0) @binding(8) var<storage, read_write> status: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let c = params.base + gid.x;
    var sum = unpacked(source[c]);
    let end = offsets[c + 1u];
    var i = offsets[c];
    for (; i < end; i++) {
        let l = links[i];
        let rho = of_three(materials[planes[l.other].material].rho);
        sum += rho * (light[l.other].h * l.value + light[l.other].g0 * l.first + light[l.other].g1 * l.second);
    }
    unfinished = unfinished || i < end;
    beta[c] = packed(sum);
    finish();
}
