//! The converged answer that both are held against: a file's, or the peer's own, by many more samples, kept from run
//! to run.

use crate::Outcome;
use crate::worker::Worker;
use raycell::SurfacePoint;
use raycell::accuracy::truth::{Flag, Truth};
use std::path::Path;

/// Samples a point of a batch; the scatter of batches tells the noise.
const BATCH: u32 = 256;
/// Where the batches' seeds begin, far from those that are timed.
const SEEDS: u32 = 10_000;

/// The kept reference of a scene at these points, brought to `samples` a point where it has fewer.
pub fn get(out: &Path, scene: &Path, points: &[SurfacePoint], samples: u32, mut peer: Option<&mut Worker>) -> Outcome<Truth> {
    // A file is of one scene and one list of points.
    let mut key = crc32fast::Hasher::new();
    for path in [scene.to_path_buf(), scene.with_extension("mtl")] {
        key.update(&std::fs::read(path).unwrap_or_default());
    }
    let numbers: Vec<f64> = points.iter().flat_map(|p| [p.p, p.n]).flatten().collect();
    key.update(bytemuck::cast_slice(&numbers));
    let path = out.join(format!("reference-{:08x}.bin", key.finalize()));

    // Sums over batches of radiosity, and of its square, a point and band.
    let (mut batches, mut sums) = (0, vec![[0.0f64; 6]; points.len()]);
    if let Ok(bytes) = std::fs::read(&path)
        && bytes.len() == 8 + 48 * points.len()
    {
        let numbers: Vec<f64> = bytemuck::pod_collect_to_vec(&bytes);
        batches = numbers[0] as u32;
        sums = numbers[1..].as_chunks::<6>().0.to_vec();
    }
    while batches * BATCH < samples {
        let Some(peer) = peer.as_mut() else {
            if batches > 1 {
                break;
            }
            return Err("no reference at these points yet, and no peer to make it: install Mitsuba 3, or give --python".into());
        };
        let (_, b) = peer.bake(BATCH, SEEDS + batches)?;
        for (sum, b) in sums.iter_mut().zip(b) {
            for k in 0..3 {
                sum[k] += b[k];
                sum[3 + k] += b[k] * b[k];
            }
        }
        batches += 1;
        let mut numbers = vec![batches as f64];
        numbers.extend(sums.as_flattened());
        let part = path.with_extension("part");
        std::fs::write(&part, bytemuck::cast_slice::<f64, u8>(&numbers))?;
        std::fs::rename(&part, &path)?;
        eprintln!("reference: {} of {samples} samples a point", batches * BATCH);
    }

    println!("reference: {} samples a point by the peer", batches * BATCH);
    let n = batches as f64;
    let scatter = |s: &[f64; 6], k: usize| ((s[3 + k] - s[k] * s[k] / n).max(0.0) / (n * (n - 1.0))).sqrt();
    Ok(Truth {
        points: points.to_vec(),
        b: sums.iter().map(|s| [0, 1, 2].map(|k| s[k] / n)).collect(),
        stderr: sums.iter().map(|s| [0, 1, 2].map(|k| scatter(s, k))).collect(),
        // All that light reaches count, however noisy: leaving some out would choose among them.
        flags: vec![Flag::Good; points.len()],
        weights: Vec::new(),
    })
}
