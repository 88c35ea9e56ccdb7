//! The surface network: nodes on live surface points (design §1, step 4).

use super::candidates;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{NONE, Node, Point, Psi, kind};
use crate::progress::Progress;
use crate::scene::{Geometry, cumulative};
use crate::twin::assign::Surface;
use crate::twin::gather::Gathered;
use crate::twin::math::{invert_cdf, unit};
use crate::twin::sobol::sobol4;
use crate::twin::trace::{Ray, closest, place_in_tile, surface_point};
use glam::Vec3;
use rayon::prelude::*;

/// Training points a node.
const POINTS_PER_NODE: usize = 24;
/// Iterations of k-means.
const ITERATIONS: usize = 6;
/// Rounds in which orphans get nodes.
const ORPHAN_ROUNDS: usize = 3;
/// Orphaned training points that make one new node.
const POINTS_PER_ORPHAN_NODE: usize = 8;
/// Most nodes a round of orphans may add, as a share of the rest.
const ORPHAN_SHARE: f64 = 0.12;
/// Rays that tell whether a training point is dead: one front face that the first ones meet is enough, else more follow.
pub const DEAD_PROBES: [u32; 2] = [3, 9];

/// A training point in the nodes' metric: (p/L, lambda n).
type Place = [f32; 6];

fn place(geometry: &Geometry, point: &Point, lambda: f32) -> Place {
    let n = geometry.tris[point.tri as usize].normal;
    let inv = 1.0 / geometry.unit as f32;
    [point.p[0] * inv, point.p[1] * inv, point.p[2] * inv, n[0] * lambda, n[1] * lambda, n[2] * lambda]
}

fn distance2(a: &Place, b: &Place) -> f32 {
    let mut sum = 0.0;
    for k in 0..6 {
        sum += (a[k] - b[k]) * (a[k] - b[k]);
    }
    sum
}

/// Index of the centre nearest to a place; ties to the lowest.
fn nearest(centres: &[Place], p: &Place) -> usize {
    let mut best = (f32::MAX, 0);
    for (i, c) in centres.iter().enumerate() {
        let d = distance2(c, p);
        if d < best.0 {
            best = (d, i);
        }
    }
    best.1
}

/// k-means over places, started from every n-th: the indices of the places nearest to the centres.
fn k_means(places: &[Place], count: usize) -> Vec<usize> {
    if places.is_empty() || count == 0 {
        return Vec::new();
    }
    let count = count.min(places.len());
    let mut centres: Vec<Place> = (0..count).map(|i| places[(2 * i + 1) * places.len() / (2 * count)]).collect();
    let mut of: Vec<usize> = Vec::new();
    for _ in 0..ITERATIONS {
        of = places.par_iter().map(|p| nearest(&centres, p)).collect();
        let mut sums = vec![([0.0f64; 6], 0.0f64); count];
        for (p, &c) in places.iter().zip(&of) {
            for k in 0..6 {
                sums[c].0[k] += p[k] as f64;
            }
            sums[c].1 += 1.0;
        }
        for (centre, (sum, n)) in centres.iter_mut().zip(sums) {
            if n > 0.0 {
                *centre = sum.map(|s| (s / n) as f32);
            }
        }
    }
    // A node is a real surface point: the member nearest to the centre.
    let mut best = vec![(f32::MAX, usize::MAX); count];
    for (i, (p, &c)) in places.iter().zip(&of).enumerate() {
        let d = distance2(p, &centres[c]);
        if d < best[c].0 {
            best[c] = (d, i);
        }
    }
    best.into_iter().map(|b| b.1).filter(|&i| i != usize::MAX).collect()
}

/// Draws `count` surface points with the given weight per tile (0: never), in the order of tiles.
pub fn sample_points(geometry: &Geometry, weight: &[f64], count: u32, seed: u32) -> Vec<Point> {
    if !weight.iter().any(|&w| w > 0.0) {
        return Vec::new();
    }
    let cdf = cumulative(weight);
    let mut samples: Vec<[u32; 4]> = (0..count).map(|i| sobol4(i, seed)).collect();
    samples.sort_unstable();
    samples.into_iter().map(|u| place_of(geometry, &cdf, u[0], u[1])).collect()
}

/// The surface point of two random numbers, by the cumulative distribution over the tiles.
pub fn place_of(geometry: &Geometry, cdf: &[u32], u: u32, v: u32) -> Point {
    let (tile, at) = invert_cdf(cdf.len() as u32, |t| cdf[t as usize], u);
    place_on_tile(geometry, tile, at, unit(v))
}

/// The surface point at two numbers in [0, 1) of a tile.
pub fn place_on_tile(geometry: &Geometry, tile: u32, u: f32, v: f32) -> Point {
    let tri = geometry.tile_tri[tile as usize];
    let t = &geometry.tris[tri as usize];
    let (b1, b2) = place_in_tile(geometry.flatland, t.cuts(), tile - t.first_tile, u, v);
    surface_point(geometry, tri, b1, b2)
}

