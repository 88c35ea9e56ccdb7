//! `raycell selftest`: whether this machine's driver computes what is known.

use super::console::Console;
use super::exit::{DONE, Done, MISSED};
use super::log::Log;
use super::shared::interrupt::{heed, interrupt};
use super::shared::machine::{Device, Machine};
use crate::error::Result;
use crate::output::report::AdapterReport;
use crate::selftest::{Outcome, Spoil, run_with};
use clap::Args;
use serde_json::json;
use std::collections::BTreeSet;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  raycell selftest
      Closed forms beside what this machine's driver finds. Exit code 1 where one is missed.
  raycell selftest D02 A06 --adapter llvmpipe
      Some cases of docs/hard_cases.md, on an adapter of this name.
  raycell selftest --json
      The same for a script.";

#[derive(Args)]
#[command(after_long_help = EXAMPLES)]
pub struct Flags {
    /// Cases of docs/hard_cases.md, as A06; all where none is named.
    #[arg(value_name = "CASE")]
    pub cases: Vec<String>,
    #[command(flatten)]
    pub device: Device,
}

pub fn run(flags: Flags, console: &Console) -> Result<Done> {
    let begin = Instant::now();
    let mut log = Log::new(console);
    let machine = Machine::open(&flags.device, &log)?;
    let stop = interrupt();
    let outcomes = run_with(&machine.backend, &flags.cases, Spoil::Nothing, &mut |event| heed(&mut log, &stop, event));
    let outcomes = machine.judge("the self-test", outcomes)?;
    log.finish();
    Ok(told(&outcomes, machine.adapter.as_ref(), begin.elapsed().as_secs_f64()))
}

/// The table, the object, and the exit code.
fn told(outcomes: &[Outcome], adapter: Option<&AdapterReport>, seconds: f64) -> Done {
    let cases: BTreeSet<_> = outcomes.iter().map(|o| o.case).collect();
    let failed: BTreeSet<_> = outcomes.iter().filter(|o| !o.pass).map(|o| o.case).collect();
    let width = outcomes.iter().map(|o| o.what.chars().count()).max().unwrap_or(0);
    let mut text = format!("case  {:width$}  {:>15}  {:>15}  {:>9}  pass\n", "what", "truth", "got", "tolerance");
    for o in outcomes {
        let got = o.got.map_or("-".into(), number);
        let (truth, pass) = (number(o.truth), if o.pass { "yes" } else { "NO" });
        text += &format!("{:4}  {:width$}  {truth:>15}  {got:>15}  {:>9}  {pass}\n", o.case, o.what, bound(o.tolerance));
        if let Some(error) = &o.error {
            text += &format!("      {error}\n");
        }
    }
    text += &format!("{} of {} cases pass, {seconds:.1} s\n", cases.len() - failed.len(), cases.len());
    let object = json!({
        "command": "selftest",
        "adapter": adapter,
        "cases": cases.len(),
        "passed": cases.len() - failed.len(),
        "failed": failed,
        "outcomes": outcomes,
        "seconds": seconds,
    });
    Done { code: if failed.is_empty() { DONE } else { MISSED }, text, object }
}

/// A number to nine digits, whole ones whole.
fn number(x: f64) -> String {
    match x.abs() {
        a if a == a.trunc() && a < 1e12 => format!("{x}"),
        a if (1e-3..1e5).contains(&a) => format!("{x:.8}"),
        _ => format!("{x:.8e}"),
    }
}

/// A tolerance; nothing is the tolerance of what must be so exactly.
fn bound(x: f64) -> String {
    if x == 0.0 { "exact".into() } else { format!("{x:.2e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Backend;
    use crate::progress::Flow;

    #[test]
    fn a_case_that_fails_is_told_and_is_exit_code_1() {
        let some = ["A11", "A17"].map(String::from);
        let run = |spoil| run_with(&Backend::Cpu, &some, spoil, &mut |_| Flow::Continue).unwrap();
        let good = told(&run(Spoil::Nothing), None, 1.0);
        assert_eq!((good.code, &good.object["passed"], &good.object["cases"]), (0, &2.into(), &2.into()), "{}", good.text);
        assert!(good.text.contains("2 of 2 cases pass") && !good.text.contains("NO"), "{}", good.text);
        let bad = told(&run(Spoil::Truths), None, 1.0);
        assert_eq!((bad.code, &bad.object["failed"]), (1, &json!(["A11", "A17"])), "{}", bad.text);
        assert!(bad.text.contains("0 of 2 cases pass") && bad.text.matches("NO\n").count() == 6, "{}", bad.text);
    }

    #[test]
    fn an_unknown_case_is_refused() {
        let refused = run_with(&Backend::Cpu, &["Z99".into()], Spoil::Nothing, &mut |_| Flow::Continue).unwrap_err();
        assert!(refused.to_string().contains("CASE = Z99"), "{refused}");
    }
}
