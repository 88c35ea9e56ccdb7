//! Fig. 1: a museum from two places, of one solution.

use super::{Figure, Press, stage};
use crate::error::{Error, Result};
use crate::output::image::Tone;
use crate::params::Params;
use crate::plot::panel::titled;
use crate::plot::{draw, picture::picture};
use crate::scene::{LoadOptions, Scene};
use crate::solution::{Camera, Image};
use std::path::Path;

/// How much of it is made.
#[derive(Clone, Debug)]
pub struct Options {
    /// Light rays of the bake.
    pub rays: u32,
    /// Pixels across a view.
    pub width: u32,
    /// Pixels down a view.
    pub height: u32,
}

impl Default for Options {
    fn default() -> Options {
        Options { rays: 262_144, width: 480, height: 300 }
    }
}

/// The files of `scenes/museum`, as they were when the program was built.
const MUSEUM: [(&str, &[u8]); 3] = [
    ("scene.toml", include_bytes!("../../scenes/museum/scene.toml")),
    ("scene.obj", include_bytes!("../../scenes/museum/scene.obj")),
    ("scene.mtl", include_bytes!("../../scenes/museum/scene.mtl")),
];

/// The museum.
pub fn scene(press: &mut Press) -> Result<Scene> {
    let mut read = |path: &Path| {
        let name = path.file_name().unwrap_or_default();
        let file = MUSEUM.iter().find(|(n, _)| *n == name);
        file.map(|(_, bytes)| bytes.to_vec()).ok_or_else(|| std::io::ErrorKind::NotFound.into())
    };
    let mut scene = Scene::load_from(Path::new("museum/scene.toml"), &LoadOptions::default(), &mut read, press.tell)?;
    scene.name = "museum".into();
    Ok(scene)
}

/// Makes the figure.
pub fn make(press: &mut Press, options: &Options) -> Result<Figure> {
    let scene = scene(press)?;
    // A picture for the eye: a few per cent of noise in what is lit directly are not seen.
    let params = Params {
        seed: press.seed,
        rays: options.rays,
        direct_tolerance: 0.04,
        direct_samples: 64,
        gather_rays: 48,
        gather_threshold: 0.5,
        ..Params::default()
    };
    let solution = crate::bake(press.backend, &scene, &params, press.tell)?;
    let mut views: Vec<(String, Image)> = Vec::new();
    for view in &scene.cameras {
        stage(press, "render")?;
        let camera = Camera { width: options.width, height: options.height, ..view.camera };
        views.push((view.name.clone(), solution.render_with(press.backend, &camera, press.tell)?));
    }
    let [a, b] = views.as_slice() else {
        return Err(Error::EmptyScene { scene: scene.name.clone() });
    };

    // One exposure for both: one light.
    let all: Vec<[f32; 3]> = views.iter().flat_map(|(_, image)| image.rgb.iter().copied()).collect();
    let tone = Tone::auto(&all);
    let mut figure = Figure::new("fig1", "Fig. 1: a museum, from two places, of one solution");
    let (width, height) = (1200, 44 + 592 * options.height / options.width);
    let drawn = draw(width, height, |page| {
        let halves = page.split_evenly((1, 2));
        for (area, (name, image)) in halves.iter().zip([a, b]) {
            let pixels: Vec<[u8; 3]> = image.rgb.iter().map(|&c| tone.map(c)).collect();
            picture(&titled(area, name)?, &pixels, image.width, image.height)?;
        }
        Ok(())
    });
    figure.drawing(press, drawn)?;
    for (name, image) in &views {
        figure.exr(press, name, image)?;
    }

    let report = solution.report();
    figure.about.push(format!(
        "Three rooms under skylights ({} triangles, our own), baked once in flux mode and seen from two cameras; the paper \
         shows a museum likewise. Both views have one exposure ({tone}).",
        scene.faces.len()
    ));
    figure.about.push(
        "There is no truth for this scene; what can be told is the account of its energy: what is emitted, less what is \
         absorbed and what escapes, as a share of what is emitted."
            .into(),
    );
    figure.number("triangles", scene.faces.len() as f64, "");
    figure.number("light rays", options.rays as f64, "");
    figure.number("cells", report.cells as f64, "");
    if let Some(imbalance) = report.energy.imbalance {
        figure.number("energy not accounted for", imbalance.abs(), "1");
    }
    figure.finish(press)?;
    Ok(figure)
}
