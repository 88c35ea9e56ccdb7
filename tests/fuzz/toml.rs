//! TOML scenes, with an OBJ beside them.

use super::{Target, run};
use raycell::Flow;
use raycell::scene::{LoadOptions, Scene};
use std::path::Path;

const OBJ: &[u8] = b"mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl wall\nf 1 2 3\n";
const MTL: &[u8] = b"newmtl wall\nKd 0.5 0.5 0.5\n";

const SEEDS: &[&[u8]] = &[
    br#"[[file]]
path = "s.obj"
unit = 0.01
up = "z"
scale = [1, 1, -1]
rotate = [0, 90, 0]
translate = [1.0, 2.0, 3.0]

[[material]]
name = "wall"
reflectance = 0.25
radiosity = [1, 2, 3]
two_sided = true
"#,
    br#"[[mesh]]
name = "room"
material = "white"
vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]]
faces = [[0, 1, 2, 3], [0, 1, 4], [1, 2, 4]]

[[material]]
name = "white"
reflectance = [0.8, 0.7, 0.6]
lumens = 800
color = [1, 0.5, 0.25]

[[camera]]
name = "door"
eye = [0, 0, -2]
target = [0, 0, 0]
up = [0, 1, 0]
vfov = 50
width = 64
height = 48
"#,
    br#"file = [{ path = "s.obj", matrix = [[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], kd_space = "srgb" }]
"#,
    br#"[[mesh]]
name = "sheet"
material = "paper"
vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
faces = [[0, 1, 2, 3]]
uvs = [[0, 0], [1, 0], [1, 1], [0, 1]]

[[material]]
name = "paper"
reflectance = 0.5
reflectance_map = "t.png"
emission_map = "t.png"
alpha_map = "gone.png"
alpha_cutoff = 0.25
"#,
];

const WORDS: &[&str] = &[
    "[[file]]\n",
    "[[mesh]]\n",
    "[[material]]\n",
    "[[camera]]\n",
    "path = ",
    "\"s.obj\"",
    "\"gone.obj\"",
    "\"s.toml\"",
    "name = \"wall\"\n",
    "lumens = 1\n",
    "radiance = 1\n",
    "two_sided = true\n",
    "= ",
    "[",
    "]",
    "{",
    "}",
    "\"",
    "'''",
    "\"\"\"",
    "\n",
    "#",
    ",",
    ".",
    "nan",
    "inf",
    "-",
    "[[[[[[[[",
    "1979-05-27",
    "true",
    "\\u0000",
    "\u{e9}",
    "\0",
];

#[test]
fn toml() {
    run(&Target {
        format: "toml",
        seeds: SEEDS,
        words: WORDS,
        read: &|bytes| {
            let mut files = |path: &Path| match path.to_str() {
                Some("s.toml") => Ok(bytes.to_vec()),
                Some("s.obj") => Ok(OBJ.to_vec()),
                Some("s.mtl") => Ok(MTL.to_vec()),
                Some("t.png") => Ok(super::png()),
                _ => Err(std::io::ErrorKind::NotFound.into()),
            };
            let options = LoadOptions::default();
            Scene::load_from(Path::new("s.toml"), &options, &mut files, &mut |_| Flow::Continue)
                .map(drop)
                .map_err(|e| e.to_string())
        },
        // Line and file; or a file it names that is not there, or not of a scene; or nothing to light in all.
        names_place: &|message| {
            let line = message.strip_prefix("s.toml:").is_some_and(|m| m.starts_with(|c: char| c.is_ascii_digit()));
            let other = message.starts_with("cannot read ") || message.contains("does not tell a format");
            line || other || message.starts_with("s.toml: the scene has no triangle")
        },
    });
}
