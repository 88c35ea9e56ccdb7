//! Pairs of triangles in each other's way: running through each other, or covering each other in one plane.

use super::finding::{Check, Finding, count};
use super::mesh::Mesh;
use super::rays::{Dice, Sight};
use super::tally::{Tally, name};
use crate::layout::NONE;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// How deep one surface must reach through another, local: less is a contact.
const DEEP: f64 = 1e-4;
/// Surfaces nearer than this are in one plane, local.
const LEVEL: f64 = 1e-5;
/// Least cosine of normals in one plane.
const PARALLEL: f64 = 1.0 - 1e-6;
/// How far triangles in one plane must cover each other, as a share of the lower height of the two.
const COVER: f64 = 0.05;
/// Rays that tell whether a place lies within a closed surface.
const RAYS: u32 = 16;

/// What two triangles do to each other.
enum Trouble {
    /// They cross; a place on the line.
    Cross(DVec3),
    /// One covers the other; a place on both.
    Cover(DVec3),
}

/// Objects that run through each other, and surfaces that cover each other. What is flipped (`wrong`, a patch
/// each) covers nothing: turned back, a box's bottom faces the floor it stands on.
pub fn pairs(mesh: &Mesh, wrong: &[bool]) -> Vec<Finding> {
    let found: Vec<(u32, u32, Trouble)> = (0..mesh.corners.len() as u32)
        .into_par_iter()
        .flat_map_iter(|i| {
            let mut found = Vec::new();
            meet_boxes(mesh, i, &mut |j| {
                if let Some(trouble) = trouble(mesh, wrong, i, j) {
                    found.push((i, j, trouble));
                }
            });
            found
        })
        .collect();

    let (mut cross, mut cover) = (Tally::new(), Tally::new());
    for (i, j, trouble) in found {
        // The pair in the order of the file.
        let (i, j) = if mesh.face(i) < mesh.face(j) { (i, j) } else { (j, i) };
        let key = [mesh.object(i), mesh.object(j)];
        match trouble {
            Trouble::Cross(place) => cross.add(key, mesh.face(i), mesh.world(place)),
            Trouble::Cover(place) => cover.add(key, mesh.face(i), mesh.world(place)),
        }
    }
    let tell = |check, [a, b]: [u32; 2], n: usize, verb: &str, cure| {
        let [name, other] = [a, b].map(|object| name(mesh.scene, object));
        let what = if a == b { "its own surface".into() } else { format!("object '{other}'") };
        let message = format!("object '{name}' {verb} {what} in {}", count(n, "pair"));
        let finding = Finding::new(check, name, n as f64, "pairs", message, cure);
        Finding { other: (a != b).then(|| other.into()), ..finding }
    };
    let mut findings = cross.findings(|key, seen| {
        tell(Check::Intersecting, key, seen.count, "runs through", "move them apart, or cut one with the other in the modeller")
    });
    findings.extend(cover.findings(|key, seen| {
        tell(
            Check::Overlapping,
            key,
            seen.count,
            "lies in one plane with, and covers,",
            "move one off the other, or cut a hole for it",
        )
    }));
    findings
}

/// Calls `meet` with every triangle after `i` whose box meets the box of `i` and the plane of `i`.
fn meet_boxes(mesh: &Mesh, i: u32, meet: &mut impl FnMut(u32)) {
    let vec = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let [a, b, c] = mesh.triangle(i);
    let (low, high) = (a.min(b).min(c) - LEVEL, a.max(b).max(c) + LEVEL);
    let n = mesh.normal(i);
    let mut stack = vec![0u32];
    while let Some(k) = stack.pop() {
        let node = &mesh.geometry.nodes[k as usize];
        let (min, max) = (vec(node.min), vec(node.max));
        let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
        if min.cmpgt(high).any() || max.cmplt(low).any() || n.dot(middle - a).abs() > n.abs().dot(half) + LEVEL {
            continue;
        }
        if node.count == 0 {
            stack.extend([node.first, node.first + 1]);
        } else {
            (node.first..node.first + node.count).filter(|&j| j > i).for_each(&mut *meet);
        }
    }
}

fn trouble(mesh: &Mesh, wrong: &[bool], i: u32, j: u32) -> Option<Trouble> {
    let shared = mesh.corners[i as usize].iter().filter(|v| mesh.corners[j as usize].contains(v)).count();
    // Neighbours along an edge are where they should be; folds are for the eye.
    if shared >= 2 {
        return None;
    }
    let (n, m) = (mesh.normal(i), mesh.normal(j));
    if n.dot(m) > PARALLEL {
        let flipped = [i, j].iter().any(|&t| wrong[mesh.patch[t as usize] as usize]);
        let place = if flipped { None } else { cover(mesh, i, j) };
        return place.filter(|&place| ![i, j].iter().any(|&t| hides(mesh, t, place))).map(Trouble::Cover);
    }
    if mesh.object(i) == mesh.object(j) {
        return None;
    }
    cross(mesh.triangle(i), n, mesh.triangle(j), m).map(Trouble::Cross)
}

