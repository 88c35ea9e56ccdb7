// Owen-scrambled Sobol points in four dimensions: the twin of src/twin/sobol.rs.
#import math
#import finish

fn laine_karras(v: u32, seed: u32) -> u32 {
    var x = v + seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    return x ^ (x * 0x8d22f6e6u);
}

fn scramble(x: u32, seed: u32) -> u32 {
    return reverseBits(laine_karras(reverseBits(x), seed));
}

// Point `index` of the sequence scrambled by `seed`, as 32-bit fractions.
fn sobol4(index: u32, seed: u32) -> vec4<u32> {
    // Every dimension walks its direction numbers while the index has bits left.
    var x = vec4<u32>(reverseBits(index), 0u, 0u, 0u);
    var d1 = 0x80000000u;
    var d2a = 0x80000000u;
    var d2b = 0xc0000000u;
    var d3a = 0x80000000u;
    var d3b = 0xc0000000u;
    var d3c = 0x20000000u;
    var bits = index;
    while bits != 0u {
        let mask = 0u - (bits & 1u);
        x.y ^= d1 & mask;
        x.z ^= d2a & mask;
        x.w ^= d3a & mask;
        bits >>= 1u;
        d1 ^= d1 >> 1u;
        let d2c = d2b ^ d2a ^ (d2a >> 2u);
        d2a = d2b;
        d2b = d2c;
        let d3d = d3b ^ d3a ^ (d3a >> 3u);
        d3a = d3b;
        d3b = d3c;
        d3c = d3d;
    }
    unfinished = unfinished || bits != 0u;
    let s = hash(seed);
    return vec4<u32>(
        scramble(x.x, s), scramble(x.y, hash(s ^ 1u)), scramble(x.z, hash(s ^ 2u)), scramble(x.w, hash(s ^ 3u)),
    );
}
