//! The images that scene files name: found, decoded, and taken into the scene once.

use super::Scene;
use super::load::Reader;
use super::mtl::{NEARLY_ONE, not_quite_one};
use super::texture::{Map, Meaning, Texture};
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};

/// Images by the name in their file and by how they are meant: their number in the scene, none where they cannot be had.
#[derive(Default)]
pub struct Images(HashMap<(String, Meaning), Option<u32>>);

impl Images {
    /// The number of an image that `place` names; `bytes` are asked for once. Where it cannot be had a warning says what
    /// is taken `instead`.
    pub fn take(
        &mut self,
        name: &str,
        meaning: Meaning,
        bytes: impl FnOnce() -> Result<Vec<u8>, String>,
        place: &str,
        instead: &str,
        scene: &mut Scene,
    ) -> Option<u32> {
        if let Some(&known) = self.0.get(&(name.to_string(), meaning)) {
            return known;
        }
        // Whoever has the scene elsewhere knows the image by its last name.
        let last = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let made = match bytes() {
            Err(why) => Err(format!("{place}: texture '{name}' was not found ({why}), and {instead}; put it beside the scene")),
            Ok(bytes) => {
                Texture::decode(last, &bytes, meaning).and_then(|t| t.check().map(|()| t).map_err(|e| e.to_string())).map_err(
                    |why| format!("{place}: texture '{name}' cannot be read ({why}), and {instead}; export it anew, as a PNG"),
                )
            }
        };
        let known = match made {
            Ok(texture) => {
                scene.textures.push(texture);
                Some(scene.textures.len() as u32 - 1)
            }
            Err(warning) => {
                scene.warnings.push(warning);
                None
            }
        };
        self.0.insert((name.to_string(), meaning), known);
        known
    }
}

/// The file of a name beside another: as written, with Windows' separators turned, or by its last part alone,
/// where a path of somebody else's machine was written.
pub fn find(beside: &Path, name: &str, reader: &mut Reader) -> io::Result<(PathBuf, Vec<u8>)> {
    let folder = beside.parent().unwrap_or(Path::new(""));
    let turned = name.replace('\\', "/");
    let mut read = |name: &str| {
        let path = folder.join(name);
        reader.try_read(&path).map(|bytes| (path, bytes))
    };
    read(&turned).or_else(|e| match turned.rsplit_once('/') {
        Some((_, last)) if !last.is_empty() => read(last).map_err(|_| e),
        _ => Err(e),
    })
}

/// Lowers what multiplies a map where its largest texel would reflect everything, with the warning of a plain reflectance.
pub fn below_one(factor: [f64; 3], map: Option<Map>, name: &str, place: &str, scene: &mut Scene) -> [f64; 3] {
    let most = map.map_or([1.0; 3], |m| scene.textures[m.texture as usize].most().map(f64::from));
    let product = [0, 1, 2].map(|k| factor[k] * most[k]);
    let lowered = not_quite_one(product, name, place, &mut scene.warnings);
    // What is no number stays so, to be refused.
    [0, 1, 2].map(|k| if lowered[k] < product[k] { NEARLY_ONE / most[k] } else { factor[k] })
}
