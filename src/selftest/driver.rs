//! What all passes rely on: loops, dispatches, casts, integer sums, and numbers that are none.

use super::scenes::{cube, grey, solid};
use super::trial::{Trial, on_engine};
use crate::engine::{Backend, Engine};
use crate::error::Result;
use crate::gpu::sentinel::{self, Counts, LOOP_BUDGET};
use crate::layout::{Point, kind};
use crate::scene::Geometry;
use crate::twin::winner::{Feature, Metric};

/// Runs the sentinel, and compares all that it counts.
fn counted(t: &mut Trial, items: u32, trips: u32, what: &str) -> Result<()> {
    let Backend::Gpu(gpu) = t.backend else { return Ok(()) };
    let (got, want) = (sentinel::count(gpu, items, trips, u32::MAX)?, Counts::expected(items, trips));
    t.near(format!("invocations {what}"), f64::from(want.items), f64::from(got.items), 0.0);
    t.near("the sum of their numbers, modulo 2^32", f64::from(want.index_sum), f64::from(got.index_sum), 0.0);
    t.near("their loop trips, modulo 2^32", f64::from(want.trips), f64::from(got.trips), 0.0);
    // 64 bits are more than a float tells apart.
    t.near("their sum with carry, off by", 0.0, got.sum.abs_diff(want.sum) as f64, 0.0);
    Ok(())
}

pub fn loops(t: &mut Trial) -> Result<()> {
    counted(t, 1000, LOOP_BUDGET, "with loops of 30,000 trips")
}

pub fn dispatches(t: &mut Trial) -> Result<()> {
    // The catalogue's number: beyond 65,535 workgroups of 256, so far beyond as many of 64.
    counted(t, 65_535 * 256 + 1, 1, "beyond 65,535 workgroups")
}

/// A point of the floor that rays are said to have met.
fn hit(x: f32) -> Point {
    Point { p: [x, 0.0, 0.0], kind: kind::FRONT, weight: 1.0, ..Point::default() }
}

pub fn not_numbers(t: &mut Trial) -> Result<()> {
    // A pass must hand on what is no number, so that the host sees it: every third is.
    const COUNT: usize = 3 * 1000;
    let geometry = Geometry::new(&solid(&cube(), &[0; 6].map(|_| grey(0.5, 1.0)))?)?;
    let light: Vec<[f32; 4]> = (0..COUNT).map(|i| [[1.0, f32::NAN, f32::INFINITY][i % 3], 1.0, 1.0, 0.0]).collect();
    let gathered = on_engine!(t.backend, &geometry, engine => {
        let mut hits = engine.upload(&vec![hit(0.0); COUNT])?;
        engine.set_irradiance(&mut hits, &light)?;
        engine.gather(&hits, 1, true, false)?
    });
    let count = |is: fn(f32) -> bool| gathered.iter().filter(|g| is(g.irradiance[0])).count() as f64;
    t.near("NaN that are seen", COUNT as f64 / 3.0, count(f32::is_nan), 0.0);
    t.near("infinities that are seen", COUNT as f64 / 3.0, count(f32::is_infinite), 0.0);
    t.near("numbers that stay numbers", COUNT as f64 / 3.0, count(|x| x == 0.5), 0.0);
    Ok(())
}

pub fn sums(t: &mut Trial) -> Result<()> {
    // Floats that are added one by one lose 4 % of this sum.
    const TERMS: usize = 1 << 20;
    const TENTH: f32 = 0.1;
    let geometry = Geometry::new(&solid(&cube(), &[0; 6].map(|_| grey(0.5, 1.0)))?)?;
    let metric = Metric { inv_unit: 1.0, lambda: 0.0, mu: 0.0 };
    let brightness = vec![0.0; geometry.tiles as usize];
    let cell: Feature = [0.0; 16];
    let sums = on_engine!(t.backend, &geometry, engine => {
        let mut rays = engine.upload(&vec![hit(TENTH); TERMS])?;
        engine.feature(&mut rays, metric, &brightness)?;
        engine.set_winners(&mut rays, &vec![0; TERMS])?;
        engine.accumulate(&rays, 0..TERMS, &[cell])?
    });
    let unit = crate::twin::fixed::FEATURE_UNIT;
    t.near("the sum of 2^20 times 0.1f", TERMS as f64 * f64::from(TENTH), sums[0].feature[0].value(unit), 0.0);
    t.near("how many there were", TERMS as f64, f64::from(sums[0].count.lo), 0.0);
    Ok(())
}
