//! The network beside the methods it argues with: error against coefficients, kernel evaluations, rays and time.
//!
//! `cargo run --release --example methods -- table` prints docs/methods.md's tables, `claims` its claims, each on the
//! shipped scenes (`table SCENE ...` for some of them; `claims NAME ...`: tessellation, growth, walls, crossing).
//! `cargo run --release --example methods -- bake SCENE TRUTH.csv METHOD SIZE,SIZE,... [key=value ...]` tries one:
//! METHOD is network, fem, hierarchical or rays, SIZE the patches of fem and hierarchical and the rays of the others.
//! Keys: seeds, and any parameter of `Params` as JSON (`refinements=0`, `cells_from=random`, `direct=network`).

mod claims;
mod run;
mod table;

use raycell::gpu::{Gpu, device};
use raycell::{Backend, Method, Params};
use run::{Case, Run, run};
use std::path::Path;
use std::sync::Arc;

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn main() -> Outcome {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    let open = device::open(device::BackendChoice::Auto, None)?;
    let backend = Backend::Gpu(Arc::new(Gpu::new(&open.device, &open.queue)?));
    match words[..] {
        ["table", ref scenes @ ..] => Ok(table::print(&backend, scenes)?),
        ["claims", ref names @ ..] => Ok(claims::print(&backend, names)?),
        ["bake", scene, truth, method, sizes, ref keys @ ..] => bake(&backend, scene, truth, method, sizes, keys),
        _ => Err("give table, claims, or bake SCENE TRUTH.csv METHOD SIZE,SIZE,... [key=value ...]".into()),
    }
}

fn bake(backend: &Backend, scene: &str, truth: &str, method: &str, sizes: &str, keys: &[&str]) -> Outcome {
    let case = Case::new(scene, Path::new(scene), Path::new(truth))?;
    let method: Method = serde_json::from_value(method.into())?;
    let keys: Vec<(&str, &str)> = keys.iter().filter_map(|k| k.split_once('=')).collect();
    let seeds = keys.iter().find(|k| k.0 == "seeds").map_or(Ok(1), |k| k.1.parse())?;
    println!("size seed: RRMSE by nodes, constant, linear; coefficients, evaluations, cells, nodes, sweeps, seconds, imbalance");
    for size in sizes.split(',') {
        let size: u32 = size.parse()?;
        for seed in 1..=seeds {
            let base = Params { seed, method, gather_rays: 0, ..Params::default() };
            let sized = match method {
                Method::Fem | Method::Hierarchical => Params { patches: size, ..base },
                Method::Network | Method::Rays => Params { rays: size, ..base },
            };
            let mut json = serde_json::to_value(sized)?;
            for (name, value) in keys.iter().filter(|k| k.0 != "seeds") {
                json[name] = serde_json::from_str(value).unwrap_or((*value).into());
            }
            let r = run(backend, &case, &serde_json::from_value(json)?)?;
            print!("{size} {seed}: {:.5}", r.error);
            if let Some([constant, linear]) = r.patches {
                print!(", {constant:.5}, {linear:.5}");
            }
            let Run { coefficients, evaluations, cells, nodes, sweeps, seconds, imbalance, .. } = r;
            println!("; {coefficients} {evaluations} {cells} {nodes} {sweeps} {seconds:.1} {imbalance:+.4}");
        }
    }
    Ok(())
}
