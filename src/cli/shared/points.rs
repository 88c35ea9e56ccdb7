//! What is told of a point list.

use crate::solution::{Answer, Status};

pub fn off_surface(answers: &[Answer]) -> String {
    let n = answers.iter().filter(|a| a.status == Status::OffSurface).count();
    if n > 0 { format!(" ({n} of {} points are off every surface)", answers.len()) } else { String::new() }
}
