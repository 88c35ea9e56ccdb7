//! Owen-scrambled Sobol points in four dimensions (`wgsl/lib/sobol.wgsl`).
//!
//! Direction numbers of Joe and Kuo (2008), dimensions 1 to 4, by their recurrences; nested uniform
//! scrambling by hash (Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020).

use super::math::hash;

/// The Laine–Karras permutation: each bit is flipped by the bits below it.
fn laine_karras(x: u32, seed: u32) -> u32 {
    let mut x = x.wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50b47c);
    x ^= x.wrapping_mul(0xb82f1e52);
    x ^= x.wrapping_mul(0xc7afe638);
    x ^ x.wrapping_mul(0x8d22f6e6)
}

/// Scrambles a point so that its digits are flipped by the digits above them.
fn scramble(x: u32, seed: u32) -> u32 {
    laine_karras(x.reverse_bits(), seed).reverse_bits()
}

/// Point `index` of the sequence scrambled by `seed`, as 32-bit fractions.
pub fn sobol4(index: u32, seed: u32) -> [u32; 4] {
    // Every dimension walks its direction numbers while the index has bits left.
    let mut x = [index.reverse_bits(), 0, 0, 0];
    let mut d1 = 0x80000000u32; // v_k = v_{k-1} ^ v_{k-1} >> 1
    let (mut d2a, mut d2b) = (0x80000000u32, 0xc0000000u32); // v_k = v_{k-1} ^ v_{k-2} ^ v_{k-2} >> 2
    let (mut d3a, mut d3b, mut d3c) = (0x80000000u32, 0xc0000000u32, 0x20000000u32); // v_k = v_{k-2} ^ v_{k-3} ^ v_{k-3} >> 3
    let mut bits = index;
    while bits != 0 {
        if bits & 1 != 0 {
            x[1] ^= d1;
            x[2] ^= d2a;
            x[3] ^= d3a;
        }
        bits >>= 1;
        d1 ^= d1 >> 1;
        (d2a, d2b) = (d2b, d2b ^ d2a ^ (d2a >> 2));
        (d3a, d3b, d3c) = (d3b, d3c, d3b ^ d3a ^ (d3a >> 3));
    }
    let s = hash(seed);
    [scramble(x[0], s), scramble(x[1], hash(s ^ 1)), scramble(x[2], hash(s ^ 2)), scramble(x[3], hash(s ^ 3))]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In any 2^k consecutive points from a multiple of 2^k, each dimension has one point in each 2^-k interval.
    #[test]
    fn every_dimension_is_stratified() {
        for (seed, k) in [(0u32, 4u32), (7, 8), (123_456, 12)] {
            let n = 1u32 << k;
            for start in [0, 3 * n] {
                for dim in 0..4 {
                    let mut seen = vec![0u32; n as usize];
                    for i in start..start + n {
                        seen[(sobol4(i, seed)[dim] >> (32 - k)) as usize] += 1;
                    }
                    assert!(seen.iter().all(|&c| c == 1), "dimension {dim}, seed {seed}, 2^{k} points from {start}");
                }
            }
        }
    }

    /// The first two dimensions are a (0,2)-sequence: one point in every elementary rectangle.
    #[test]
    fn first_two_dimensions_fill_elementary_rectangles() {
        let k = 8;
        for a in 0..=k {
            let mut seen = vec![0; 1 << k];
            for i in 0..1u32 << k {
                let p = sobol4(i, 99);
                let cell = ((p[0] as u64 >> (32 - a)) << (k - a)) | (p[1] as u64 >> (32 - (k - a)));
                seen[cell as usize] += 1;
            }
            assert!(seen.iter().all(|&c| c == 1), "rectangles 2^-{a} x 2^-{}", k - a);
        }
    }
}
