// Draws a mesh with baked light: radiosity at its corners, seen from the open front of the Cornell box.

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) radiosity: vec3f,
}

const EYE = vec3f(2.78, 2.73, -8.0);
const NEAR = 0.1;
const FAR = 100.0;
// 1 / tan(half the field of view)
const ZOOM = 2.75;
const EXPOSURE = 0.5;
const PI = 3.14159265;

@vertex
fn vertex(@location(0) position: vec3f, @location(1) light: vec4f) -> Corner {
    // Looking along +z, y up, x to the left.
    let at = (position - EYE) * vec3f(-1.0, 1.0, 1.0);
    let depth = FAR * (at.z - NEAR) / (FAR - NEAR);
    return Corner(vec4f(ZOOM * at.xy, depth, at.z), light.rgb);
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4f {
    // What a camera sees of a diffuse surface is its radiosity over pi.
    let radiance = EXPOSURE * corner.radiosity / PI;
    return vec4f(radiance / (1.0 + radiance), 1.0);
}
