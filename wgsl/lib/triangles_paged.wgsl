// The members of a triangle that is stored as four texels: the layout of Tri in lib/layout.wgsl, bit by bit.
// `tris` is a texture here (src/gpu/paged.rs); the rest is lib/triangles.wgsl.

fn tri_texel(t: u32) -> vec4<u32> {
    return textureLoad(tris, vec2<u32>(t % ROW, t / ROW % ROW), t / (ROW * ROW), 0);
}

fn tri_v0(i: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(tri_texel(4u * i).xyz);
}

fn tri_material(i: u32) -> u32 {
    return tri_texel(4u * i).w;
}

fn tri_v1(i: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(tri_texel(4u * i + 1u).xyz);
}

fn tri_plane(i: u32) -> u32 {
    return tri_texel(4u * i + 1u).w;
}

fn tri_v2(i: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(tri_texel(4u * i + 2u).xyz);
}

fn tri_first_tile(i: u32) -> u32 {
    return tri_texel(4u * i + 2u).w;
}

fn tri_normal(i: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(tri_texel(4u * i + 3u).xyz);
}

fn tri_split(i: u32) -> u32 {
    return tri_texel(4u * i + 3u).w;
}
