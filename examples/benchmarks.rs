//! Writes docs/benchmarks.md from what `cargo bench --bench passes` left in target/criterion. `ci/benchmarks` runs both.

use serde_json::Value;
use std::error::Error;
use std::path::{Path, PathBuf};

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

/// Where criterion's files lie.
struct Estimates(PathBuf);

/// Seconds of a run.
struct Measured {
    median: f64,
    /// Between the quartiles' distance and the median there is a factor of 1.35 for a normal scatter; criterion keeps the
    /// median absolute deviation, which is what is told here.
    spread: f64,
}

impl Estimates {
    fn json(&self, path: &str) -> Outcome<Value> {
        let path = self.0.join(path);
        let text = std::fs::read_to_string(&path)
            .map_err(|e| format!("{}: {e}; run `cargo bench --bench passes` first", path.display()))?;
        Ok(serde_json::from_str(&text)?)
    }

    fn of(&self, id: &str) -> Outcome<Measured> {
        let json = self.json(&format!("{id}/new/estimates.json"))?;
        let seconds = |key: &str| json[key]["point_estimate"].as_f64().map(|ns| ns * 1e-9).ok_or(format!("{id}: no {key}"));
        Ok(Measured { median: seconds("median")?, spread: seconds("median_abs_dev")? })
    }

    /// Elements, or bytes, of a run.
    fn amount(&self, id: &str) -> Outcome<f64> {
        let json = self.json(&format!("{id}/new/benchmark.json"))?;
        let amount = ["Elements", "Bytes"].iter().find_map(|k| json["throughput"][k].as_f64());
        amount.ok_or(format!("{id}: no throughput").into())
    }
}

impl Measured {
    fn milliseconds(&self) -> String {
        format!("{} ± {:.0} %", short(1e3 * self.median), 100.0 * self.spread / self.median)
    }
}

/// Three digits.
fn short(x: f64) -> String {
    let digits = (2 - x.abs().max(1e-9).log10().floor() as i32).clamp(0, 3) as usize;
    format!("{x:.digits$}")
}

/// With a unit's prefix.
fn rate(x: f64) -> String {
    let (scale, prefix) = [(1e9, "G"), (1e6, "M"), (1e3, "k")].into_iter().find(|(s, _)| x >= *s).unwrap_or((1.0, ""));
    format!("{} {prefix}", short(x / scale)).trim().to_string()
}

fn main() -> Outcome {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = std::env::var("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    let path = root.join("docs/benchmarks.md");
    std::fs::write(&path, page(&Estimates(target.join("criterion")))?)?;
    println!("wrote {}", path.display());
    Ok(())
}

fn page(all: &Estimates) -> Outcome<String> {
    let note = all.json("raycell.json")?;
    let word = |key: &str| note[key].as_str().unwrap_or("unknown").to_string();
    let (fma, triad) = (all.of("limit/fma")?, all.of("limit/triad")?);
    let flops = all.amount("limit/fma")? / fma.median;
    let bytes = all.amount("limit/triad")? / triad.median;
    let mut page = format!(
        "# Benchmarks\n\nWritten by `ci/benchmarks`; what is measured is told in [benches/README.md](../benches/README.md).\n\n\
         - adapter: {} ({}), driver {}, {} processor threads\n\
         - scene: Cornell box, {} rays a batch, {} cells\n\
         - limits through this driver: {:.1} GFLOP/s of multiply-adds (± {:.0} %), {:.1} GB/s of triad (± {:.0} %)\n\
         - {}\n\n## Passes\n\n\
         Milliseconds: median of 10 samples of a run with the host's part in it, ± median absolute deviation. Device: by the \
         device's own clock, where it has one. A pass's share of a limit is its known work a run over the device's time (the \
         run's where there is no clock); passes that walk the hierarchy have no known work. \
         A batch this small lies in the processor's cache, so a pass may beat the triad, which does not.\n\n\
         | pass | elements | run ms | device ms | elements/s | of FMA rate | of bandwidth | twin ms |\n|---|---|---|---|---|---|---|---|\n",
        word("adapter"),
        word("backend"),
        word("driver"),
        note["cores"],
        note["rays"],
        note["cells"],
        flops * 1e-9,
        100.0 * fma.spread / fma.median,
        bytes * 1e-9,
        100.0 * triad.spread / triad.median,
        load(),
    );
    for pass in note["passes"].as_array().ok_or("no passes")? {
        let name = pass["name"].as_str().ok_or("a pass without a name")?;
        let (device, twin) = (all.of(&format!("pass/{name}/device"))?, all.of(&format!("pass/{name}/twin"))?);
        let count = pass["elements"].as_f64().ok_or("no elements")?;
        let clock = pass["device_seconds"].as_f64();
        let share = |work: &Value, limit: f64| match work.as_f64() {
            Some(work) => format!("{:.0} %", 100.0 * work * count / clock.unwrap_or(device.median) / limit),
            None => String::new(),
        };
        page += &format!(
            "| {name} | {count} × {} | {} | {} | {} | {} | {} | {} |\n",
            pass["element"].as_str().unwrap_or("element"),
            device.milliseconds(),
            clock.map(|s| short(1e3 * s)).unwrap_or_default(),
            rate(count / device.median),
            share(&pass["flops"], flops),
            share(&pass["bytes"], bytes),
            twin.milliseconds(),
        );
    }
    page += "\n## Whole bakes\n\nCornell box, default settings but for the rays; seconds with everything after start-up.\n\n\
             | rays | seconds | rays/s |\n|---|---|---|\n";
    let mut bakes: Vec<u64> = std::fs::read_dir(all.0.join("bake/cornell"))?
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok())
        .collect();
    bakes.sort_unstable();
    for rays in bakes {
        let run = all.of(&format!("bake/cornell/{rays}"))?;
        let share = 100.0 * run.spread / run.median;
        page += &format!("| {rays} | {} ± {share:.0} % | {} |\n", short(run.median), rate(rays as f64 / run.median));
    }
    Ok(page)
}

/// How busy the machine is now: what the figures can be trusted for.
fn load() -> String {
    match std::fs::read_to_string("/proc/loadavg") {
        Ok(load) => {
            let means: Vec<&str> = load.split_whitespace().take(3).collect();
            format!("mean number of running programs in the last 1, 5 and 15 minutes: {}", means.join(", "))
        }
        Err(_) => "the machine's load is not known".into(),
    }
}