/// Which of the points are dead, as [`Gathered::is_dead`] has it.
pub fn dead_points<E: Engine>(engine: &mut E, points: &[Point], seed: u32, progress: &mut Progress) -> Result<Vec<bool>> {
    let mut seen = vec![Gathered::default(); points.len()];
    let mut unsure: Vec<usize> = (0..points.len()).collect();
    let mut shot = 0;
    for rays in DEAD_PROBES {
        for chunk in unsure.chunks(32_768) {
            let batch = engine.upload(&chunk.iter().map(|&i| points[i]).collect::<Vec<_>>())?;
            let hits = engine.shoot(&batch, seed, shot, rays)?;
            for (&i, more) in chunk.iter().zip(engine.gather(&hits, rays, false, false)?) {
                let share = rays as f32 / (shot + rays) as f32;
                seen[i].front += share * (more.front - seen[i].front);
                seen[i].back += share * (more.back - seen[i].back);
            }
            progress.tick()?;
        }
        shot += rays;
        unsure.retain(|&i| seen[i].front == 0.0);
    }
    Ok(seen.iter().map(Gathered::is_dead).collect())
}

/// Places about `count` nodes with density `density` (per area, a number each tile), then more where
/// points find no compatible node. `mark`: as for [`candidates::find`]. The surface is left set on the engine.
pub fn place_nodes<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    density: &[f64],
    count: usize,
    lambda: f32,
    seed: u32,
    mark: bool,
    progress: &mut Progress,
) -> Result<Surface> {
    // Only what reflects needs nodes; emitters that do not are read as B = E.
    let weight: Vec<f64> = (0..geometry.tiles as usize)
        .map(|t| {
            let rho = geometry.material_of(geometry.tile_tri[t] as usize).rho;
            if rho.iter().any(|&r| r > 0.0) { density[t] * geometry.tile_area(t) } else { 0.0 }
        })
        .collect();
    let points = sample_points(geometry, &weight, (count * POINTS_PER_NODE) as u32, seed);
    let dead = dead_points(engine, &points, seed ^ 0xdead, progress)?;
    let points: Vec<Point> = points.into_iter().zip(dead).filter(|(p, d)| !d && geometry.is_there(p)).map(|(p, _)| p).collect();
    let places: Vec<Place> = points.iter().map(|p| place(geometry, p, lambda)).collect();

    // Each material has its own share of the nodes.
    let mut surface = Surface { inv_unit: (1.0 / geometry.unit) as f32, lambda, ..Surface::default() };
    let all: Vec<usize> = (0..points.len()).collect();
    add_nodes(geometry, &mut surface, &points, &places, &all, count);
    progress.tick()?;
    // Until all nodes are there, only the training points' own tiles are asked of.
    let asked = candidates::of_tiles(geometry, points.iter().map(|p| p.tile).filter(|&t| t != NONE));
    candidates::find_some(geometry, &mut surface, &asked, false);
    engine.set_surface(&surface)?;

    // Orphans get nodes of their own; whoever has a node that speaks for it keeps one.
    let mut orphans = all;
    for _ in 0..ORPHAN_ROUNDS {
        let mut left = Vec::new();
        for chunk in orphans.chunks(65_536) {
            let mut batch = engine.upload(&chunk.iter().map(|&i| points[i]).collect::<Vec<_>>())?;
            engine.assign(&mut batch)?;
            let psi = engine.psi(&batch)?;
            left.extend(chunk.iter().zip(psi).filter(|(_, psi)| psi.is_orphan()).map(|(&i, _)| i));
            progress.tick()?;
        }
        orphans = left;
        let more =
            orphans.len().div_ceil(POINTS_PER_ORPHAN_NODE).min((ORPHAN_SHARE * surface.nodes.len() as f64).ceil() as usize);
        if more == 0 {
            break;
        }
        add_nodes(geometry, &mut surface, &points, &places, &orphans, more);
        candidates::find_some(geometry, &mut surface, &asked, false);
        engine.set_surface(&surface)?;
    }
    candidates::find(geometry, &mut surface, mark);
    engine.set_surface(&surface)?;
    Ok(surface)
}

/// Ends of rays that no node speaks for, nor is in sight of, name the one that speaks for the other end, where both reflect
/// alike: what is in a corner too small for nodes is taken to be lit as what it sees. Returns whether there were any.
pub fn lend(geometry: &Geometry, points: &[Point], psi: &mut [Psi]) -> bool {
    let material = |p: &Point| geometry.tris[p.tri as usize].material;
    let mut any = false;
    for (ray, ends) in points.chunks_exact(2).zip(psi.chunks_exact_mut(2)) {
        for [end, other] in [[0, 1], [1, 0]] {
            let lost = ray[0].kind == kind::FRONT && ends[end].node[0] == NONE;
            if lost && !ends[other].is_orphan() && material(&ray[0]) == material(&ray[1]) {
                ends[end].node[0] = ends[other].node[0];
                any = true;
            }
        }
    }
    any
}

