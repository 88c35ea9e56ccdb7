// The members of a triangle. The kernel binds `tris: array<Tri>`. For scenes that exceed one binding the host takes
// lib/triangles_paged.wgsl in its place.

fn tri_v0(i: u32) -> vec3<f32> {
    return tris[i].v0;
}

fn tri_material(i: u32) -> u32 {
    return tris[i].material;
}

fn tri_v1(i: u32) -> vec3<f32> {
    return tris[i].v1;
}

fn tri_plane(i: u32) -> u32 {
    return tris[i].plane;
}

fn tri_v2(i: u32) -> vec3<f32> {
    return tris[i].v2;
}

fn tri_first_tile(i: u32) -> u32 {
    return tris[i].first_tile;
}

fn tri_normal(i: u32) -> vec3<f32> {
    return tris[i].normal;
}

fn tri_split(i: u32) -> u32 {
    return tris[i].split;
}
