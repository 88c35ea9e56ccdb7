//! Whole bakes: cases E, and bakes beside each other.

use super::Spoil;
use super::scenes::{SQUARE, cube, flat, grey, solid};
use super::trial::{Trial, spread};
use crate::accuracy::norms::rrmse;
use crate::engine::Backend;
use crate::error::Result;
use crate::params::{Direct, Norm, Params};
use crate::scene::Scene;
use crate::scene::shapes::{block, flipped, room, sphere};
use crate::solution::Answer;

/// Rays of a bake here: what is asked holds at any number.
const RAYS: u32 = 16_384;
/// A block within the unit cube.
const LOW: [f64; 3] = [0.2, 0.3, 0.1];
const HIGH: [f64; 3] = [0.5, 0.6, 0.4];

fn few() -> Params {
    Params { rays: RAYS, ..Params::default() }
}

fn b(answers: &[Answer]) -> Vec<f64> {
    answers.iter().map(|a| a.b[0]).collect()
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

pub fn furnace(t: &mut Trial) -> Result<()> {
    for rho in [0.5, 0.9, 0.99] {
        let scene = solid(&room([0.0; 3], [1.0; 3], [0; 6]), &[grey(rho, 1.0)])?;
        // f32 rounds the reflectance, and the truth with it.
        let truth = 1.0 / (1.0 - f64::from(rho as f32));
        for direct in [Direct::Network, Direct::Exact] {
            let got = b(&t.light(&scene, &Params { direct, ..few() }, |_| true, 256)?);
            let what = format!("b in a furnace of {rho}, {} direct light", if direct == Direct::Exact { "exact" } else { "no" });
            if direct == Direct::Network {
                t.all_near(format!("{what}, the worst point"), truth, &got, 5e-3 * truth); // final gathers of 1,024 rays
            } else {
                t.near(format!("{what}, the mean"), truth, mean(&got), 1e-2 * truth); // direct light is sampled
            }
        }
    }
    Ok(())
}

pub fn kirchhoff(t: &mut Trial) -> Result<()> {
    // Every side and a block within shine as much as they absorb.
    let rhos = [0.05, 0.3, 0.5, 0.8, 0.95, 0.7, 0.4];
    let materials = rhos.map(|rho| grey(rho, 1.0 - rho));
    let scene = solid(&[cube(), block(LOW, HIGH, 6)].concat(), &materials)?;
    let got = b(&t.light(&scene, &Params { direct: Direct::Network, ..few() }, |_| true, 512)?);
    // Scatter of 1,024 gathered rays, times 1/(1 - rho) of the whitest side; the mean is told closer.
    t.all_near("b where all shine as they absorb, the worst point", 1.0, &got, 3e-2);
    t.near("b where all shine as they absorb, the mean", 1.0, mean(&got), 3e-3);
    Ok(())
}

pub fn halves(t: &mut Trial) -> Result<()> {
    // Halves by a skew plane, which parts no triangle's centre; the ball is its own mirror image, so they are halves.
    let side = |corners: &[[f64; 3]; 3]| {
        let middle: glam::DVec3 = corners.iter().map(|&c| glam::DVec3::from(c)).sum();
        u32::from(middle.dot(glam::DVec3::new(0.3, 0.5, 0.81)) > 0.0)
    };
    let ball = flipped(sphere(3, 0)).into_iter().map(|(corners, _)| (corners, side(&corners))).collect();
    let scene = solid(&ball, &[grey(0.2, 1.0), grey(0.8, 1.0)])?;
    let params = Params { rays: 32_768, direct: Direct::Network, ..Params::default() };
    let solution = t.bake(&scene, &params)?;
    for (half, rho, truth) in [(0, 0.2, 1.4), (1, 0.8, 2.6)] {
        let points = spread(&scene, |face| ball[face as usize].1 == half, 512)?;
        let got = b(&solution.query(t.backend, &points)?);
        t.near(format!("b on a sphere's half of {rho}, the mean"), truth, mean(&got), 5e-3 * truth);
    }
    Ok(())
}

/// A closed room of one reflectance, lit by its ceiling, with a block that floats in it.
fn lit_room(rho: f64) -> Result<Scene> {
    let walls = room([0.0; 3], [1.0; 3], [0, 0, 0, 0, 0, 1]);
    solid(&[walls, block(LOW, HIGH, 0)].concat(), &[grey(rho, 0.0), grey(rho, 1.0)])
}

pub fn energy(t: &mut Trial) -> Result<()> {
    let scene = lit_room(0.7)?;
    let solution = t.bake(&scene, &Params { rays: 32_768, ..Params::default() })?;
    let imbalance = solution.report().energy.imbalance.unwrap_or(f64::NAN);
    t.near("light that is lost or made", 0.0, imbalance, 0.01); // a network's share of reflected light, at few rays
    // All that shines is absorbed in the end: the mean of b is that of e, times 1/(1 - rho).
    let truth = 1.0 / 0.3 / (6.0 + 6.0 * 0.3 * 0.3);
    let answers = solution.query(t.backend, &spread(&scene, |_| true, 512)?)?;
    t.near("b in a closed room of 0.7, the mean", truth, mean(&b(&answers)), 5e-3 * truth); // 32,768 rays
    Ok(())
}

pub fn lit_square(t: &mut Trial) -> Result<()> {
    for (rho, bottom, top) in [(0.5, 1.1486301912981856, 0.31217615465799264), (0.9, 3.0922999014660637, 2.3416482873791233)] {
        let scene = flat(&SQUARE, &[grey(rho, 1.0), grey(rho, 0.0), grey(rho, 0.0), grey(rho, 0.0)])?;
        let norm = if t.spoil == Spoil::Norm { Norm::Paper1997 } else { Norm::Lambert };
        let solution = t.bake(&scene, &Params { rays: 131_072, norm, ..Params::default() })?;
        for (what, side, truth) in [("bottom", 0, bottom), ("top", 2, top)] {
            let got = b(&solution.query(t.backend, &spread(&scene, |face| face == side, 128)?)?);
            t.near(format!("b of a flatland square of {rho}, {what}, the mean"), truth, mean(&got), 3e-3 * truth);
        }
    }
    Ok(())
}

pub fn norm(t: &mut Trial) -> Result<()> {
    for (rho, norm) in [(0.5, Norm::Lambert), (0.9, Norm::Lambert), (0.5, Norm::Paper1997), (0.9, Norm::Paper1997)] {
        let scene = flat(&SQUARE, &[grey(rho, 1.0)])?;
        let other = if norm == Norm::Lambert { Norm::Paper1997 } else { Norm::Lambert };
        let used = if t.spoil == Spoil::Norm { other } else { norm };
        let params = Params { norm: used, direct: Direct::Network, ..few() };
        let got = b(&t.light(&scene, &params, |_| true, 64)?);
        let truth = 1.0 / (1.0 - rho * norm.share());
        let name = if norm == Norm::Lambert { "1/(2 r)" } else { "1/(2 pi r)" };
        t.all_near(format!("b in a flatland furnace of {rho}, {name}, the worst point"), truth, &got, 3e-3 * truth); // 16,384 rays
    }
    Ok(())
}

pub fn same_bytes(t: &mut Trial) -> Result<()> {
    let scene = lit_room(0.7)?;
    let points = spread(&scene, |_| true, 256)?;
    let mut once: Option<Vec<u8>> = None;
    for _ in 0..2 {
        let solution = t.bake(&scene, &few())?;
        let mut bytes = bytemuck::cast_slice::<_, u8>(solution.light()).to_vec();
        bytes.extend_from_slice(bytemuck::cast_slice(solution.cells()));
        for answer in solution.query(t.backend, &points)? {
            bytes.extend(answer.b.iter().chain(&answer.h).chain(&answer.d).flat_map(|x| x.to_le_bytes()));
        }
        match &once {
            None => once = Some(bytes),
            Some(first) => {
                let longer = first.len().abs_diff(bytes.len());
                let differ = first.iter().zip(&bytes).filter(|(a, b)| a != b).count();
                t.near("bytes that differ between two bakes of one seed", 0.0, (longer + differ) as f64, 0.0);
            }
        }
    }
    Ok(())
}

/// Both machines draw the same rays. A rounding apart, a ray may meet another triangle or win another cell: where they
/// differ, the other is a second draw of the same estimator. So they differ by no more than seeds do.
pub fn twin(t: &mut Trial) -> Result<()> {
    let scene = lit_room(0.7)?;
    let points = spread(&scene, |_| true, 256)?;
    let mut answers = |cpu: bool, seed: u32| -> Result<Vec<[f64; 3]>> {
        let backend = if cpu { &Backend::Cpu } else { t.backend };
        let solution = t.bake_on(backend, &scene, &Params { rays: 8192, seed, ..Params::default() })?;
        Ok(solution.query(backend, &points)?.iter().map(|a| a.b).collect())
    };
    let seeds = [answers(false, 1)?, answers(false, 2)?, answers(false, 3)?];
    let twin = answers(true, 1)?;
    let apart = |i: usize, j: usize| rrmse(&seeds[i], &seeds[j]).powi(2);
    let scatter = ((apart(0, 1) + apart(1, 2) + apart(2, 0)) / 3.0).sqrt();
    t.near("a bake's distance from plain Rust's, tolerance: that of seeds", 0.0, rrmse(&seeds[0], &twin), 1.25 * scatter);
    Ok(())
}
