//! The textbooks' read-outs of patches, to hold the nodes' against: constant, and linear between middles.

use super::Mesh;
use crate::layout::{Node, NodeLight, Point};
use crate::twin::math::tangents;
use glam::Vec3;

/// The irradiance of the patch that holds a point, scaled; 0 on what neither reflects nor emits.
pub fn constant(mesh: &Mesh, light: &[NodeLight], point: &Point) -> Vec3 {
    mesh.find(point).map_or(Vec3::ZERO, |(patch, _)| Vec3::from(light[patch as usize].h))
}

/// The irradiance at a point, scaled: between the middles of the nearest four patches of a quadrilateral chart (two of
/// a segment), continued to the chart's edges; on triangles the patch's own plane. Never below 0. A patch that no
/// light reaches is covered and takes no part.
pub fn linear(mesh: &Mesh, nodes: &[Node], light: &[NodeLight], point: &Point) -> Vec3 {
    let Some((patch, at)) = mesh.find(point) else { return Vec3::ZERO };
    let chart = &mesh.charts[mesh.patches[patch as usize].chart as usize];
    let own = &light[patch as usize];
    if chart.shape.sides == 3 {
        let node = &nodes[patch as usize];
        let (t1, t2) = tangents(Vec3::from(node.n));
        let d = Vec3::from(point.p) - Vec3::from(node.p);
        let (a, b) = (d.dot(t1) - node.mean[0], d.dot(t2) - node.mean[1]);
        return (Vec3::from(own.h) + Vec3::from(own.g0) * a + Vec3::from(own.g1) * b).max(Vec3::ZERO);
    }
    // The two middles on either side along an axis, and the share of the second; beyond the last they are continued.
    let between = |x: f64, n: u32| {
        let first = ((x - 0.5).max(0.0) as u32).min(n.saturating_sub(2));
        if n > 1 { ([first, first + 1], (x - 0.5 - first as f64) as f32) } else { ([0, 0], 0.0) }
    };
    let n = chart.cuts[0];
    let [i, j] = [between(at[0], n), between(at[1], chart.cuts[1])];
    let value = |a: usize, b: usize| {
        let h = Vec3::from(light[(chart.first + j.0[b] * n + i.0[a]) as usize].h);
        if h == Vec3::ZERO { Vec3::from(own.h) } else { h }
    };
    let row = |b: usize| value(0, b) * (1.0 - i.1) + value(1, b) * i.1;
    (row(0) * (1.0 - j.1) + row(1) * j.1).max(Vec3::ZERO)
}
