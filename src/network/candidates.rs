//! Which nodes can speak for the points of a tile: the lists that searches are made over (design §1.4), and which of their
//! nodes need no ray to be seen.

use super::boxes::{Boxes, Key};
use super::groups::Extent;
use super::tiles::tile_corners;
use crate::layout::{Candidate, Node};
use crate::scene::Geometry;
use crate::twin::assign::{Between, CONE, NEAREST, Surface};
use glam::Vec3;
use rayon::prelude::*;

/// Lists that one thread finds at a time.
const CHUNK: usize = 256;

/// Lists for every tile, or group of them, the nodes that can be among the nearest of any of its points. `mark`: marks also the
/// candidates that nothing can hide from their tile, so that no ray need be shot. That takes box queries, which many points pay
/// for; the weights are the same without.
pub fn find(geometry: &Geometry, surface: &mut Surface, mark: bool) {
    find_some(geometry, surface, &vec![true; geometry.lists()], mark);
}

/// The lists of some tiles, for [`find_some`].
pub fn of_tiles(geometry: &Geometry, tiles: impl Iterator<Item = u32>) -> Vec<bool> {
    let mut asked = vec![false; geometry.lists()];
    for tile in tiles {
        asked[geometry.groups.as_ref().map_or(tile, |groups| groups.of_tile[tile as usize]) as usize] = true;
    }
    asked
}

/// As [`find`] for the lists that are asked of; all others stay as they are, or empty.
pub fn find_some(geometry: &Geometry, surface: &mut Surface, asked: &[bool], mark: bool) {
    surface.groups = geometry.groups.clone();
    let boxes = Boxes::new(geometry, surface);
    let before = &*surface;
    let found: Vec<(Vec<u32>, Vec<Candidate>)> = asked
        .par_chunks(CHUNK)
        .enumerate()
        .map(|(chunk, asked)| {
            let mut search = Search::new(before, &boxes);
            let (mut lengths, mut found) = (Vec::with_capacity(CHUNK), Vec::new());
            for (list, &asked) in (chunk * CHUNK..).zip(asked) {
                let first = found.len();
                match (asked, &geometry.groups) {
                    (false, _) => found.extend_from_slice(before.list(list)),
                    (true, Some(groups)) => search.list(groups.extent(list), &mut found),
                    (true, None) => search.list(&Extent::of_tile(geometry, list as u32), &mut found),
                }
                lengths.push((found.len() - first) as u32);
            }
            (lengths, found)
        })
        .collect();
    (surface.offsets, surface.candidates) = (vec![0], Vec::with_capacity(found.iter().map(|chunk| chunk.1.len()).sum()));
    let mut end = 0;
    for (lengths, candidates) in found {
        surface.offsets.extend(lengths.iter().map(|length| {
            end += length;
            end
        }));
        surface.candidates.extend(candidates);
    }
    if mark {
        mark_free(geometry, surface, asked);
    }
}

/// Looks for the nodes around places, one after the other.
struct Search<'a> {
    surface: &'a Surface,
    boxes: &'a Boxes,
    /// Lists follow each other by place: most find the boxes around them where the one before had them.
    last: Option<Key>,
    around: Vec<u32>,
    near: Vec<(f32, u32)>,
    sure: Vec<f32>,
}

