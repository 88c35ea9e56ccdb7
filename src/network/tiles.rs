//! Tables over the tiles: where rays start, and how dense nodes lie (design §1, steps 1 and 4).

use super::nodes::place_on_tile;
use crate::engine::Engine;
use crate::error::Result;
use crate::hash::NumberMap;
use crate::layout::{DirectSum, Point, Tile, kind};
use crate::progress::Progress;
use crate::scene::{Geometry, TILES, cumulative};
use crate::twin::direct::Samples;
use crate::twin::math::{invert_cdf, seed_of, unit};
use crate::twin::sobol::sobol4;
use crate::twin::trace::{corner_position, place_in_tile};
use glam::Vec3;

/// Points in flight.
const BATCH: usize = 65_536;

/// The mean over the bands.
pub fn mean(x: &[f64; 3]) -> f64 {
    (x[0] + x[1] + x[2]) / 3.0
}

/// The corners of a tile.
pub fn tile_corners(geometry: &Geometry, tile: u32) -> [Vec3; 3] {
    let t = &geometry.tris[geometry.tile_tri[tile as usize] as usize];
    // Places (0, ?), (1, 0) and (1, 1) of the tile are its corners.
    [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)].map(|(a, b)| {
        let (b1, b2) = place_in_tile(geometry.flatland, t.cuts(), tile - t.first_tile, a, b);
        corner_position(t, b1, b2)
    })
}

/// A random point of every tile; where tiles are in groups, of one tile each group.
pub fn places(geometry: &Geometry, seed: u32) -> Vec<Point> {
    places_of(geometry, &looks(geometry, geometry.tiles).tiles, seed)
}

/// A random point of each of some tiles.
pub fn places_of(geometry: &Geometry, tiles: &[u32], seed: u32) -> Vec<Point> {
    let place = |&t| {
        let u = sobol4(t, seed);
        place_of_tile(geometry, t, unit(u[0]), unit(u[1]))
    };
    tiles.iter().map(place).collect()
}

/// Which tiles are looked at, and who speaks for the others.
pub struct Looks {
    /// The tiles that are looked at.
    pub tiles: Vec<u32>,
    /// For each tile the place in `tiles` of the one that speaks for it.
    pub of: Vec<u32>,
}

/// Every tile, or group of them, by itself; where there are more than `looks`, one for all of a material that face about one way and
/// lie in a box as wide as so many looks lie apart.
pub fn looks(geometry: &Geometry, looks: u32) -> Looks {
    if looks as usize >= geometry.lists() {
        return match &geometry.groups {
            None => Looks { tiles: (0..geometry.tiles).collect(), of: (0..geometry.tiles).collect() },
            Some(groups) => Looks { tiles: groups.tiles(), of: groups.of_tile.clone() },
        };
    }
    let width = geometry.spacing(looks as usize);
    let key = |t: u32| {
        let tri = &geometry.tris[geometry.tile_tri[t as usize] as usize];
        let axis = (0..3).fold(0, |a, k| if tri.normal[k].abs() > tri.normal[a].abs() { k } else { a });
        let c = tile_corners(geometry, t);
        let at = ((c[0] + c[1] + c[2]) / 3.0).to_array().map(|x| (f64::from(x) / width).floor() as i32);
        (tri.material, axis, tri.normal[axis] < 0.0, at)
    };
    let mut first = NumberMap::default();
    let mut tiles = Vec::new();
    let of = (0..geometry.tiles).map(|t| {
        *first.entry(key(t)).or_insert_with(|| {
            tiles.push(t);
            tiles.len() as u32 - 1
        })
    });
    let of = of.collect();
    Looks { tiles, of }
}

/// `count` points drawn by start densities.
pub fn drawn(geometry: &Geometry, starts: &[Tile], seed: u32, count: u32) -> Vec<Point> {
    let place = |i| {
        let u = sobol4(i, seed);
        let (t, at) = invert_cdf(starts.len() as u32, |t| starts[t as usize].cdf, u[0]);
        Point { density: starts[t as usize].density, ..place_of_tile(geometry, t, at, unit(u[1])) }
    };
    (0..count).map(place).collect()
}

/// A front point of a tile that is known: rounding must not move it to the neighbour.
fn place_of_tile(geometry: &Geometry, tile: u32, u: f32, v: f32) -> Point {
    Point { tile, kind: kind::FRONT, ..place_on_tile(geometry, tile, u, v) }
}

/// A first estimate of direct light at some tiles' points.
pub fn direct<E: Engine>(
    engine: &mut E,
    places: &[Point],
    seed: u32,
    rounds: u32,
    progress: &mut Progress,
) -> Result<Vec<DirectSum>> {
    let mut sums = Vec::new();
    for (i, chunk) in places.chunks(BATCH).enumerate() {
        let mut batch = engine.upload(chunk)?;
        let samples = Samples { emitter: 3 * rounds, cosine: rounds };
        engine.direct(&mut batch, None, seed_of(seed, i as u32), 0, rounds, samples)?;
        sums.extend(engine.direct_sums(&batch)?);
        progress.tick()?;
    }
    Ok(sums)
}

