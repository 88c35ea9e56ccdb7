//! What the user sees while it runs: a bar on a terminal, a line a stage elsewhere, nothing when quiet.
//!
//! Everything goes to stderr; a closed stderr is ignored.

use super::console::Console;
use crate::progress::Event;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::Instant;

/// Shows events.
pub struct Log {
    console: Console,
    bar: Option<ProgressBar>,
    stage: Option<(&'static str, Instant)>,
    rays: u64,
    cells: u64,
    sweep: Option<(u32, f64)>,
    error: Option<String>,
}

impl Log {
    pub fn new(console: &Console) -> Log {
        let bar = (!console.quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::no_length();
            bar.set_style(style("{spinner} {prefix} {msg}"));
            bar.enable_steady_tick(std::time::Duration::from_millis(120));
            bar
        });
        Log { console: *console, bar, stage: None, rays: 0, cells: 0, sweep: None, error: None }
    }

    /// A line for the user.
    pub fn line(&self, text: &str) {
        self.beside_the_bar(|| self.console.line(text));
    }

    pub fn warning(&self, text: &str) {
        self.beside_the_bar(|| self.console.warning(text));
    }

    fn beside_the_bar(&self, write: impl FnOnce()) {
        match &self.bar {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    pub fn event(&mut self, event: &Event) {
        match event {
            Event::Stage { name } => {
                self.end_stage();
                self.stage = Some((name, Instant::now()));
                if let Some(bar) = &self.bar {
                    bar.set_style(style("{spinner} {prefix} {msg}"));
                    bar.unset_length();
                    bar.set_prefix(*name);
                    bar.set_message("");
                }
            }
            Event::Rays { done, total } => {
                self.rays = *done;
                self.advance(*done, *total, "rays");
            }
            Event::Read { done, total } => self.advance(done >> 10, total >> 10, "KiB"),
            Event::Points { done, total } => self.advance(*done, *total, "points"),
            Event::Cells { count } => {
                self.cells = *count;
                self.message(format!("{count} cells"));
            }
            Event::Sweep { n, residual } => {
                self.sweep = Some((*n, *residual));
                self.message(format!("sweep {n}, residual {residual:.1e}"));
            }
            Event::Error { rrmse, low, high } => {
                self.error =
                    Some(format!("estimated error {:.2} % ({:.2} to {:.2} %)", 100.0 * rrmse, 100.0 * low, 100.0 * high));
            }
            Event::Warning(text) => self.warning(text),
            Event::Spent { .. } | Event::Tick => {}
        }
    }

    fn advance(&self, done: u64, total: u64, unit: &str) {
        let (Some(bar), Some((_, since))) = (&self.bar, &self.stage) else { return };
        if bar.length() != Some(total) {
            bar.set_length(total);
            bar.set_style(style("{spinner} {prefix} [{bar:30}] {msg}"));
        }
        bar.set_position(done);
        // Counted from the stage's beginning: the first event may come when much is done.
        let rate = done as f64 / since.elapsed().as_secs_f64().max(1e-9);
        let left = total.saturating_sub(done) as f64 / rate.max(1e-9);
        let cells = if self.cells > 0 { format!(", {} cells", self.cells) } else { String::new() };
        self.message(format!("{done}/{total} {unit}, {rate:.0} {unit}/s{cells}, {left:.0} s left"));
    }

    fn message(&self, text: String) {
        if let Some(bar) = &self.bar {
            bar.set_message(text);
        }
    }

    /// One line for the stage that has ended.
    fn end_stage(&mut self) {
        let Some((name, since)) = self.stage.take() else { return };
        let seconds = since.elapsed().as_secs_f64();
        let mut text = format!("{name}: {seconds:.2} s");
        if self.rays > 0 {
            text += &format!(", {} rays, {:.0} rays/s", self.rays, self.rays as f64 / seconds.max(1e-9));
        }
        if self.cells > 0 {
            text += &format!(", {} cells", self.cells);
        }
        if let Some((n, residual)) = self.sweep {
            text += &format!(", {n} sweeps, residual {residual:.1e}");
        }
        if let Some(error) = self.error.take() {
            text += &format!(", {error}");
        }
        (self.rays, self.cells, self.sweep) = (0, 0, None);
        self.line(&text);
    }

    /// Ends the last stage and clears the bar.
    pub fn finish(&mut self) {
        self.end_stage();
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        // After an error the bar must not stay on the message's line.
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_spinner())
}
