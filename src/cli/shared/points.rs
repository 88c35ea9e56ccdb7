//! What is told of a point list.

use crate::solution::{Answer, Status};

pub fn off_surface(answers: &[Answer]) -> String {
    let told = |status, what: &str| match answers.iter().filter(|a| a.status == status).count() {
        0 => String::new(),
        n => format!(" ({n} of {} points are {what})", answers.len()),
    };
    told(Status::OffSurface, "off every surface") + &told(Status::Mirror, "on mirrors, which have no radiosity")
}
