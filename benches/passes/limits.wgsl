// Two chains of vectors, 32 multiply-adds a trip; each number tends to 1.
@group(0) @binding(0) var<storage, read_write> out: array<f32>;

@compute @workgroup_size(64)
fn fma_chain(@builtin(global_invocation_id) gid: vec3<u32>) {
    // Read, so that nothing is known before.
    let h = vec4<f32>(min(out[gid.x] + 0.5, 0.5));
    var a = vec4<f32>(0.0, 0.1, 0.2, 0.3) + h;
    var b = a + h;
    var i = 0u;
    for (; i < 1024u; i++) {
        a = fma(a, h, h);
        b = fma(b, h, h);
        a = fma(a, h, h);
        b = fma(b, h, h);
        a = fma(a, h, h);
        b = fma(b, h, h);
        a = fma(a, h, h);
        b = fma(b, h, h);
    }
    // 4, if all trips were made: every number has come to 1.
    let c = a + b;
    out[gid.x] = f32(i) * (c.x + c.y + c.z + c.w) / 2048.0;
}

@group(0) @binding(0) var<storage, read_write> sum: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> first: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> second: array<vec4<f32>>;

@compute @workgroup_size(64)
fn triad(@builtin(global_invocation_id) gid: vec3<u32>) {
    sum[gid.x] = first[gid.x] + 3.0 * second[gid.x];
}
