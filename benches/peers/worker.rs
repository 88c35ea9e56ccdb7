//! The peer's process, asked line by line.

use crate::Outcome;
use crate::table::Seconds;
use raycell::SurfacePoint;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

pub struct Worker {
    /// What the peer says of itself.
    pub version: String,
    process: Child,
    ask: Option<ChildStdin>,
    answer: BufReader<ChildStdout>,
    file: PathBuf,
}

impl Worker {
    /// Starts it on a scene and points, or says why there is none.
    pub fn start(
        python: &str,
        scene: &Path,
        points: &[SurfacePoint],
        threads: usize,
        out: &Path,
    ) -> Outcome<Result<Worker, String>> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peers/by_mitsuba.py");
        let places = out.join("points.f32");
        let numbers: Vec<f32> = points.iter().flat_map(|p| [p.p, p.n]).flatten().map(|x| x as f32).collect();
        std::fs::write(&places, bytemuck::cast_slice::<f32, u8>(&numbers))?;
        let command = Command::new(python)
            .arg(script)
            .args([scene, &places])
            .arg(threads.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut process = match command {
            Ok(process) => process,
            Err(e) => return Ok(Err(format!("{python}: {e}"))),
        };
        let (ask, answer) = (process.stdin.take(), process.stdout.take().ok_or("no pipe")?);
        let mut worker =
            Worker { version: String::new(), process, ask, answer: BufReader::new(answer), file: out.join("answer.f32") };
        let line = worker.line()?;
        Ok(match line.split_once(' ') {
            Some(("ready", version)) => {
                worker.version = version.into();
                Ok(worker)
            }
            Some(("skipped", why)) => Err(why.into()),
            _ => Err(format!("{python} ended without a word")),
        })
    }

    /// Seconds, and radiosity at the points.
    pub fn bake(&mut self, spp: u32, seed: u32) -> Outcome<(Seconds, Vec<[f64; 3]>)> {
        let ask = self.ask.as_mut().ok_or("the peer has ended")?;
        writeln!(ask, "{spp} {seed} {}", self.file.display())?;
        let line = self.line()?;
        let said: serde_json::Value = serde_json::from_str(&line).map_err(|_| "the peer ended early")?;
        let seconds =
            Seconds { wall: said["seconds"].as_f64().ok_or("the peer told no seconds")?, cores: said["core_seconds"].as_f64() };
        let bytes = std::fs::read(&self.file)?;
        let b =
            bytes.chunks_exact(12).map(|c| [0, 4, 8].map(|k| f32::from_le_bytes([c[k], c[k + 1], c[k + 2], c[k + 3]]) as f64));
        Ok((seconds, b.collect()))
    }

    fn line(&mut self) -> Outcome<String> {
        let mut line = String::new();
        self.answer.read_line(&mut line)?;
        Ok(line.trim().to_string())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        // It ends with its input.
        self.ask = None;
        let _ = self.process.wait();
    }
}
