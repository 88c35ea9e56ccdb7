//! The bounding volume hierarchy: by surface area, or where that gets too deep for the traversal stack, by halves.

use crate::layout::BvhNode;
use crate::twin::trace::STACK;
use glam::Vec3A;
use obvhs::Boundable;
use obvhs::aabb::Aabb;

/// Triangles in a leaf of the hierarchy by halves.
const LEAF: usize = 4;

/// Builds the hierarchy over boxes, root first. Also tells the order in which its leaves name them.
pub fn build<B: Boundable>(boxes: &[B]) -> (Vec<BvhNode>, Vec<usize>) {
    let params = obvhs::BvhBuildParams::medium_build();
    let bvh = obvhs::bvh2::builder::build_bvh2(boxes, params, &mut std::time::Duration::default());
    let node = |n: &obvhs::bvh2::node::Bvh2Node| node(n.aabb(), n.prim_count, n.first_index);
    let nodes: Vec<BvhNode> = bvh.nodes.iter().map(node).collect();
    if depth(&nodes) <= STACK {
        return (nodes, bvh.primitive_indices.iter().map(|&i| i as usize).collect());
    }
    // A fan of a thousand slivers about one corner: boxes within boxes, taken off one by one.
    by_halves(boxes)
}

fn node(aabb: &Aabb, count: u32, first: u32) -> BvhNode {
    BvhNode { min: aabb.min.to_array(), count, max: aabb.max.to_array(), first }
}

/// Cuts at the median along the longest side, down to leaves of [`LEAF`]: as shallow as can be.
fn by_halves<B: Boundable>(boxes: &[B]) -> (Vec<BvhNode>, Vec<usize>) {
    let boxes: Vec<Aabb> = boxes.iter().map(|b| b.aabb()).collect();
    let middle = |i: usize| boxes[i].min + boxes[i].max;
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    let mut nodes = vec![BvhNode::default()];
    let mut open = vec![(0, 0..boxes.len())];
    while let Some((at, range)) = open.pop() {
        let own = &mut order[range.clone()];
        let around = own.iter().fold(Aabb::empty(), |a, &i| a.union(&boxes[i]));
        if own.len() <= LEAF {
            nodes[at] = node(&around, own.len() as u32, range.start as u32);
            continue;
        }
        let (low, high) = own.iter().fold((Vec3A::MAX, Vec3A::MIN), |(l, h), &i| (l.min(middle(i)), h.max(middle(i))));
        let size = high - low;
        let axis = (1..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
        let half = own.len() / 2;
        // Middles that coincide are told apart by their number.
        own.select_nth_unstable_by(half, |&a, &b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b)));
        let first = nodes.len();
        nodes[at] = node(&around, 0, first as u32);
        nodes.resize(first + 2, BvhNode::default());
        open.extend([(first, range.start..range.start + half), (first + 1, range.start + half..range.end)]);
    }
    (nodes, order)
}

/// Most inner nodes on a way from the root to a leaf: what the traversal stack must hold.
pub fn depth(nodes: &[BvhNode]) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0u32, 0usize)];
    while let Some((i, above)) = stack.pop() {
        let Some(node) = nodes.get(i as usize) else { continue };
        deepest = deepest.max(above);
        if node.count == 0 {
            stack.extend([(node.first, above + 1), (node.first + 1, above + 1)]);
        }
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes within boxes: each as large as all smaller ones together.
    fn nested(n: usize) -> Vec<Aabb> {
        (0..n).map(|i| Aabb { min: Vec3A::ZERO, max: Vec3A::splat(1.0 + i as f32) }).collect()
    }

    #[test]
    fn halves_are_shallow_and_hold_every_box() {
        for n in [1, 2, 4, 5, 64, 1000, 4097] {
            let boxes = nested(n);
            let (nodes, order) = by_halves(&boxes);
            assert!(depth(&nodes) <= (n as f64).log2().ceil() as usize, "{n}");
            let mut seen = vec![0; n];
            let mut stack = vec![0usize];
            while let Some(i) = stack.pop() {
                let node = &nodes[i];
                if node.count == 0 {
                    stack.extend([node.first as usize, node.first as usize + 1]);
                    continue;
                }
                for &b in &order[node.first as usize..][..node.count as usize] {
                    seen[b] += 1;
                    let (min, max) = (Vec3A::from_array(node.min), Vec3A::from_array(node.max));
                    assert!(min.cmple(boxes[b].min).all() && max.cmpge(boxes[b].max).all());
                }
            }
            assert!(seen.iter().all(|&times| times == 1), "{n}");
            // As is whatever `build` makes of them.
            assert!(depth(&build(&boxes).0) <= STACK);
        }
    }
}
