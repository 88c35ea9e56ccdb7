//! What is seen and what is not: cases D.

use super::factors::pairs;
use super::scenes::{SQUARE, cube, flat, grey, placed, plate, solid};
use super::trial::{Trial, spread, starts};
use crate::error::Result;
use crate::layout::{NONE, Point};
use crate::params::Params;
use crate::scene::Geometry;
use crate::scene::shapes::{Triangles, block, cut, moved, quad, room, sphere};
use crate::solution::SurfacePoint;
use crate::twin::math::kernel_g;
use glam::{DVec3, Vec3};
use std::collections::BTreeSet;

/// What two points would exchange if nothing stood between them.
fn open_g(geometry: &Geometry, pair: &[Point]) -> f32 {
    let normal = |p: &Point| Vec3::from(geometry.tris[p.tri as usize].normal);
    kernel_g(geometry.flatland, pair[0].p.into(), normal(&pair[0]), pair[1].p.into(), normal(&pair[1]))
}

pub fn convex(t: &mut Trial) -> Result<()> {
    for (scale, by) in [(1e-6, 0.0), (1.0, 0.0), (1.0, 1e4), (1e6, 0.0)] {
        let triangles = moved(cut(&cube(), 8), placed(scale, by));
        let geometry = Geometry::new(&solid(&triangles, &[0; 6].map(|_| grey(0.5, 1.0)))?)?;
        let pairs = pairs(&geometry, |_| true, |_| true, 1 << 15);
        let seen = t.kernel(&geometry, &pairs)?;
        // Points on an edge see each other at no angle: 1e-6 of what they see at most.
        let hidden = pairs.chunks(2).zip(seen).filter(|(pair, g)| open_g(&geometry, pair) > 1e-6 && *g == 0.0).count();
        t.near(format!("false shadows in a skew cube of {scale:e} m at {by:e} m"), 0.0, hidden as f64, 0.0);
    }
    Ok(())
}

/// Corners and points of the edges of a mesh.
fn seams(mesh: &Triangles) -> Vec<DVec3> {
    // Ends in one order: both triangles of an edge then tell the same points.
    let bits = |p: [f64; 3]| p.map(f64::to_bits);
    let mut places = BTreeSet::new();
    for ([a, b, c], _) in mesh {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let (p, q) = if bits(*p) < bits(*q) { (p, q) } else { (q, p) };
            for s in [0.0, 0.1, 0.5, 0.77, 1.0] {
                places.insert(bits(DVec3::from(*p).lerp((*q).into(), s).to_array()));
            }
        }
    }
    places.into_iter().map(|p| DVec3::from(p.map(f64::from_bits))).collect()
}

pub fn watertight(t: &mut Trial) -> Result<()> {
    // A small block within a closed mesh within a room: whoever looks from the block at a seam of the mesh must
    // not see the room behind it.
    let (low, high) = ([-2.0; 3], [2.0; 3]);
    let outside = [block([-0.1; 3], [0.1; 3], 0), room(low, high, [0; 6])].concat();
    let skew = |p| placed(1.2, 0.0)(p);
    for (what, mesh) in [
        ("a sphere of 1280 triangles", sphere(3, 0)),
        ("a skew cube of 12", moved(cube(), skew)),
        ("a skew cube of 432", moved(cut(&cube(), 6), skew)),
    ] {
        let mesh: Triangles = mesh.into_iter().map(|(corners, _)| (corners, 0)).collect();
        let scene =
            |with: &Triangles| Geometry::new(&solid(&[&outside, with].map(|t| t.as_slice()).concat(), &[grey(0.5, 1.0)])?);
        let (closed, open) = (scene(&mesh)?, scene(&Vec::new())?);
        let count = outside.len() as u32;
        let eyes = starts(&closed, |face| face < 12, 16);
        let (mut pairs, mut without) = (Vec::new(), Vec::new());
        for eye in &eyes {
            let (from, normal) =
                (DVec3::from(closed.to_world(eye.p)), Vec3::from(closed.tris[eye.tri as usize].normal).as_dvec3());
            for seam in seams(&mesh) {
                let way = seam - from;
                // Where it leaves the room, and through which side.
                let far = |k: usize| (if way[k] > 0.0 { high[k] } else { low[k] } - from[k]) / way[k];
                let Some(axis) = (0..3).filter(|&k| way[k] != 0.0).min_by(|&a, &b| far(a).total_cmp(&far(b))) else { continue };
                let (at, mut n) = (from + way * far(axis), [0.0; 3]);
                n[axis] = -way[axis].signum();
                if way.dot(normal) <= 1e-3 {
                    continue;
                }
                for (geometry, list) in [(&closed, &mut pairs), (&open, &mut without)] {
                    let place = |p: DVec3, n: [f64; 3]| {
                        let at = geometry.locate(p.to_array(), n).filter(|at| geometry.source[at.tri as usize] < count);
                        at.map_or(Point { tri: NONE, ..Point::default() }, |at| Point {
                            p: at.p,
                            tri: at.tri,
                            ..Point::default()
                        })
                    };
                    list.extend([place(from, normal.to_array()), place(at, n)]);
                }
            }
        }
        let through = t.kernel(&closed, &pairs)?.iter().filter(|&&g| g != 0.0).count();
        let seen = t.kernel(&open, &without)?.iter().filter(|&&g| g > 0.0).count();
        t.near(format!("rays through the seams of {what}"), 0.0, through as f64, 0.0);
        t.near("rays that pass where the mesh is taken away", without.len() as f64 / 2.0, seen as f64, 0.0);
    }
    Ok(())
}

