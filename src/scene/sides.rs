//! Two-sided surfaces: a twin of opposite winding for each triangle or flatland segment.

use super::{Face, Scene};
use std::collections::HashSet;
use std::ops::Range;

/// Gives every face that `wanted` names a twin of opposite winding, unless the scene holds one already
/// (on the same vertices). Both sides then reflect, and both sides of an emitter shine.
pub fn mirror(scene: &mut Scene, wanted: impl Fn(&Face) -> bool) {
    let all = 0..scene.faces.len();
    mirror_range(scene, all, wanted);
}

/// As [`mirror`], of the faces in a range, among which twins are looked for.
pub fn mirror_range(scene: &mut Scene, range: Range<usize>, wanted: impl Fn(&Face) -> bool) {
    let first = range.start;
    let faces = &scene.faces[range];
    if !faces.iter().any(&wanted) {
        return;
    }
    let key = |mut v: [u32; 3]| {
        let first = (0..3).min_by_key(|&k| v[k]).unwrap_or(0);
        v.rotate_left(first);
        v
    };
    let there: HashSet<[u32; 3]> = faces.iter().map(|f| key(f.vertices)).collect();
    let turned = |[a, b, c]: [u32; 3]| if b == c { [b, a, a] } else { [a, c, b] };
    let twin = |f: &Face| Face { vertices: turned(f.vertices), ..*f };
    let lacks = |(_, f): &(usize, &Face)| wanted(f) && !there.contains(&key(twin(f).vertices));
    let twins: Vec<(usize, Face)> = faces.iter().enumerate().filter(lacks).map(|(i, f)| (first + i, twin(f))).collect();
    for (of, twin) in twins {
        if let Some(&[a, b, c]) = scene.face_uvs.get(of) {
            scene.set_uv(scene.faces.len(), [a, c, b]);
        }
        scene.faces.push(twin);
    }
}
