//! What `examples/benchmarks` cannot know from criterion's files: the adapter, the work of an element, the device's clock.

use crate::case::{CELLS, Case, PASSES, RAYS};
use serde_json::{Value, json};

pub struct Note(Value);

impl Note {
    pub fn new(info: &wgpu::AdapterInfo, case: &Case) -> Note {
        let passes: Vec<Value> = PASSES
            .iter()
            .map(|p| {
                let elements = case.elements(p.name);
                json!({ "name": p.name, "element": p.element, "elements": elements, "flops": p.flops, "bytes": p.bytes })
            })
            .collect();
        let driver = format!("{} {}", info.driver, info.driver_info);
        let cores = std::thread::available_parallelism().map_or(0, |n| n.get());
        Note(json!({
            "adapter": info.name, "backend": format!("{:?}", info.backend), "driver": driver.trim(),
            "cores": cores, "rays": RAYS, "cells": CELLS, "passes": passes,
        }))
    }

    /// Seconds of a run of a pass by the device's own clock.
    pub fn on_device(&mut self, pass: &str, seconds: f64) {
        let passes = self.0["passes"].as_array_mut().unwrap();
        passes.iter_mut().find(|p| p["name"] == pass).unwrap()["device_seconds"] = json!(seconds);
    }

    /// Beside criterion's own files.
    pub fn write(&self) {
        let target = std::env::var("CARGO_TARGET_DIR").unwrap_or(concat!(env!("CARGO_MANIFEST_DIR"), "/target").into());
        std::fs::create_dir_all(format!("{target}/criterion")).unwrap();
        std::fs::write(format!("{target}/criterion/raycell.json"), self.0.to_string()).unwrap();
    }
}