impl<'a> Search<'a> {
    fn new(surface: &'a Surface, boxes: &'a Boxes) -> Search<'a> {
        Search { surface, boxes, last: None, around: Vec::new(), near: Vec::new(), sure: Vec::new() }
    }

    /// Lists the nodes that can be among the nearest of any point of an extent. Where its normals differ, nodes of other
    /// cones than a point's own are among them: whoever reads the list asks.
    fn list(&mut self, extent: &Extent, found: &mut Vec<Candidate>) {
        let boxes = self.boxes;
        let own = boxes.of_material(extent.material);
        if own.is_empty() {
            return;
        }
        let here = boxes.key(extent.material, extent.centre);
        if self.last != Some(here) {
            self.last = Some(here);
            self.around.clear();
            self.around.extend(boxes.around(here));
        }
        let around = std::mem::take(&mut self.around);
        if self.within_reach(extent, &around) > 0.999 * boxes.width {
            self.within_reach(extent, own);
        }
        self.around = around;
        self.near.sort_unstable_by_key(|x| x.1);
        found.extend(self.near.iter().map(|x| Candidate { node: x.1, free: 0 }));
    }

    /// Finds those of some nodes that are near enough, and how far that is.
    fn within_reach(&mut self, extent: &Extent, nodes: &[u32]) -> f32 {
        let (inv, lambda) = (self.surface.inv_unit, self.surface.lambda);
        // Normals whose ends are nearer than this are in each other's cone; rounding is granted.
        let cone = (2.0 - 2.0 * CONE).sqrt();
        self.near.clear();
        self.sure.clear();
        for &i in nodes {
            let node = &self.surface.nodes[i as usize];
            let (d, m) = ((extent.centre - Vec3::from(node.p)) * inv, extent.normal - Vec3::from(node.n));
            let [maybe, surely] = match extent.spread == 0.0 {
                true => [Vec3::from(node.n).dot(extent.normal) > CONE; 2],
                false => {
                    let apart = m.length();
                    [apart - extent.spread < cone * (1.0 + 1e-5), apart + extent.spread < cone * (1.0 - 1e-5)]
                }
            };
            let distance = (d.dot(d) + lambda * lambda * m.dot(m)).sqrt();
            if maybe {
                self.near.push((distance, i));
            }
            if surely {
                self.sure.push(distance);
            }
        }
        if self.sure.len() < NEAREST {
            return f32::INFINITY;
        }
        self.sure.select_nth_unstable_by(NEAREST - 1, f32::total_cmp);
        // How much nearer, or farther, a point may be to a node than the centre is: nodes beyond `reach` are not among the
        // nearest of any.
        let slack = (extent.radius * inv).hypot(lambda * extent.spread);
        let reach = (self.sure[NEAREST - 1] + 2.0 * slack) * (1.0 + 1e-5);
        self.near.retain(|x| x.0 <= reach);
        reach
    }
}

/// Leaves out the nodes that no ray has met, whose light nobody knows: a point near them is better gathered for. Returns
/// whether there were any.
pub fn leave_out_empty(geometry: &Geometry, surface: &mut Surface, mass: &[f64], mark: bool) -> bool {
    for (node, _) in surface.nodes.iter_mut().zip(mass).filter(|(_, m)| **m <= 0.0) {
        node.gain = -1.0;
    }
    if surface.nodes.iter().all(|node| node.gain >= 0.0) {
        return false;
    }
    // A list that none of them is in has all that it needs.
    let empty = |c: &Candidate| surface.nodes[c.node as usize].gain < 0.0;
    let asked: Vec<bool> = (0..geometry.lists()).into_par_iter().map(|list| surface.list(list).iter().any(empty)).collect();
    find_some(geometry, surface, &asked, mark);
    true
}

/// Whether so many rays save more by marks than finding them takes. Lists that tiles share have none.
pub fn worth_marking(geometry: &Geometry, rays: u32) -> bool {
    rays >= geometry.tiles && geometry.groups.is_none()
}

/// Marks what nothing can hide from the tiles that are asked of.
fn mark_free(geometry: &Geometry, surface: &mut Surface, asked: &[bool]) {
    let free: Vec<Vec<u32>> = (0..geometry.tiles as usize)
        .into_par_iter()
        .map(|tile| {
            let list = surface.list(tile);
            if !asked[tile] {
                return list.iter().map(|c| c.free).collect();
            }
            let own: Vec<&Node> = list.iter().map(|c| &surface.nodes[c.node as usize]).collect();
            let tri = &geometry.tris[geometry.tile_tri[tile] as usize];
            let (corners, n) = (tile_corners(geometry, tile as u32), Vec3::from(tri.normal));
            // Ask for all at once before asking for each.
            let alone = is_free(geometry, &corners, n, tri.plane, &own);
            own.iter().map(|&node| (alone || is_free(geometry, &corners, n, tri.plane, &[node])) as u32).collect()
        })
        .collect();
    for (candidate, free) in surface.candidates.iter_mut().zip(free.into_iter().flatten()) {
        candidate.free = free;
    }
}

