//! The error estimate beside the true error, on random scenes and on the shipped ones.
//!
//! `cargo run --release --example estimate -- claim` bakes the claim's scenes (seeds 81 to 100), `tune` those for tuning
//! (101 to 120), `shipped` those with a truth in tests/data: three rungs of the ladder of sizes, three seeds each. Each
//! prints a row a run, a table in Markdown and the claim's figures; what was baked is kept, and stopped it goes on. `scenes SEED ...` says what the random scenes hold, `obj SEED
//! FILE` writes one, `references SEED ... seconds=60` makes their truths, or goes on with them. More words narrow a table:
//! seeds or names of scenes, and `rungs=2,4`, `seeds=2`. Truths are kept in target/estimate.

mod scenes;
mod table;
mod truths;

use raycell::gpu::{Gpu, device};
use raycell::{Backend, Params};
use std::sync::Arc;

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// Seeds of the scenes that the claim is made on: nobody looks at them while anything is tuned.
const CLAIM: std::ops::RangeInclusive<u32> = 81..=100;
/// Seeds of the scenes for tuning.
const TUNE: std::ops::RangeInclusive<u32> = 101..=120;
/// Rungs of the settings: 16,384, 65,536 and 131,072 rays.
const RUNGS: [u32; 3] = [2, 4, 5];
/// Seeds of the bakes.
const SEEDS: u32 = 3;

fn main() -> Outcome {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    match words[..] {
        ["scenes", ref seeds @ ..] => {
            for seed in numbers(seeds)? {
                println!("{seed}: {}", scenes::describe(&scenes::scene(seed)?));
            }
            Ok(())
        }
        ["obj", seed, file] => Ok(scenes::write(&scenes::scene(seed.parse()?)?, file.as_ref())?),
        ["references", ref more @ ..] => {
            let (keys, seeds): (Vec<&str>, Vec<&str>) = more.iter().partition(|w| w.contains('='));
            let seconds = key(&keys, "seconds").map_or(Ok(60), str::parse)?;
            numbers(&seeds)?.into_iter().try_for_each(|seed| truths::refine(seed, seconds))
        }
        ["claim", ref more @ ..] => bake(more, || CLAIM.map(truths::random).collect()),
        ["tune", ref more @ ..] => bake(more, || TUNE.map(truths::random).collect()),
        ["shipped", ref more @ ..] => bake(more, truths::shipped),
        _ => Err("give claim, tune, shipped, references SEED ..., scenes SEED ..., or obj SEED FILE".into()),
    }
}

/// The value of `name=value`.
fn key<'a>(keys: &[&'a str], name: &str) -> Option<&'a str> {
    keys.iter().find_map(|k| k.strip_prefix(name)?.strip_prefix('='))
}

fn numbers(words: &[&str]) -> Outcome<Vec<u32>> {
    let mut seeds = Vec::new();
    for word in words {
        match word.split_once('-') {
            Some((a, b)) => seeds.extend(a.parse::<u32>()?..=b.parse()?),
            None => seeds.push(word.parse()?),
        }
    }
    if seeds.is_empty() { Err("give seeds, as 101 or 101-112".into()) } else { Ok(seeds) }
}

/// Bakes the cases that are named, or all, and prints their table.
fn bake(more: &[&str], all: impl Fn() -> Outcome<Vec<truths::Case>>) -> Outcome {
    let (keys, names): (Vec<&str>, Vec<&str>) = more.iter().partition(|w| w.contains('='));
    let mut rungs = RUNGS.to_vec();
    if let Some(list) = key(&keys, "rungs") {
        rungs = list.split(',').map(str::parse).collect::<Result<_, _>>()?;
    }
    let seeds = key(&keys, "seeds").map_or(Ok(SEEDS), str::parse)?;
    let seeds_named = numbers(&names);
    let cases: Vec<truths::Case> = match seeds_named {
        Ok(seeds) => seeds.into_iter().map(truths::random).collect::<Outcome<_>>()?,
        Err(_) => all()?.into_iter().filter(|case| names.is_empty() || names.contains(&case.name.as_str())).collect(),
    };
    let open = device::open(device::BackendChoice::Auto, None)?;
    let backend = Backend::Gpu(Arc::new(Gpu::new(&open.device, &open.queue)?));
    let mut table = table::Table::default();
    println!("{}", table::HEADER);
    for case in &cases {
        for &rung in &rungs {
            for seed in 1..=seeds {
                println!("{}", table.run(&backend, case, &Params { seed, ..Params::default() }.rung(rung))?);
            }
        }
    }
    println!("\n{}\n{}", table.short(), table.claim());
    Ok(())
}
