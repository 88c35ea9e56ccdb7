// Pass winner: the best-matching cell of each feature, exactly. Twin: src/twin/winner.rs.
//
// Features come ordered by their receiver's place, cells in blocks of like receivers: most blocks are
// farther from all eight features of an invocation than the best cells found, and are passed over.
// Eight features at a time, a component of four in a vector: reading the cells is what a software
// device's time goes into.
#import layout
#import math
#import finish

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    features: u32, // length of `order`
    first: u32, // blocks of this dispatch: [first, end)
    end: u32,
    pad0: u32,
    pad1: u32,
}

// A block of cells and the box around their receivers.
struct Block {
    low: vec3<f32>, // y/L
    start: u32, // its cells: [start, end)
    low_n: vec3<f32>, // lambda n_y
    end: u32,
    high: vec3<f32>,
    pad0: u32,
    high_n: vec3<f32>,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> features: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> order: array<u32>; // the features to look at
@group(0) @binding(3) var<storage, read> blocks: array<Block>;
// By blocks; component 13 of a cell is its index, as a float.
@group(0) @binding(4) var<storage, read> cells: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> winners: array<u32>;
@group(0) @binding(6) var<storage, read_write> distances: array<f32>; // as `order`
@group(0) @binding(7) var<storage, read_write> status: array<atomic<u32>>;

// How much nearer than its box, relatively, rounding may make a cell.
const SLACK = 1.0 - 1e-5;

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
    let a = 4u * order[min(item, last)];
    let b = 4u * order[min(item + 1u, last)];
    let c = 4u * order[min(item + 2u, last)];
    let d = 4u * order[min(item + 3u, last)];
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

fn least(v: vec4<f32>) -> f32 {
    return min(min(v.x, v.y), min(v.z, v.w));
}

fn greatest(v: vec4<f32>) -> f32 {
    return max(max(v.x, v.y), max(v.z, v.w));
}

// The best of four features: squared distances and cells.
struct Best {
    d: vec4<f32>,
    cell: vec4<u32>,
}

// The nearer of two, among equals the lower index: blocks come in an order of their own.
fn better(best: Best, d: vec4<f32>, cell: u32) -> Best {
    let closer = (d < best.d) | ((d == best.d) & (vec4<u32>(cell) < best.cell));
    return Best(select(best.d, d, closer), select(best.cell, vec4<u32>(cell), closer));
}

// Squared distance between a block's box and another in the receivers' six dimensions.
fn gap2(block: u32, low: vec3<f32>, low_n: vec3<f32>, high: vec3<f32>, high_n: vec3<f32>) -> f32 {
    let d = max(max(blocks[block].low - high, low - blocks[block].high), vec3<f32>());
    let m = max(max(blocks[block].low_n - high_n, low_n - blocks[block].high_n), vec3<f32>());
    return dot3(d, d) + dot3(m, m);
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

    // Bound the receivers of all eight.
    let low = vec3<f32>(
        least(min(f.m1[2], g.m1[2])), least(min(f.m1[3], g.m1[3])), least(min(f.m2[0], g.m2[0])),
    );
    let high = vec3<f32>(
        greatest(max(f.m1[2], g.m1[2])), greatest(max(f.m1[3], g.m1[3])), greatest(max(f.m2[0], g.m2[0])),
    );
    let low_n = vec3<f32>(
        least(min(f.m2[1], g.m2[1])), least(min(f.m2[2], g.m2[2])), least(min(f.m2[3], g.m2[3])),
    );
    let high_n = vec3<f32>(
        greatest(max(f.m2[1], g.m2[1])), greatest(max(f.m2[2], g.m2[2])), greatest(max(f.m2[3], g.m2[3])),
    );

    // Go on from the best of earlier dispatches.
    var f_best = Best(vec4<f32>(F32_MAX), vec4<u32>(NONE));
    var g_best = f_best;
    if params.first > 0u {
        for (var k = 0u; k < 4u; k++) {
            let i = min(item + k, last);
            let j = min(item + 4u + k, last);
            f_best.d[k] = distances[i];
            g_best.d[k] = distances[j];
            f_best.cell[k] = winners[order[i]];
            g_best.cell[k] = winners[order[j]];
        }
    }

    // Begin with the nearest block, so that most others can be passed over.
    var nearest = params.first;
    var nearest_gap = F32_MAX;
    var block = params.first;
    for (; block < params.end; block++) {
        let gap = gap2(block, low, low_n, high, high_n);
        nearest = select(nearest, block, gap < nearest_gap);
        nearest_gap = min(nearest_gap, gap);
    }
    unfinished = unfinished || block < params.end;
    block = params.first;
    for (; block <= params.end; block++) {
        // The nearest one's turn comes first.
        let b = select(block - 1u, nearest, block == params.first);
        let again = block > params.first && b == nearest;
        let worst = max(greatest(f_best.d), greatest(g_best.d));
        if params.first == params.end || again || gap2(b, low, low_n, high, high_n) * SLACK > worst {
            continue;
        }
        let end = blocks[b].end;
        var cell = blocks[b].start;
        for (; cell < end; cell++) {
            let w0 = cells[4u * cell];
            let w1 = cells[4u * cell + 1u];
            let w2 = cells[4u * cell + 2u];
            let w3 = cells[4u * cell + 3u].xy;
            let index = u32(w3.y);
            f_best = better(f_best, distance2(f, w0, w1, w2, w3.x), index);
            g_best = better(g_best, distance2(g, w0, w1, w2, w3.x), index);
        }
        unfinished = unfinished || cell < end;
    }
    unfinished = unfinished || block <= params.end;

    for (var k = 0u; k < 4u; k++) {
        if item + k <= last {
            distances[item + k] = f_best.d[k];
            winners[order[item + k]] = f_best.cell[k];
        }
        if item + 4u + k <= last {
            distances[item + 4u + k] = g_best.d[k];
            winners[order[item + 4u + k]] = g_best.cell[k];
        }
    }
    finish();
}
