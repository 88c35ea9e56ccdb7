// The members of a node that is stored as two texels: the layout of BvhNode in lib/layout.wgsl, bit by bit.
// `bvh` is a texture here (src/gpu/paged.rs); the rest is lib/boxes.wgsl.

fn box_texel(t: u32) -> vec4<u32> {
    return textureLoad(bvh, vec2<u32>(t % ROW, t / ROW % ROW), t / (ROW * ROW), 0);
}

fn box_min(i: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(box_texel(2u * i).xyz);
}

fn box_count(i: u32) -> u32 {
    return box_texel(2u * i).w;
}

fn box_max(i: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(box_texel(2u * i + 1u).xyz);
}

fn box_first(i: u32) -> u32 {
    return box_texel(2u * i + 1u).w;
}
