//! The converged answer that both are held against: the peer's own, by many more samples, kept from run to run.

use crate::Outcome;
use crate::worker::Worker;
use raycell::SurfacePoint;
use std::path::Path;

/// Samples a point of a batch; the scatter of batches tells the noise.
const BATCH: u32 = 256;
/// Where the batches' seeds begin, far from those that are timed.
const SEEDS: u32 = 10_000;

/// Sums over batches of radiosity, and of its square, a point and band.
pub struct Reference {
    batches: u32,
    sums: Vec<[f64; 6]>,
}

impl Reference {
    /// The kept reference of a scene at these points, brought to `samples` a point where it has fewer.
    pub fn get(
        out: &Path,
        scene: &Path,
        points: &[SurfacePoint],
        samples: u32,
        mut peer: Option<&mut Worker>,
    ) -> Outcome<Reference> {
        // A file is of one scene and one list of points.
        let mut key = crc32fast::Hasher::new();
        for path in [scene.to_path_buf(), scene.with_extension("mtl")] {
            key.update(&std::fs::read(path).unwrap_or_default());
        }
        let numbers: Vec<f64> = points.iter().flat_map(|p| [p.p, p.n]).flatten().collect();
        key.update(bytemuck::cast_slice(&numbers));
        let path = out.join(format!("reference-{:08x}.bin", key.finalize()));
        let mut own = Reference { batches: 0, sums: vec![[0.0; 6]; points.len()] };
        if let Ok(bytes) = std::fs::read(&path)
            && bytes.len() == 8 + 48 * points.len()
        {
            let numbers: Vec<f64> = bytemuck::pod_collect_to_vec(&bytes);
            own.batches = numbers[0] as u32;
            own.sums = numbers[1..].as_chunks::<6>().0.to_vec();
        }
        while own.batches * BATCH < samples {
            let Some(peer) = peer.as_mut() else {
                let why =
                    "there is no reference at these points yet, and no peer to make it: install Mitsuba 3, or give --python";
                return if own.batches > 1 { Ok(own) } else { Err(why.into()) };
            };
            let (_, b) = peer.bake(BATCH, SEEDS + own.batches)?;
            for (sum, b) in own.sums.iter_mut().zip(b) {
                for k in 0..3 {
                    sum[k] += b[k];
                    sum[3 + k] += b[k] * b[k];
                }
            }
            own.batches += 1;
            let mut numbers = vec![own.batches as f64];
            numbers.extend(own.sums.as_flattened());
            let part = path.with_extension("part");
            std::fs::write(&part, bytemuck::cast_slice::<f64, u8>(&numbers))?;
            std::fs::rename(&part, &path)?;
            eprint!("\rreference: {} of {samples} samples a point", own.batches * BATCH);
        }
        eprintln!();
        Ok(own)
    }

    pub fn samples(&self) -> u32 {
        self.batches * BATCH
    }

    /// Radiosity at point i.
    pub fn b(&self, i: usize) -> [f64; 3] {
        [0, 1, 2].map(|k| self.sums[i][k] / self.batches as f64)
    }

    /// Mean radiosity over points and bands.
    pub fn level(&self) -> f64 {
        (0..self.sums.len()).map(|i| self.b(i).iter().sum::<f64>()).sum::<f64>() / (3 * self.sums.len()) as f64
    }

    /// Mean variance of the reference itself over points and bands.
    pub fn variance(&self) -> f64 {
        let n = self.batches as f64;
        let own = |s: &[f64; 6], k: usize| (s[3 + k] - s[k] * s[k] / n).max(0.0) / (n * (n - 1.0));
        self.sums.iter().map(|s| own(s, 0) + own(s, 1) + own(s, 2)).sum::<f64>() / (3 * self.sums.len()) as f64
    }

    /// Its own RRMSE.
    pub fn noise(&self) -> f64 {
        self.variance().sqrt() / self.level()
    }
}