/// Where two triangles run through each other by more than [`DEEP`].
fn cross(a: [DVec3; 3], n: DVec3, b: [DVec3; 3], m: DVec3) -> Option<DVec3> {
    let heights = |t: &[DVec3; 3], origin: DVec3, n: DVec3| t.map(|v| n.dot(v - origin));
    let (ha, hb) = (heights(&a, b[0], m), heights(&b, a[0], n));
    let through = |h: &[f64; 3]| h.iter().any(|&x| x > DEEP) && h.iter().any(|&x| x < -DEEP);
    if !through(&ha) || !through(&hb) {
        return None;
    }
    // Where each triangle meets the other's plane, along the line in which the planes meet.
    let line = n.cross(m).try_normalize()?;
    let span = |t: &[DVec3; 3], h: &[f64; 3]| {
        let mut ends: Vec<DVec3> = Vec::with_capacity(3);
        for k in 0..3 {
            let l = (k + 1) % 3;
            if (h[k] < 0.0) != (h[l] < 0.0) {
                ends.push(t[k] + (t[l] - t[k]) * (h[k] / (h[k] - h[l])));
            }
        }
        ends
    };
    let (pa, pb) = (span(&a, &ha), span(&b, &hb));
    let range = |p: &[DVec3]| {
        let x = p.iter().map(|v| line.dot(*v));
        (x.clone().fold(f64::MAX, f64::min), x.fold(f64::MIN, f64::max))
    };
    let ((a0, a1), (b0, b1)) = (range(&pa), range(&pb));
    let (low, high) = (a0.max(b0), a1.min(b1));
    (high - low > DEEP).then(|| pa[0] + line * (0.5 * (low + high) - line.dot(pa[0])))
}

/// Where two triangles that face one way cover each other in one plane.
fn cover(mesh: &Mesh, i: u32, j: u32) -> Option<DVec3> {
    // The larger one's plane is the better known.
    let (i, j) = if mesh.geometry.areas[i as usize] < mesh.geometry.areas[j as usize] { (j, i) } else { (i, j) };
    let (a, b, n) = (mesh.triangle(i), mesh.triangle(j), mesh.normal(i));
    if b.iter().any(|v| n.dot(*v - a[0]).abs() > LEVEL) {
        return None;
    }
    let u = (a[1] - a[0]).try_normalize()?;
    let w = n.cross(u);
    let flat = |t: &[DVec3; 3]| t.map(|v| DVec2::new(u.dot(v - a[0]), w.dot(v - a[0])));
    let (fa, fb) = (flat(&a), flat(&b));
    let height = |t: &[DVec2; 3], tri: u32| {
        let longest = (0..3).map(|k| t[k].distance(t[(k + 1) % 3])).fold(f64::MIN_POSITIVE, f64::max);
        2.0 * mesh.geometry.areas[tri as usize] / longest
    };
    let enough = COVER * height(&fa, i).min(height(&fb, j));
    // Two convex shapes overlap by the least of their overlaps along all side normals.
    for t in [&fa, &fb] {
        for k in 0..3 {
            let axis = (t[(k + 1) % 3] - t[k]).perp().try_normalize()?;
            let range = |s: &[DVec2; 3]| {
                let x = s.map(|v| axis.dot(v));
                (x[0].min(x[1]).min(x[2]), x[0].max(x[1]).max(x[2]))
            };
            let ((a0, a1), (b0, b1)) = (range(&fa), range(&fb));
            if a1.min(b1) - a0.max(b0) < enough {
                return None;
            }
        }
    }
    Some((b[0] + b[1] + b[2]) / 3.0)
}

/// Whether one face of a sheet with two lies where nobody looks: on the inside of its own object, as the upper
/// face of a box's bottom does, or towards nothing.
fn hides(mesh: &Mesh, tri: u32, place: DVec3) -> bool {
    let n = mesh.normal(tri).as_vec3();
    let unseen = |sight: Sight| match sight {
        Sight::Void => true,
        Sight::Front(t, _) | Sight::Back(t, _) => mesh.object(t) == mesh.object(tri),
    };
    let above = place.as_vec3() + n * (2.0 * LEVEL as f32);
    mesh.mirror[tri as usize] != NONE && (0..RAYS).all(|i| unseen(mesh.look_about(above, n, NONE, &mut Dice::new(6, i)).0))
}
