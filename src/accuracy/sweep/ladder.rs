//! Which runs a sweep makes: methods, each at growing settings, with several seeds.

use crate::params::{Direct, Method, Mode, Params};
use serde::{Deserialize, Serialize};

/// A method with what belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The network, direct light exact: the default of every bake.
    Network,
    /// The network carries all light.
    NetworkDirect,
    /// The seed paper's network.
    Paper,
    /// Uniform patches.
    Fem,
    /// Links between patches of a hierarchy.
    Hierarchical,
    /// Every ray its own coefficient.
    Rays,
}

/// What a kind's setting counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// Light rays.
    Rays,
    /// Patches.
    Patches,
    /// Cells, with 32 kernel evaluations each.
    Cells,
}

/// Kernel evaluations for each cell of the paper's network.
const EVALUATIONS: u32 = 32;

impl Kind {
    /// All, in the order of reports.
    pub const ALL: [Kind; 6] = [Kind::Network, Kind::NetworkDirect, Kind::Paper, Kind::Fem, Kind::Hierarchical, Kind::Rays];

    /// As it is called on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Network => "network",
            Kind::NetworkDirect => "network-direct",
            Kind::Paper => "paper",
            Kind::Fem => "fem",
            Kind::Hierarchical => "hierarchical",
            Kind::Rays => "rays",
        }
    }

    /// In words.
    pub fn title(self) -> &'static str {
        match self {
            Kind::Network => "network (default)",
            Kind::NetworkDirect => "network, --direct network",
            Kind::Paper => "network, --mode paper",
            Kind::Fem => "finite elements",
            Kind::Hierarchical => "hierarchical",
            Kind::Rays => "raw rays",
        }
    }

    /// What its settings count.
    pub fn size(self) -> Size {
        match self {
            Kind::Network | Kind::NetworkDirect | Kind::Rays => Size::Rays,
            Kind::Fem | Kind::Hierarchical => Size::Patches,
            Kind::Paper => Size::Cells,
        }
    }

    /// A setting in words.
    pub fn setting(self, size: u32) -> String {
        let what = match self.size() {
            Size::Rays => "rays",
            Size::Patches => "patches",
            Size::Cells => "cells",
        };
        format!("{} {what}", thousands(size as u64))
    }

    /// The exponent by which a run's time is foreseen to grow with its setting.
    pub fn growth(self) -> f64 {
        if self.size() == Size::Patches { 2.0 } else { 1.0 }
    }

    /// The parameters of a run. Everything else is the default: also the read-out, which all share, but for its final
    /// gathers where they are not wanted.
    pub fn params(self, size: u32, seed: u32, gather: bool) -> Params {
        let default = Params::default();
        let base = Params { seed, gather_rays: if gather { default.gather_rays } else { 0 }, ..default };
        match self {
            Kind::Network => Params { rays: size, ..base },
            Kind::NetworkDirect => Params { rays: size, direct: Direct::Network, ..base },
            Kind::Rays => Params { rays: size, method: Method::Rays, ..base },
            Kind::Fem => Params { patches: size, method: Method::Fem, ..base },
            Kind::Hierarchical => Params { patches: size, method: Method::Hierarchical, ..base },
            Kind::Paper => {
                let mut params = Params { mode: Mode::Paper, direct: Direct::Network, cells: Some(size), gather_rays: 0, ..base };
                params.paper.evaluations = Some(size.saturating_mul(EVALUATIONS));
                params
            }
        }
    }
}

/// 524288 as 524,288.
pub fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().filter_map(|g| std::str::from_utf8(g).ok()).collect();
    groups.join(",")
}

/// The settings of each kind, smallest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Sizes {
    pub rays: Vec<u32>,
    pub patches: Vec<u32>,
    pub cells: Vec<u32>,
}

impl Sizes {
    /// The default ladder.
    pub fn of(flatland: bool) -> Sizes {
        let (rays, patches): (&[u32], &[u32]) = match flatland {
            true => (&[2_048, 8_192, 32_768, 131_072, 524_288], &[16, 32, 64, 128, 256]),
            false => (&[8_192, 32_768, 131_072, 524_288, 2_097_152], &[100, 350, 800, 1_600, 3_200]),
        };
        Sizes { rays: rays.into(), patches: patches.into(), cells: vec![128, 256, 512, 1_024] }
    }

    /// The settings of a kind.
    pub fn of_kind(&self, kind: Kind) -> Vec<u32> {
        match kind.size() {
            // Every ray's coefficients are swept again and again: a quarter of the rays takes the network's time.
            Size::Rays if kind == Kind::Rays && self.rays.len() > 2 => self.rays[..self.rays.len() - 1].to_vec(),
            Size::Rays => self.rays.clone(),
            // The hierarchy divides what it begins with.
            Size::Patches if kind == Kind::Hierarchical => self.patches.iter().map(|p| (p / 2).max(4)).collect(),
            Size::Patches => self.patches.clone(),
            Size::Cells => self.cells.clone(),
        }
    }
}

/// A run to be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rung {
    pub kind: Kind,
    pub size: u32,
    pub seed: u32,
}

/// All runs, the small ones of all kinds first: a sweep that is stopped has something of each.
pub fn rungs(kinds: &[Kind], sizes: &Sizes, seeds: u32) -> Vec<Rung> {
    let deepest = kinds.iter().map(|&k| sizes.of_kind(k).len()).max().unwrap_or(0);
    let at = |level: usize| kinds.iter().filter_map(move |&kind| Some((kind, *sizes.of_kind(kind).get(level)?)));
    (0..deepest).flat_map(at).flat_map(|(kind, size)| (1..=seeds).map(move |seed| Rung { kind, size, seed })).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rung_can_be_baked() {
        for flatland in [false, true] {
            let rungs = rungs(&Kind::ALL, &Sizes::of(flatland), 2);
            assert!(rungs.len() > 40, "{}", rungs.len());
            for r in &rungs {
                r.kind.params(r.size, r.seed, true).check().unwrap();
            }
            // The first of each come before the second of any.
            assert!(rungs[..12].iter().all(|r| r.size == Sizes::of(flatland).of_kind(r.kind)[0]));
        }
        assert_eq!((thousands(524_288), thousands(7), thousands(1_000)), ("524,288".into(), "7".into(), "1,000".into()));
    }
}
