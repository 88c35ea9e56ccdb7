//! OBJ, with a material file beside it.

use super::{Target, run};
use raycell::Flow;
use raycell::scene::{LoadOptions, Scene};
use std::path::Path;

const MTL: &[u8] = b"newmtl wall\nKd 0.5 0.5 0.5\nmap_Kd t.png\nmap_d t.png\nnewmtl lamp\nKd 0 0 0\nKe 1 2 3\n";

const SEEDS: &[&[u8]] = &[
    b"mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no floor\nusemtl wall\nvt 0 1\nvt 2 0.5\nf 1/1 2/2 3/-1 4/1\ng lamp\nusemtl lamp\nf -4 -3 -2\n",
    b"# exporter\r\nv 0 0 0 1.0\r\nv 2 0.2 0\r\nv 4 0 0\r\nv 2 3 0\r\nvt 0.5\r\nvn 0 0 1\r\nusemtl none\r\nf 1//1 2//1 \\\r\n 3//1 4//1\r\nl 1 2\r\np 3\r\n",
    b"o a\nv 0 0 0\nv 7 0 0\nv 7 5 0\nv 5 5 0\nv 5 1 0\nv 4 1 0\nv 4 5 0\nv 3 5 0\ns off\nf 1/1/1 2/2/2 3 4 5 6 7 8\n",
];

const WORDS: &[&str] = &[
    "v ",
    "f ",
    "o ",
    "g ",
    "usemtl ",
    "mtllib s.mtl",
    "l ",
    "p ",
    "vt ",
    "vn ",
    "s off",
    "\n",
    "\r\n",
    "\\\n",
    "#",
    " ",
    "\t",
    "1 ",
    "-1 ",
    "1/1/1",
    "//",
    "curv2 ",
    "\u{e9}",
    "\u{feff}",
    "\0",
    "f 1 2 3\n",
    "v 1e300 1e-300 0\n",
];

#[test]
fn obj() {
    run(&Target {
        format: "obj",
        seeds: SEEDS,
        words: WORDS,
        read: &|bytes| {
            let mut files = |path: &Path| match path.to_str() {
                Some("s.obj") => Ok(bytes.to_vec()),
                Some("s.mtl") => Ok(MTL.to_vec()),
                Some("t.png") => Ok(super::png()),
                _ => Err(std::io::ErrorKind::NotFound.into()),
            };
            let options = LoadOptions::default();
            Scene::load_from(Path::new("s.obj"), &options, &mut files, &mut |_| Flow::Continue)
                .map(drop)
                .map_err(|e| e.to_string())
        },
        // Line and file, but where the file as a whole holds nothing to light.
        names_place: &|message| {
            let line = message.strip_prefix("s.obj:").is_some_and(|m| m.starts_with(|c: char| c.is_ascii_digit()));
            line || message.starts_with("s.obj: the scene has no triangle")
        },
    });
}
