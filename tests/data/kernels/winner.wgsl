const F32_MAX: f32 = 340282350000000000000000000000000000000f;

struct Best {
    d: vec4<f32>,
    cell: vec4<u32>,
}

struct Block {
    low: vec3<f32>,
    start: u32,
    low_n: vec3<f32>,
    end: u32,
    high: vec3<f32>,
    pad0_: u32,
    high_n: vec3<f32>,
    pad1_: u32,
}

struct Four {
    m0_: mat4x4<f32>,
    m1_: mat4x4<f32>,
    m2_: mat4x4<f32>,
    x12_: vec4<f32>,
}

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    features: u32,
    first: u32,
    end: u32,
    pad0_: u32,
    pad1_: u32,
}

@group(0) @binding(0) 
var<uniform> params: Params;

@group(0) @binding(1) 
var<storage> features: array<vec4<f32>>;

@group(0) @binding(2) 
var<storage> order: array<u32>;

@group(0) @binding(3) 
var<storage> blocks: array<Block>;

@group(0) @binding(4) 
var<storage> cells: array<vec4<f32>>;

@group(0) @binding(5) 
var<storage, read_write> winners: array<u32>;

@group(0) @binding(6) 
var<storage, read_write> distances: array<f32>;

@group(0) @binding(7) 
var<storage, read_write> status: array<atomic<u32>>;

var<private> unfinished: bool = false;

fn better(best: Best, d: vec4<f32>, cell_1: u32) -> Best {
    let closer = ((d < best.d) | ((d == best.d) & (vec4(cell_1) < best.cell)));
    return Best(select(best.d, d, closer), select(best.cell, vec4(cell_1), closer));
}

fn distance2_(f: Four, w0_: vec4<f32>, w1_: vec4<f32>, w2_: vec4<f32>, w3_: f32) -> vec4<f32> {
    var e: vec4<f32>;
    var sum: vec4<f32>;
    e = (f.m0_[0] - vec4(w0_.x));
    let _e11 = e;
    let _e12 = e;
    sum = (_e11 * _e12);
    e = (f.m0_[1] - vec4(w0_.y));
    let _e20 = sum;
    let _e21 = e;
    let _e22 = e;
    sum = (_e20 + (_e21 * _e22));
    e = (f.m0_[2] - vec4(w0_.z));
    let _e30 = sum;
    let _e31 = e;
    let _e32 = e;
    sum = (_e30 + (_e31 * _e32));
    e = (f.m0_[3] - vec4(w0_.w));
    let _e40 = sum;
    let _e41 = e;
    let _e42 = e;
    sum = (_e40 + (_e41 * _e42));
    e = (f.m1_[0] - vec4(w1_.x));
    let _e50 = sum;
    let _e51 = e;
    let _e52 = e;
    sum = (_e50 + (_e51 * _e52));
    e = (f.m1_[1] - vec4(w1_.y));
    let _e60 = sum;
    let _e61 = e;
    let _e62 = e;
    sum = (_e60 + (_e61 * _e62));
    e = (f.m1_[2] - vec4(w1_.z));
    let _e70 = sum;
    let _e71 = e;
    let _e72 = e;
    sum = (_e70 + (_e71 * _e72));
    e = (f.m1_[3] - vec4(w1_.w));
    let _e80 = sum;
    let _e81 = e;
    let _e82 = e;
    sum = (_e80 + (_e81 * _e82));
    e = (f.m2_[0] - vec4(w2_.x));
    let _e90 = sum;
    let _e91 = e;
    let _e92 = e;
    sum = (_e90 + (_e91 * _e92));
    e = (f.m2_[1] - vec4(w2_.y));
    let _e100 = sum;
    let _e101 = e;
    let _e102 = e;
    sum = (_e100 + (_e101 * _e102));
    e = (f.m2_[2] - vec4(w2_.z));
    let _e110 = sum;
    let _e111 = e;
    let _e112 = e;
    sum = (_e110 + (_e111 * _e112));
    e = (f.m2_[3] - vec4(w2_.w));
    let _e120 = sum;
    let _e121 = e;
    let _e122 = e;
    sum = (_e120 + (_e121 * _e122));
    e = (f.x12_ - vec4(w3_));
    let _e128 = sum;
    let _e129 = e;
    let _e130 = e;
    sum = (_e128 + (_e129 * _e130));
    let _e133 = sum;
    return _e133;
}

