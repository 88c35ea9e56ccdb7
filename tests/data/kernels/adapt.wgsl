struct CellSums {
    feature: array<Fixed, 13>,
    distortion: Fixed,
    count: Fixed,
    pad0_: Fixed,
}

struct Fixed {
    lo: u32,
    hi: u32,
}

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    eta: f32,
}

@group(0) @binding(0) 
var<uniform> params: Params;

@group(0) @binding(1) 
var<storage> cells: array<f32>;

@group(0) @binding(2) 
var<storage> sums: array<CellSums>;

@group(0) @binding(3) 
var<storage> offsets: array<u32>;

@group(0) @binding(4) 
var<storage> neighbours: array<u32>;

@group(0) @binding(5) 
var<storage, read_write> moved_cells: array<f32>;

@group(0) @binding(6) 
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

fn value(cell: u32, k_3: u32) -> f32 {
    let f = sums[cell].feature[k_3];
    return (f32(bitcast<i32>(f.hi)) + (f32(f.lo) / 4294967300f));
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var share: f32 = 0f;
    var count: f32;
    var moved: array<f32, 13>;
    var k: u32 = 0u;
    var i: u32;
    var k_1: u32;
    var local: bool;
    var k_2: u32 = 0u;
    var x: f32;
    var local_1: bool;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let c = (_e8 + gid.x);
    let start = offsets[c];
    let end = offsets[(c + 1u)];
    if (end > start) {
        let _e24 = params.eta;
        share = (_e24 / f32((end - start)));
    }
    let _e32 = sums[c].count.lo;
    count = f32(_e32);
    loop {
        let _e38 = k;
        if (_e38 < 13u) {
        } else {
            break;
        }
        {
            let _e41 = k;
            let _e43 = k;
            let _e44 = value(c, _e43);
            moved[_e41] = _e44;
        }
        continuing {
            let _e46 = k;
            k = (_e46 + 1u);
        }
    }
    let _e48 = share;
    if (_e48 > 0f) {
        i = start;
        loop {
            let _e52 = i;
            if (_e52 < end) {
            } else {
                break;
            }
            {
                let _e55 = i;
                let n = neighbours[_e55];
                let _e58 = count;
                let _e59 = share;
                let _e64 = sums[n].count.lo;
                count = (_e58 + (_e59 * f32(_e64)));
                k_1 = 0u;
                loop {
                    let _e70 = k_1;
                    if (_e70 < 13u) {
                    } else {
                        break;
                    }
                    {
                        let _e73 = k_1;
                        let _e75 = moved[_e73];
                        let _e76 = share;
                        let _e77 = k_1;
                        let _e78 = value(n, _e77);
                        moved[_e73] = (_e75 + (_e76 * _e78));
                    }
                    continuing {
                        let _e82 = k_1;
                        k_1 = (_e82 + 1u);
                    }
                }
            }
            continuing {
                let _e85 = i;
                i = (_e85 + 1u);
            }
        }
        let _e89 = unfinished;
        if !(_e89) {
            let _e93 = i;
            local = (_e93 < end);
        } else {
            local = true;
        }
        let _e96 = local;
        unfinished = _e96;
    }
    loop {
        let _e99 = k_2;
        if (_e99 < 16u) {
        } else {
            break;
        }
        {
            let _e105 = k_2;
            let _e108 = cells[((16u * c) + _e105)];
            x = _e108;
            let _e110 = k_2;
            if (_e110 < 13u) {
                let _e115 = count;
                local_1 = (_e115 > 0f);
            } else {
                local_1 = false;
            }
            let _e119 = local_1;
            if _e119 {
                let _e120 = k_2;
                let _e124 = moved[min(_e120, 12u)];
                let _e125 = count;
                x = (_e124 / _e125);
            }
            let _e130 = k_2;
            let _e133 = x;
            moved_cells[((16u * c) + _e130)] = _e133;
        }
        continuing {
            let _e135 = k_2;
            k_2 = (_e135 + 1u);
        }
    }
    finish();
    return;
}
