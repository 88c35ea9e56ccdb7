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
var<storage> planes: array<Plane>;

@group(0) @binding(4) 
var<storage> known: array<Light>;

@group(0) @binding(5) 
var<storage> beta: array<vec4<f32>>;

@group(0) @binding(6) 
var<storage, read_write> light: array<Light>;

@group(0) @binding(7) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> h: vec3<f32>;

var<private> m1_: vec3<f32>;

var<private> m2_: vec3<f32>;

var<private> unfinished: bool = false;

fn add(i_1: u32) {
    let l = links[i_1];
    let _e7 = beta[l.other];
    let _e8 = unpacked(_e7);
    let _e10 = h;
    h = (_e10 + (_e8 * l.value));
    let _e15 = m1_;
    m1_ = (_e15 + (_e8 * l.first));
    let _e20 = m2_;
    m2_ = (_e20 + (_e8 * l.second));
    return;
}

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

fn unpacked(p: vec4<f32>) -> vec3<f32> {
    return p.xyz;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var i: u32;
    var local: bool;
    var local_1: bool;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let j = (_e8 + gid.x);
    let _e15 = known[j].h;
    h = _e15;
    let _e20 = known[j].g0_;
    m1_ = _e20;
    let _e25 = known[j].g1_;
    m2_ = _e25;
    let end = offsets[(j + 1u)];
    let _e33 = offsets[j];
    i = _e33;
    loop {
        let _e35 = i;
        if ((_e35 + 4u) <= end) {
        } else {
            break;
        }
        {
            let _e39 = i;
            add(_e39);
            let _e40 = i;
            add((_e40 + 1u));
            let _e43 = i;
            add((_e43 + 2u));
            let _e46 = i;
            add((_e46 + 3u));
            let _e49 = i;
            i = (_e49 + 4u);
        }
    }
    let _e54 = unfinished;
    if !(_e54) {
        let _e58 = i;
        local = ((_e58 + 4u) <= end);
    } else {
        local = true;
    }
    let _e63 = local;
    unfinished = _e63;
    loop {
        let _e64 = i;
        if (_e64 < end) {
        } else {
            break;
        }
        {
            let _e66 = i;
            add(_e66);
            let _e68 = i;
            i = (_e68 + 1u);
        }
    }
    let _e72 = unfinished;
    if !(_e72) {
        let _e76 = i;
        local_1 = (_e76 < end);
    } else {
        local_1 = true;
    }
    let _e79 = local_1;
    unfinished = _e79;
    let p_1 = planes[j];
    let _e86 = h;
    let _e88 = m1_;
    let _e92 = m2_;
    let _e97 = m1_;
    let _e101 = m2_;
    light[j] = Light(_e86, ((_e88 * p_1.i11_) + (_e92 * p_1.i12_)), ((_e97 * p_1.i12_) + (_e101 * p_1.i22_)));
    finish();
    return;
}
