//! The second solver: Gauss-Seidel on the host, each node with the newest light of all others.

use crate::layout::{Link, Material, NodeLight};
use crate::twin::jacobi::System;
use glam::DVec3;

/// A system turned about, so that a node knows which cells gather from it.
pub struct GaussSeidel<'a> {
    system: &'a System,
    materials: &'a [Material],
    /// Start of each node's readers; one more entry than nodes.
    offsets: Vec<u32>,
    /// The cells that gather from each node: `other` names the cell.
    readers: Vec<Link>,
}

/// A node's light while sweeps go on.
#[derive(Clone, Copy)]
struct Light {
    h: DVec3,
    g: [DVec3; 2],
}

fn wide(x: [f32; 3]) -> DVec3 {
    DVec3::from_array(x.map(f64::from))
}

impl GaussSeidel<'_> {
    /// Prepares a system; `materials` as for the Jacobi pass.
    pub fn new<'a>(system: &'a System, materials: &'a [Material]) -> GaussSeidel<'a> {
        let mut offsets = vec![0u32; system.planes.len() + 1];
        for l in &system.cell_links {
            offsets[l.other as usize + 1] += 1;
        }
        for j in 1..offsets.len() {
            offsets[j] += offsets[j - 1];
        }
        let mut next = offsets.clone();
        let mut readers = vec![Link::default(); system.cell_links.len()];
        for c in 0..system.source.len() {
            for l in &system.cell_links[system.cell_offsets[c] as usize..system.cell_offsets[c + 1] as usize] {
                let at = &mut next[l.other as usize];
                readers[*at as usize] = Link { other: c as u32, ..*l };
                *at += 1;
            }
        }
        GaussSeidel { system, materials, offsets, readers }
    }

    fn rho(&self, node: usize) -> DVec3 {
        wide(self.system.rho(self.materials, node))
    }

    /// `sweeps` sweeps over all nodes in order, from `light`; sums in f64. What a node sends to itself is a sweep old.
    pub fn sweeps(&self, light: &[NodeLight], sweeps: u32) -> Vec<NodeLight> {
        let s = self.system;
        let mut light: Vec<Light> = light.iter().map(|l| Light { h: wide(l.h), g: [wide(l.g0), wide(l.g1)] }).collect();
        let mut beta: Vec<DVec3> = (0..s.source.len())
            .map(|c| {
                let [r, g, b, _] = s.source[c];
                let row = &s.cell_links[s.cell_offsets[c] as usize..s.cell_offsets[c + 1] as usize];
                wide([r, g, b])
                    + row.iter().map(|l| self.rho(l.other as usize) * gathered(l, &light[l.other as usize])).sum::<DVec3>()
            })
            .collect();
        for _ in 0..sweeps {
            for j in 0..light.len() {
                let known = &s.node_source[j];
                let (mut h, mut m1, mut m2) = (wide(known.h), wide(known.g0), wide(known.g1));
                for l in &s.node_links[s.node_offsets[j] as usize..s.node_offsets[j + 1] as usize] {
                    let b = beta[l.other as usize];
                    h += b * l.value as f64;
                    m1 += b * l.first as f64;
                    m2 += b * l.second as f64;
                }
                let p = &s.planes[j];
                let (i11, i12, i22) = (p.i11 as f64, p.i12 as f64, p.i22 as f64);
                let now = Light { h, g: [m1 * i11 + m2 * i12, m1 * i12 + m2 * i22] };
                let old = std::mem::replace(&mut light[j], now);
                let change = Light { h: now.h - old.h, g: [now.g[0] - old.g[0], now.g[1] - old.g[1]] };
                let rho = self.rho(j);
                for l in &self.readers[self.offsets[j] as usize..self.offsets[j + 1] as usize] {
                    beta[l.other as usize] += rho * gathered(l, &change);
                }
            }
        }
        let narrow = |x: DVec3| x.as_vec3().to_array();
        light
            .iter()
            .map(|l| NodeLight { h: narrow(l.h), g0: narrow(l.g[0]), g1: narrow(l.g[1]), ..NodeLight::default() })
            .collect()
    }
}

/// What a link brings from a node's light.
fn gathered(l: &Link, light: &Light) -> DVec3 {
    light.h * l.value as f64 + light.g[0] * l.first as f64 + light.g[1] * l.second as f64
}
