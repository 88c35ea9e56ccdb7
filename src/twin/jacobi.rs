//! Pass `jacobi`: one sweep of the iteration, all bands at once (design §1, step 6).
//!
//! beta_c = s_c + sum_i rho_i (a_ci H_i + a'_ci . G_i);
//! H_j = (1/m_j) sum_c o_cj beta_c;  G_j = (C_j + ridge tr C_j)^-1 (1/m_j) sum_c o'_cj beta_c.

use crate::layout::{Link, Material, NodeLight, Plane};
use glam::Vec3;
use rayon::prelude::*;

/// The linear system in the order the sweep reads it: rows in CSR form, 1/m_j folded into the deposits.
#[derive(Clone, Debug, Default)]
pub struct System {
    /// Start of each cell's gather row; one more entry than cells.
    pub cell_offsets: Vec<u32>,
    /// Gather rows.
    pub cell_links: Vec<Link>,
    /// What each cell sends by itself, scaled W/m²; the fourth number is unused.
    pub source: Vec<[f32; 4]>,
    /// Start of each node's deposit row; one more entry than nodes.
    pub node_offsets: Vec<u32>,
    /// Deposit rows.
    pub node_links: Vec<Link>,
    /// Gradient fit of each node.
    pub planes: Vec<Plane>,
    /// What arrives at each node before any cell: h the value, g0 and g1 the moments (not yet a gradient).
    pub node_source: Vec<NodeLight>,
    /// A material for each node, where reflectance varies over the scene's own; else empty.
    pub materials: Vec<Material>,
}

impl System {
    /// Reflectance of a node, of the scene's materials or its own.
    pub fn rho(&self, materials: &[Material], node: usize) -> [f32; 3] {
        self.materials.get(node).unwrap_or_else(|| &materials[self.planes[node].material as usize]).rho
    }
}

/// beta of every cell.
pub fn beta(system: &System, materials: &[Material], light: &[NodeLight]) -> Vec<[f32; 4]> {
    (0..system.source.len())
        .into_par_iter()
        .map(|c| {
            let mut sum = Vec3::from_slice(&system.source[c][..3]);
            for l in &system.cell_links[system.cell_offsets[c] as usize..system.cell_offsets[c + 1] as usize] {
                let node = &light[l.other as usize];
                let rho = Vec3::from(system.rho(materials, l.other as usize));
                sum += rho * (Vec3::from(node.h) * l.value + Vec3::from(node.g0) * l.first + Vec3::from(node.g1) * l.second);
            }
            [sum.x, sum.y, sum.z, 0.0]
        })
        .collect()
}

/// H and its gradient at every node.
pub fn update(system: &System, beta: &[[f32; 4]]) -> Vec<NodeLight> {
    (0..system.planes.len())
        .into_par_iter()
        .map(|j| {
            let s = &system.node_source[j];
            let (mut h, mut m1, mut m2) = (Vec3::from(s.h), Vec3::from(s.g0), Vec3::from(s.g1));
            for l in &system.node_links[system.node_offsets[j] as usize..system.node_offsets[j + 1] as usize] {
                let b = Vec3::from_slice(&beta[l.other as usize][..3]);
                h += b * l.value;
                m1 += b * l.first;
                m2 += b * l.second;
            }
            let p = &system.planes[j];
            let (g0, g1) = (m1 * p.i11 + m2 * p.i12, m1 * p.i12 + m2 * p.i22);
            NodeLight { h: h.to_array(), g0: g0.to_array(), g1: g1.to_array(), ..NodeLight::default() }
        })
        .collect()
}

/// `sweeps` Jacobi sweeps from `light`.
pub fn jacobi(system: &System, materials: &[Material], light: &[NodeLight], sweeps: u32) -> Vec<NodeLight> {
    let mut light = light.to_vec();
    for _ in 0..sweeps {
        light = update(system, &beta(system, materials, &light));
    }
    light
}
