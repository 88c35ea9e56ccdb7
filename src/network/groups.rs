//! Lists of candidates that small tiles share. A triangle has a tile at least, so a scene of millions has millions of
//! tiles, far more than its light has detail: lists of their own would take gigabytes.

use super::tiles::tile_corners;
use crate::hash::NumberMap;
use crate::layout::NONE;
use crate::scene::{Geometry, TILES};
use glam::Vec3;

/// Tiles beyond which they share lists.
const MANY: u32 = 1 << 18;
/// Normals of a group agree to a cell of so many along an edge of a cube's faces.
const FACETS: f32 = 8.0;

/// Tiles in groups of like places, normals and material.
#[derive(Clone, Debug, Default)]
pub struct Groups {
    /// The group of each tile.
    pub of_tile: Vec<u32>,
    groups: Vec<Extent>,
}

impl Groups {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.groups.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// What a group takes in.
    pub fn extent(&self, group: usize) -> &Extent {
        &self.groups[group]
    }

    /// A tile of each group: its first.
    pub fn tiles(&self) -> Vec<u32> {
        let mut first = vec![NONE; self.groups.len()];
        for (tile, &group) in self.of_tile.iter().enumerate().rev() {
            first[group as usize] = tile as u32;
        }
        first
    }
}

/// Where the points of a tile, or of tiles that have much in common, lie and face.
#[derive(Clone, Debug)]
pub struct Extent {
    pub material: u32,
    pub centre: Vec3,
    /// How far points lie from the centre at most, local.
    pub radius: f32,
    pub normal: Vec3,
    /// How far the ends of normals lie from that of `normal` at most.
    pub spread: f32,
}

impl Extent {
    /// That of a tile.
    pub fn of_tile(geometry: &Geometry, tile: u32) -> Extent {
        let tri = &geometry.tris[geometry.tile_tri[tile as usize] as usize];
        let corners = tile_corners(geometry, tile);
        let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
        let radius = corners.iter().map(|c| (*c - centre).length()).fold(0.0, f32::max);
        Extent { material: tri.material, centre, radius, normal: Vec3::from(tri.normal), spread: 0.0 }
    }
}

/// The groups of a scene that has many tiles.
pub fn groups(geometry: &Geometry) -> Option<Groups> {
    (geometry.tiles > MANY).then(|| group(geometry))
}

/// Groups the tiles of any scene.
pub fn group(geometry: &Geometry) -> Groups {
    // As wide as a tile where triangles are large.
    let width = geometry.spacing(TILES as usize) as f32;
    let mut at: NumberMap<[i32; 5], u32> = NumberMap::default();
    let mut sums: Vec<(u32, [f64; 3], [f64; 3], f64)> = Vec::new();
    let round = |p: Vec3| (p / width).floor().to_array().map(|x| x as i32);
    let of_tile: Vec<u32> = (0..geometry.tiles)
        .map(|tile| {
            let tri = &geometry.tris[geometry.tile_tri[tile as usize] as usize];
            let (corners, n) = (tile_corners(geometry, tile), Vec3::from(tri.normal));
            let centre = (corners[0] + corners[1] + corners[2]) / 3.0;
            let large = corners.iter().any(|c| (*c - centre).abs().max_element() > width);
            let [x, y, z] = round(centre);
            let fresh = sums.len() as u32;
            let group = match large {
                true => fresh,
                false => *at.entry([x, y, z, facet(n), tri.material as i32]).or_insert(fresh),
            };
            if group == fresh {
                sums.push((tri.material, [0.0; 3], [0.0; 3], 0.0));
            }
            let sum = &mut sums[group as usize];
            for k in 0..3 {
                sum.1[k] += f64::from(centre[k]);
                sum.2[k] += f64::from(n[k]);
            }
            sum.3 += 1.0;
            group
        })
        .collect();
    let mut groups: Vec<Extent> = sums
        .into_iter()
        .map(|(material, centre, normal, count)| Extent {
            material,
            centre: Vec3::from(centre.map(|x| (x / count) as f32)),
            radius: 0.0,
            normal: Vec3::from(normal.map(|x| (x / count) as f32)).normalize_or_zero(),
            spread: 0.0,
        })
        .collect();
    for tile in 0..geometry.tiles {
        let group = &mut groups[of_tile[tile as usize] as usize];
        for corner in tile_corners(geometry, tile) {
            group.radius = group.radius.max((corner - group.centre).length());
        }
        let n = Vec3::from(geometry.tris[geometry.tile_tri[tile as usize] as usize].normal);
        group.spread = group.spread.max((n - group.normal).length());
    }
    Groups { of_tile, groups }
}

/// The cell of a normal on a cube's faces.
fn facet(n: Vec3) -> i32 {
    let a = n.abs();
    let (axis, u, v) = if a.x >= a.y && a.x >= a.z {
        (0, n.y / a.x, n.z / a.x)
    } else if a.y >= a.z {
        (1, n.x / a.y, n.z / a.y)
    } else {
        (2, n.x / a.z, n.y / a.z)
    };
    let cell = |x: f32| (((x + 1.0) * 0.5 * FACETS) as i32).min(FACETS as i32 - 1);
    let side = 2 * axis + i32::from(n[axis as usize] < 0.0);
    (side * FACETS as i32 + cell(u)) * FACETS as i32 + cell(v)
}
