//! Lists of candidates that small tiles share. A triangle has a tile at least, so a scene of millions has millions of
//! tiles, far more than its light has detail: lists of their own would take gigabytes.

use super::boxes::Boxes;
use crate::hash::NumberMap;
use crate::layout::{Candidate, NONE};
use crate::network::nodes::tile_corners;
use crate::scene::{Geometry, TILES};
use crate::twin::assign::{CONE, NEAREST, Surface};
use glam::Vec3;
use rayon::prelude::*;

/// Tiles beyond which they share lists.
const MANY: u32 = 1 << 18;
/// Normals of a group agree to a cell of so many along an edge of a cube's faces.
const FACETS: f32 = 8.0;

/// Tiles in groups of like places, normals and material.
#[derive(Clone, Debug, Default)]
pub struct Groups {
    /// The group of each tile.
    pub of_tile: Vec<u32>,
    groups: Vec<Group>,
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

    /// A tile of each group: its first.
    pub fn tiles(&self) -> Vec<u32> {
        let mut first = vec![NONE; self.groups.len()];
        for (tile, &group) in self.of_tile.iter().enumerate().rev() {
            first[group as usize] = tile as u32;
        }
        first
    }
}

/// What tiles have in common.
#[derive(Clone, Debug)]
struct Group {
    material: u32,
    centre: Vec3,
    /// How far their points lie from the centre at most, local.
    radius: f32,
    normal: Vec3,
    /// How far the ends of their normals lie from that of `normal` at most.
    spread: f32,
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
    let mut groups: Vec<Group> = sums
        .into_iter()
        .map(|(material, centre, normal, count)| Group {
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

/// For each group the nodes that can be among the nearest of any point of its tiles. Nodes of other cones than a tile's own
/// are among them, too: whoever reads the list asks.
pub fn candidates(geometry: &Geometry, surface: &Surface, groups: &Groups) -> Vec<Vec<Candidate>> {
    let (inv, lambda) = (surface.inv_unit, surface.lambda);
    // Normals whose ends are nearer than this are in each other's cone; rounding is granted.
    let cone = (2.0 - 2.0 * CONE).sqrt();
    let boxes = Boxes::new(geometry, surface);
    let list = |group: &Group| {
        // How much nearer, or farther, a point of the group may be to a node than the centre is.
        let slack = (group.radius * inv).hypot(lambda * group.spread);
        let within_reach = |nodes: &mut dyn Iterator<Item = &u32>| {
            let (mut near, mut sure): (Vec<(f32, u32)>, Vec<f32>) = (Vec::new(), Vec::new());
            for &i in nodes {
                let node = &surface.nodes[i as usize];
                let (d, m) = ((group.centre - Vec3::from(node.p)) * inv, group.normal - Vec3::from(node.n));
                let (apart, distance) = (m.length(), (d.dot(d) + lambda * lambda * m.dot(m)).sqrt());
                if apart - group.spread < cone * (1.0 + 1e-5) {
                    near.push((distance, i));
                }
                if apart + group.spread < cone * (1.0 - 1e-5) {
                    sure.push(distance);
                }
            }
            if sure.len() < NEAREST {
                return (near, f32::INFINITY);
            }
            sure.select_nth_unstable_by(NEAREST - 1, f32::total_cmp);
            let reach = (sure[NEAREST - 1] + 2.0 * slack) * (1.0 + 1e-5);
            near.retain(|x| x.0 <= reach);
            (near, reach)
        };
        let (mut near, reach) = within_reach(&mut boxes.around(boxes.key(group.material, group.centre)));
        if reach > 0.999 * boxes.width {
            near = within_reach(&mut boxes.of_material(group.material).iter()).0;
        }
        near.sort_unstable_by_key(|x| x.1);
        near.into_iter().map(|x| Candidate { node: x.1, free: 0 }).collect()
    };
    groups.groups.par_iter().map(list).collect()
}