/// Whether no triangle outside the planes of the tile and the nodes touches the box around all
/// lifted segments between them.
fn is_free(geometry: &Geometry, corners: &[Vec3; 3], n: Vec3, plane: u32, nodes: &[&Node]) -> bool {
    let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
    let mut take = |v: Vec3| {
        low = low.min(v);
        high = high.max(v);
    };
    for node in nodes {
        let q = Vec3::from(node.p);
        for &c in corners {
            // Their own planes may stand between them.
            let between = Between::new(c, n, node);
            if !between.is_level() {
                return false;
            }
            let lift = 1.01 * between.lift;
            // Segments start at the lift, so the surface itself is not in the box.
            take(c + n * lift);
            take(q + Vec3::from(node.n) * lift);
            take(c + n * 2e-6);
            take(q + Vec3::from(node.n) * 2e-6);
        }
    }
    let mut stack = vec![0u32];
    while let Some(i) = stack.pop() {
        let b = &geometry.nodes[i as usize];
        if Vec3::from(b.max).cmplt(low).any() || Vec3::from(b.min).cmpgt(high).any() {
            continue;
        }
        if b.count == 0 {
            stack.extend([b.first, b.first + 1]);
            continue;
        }
        for t in &geometry.tris[b.first as usize..(b.first + b.count) as usize] {
            if t.plane == plane || nodes.iter().all(|n| n.plane == t.plane) {
                continue;
            }
            let v = [t.v0, t.v1, t.v2].map(Vec3::from);
            let (tl, th) = (v[0].min(v[1]).min(v[2]), v[0].max(v[1]).max(v[2]));
            if !(th.cmplt(low).any() || tl.cmpgt(high).any()) {
                return false;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::nodes::surface_of;
    use crate::scene::{Material, Scene, shapes};

    #[test]
    fn lists_without_some_nodes_are_those_of_the_others() {
        // Two rooms in one: a screen across most of it.
        let room = shapes::room([0.0; 3], [2.0, 1.0, 1.0], [0; 6]);
        let screen = shapes::block([0.9, 0.0, 0.0], [1.0, 0.8, 0.9], 0);
        let materials = vec![Material::new("grey", [0.5; 3], [0.0; 3])];
        let geometry = Geometry::new(&Scene::from_triangles("rooms", &[room, screen].concat(), materials).unwrap()).unwrap();
        let placed: Vec<Node> = (0..geometry.tiles).step_by(5).map(|tile| node(&geometry, tile)).collect();
        let mass: Vec<f64> = (0..placed.len()).map(|i| f64::from(u8::from(i % 7 != 3))).collect();
        for mark in [false, true] {
            let mut surface = surface_of(&geometry, placed.clone(), 0.3, mark);
            let all = surface.candidates.len();
            assert!(leave_out_empty(&geometry, &mut surface, &mass, mark));
            let anew = surface_of(&geometry, surface.nodes.clone(), 0.3, mark);
            assert!(surface.offsets == anew.offsets && surface.candidates == anew.candidates);
            assert!(surface.candidates.len() < all && surface.candidates.iter().all(|c| mass[c.node as usize] > 0.0));
            assert_eq!(surface.candidates.iter().any(|c| c.free == 1), mark);
            assert!(!leave_out_empty(
                &geometry,
                &mut surface_of(&geometry, placed.clone(), 0.3, mark),
                &vec![1.0; placed.len()],
                mark
            ));
        }
    }

    fn node(geometry: &Geometry, tile: u32) -> Node {
        let tri = &geometry.tris[geometry.tile_tri[tile as usize] as usize];
        let centre = tile_corners(geometry, tile).iter().sum::<Vec3>() / 3.0;
        Node { p: centre.to_array(), material: tri.material, n: tri.normal, plane: tri.plane, gain: 1.0, ..Node::default() }
    }
}
