//! What a bake is to reach: flags, and the goal they make.

use crate::accuracy::Goal;
use crate::error::{Error, Result};
use clap::{Args, ValueEnum};
use std::time::Duration;

/// What it is to reach.
#[derive(Args)]
#[command(next_help_heading = "Accuracy")]
pub struct Flags {
    /// Bake until the error is within this, in percent: until the upper end of its estimate is, and half of the
    /// surface is within twice as much of its own light. Exits with 1 where it cannot be.
    #[arg(long, value_name = "PCT", conflicts_with_all = ["rays", "cells", "patches", "quality"])]
    pub target_error: Option<String>,
    /// Use this much time, as 90, 90s, 1.5m or 2h, read-out included: the best that can be had in it.
    #[arg(long, value_name = "TIME", conflicts_with_all = ["rays", "cells", "patches"])]
    pub time_budget: Option<String>,
    /// An error to reach by name: preview 10 %, normal 3 %, final 1 %.
    #[arg(long, value_enum, conflicts_with_all = ["rays", "cells", "patches"])]
    pub quality: Option<Quality>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// 10 %: seconds.
    Preview,
    /// 3 %: what an eye takes for right.
    Normal,
    /// 1 %, and final gathers everywhere.
    Final,
}

impl Flags {
    /// The goal, where there is one. Errors: [`Error::InvalidParam`].
    pub fn goal(&self) -> Result<Option<Goal>> {
        let seconds = |text: &String| {
            let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("min", 60.0), ("h", 3600.0), ("", 1.0)];
            number("time-budget", text, &units, [0.1, 1e6], "give seconds, as 90, 90s, 1.5m or 2h, from 0.1 s to a million")
        };
        let named = self.quality.map(|quality| match quality {
            Quality::Preview => 0.1,
            Quality::Normal => 0.03,
            Quality::Final => 0.01,
        });
        let error = self.target_error.as_ref().map(|text| percent("target-error", text)).transpose()?.or(named);
        let budget = self.time_budget.as_ref().map(seconds).transpose()?.map(Duration::from_secs_f64);
        Ok((error.is_some() || budget.is_some()).then_some(Goal { error, budget }))
    }
}

/// A share in percent. Errors: [`Error::InvalidParam`].
pub fn percent(name: &'static str, text: &str) -> Result<f64> {
    number(name, text, &[("%", 0.01), ("", 0.01)], [1e-4, 1.0], "give 0.01 to 100 percent")
}

/// A number with a unit.
fn number(name: &'static str, text: &str, units: &[(&str, f64)], [low, high]: [f64; 2], range: &'static str) -> Result<f64> {
    let text = text.trim();
    let end = text.find(|c: char| c.is_alphabetic() && c != 'e' || c == '%').unwrap_or(text.len());
    let unit = units.iter().find(|u| u.0 == text[end..].trim()).map(|u| u.1);
    let value = unit.zip(text[..end].trim().parse::<f64>().ok()).map(|(unit, x)| unit * x);
    value.filter(|x| (low..=high).contains(x)).ok_or_else(|| Error::InvalidParam { name, value: text.into(), range })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_units() {
        let goal = |error: Option<&str>, budget: Option<&str>| {
            Flags { target_error: error.map(String::from), time_budget: budget.map(String::from), quality: None }.goal()
        };
        assert_eq!(goal(None, None).unwrap(), None);
        for text in ["3", "3%", " 3 %", "3.0%"] {
            assert!((goal(Some(text), None).unwrap().unwrap().error.unwrap() - 0.03).abs() < 1e-12, "{text}");
        }
        for (text, seconds) in [("90", 90.0), ("90s", 90.0), ("1.5m", 90.0), ("2h", 7200.0), ("250ms", 0.25)] {
            assert_eq!(goal(None, Some(text)).unwrap().unwrap().budget, Some(Duration::from_secs_f64(seconds)), "{text}");
        }
        for text in ["", "x", "-1", "0", "nan", "3 apples", "1000%"] {
            assert!(goal(Some(text), None).is_err(), "{text}");
        }
        assert!(goal(None, Some("10 parsec")).is_err() && goal(None, Some("0")).is_err());
    }
}
