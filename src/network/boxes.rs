//! Nodes by place: what is near is found without looking at all of them.

use crate::scene::Geometry;
use crate::twin::assign::Surface;
use glam::Vec3;
use std::collections::HashMap;

/// A box: a material, and the place in the boxes' grid.
pub type Key = (u32, [i32; 3]);

/// The nodes that speak for points, in boxes of one material each.
pub struct Boxes {
    /// Side of a box in units of L: a few node spacings, so that the boxes around a place hold all that most need.
    pub width: f32,
    inv_unit: f32,
    boxes: HashMap<Key, Vec<u32>>,
    by_material: Vec<Vec<u32>>,
}

impl Boxes {
    /// Those of a surface network.
    pub fn new(geometry: &Geometry, surface: &Surface) -> Boxes {
        let inv_unit = surface.inv_unit;
        let width = 2.5 * geometry.spacing(surface.nodes.len()) as f32 * inv_unit;
        let by_material = vec![Vec::new(); geometry.materials.len()];
        let mut all = Boxes { width, inv_unit, boxes: HashMap::new(), by_material };
        for (i, n) in surface.nodes.iter().enumerate().filter(|(_, n)| n.gain >= 0.0) {
            all.by_material[n.material as usize].push(i as u32);
            all.boxes.entry(all.key(n.material, Vec3::from(n.p))).or_default().push(i as u32);
        }
        all
    }

    /// The box of a place, local.
    pub fn key(&self, material: u32, p: Vec3) -> Key {
        (material, (p * (self.inv_unit / self.width)).floor().to_array().map(|x| x as i32))
    }

    /// The nodes in a box and in the 26 about it.
    pub fn around(&self, (material, [x, y, z]): Key) -> impl Iterator<Item = &u32> {
        (0..27).filter_map(move |k| self.boxes.get(&(material, [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]))).flatten()
    }

    /// All nodes of a material.
    pub fn of_material(&self, material: u32) -> &[u32] {
        &self.by_material[material as usize]
    }
}
