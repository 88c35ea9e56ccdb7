//! The surface network: nodes on live surface points, and each tile's candidates (design §1, step 4).

use super::boxes::{Boxes, Key};
use super::groups;
use crate::engine::Engine;
use crate::error::Result;
use crate::layout::{Candidate, NONE, Node, Point};
use crate::progress::Progress;
use crate::scene::{Geometry, cumulative};
use crate::twin::assign::{CONE, LIFT, NEAREST, Surface, crossed};
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
/// Rays that tell whether a training point is dead.
pub const DEAD_PROBES: u32 = 12;

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

/// Which of the points are dead; see [`Gathered::is_dead`].
pub fn dead_points<E: Engine>(engine: &mut E, points: &[Point], seed: u32, progress: &mut Progress) -> Result<Vec<bool>> {
    let mut dead = Vec::with_capacity(points.len());
    for chunk in points.chunks(32_768) {
        let batch = engine.upload(chunk)?;
        let hits = engine.shoot(&batch, seed, 0, DEAD_PROBES)?;
        dead.extend(engine.gather(&hits, DEAD_PROBES, false, false)?.iter().map(Gathered::is_dead));
        progress.tick()?;
    }
    Ok(dead)
}

/// Places about `count` nodes with density `density` (per area, a number each tile), then more where
/// points find no compatible node. `mark`: also find which nodes need no visibility ray
/// ([`mark_free`]). The surface is left set on the engine.
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
    let mut asked = vec![false; geometry.tiles as usize];
    for p in points.iter().filter(|p| p.tile != NONE) {
        asked[p.tile as usize] = true;
    }
    list_candidates(geometry, &mut surface, |tile| asked[tile]);
    engine.set_surface(&surface)?;

    // Orphans get nodes of their own.
    for _ in 0..ORPHAN_ROUNDS {
        let mut orphans = Vec::new();
        for (start, chunk) in points.chunks(65_536).enumerate() {
            let mut batch = engine.upload(chunk)?;
            engine.assign(&mut batch)?;
            let psi = engine.psi(&batch)?;
            orphans.extend(psi.iter().enumerate().filter(|(_, s)| s.is_orphan()).map(|(i, _)| start * 65_536 + i));
            progress.tick()?;
        }
        let more =
            orphans.len().div_ceil(POINTS_PER_ORPHAN_NODE).min((ORPHAN_SHARE * surface.nodes.len() as f64).ceil() as usize);
        if more == 0 {
            break;
        }
        add_nodes(geometry, &mut surface, &points, &places, &orphans, more);
        list_candidates(geometry, &mut surface, |tile| asked[tile]);
        engine.set_surface(&surface)?;
    }
    find_candidates(geometry, &mut surface);
    if mark {
        mark_free(geometry, &mut surface);
    }
    engine.set_surface(&surface)?;
    Ok(surface)
}

/// The surface network of nodes that were placed earlier; `mark` as for [`place_nodes`].
pub fn surface_of(geometry: &Geometry, nodes: Vec<Node>, lambda: f32, mark: bool) -> Surface {
    let mut surface = Surface { nodes, inv_unit: (1.0 / geometry.unit) as f32, lambda, ..Surface::default() };
    find_candidates(geometry, &mut surface);
    if mark {
        mark_free(geometry, &mut surface);
    }
    surface
}

/// Adds about `count` nodes at the k-means of the chosen points, material by material.
fn add_nodes(geometry: &Geometry, surface: &mut Surface, points: &[Point], places: &[Place], chosen: &[usize], count: usize) {
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
}

/// Lists for every tile, or group of them, the nodes that can be among the nearest of any of its points, and looks up from
/// each node.
pub fn find_candidates(geometry: &Geometry, surface: &mut Surface) {
    list_candidates(geometry, surface, |_| true);
}

/// [`find_candidates`] for the tiles that are `asked` of; the lists of all others stay empty, where they have their own.
fn list_candidates(geometry: &Geometry, surface: &mut Surface, asked: impl Fn(usize) -> bool + Sync) {
    surface.nodes.par_iter_mut().for_each(|n| {
        n.clear = closest(
            geometry,
            &Ray { origin: Vec3::from(n.p), direction: Vec3::from(n.n), t_max: f32::MAX, skip: [n.plane, NONE] },
        )
        .t
    });
    surface.groups = geometry.groups.clone();
    let rows = match &surface.groups {
        Some(groups) => groups::candidates(geometry, surface, groups),
        None => candidates_of_tiles(geometry, surface, asked),
    };
    surface.offsets = vec![0];
    surface.candidates.clear();
    for row in rows {
        surface.candidates.extend(row);
        surface.offsets.push(surface.candidates.len() as u32);
    }
}

