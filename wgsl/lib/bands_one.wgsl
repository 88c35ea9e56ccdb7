// The colour bands of the solve where all is grey: one, a quarter of the bytes of lib/bands.wgsl, to the same bits.

alias Bands = f32;
alias Packed = f32;

struct Light {
    h: Bands,
    g0: Bands,
    g1: Bands,
}

fn packed(b: Bands) -> Packed {
    return b;
}

fn unpacked(p: Packed) -> Bands {
    return p;
}

fn of_three(b: vec3<f32>) -> Bands {
    return b.x;
}
