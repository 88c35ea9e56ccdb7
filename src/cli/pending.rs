//! Stand-ins, so that this builds before `Solution` has methods of the same names (which then win).
//! To be deleted with its `use` in run.rs once it has.
#![allow(dead_code)]

use crate::bake::Backend;
use crate::error::{Error, Result};
use crate::output::ply::Mesh;
use crate::solution::{Camera, Image, Solution};
use std::path::Path;

fn pending<T>(name: &'static str) -> Result<T> {
    Err(Error::InvalidParam { name, value: "asked for".into(), range: "it is not built yet" })
}

pub trait Pending: Sized {
    fn render(&self, _: &Backend, _: &Camera) -> Result<Image> {
        pending("render")
    }
    fn vertices(&self, _: &Backend) -> Result<Mesh> {
        pending("vertices")
    }
    fn save(&self, _: &Path) -> Result<()> {
        pending("solution.rcell")
    }
    fn load(_: &Path) -> Result<Self> {
        pending("solution.rcell")
    }
}

impl Pending for Solution {}