fn dot3_(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return (((a.x * b.x) + (a.y * b.y)) + (a.z * b.z));
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

fn gap2_(block_1: u32, low: vec3<f32>, low_n: vec3<f32>, high: vec3<f32>, high_n: vec3<f32>) -> f32 {
    let _e8 = blocks[block_1].low;
    let _e13 = blocks[block_1].high;
    let d_2 = max(max((_e8 - high), (low - _e13)), vec3<f32>());
    let _e21 = blocks[block_1].low_n;
    let _e26 = blocks[block_1].high_n;
    let m = max(max((_e21 - high_n), (low_n - _e26)), vec3<f32>());
    let _e31 = dot3_(d_2, d_2);
    let _e32 = dot3_(m, m);
    return (_e31 + _e32);
}

fn greatest(v_1: vec4<f32>) -> f32 {
    return max(max(v_1.x, v_1.y), max(v_1.z, v_1.w));
}

fn least(v: vec4<f32>) -> f32 {
    return min(min(v.x, v.y), min(v.z, v.w));
}

fn load(item: u32) -> Four {
    let _e3 = params.features;
    let last = (_e3 - 1u);
    let _e10 = order[min(item, last)];
    let a_1 = (4u * _e10);
    let _e18 = order[min((item + 1u), last)];
    let b_1 = (4u * _e18);
    let _e26 = order[min((item + 2u), last)];
    let c = (4u * _e26);
    let _e34 = order[min((item + 3u), last)];
    let d_1 = (4u * _e34);
    let _e38 = features[a_1];
    let _e41 = features[b_1];
    let _e44 = features[c];
    let _e47 = features[d_1];
    let _e54 = features[(a_1 + 1u)];
    let _e59 = features[(b_1 + 1u)];
    let _e64 = features[(c + 1u)];
    let _e69 = features[(d_1 + 1u)];
    let _e76 = features[(a_1 + 2u)];
    let _e81 = features[(b_1 + 2u)];
    let _e86 = features[(c + 2u)];
    let _e91 = features[(d_1 + 2u)];
    let _e99 = features[(a_1 + 3u)].x;
    let _e105 = features[(b_1 + 3u)].x;
    let _e111 = features[(c + 3u)].x;
    let _e117 = features[(d_1 + 3u)].x;
    return Four(transpose(mat4x4<f32>(_e38, _e41, _e44, _e47)), transpose(mat4x4<f32>(_e54, _e59, _e64, _e69)), transpose(mat4x4<f32>(_e76, _e81, _e86, _e91)), vec4<f32>(_e99, _e105, _e111, _e117));
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var f_best: Best = Best(vec4(340282350000000000000000000000000000000f), vec4(4294967295u));
    var g_best: Best;
    var k: u32 = 0u;
    var nearest: u32;
    var nearest_gap: f32 = F32_MAX;
    var block: u32;
    var local: bool;
    var local_1: bool;
    var local_2: bool;
    var local_3: bool;
    var cell: u32;
    var local_4: bool;
    var local_5: bool;
    var k_1: u32 = 0u;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e9 = params.base;
    let item_1 = (8u * (_e9 + gid.x));
    let _e15 = params.features;
    let last_1 = (_e15 - 1u);
    let _e18 = load(item_1);
    let _e21 = load((item_1 + 4u));
    let _e27 = least(min(_e18.m1_[2], _e21.m1_[2]));
    let _e33 = least(min(_e18.m1_[3], _e21.m1_[3]));
    let _e39 = least(min(_e18.m2_[0], _e21.m2_[0]));
    let low_1 = vec3<f32>(_e27, _e33, _e39);
    let _e46 = greatest(max(_e18.m1_[2], _e21.m1_[2]));
    let _e52 = greatest(max(_e18.m1_[3], _e21.m1_[3]));
    let _e58 = greatest(max(_e18.m2_[0], _e21.m2_[0]));
    let high_1 = vec3<f32>(_e46, _e52, _e58);
    let _e65 = least(min(_e18.m2_[1], _e21.m2_[1]));
    let _e71 = least(min(_e18.m2_[2], _e21.m2_[2]));
    let _e77 = least(min(_e18.m2_[3], _e21.m2_[3]));
    let low_n_1 = vec3<f32>(_e65, _e71, _e77);
    let _e84 = greatest(max(_e18.m2_[1], _e21.m2_[1]));
    let _e90 = greatest(max(_e18.m2_[2], _e21.m2_[2]));
    let _e96 = greatest(max(_e18.m2_[3], _e21.m2_[3]));
    let high_n_1 = vec3<f32>(_e84, _e90, _e96);
    let _e104 = f_best;
    g_best = _e104;
    let _e108 = params.first;
    if (_e108 > 0u) {
        loop {
            let _e113 = k;
            if (_e113 < 4u) {
            } else {
                break;
            }
            {
                let _e116 = k;
                let i = min((item_1 + _e116), last_1);
                let _e121 = k;
                let j = min(((item_1 + 4u) + _e121), last_1);
                let _e125 = k;
                let _e129 = distances[i];
                f_best.d[_e125] = _e129;
                let _e131 = k;
                let _e135 = distances[j];
                g_best.d[_e131] = _e135;
                let _e137 = k;
                let _e142 = order[i];
                let _e144 = winners[_e142];
                f_best.cell[_e137] = _e144;
                let _e146 = k;
                let _e151 = order[j];
                let _e153 = winners[_e151];
                g_best.cell[_e146] = _e153;
            }
            continuing {
                let _e155 = k;
                k = (_e155 + 1u);
            }
        }
    }
    let _e159 = params.first;
    nearest = _e159;
    let _e165 = params.first;
    block = _e165;
    loop {
        let _e167 = block;
        let _e170 = params.end;
        if (_e167 < _e170) {
        } else {
            break;
        }
        {
            let _e172 = block;
            let _e173 = gap2_(_e172, low_1, low_n_1, high_1, high_n_1);
            let _e174 = nearest;
            let _e175 = block;
            let _e176 = nearest_gap;
            nearest = select(_e174, _e175, (_e173 < _e176));
            let _e179 = nearest_gap;
            nearest_gap = min(_e179, _e173);
        }
        continuing {
            let _e182 = block;
            block = (_e182 + 1u);
        }
    }
    let _e186 = unfinished;
    if !(_e186) {
        let _e190 = block;
        let _e193 = params.end;
        local = (_e190 < _e193);
    } else {
        local = true;
    }
    let _e196 = local;
    unfinished = _e196;
    let _e199 = params.first;
    block = _e199;
    loop {
        let _e200 = block;
        let _e203 = params.end;
        if (_e200 <= _e203) {
        } else {
            break;
        }
        {
            let _e205 = block;
            let _e208 = nearest;
            let _e209 = block;
            let _e212 = params.first;
            let b_2 = select((_e205 - 1u), _e208, (_e209 == _e212));
            let _e215 = block;
            let _e218 = params.first;
            if (_e215 > _e218) {
                let _e222 = nearest;
                local_1 = (b_2 == _e222);
            } else {
                local_1 = false;
            }
            let again = local_1;
            let _e227 = f_best.d;
            let _e228 = greatest(_e227);
            let _e230 = g_best.d;
            let _e231 = greatest(_e230);
            let worst = max(_e228, _e231);
            let _e235 = params.first;
            let _e238 = params.end;
            if !((_e235 == _e238)) {
                local_2 = again;
            } else {
                local_2 = true;
            }
            let _e244 = local_2;
            if !(_e244) {
                let _e248 = gap2_(b_2, low_1, low_n_1, high_1, high_n_1);
                local_3 = ((_e248 * 0.99999f) > worst);
            } else {
                local_3 = true;
            }
            let _e253 = local_3;
            if _e253 {
                continue;
            }
            let end = blocks[b_2].end;
            let _e261 = blocks[b_2].start;
            cell = _e261;
            loop {
                let _e263 = cell;
                if (_e263 < end) {
                } else {
                    break;
                }
                {
                    let _e267 = cell;
                    let w0_1 = cells[(4u * _e267)];
                    let _e273 = cell;
                    let w1_1 = cells[((4u * _e273) + 1u)];
                    let _e281 = cell;
                    let w2_1 = cells[((4u * _e281) + 2u)];
                    let _e289 = cell;
                    let _e294 = cells[((4u * _e289) + 3u)];
                    let w3_1 = _e294.xy;
                    let index = u32(w3_1.y);
                    let _e298 = f_best;
                    let _e300 = distance2_(_e18, w0_1, w1_1, w2_1, w3_1.x);
                    let _e301 = better(_e298, _e300, index);
                    f_best = _e301;
                    let _e302 = g_best;
                    let _e304 = distance2_(_e21, w0_1, w1_1, w2_1, w3_1.x);
                    let _e305 = better(_e302, _e304, index);
                    g_best = _e305;
                }
                continuing {
                    let _e307 = cell;
                    cell = (_e307 + 1u);
                }
            }
            let _e311 = unfinished;
            if !(_e311) {
                let _e315 = cell;
                local_4 = (_e315 < end);
            } else {
                local_4 = true;
            }
            let _e318 = local_4;
            unfinished = _e318;
        }
        continuing {
            let _e320 = block;
            block = (_e320 + 1u);
        }
    }
    let _e324 = unfinished;
    if !(_e324) {
        let _e328 = block;
        let _e331 = params.end;
        local_5 = (_e328 <= _e331);
    } else {
        local_5 = true;
    }
    let _e334 = local_5;
    unfinished = _e334;
    loop {
        let _e337 = k_1;
        if (_e337 < 4u) {
        } else {
            break;
        }
        {
            let _e340 = k_1;
            if ((item_1 + _e340) <= last_1) {
                let _e344 = k_1;
                let _e348 = k_1;
                let _e350 = f_best.d[_e348];
                distances[(item_1 + _e344)] = _e350;
                let _e353 = k_1;
                let _e356 = order[(item_1 + _e353)];
                let _e359 = k_1;
                let _e361 = f_best.cell[_e359];
                winners[_e356] = _e361;
            }
            let _e364 = k_1;
            if (((item_1 + 4u) + _e364) <= last_1) {
                let _e370 = k_1;
                let _e374 = k_1;
                let _e376 = g_best.d[_e374];
                distances[((item_1 + 4u) + _e370)] = _e376;
                let _e381 = k_1;
                let _e384 = order[((item_1 + 4u) + _e381)];
                let _e387 = k_1;
                let _e389 = g_best.cell[_e387];
                winners[_e384] = _e389;
            }
        }
        continuing {
            let _e391 = k_1;
            k_1 = (_e391 + 1u);
        }
    }
    finish();
    return;
}
