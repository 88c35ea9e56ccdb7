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

impl Surface {
    /// The candidates in a list; none where lists have not been made.
    pub fn list(&self, list: usize) -> &[Candidate] {
        match self.offsets.get(list..list + 2) {
            Some(ends) => &self.candidates[ends[0] as usize..ends[1] as usize],
            None => &[],
        }
    }
}

/// Squared distance in the metric (y/L, lambda n).
pub fn distance2(surface: &Surface, p: Vec3, n: Vec3, node: &Node) -> f32 {
    let d = (p - Vec3::from(node.p)) * surface.inv_unit;
    let m = (n - Vec3::from(node.n)) * surface.lambda;
    d.dot(d) + m.dot(m)
}

/// How a point and a node lie to each other.
#[derive(Clone, Copy, Debug)]
pub struct Between {
    /// How far the node lies behind the point's plane, and the point behind the node's, local.
    behind: [f32; 2],
    /// How far behind the turn of their normals explains, as of an edge or a curve between them.
    turn: f32,
    /// Cosine between their normals.
    cosine: f32,
    /// How far the segment between them is lifted at both ends: by [`LIFT`], and over such an edge.
    pub lift: f32,
}

impl Between {
    /// Of a point with its normal, and a node.
    pub fn new(p: Vec3, n: Vec3, node: &Node) -> Between {
        let (d, m) = (p - Vec3::from(node.p), Vec3::from(node.n));
        let turn = ((n - m).dot(n - m) * d.dot(d)).sqrt() + FLOOR;
        let (behind, cosine) = ([d.dot(n), -d.dot(m)], n.dot(m));
        let over = behind.map(|x| if x <= turn { x } else { 0.0 });
        let lift = (LIFT * d.dot(d).sqrt()).max(FLOOR).max(over[0].max(over[1]) / cosine);
        Between { behind, turn, cosine, lift }
    }

    /// Whether neither lies behind the other's plane: no lift takes one of them through it.
    pub fn is_level(&self) -> bool {
        self.behind[0] <= FLOOR && self.behind[1] <= FLOOR
    }

    /// The planes that the segment need not look at, of those of the point and the node, where the point and the node are
    /// lifted so far: the plane that the other end lies behind only as an edge explains it, and is lifted over. Of two sheets
    /// that face the same way, or where one surface runs into another, the plane hides what lies behind.
    pub fn crossed(&self, plane: u32, node: &Node, lifts: [f32; 2]) -> [u32; 2] {
        let hides = |behind: f32, lift: f32| behind > self.turn || behind > lift * self.cosine + FLOOR;
        let ([there, here], [own, other]) = (self.behind, lifts);
        [if hides(there, other) { NONE } else { plane }, if hides(here, own) { NONE } else { node.plane }]
    }
}

