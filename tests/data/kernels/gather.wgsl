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
    var square: f32 = 0f;
    var nearness: f32 = 0f;
    var front: f32 = 0f;
    var back: f32 = 0f;
    var k: u32;
    var local: bool;
    var local_1: bool;
    var d: vec3<f32>;
    var brought: vec3<f32>;
    var local_2: bool;
    var inv: f32 = 1f;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let i_1 = (_e8 + gid.x);
    let _e23 = params.first;
    if (_e23 > 0u) {
        let _e30 = gathered[(2u * i_1)];
        sum = _e30.xyz;
        let _e37 = gathered[(2u * i_1)].w;
        nearness = _e37;
        let _e45 = gathered[((2u * i_1) + 1u)].x;
        front = _e45;
        let _e53 = gathered[((2u * i_1) + 1u)].y;
        back = _e53;
        let _e61 = gathered[((2u * i_1) + 1u)].z;
        square = _e61;
    }
    let _e64 = params.first;
    k = _e64;
    loop {
        let _e66 = k;
        let _e69 = params.end;
        if (_e66 < _e69) {
        } else {
            break;
        }
        {
            let _e73 = params.rays;
            let _e75 = k;
            let at = ((i_1 * _e73) + _e75);
            let kind = hits[at].kind;
            if !((kind == FRONT)) {
                local = (kind == BACK);
            } else {
                local = true;
            }
            let _e89 = local;
            if _e89 {
                let _e90 = nearness;
                let _e94 = hits[at].weight;
                nearness = (_e90 + (1f / max(_e94, 0.000000000001f)));
            }
            let _e100 = back;
            back = (_e100 + select(0f, 1f, (kind == BACK)));
            let _e107 = front;
            front = (_e107 + select(0f, 1f, (kind == FRONT)));
            if (kind == FRONT) {
                let _e120 = params.lit;
                local_1 = (_e120 == 1u);
            } else {
                local_1 = false;
            }
            let _e124 = local_1;
            if _e124 {
                let _e129 = hits[at].tri;
                let _e130 = tri_material(_e129);
                let rho = materials[_e130].rho;
                d = vec3<f32>();
                let _e138 = params.exact;
                if (_e138 == 1u) {
                    let _e144 = direct[at].sum;
                    let _e148 = direct[at].rounds;
                    d = (_e144 / vec3(f32(max(_e148, 1u))));
                }
                let _e154 = d;
                let _e157 = light[at];
                brought = (_e154 + _e157.xyz);
                let _e161 = brought;
                brought = (rho * _e161);
                let _e163 = sum;
                let _e164 = brought;
                sum = (_e163 + _e164);
                let _e167 = brought.x;
                let _e169 = brought.y;
                let _e172 = brought.z;
                let grey = (((_e167 + _e169) + _e172) / 3f);
                let _e176 = square;
                square = (_e176 + (grey * grey));
            }
        }
        continuing {
            let _e180 = k;
            k = (_e180 + 1u);
        }
    }
    let _e184 = unfinished;
    if !(_e184) {
        let _e188 = k;
        let _e191 = params.end;
        local_2 = (_e188 < _e191);
    } else {
        local_2 = true;
    }
    let _e194 = local_2;
    unfinished = _e194;
    let _e199 = params.end;
    let _e202 = params.rays;
    if (_e199 == _e202) {
        let _e206 = params.rays;
        inv = (1f / f32(_e206));
    }
    let _e214 = sum;
    let _e215 = inv;
    let _e217 = nearness;
    let _e218 = inv;
    gathered[(2u * i_1)] = vec4<f32>((_e214 * _e215), (_e217 * _e218));
    let _e227 = front;
    let _e228 = inv;
    let _e230 = back;
    let _e231 = inv;
    let _e233 = square;
    let _e234 = inv;
    gathered[((2u * i_1) + 1u)] = vec4<f32>((_e227 * _e228), (_e230 * _e231), (_e233 * _e234), 0f);
    finish();
    return;
}
