//! What a scene calls for: which effects can matter in it, and on what evidence.
//!
//! [`analyse`] looks at the scene alone, without a device and without a bake. Shares come from a few thousand rays
//! of the plain-Rust twins, so they are good to a few percent; what is said to be absent is proven, not sampled.

mod colour;
mod light;
mod lights;
mod maps;
mod names;
mod occlusion;
mod switches;
mod time;
mod way;

pub use names::Name;
pub use switches::{Switches, drop_below};
pub use time::after;
pub(crate) use time::{Spent, spend};

use crate::error::Result;
use crate::output::report::EffectReport;
use crate::scene::{Geometry, Scene};
use light::Look;

/// Why an effect is absent that the files do not ask for.
pub(crate) const NONE: &str = "the scene asks for none";

/// The effects of a scene, in the order of [`Name::ALL`].
///
/// Errors: those of [`Geometry::new`]: [`Scene::check`]'s, and [`crate::Error::EmptyScene`].
pub fn analyse(scene: &Scene) -> Result<Vec<EffectReport>> {
    Ok(of(scene, &Geometry::new(scene)?).0)
}

/// As [`analyse`], of a scene that is prepared; and the share of rays from surfaces that meet a mirror.
pub(crate) fn of(scene: &Scene, geometry: &Geometry) -> (Vec<EffectReport>, f64) {
    let look = Look::at(geometry);
    let effects = Name::ALL
        .iter()
        .map(|&name| match name {
            _ if scene.effects.asked(name) == Some(false) => asked_off(name),
            Name::Direct => direct(geometry, &look),
            Name::Occlusion => occlusion::occlusion(scene, geometry, &look),
            Name::Interreflection => interreflection(scene, geometry, &look),
            Name::Colour => colour::colour(scene),
            Name::TwoSided => two_sided(geometry),
            Name::Flatland => flatland(geometry),
            Name::Textures => maps::textures(scene, geometry),
            Name::Environment => lights::environment(scene, geometry, &look),
            Name::Lights => lights::lights(scene, geometry, &look),
            Name::Mirrors => way::mirrors(scene, geometry, &look),
            Name::Transparency => maps::transparency(scene, geometry),
            Name::Medium => way::medium(scene, geometry, &look),
        })
        .collect();
    (effects, look.over_mirrors)
}

fn told(name: Name, on: bool, why: String, cost: &str) -> EffectReport {
    EffectReport { name: name.word().into(), on, why, cost: cost.into(), ..EffectReport::default() }
}

/// The same with its part of the light.
fn shared(effect: EffectReport, share: f64) -> EffectReport {
    EffectReport { share: Some(share), ..effect }
}

/// An effect that was asked off.
fn asked_off(name: Name) -> EffectReport {
    told(name, false, "asked off".into(), "nothing")
}

fn percent(x: f64) -> String {
    if x > 0.0 && x < 0.001 { "under 0.1 %".into() } else { format!("{:.*} %", usize::from(x < 0.1), 100.0 * x) }
}

fn direct(geometry: &Geometry, look: &Look) -> EffectReport {
    let shining = geometry.emitters.len();
    let sort = if geometry.flatland { "segment" } else { "triangle" };
    if !geometry.shines() {
        return told(Name::Direct, false, "nothing shines: all is dark (give a material a Ke)".into(), "nothing");
    }
    let cost = "shadow rays at every ray's ends and at every point shown";
    if geometry.is_surfaceless() {
        let straight = percent(1.0 - look.reflected);
        let why = format!(
            "{}; {straight} of all light comes straight from where it shines",
            match shining {
                0 => "only what has no surface shines".into(),
                1 => format!("1 {sort} shines, and what has no surface"),
                n => format!("{n} {sort}s shine, and what has no surface"),
            }
        );
        return told(Name::Direct, true, why, cost);
    }
    let why = format!(
        "{shining} {sort}{} shine{}; {} of all light comes straight from them",
        if shining == 1 { "" } else { "s" },
        if shining == 1 { "s" } else { "" },
        percent(1.0 - look.reflected),
    );
    told(Name::Direct, true, why, cost)
}

