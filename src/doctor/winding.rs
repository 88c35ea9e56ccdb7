//! Surfaces wound the wrong way round.
//!
//! A room is right when its normals point inwards and a box in it when they point outwards, so no rule of
//! volumes tells them apart; light does: what it meets from behind is wrong. Where no light comes, the
//! smaller part of an object that disagrees with its neighbours along their edges is.

use super::finding::{Check, Finding, count, faces};
use super::light::Met;
use super::mesh::Mesh;
use super::tally::{Tally, middle, name};

/// Meetings with light that say something of a whole patch, and of one that its neighbours contradict.
const ENOUGH: [u32; 2] = [24, 8];
/// Share of meetings from behind that makes a patch wrong by itself.
const MOSTLY: f64 = 0.9;

/// Which patches are flipped. Those in `away` shine at nothing, which is their fault already.
pub fn wrong(mesh: &Mesh, met: &Met, away: &[u32]) -> Vec<bool> {
    let mut wrong = vec![false; mesh.patch_area.len()];
    let mut excused = vec![false; mesh.patch_area.len()];
    away.iter().for_each(|&p| excused[p as usize] = true);

    // What light meets from behind.
    for p in 0..wrong.len() {
        let all = met.front[p] + met.back[p];
        wrong[p] = !excused[p] && all >= ENOUGH[0] && met.back[p] as f64 >= MOSTLY * all as f64;
    }

    // What disagrees with the rest of its object, largest patches first: their word counts.
    let mut disputes: Vec<[u32; 2]> = mesh
        .meetings
        .iter()
        .filter(|m| !m.agree && mesh.object(m.tris[0]) == mesh.object(m.tris[1]))
        .map(|m| m.tris.map(|t| mesh.patch[t as usize]))
        .filter(|[a, b]| a != b)
        .map(|[a, b]| if mesh.patch_area[a as usize] < mesh.patch_area[b as usize] { [a, b] } else { [b, a] })
        .collect();
    disputes.sort_by(|a, b| mesh.patch_area[b[0] as usize].total_cmp(&mesh.patch_area[a[0] as usize]).then(a.cmp(b)));
    disputes.dedup();
    for [small, large] in disputes {
        let (s, l) = (small as usize, large as usize);
        if wrong[l] || wrong[s] || excused[s] || excused[l] {
            continue;
        }
        let known = met.front[s] + met.back[s] >= ENOUGH[1];
        wrong[s] = !known || met.back[s] > met.front[s];
    }

    wrong
}

/// Flipped triangles by object.
pub fn flipped(mesh: &Mesh, wrong: &[bool]) -> Vec<Finding> {
    let mut tally = Tally::new();
    for t in (0..mesh.corners.len() as u32).filter(|&t| wrong[mesh.patch[t as usize] as usize]) {
        tally.add(mesh.object(t), mesh.face(t), middle(mesh.scene, mesh.face(t)));
    }
    let [one, many] = faces(mesh.scene);
    tally.findings(|object, seen| {
        let name = name(mesh.scene, object);
        let message = format!("object '{name}': {} with the back to the light or to their neighbours", count(seen.count, one));
        let cure = "flip their normals in the modeller, or bake with --two-sided";
        Finding::new(Check::Flipped, name, seen.count as f64, many, message, cure)
    })
}
