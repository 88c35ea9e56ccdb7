//! Work that waits for a host's frames: recorded slice by slice, each as long as the host allows.
//!
//! A bake runs on a thread of its own and hands its work in; the host records a slice a frame, and
//! submits it. How much fits into a slice is learnt from how long earlier slices took: by timestamps
//! where the host's device has them, else from when the host hears that a slice is done.

use super::pace::{DISPATCH, FASTER, GROWTH, Pace, part};
use super::stamps::{Stamps, Timer};
use super::work::Work;
use crate::error::{Error, Result};
use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, mpsc};
use std::time::{Duration, Instant};

/// Part of what a pass allows a dispatch that goes into a kernel's first slice, which is measured.
const PROBE: f64 = 1.0 / 2048.0;
/// Slices that may be on the device at a time where it has timestamps: one runs, one is ready.
const TIMED: usize = 2;
/// Slices at a time where the host's hearing is the clock. On drivers that submit in line (lavapipe) the host also
/// waits less: 99 % of frames under 2.4 ms instead of 5.6.
const UNTIMED: usize = 1;
/// Bytes copied or cleared a second, as planned: slow enough for any bus.
const COPY_RATE: f64 = 2e9;
/// Part of a slice that the first items of a job may take.
const FIRST: f64 = 1.0 / 3.0;
/// How much a measurement of several kernels together may slow each.
const SLOWER: f64 = 3.0;
/// Part of the time until the host hears of a slice that is taken for the device's, whatever the host's delay.
const SURE: f64 = 0.1;
/// Bytes that are not divided further.
const PIECE: u64 = 1 << 18;
/// Part of the budget that is planned: estimates err.
const PLANNED: f64 = 0.75;

/// Work between a bake and its host.
#[derive(Debug, Default)]
pub(crate) struct Frames {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    works: VecDeque<Work>,
    /// The host is gone: nothing will be submitted any more.
    closed: bool,
    /// What is known of each kernel.
    paces: HashMap<&'static str, Pace>,
    /// Slices recorded and not known to be done.
    in_flight: usize,
    /// A recorded slice was thrown away: what it should have done is missing.
    unsubmitted: bool,
    /// Seconds until the host hears of a frame without a slice.
    delay: f64,
}

/// A slice on its way: which kernels it holds and what they were expected to take.
struct Slice {
    /// Kernels, and how much of what their pass allows a dispatch.
    kernels: Vec<(&'static str, f64)>,
    /// Dispatches.
    dispatches: f64,
    /// Seconds; NaN where its one kernel was never measured.
    planned: f64,
}

/// A slice that the host has. Dropped before it is done, it was never submitted.
struct Sent {
    frames: Arc<Frames>,
    done: bool,
}

impl Drop for Sent {
    fn drop(&mut self) {
        if !self.done {
            let mut state = self.frames.state();
            state.unsubmitted = true;
            self.frames.changed.notify_all();
        }
    }
}

impl Frames {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// Hands work in. Errors: [`Error::Cancelled`] where the host is gone.
    pub fn push(&self, work: Work) -> Result<()> {
        let mut state = self.state();
        if state.closed {
            return Err(Error::Cancelled);
        }
        state.works.push_back(work);
        Ok(())
    }

    /// Sleeps until a callback has sent. Errors: [`Error::Cancelled`] where the host is gone, [`Error::Device`]
    /// where it threw a slice away.
    pub fn wait_for<T>(&self, arrived: &mpsc::Receiver<T>) -> Result<T> {
        let mut state = self.state();
        loop {
            if let Ok(value) = arrived.try_recv() {
                return Ok(value);
            }
            if state.closed {
                return Err(Error::Cancelled);
            }
            if state.unsubmitted {
                let why = "commands with the bake's work were dropped instead of submitted".into();
                return Err(Error::Device { stage: "the host's frame".into(), why });
            }
            state = self.changed.wait(state).unwrap_or_else(|e| e.into_inner());
        }
    }

    /// Makes the bake look again.
    pub fn wake(&self) {
        // With the lock, so that no one is between looking and sleeping.
        let _state = self.state();
        self.changed.notify_all();
    }

    /// The host is gone: all that waits ends, now and later.
    pub fn close(&self) {
        let mut state = self.state();
        state.closed = true;
        let left = std::mem::take(&mut state.works);
        self.changed.notify_all();
        drop(state);
        drop(left);
    }

    /// Whether there is work and nothing on the device.
    pub fn ready(&self) -> bool {
        let state = self.state();
        !state.works.is_empty() && state.in_flight == 0
    }

    /// Whether all work has been recorded.
    pub fn empty(&self) -> bool {
        self.state().works.is_empty()
    }

    /// Records the next slice: copies, then dispatches that take `budget` on the device, then copies
    /// and mappings. Says whether anything was recorded.
    pub fn record(
        self: &Arc<Self>,
        device: &wgpu::Device,
        timer: Option<&Timer>,
        encoder: &mut wgpu::CommandEncoder,
        budget: Duration,
    ) -> bool {
        let start = Instant::now();
        let mut state = self.state();
        let frames = self.clone();
        let most = if timer.is_some() { TIMED } else { UNTIMED };
        if state.in_flight >= most || state.works.is_empty() {
            if state.in_flight == 0 && timer.is_none() {
                encoder.on_submitted_work_done(move || frames.state().delay = start.elapsed().as_secs_f64());
            }
            return false;
        }
        let budget = budget.as_secs_f64();
        let mut left = PLANNED * budget;
        let in_time = |left: f64| left > 0.0 && start.elapsed().as_secs_f64() < budget;

        state.record_others(device, encoder, &mut left, in_time);
        let slice = if in_time(left) && matches!(state.works.front(), Some(Work::Dispatch { .. })) {
            let stamps = timer.map(|timer| Stamps::new(device, timer));
            let writes = stamps.as_ref().map(Stamps::writes);
            let mut pass =
                encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("raycell"), timestamp_writes: writes });
            let slice = state.record_dispatches(device, &mut pass, &mut left, in_time);
            drop(pass);
            state.record_others(device, encoder, &mut left, in_time);
            Some((slice, stamps))
        } else if let Some(Work::Warm { .. }) = state.works.front() {
            // Compiling takes as long as it takes, and says nothing about slices.
            if let Some(work) = state.works.pop_front() {
                work.record(device, encoder);
            }
            state.record_others(device, encoder, &mut left, in_time);
            None
        } else {
            None
        };

