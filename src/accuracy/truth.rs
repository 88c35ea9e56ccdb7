//! A truth: radiosity at surface points with its standard error, and the CSV file it is kept in.
//!
//! Columns `px,py,pz,nx,ny,nz` (metres), `B_r,B_g,B_b` (W/m²), `stderr_r,stderr_g,stderr_b` and `flag`: 0 good, 1 noisy
//! beside its own radiosity, 2 covered (no light can reach it); and `weight`, what of the surface a point stands for, where
//! that is not the same for all.

use crate::error::{Error, Result};
use crate::output::atomic;
use crate::output::points::{self, number};
use crate::solution::SurfacePoint;
use std::path::Path;

const HEADER: &str = "px,py,pz,nx,ny,nz,B_r,B_g,B_b,stderr_r,stderr_g,stderr_b,flag";
/// Standard error of the band mean, as a share of it, beyond which a point is noisy: its own relative error says little.
const NOISY: f64 = 0.05;

/// How far a point of a truth can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flag {
    /// Known well.
    Good,
    /// Its standard error is not small beside its radiosity.
    Noisy,
    /// No light can reach it.
    Covered,
}

/// Radiosity at surface points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// Where.
    pub points: Vec<SurfacePoint>,
    /// Radiosity, W/m² a band.
    pub b: Vec<[f64; 3]>,
    /// Its standard error; 0 where it is exact.
    pub stderr: Vec<[f64; 3]>,
    /// How far each is trusted.
    pub flags: Vec<Flag>,
    /// What of the surface each stands for, 1 on average; none where that is the same for all.
    pub weights: Vec<f64>,
}

/// The flag of a point that light can reach.
pub(super) fn flag_of(b: [f64; 3], stderr: [f64; 3]) -> Flag {
    if stderr.iter().sum::<f64>() > NOISY * b.iter().sum::<f64>() { Flag::Noisy } else { Flag::Good }
}

