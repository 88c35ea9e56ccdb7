// Pass winner: the best-matching cell of each feature, by brute force. Twin: src/twin/winner.rs.
//
// An invocation serves four features, a component of all four in a vector: the cells are read a
// quarter as often, which made this loop four times faster on a software device.
#import layout
#import math
#import finish

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    start: u32, // first feature
    features: u32, // features from there
    first: u32, // cells of this dispatch: [first, end)
    end: u32,
    pad0: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> features: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> cells: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> winners: array<u32>;
@group(0) @binding(4) var<storage, read_write> distances: array<f32>; // of the range only
@group(0) @binding(5) var<storage, read_write> status: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let item = 4u * (params.base + gid.x);

    // Gather four features by component; past the end the last one is repeated.
    let last = params.features - 1u;
    let a = 4u * (params.start + item);
    let b = 4u * (params.start + min(item + 1u, last));
    let c = 4u * (params.start + min(item + 2u, last));
    let d = 4u * (params.start + min(item + 3u, last));
    let m0 = transpose(mat4x4<f32>(features[a], features[b], features[c], features[d]));
    let m1 = transpose(mat4x4<f32>(features[a + 1u], features[b + 1u], features[c + 1u], features[d + 1u]));
    let m2 = transpose(mat4x4<f32>(features[a + 2u], features[b + 2u], features[c + 2u], features[d + 2u]));
    let x12 = vec4<f32>(features[a + 3u].x, features[b + 3u].x, features[c + 3u].x, features[d + 3u].x);

    // Go on from the best of earlier dispatches.
    var best = vec4<f32>(F32_MAX);
    var index = vec4<u32>(NONE);
    if params.first > 0u {
        for (var k = 0u; k < 4u; k++) {
            let at = min(item + k, last);
            best[k] = distances[at];
            index[k] = winners[params.start + at];
        }
    }

    // The lowest index wins among equals.
    var cell = params.first;
    for (; cell < params.end; cell++) {
        let w0 = cells[4u * cell];
        let w1 = cells[4u * cell + 1u];
        let w2 = cells[4u * cell + 2u];
        let w3 = cells[4u * cell + 3u].x;
        var e = m0[0] - w0.x;
        var sum = e * e;
        e = m0[1] - w0.y;
        sum += e * e;
        e = m0[2] - w0.z;
        sum += e * e;
        e = m0[3] - w0.w;
        sum += e * e;
        e = m1[0] - w1.x;
        sum += e * e;
        e = m1[1] - w1.y;
        sum += e * e;
        e = m1[2] - w1.z;
        sum += e * e;
        e = m1[3] - w1.w;
        sum += e * e;
        e = m2[0] - w2.x;
        sum += e * e;
        e = m2[1] - w2.y;
        sum += e * e;
        e = m2[2] - w2.z;
        sum += e * e;
        e = m2[3] - w2.w;
        sum += e * e;
        e = x12 - w3;
        sum += e * e;
        let closer = sum < best;
        best = select(best, sum, closer);
        index = select(index, vec4<u32>(cell), closer);
    }
    unfinished = unfinished || cell < params.end;
    for (var k = 0u; k < 4u; k++) {
        if item + k <= last {
            distances[item + k] = best[k];
            winners[params.start + item + k] = index[k];
        }
    }
    finish();
}
