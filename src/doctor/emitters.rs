//! Emitters that shine away from everything.

use super::finding::{Check, Finding, count, faces};
use super::mesh::Mesh;
use super::rays::{Dice, Sight};
use super::tally::{Tally, middle, name};
use crate::layout::NONE;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Rays on each side of an emitter, and fewest where there are many of them.
const RAYS: [usize; 2] = [64, 512];
/// Rays on all emitters together, about.
const ALL: usize = 1 << 18;
/// An emitter is right if this share of its rays meets another front.
const SEEN: f64 = 0.01;
/// An emitter that shines into itself alone is right unless its back sees this share of fronts.
const BEHIND: f64 = 0.05;

/// The emitting patches that shine at nothing, and the findings on them.
pub fn facing_away(mesh: &Mesh) -> (Vec<u32>, Vec<Finding>) {
    let mut patches: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for t in (0..mesh.corners.len() as u32).filter(|&t| mesh.shines(t)) {
        patches.entry(mesh.patch[t as usize]).or_default().push(t);
    }
    let rays = (ALL / patches.len().max(1)).clamp(RAYS[0], RAYS[1]);
    let away: Vec<(u32, Vec<u32>)> =
        patches.into_par_iter().filter(|(patch, tris)| shines_away(mesh, *patch, tris, rays)).collect();

    let mut tally = Tally::new();
    for &t in away.iter().flat_map(|(_, tris)| tris) {
        tally.add(mesh.object(t), mesh.face(t), middle(mesh.scene, mesh.face(t)));
    }
    let [one, many] = faces(mesh.scene);
    let findings = tally.findings(|object, seen| {
        let name = name(mesh.scene, object);
        let message = format!(
            "object '{name}': {} shining away from everything else in the scene",
            count(seen.count, &format!("emitting {one}"))
        );
        let cure = "flip their normals in the modeller, or turn the lamp round";
        Finding::new(Check::EmitterFacingAway, name, seen.count as f64, many, message, cure)
    });
    (away.into_iter().map(|(patch, _)| patch).collect(), findings)
}

/// Whether the front of these triangles sees nothing lightable.
fn shines_away(mesh: &Mesh, patch: u32, tris: &[u32], rays: usize) -> bool {
    // Sheets with two faces shine both ways.
    if mesh.patch_area.len() == 1 || tris.iter().any(|&t| mesh.mirror[t as usize] != NONE) {
        return false;
    }
    let ends: Vec<f64> = tris
        .iter()
        .scan(0.0, |sum, &t| {
            *sum += mesh.geometry.areas[t as usize];
            Some(*sum)
        })
        .collect();
    let total = ends[ends.len() - 1];
    // Shares of rays that meet fronts: of other patches, and of this one.
    let shares = |front: bool| {
        let (mut others, mut own) = (0, 0);
        for i in 0..rays {
            let mut dice = Dice::new(2 + front as u32, i as u32);
            let u = total * (i as f64 + dice.roll() as f64) / rays as f64;
            let tri = tris[ends.partition_point(|&end| end <= u).min(tris.len() - 1)];
            if let (Sight::Front(t, _), _) = mesh.look_from(tri, front, &mut dice) {
                *(if mesh.patch[t as usize] == patch { &mut own } else { &mut others }) += 1;
            }
        }
        [others, own].map(|n| n as f64 / rays as f64)
    };
    let [others, own] = shares(true);
    others < SEEN && (own < SEEN || shares(false)[0] > BEHIND)
}
