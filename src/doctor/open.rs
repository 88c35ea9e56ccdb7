//! Where light leaks: holes in surfaces that are closed but for them, and slits between what nearly touches.
//!
//! Lamps, single walls, rooms open to one side and boxes without a bottom have borders by design. A border
//! counts only where lit space on one side of it lies against darkness (backs, or nothing) on the other.

use super::finding::{Check, Finding, count, metres};
use super::mesh::{Mesh, Side, WELD};
use super::nearest::nearest;
use super::rays::{Dice, Sight};
use super::tally::{Tally, name};
use crate::layout::NONE;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// Largest hole, as a share of its patch; larger ones are windows and doors.
const HOLE: f64 = 0.02;
/// Largest missing half of a quad, as a share of its patch.
const HALF: f64 = 0.2;
/// Narrowest hole, local: less is a seam between finer and coarser triangles.
const NARROW: f64 = 2e-5;
/// Widest slit, local; and as a share of its edge.
const SLIT: [f64; 2] = [2e-3, 0.1];
/// Rays on each side of a border.
const RAYS: u32 = 48;
/// A border is closed where more rays than this share meet a back, or something at hand, on its lit side.
const CLOSED: f64 = 0.4;
/// It leaks where at least this share of rays meets darkness on the other. (A box that stands on a floor shows
/// the lit floor through a hole in its lid, beside its own backs.)
const DARK: f64 = 0.25;

/// Holes and slits by object.
pub fn open(mesh: &Mesh) -> Vec<Finding> {
    let slits: Vec<Slit> = mesh.border.par_iter().filter_map(|&side| slit(mesh, side)).collect();
    let mut findings = holes(mesh, &slits);
    findings.extend(tell_slits(mesh, slits));
    findings
}

/// The two ends of a side.
fn ends(mesh: &Mesh, side: Side) -> [u32; 2] {
    let c = mesh.corners[side.tri as usize];
    [c[side.k as usize], c[(side.k as usize + 1) % 3]]
}

/// Whether a place lies between light (the way of `n`) and darkness. `size` is the opening's.
fn leaks(mesh: &Mesh, places: &[DVec3], n: DVec3, size: f64) -> bool {
    let look = |n: DVec3, seed: u32| -> Vec<Sight> {
        (0..RAYS)
            .map(|i| {
                let mut dice = Dice::new(seed, i);
                let place = places[i as usize % places.len()].as_vec3();
                mesh.look_about(place, n.as_vec3(), NONE, &mut dice).0
            })
            .collect()
    };
    let share =
        |sights: &[Sight], counts: &dyn Fn(&Sight) -> bool| sights.iter().filter(|s| counts(s)).count() as f64 / RAYS as f64;
    // What stands right before an opening closes it.
    let near = (0.05 * size) as f32;
    let (lit, dark) = (look(n, 4), look(-n, 5));
    let closed = share(&lit, &|s| matches!(s, Sight::Back(..)) || matches!(s, Sight::Front(_, t) if *t < near));
    let through = share(&dark, &|s| matches!(s, Sight::Void) || matches!(s, Sight::Back(_, t) if *t > near));
    closed <= CLOSED && through >= DARK
}

/// Small holes. What goes round a slit is no hole as well.
fn holes(mesh: &Mesh, slits: &[Slit]) -> Vec<Finding> {
    let slits: HashSet<Side> = slits.iter().map(|s| s.side).collect();
    // Sides by their first end, to walk round a hole.
    let mut from: HashMap<u32, Vec<usize>> = HashMap::new();
    for (i, &side) in mesh.border.iter().enumerate() {
        from.entry(ends(mesh, side)[0]).or_default().push(i);
    }
    let mut used = vec![false; mesh.border.len()];
    let mut tally = Tally::new();
    let mut widest: HashMap<u32, f64> = HashMap::new();
    for start in 0..mesh.border.len() {
        // Walk on from end to end until it closes, or leads nowhere new.
        let mut ring: Vec<Side> = Vec::new();
        let mut next = (!used[start]).then_some(start);
        while let Some(at) = next {
            used[at] = true;
            ring.push(mesh.border[at]);
            let to = ends(mesh, mesh.border[at])[1];
            let closed = to == ends(mesh, ring[0])[0];
            next = if closed { None } else { from.get(&to).and_then(|on| on.iter().copied().find(|&i| !used[i])) };
        }
        if ring.len() < 3 || ends(mesh, ring[ring.len() - 1])[1] != ends(mesh, ring[0])[0] {
            continue;
        }
        if ring.iter().any(|side| slits.contains(side)) {
            continue;
        }
        if let Some((width, places, n)) = hole(mesh, &ring)
            && leaks(mesh, &places, n, width)
        {
            let (tri, object) = (ring[0].tri, mesh.object(ring[0].tri));
            tally.add(object, mesh.face(tri), mesh.world(places[0]));
            let most = widest.entry(object).or_default();
            *most = most.max(width);
        }
    }
    tally.findings(|object, seen| {
        let (name, width) = (name(mesh.scene, object), metres(mesh.metres(widest[&object])));
        let message = format!("object '{name}': {} in a closed surface, up to {width} wide", count(seen.count, "hole"));
        Finding::new(Check::Open, name, seen.count as f64, "holes", message, "fill the missing faces in the modeller")
    })
}

