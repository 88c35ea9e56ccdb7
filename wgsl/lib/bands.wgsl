// The colour bands of the solve: three. For scenes that are all grey the host takes lib/bands_one.wgsl in its place.

alias Bands = vec3<f32>;
// As an array holds them.
alias Packed = vec4<f32>;

// A node's light: NodeLight of lib/layout.wgsl.
struct Light {
    h: Bands,
    g0: Bands,
    g1: Bands,
}

fn packed(b: Bands) -> Packed {
    return vec4<f32>(b, 0.0);
}

fn unpacked(p: Packed) -> Bands {
    return p.xyz;
}

fn of_three(b: vec3<f32>) -> Bands {
    return b;
}
