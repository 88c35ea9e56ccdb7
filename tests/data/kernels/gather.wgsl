const BACK: u32 = 3u;

const FRONT: u32 = 1u;

struct DirectSum {
    sum: vec3<f32>,
    rounds: u32,
    square: f32,
    pad0_: array<u32, 3>,
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
    rays: u32,
    first: u32,
    end: u32,
    lit: u32,
    exact: u32,
}

struct Point {
    p: vec3<f32>,
    tri: u32,
    tile: u32,
    kind: u32,
    weight: f32,
    density: f32,
}

struct Tri {
    v0_: vec3<f32>,
    material: u32,
    v1_: vec3<f32>,
    plane: u32,
    v2_: vec3<f32>,
    first_tile: u32,
    normal: vec3<f32>,
    split: u32,
}

@group(0) @binding(0) 
var<uniform> params: Params;

@group(0) @binding(1) 
var<storage> tris: array<Tri>;

@group(0) @binding(2) 
var<storage> materials: array<Material>;

@group(0) @binding(3) 
var<storage> hits: array<Point>;

@group(0) @binding(4) 
var<storage> light: array<vec4<f32>>;

@group(0) @binding(5) 
var<storage> direct: array<DirectSum>;

@group(0) @binding(6) 
var<storage, read_write> gathered: array<vec4<f32>>;

@group(0) @binding(7) 
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

fn tri_material(i: u32) -> u32 {
    let _e4 = tris[i].material;
    return _e4;
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var sum: vec3<f32> = vec3<f32>();
    var nearness: f32 = 0f;
    var front: f32 = 0f;
    var back: f32 = 0f;
    var k: u32;
    var local: bool;
    var local_1: bool;
    var d: vec3<f32>;
    var local_2: bool;
    var inv: f32 = 1f;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let i_1 = (_e8 + gid.x);
    let _e21 = params.first;
    if (_e21 > 0u) {
        let _e28 = gathered[(2u * i_1)];
        sum = _e28.xyz;
        let _e35 = gathered[(2u * i_1)].w;
        nearness = _e35;
        let _e43 = gathered[((2u * i_1) + 1u)].x;
        front = _e43;
        let _e51 = gathered[((2u * i_1) + 1u)].y;
        back = _e51;
    }
    let _e54 = params.first;
    k = _e54;
    loop {
        let _e56 = k;
        let _e59 = params.end;
        if (_e56 < _e59) {
        } else {
            break;
        }
        {
            let _e63 = params.rays;
            let _e65 = k;
            let at = ((i_1 * _e63) + _e65);
            let kind = hits[at].kind;
            if !((kind == FRONT)) {
                local = (kind == BACK);
            } else {
                local = true;
            }
            let _e79 = local;
            if _e79 {
                let _e80 = nearness;
                let _e84 = hits[at].weight;
                nearness = (_e80 + (1f / max(_e84, 0.000000000001f)));
            }
            let _e90 = back;
            back = (_e90 + select(0f, 1f, (kind == BACK)));
            let _e97 = front;
            front = (_e97 + select(0f, 1f, (kind == FRONT)));
            if (kind == FRONT) {
                let _e110 = params.lit;
                local_1 = (_e110 == 1u);
            } else {
                local_1 = false;
            }
            let _e114 = local_1;
            if _e114 {
                let _e119 = hits[at].tri;
                let _e120 = tri_material(_e119);
                let rho = materials[_e120].rho;
                d = vec3<f32>();
                let _e128 = params.exact;
                if (_e128 == 1u) {
                    let _e134 = direct[at].sum;
                    let _e138 = direct[at].rounds;
                    d = (_e134 / vec3(f32(max(_e138, 1u))));
                }
                let _e144 = sum;
                let _e145 = d;
                let _e148 = light[at];
                sum = (_e144 + (rho * (_e145 + _e148.xyz)));
            }
        }
        continuing {
            let _e154 = k;
            k = (_e154 + 1u);
        }
    }
    let _e158 = unfinished;
    if !(_e158) {
        let _e162 = k;
        let _e165 = params.end;
        local_2 = (_e162 < _e165);
    } else {
        local_2 = true;
    }
    let _e168 = local_2;
    unfinished = _e168;
    let _e173 = params.end;
    let _e176 = params.rays;
    if (_e173 == _e176) {
        let _e180 = params.rays;
        inv = (1f / f32(_e180));
    }
    let _e188 = sum;
    let _e189 = inv;
    let _e191 = nearness;
    let _e192 = inv;
    gathered[(2u * i_1)] = vec4<f32>((_e188 * _e189), (_e191 * _e192));
    let _e201 = front;
    let _e202 = inv;
    let _e204 = back;
    let _e205 = inv;
    gathered[((2u * i_1) + 1u)] = vec4<f32>((_e201 * _e202), (_e204 * _e205), 0f, 0f);
    finish();
    return;
}
