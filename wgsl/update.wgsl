// Pass jacobi, second kernel: irradiance and its gradient at each node. Twin: src/twin/jacobi.rs.
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
@group(0) @binding(3) var<storage, read> planes: array<Plane>;
@group(0) @binding(4) var<storage, read> known: array<Light>; // where each row starts
@group(0) @binding(5) var<storage, read> beta: array<Packed>;
@group(0) @binding(6) var<storage, read_write> light: array<Light>;
@group(0) @binding(7) var<storage, read_write> status: array<atomic<u32>>;

var<private> h: Bands;
var<private> m1: Bands;
var<private> m2: Bands;

fn add(i: u32) {
    let l = links[i];
    let b = unpacked(beta[l.other]);
    h += b * l.value;
    m1 += b * l.first;
    m2 += b * l.second;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let j = params.base + gid.x;
    // A row may be as long as there are cells: four links a trip keep within the loop budget.
    h = known[j].h;
    m1 = known[j].g0;
    m2 = known[j].g1;
    let end = offsets[j + 1u];
    var i = offsets[j];
    while i + 4u <= end {
        add(i);
        add(i + 1u);
        add(i + 2u);
        add(i + 3u);
        i += 4u;
    }
    unfinished = unfinished || i + 4u <= end;
    while i < end {
        add(i);
        i++;
    }
    unfinished = unfinished || i < end;
    let p = planes[j];
    light[j] = Light(h, m1 * p.i11 + m2 * p.i12, m1 * p.i12 + m2 * p.i22);
    finish();
}