pub fn strings(t: &mut Trial) -> Result<()> {
    const RAYS: u32 = 1 << 20;
    let both = |[a, b]: [[f64; 2]; 2]| vec![[a, b], [b, a]];
    let room = |more: Vec<[[f64; 2]; 2]>| flat(&[SQUARE.to_vec(), more].concat(), &[grey(0.5, 1.0)]);
    let mut share = |what: &str, more, from, to, truth: f64| {
        let got = t.form_factor(&room(more)?, |face| face == from, |face| face == to, RAYS)?;
        t.share(what, truth, got);
        Ok::<_, crate::Error>(())
    };
    share("F of a square's opposite sides", Vec::new(), 0, 2, 2f64.sqrt() - 1.0)?;
    share("F of a square's neighbouring sides", Vec::new(), 0, 1, 1.0 - 0.5f64.sqrt())?;
    share("F past a blocker half way", both([[0.25, 0.5], [0.75, 0.5]]), 0, 2, 5f64.sqrt() / 2.0 - 1.0)?;
    share("F over a fin of half the height", both([[0.5, 0.0], [0.5, 0.5]]), 3, 1, (2f64.sqrt() - 1.0) / 2.0)?;
    share("F over a fin of full height", both([[0.5, 0.0], [0.5, 1.0]]), 3, 1, 0.0)
}

pub fn dark_room(t: &mut Trial) -> Result<()> {
    // Two cubes with one partition between them, its corners the walls' own; a lamp in the left one, another outside.
    let lamp = quad([[-0.5, 0.0, 0.0], [-0.5, 1.0, 0.0], [-0.5, 1.0, 1.0], [-0.5, 0.0, 1.0]], 1);
    let left = room([0.0; 3], [1.0; 3], [0, 0, 0, 0, 0, 1]);
    let right = room([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], [0; 6]);
    let scene = solid(&[left, right, lamp].concat(), &[grey(0.5, 0.0), grey(0.5, 1.0)])?;
    let params = Params { rays: 16_384, ..Params::default() };
    let solution = t.bake(&scene, &params)?;
    let mut points = spread(&scene, |face| (12..24).contains(&face), 256)?;
    // A hair from the edges, where leaks are.
    for s in [1e-4, 0.3, 0.9999] {
        for near in [1e-5, 1e-3] {
            points.push(SurfacePoint { p: [1.0 + near, s, 0.0], n: [0.0, 0.0, 1.0] });
            points.push(SurfacePoint { p: [1.0, s, near], n: [1.0, 0.0, 0.0] });
        }
    }
    let answers = solution.query(t.backend, &points)?;
    let b: Vec<f64> = answers.iter().flat_map(|a| a.b).collect();
    t.all_near("b behind a closed wall, the worst point", 0.0, &b, 0.0);
    // The left room is closed as well: its light is that of one lit side in six.
    let answers = solution.query(t.backend, &spread(&scene, |face| face < 12, 256)?)?;
    let mean = answers.iter().map(|a| a.b[0]).sum::<f64>() / answers.len() as f64;
    t.near("b before it, the mean", 1.0 / 3.0, mean, 5e-3); // 16,384 rays: the catalogue's 1e-3 is for full bakes
    Ok(())
}

pub fn penumbra(t: &mut Trial) -> Result<()> {
    let wide = |z: f64, up: bool, half: f64, m: u32| -> Triangles {
        let at = |p: [f64; 3]| [half * (2.0 * p[0] - 1.0), half * (2.0 * p[1] - 1.0), z];
        moved(plate(0.0, up), at).into_iter().map(|(corners, _)| (corners, m)).collect()
    };
    let scene = solid(
        &[wide(0.0, true, 1.0, 0), wide(1.0, false, 1.0, 1), wide(0.5, false, 0.25, 0)].concat(),
        &[grey(0.0, 0.0), grey(0.0, 1.0)],
    )?;
    let params = Params { rays: 1024, direct_tolerance: 5e-4, direct_samples: 65_536, ..Params::default() };
    let solution = t.bake(&scene, &params)?;
    for (x, y, truth) in
        [(0.0, 0.0, 0.31466995352), (0.3, 0.2, 0.39019056758), (0.6, 0.0, 0.41657639065), (0.75, 0.75, 0.32197286823)]
    {
        let answers = solution.query(t.backend, &[SurfacePoint { p: [x, y, 0.0], n: [0.0, 0.0, 1.0] }])?;
        t.near(format!("H under a blocker at ({x}, {y})"), truth, answers[0].h[0], 3e-3 * truth);
    }
    Ok(())
}
