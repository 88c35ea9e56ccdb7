// Inversion of a fixed-point distribution. The kernel declares `cdf(i)`, which must not decrease.
#import math
#import finish

struct Place {
    index: u32,
    place: f32, // within the interval, in [0, 1)
}

// First of `len` indices whose cumulative value exceeds v, clamped to the last.
fn invert_cdf(len: u32, v: u32) -> Place {
    // Empty intervals at the end share the last value: stay below it.
    let u = min(v, 0xfffffffeu);
    var low = 0u;
    var high = len - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if cdf(middle) > u {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    unfinished = unfinished || low < high;
    var start = 0u;
    if low > 0u {
        start = cdf(low - 1u);
    }
    let width = max(cdf(low) - start, 1u);
    let place = (f32(u - start) + 0.5) / f32(width);
    return Place(low, min(place, 1.0 - 1.0 / 16777216.0));
}
