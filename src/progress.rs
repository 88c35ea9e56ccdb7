//! How a bake tells what it is doing. The library never prints: a caller's closure gets [`Event`]s.

use crate::effects::Name;
use crate::error::{Error, Result};

/// What happened.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Event {
    /// A stage began.
    Stage {
        /// Its name, as in the report's `seconds`.
        name: &'static str,
    },
    /// Bytes of a scene file read so far, counting each as often as it is gone through.
    Read {
        /// Done.
        done: u64,
        /// Of how many.
        total: u64,
    },
    /// Rays of the stage shot so far.
    Rays {
        /// Done.
        done: u64,
        /// Of how many.
        total: u64,
    },
    /// The network's size.
    Cells {
        /// Cells now.
        count: u64,
    },
    /// Jacobi sweeps done.
    Sweep {
        /// Sweeps.
        n: u32,
        /// Estimated relative distance from the fixed point.
        residual: f64,
    },
    /// Points of a read-out done.
    Points {
        /// Done.
        done: u64,
        /// Of how many.
        total: u64,
    },
    /// The estimated error of what was baked, relative, and the ends of its interval.
    Error {
        /// The estimate.
        rrmse: f64,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A part of a read-out is done.
    Spent {
        /// The effect that it was for.
        effect: Name,
        /// Wall time, without kernels being compiled.
        seconds: f64,
    },
    /// Something the user should know.
    Warning(String),
    /// Nothing new; a moment to stop at.
    Tick,
}

/// Whether to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Go on.
    Continue,
    /// Stop: the bake returns [`Error::Cancelled`]; what it has found stays in its [`crate::Checkpoint`].
    Stop,
}

/// A caller's closure, as the stages use it.
pub struct Progress<'a> {
    tell: &'a mut dyn FnMut(&Event) -> Flow,
}

impl<'a> Progress<'a> {
    /// Wraps a closure.
    pub fn new(tell: &'a mut dyn FnMut(&Event) -> Flow) -> Progress<'a> {
        Progress { tell }
    }

    /// Lets the caller stop where there is nothing to tell. Errors: [`Error::Cancelled`].
    pub fn tick(&mut self) -> Result<()> {
        self.event(Event::Tick)
    }

    /// Tells an event. Errors: [`Error::Cancelled`] where the caller wants to stop.
    pub fn event(&mut self, event: Event) -> Result<()> {
        match (self.tell)(&event) {
            Flow::Continue => Ok(()),
            Flow::Stop => Err(Error::Cancelled),
        }
    }
}
