// The members of a node of the hierarchy. The kernel binds `bvh: array<BvhNode>`. For scenes that exceed one binding the
// host takes lib/boxes_paged.wgsl in its place.

fn box_min(i: u32) -> vec3<f32> {
    return bvh[i].min;
}

fn box_count(i: u32) -> u32 {
    return bvh[i].count;
}

fn box_max(i: u32) -> vec3<f32> {
    return bvh[i].max;
}

fn box_first(i: u32) -> u32 {
    return bvh[i].first;
}
