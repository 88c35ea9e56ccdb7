// A homogeneous medium that absorbs. Twin: src/twin/way.rs.
#import math

// What it absorbs on a local length; 0: there is none.
override SIGMA: f32 = 0.0;

// e^-x for x >= 0, by polynomials: the same bits on every driver.
fn fade(x: f32) -> f32 {
    let y = x * -1.44269504;
    let whole = floor(y + 0.5);
    if whole < -126.0 {
        return 0.0;
    }
    let f = (y - whole) * 0.693147181;
    let p = 1.0 + f * (1.0 + f * (0.5 + f * (1.0 / 6.0 + f * (1.0 / 24.0 + f * (1.0 / 120.0 + f * (1.0 / 720.0))))));
    return p * bitcast<f32>(u32(i32(whole) + 127) << 23u);
}

// What arrives of light between two points that see each other.
fn between(a: vec3<f32>, b: vec3<f32>) -> f32 {
    let d = b - a;
    return fade(SIGMA * sqrt(dot3(d, d)));
}
