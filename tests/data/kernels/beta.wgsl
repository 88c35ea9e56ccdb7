struct Light {
    h: vec3<f32>,
    g0_: vec3<f32>,
    g1_: vec3<f32>,
}

struct Link {
    other: u32,
    value: f32,
    first: f32,
    second: f32,
}

struct Material {
    rho: vec3<f32>,
    pad0_: u32,
    emit: vec3<f32>,
    pad1_: u32,
}

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    pad0_: u32,
}

struct Plane {
    i11_: f32,
    i12_: f32,
    i22_: f32,
    material: u32,
}

@group(0) @binding(0) 
var<uniform> params: Params;

@group(0) @binding(1) 
var<storage> offsets: array<u32>;

@group(0) @binding(2) 
var<storage> links: array<Link>;

@group(0) @binding(3) 
var<storage> source: array<vec4<f32>>;

@group(0) @binding(4) 
var<storage> planes: array<Plane>;

@group(0) @binding(5) 
var<storage> materials: array<Material>;

@group(0) @binding(6) 
var<storage> light: array<Light>;

@group(0) @binding(7) 
var<storage, read_write> beta: array<vec4<f32>>;

@group(0) @binding(8) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> unfinished: bool = false;

fn finish() {
    let _e1 = unfinished;
    if _e1 {
        let _e5 = params.flag;
        let _e8 = atomicMax((&status[_e5]), 1u);
        return;
    } else {
        return;
    }
}

fn of_three(b: vec3<f32>) -> vec3<f32> {
    return b;
}

fn packed(b_1: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(b_1, 0f);
}

fn unpacked(p: vec4<f32>) -> vec3<f32> {
    return p.xyz;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var sum: vec3<f32>;
    var i: u32;
    var local: bool;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let c = (_e8 + gid.x);
    let _e13 = source[c];
    let _e14 = unpacked(_e13);
    sum = _e14;
    let end = offsets[(c + 1u)];
    let _e23 = offsets[c];
    i = _e23;
    loop {
        let _e25 = i;
        if (_e25 < end) {
        } else {
            break;
        }
        {
            let _e28 = i;
            let l = links[_e28];
            let _e36 = planes[l.other].material;
            let _e39 = materials[_e36].rho;
            let _e40 = of_three(_e39);
            let _e41 = sum;
            let _e46 = light[l.other].h;
            let _e53 = light[l.other].g0_;
            let _e61 = light[l.other].g1_;
            sum = (_e41 + (_e40 * (((_e46 * l.value) + (_e53 * l.first)) + (_e61 * l.second))));
        }
        continuing {
            let _e68 = i;
            i = (_e68 + 1u);
        }
    }
    let _e72 = unfinished;
    if !(_e72) {
        let _e76 = i;
        local = (_e76 < end);
    } else {
        local = true;
    }
    let _e79 = local;
    unfinished = _e79;
    let _e82 = sum;
    let _e83 = packed(_e82);
    beta[c] = _e83;
    finish();
    return;
}
