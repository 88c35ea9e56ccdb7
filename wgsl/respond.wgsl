// Pass respond: the output of a supervised network, and what its errors leave in the cells. Twin: src/twin/respond.rs.
#import layout
#import math
#import fixed
#import sums
#import finish

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    linear: u32, // 1: the best-matching cell answers alone, by its plane
    rows: u32, // where the neighbours' lists begin in `graph`
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> inputs: array<vec4<f32>>; // four an input
@group(0) @binding(2) var<storage, read_write> samples: array<Sample>;
@group(0) @binding(3) var<storage, read> cells: array<vec4<f32>>; // four a cell
@group(0) @binding(4) var<storage, read> outputs: array<CellOutput>;
@group(0) @binding(5) var<storage, read> graph: array<u32>; // the start of each cell's neighbours, then all of them
@group(0) @binding(6) var<storage, read_write> sums: array<atomic<u32>>; // ResponseSums, by words
@group(0) @binding(7) var<storage, read_write> status: array<atomic<u32>>;

const WORDS = 36u; // of ResponseSums
const COUNT = 26u;
const SHARE = 28u;
const ERROR = 30u;
const GAIN = 32u;
const ACTIVATION = 34u;

// |xi - w_c|^2 / sigma_c^2
fn exponent(input: u32, cell: u32) -> f32 {
    var sum = 0.0;
    for (var k = 0u; k < 13u; k++) {
        let e = inputs[4u * input + k / 4u][k % 4u] - cells[4u * cell + k / 4u][k % 4u];
        sum += e * e;
    }
    let width = outputs[cell].width;
    return sum / (width * width);
}

// The cells that answer: the best-matching one, then its neighbours.
fn answering(winner: u32, i: u32) -> u32 {
    if i == 0u {
        return winner;
    }
    return graph[params.rows + graph[winner] + i - 1u];
}

// The least exponent of all that answer, and which has it.
var<private> least: f32 = F32_MAX;
var<private> nearest: u32 = 0u;

// exp of the exponents' difference, so that none underflows: 1 of the least, whatever is fused in a difference of great numbers.
fn activation(input: u32, winner: u32, i: u32) -> f32 {
    if i == nearest {
        return 1.0;
    }
    return exp(min(least - exponent(input, answering(winner, i)), 0.0));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let input = params.base + gid.x;
    let winner = samples[input].winner;
    if winner == NONE {
        samples[input].output = 0.0;
        return;
    }
    let count = select(1u + graph[winner + 1u] - graph[winner], 1u, params.linear == 1u);

    var i = 0u;
    for (; i < count; i++) {
        let e = exponent(input, answering(winner, i));
        if e < least {
            least = e;
            nearest = i;
        }
    }
    unfinished = unfinished || i < count;
    var all = 0.0;
    i = 0u;
    for (; i < count; i++) {
        all += activation(input, winner, i);
    }
    unfinished = unfinished || i < count;

    // Answer.
    var output = 0.0;
    if params.linear == 1u {
        output = outputs[winner].value;
        for (var k = 0u; k < 13u; k++) {
            let e = inputs[4u * input + k / 4u][k % 4u] - cells[4u * winner + k / 4u][k % 4u];
            output += outputs[winner].slope[k] * e;
        }
    } else {
        i = 0u;
        for (; i < count; i++) {
            output += activation(input, winner, i) / all * outputs[answering(winner, i)].value;
        }
        unfinished = unfinished || i < count;
    }
    samples[input].output = output;

    // What the input leaves in the cells.
    let error = samples[input].goal - output;
    let weight = samples[input].weight;
    let at = WORDS * winner;
    for (var k = 0u; k < 13u; k++) {
        add_sum(at + 2u * k, inputs[4u * input + k / 4u][k % 4u], FEATURE_POWER);
    }
    let old = atomicAdd(&sums[at + COUNT], 1u);
    atomicAdd(&sums[at + COUNT + 1u], carry(old, 1u));
    add_sum(at + SHARE, weight, FEATURE_POWER);
    add_sum(at + ERROR, weight * (error * error), FEATURE_POWER);
    i = 0u;
    for (; i < count; i++) {
        let cell = answering(winner, i);
        let share = weight * (activation(input, winner, i) / all);
        add_sum(WORDS * cell + GAIN, share * error, FEATURE_POWER);
        add_sum(WORDS * cell + ACTIVATION, share, FEATURE_POWER);
    }
    unfinished = unfinished || i < count;
    finish();
}
