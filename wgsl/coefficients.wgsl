// Pass coefficients, first kernel: masses of the nodes and footprints of the cells. Twin: src/twin/coefficients.rs.
//
// A cell has two rows of `slots` slots, for its gather and its deposit side: hash tables with the
// node as key and linear probing. Where a slot ends up depends on the order of invocations, what it
// holds does not; the host sorts the rows.
#import layout
#import math
#import fixed
#import sums
#import finish

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    first: u32, // cells of this dispatch: [first, end)
    end: u32,
    slots: u32, // a row, a power of two
    masses: u32, // 1: sum the nodes' masses, too
    normalise: f32, // what weights are multiplied by
    rays: f32, // number of rays n
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> points: array<Point>;
@group(0) @binding(2) var<storage, read> psi: array<Psi>;
@group(0) @binding(3) var<storage, read> winners: array<u32>;
@group(0) @binding(4) var<storage, read> nodes: array<Node>;
@group(0) @binding(5) var<storage, read_write> rows: array<atomic<u32>>; // Slots, by words
@group(0) @binding(6) var<storage, read_write> sums: array<atomic<u32>>; // NodeSums, by words
@group(0) @binding(7) var<storage, read_write> overflow: array<atomic<u32>>; // 1: a row was full
@group(0) @binding(8) var<storage, read_write> status: array<atomic<u32>>;

const SLOT_WORDS = 8u;
const NODE_WORDS = 16u;

// Offsets of a point from a node along the node's tangents.
fn offsets(node: u32, p: vec3<f32>) -> vec2<f32> {
    let t = tangents(nodes[node].n);
    let d = p - nodes[node].p;
    return vec2<f32>(dot3(d, t.t1), dot3(d, t.t2));
}

fn add_row(word: u32, value: f32) {
    let v = encode(value, POWER);
    let old = atomicAdd(&rows[word], v.x);
    let hi = v.y + carry(old, v.x);
    if hi != 0u {
        atomicAdd(&rows[word + 1u], hi);
    }
}

// Masses take the whole ray, cells what of its light arrives.
var<private> carried: f32;

// Finds or takes the slot of a node in a row and adds to it.
fn add(row: u32, node: u32, value: f32, first: f32, second: f32) {
    let key = node + 1u;
    var probe = hash(node) & (params.slots - 1u);
    var at = 0u;
    var found = false;
    // A weak exchange may fail for nothing and is tried again, hence twice the slots.
    for (var k = 0u; k < 2u * params.slots && !found; k++) {
        at = SLOT_WORDS * (row * params.slots + probe);
        var held = atomicLoad(&rows[at]);
        if held == 0u {
            let swap = atomicCompareExchangeWeak(&rows[at], 0u, key);
            held = select(swap.old_value, key, swap.exchanged);
        }
        found = held == key;
        if held != 0u && !found {
            probe = (probe + 1u) & (params.slots - 1u);
        }
    }
    if !found {
        atomicMax(&overflow[0], 1u);
        return;
    }
    if LOSSY {
        add_row(at + 2u, value * carried);
        add_row(at + 4u, first * carried);
        add_row(at + 6u, second * carried);
    } else {
        add_row(at + 2u, value);
        add_row(at + 4u, first);
        add_row(at + 6u, second);
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let d = params.base + gid.x;
    let w = points[d].weight * params.normalise;
    if w <= 0.0 {
        return;
    }
    let cell = winners[d];
    let counts = points[d].kind == FRONT && cell >= params.first && cell < params.end;
    let row = 2u * (cell - params.first);

    if LOSSY {
        carried = points[d | 1u].density;
    }

    // Whatever arrives around a node has mass; the receiver end deposits.
    let here = psi[d];
    for (var k = 0u; k < 4u; k++) {
        if here.weight[k] > 0.0 {
            let node = here.node[k];
            let o = offsets(node, points[d].p);
            let v = w * here.weight[k];
            if params.masses == 1u {
                let at = NODE_WORDS * node;
                add_sum(at, v, POWER);
                add_sum(at + 2u, v * o.x, POWER);
                add_sum(at + 4u, v * o.y, POWER);
                add_sum(at + 6u, v * o.x * o.x, POWER);
                add_sum(at + 8u, v * o.x * o.y, POWER);
                add_sum(at + 10u, v * o.y * o.y, POWER);
                add_sum(at + 12u, (v * params.rays) * v, POWER);
            }
            if counts {
                add(row + 1u, node, v, v * o.x, v * o.y);
            }
        }
    }

    // The emitter end gathers; an orphan borrows the value of the node it names.
    if counts {
        let there = psi[d ^ 1u];
        if there.weight.x == 0.0 {
            if there.node.x != NONE {
                add(row, there.node.x, w, 0.0, 0.0);
            }
        } else {
            for (var k = 0u; k < 4u; k++) {
                if there.weight[k] > 0.0 {
                    let node = there.node[k];
                    let o = offsets(node, points[d ^ 1u].p);
                    let v = w * there.weight[k];
                    add(row, node, v, v * o.x, v * o.y);
                }
            }
        }
    }
    finish();
}