/// The lists of [`list_candidates`], one each tile.
fn candidates_of_tiles(geometry: &Geometry, surface: &Surface, asked: impl Fn(usize) -> bool + Sync) -> Vec<Vec<Candidate>> {
    let (inv, lambda) = (surface.inv_unit, surface.lambda);
    let boxes = Boxes::new(geometry, surface);
    // Tiles follow each other by place: most find the boxes around them where the one before had them.
    type Around = (Option<Key>, Vec<u32>);
    (0..geometry.tiles as usize)
        .into_par_iter()
        .with_min_len(256)
        .map_init(Around::default, |(last, around), tile| {
            if !asked(tile) {
                return Vec::new();
            }
            let t = geometry.tile_tri[tile];
            let tri = &geometry.tris[t as usize];
            let own = boxes.of_material(tri.material);
            if own.is_empty() {
                return Vec::new();
            }
            let corners = tile_corners(geometry, tile as u32);
            let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
            let radius = corners.iter().map(|c| (*c - centre).length()).fold(0.0, f32::max) * inv;
            let n = Vec3::from(tri.normal);
            let measure = |&i: &u32| {
                let node = &surface.nodes[i as usize];
                let d = (centre - Vec3::from(node.p)) * inv;
                let m = (n - Vec3::from(node.n)) * lambda;
                (Vec3::from(node.n).dot(n) > CONE).then(|| ((d.dot(d) + m.dot(m)).sqrt(), i))
            };
            // No point of the tile lies farther than `radius` from its centre, so nodes beyond `reach`
            // are not among its nearest.
            let within_reach = |mut near: Vec<(f32, u32)>| {
                if near.len() < NEAREST {
                    return (near, f32::INFINITY);
                }
                near.select_nth_unstable_by(NEAREST - 1, |a, b| a.0.total_cmp(&b.0));
                let reach = (near[NEAREST - 1].0 + 2.0 * radius) * (1.0 + 1e-5);
                near.retain(|x| x.0 <= reach);
                (near, reach)
            };
            let here = boxes.key(tri.material, centre);
            if *last != Some(here) {
                (*last, *around) = (Some(here), boxes.around(here).copied().collect());
            }
            let (mut near, reach) = within_reach(around.iter().filter_map(measure).collect());
            if reach > 0.999 * boxes.width {
                near = within_reach(own.iter().filter_map(measure).collect()).0;
            }
            near.sort_unstable_by_key(|x| x.1);

            near.into_iter().map(|x| Candidate { node: x.1, free: 0 }).collect()
        })
        .collect()
}

/// Leaves out the nodes that no ray has met, whose light nobody knows: a point near them is better gathered for. Returns
/// whether there were any.
pub fn leave_out_empty(geometry: &Geometry, surface: &mut Surface, mass: &[f64], mark: bool) -> bool {
    let mut any = false;
    for (node, _) in surface.nodes.iter_mut().zip(mass).filter(|(_, m)| **m <= 0.0) {
        node.gain = -1.0;
        any = true;
    }
    if any {
        find_candidates(geometry, surface);
        if mark {
            mark_free(geometry, surface);
        }
    }
    any
}

/// Whether so many rays save more by marks than finding them takes. Lists that tiles share have none.
pub fn worth_marking(geometry: &Geometry, rays: u32) -> bool {
    rays >= geometry.tiles && geometry.groups.is_none()
}

/// Marks the candidates that nothing can hide from their tile, so that no ray need be shot. Worth its
/// box queries where many points are assigned; the weights are the same without.
pub fn mark_free(geometry: &Geometry, surface: &mut Surface) {
    let Surface { nodes, offsets, candidates, .. } = surface;
    let free: Vec<Vec<u32>> = (0..geometry.tiles as usize)
        .into_par_iter()
        .map(|tile| {
            let own: Vec<&Node> =
                candidates[offsets[tile] as usize..offsets[tile + 1] as usize].iter().map(|c| &nodes[c.node as usize]).collect();
            let tri = &geometry.tris[geometry.tile_tri[tile] as usize];
            let (corners, n) = (tile_corners(geometry, tile as u32), Vec3::from(tri.normal));
            // Ask for all at once before asking for each.
            let alone = is_free(geometry, &corners, n, tri.plane, &own);
            own.iter().map(|&node| (alone || is_free(geometry, &corners, n, tri.plane, &[node])) as u32).collect()
        })
        .collect();
    for (candidate, free) in candidates.iter_mut().zip(free.into_iter().flatten()) {
        candidate.free = free;
    }
}

/// The corners of a tile.
pub fn tile_corners(geometry: &Geometry, tile: u32) -> [Vec3; 3] {
    let t = &geometry.tris[geometry.tile_tri[tile as usize] as usize];
    // Places (0, ?), (1, 0) and (1, 1) of the tile are its corners.
    [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)].map(|(a, b)| {
        let (b1, b2) = place_in_tile(geometry.flatland, t.cuts(), tile - t.first_tile, a, b);
        crate::twin::trace::corner_position(t, b1, b2)
    })
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
            if crossed(c, n, plane, node) != [plane, node.plane] {
                return false;
            }
            let lift = (LIFT * (c - q).length()).max(2e-6) * 1.01;
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
}
