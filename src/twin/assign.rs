//! Pass `assign`: the nodes that speak for a surface point, by the four rules of design §1.4.

use super::trace::{Ray, closest, segment_blocked};
use crate::layout::{Candidate, NONE, Node, Point, Psi};
use crate::network::groups::Groups;
use crate::scene::Geometry;
use glam::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Nearest candidates that are looked at.
pub const NEAREST: usize = 9;
/// Normals must agree to this cosine.
pub const CONE: f32 = 0.7;
/// Share of the distance by which one point may lie off the other's plane.
pub const PLANE: f32 = 0.3;
/// The same in absolute terms, in units of L.
pub const PLANE_FLOOR: f32 = 1e-3;
/// The segment between both points is lifted along the normals by this share of their distance.
pub const LIFT: f32 = 0.1;

/// Least lift, local; what lies this little behind a plane lies on it.
const FLOOR: f32 = 2e-6;

/// A surface network as the passes read it: nodes, and each tile's candidates in CSR form.
///
/// A tile's list holds every node of its material and cone that can be among the nearest nine of any
/// point of the tile, so that the search over the list is exact. So does a list that tiles share, and others beside.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Groups of tiles that share a list, where there are many; else each has its own.
    pub groups: Option<Arc<Groups>>,
    /// Start of each list of candidates; one more entry than lists.
    pub offsets: Vec<u32>,
    /// Candidates of all lists.
    pub candidates: Vec<Candidate>,
    /// 1/L, per local length.
    pub inv_unit: f32,
    /// Weight lambda of normals.
    pub lambda: f32,
}

/// Squared distance in the metric (y/L, lambda n).
pub fn distance2(surface: &Surface, p: Vec3, n: Vec3, node: &Node) -> f32 {
    let d = (p - Vec3::from(node.p)) * surface.inv_unit;
    let m = (n - Vec3::from(node.n)) * surface.lambda;
    d.dot(d) + m.dot(m)
}

/// The planar pieces that a segment between a point and a node need not look at: their own, unless one lies behind the
/// other's plane by more than the turn of their normals explains, as of two sheets that face the same way.
pub fn crossed(p: Vec3, n: Vec3, plane: u32, node: &Node) -> [u32; 2] {
    let (d, m) = (p - Vec3::from(node.p), Vec3::from(node.n));
    let turn = ((n - m).dot(n - m) * d.dot(d)).sqrt() + FLOOR;
    [if d.dot(n) > turn { NONE } else { plane }, if -d.dot(m) > turn { NONE } else { node.plane }]
}

/// Whether a node is in sight of a point: the segment between them, lifted along both normals, is free. Neither end is lifted
/// by more than half of the way up that is free there (`reach` at the point), so that in a slot it stays in the slot.
fn in_sight(geometry: &Geometry, p: Vec3, n: Vec3, plane: u32, reach: f32, node: &Node) -> bool {
    let (q, m) = (Vec3::from(node.p), Vec3::from(node.n));
    let d = p - q;
    let lift = (LIFT * d.dot(d).sqrt()).max(FLOOR);
    let (here, there) = (lift.min(0.5 * reach), lift.min(0.5 * node.clear));
    !segment_blocked(geometry, p + n * here, q + m * there, crossed(p, n, plane, node))
}

/// The weights of one point. Points without a triangle or a tile have none.
pub fn weights(geometry: &Geometry, surface: &Surface, point: &Point) -> Psi {
    if point.tri == NONE || point.tile == NONE {
        return Psi::EMPTY;
    }
    let tri = &geometry.tris[point.tri as usize];
    let (p, n) = (Vec3::from(point.p), Vec3::from(tri.normal));

    // Keep the nearest candidates in order; the earlier of two equals comes first.
    let mut near = [(f32::MAX, Candidate { node: NONE, free: 0 }); NEAREST];
    let list = surface.groups.as_ref().map_or(point.tile, |groups| groups.of_tile[point.tile as usize]) as usize;
    for c in surface.offsets[list]..surface.offsets[list + 1] {
        // A list of several tiles holds nodes of other cones, too.
        let node = &surface.nodes[surface.candidates[c as usize].node as usize];
        if surface.groups.is_some() && n.dot(Vec3::from(node.n)) <= CONE {
            continue;
        }
        let mut item = (distance2(surface, p, n, node), surface.candidates[c as usize]);
        for slot in near.iter_mut() {
            if item.0 < slot.0 {
                std::mem::swap(&mut item, slot);
            }
        }
    }

    // How far is it up from the point? Asked where a candidate needs a ray.
    let mut reach = None;
    let mut sees = |node: &Node, near: &[(f32, Candidate)]| {
        let reach = *reach.get_or_insert_with(|| {
            let length = |c: &Candidate| (p - Vec3::from(surface.nodes[c.node as usize].p)).length();
            let far = near.iter().filter(|x| x.1.node != NONE).map(|x| length(&x.1)).fold(0.0, f32::max);
            let up = Ray { origin: p, direction: n, t_max: 2.0 * (LIFT * 1.001 * far + 2.0 * FLOOR), skip: [tri.plane, NONE] };
            closest(geometry, &up).t
        });
        in_sight(geometry, p, n, tri.plane, reach, node)
    };

    // Take the first five that are compatible; the fifth only sets the radius.
    let mut found = [(0.0f32, NONE); 5];
    let mut count = 0;
    for (d2, c) in near {
        if c.node == NONE || count == 5 {
            break;
        }
        let node = &surface.nodes[c.node as usize];
        let d = p - Vec3::from(node.p);
        let length = d.dot(d).sqrt();
        let off = d.dot(Vec3::from(node.n)).abs().max(d.dot(n).abs());
        if off * surface.inv_unit >= PLANE * length * surface.inv_unit + PLANE_FLOOR {
            continue;
        }
        if c.free == 0 && !sees(node, &near) {
            continue;
        }
        found[count] = (d2, c.node);
        count += 1;
    }
    if count == 0 {
        // An orphan names the nearest node in sight, whatever its plane.
        let mut psi = Psi::EMPTY;
        for (_, c) in near {
            if c.node == NONE || psi.node[0] != NONE {
                break;
            }
            if c.free == 1 || sees(&surface.nodes[c.node as usize], &near) {
                psi.node[0] = c.node;
            }
        }
        return psi;
    }
    let radius2 = if count == 5 { found[4].0 } else { 2.25 * found[count - 1].0 }.max(1e-20);
    let mut psi = Psi::EMPTY;
    let mut sum = 0.0;
    for k in 0..count.min(4) {
        // The small term keeps the sum positive where all five are equally far.
        let t = (1.0 - found[k].0 / radius2).max(0.0) + 1e-6;
        psi.node[k] = found[k].1;
        psi.weight[k] = t * t;
        sum += psi.weight[k];
    }
    psi.weight = psi.weight.map(|w| w / sum);
    psi
}

/// The weights of many points.
pub fn assign(geometry: &Geometry, surface: &Surface, points: &[Point]) -> Vec<Psi> {
    points.par_iter().map(|p| weights(geometry, surface, p)).collect()
}
