//! The linear system as sections of a `.rcell` file, the same in solutions and checkpoints.

use crate::error::Result;
use crate::output::rcell::{Container, Section};
use crate::twin::jacobi::System;

/// The sections that hold a system, in the order they are written; the nodes' own materials where they have some.
pub(crate) fn of(system: &System) -> Vec<Section<'_>> {
    let own = Section::new("node_materials", &system.materials);
    let all = [
        Section::new("cell_offsets", &system.cell_offsets),
        Section::new("cell_links", &system.cell_links),
        Section::new("source", &system.source),
        Section::new("node_offsets", &system.node_offsets),
        Section::new("node_links", &system.node_links),
        Section::new("planes", &system.planes),
        Section::new("node_source", &system.node_source),
    ];
    all.into_iter().chain((!system.materials.is_empty()).then_some(own)).collect()
}

/// The system that [`of`] wrote. Errors: [`crate::Error::Format`] where a section is missing.
pub(crate) fn read(file: &Container) -> Result<System> {
    Ok(System {
        cell_offsets: file.get("cell_offsets")?,
        cell_links: file.get("cell_links")?,
        source: file.get("source")?,
        node_offsets: file.get("node_offsets")?,
        node_links: file.get("node_links")?,
        planes: file.get("planes")?,
        node_source: file.get("node_source")?,
        materials: if file.has("node_materials") { file.get("node_materials")? } else { Vec::new() },
    })
}
