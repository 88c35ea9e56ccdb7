//! CSV lists of points.

use super::{Target, run};
use raycell::output::points;
use std::path::Path;

const SEEDS: &[&[u8]] = &[
    b"px,py,pz,nx,ny,nz\n0.5,0,0.5,0,1,0\n-1e-3,2.5,1e3,0,0,-2\n",
    b"\xef\xbb\xbfid,\"nx\", ny ,nz,px,py,pz,note\r\n1,0,1,0,0.5,0,0.5,\"a, \"\"b\"\"\nc\"\r\n2,1,0,0,1,2,3,\r\n",
    b"px,py,pz,nx,ny,nz,B_r,status\n1,2,3,0,1,0,0.25,ok\n1,2,3,0,1,0,,off_surface\n4,5,6,0,0,1,1,ok\n",
];

const WORDS: &[&str] = &[
    "px",
    "py",
    "pz",
    "nx",
    "ny",
    "nz",
    ",",
    ",,",
    ";",
    "\t",
    " ",
    "\"",
    "\"\"",
    "\n",
    "\r",
    "\r\n",
    "\u{feff}",
    "\0",
    "0,0,0",
    "px,py,pz,nx,ny,nz\n",
    "0,0,0,0,1,0\n",
    "\u{e9}",
    "#",
];

#[test]
fn csv() {
    run(&Target {
        format: "csv",
        seeds: SEEDS,
        words: WORDS,
        read: &|bytes| {
            let read = points::parse(Path::new("p.csv"), bytes).map_err(|e| e.to_string())?;
            // What is let through is fit to be asked for.
            assert!(read.iter().all(|p| p.p.iter().chain(&p.n).all(|x| x.is_finite()) && p.n != [0.0; 3]));
            Ok(())
        },
        names_place: &|message| message.strip_prefix("p.csv:").is_some_and(|m| m.starts_with(|c: char| c.is_ascii_digit())),
    });
}
