struct Params {
    base: u32,
    count: u32,
    trips: u32,
    bits: u32,
}

@group(0) @binding(0) 
var<uniform> params: Params;

@group(0) @binding(1) 
var<storage, read_write> out: array<atomic<u32>>;

fn carry(old: u32, add: u32) -> u32 {
    return select(0u, 1u, ((old + add) < old));
}

@compute @workgroup_size(64, 1, 1) 
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    var trips: u32 = 0u;
    var mixed: u32;
    var k: u32 = 0u;
    var local: bool;
    let _e4 = params.count;
    if (gid.x >= _e4) {
        return;
    }
    let _e8 = params.base;
    let i = (_e8 + gid.x);
    mixed = (i | 1u);
    loop {
        let _e18 = k;
        let _e21 = params.trips;
        if (_e18 < _e21) {
        } else {
            break;
        }
        {
            let _e23 = mixed;
            mixed = ((_e23 * 1664525u) + 1013904224u);
            let _e28 = trips;
            let _e29 = mixed;
            trips = (_e28 + (_e29 & 1u));
        }
        continuing {
            let _e34 = k;
            k = (_e34 + 1u);
        }
    }
    let _e38 = trips;
    let _e39 = atomicAdd((&out[2]), _e38);
    let _e42 = atomicAdd((&out[4]), i);
    let _e46 = atomicAdd((&out[0]), 3221225472u);
    let _e50 = carry(_e46, 3221225472u);
    let _e51 = atomicAdd((&out[1]), _e50);
    let _e54 = params.bits;
    let f = bitcast<f32>(_e54);
    let _e61 = params.bits;
    if (bitcast<u32>((f * 2f)) == (_e61 + 8388608u)) {
        local = (f > 1f);
    } else {
        local = false;
    }
    let _e70 = local;
    if _e70 {
        let _e74 = atomicAdd((&out[3]), 1u);
        return;
    } else {
        return;
    }
}
