//! Form factors and the kernel: cases A, and the rows of E.

use super::scenes::{cube, grey, placed, plate, solid};
use super::trial::{Trial, starts};
use crate::error::Result;
use crate::layout::{NONE, Point};
use crate::scene::Geometry;
use crate::scene::shapes::{self, Triangles, cut, flipped, moved, quad, sphere};
use std::f64::consts::PI;

/// Rays of a form factor.
const RAYS: u32 = 1 << 18;

/// F from the first of two quads, faces 0 and 1, to the second.
fn between(t: &mut Trial, quads: &[Triangles; 2], rays: u32) -> Result<(f64, usize)> {
    let scene = solid(&quads.concat(), &[grey(0.5, 1.0)])?;
    t.form_factor(&scene, |face| face < 2, |face| face >= 2, rays)
}

/// A unit square that stands on the y axis at `degrees` to the floor, and faces it.
fn hinged(degrees: f64) -> Triangles {
    let (sin, cos) = degrees.to_radians().sin_cos();
    quad([[0.0; 3], [0.0, 1.0, 0.0], [cos, 1.0, sin], [cos, 0.0, sin]], 0)
}

pub fn common_edge(t: &mut Trial) -> Result<()> {
    let got = between(t, &[plate(0.0, true), hinged(90.0)], 4 * RAYS)?;
    t.share("F of squares with a common edge", 0.20004377607540, got);
    Ok(())
}

pub fn hinges(t: &mut Trial) -> Result<()> {
    for (degrees, truth) in
        [(1.0, 0.98299717857), (10.0, 0.84960612496), (45.0, 0.48334769548), (135.0, 0.04830944780), (170.0, 0.00236205668)]
    {
        let got = between(t, &[plate(0.0, true), hinged(degrees)], RAYS)?;
        t.share(format!("F of squares at {degrees} degrees"), truth, got);
    }
    Ok(())
}

pub fn common_corner(t: &mut Trial) -> Result<()> {
    let wall = quad([[0.0, -1.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0], [0.0, -1.0, 1.0]], 0);
    let got = between(t, &[plate(0.0, true), wall], RAYS)?;
    t.share("F of squares with a common corner", 0.04059223010156, got);
    Ok(())
}

pub fn gaps(t: &mut Trial) -> Result<()> {
    for (gap, truth) in [
        (1e-1, 0.8269945223972),
        (1e-2, 0.9804166029260),
        (1e-3, 0.9980056319076),
        (1e-4, 0.9998000709778),
        (1e-5, 0.9999800008564),
        (1e-6, 0.9999980000100),
    ] {
        let got = between(t, &[plate(0.0, true), plate(gap, false)], RAYS)?;
        t.share(format!("F of plates {gap:e} apart"), truth, got);
    }
    Ok(())
}

/// Points of two sets of faces, one of each a pair, unrelated.
pub fn pairs(geometry: &Geometry, from: impl Fn(u32) -> bool, to: impl Fn(u32) -> bool, n: u32) -> Vec<Point> {
    let (x, y) = (starts(geometry, from, n), starts(geometry, to, n));
    let other = |i: usize| y[(i * 7919 + 13) % y.len().max(1)]; // 7919 is prime: every point once
    x.iter().enumerate().flat_map(|(i, &x)| [x, other(i)]).collect()
}

pub fn coplanar(t: &mut Trial) -> Result<()> {
    // A plane of 2,048 triangles, skew and far from the origin: rounding tilts each a little.
    let plane = moved(cut(&plate(0.0, true), 32), placed(1.0, 1e5));
    let geometry = Geometry::new(&solid(&plane, &[grey(0.5, 1.0)])?)?;
    let pairs = pairs(&geometry, |_| true, |_| true, 1 << 16);
    let values = t.kernel(&geometry, &pairs)?;
    t.near("pairs in one plane that see each other", 0.0, values.iter().filter(|&&g| g != 0.0).count() as f64, 0.0);
    Ok(())
}

