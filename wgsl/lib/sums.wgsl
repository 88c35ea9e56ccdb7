// Adding to the 64-bit sums of a kernel's own buffer `sums: array<atomic<u32>>`, by words.
#import fixed

fn add_sum(word: u32, value: f32, power: i32) {
    let v = encode(value, power);
    let old = atomicAdd(&sums[word], v.x);
    let hi = v.y + carry(old, v.x);
    if hi != 0u {
        atomicAdd(&sums[word + 1u], hi);
    }
}

fn add_sum3(word: u32, value: vec3<f32>, power: i32) {
    add_sum(word, value.x, power);
    add_sum(word + 2u, value.y, power);
    add_sum(word + 4u, value.z, power);
}
