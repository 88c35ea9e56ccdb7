// Pass adapt: cells move to the mean of their rays, drawn by their neighbours. Twin: src/twin/adapt.rs.
#import layout
#import finish

struct Params {
    base: u32,
    count: u32,
    flag: u32,
    eta: f32, // how strongly neighbours draw; 0: Lloyd
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> cells: array<f32>; // sixteen a cell
@group(0) @binding(2) var<storage, read> sums: array<CellSums>;
@group(0) @binding(3) var<storage, read> offsets: array<u32>;
@group(0) @binding(4) var<storage, read> neighbours: array<u32>;
@group(0) @binding(5) var<storage, read_write> moved_cells: array<f32>;
@group(0) @binding(6) var<storage, read_write> status: array<atomic<u32>>;

fn value(cell: u32, k: u32) -> f32 {
    let f = sums[cell].feature[k];
    return f32(bitcast<i32>(f.hi)) + f32(f.lo) / 4294967296.0;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let c = params.base + gid.x;
    let start = offsets[c];
    let end = offsets[c + 1u];
    var share = 0.0;
    if end > start {
        share = params.eta / f32(end - start);
    }
    var count = f32(sums[c].count.lo);
    var moved: array<f32, 13>;
    for (var k = 0u; k < 13u; k++) {
        moved[k] = value(c, k);
    }
    if share > 0.0 {
        var i = start;
        for (; i < end; i++) {
            let n = neighbours[i];
            count += share * f32(sums[n].count.lo);
            for (var k = 0u; k < 13u; k++) {
                moved[k] += share * value(n, k);
            }
        }
        unfinished = unfinished || i < end;
    }
    // Cells without a ray stay where they are.
    for (var k = 0u; k < 16u; k++) {
        var x = cells[16u * c + k];
        if k < 13u && count > 0.0 {
            x = moved[min(k, 12u)] / count;
        }
        moved_cells[16u * c + k] = x;
    }
    finish();
}