pub fn back_to_back(t: &mut Trial) -> Result<()> {
    let scene = solid(&[plate(0.0, false), plate(1.0, true)].concat(), &[grey(0.5, 1.0)])?;
    let geometry = Geometry::new(&scene)?;
    let pairs = pairs(&geometry, |face| face < 2, |face| face >= 2, 1 << 16);
    let sum: f64 = t.kernel(&geometry, &pairs)?.iter().map(|&g| f64::from(g)).sum();
    t.near("G of plates back to back", 0.0, sum, 0.0);
    Ok(())
}

pub fn tetrahedron(t: &mut Trial) -> Result<()> {
    let scene = solid(&shapes::tetrahedron(), &[0; 4].map(|_| grey(0.5, 1.0)))?;
    let (mut factors, mut rows, mut rays) = (Vec::new(), Vec::new(), 0);
    for i in 0..4 {
        let mut row = 0.0;
        for j in (0..4).filter(|&j| j != i) {
            let got = t.form_factor(&scene, |face| face == i, |face| face == j, RAYS / 4)?;
            factors.push(got.0);
            (row, rays) = (row + got.0, got.1);
        }
        rows.push(row);
    }
    let error = 5.0 * (2.0 / 9.0 / rays as f64).sqrt();
    t.all_near("F between a tetrahedron's sides, the worst of 12", 1.0 / 3.0, &factors, error);
    // All rays meet a side: the rest is the rounding of three additions.
    t.all_near("F from a side to all others, the worst of 4", 1.0, &rows, 1e-15);
    Ok(())
}

pub fn scales(t: &mut Trial) -> Result<()> {
    // Two small squares at (s,0,0) and (0,s,0) that face the origin along their axes.
    for s in [1e-12, 1e-6, 1.0, 1e6, 1e12] {
        let h = 0.1 * s;
        let x = quad([[s, -h, -h], [s, -h, h], [s, h, h], [s, h, -h]], 0);
        let y = quad([[-h, s, -h], [h, s, -h], [h, s, h], [-h, s, h]], 0);
        let geometry = Geometry::new(&solid(&[x, y].concat(), &[grey(0.5, 1.0)])?)?;
        let place = |p: [f64; 3], n: [f64; 3]| {
            let at = geometry.locate(p, n).map(|at| Point { p: at.p, tri: at.tri, ..Point::default() });
            at.unwrap_or(Point { tri: NONE, ..Point::default() })
        };
        let pair = [place([s, 0.0, 0.0], [-1.0, 0.0, 0.0]), place([0.0, s, 0.0], [0.0, -1.0, 0.0])];
        let g: f64 = t.kernel(&geometry, &pair)?.iter().map(|&g| f64::from(g)).sum();
        let truth = 1.0 / (4.0 * PI);
        t.near(format!("G s² of points {s:e} m away"), truth, g * (geometry.scale * s).powi(2), 1e-6 * truth);
    }
    Ok(())
}

pub fn concentric(t: &mut Trial) -> Result<()> {
    // Of one tessellation, so that areas go as squares exactly.
    let inner = moved(sphere(3, 0), |p| p.map(|x| 0.5 * x));
    let faces = inner.len() as u32;
    let scene = solid(&[inner, flipped(sphere(3, 1))].concat(), &[grey(0.3, 1.0), grey(0.6, 0.0)])?;
    let inside = move |face: u32| face < faces;
    let got = t.form_factor(&scene, inside, |face| !inside(face), RAYS)?;
    t.near("F12 of concentric spheres", 1.0, got.0, 0.0);
    let got = t.form_factor(&scene, |face| !inside(face), inside, RAYS)?;
    t.share("F21 of concentric spheres", 0.25, got);
    let got = t.form_factor(&scene, |face| !inside(face), |face| !inside(face), RAYS)?;
    t.share("F22 of concentric spheres", 0.75, got);
    Ok(())
}

pub fn rows(t: &mut Trial) -> Result<()> {
    let turned = moved(cut(&cube(), 4), placed(3.0, 7.0));
    for (what, triangles) in [("a skew cube of 192 triangles", turned), ("a sphere of 1280", flipped(sphere(3, 0)))] {
        let scene = solid(&triangles, &[0; 6].map(|_| grey(0.5, 1.0)))?;
        let got = t.form_factor(&scene, |_| true, |_| true, RAYS)?;
        t.near(format!("F of all to all in {what}"), 1.0, got.0, 0.0);
    }
    Ok(())
}
