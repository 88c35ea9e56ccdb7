//! How devices fail: lost, out of memory, or otherwise.

use crate::error::{Error, Result};
use std::sync::{Arc, Mutex};

/// Keeps the first failure of a device that nobody else heard of.
#[derive(Clone, Debug, Default)]
pub struct Watch(Arc<Mutex<Option<Failure>>>);

#[derive(Clone, Debug)]
enum Failure {
    Lost(String),
    OutOfMemory(String),
    Other(String),
}

impl Watch {
    /// Watches a device. It takes the place of the device's handlers, of which the default one panics: only for
    /// a device that is one's own.
    pub(super) fn on(device: &wgpu::Device) -> Watch {
        let watch = Watch::default();
        let lost = watch.clone();
        device.set_device_lost_callback(move |reason, message| lost.keep(Failure::Lost(format!("{reason:?}: {message}"))));
        let error = watch.clone();
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| {
            let text = e.to_string();
            error.keep(match e {
                wgpu::Error::OutOfMemory { .. } => Failure::OutOfMemory(text),
                _ => Failure::Other(text),
            });
        }));
        watch
    }

    fn keep(&self, failure: Failure) {
        self.0.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(failure);
    }

    /// A result of this device: where the device failed meanwhile, that is the error, whatever came of it.
    ///
    /// Errors: [`Error::DeviceLost`], [`Error::OutOfMemory`], [`Error::Device`], else the result's own.
    pub fn judge<T>(&self, stage: &str, result: Result<T>) -> Result<T> {
        let stage = || stage.to_string();
        match self.0.lock().unwrap_or_else(|e| e.into_inner()).clone() {
            Some(Failure::Lost(why)) => Err(Error::DeviceLost { stage: stage(), why }),
            Some(Failure::OutOfMemory(why)) => Err(Error::OutOfMemory { stage: stage(), why }),
            Some(Failure::Other(why)) => Err(Error::Device { stage: stage(), why }),
            None => result,
        }
    }
}

/// What an error that a scope caught is to a user.
pub(super) fn of(device: &wgpu::Device, stage: String, e: wgpu::Error) -> Error {
    match e {
        wgpu::Error::OutOfMemory { .. } => Error::OutOfMemory { stage, why: e.to_string() },
        _ => or_lost(device, stage, e.to_string()),
    }
}

/// A failure of the device, told apart from its loss.
pub(super) fn or_lost(device: &wgpu::Device, stage: String, why: String) -> Error {
    if is_lost(device) { Error::DeviceLost { stage, why } } else { Error::Device { stage, why } }
}

/// Whether a device is lost. Its owner's callback tells, and that is the owner's; but on a lost device a buffer
/// is made without an error, and without memory.
fn is_lost(device: &wgpu::Device) -> bool {
    let scopes = [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::Validation]
        .map(|filter| device.push_error_scope(filter));
    let probe = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("raycell.probe"),
        size: 16,
        usage: wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: true,
    });
    let mapped = probe.get_mapped_range_mut(..).is_ok();
    let errors = scopes.into_iter().rev().map(|scope| pollster::block_on(scope.pop())).filter(Option::is_some).count();
    !mapped && errors == 0
}
