// Integer accumulators: a 64-bit sum is two u32, low first. Twin: src/twin/fixed.rs.

const FEATURE_POWER = 32; // features and distortions, in units of 2^-32
const POWER = 58; // normalised weights and what they multiply, in units of 2^-58

// What the high word gains when `add` was added to a low word that held `old`.
fn carry(old: u32, add: u32) -> u32 {
    return select(0u, 1u, old + add < old);
}

// value * 2^power truncated toward zero, in two's complement, exactly: the bits of the float are
// shifted into place. Saturates.
fn encode(value: f32, power: i32) -> vec2<u32> {
    let bits = bitcast<u32>(value);
    let exponent = i32((bits >> 23u) & 255u);
    let mantissa = (bits & 0x7fffffu) | 0x800000u;
    let shift = exponent - 150 + power;
    var lo = 0u;
    var hi = 0u;
    if exponent == 0 || shift <= -24 {
        return vec2<u32>(0u, 0u);
    } else if shift < 0 {
        lo = mantissa >> u32(-shift);
    } else if shift == 0 {
        lo = mantissa;
    } else if shift < 32 {
        lo = mantissa << u32(shift);
        hi = mantissa >> u32(32 - shift);
    } else if shift < 40 {
        hi = mantissa << u32(shift - 32);
    } else {
        lo = 0xffffffffu;
        hi = 0x7fffffffu;
    }
    if (bits >> 31u) != 0u {
        lo = ~lo + 1u;
        hi = ~hi + select(0u, 1u, lo == 0u);
    }
    return vec2<u32>(lo, hi);
}