impl Truth {
    /// Reads a truth. Where it has no `stderr` its numbers are taken for exact, where it has no `flag` for good.
    ///
    /// Errors: [`Error::Read`]; [`Error::Format`] with the line where a column is missing or a cell is no number.
    pub fn read(path: &Path) -> Result<Truth> {
        let bytes = std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?;
        let points = points::parse(path, &bytes)?;
        let fail = |line: Option<u64>, what: String| Error::Format {
            path: path.into(),
            line: line.map(|l| l as usize),
            what,
            cure: format!("a truth has the columns {HEADER}"),
        };
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes.as_slice());
        let header = reader.headers().map_err(|e| fail(Some(1), e.to_string()))?.clone();
        let column = |name: &str| header.iter().position(|h| h == name);
        let triple = |names: [&str; 3]| match names.map(column) {
            [Some(r), Some(g), Some(b)] => Some([r, g, b]),
            _ => None,
        };
        let light =
            triple(["B_r", "B_g", "B_b"]).ok_or_else(|| fail(Some(1), "a column of B_r, B_g and B_b is missing".into()))?;
        let scatter = triple(["stderr_r", "stderr_g", "stderr_b"]);
        let (flag, weight) = (column("flag"), column("weight"));
        let mut truth = Truth { points, ..Truth::default() };
        for record in reader.records() {
            let record = record.map_err(|e| fail(None, e.to_string()))?;
            let line = record.position().map(|p| p.line());
            let number = |k: usize| -> Result<f64> {
                let cell = &record[k];
                let number = cell.parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
                number.ok_or_else(|| fail(line, format!("'{cell}' in column '{}' is no number >= 0", &header[k])))
            };
            let read = |[r, g, b]: [usize; 3]| -> Result<[f64; 3]> { Ok([number(r)?, number(g)?, number(b)?]) };
            truth.b.push(read(light)?);
            truth.stderr.push(scatter.map_or(Ok([0.0; 3]), read)?);
            truth.weights.extend(weight.map(number).transpose()?);
            truth.flags.push(match flag.map(|k| &record[k]) {
                None | Some("0") => Flag::Good,
                Some("1") => Flag::Noisy,
                Some("2") => Flag::Covered,
                Some(other) => return Err(fail(line, format!("flag '{other}' is not 0, 1 or 2"))),
            });
        }
        if truth.points.is_empty() {
            return Err(fail(None, "there is no point in it".into()));
        }
        if weight.is_some() && truth.weights.iter().sum::<f64>() <= 0.0 {
            return Err(fail(None, "no point in it has a weight".into()));
        }
        Ok(truth)
    }

    /// Writes it, so that [`Truth::read`] reads the same. Errors: [`Error::Write`].
    pub fn write(&self, path: &Path) -> Result<()> {
        let weighted = !self.weights.is_empty();
        let mut text = format!("{HEADER}{}\n", if weighted { ",weight" } else { "" });
        for (i, point) in self.points.iter().enumerate() {
            for x in point.p.iter().chain(&point.n).chain(&self.b[i]).chain(&self.stderr[i]) {
                text += &number(*x);
                text.push(',');
            }
            text.push(match self.flags[i] {
                Flag::Good => '0',
                Flag::Noisy => '1',
                Flag::Covered => '2',
            });
            if weighted {
                text.push(',');
                text += &number(self.weights[i]);
            }
            text.push('\n');
        }
        atomic::write(path, text.as_bytes())
    }

    /// What of the surface a point stands for, 1 where that is the same for all.
    pub fn weight(&self, point: usize) -> f64 {
        self.weights.get(point).copied().unwrap_or(1.0)
    }

    /// A mean over the surface and the bands of what `of` says of a point.
    pub(super) fn over(&self, of: impl Fn(usize) -> [f64; 3]) -> f64 {
        let (mut sum, mut all) = (0.0, 0.0);
        for i in 0..self.b.len() {
            sum += self.weight(i) * of(i).iter().sum::<f64>();
            all += 3.0 * self.weight(i);
        }
        if all > 0.0 { sum / all } else { 0.0 }
    }

    /// Mean radiosity over the surface and the bands, W/m².
    pub fn mean(&self) -> f64 {
        self.over(|i| self.b[i])
    }

    /// Its own noise: sqrt(mean stderr²) over the surface and the bands, over the mean. A part of any error measured by it.
    pub fn noise(&self) -> f64 {
        self.over(|i| self.stderr[i].map(|s| s * s)).sqrt() / self.mean()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_reads_what_it_wrote() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("truth.csv");
        let at = |x: f64| SurfacePoint { p: [x, 0.1, -3.0], n: [0.0, 1.0, 0.0] };
        let truth = Truth {
            points: vec![at(1.0), at(1.0 / 3.0), at(2.0)],
            b: vec![[1.0, 2.0, 3.0], [0.1, 0.2, 0.7], [0.0; 3]],
            stderr: vec![[1e-3, 2e-3, 1e-4], [0.1, 0.02, 0.03], [0.0; 3]],
            flags: vec![Flag::Good, Flag::Noisy, Flag::Covered],
            weights: Vec::new(),
        };
        let weighted = Truth { weights: vec![0.5, 2.0, 0.5], ..truth.clone() };
        for truth in [&weighted, &truth] {
            truth.write(&path).unwrap();
            assert_eq!(Truth::read(&path).unwrap(), *truth);
        }
        assert!((truth.mean() - 7.0 / 9.0).abs() < 1e-12);
        assert!((weighted.mean() - (0.5 * 6.0 + 2.0) / 9.0).abs() < 1e-12);
        std::fs::write(&path, "B_b,B_g,B_r,px,py,pz,nx,ny,nz\n3,2,1,0,0,0,0,1,0\n").unwrap();
        let bare = Truth::read(&path).unwrap();
        assert_eq!((bare.b[0], bare.stderr[0], bare.flags[0]), ([1.0, 2.0, 3.0], [0.0; 3], Flag::Good));
        for (text, part) in [
            ("px,py,pz,nx,ny,nz,B_r,B_g\n", "B_r, B_g and B_b is missing"),
            ("px,py,pz,nx,ny,nz,B_r,B_g,B_b\n0,0,0,0,1,0,1,x,1\n", "truth.csv:2: 'x' in column 'B_g'"),
            ("px,py,pz,nx,ny,nz,B_r,B_g,B_b,flag\n0,0,0,0,1,0,1,1,1,7\n", "truth.csv:2: flag '7'"),
            ("px,py,pz,nx,ny,nz,B_r,B_g,B_b\n", "there is no point"),
            ("px,py,pz,nx,ny,nz,B_r,B_g,B_b,weight\n0,0,0,0,1,0,1,1,1,0\n", "no point in it has a weight"),
        ] {
            std::fs::write(&path, text).unwrap();
            let said = Truth::read(&path).unwrap_err().to_string();
            assert!(said.contains(part), "{part:?} in {said:?}");
        }
    }
}
