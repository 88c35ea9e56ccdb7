//! Light leaks and false shadows in what is read out: closed walls keep all light out, slots let in what geometry lets in, and
//! the lit foot of a wall is not darker for what is behind it. Whole bakes on the GPU. Dark rooms behind thin walls are
//! D03 and D04.

use super::setup::*;
use glam::DVec3;
use raycell::engine::Engine;
use raycell::layout::{Point, kind};
use raycell::pass::GpuEngine;
use raycell::scene::shapes::{Triangles, block, flipped, moved, quad, room};
use raycell::scene::{Geometry, Material};
use raycell::{Direct, Params, Status, SurfacePoint};

/// 0 grey, 1 the lamp, 2 darker.
fn paints() -> Vec<Material> {
    vec![grey(0.6, 0.0), grey(0.3, 1.0), grey(0.4, 0.0)]
}

fn lamp(low: [f64; 2], high: [f64; 2], z: f64) -> Triangles {
    quad([[low[0], low[1], z], [low[0], high[1], z], [high[0], high[1], z], [high[0], low[1], z]], 1)
}

/// A grid of points on the plane where coordinate `axis` is `at`, asked for from the side of `sign`.
fn plane(axis: usize, at: f64, sign: f64, u: &[f64], v: &[f64]) -> Vec<SurfacePoint> {
    let mut points = Vec::new();
    for (&u, &v) in u.iter().flat_map(|u| v.iter().map(move |v| (u, v))) {
        let (mut p, mut n) = ([0.0; 3], [0.0; 3]);
        (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (at, u, v);
        n[axis] = sign;
        points.push(SurfacePoint { p, n });
    }
    points
}

fn medium(direct: Direct) -> Params {
    Params { direct_samples: 1024, gather_rays: 256, ..params(16_384, direct) }
}

/// So many rays that one which finds its way out of a slot brings less than a thousandth.
fn careful(direct: Direct) -> Params {
    Params { gather_rays: 4096, ..medium(direct) }
}

fn most(answers: &[raycell::Answer]) -> f64 {
    answers.iter().flat_map(|a| a.b).fold(0.0, f64::max)
}

/// What lies on a surface is left behind by rays that start there, however the plane that both lie in is turned: whether they
/// meet it would be chance, and the covered floor alive and lit.
#[test]
fn a_box_covers_the_floor_that_it_stands_on() {
    let Some(gpu) = gpu() else { return };
    let floor = quad([[-1.0, 0.0, -1.0], [-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0]], 0);
    let upright = [floor, block([-0.4, 0.0, -0.3], [0.3, 0.5, 0.2], 0)].concat();
    for turn in [|p| p, rotated] {
        let g = Geometry::new(&scene(&moved(upright.clone(), turn), vec![grey(0.5, 1.0)])).unwrap();
        let up = DVec3::from(turn([0.0, 1.0, 0.0])) - DVec3::from(turn([0.0; 3]));
        // Under the box on the floor, then on the box's bottom.
        let mut dice = Dice(3);
        let mut points: Vec<Point> = Vec::new();
        for side in [1.0, -1.0] {
            for _ in 0..40 {
                let at = turn([-0.39 + 0.68 * dice.unit(), 0.0, -0.29 + 0.48 * dice.unit()]);
                let on = g.locate(at, (up * side).to_array()).unwrap();
                points.push(Point { p: on.p, tri: on.tri, ..Point::default() });
            }
        }
        let kinds = |ends: Vec<Point>| -> Vec<u32> { ends.iter().map(|e| e.kind).collect() };
        let mut twin = raycell::twin::TwinEngine::new(&g);
        let mut device = GpuEngine::new(&gpu, &g).unwrap();
        let (a, b) = (twin.upload(&points).unwrap(), device.upload(&points).unwrap());
        let (a, b) = (twin.shoot(&a, 5, 0, 64).unwrap(), device.shoot(&b, 5, 0, 64).unwrap());
        for kinds in [kinds(twin.points(&a).unwrap()), kinds(device.points(&b).unwrap())] {
            let (above, below) = kinds.split_at(40 * 64);
            assert_eq!(above.iter().filter(|k| **k != kind::BACK).count(), 0, "the box is seen from where it stands");
            assert_eq!(below.iter().filter(|k| **k != kind::SKY).count(), 0, "the floor is seen from what stands on it");
        }
    }
}

#[test]
fn a_cupboard_against_a_wall_is_dark_inside() {
    let Some(gpu) = gpu() else { return };
    // Its boards are 2 cm thick, its back is the room's wall, which runs through.
    let room = room([0.0; 3], [1.0; 3], [0; 6]);
    let outer: Triangles = block([0.0, 0.3, 0.2], [0.3, 0.7, 0.6], 0)[2..].to_vec();
    let inner: Triangles = raycell::scene::shapes::room([0.0, 0.32, 0.22], [0.28, 0.68, 0.58], [0; 6])[2..].to_vec();
    let t = [room, outer, inner.clone(), lamp([0.5, 0.3], [0.9, 0.7], 0.98)].concat();
    for direct in [Direct::Exact, Direct::Network] {
        let solution = solve(&gpu, &scene(&t, paints()), &medium(direct));
        let places = [0.3201, 0.35, 0.4, 0.5, 0.6, 0.6799];
        let back = plane(0, 0.0, 1.0, &places, &[0.2201, 0.25, 0.4, 0.5, 0.5799]);
        let dark = ask(&gpu, &solution, &[back, scattered(&inner, 20, 1)].concat(), 0.05);
        assert!(dark.iter().all(|a| a.status != Status::OffSurface));
        assert!(dark.iter().all(|a| a.b == [0.0; 3] && a.h == [0.0; 3]), "{direct:?}: {:e}", most(&dark));
        // Beside it the wall is lit.
        let lit = ask(&gpu, &solution, &plane(0, 0.0, 1.0, &[0.1, 0.28, 0.72, 0.9], &[0.3, 0.5]), 0.05);
        assert!(lit.iter().all(|a| a.b[0] > 0.005), "{lit:?}");
    }
}

/// On the lit side of a partition that stands on a slab which runs through below it, the foot is as bright as that of the same
/// room's own wall.
#[test]
fn the_lit_foot_of_a_partition_has_no_dark_halo() {
    let Some(gpu) = gpu() else { return };
    let own = room([0.0; 3], [1.0; 3], [2, 2, 2, 2, 0, 0]);
    let light = lamp([0.4, 0.3], [0.8, 0.7], 0.98);
    let alone = [own.clone(), light.clone()].concat();
    let along = [0.1, 0.2, 0.3, 0.4, 0.45, 0.55, 0.6, 0.7, 0.8, 0.9];
    let off = [1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1];
    let params = |seed| Params { seed, ..params(65_536, Direct::Exact) };
    let read = |t: &Triangles, seed| {
        let solution = solve(&gpu, &scene(t, paints()), &params(seed));
        let stated = solution.report().estimated_error.clone().unwrap().high;
        let at = |points: Vec<SurfacePoint>| mean(&ask(&gpu, &solution, &points, 0.05));
        // On the floor, and on the wall above it.
        let foot = off.map(|d| [at(plane(2, 0.0, 1.0, &[1.0 - d], &along)), at(plane(0, 1.0, -1.0, &along, &[d]))]);
        (foot, stated)
    };
    let (want, stated) = read(&alone, 1);
    for thickness in [0.1, 1e-3] {
        let right = 1.0 + thickness;
        // Floor and ceiling are slabs of both rooms, the partition has two faces.
        let ends = [own[..2].to_vec(), moved(own[2..4].to_vec(), |p| [p[0] + right, p[1], p[2]])].concat();
        let partition = [own[2..4].to_vec(), moved(own[..2].to_vec(), |p| [p[0] + right, p[1], p[2]])].concat();
        let through = |t: &[([[f64; 3]; 3], u32)]| moved(t.to_vec(), |p| [p[0] * (1.0 + right), p[1], p[2]]);
        let t = [ends, partition, through(&own[4..]), light.clone()].concat();
        let (got, _) = read(&t, 1);
        for (k, (got, want)) in got.iter().zip(&want).enumerate() {
            let error = [0, 1].map(|i| got[i] / want[i] - 1.0);
            eprintln!(
                "{thickness}: {} from the corner, floor {:+.3}, wall {:+.3}; stated {stated:.3}",
                off[k], error[0], error[1]
            );
            // Both bakes have the stated error, and the mean of ten points less of it.
            assert!(error.iter().all(|e| e.abs() < 2.0 * stated), "{thickness}, {}: {error:?}", off[k]);
        }
    }
}

/// Behind a board 2 mm off a wall it is dark: at 0.3 m from its edges 1e-3 of the light and less. The board may be a box or a
/// sheet.
#[test]
fn a_shelf_two_millimetres_off_a_wall_keeps_its_slot_dark() {
    let Some(gpu) = gpu() else { return };
    let walls = room([0.0; 3], [2.0; 3], [0; 6]);
    let thick = block([0.002, 0.2, 0.2], [0.032, 1.8, 1.8], 2);
    let corners = [[0.002, 0.2, 0.2], [0.002, 1.8, 0.2], [0.002, 1.8, 1.8], [0.002, 0.2, 1.8]];
    let thin = [quad(corners, 2), flipped(quad(corners, 2))].concat();
    for (name, board, front) in [("box", thick, 0.032), ("sheet", thin, 0.002)] {
        let t = [walls.clone(), board, lamp([1.0, 0.7], [1.6, 1.3], 1.98)].concat();
        for direct in [Direct::Exact, Direct::Network] {
            let solution = solve(&gpu, &scene(&t, paints()), &careful(direct));
            let spacing = solution.geometry().spacing(solution.nodes().len()) / solution.geometry().scale;
            let inner: Vec<f64> = (0..8).map(|i| 0.2 + spacing + (1.6 - 2.0 * spacing) * (f64::from(i) + 0.5) / 8.0).collect();
            let slot = [plane(0, 0.0, 1.0, &inner, &inner), plane(0, 0.002, -1.0, &inner, &inner)].concat();
            let dark = most(&ask(&gpu, &solution, &slot, 0.05));
            let lit = ask(&gpu, &solution, &plane(0, front, 1.0, &inner, &inner), 0.05);
            let around = ask(&gpu, &solution, &plane(0, 0.0, 1.0, &[0.05, 0.1, 0.15, 1.85, 1.9, 1.95], &inner), 0.05);
            let (board, wall) = (mean(&lit), mean(&around));
            eprintln!("{name}, {direct:?}: spacing {spacing:.2} m, slot {dark:.1e}, board {board:.4}, wall beside it {wall:.4}");
            assert!(spacing < 0.6 && dark <= 1e-3 * board, "{name}, {direct:?}: {dark:e} of {board}");
            // Nor does the slot darken what is beside it.
            assert!(wall > 0.5 * board && lit.iter().all(|a| a.b[0] > 0.5 * board), "{name}, {direct:?}: {wall} {board}");
        }
    }
}

/// Two sheets of one material that face the same way: the lower one is in the shadow of the upper one's back.
#[test]
fn a_sheet_below_a_sheet_is_in_its_shadow() {
    let Some(gpu) = gpu() else { return };
    let walls = room([0.0; 3], [2.0; 3], [2; 6]);
    let sheet = |z: f64| quad([[0.2, 0.2, z], [1.8, 0.2, z], [1.8, 1.8, z], [0.2, 1.8, z]], 0);
    for gap in [2e-2, 2e-3, 2e-4] {
        let t = [walls.clone(), sheet(0.5), sheet(0.5 + gap), lamp([0.7, 0.7], [1.3, 1.3], 1.98)].concat();
        for direct in [Direct::Exact, Direct::Network] {
            let solution = solve(&gpu, &scene(&t, paints()), &careful(direct));
            let spacing = solution.geometry().spacing(solution.nodes().len()) / solution.geometry().scale;
            let inner: Vec<f64> = (0..8).map(|i| 0.2 + spacing + (1.6 - 2.0 * spacing) * (f64::from(i) + 0.5) / 8.0).collect();
            let [low, high] = [0.5, 0.5 + gap].map(|z| ask(&gpu, &solution, &plane(2, z, 1.0, &inner, &inner), 0.05));
            let (dark, lit) = (most(&low), mean(&high));
            let least = high.iter().map(|a| a.b[0]).fold(f64::MAX, f64::min);
            eprintln!("gap {gap}, {direct:?}: lower {dark:.1e}, upper {lit:.4}, at least {least:.4}");
            assert!(dark <= 1e-3 * lit, "gap {gap}, {direct:?}: {dark:e} of {lit}");
            assert!(least > 0.5 * lit, "gap {gap}, {direct:?}: {least} of {lit}");
        }
    }
}