/// Width, places and outward normal of a ring of sides round a hole; none where it is too large or a seam.
fn hole(mesh: &Mesh, ring: &[Side]) -> Option<(f64, Vec<DVec3>, DVec3)> {
    let corners: Vec<DVec3> = ring.iter().map(|&s| mesh.vertices[ends(mesh, s)[0] as usize]).collect();
    let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let fans: Vec<DVec3> =
        (0..corners.len()).map(|i| 0.5 * (corners[i] - centre).cross(corners[(i + 1) % corners.len()] - centre)).collect();
    // The faces round a hole run along it the other way than its filling would.
    let filling = -fans.iter().sum::<DVec3>();
    let (area, n) = (filling.length(), filling.normalize_or_zero());
    let across = corners.iter().map(|c| c.distance(centre)).fold(0.0, f64::max) * 2.0;
    let patch = mesh.patch_area[mesh.patch[ring[0].tri as usize] as usize];
    let level = |s: &Side| mesh.normal(s.tri).dot(n) > 0.999;
    let small = area < HOLE * patch || (ring.len() == 3 && area < HALF * patch && ring.iter().any(level));
    if !small || n == DVec3::ZERO || area < NARROW * across {
        return None;
    }
    // Places all over the filling: the middles between the centre and the sides.
    let places = (0..corners.len()).map(|i| (corners[i] + corners[(i + 1) % corners.len()] + centre) / 3.0).collect();
    Some((area / across, places, n))
}

/// A border that all but touches something.
struct Slit {
    side: Side,
    /// The triangle it nearly touches.
    other: u32,
    /// Local.
    width: f64,
    /// In the middle of the slit.
    place: DVec3,
}

/// Slits by object. Where two borders face each other, both see the slit: the one with more edges tells.
fn tell_slits(mesh: &Mesh, slits: Vec<Slit>) -> Vec<Finding> {
    let key = |s: &Slit| [mesh.object(s.side.tri), mesh.object(s.other)];
    let mut edges: HashMap<[u32; 2], usize> = HashMap::new();
    for slit in &slits {
        *edges.entry(key(slit)).or_default() += 1;
    }
    let tells = |k: [u32; 2]| {
        let (own, others) = (edges[&k], edges.get(&[k[1], k[0]]).copied().unwrap_or(0));
        own > others || (own == others && k[0] <= k[1])
    };
    let mut tally = Tally::new();
    let mut widest: HashMap<[u32; 2], f64> = HashMap::new();
    for slit in slits.iter().filter(|s| tells(key(s))) {
        tally.add(key(slit), mesh.face(slit.side.tri), mesh.world(slit.place));
        let most = widest.entry(key(slit)).or_default();
        *most = most.max(slit.width);
    }
    tally.findings(|key, seen| {
        let [name, other] = key.map(|object| name(mesh.scene, object));
        let width = mesh.metres(widest[&key]);
        let to = if key[0] == key[1] { "the next surface".into() } else { format!("object '{other}'") };
        let edges = count(seen.count, "edge");
        let message = format!("object '{name}': a gap of {} along {edges}, before {to}", metres(width));
        let finding = Finding::new(Check::Open, name, width, "m", message, "snap the edges together in the modeller");
        Finding { other: (key[0] != key[1]).then(|| other.into()), ..finding }
    })
}

/// The slit at a border, if there is one.
fn slit(mesh: &Mesh, side: Side) -> Option<Slit> {
    if mesh.shines(side.tri) {
        return None;
    }
    let [a, b] = ends(mesh, side);
    let [pa, pb] = [a, b].map(|v| mesh.vertices[v as usize]);
    let along = pb - pa;
    let reach = SLIT[0].min(SLIT[1] * along.length());
    let n = mesh.normal(side.tri);
    let outward = along.cross(n).normalize_or_zero();
    let touches = |t: u32| mesh.corners[t as usize].iter().any(|&v| v == a || v == b);
    let mut widest: Option<(u32, f64, DVec3)> = None;
    for share in [0.25, 0.5, 0.75] {
        let p = pa + along * share;
        let (t, q) = nearest(mesh, p, reach, |t| t != side.tri && !touches(t))?;
        let width = p.distance(q);
        // Straight on from the border, neither beside its surface nor beneath it; and not touching.
        if width <= 4.0 * WELD || (q - p).dot(outward) < 0.7 * width {
            return None;
        }
        if widest.is_none_or(|w| w.1 < width) {
            widest = Some((t, width, 0.5 * (p + q)));
        }
    }
    let (other, width, place) = widest?;
    leaks(mesh, &[place], n, 0.0).then_some(Slit { side, other, width, place })
}