/// The surface network of nodes that were placed earlier; `mark` as for [`place_nodes`].
pub fn surface_of(geometry: &Geometry, mut nodes: Vec<Node>, lambda: f32, mark: bool) -> Surface {
    look_up(geometry, &mut nodes);
    let mut surface = Surface { nodes, inv_unit: (1.0 / geometry.unit) as f32, lambda, ..Surface::default() };
    candidates::find(geometry, &mut surface, mark);
    surface
}

/// Adds about `count` nodes at the k-means of the chosen points, material by material.
fn add_nodes(geometry: &Geometry, surface: &mut Surface, points: &[Point], places: &[Place], chosen: &[usize], count: usize) {
    let first = surface.nodes.len();
    for material in 0..geometry.materials.len() as u32 {
        let members: Vec<usize> =
            chosen.iter().copied().filter(|&i| geometry.tris[points[i].tri as usize].material == material).collect();
        let share = (count as f64 * members.len() as f64 / chosen.len().max(1) as f64).ceil() as usize;
        let own: Vec<Place> = members.iter().map(|&i| places[i]).collect();
        for i in k_means(&own, share) {
            let p = &points[members[i]];
            let tri = &geometry.tris[p.tri as usize];
            surface.nodes.push(Node { p: p.p, material, n: tri.normal, plane: tri.plane, gain: 1.0, ..Node::default() });
        }
    }
    look_up(geometry, &mut surface.nodes[first..]);
}

/// Finds how far it is up from each node.
fn look_up(geometry: &Geometry, nodes: &mut [Node]) {
    nodes.par_iter_mut().for_each(|n| {
        let up = Ray { origin: Vec3::from(n.p), direction: Vec3::from(n.n), t_max: f32::MAX, skip: [n.plane, NONE] };
        n.clear = closest(geometry, &up).t;
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Flow;
    use crate::scene::{Material, Scene, shapes};
    use crate::twin::TwinEngine;

    #[test]
    fn a_surface_is_the_same_placed_or_read() {
        // A block on the floor: orphans beside it, tiles that no training point lies in.
        let room = shapes::room([0.0; 3], [1.0; 3], [0; 6]);
        let solid = [room, shapes::block([0.4, 0.0, 0.4], [0.5, 0.02, 0.5], 0)].concat();
        let materials = vec![Material::new("grey", [0.5; 3], [0.0; 3])];
        let geometry = Geometry::new(&Scene::from_triangles("room", &solid, materials).unwrap()).unwrap();
        let density = vec![1.0; geometry.tiles as usize];
        for mark in [false, true] {
            let quiet = &mut |_: &_| Flow::Continue;
            let engine = &mut TwinEngine::new(&geometry);
            let placed = place_nodes(engine, &geometry, &density, 60, 0.3, 5, mark, &mut Progress::new(quiet)).unwrap();
            let read = surface_of(&geometry, placed.nodes.clone(), 0.3, mark);
            assert!(placed.offsets == read.offsets && placed.candidates == read.candidates);
            assert!(placed.offsets.windows(2).all(|w| w[0] < w[1]), "a tile without candidates");
        }
    }

    #[test]
    fn an_end_without_nodes_borrows_from_the_other_of_its_material() {
        let materials = vec![Material::new("a", [0.5; 3], [0.0; 3]), Material::new("b", [0.2; 3], [0.0; 3])];
        let t = [shapes::block([0.0; 3], [1.0; 3], 0), shapes::block([2.0, 0.0, 0.0], [3.0, 1.0, 1.0], 1)].concat();
        let g = Geometry::new(&Scene::from_triangles("two", &t, materials).unwrap()).unwrap();
        let top = |x: f64| {
            let tri = g.locate([x, 1.0, 0.5], [0.0, 1.0, 0.0]).unwrap().tri;
            surface_point(&g, tri, 0.3, 0.3)
        };
        let [a, b] = [0.5, 2.5].map(|x| Point { kind: kind::FRONT, ..top(x) });
        let spoken = Psi { node: [7, 3, NONE, NONE], weight: [0.75, 0.25, 0.0, 0.0] };
        let lent = Psi { node: [7, NONE, NONE, NONE], ..Psi::EMPTY };
        let named = Psi { node: [5, NONE, NONE, NONE], ..Psi::EMPTY };
        for (ends, before, after) in [
            ([a, a], [Psi::EMPTY, spoken], [lent, spoken]),
            ([a, a], [spoken, Psi::EMPTY], [spoken, lent]),
            ([a, b], [Psi::EMPTY, spoken], [Psi::EMPTY, spoken]),
            ([a, a], [named, spoken], [named, spoken]),
            ([a, a], [Psi::EMPTY, named], [Psi::EMPTY, named]),
        ] {
            let mut psi = before;
            assert_eq!(lend(&g, &ends, &mut psi), before != after);
            assert_eq!(psi, after);
        }
    }
}