fn interreflection(scene: &Scene, geometry: &Geometry, look: &Look) -> EffectReport {
    let rho = |m: u32| f64::from(geometry.most_rho[m as usize]);
    let most = geometry.tris.iter().map(|t| t.material).max_by(|&a, &b| rho(a).total_cmp(&rho(b)));
    let Some(most) = most.filter(|&m| rho(m) > 0.0) else {
        return told(Name::Interreflection, false, "no surface reflects: all light is direct".into(), "nothing");
    };
    if !geometry.shines() {
        return told(Name::Interreflection, false, "nothing shines: there is nothing to reflect".into(), "nothing");
    }
    let why = format!(
        "surfaces reflect up to {} ('{}'); {} of all light has been reflected before it arrives, and after {} reflection{} \
         less than 0.1 % of it is left",
        percent(rho(most)),
        scene.materials[most as usize].name,
        percent(look.reflected),
        look.bounces,
        if look.bounces == 1 { "" } else { "s" },
    );
    let on = told(Name::Interreflection, true, why, "the network: training rays, coefficients and the solve");
    shared(on, look.reflected)
}

fn two_sided(geometry: &Geometry) -> EffectReport {
    let sheets = geometry.tris.iter().filter(|t| t.plane & crate::layout::TWIN != 0).count() / 2;
    match sheets {
        0 => told(Name::TwoSided, false, "every triangle has one lit side".into(), "nothing"),
        1 => told(Name::TwoSided, true, "1 triangle is lit on both sides".into(), "a triangle more"),
        n => told(Name::TwoSided, true, format!("{n} triangles are lit on both sides"), "as many triangles more"),
    }
}

fn flatland(geometry: &Geometry) -> EffectReport {
    match geometry.flatland {
        true => {
            told(Name::Flatland, true, "the scene is of segments in the plane".into(), "less than space: kernels of their own")
        }
        false => told(Name::Flatland, false, "the scene is of triangles in space".into(), "nothing"),
    }
}

/// An effect that is not built: absent where the files do not ask for it, else the reader's own words.
fn unread(scene: &Scene, name: Name, words: &[&str]) -> EffectReport {
    let asks = |w: &&String| w.contains("not supported") && words.iter().any(|word| w.contains(word));
    let why = match scene.warnings.iter().find(asks) {
        Some(warning) => format!("asked for and not built yet: {warning}"),
        None => NONE.into(),
    };
    told(name, false, why, "nothing")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, shapes};

    fn grey(rho: f64, e: f64) -> Material {
        Material::new("grey", [rho; 3], [e; 3])
    }

    fn effects(triangles: &shapes::Triangles, materials: Vec<Material>) -> Vec<EffectReport> {
        analyse(&Scene::from_triangles("room", triangles, materials).unwrap()).unwrap()
    }

    fn on(effects: &[EffectReport], name: Name) -> &EffectReport {
        effects.iter().find(|e| e.name == name.word()).unwrap()
    }

    #[test]
    fn an_empty_room_has_no_shadows_and_a_block_in_it_casts_some() {
        let room = shapes::room([0.0; 3], [1.0, 2.0, 3.0], [0, 0, 0, 1, 0, 0]);
        let materials = || vec![grey(0.5, 0.0), grey(0.0, 1.0)];
        let empty = effects(&room, materials());
        assert!(!on(&empty, Name::Occlusion).on, "{empty:?}");
        let full = [room, shapes::block([0.3, 0.5, 0.5], [0.7, 1.0, 1.0], 0)].concat();
        let full = effects(&full, materials());
        assert!(on(&full, Name::Occlusion).on && on(&full, Name::Occlusion).why.contains('%'), "{full:?}");
        assert!(on(&full, Name::Interreflection).on && on(&full, Name::Direct).on);
        assert_eq!(full.iter().map(|e| e.name.as_str()).collect::<Vec<_>>(), Name::ALL.map(Name::word));
    }

    #[test]
    fn black_walls_reflect_nothing_and_dark_rooms_shine_nothing() {
        let room = shapes::room([0.0; 3], [1.0; 3], [0, 0, 0, 1, 0, 0]);
        let black = effects(&room, vec![grey(0.0, 0.0), grey(0.0, 1.0)]);
        assert!(!on(&black, Name::Interreflection).on && on(&black, Name::Direct).on);
        let dark = effects(&room, vec![grey(0.5, 0.0), grey(0.5, 0.0)]);
        assert!(!on(&dark, Name::Interreflection).on && !on(&dark, Name::Direct).on);
    }

    #[test]
    fn shares_of_a_furnace_are_those_of_its_series() {
        // Everywhere D = 1 and B = 2: half of what arrives has been reflected, and 2^-10 is left after 10 reflections.
        let geometry = Geometry::new(
            &Scene::from_triangles("room", &shapes::room([0.0; 3], [1.0; 3], [0; 6]), vec![grey(0.5, 1.0)]).unwrap(),
        )
        .unwrap();
        let look = Look::at(&geometry);
        assert!((look.reflected - 0.5).abs() < 0.02, "{look:?}");
        assert_eq!(look.bounces, 9);
        assert_eq!(look.blocked, 0.0);
    }
}
