//! MTL, used by an OBJ that is right.

use super::{Target, run};
use raycell::Flow;
use raycell::scene::{KdSpace, LoadOptions, Scene};
use std::path::Path;

const OBJ: &[u8] =
    b"mtllib s.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl wall\nf 1/1 2/2 3/3\nusemtl my lamp\nf 1 2 3\n";

const SEEDS: &[&[u8]] = &[
    b"newmtl wall\nKd 0.5 0.5 0.5\nnewmtl my lamp\nKd 0 0 0\nKe 1 2 3\n",
    b"# exporter\r\nnewmtl wall\r\nNs 250\r\nKa 1 1 1\r\nKd 0.8\r\nKs 0.5 0.5 0.5\r\nd 0.5\r\nTr 0.5\r\nillum 7\r\nmap_Kd wall.png\r\n",
    b"newmtl wall\nKd 1 1 1\nmap_Kd -s 2 2 1 -o 0.5 0 0 -clamp on t.png\nmap_d -imfchan m t.png\nnewmtl my lamp\nmap_Ke -mm 0 1 t.png\n",
    b"newmtl my lamp\n\tKd 1.0 1.0 1.0\n\tKe 17 12 4\nnewmtl wall\n",
];

const WORDS: &[&str] = &[
    "newmtl ",
    "newmtl wall\n",
    "Kd ",
    "Ke ",
    "Ks ",
    "map_Kd ",
    "map_Ke ",
    "map_d ",
    "-s 1 2 3 ",
    "-o -1 ",
    "-clamp on ",
    "-imfchan r ",
    "t.png",
    "illum ",
    "d ",
    "Tr ",
    "spectral ",
    "xyz ",
    "\n",
    "\r",
    "\\\n",
    "#",
    " ",
    "\t",
    "0.5 ",
    "-0.1 ",
    "nan ",
    "\u{e9}",
    "\u{feff}",
    "\0",
];

#[test]
fn mtl() {
    run(&Target {
        format: "mtl",
        seeds: SEEDS,
        words: WORDS,
        read: &|bytes| {
            let mut files = |path: &Path| match path.to_str() {
                Some("s.obj") => Ok(OBJ.to_vec()),
                Some("t.png") => Ok(super::png()),
                _ => Ok(bytes.to_vec()),
            };
            let mut options = LoadOptions::default();
            options.kd_space = if bytes.len() % 2 == 0 { KdSpace::Linear } else { KdSpace::Srgb };
            Scene::load_from(Path::new("s.obj"), &options, &mut files, &mut |_| Flow::Continue)
                .map(drop)
                .map_err(|e| e.to_string())
        },
        names_place: &|message| message.strip_prefix("s.mtl:").is_some_and(|m| m.starts_with(|c: char| c.is_ascii_digit())),
    });
}
