//! What effects take: a bake's time by what it was for (`docs/effects.md`).

use super::Name;
use crate::output::report::{EffectReport, Report};
use crate::twin::direct::DirectRays;
use std::collections::BTreeMap;

/// Time of a walk through the hierarchy, over all else that a sample of direct light takes: cornell's direct light at rays' ends
/// takes .17 s where no shadow ray is walked, and .5 s where they are (lavapipe, 2 cores).
const WALK: f64 = 2.0;

/// Seconds that effects took.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spent([f64; Name::ALL.len()]);

impl Spent {
    pub fn add(&mut self, name: Name, seconds: f64) {
        self.0[name as usize] += seconds;
    }

    /// Divides what direct light took by its rays.
    pub fn add_direct(&mut self, seconds: f64, rays: &DirectRays) {
        let parts = direct_work(rays);
        let all: f64 = parts.iter().map(|(_, work)| work).sum();
        for (name, work) in parts.into_iter().filter(|_| all > 0.0) {
            self.add(name, seconds * work / all);
        }
    }

    /// Divides what final gathers took: between `shot` rays, and the direct light where they end.
    pub fn add_gather(&mut self, seconds: f64, shot: u64, rays: &DirectRays) {
        let direct: f64 = direct_work(rays).iter().map(|(_, work)| work).sum();
        let carried = shot as f64 * (1.0 + WALK);
        let share = if carried > 0.0 { carried / (carried + direct) } else { 1.0 };
        self.add(Name::Interreflection, seconds * share);
        self.add_direct(seconds * (1.0 - share), rays);
    }

    /// Divides the stages of a bake. `mirrored` is the share of rays that meet a mirror.
    pub fn of_stages(stages: &BTreeMap<&'static str, f64>, rays: &DirectRays, mirrored: f64) -> Spent {
        let mut spent = Spent::default();
        for (&stage, &seconds) in stages {
            match stage {
                "direct" => spent.add_direct(seconds, rays),
                // The account and the error's estimate are of no effect.
                "energy" | "estimate" => {}
                "emit" => {
                    let share = mirrored / (1.0 + mirrored);
                    spent.add(Name::Mirrors, seconds * share);
                    spent.add(Name::Interreflection, seconds * (1.0 - share));
                }
                _ => spent.add(Name::Interreflection, seconds),
            }
        }
        spent
    }

    /// Effects that took time, and how much.
    pub fn parts(&self) -> impl Iterator<Item = (Name, f64)> {
        Name::ALL.into_iter().map(|name| (name, self.0[name as usize])).filter(|(_, seconds)| *seconds > 0.0)
    }
}

/// Work of direct light's rays; 1 is a sample without a walk.
fn direct_work(rays: &DirectRays) -> [(Name, f64); 5] {
    let whole = |rays: u64| rays as f64 * (1.0 + WALK);
    [
        (Name::Direct, rays.samples as f64),
        (Name::Occlusion, rays.lines as f64 * WALK),
        // Where there are none, most points shoot no cosine directions at lamps.
        (Name::Mirrors, whole(rays.directions)),
        (Name::Environment, whole(rays.sky)),
        (Name::Lights, whole(rays.lights)),
    ]
}

/// Adds what an effect took to those of a report; one that is absent takes nothing.
pub(crate) fn spend(effects: &mut [EffectReport], parts: impl IntoIterator<Item = (Name, f64)>) {
    for (name, seconds) in parts {
        if let Some(effect) = effects.iter_mut().find(|e| e.on && e.name == name.word()) {
            *effect.seconds.get_or_insert(0.0) += seconds;
        }
    }
}

/// What effects took of a bake, as shares of all its time, the dearest first; empty where that is not known. What is
/// left of 1 is of no effect: opening the device, reading, compiling, the account of energy, the error's estimate.
pub fn after(report: &Report) -> Vec<(String, f64)> {
    let Some(total) = report.seconds.total.filter(|&t| t > 0.0) else { return Vec::new() };
    let effects = report.effects.iter().flatten().filter(|e| e.on);
    let mut shares: Vec<(String, f64)> =
        effects.filter_map(|e| Some((e.name.clone(), e.seconds.filter(|&s| s > 0.0)? / total))).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_direct_light_takes_is_divided() {
        let rays = DirectRays { samples: 24, lines: 24, directions: 0, sky: 32, lights: 2 };
        let mut spent = Spent::default();
        spent.add_direct(3.0, &rays);
        spent.add_gather(5.0, 100, &rays);
        let parts: BTreeMap<_, _> = spent.parts().map(|(name, seconds)| (name.word(), seconds)).collect();
        assert!((parts.values().sum::<f64>() - 8.0).abs() < 1e-12, "{parts:?}");
        assert!((parts["occlusion"] / parts["direct"] - WALK).abs() < 1e-12 && parts["environment"] > parts["lights"]);
        assert!(!parts.contains_key("mirrors") && parts["interreflection"] < 5.0, "{parts:?}");
        // Nothing was shot: it is the network's.
        let mut none = Spent::default();
        none.add_direct(1.0, &DirectRays::default());
        none.add_gather(1.0, 0, &DirectRays::default());
        assert_eq!(none.parts().collect::<Vec<_>>(), [(Name::Interreflection, 1.0)]);
    }

    #[test]
    fn what_is_off_takes_nothing() {
        let effect = |name: Name, on| EffectReport { name: name.word().into(), on, ..EffectReport::default() };
        let mut effects = vec![effect(Name::Direct, true), effect(Name::Lights, false)];
        spend(&mut effects, [(Name::Direct, 0.5), (Name::Lights, 0.25), (Name::Direct, 1.0)]);
        let mut report = Report { effects: Some(effects), ..Report::default() };
        assert!(after(&report).is_empty(), "all of it is not known");
        report.seconds.total = Some(2.0);
        assert_eq!(after(&report), [("direct".to_string(), 0.75)]);
    }
}
