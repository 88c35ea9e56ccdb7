// Draws a mesh with the radiosity at its corners, looked at along +z.

struct Camera {
    middle: vec3f,
    back: f32,
    aspect: f32,
}

@group(0) @binding(0) var<uniform> camera: Camera;

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) radiosity: vec3f,
}

const ZOOM = 2.75;
const EXPOSURE = 2.0;
const PI = 3.14159265;

@vertex
fn vertex(@location(0) position: vec3f, @location(1) light: vec4f) -> Corner {
    let at = (position - camera.middle) * vec3f(-1.0, 1.0, 1.0) + vec3f(0.0, 0.0, camera.back);
    let near = 0.1 * camera.back;
    let far = 3.0 * camera.back;
    let depth = far * (at.z - near) / (far - near);
    return Corner(vec4f(ZOOM * at.x / camera.aspect, ZOOM * at.y, depth, at.z), light.rgb);
}

@fragment
fn fragment(corner: Corner) -> @location(0) vec4f {
    // What a camera sees of a diffuse surface is its radiosity over pi. The target takes sRGB values.
    let radiance = EXPOSURE * corner.radiosity / PI;
    return vec4f(pow(radiance / (1.0 + radiance), vec3f(1.0 / 2.2)), 1.0);
}
