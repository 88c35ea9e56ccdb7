//! Two-sided surfaces: a twin of opposite winding for each triangle.

use super::{Face, Scene};
use std::collections::HashSet;

/// Gives every face that `wanted` names a twin of opposite winding, unless the scene holds one already
/// (on the same vertices). Both sides then reflect, and both sides of an emitter shine.
pub fn mirror(scene: &mut Scene, wanted: impl Fn(&Face) -> bool) {
    let key = |mut v: [u32; 3]| {
        let first = (0..3).min_by_key(|&k| v[k]).unwrap_or(0);
        v.rotate_left(first);
        v
    };
    let there: HashSet<[u32; 3]> = scene.faces.iter().map(|f| key(f.vertices)).collect();
    let twin = |f: &Face| Face { vertices: [f.vertices[0], f.vertices[2], f.vertices[1]], ..*f };
    let twins: Vec<Face> =
        scene.faces.iter().filter(|f| wanted(f)).map(twin).filter(|f| !there.contains(&key(f.vertices))).collect();
    scene.faces.extend(twins);
}
