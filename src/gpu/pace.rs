//! How long kernels take, learnt as they run, so that no dispatch is long: drivers of desktops reset a device that is at one
//! for seconds, and a picture stands still meanwhile. How work is cut changes no byte.

use super::Job;
use super::kernel::WORKGROUP;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};

/// Seconds of a dispatch apart from its items.
pub(super) const DISPATCH: f64 = 50e-6;
/// How much a measurement may quicken a kernel's pace. Work of one kernel differs: what follows may be
/// slower again, and that is heeded at once.
pub(super) const FASTER: f64 = 1.15;
/// How much a dispatch may outgrow the longest of its kernel so far: a first measurement may be far off.
pub(super) const GROWTH: f64 = 2.0;
/// Seconds that a dispatch should take where raycell submits.
const TARGET: f64 = 0.03;
/// Least part of what a pass allows a dispatch that is worth one by itself.
const LEAST: f64 = 1.0 / 32.0;

/// How long a kernel takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Seconds of all that its pass allows a dispatch.
    pub seconds: f64,
    /// The slowest of the job before: where a job begins, it may be as slow again.
    pub slowest: f64,
    /// Largest part of what its pass allows a dispatch in one so far.
    pub tried: f64,
}

impl Pace {
    /// The pace of a kernel that was never measured before.
    pub fn of(seconds: f64) -> Pace {
        Pace { seconds, slowest: 0.0, tried: 0.0 }
    }

    /// Learns from a `share` of what its pass allows; `measured` is what all of it would take.
    pub fn learn(&mut self, share: f64, measured: f64) {
        self.tried = self.tried.max(share);
        self.seconds = measured.max(self.seconds / FASTER);
        self.slowest = self.slowest.max(measured);
    }
}

/// How many of the items that are left go into one dispatch: about a share `wanted` of what the pass
/// allows; whole workgroups where there are any.
pub(super) fn part(job: &Job, rest: &Range<u32>, wanted: f64) -> u32 {
    let items = ((wanted / job.share) as u32).max(1);
    let whole = if items > WORKGROUP { items - items % WORKGROUP } else { items };
    whole.min(rest.len() as u32)
}

/// The paces of all kernels where raycell submits.
#[derive(Debug, Default)]
pub(super) struct Paces {
    known: Mutex<HashMap<&'static str, Pace>>,
    /// Seconds of each kernel's longest dispatch that was measured.
    longest: Mutex<BTreeMap<&'static str, f64>>,
    /// Whether every dispatch is measured.
    all: AtomicBool,
}

impl Paces {
    fn known(&self) -> MutexGuard<'_, HashMap<&'static str, Pace>> {
        self.known.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// How many of a job's items go into the next dispatch, and whether it has to be measured.
    pub fn next(&self, job: &Job, rest: &Range<u32>) -> (u32, bool) {
        let all = self.all.load(Ordering::Relaxed);
        if job.share * f64::from(job.items) <= LEAST {
            return ((rest.len() as u32).min(job.chunk), all);
        }
        let (wanted, grown) = match self.known().get(job.name) {
            None => (LEAST, false),
            Some(pace) => {
                let wanted = (TARGET / pace.seconds).clamp(LEAST, 1.0);
                let most = (GROWTH * pace.tried).max(LEAST);
                (wanted.min(most), wanted <= most)
            }
        };
        let items = part(job, rest, wanted).min(job.chunk);
        // Where a job is cut, its first part tells what its items cost.
        let begins = rest.start == 0 && items < rest.len() as u32;
        (items, all || !grown || begins)
    }

    /// A dispatch of so many items has taken `seconds`.
    pub fn took(&self, job: &Job, items: u32, seconds: f64) {
        let share = job.share * f64::from(items);
        if share >= 0.5 * LEAST {
            let measured = (seconds - DISPATCH).max(0.0) / share;
            self.known().entry(job.name).or_insert(Pace::of(measured)).learn(share, measured);
        }
        let mut longest = self.longest.lock().unwrap_or_else(|e| e.into_inner());
        let most = longest.entry(job.name).or_default();
        *most = most.max(seconds);
    }

    /// From now on every dispatch is measured.
    pub fn measure_all(&self) {
        self.all.store(true, Ordering::Relaxed);
    }

    pub fn longest(&self) -> BTreeMap<&'static str, f64> {
        self.longest.lock().unwrap_or_else(|e| e.into_inner()).clone()
    }
}
