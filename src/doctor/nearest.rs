//! The nearest surface to a place.

use super::mesh::Mesh;
use crate::scene::nearest_on_triangle;
use glam::DVec3;

/// The nearest triangle that `counts`, within `reach` of `p`, and its nearest point; all local.
pub fn nearest(mesh: &Mesh, p: DVec3, mut reach: f64, counts: impl Fn(u32) -> bool) -> Option<(u32, DVec3)> {
    let vec = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let nodes = &mesh.geometry.nodes;
    let mut found = None;
    let mut stack = vec![0u32];
    while let Some(i) = stack.pop() {
        let node = &nodes[i as usize];
        if p.distance(p.clamp(vec(node.min), vec(node.max))) > reach {
            continue;
        }
        if node.count == 0 {
            stack.extend([node.first + 1, node.first]);
            continue;
        }
        for t in (node.first..node.first + node.count).filter(|&t| counts(t)) {
            let q = nearest_on_triangle(p, mesh.triangle(t));
            if p.distance(q) <= reach {
                reach = p.distance(q);
                found = Some((t, q));
            }
        }
    }
    found
}