        state.in_flight += 1;
        match slice {
            Some((slice, Some(stamps))) => {
                let mut sent = Sent { frames, done: false };
                stamps.read(device, encoder, move |seconds| {
                    sent.done = true;
                    sent.frames.state().done(seconds.map(|seconds| (slice, seconds)));
                });
            }
            slice => {
                let mut sent = Sent { frames, done: false };
                encoder.on_submitted_work_done(move || {
                    sent.done = true;
                    let mut state = sent.frames.state();
                    // How long the device was at it: less what the host takes to hear of anything.
                    let heard = start.elapsed().as_secs_f64();
                    let planned = slice.as_ref().map_or(0.0, |(slice, _)| slice.planned);
                    // Within the delay's own noise nothing was slow: else slices would shrink for no reason, and go on shrinking.
                    let own = heard - state.delay;
                    let own = if heard < 2.0 * state.delay + planned { own.min(planned) } else { own };
                    let seconds = own.max(SURE * heard);
                    state.done(slice.map(|(slice, _)| (slice, seconds)));
                })
            }
        }
        true
    }
}

impl State {
    /// Records what is neither dispatch nor warming, up to the first that is; long copies and clears in parts.
    fn record_others(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        left: &mut f64,
        in_time: impl Fn(f64) -> bool,
    ) {
        while in_time(*left) && !matches!(self.works.front(), None | Some(Work::Dispatch { .. } | Work::Warm { .. })) {
            let Some(mut work) = self.works.pop_front() else { return };
            let wanted = (*left * COPY_RATE) as u64;
            let rest = work.split(wanted.next_multiple_of(PIECE));
            *left -= work.bytes() as f64 / COPY_RATE;
            work.record(device, encoder);
            if let Some(rest) = rest {
                self.works.push_front(rest);
            }
        }
    }

    /// Records dispatches, in parts where they are long, until the time is planned for.
    fn record_dispatches(
        &mut self,
        device: &wgpu::Device,
        pass: &mut wgpu::ComputePass,
        left: &mut f64,
        in_time: impl Fn(f64) -> bool,
    ) -> Slice {
        let alone = self.in_flight == 0;
        let mut slice = Slice { kernels: Vec::new(), dispatches: 0.0, planned: 0.0 };
        while in_time(*left) {
            let Some(Work::Dispatch { job, items: rest }) = self.works.front_mut() else { break };
            let begins = rest.start == 0;
            let pace = self.paces.get_mut(job.name);
            let pace = pace.map(|pace| {
                if begins {
                    pace.seconds = pace.seconds.max(std::mem::take(&mut pace.slowest));
                }
                *pace
            });
            let items = match pace {
                Some(pace) => {
                    // What a job's items cost is seen in its first slice.
                    let wanted = if begins { *left * FIRST } else { *left };
                    part(job, rest, (wanted / pace.seconds).min(GROWTH * pace.tried))
                }
                // Alone in its slice, and small, so that its time is its own.
                None if alone && slice.kernels.is_empty() => part(job, rest, PROBE),
                None => break,
            };
            job.encode_part(device, rest.start..rest.start + items, pass);
            rest.start += items;
            let share = job.share * f64::from(items);
            let seconds = pace.map_or(f64::NAN, |pace| pace.seconds * share + DISPATCH);
            match slice.kernels.iter_mut().find(|(name, _)| *name == job.name) {
                Some((_, sum)) => *sum += share,
                None => slice.kernels.push((job.name, share)),
            }
            slice.planned += seconds;
            slice.dispatches += 1.0;
            // Where it is not known how long it takes, that is enough.
            *left = if seconds.is_nan() { 0.0 } else { *left - seconds };
            let done = rest.start == rest.end;
            if done {
                self.works.pop_front();
            } else if begins {
                break;
            }
        }
        slice
    }

    /// A slice is done: learns from the seconds it took, where they are known.
    fn done(&mut self, took: Option<(Slice, f64)>) {
        self.in_flight = self.in_flight.saturating_sub(1);
        let Some((slice, seconds)) = took else { return };
        let items = (seconds - DISPATCH * slice.dispatches).max(0.0);
        let planned = slice.planned - DISPATCH * slice.dispatches;
        for &(name, share) in &slice.kernels {
            let pace = self.paces.entry(name).or_insert(Pace::of(items / share));
            // Each kernel's part of what was measured, as it was planned.
            let measured = match slice.kernels.len() {
                1 => items / share,
                _ => pace.seconds * (items / planned).clamp(1.0 / FASTER, SLOWER),
            };
            pace.learn(share, measured);
        }
    }
}

impl std::fmt::Debug for State {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("State").field("works", &self.works.len()).field("in_flight", &self.in_flight).finish_non_exhaustive()
    }
}
