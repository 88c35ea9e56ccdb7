// Pass winner: the best-matching cell of each feature, by brute force. Twin: src/twin/winner.rs.
//
// An invocation serves eight features, a component of four of them in a vector: the cells are read an
// eighth as often, and reading them is what a software device's time goes into.
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

// Four features by component.
struct Four {
    m0: mat4x4<f32>, // components 0 to 3
    m1: mat4x4<f32>,
    m2: mat4x4<f32>,
    x12: vec4<f32>,
}

// Features from `item` on; past the end the last one is repeated.
fn load(item: u32) -> Four {
    let last = params.features - 1u;
    let a = 4u * (params.start + min(item, last));
    let b = 4u * (params.start + min(item + 1u, last));
    let c = 4u * (params.start + min(item + 2u, last));
    let d = 4u * (params.start + min(item + 3u, last));
    return Four(
        transpose(mat4x4<f32>(features[a], features[b], features[c], features[d])),
        transpose(mat4x4<f32>(features[a + 1u], features[b + 1u], features[c + 1u], features[d + 1u])),
        transpose(mat4x4<f32>(features[a + 2u], features[b + 2u], features[c + 2u], features[d + 2u])),
        vec4<f32>(features[a + 3u].x, features[b + 3u].x, features[c + 3u].x, features[d + 3u].x),
    );
}

// Squared distances to a cell, summed in the order of components.
fn distance2(f: Four, w0: vec4<f32>, w1: vec4<f32>, w2: vec4<f32>, w3: f32) -> vec4<f32> {
    var e = f.m0[0] - w0.x;
    var sum = e * e;
    e = f.m0[1] - w0.y;
    sum += e * e;
    e = f.m0[2] - w0.z;
    sum += e * e;
    e = f.m0[3] - w0.w;
    sum += e * e;
    e = f.m1[0] - w1.x;
    sum += e * e;
    e = f.m1[1] - w1.y;
    sum += e * e;
    e = f.m1[2] - w1.z;
    sum += e * e;
    e = f.m1[3] - w1.w;
    sum += e * e;
    e = f.m2[0] - w2.x;
    sum += e * e;
    e = f.m2[1] - w2.y;
    sum += e * e;
    e = f.m2[2] - w2.z;
    sum += e * e;
    e = f.m2[3] - w2.w;
    sum += e * e;
    e = f.x12 - w3;
    sum += e * e;
    return sum;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let item = 8u * (params.base + gid.x);
    let last = params.features - 1u;
    let f = load(item);
    let g = load(item + 4u);

    // Go on from the best of earlier dispatches.
    var f_best = vec4<f32>(F32_MAX);
    var g_best = vec4<f32>(F32_MAX);
    var f_index = vec4<u32>(NONE);
    var g_index = vec4<u32>(NONE);
    if params.first > 0u {
        for (var k = 0u; k < 4u; k++) {
            let i = min(item + k, last);
            let j = min(item + 4u + k, last);
            f_best[k] = distances[i];
            g_best[k] = distances[j];
            f_index[k] = winners[params.start + i];
            g_index[k] = winners[params.start + j];
        }
    }

    // The lowest index wins among equals.
    var cell = params.first;
    for (; cell < params.end; cell++) {
        let w0 = cells[4u * cell];
        let w1 = cells[4u * cell + 1u];
        let w2 = cells[4u * cell + 2u];
        let w3 = cells[4u * cell + 3u].x;
        let f_d = distance2(f, w0, w1, w2, w3);
        let g_d = distance2(g, w0, w1, w2, w3);
        f_index = select(f_index, vec4<u32>(cell), f_d < f_best);
        g_index = select(g_index, vec4<u32>(cell), g_d < g_best);
        f_best = select(f_best, f_d, f_d < f_best);
        g_best = select(g_best, g_d, g_d < g_best);
    }
    unfinished = unfinished || cell < params.end;

    for (var k = 0u; k < 4u; k++) {
        if item + k <= last {
            distances[item + k] = f_best[k];
            winners[params.start + item + k] = f_index[k];
        }
        if item + 4u + k <= last {
            distances[item + 4u + k] = g_best[k];
            winners[params.start + item + 4u + k] = g_index[k];
        }
    }
    finish();
}