/// Whether a node is in sight of a point: the segment between them, lifted along both normals, is free. Neither end is lifted
/// by more than half of the way up that is free there (`reach` at the point), so that in a slot it stays in the slot.
fn in_sight(geometry: &Geometry, p: Vec3, n: Vec3, plane: u32, reach: f32, node: &Node) -> bool {
    let (q, m, between) = (Vec3::from(node.p), Vec3::from(node.n), Between::new(p, n, node));
    let lifts = [reach, node.clear].map(|clear| between.lift.min(0.5 * clear));
    !segment_blocked(geometry, p + n * lifts[0], q + m * lifts[1], between.crossed(plane, node, lifts))
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
    for &candidate in surface.list(list) {
        // A list of several tiles holds nodes of other cones, too.
        let node = &surface.nodes[candidate.node as usize];
        if surface.groups.is_some() && n.dot(Vec3::from(node.n)) <= CONE {
            continue;
        }
        let mut item = (distance2(surface, p, n, node), candidate);
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
            let lift = |c: &Candidate| Between::new(p, n, &surface.nodes[c.node as usize]).lift;
            let most = near.iter().filter(|x| x.1.node != NONE).map(|x| lift(&x.1)).fold(0.0, f32::max);
            let up = Ray { origin: p, direction: n, t_max: 2.0 * (1.001 * most + 2.0 * FLOOR), skip: [tri.plane, NONE] };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::nodes::surface_of;
    use crate::scene::shapes::{Triangles, block, moved, quad};
    use crate::scene::{Material, Scene};
    use crate::twin::trace::{barycentric, surface_point};
    use glam::DVec3;

    fn geometry(t: &Triangles) -> Geometry {
        Geometry::new(&Scene::from_triangles("assign", t, vec![Material::new("grey", [0.5; 3], [0.0; 3])]).unwrap()).unwrap()
    }

    fn point(g: &Geometry, p: DVec3, n: DVec3) -> Point {
        let at = g.locate(p.to_array(), n.to_array()).unwrap();
        let (b1, b2) = barycentric(g.flatland, &g.tris[at.tri as usize], Vec3::from(at.p));
        surface_point(g, at.tri, b1, b2)
    }

    /// Who speaks for a point, where there is a node at one other point.
    fn speaker(g: &Geometry, [p, q]: [[DVec3; 2]; 2]) -> Psi {
        let (p, q) = (point(g, p[0], p[1]), point(g, q[0], q[1]));
        let t = &g.tris[q.tri as usize];
        let node = Node { p: q.p, material: t.material, n: t.normal, plane: t.plane, gain: 1.0, ..Node::default() };
        weights(g, &surface_of(g, vec![node], 0.3, false), &p)
    }

    #[test]
    fn an_edge_is_seen_around_and_a_face_is_not_seen_through() {
        let (sin, cos) = 20f64.to_radians().sin_cos();
        let turned = |p: [f64; 3]| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1], p[2]];
        let up = [DVec3::Y, DVec3::from(turned([0.0, 1.0, 0.0]))];
        // Two blocks that run through each other: left of the middle the turned one's top lies in the other.
        let level = block([-1.0, -1.0, -1.0], [1.0, 0.0, 1.0], 0);
        let ramp = moved(block([-0.9, -0.9, -0.9], [0.9, 0.0, 0.9], 0), turned);
        let both = geometry(&[level, ramp].concat());
        let on_level = |x: f64| [DVec3::new(x, 0.0, 0.05), up[0]];
        let on_ramp = |x: f64| [DVec3::from(turned([x, 0.0, 0.0])), up[1]];
        assert_eq!(speaker(&both, [on_level(-0.3), on_ramp(-0.1)]), Psi::EMPTY, "through the level top");
        assert_eq!(speaker(&both, [on_ramp(-0.1), on_level(-0.3)]), Psi::EMPTY, "out of the level block");
        assert_eq!(speaker(&both, [on_ramp(0.3), on_level(0.1)]), Psi::EMPTY, "through the ramp");
        assert_eq!(speaker(&both, [on_level(-0.3), on_level(-0.1)]).weight[0], 1.0);
        // A roof: its left half is level, its right one turned down.
        let half = |x: [f64; 2]| quad([[x[0], 0.0, -1.0], [x[0], 0.0, 1.0], [x[1], 0.0, 1.0], [x[1], 0.0, -1.0]], 0);
        let down = |p: [f64; 3]| [cos * p[0] + sin * p[1], cos * p[1] - sin * p[0], p[2]];
        let roof = geometry(&[half([-1.0, 0.0]), moved(half([0.0, 1.0]), down)].concat());
        let left = [DVec3::new(-0.1, 0.0, 0.05), up[0]];
        let right = [DVec3::from(down([0.2, 0.0, 0.0])), DVec3::from(down([0.0, 1.0, 0.0]))];
        for ends in [[left, right], [right, left]] {
            assert_eq!(speaker(&roof, ends).weight[0], 1.0);
        }
    }
}
