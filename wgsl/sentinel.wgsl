// Does this driver do what the other kernels rely on? See src/gpu/sentinel.rs.
#import fixed

struct Params {
    base: u32,
    count: u32,
    trips: u32, // loop trips to make
    bits: u32, // bits of 1.5
}

@group(0) @binding(0) var<uniform> params: Params;
// Sum (low, high), loop trips, items whose casts are right, sum of item numbers.
@group(0) @binding(1) var<storage, read_write> out: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let i = params.base + gid.x;
    // Count the trips really made; the chained numbers keep the loop from being folded away.
    var trips = 0u;
    var mixed = i | 1u;
    for (var k = 0u; k < params.trips; k++) {
        mixed = mixed * 1664525u + 1013904224u;
        trips += mixed & 1u;
    }
    atomicAdd(&out[2], trips);
    atomicAdd(&out[4], i);

    // Add with carry.
    let old = atomicAdd(&out[0], 0xC0000000u);
    atomicAdd(&out[1], carry(old, 0xC0000000u));

    // Double a float by its exponent's bits.
    let f = bitcast<f32>(params.bits);
    if bitcast<u32>(f * 2.0) == params.bits + 0x00800000u && f > 1.0 {
        atomicAdd(&out[3], 1u);
    }
}
