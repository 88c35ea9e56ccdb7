//! Ctrl-C: the first ends a bake in order, the second at once.

use super::super::{exit, log::Log};
use crate::progress::{Event, Flow};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Shows an event, and heeds Ctrl-C.
pub fn heed(log: &mut Log, stop: &AtomicBool, event: &Event) -> Flow {
    log.event(event);
    if stop.load(Ordering::Relaxed) { Flow::Stop } else { Flow::Continue }
}

/// A flag that the first Ctrl-C raises; the second one ends the process.
pub fn interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let raised = stop.clone();
    // Where no handler can be set, Ctrl-C ends the process at once, as ever.
    let _ = ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(exit::INTERRUPTED.into());
        }
    });
    stop
}