/// Start densities p = (1 - alpha)/A + alpha q over the live area, q proportional to `wanted` (a
/// number each tile, per area). Uniform where nothing is wanted.
pub fn starts(geometry: &Geometry, wanted: &[f64], alpha: f64) -> Vec<Tile> {
    let live = |t: usize| geometry.is_live(geometry.tile_tri[t] as usize);
    let total: f64 = (0..wanted.len()).filter(|&t| live(t)).map(|t| wanted[t] * geometry.tile_area(t)).sum();
    let alpha = if total > 0.0 { alpha } else { 0.0 };
    let density: Vec<f64> = (0..wanted.len())
        .map(|t| match live(t) {
            true => (1.0 - alpha) / geometry.area + if total > 0.0 { alpha * wanted[t] / total } else { 0.0 },
            false => 0.0,
        })
        .collect();
    distribution(geometry, &density)
}

/// A fixed-point cumulative distribution from densities that integrate to 1.
pub fn distribution(geometry: &Geometry, density: &[f64]) -> Vec<Tile> {
    let shares: Vec<f64> = (0..density.len()).map(|t| density[t] * geometry.tile_area(t)).collect();
    cumulative(&shares).into_iter().zip(density).map(|(cdf, &d)| Tile { cdf, density: d as f32 }).collect()
}

/// Node density of each tile: .2 + .8 g^(2/3), g = <rho B / d^2> from the pilot's rays. Slots, and walls
/// beside lights, where irradiance changes over short distances, get more nodes. In flatland .2 + .8 g^(1/3): the
/// distance between nodes goes as g^(-1/3) in both.
pub fn node_density<E: Engine>(
    engine: &mut E,
    geometry: &Geometry,
    batches: &[E::Batch],
    carried: &[f64],
    nodes: usize,
) -> Result<Vec<f64>> {
    let spacing = geometry.spacing(nodes);
    let mut g = vec![0.0; geometry.tiles as usize];
    for batch in batches {
        for ray in engine.points(batch)?.chunks_exact(2) {
            if ray[0].kind != kind::FRONT {
                continue;
            }
            let d: f64 = (0..3).map(|k| (ray[0].p[k] as f64 - ray[1].p[k] as f64).powi(2)).sum::<f64>().sqrt();
            // Over a mirror the way is longer than the ends are apart: about a room's length.
            let d = if geometry.mirrors && ray[0].density > 0.0 { d.max(geometry.unit) } else { d };
            let close = d.max(spacing / 8.0).powi(-2);
            for (y, x) in [(&ray[0], &ray[1]), (&ray[1], &ray[0])] {
                let rho = mean(&geometry.material_at(y).rho.map(f64::from));
                g[y.tile as usize] += y.weight as f64 * rho * carried[x.tile as usize] * close;
            }
        }
    }

    // Average over the tiles of one piece that share a box three tiles wide.
    let width = 3.0 * geometry.spacing(TILES as usize);
    let mut bins: NumberMap<[i64; 4], (f64, f64)> = NumberMap::default();
    let key = |t: usize| {
        let c = tile_corners(geometry, t as u32);
        let c = (c[0] + c[1] + c[2]) / 3.0;
        let plane = geometry.tris[geometry.tile_tri[t] as usize].plane as i64;
        [plane, (c.x as f64 / width).floor() as i64, (c.y as f64 / width).floor() as i64, (c.z as f64 / width).floor() as i64]
    };
    let keys: Vec<[i64; 4]> = (0..g.len()).map(key).collect();
    for t in 0..g.len() {
        let bin = bins.entry(keys[t]).or_default();
        bin.0 += g[t];
        bin.1 += geometry.tile_area(t);
    }
    let power = if geometry.flatland { 1.0 / 3.0 } else { 2.0 / 3.0 };
    let sharp: Vec<f64> = keys.iter().map(|k| (bins[k].0 / bins[k].1).powf(power)).collect();
    let live: f64 = (0..sharp.len())
        .filter(|&t| geometry.is_live(geometry.tile_tri[t] as usize))
        .map(|t| sharp[t] * geometry.tile_area(t))
        .sum();
    let average = live / geometry.area;
    Ok(sharp.iter().map(|s| 0.2 + 0.8 * if average > 0.0 { (s / average).min(30.0) } else { 1.0 }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Scene, shapes};

    #[test]
    fn a_look_speaks_for_tiles_like_its_own() {
        let room = shapes::room([0.0; 3], [1.0; 3], [0, 1, 0, 1, 0, 1]);
        let materials = vec![Material::new("a", [0.5; 3], [0.0; 3]), Material::new("b", [0.2; 3], [1.0; 3])];
        let geometry = Geometry::new(&Scene::from_triangles("room", &shapes::cut(&room, 8), materials).unwrap()).unwrap();
        let own = looks(&geometry, geometry.tiles);
        assert!(own.tiles == own.of && own.tiles.len() == geometry.tiles as usize);
        let some = looks(&geometry, 1_000);
        // A box may cut a wall's share in two, or in four.
        assert!((500..4_000).contains(&some.tiles.len()), "{} of {}", some.tiles.len(), geometry.tiles);
        let width = geometry.spacing(1_000) as f32;
        for (t, look) in some.of.iter().map(|&i| some.tiles[i as usize]).enumerate() {
            let [a, b] = [t as u32, look].map(|t| &geometry.tris[geometry.tile_tri[t as usize] as usize]);
            assert!(a.material == b.material && a.normal == b.normal, "{t} {look}");
            let [a, b] = [t as u32, look].map(|t| tile_corners(&geometry, t).into_iter().sum::<Vec3>() / 3.0);
            assert!((a - b).abs().max_element() <= width, "{t} {look}");
        }
    }
}
