// Pass readout: the network's irradiance at surface points. Twin: src/twin/readout.rs.
#import layout
#import math

struct Params {
    base: u32,
    count: u32,
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var<storage, read> nodes: array<Node>;
@group(0) @binding(2) var<storage, read> light: array<NodeLight>;
@group(0) @binding(3) var<storage, read> points: array<Point>;
@group(0) @binding(4) var<storage, read> psi: array<Psi>;
@group(0) @binding(5) var<storage, read_write> irradiance: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) gid: vec3<u32>) {
    if gid.x >= params.count {
        return;
    }
    let i = params.base + gid.x;
    let s = psi[i];
    var sum = vec3<f32>();
    var mean = 0.0;
    var square = 0.0;
    if s.weight.x == 0.0 {
        // An orphan gets the value of the node it names.
        if s.node.x != NONE {
            sum = light[s.node.x].h;
        }
    } else {
        for (var k = 0u; k < 4u; k++) {
            if s.weight[k] > 0.0 {
                let j = s.node[k];
                let t = tangents(nodes[j].n);
                let d = points[i].p - nodes[j].p;
                let a = dot3(d, t.t1) - nodes[j].mean.x;
                let b = dot3(d, t.t2) - nodes[j].mean.y;
                let says = light[j].h + light[j].g0 * a + light[j].g1 * b;
                sum += says * s.weight[k];
                let grey = (says.x + says.y + says.z) / 3.0;
                mean += grey * s.weight[k];
                square += grey * grey * s.weight[k];
            }
        }
    }
    // By how much the nodes disagree comes last.
    irradiance[i] = vec4<f32>(max(sum, vec3<f32>()), sqrt(max(square - mean * mean, 0.0)));
}
