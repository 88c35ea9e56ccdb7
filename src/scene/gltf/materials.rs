//! Materials of a glTF file: the diffuse and the emitting part.

use crate::scene::mtl::{GREY, grey_mirror, not_quite_one};
use crate::scene::unread::Unread;
use crate::scene::{Material, Scene};
use gltf::json::material::AlphaMode;
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};
use std::collections::HashMap;
use std::path::Path;

/// The materials that primitives have used so far.
pub struct Materials<'a> {
    path: &'a Path,
    root: &'a Root,
    /// From the file's index (none: no material) to the scene's.
    used: HashMap<Option<usize>, u32>,
    two_sided: Vec<bool>,
    unread: Unread,
    metallic: Unread,
}

impl<'a> Materials<'a> {
    pub fn new(path: &'a Path, root: &'a Root) -> Materials<'a> {
        let (unread, metallic) = Default::default();
        Materials { path, root, used: HashMap::new(), two_sided: Vec::new(), unread, metallic }
    }

    /// The scene's index of a material that the primitive at `place` uses.
    pub fn used(&mut self, material: Option<Index<gltf::json::Material>>, scene: &mut Scene, place: &str) -> u32 {
        let index = material.map(|m| m.value());
        if let Some(&known) = self.used.get(&index) {
            return known;
        }
        let made = match index {
            Some(m) => self.make(m, &mut scene.warnings),
            None => {
                let file = self.path.display();
                let warning =
                    format!("{file}: {place} has no material and is taken for {GREY} grey; give it one in the modeller");
                scene.warnings.push(warning);
                self.two_sided.push(false);
                Material::new("default", [GREY; 3], [0.0; 3])
            }
        };
        scene.material_places.push(match index {
            Some(m) => format!("{}: materials[{m}]", self.path.display()),
            None => format!("{}: {place}", self.path.display()),
        });
        scene.materials.push(made);
        let known = scene.materials.len() as u32 - 1;
        self.used.insert(index, known);
        known
    }

    /// Whether a material of the scene is for both sides.
    pub fn is_two_sided(&self, material: u32) -> bool {
        self.two_sided[material as usize]
    }

    /// Tells what was not read.
    pub fn warn(&self, warnings: &mut Vec<String>) {
        self.unread.warn(self.path, warnings);
        let cure = "the base colour of a metal is a mirror's; give it a diffuse material";
        self.metallic.warn_as(self.path, "metals are taken for diffuse", cure, warnings);
    }

    fn make(&mut self, index: usize, warnings: &mut Vec<String>) -> Material {
        let m = &self.root.materials[index];
        let name = m.name.clone().unwrap_or_else(|| format!("materials[{index}]"));
        let pbr = &m.pbr_metallic_roughness;
        let place = format!("materials[{index}] '{name}'");
        for (there, what) in [
            (pbr.base_color_texture.is_some(), "baseColorTexture"),
            (pbr.metallic_roughness_texture.is_some(), "metallicRoughnessTexture"),
            (m.normal_texture.is_some(), "normalTexture"),
            (m.occlusion_texture.is_some(), "occlusionTexture"),
            (m.emissive_texture.is_some(), "emissiveTexture"),
            (m.alpha_mode != Checked::Valid(AlphaMode::Opaque), "transparency (alphaMode)"),
        ] {
            if there {
                self.unread.add(what, &place);
            }
        }
        // An ideal mirror: a metal that is not rough, and is no lamp. Without a texture that says otherwise.
        let smooth = pbr.metallic_factor.0 == 1.0 && pbr.roughness_factor.0 == 0.0 && pbr.metallic_roughness_texture.is_none();
        let mirror = smooth && m.emissive_factor.0 == [0.0; 3];
        if pbr.metallic_factor.0 > 0.0 && !mirror {
            self.metallic.add(&format!("'{name}'"), format_args!("metallicFactor {}", pbr.metallic_factor.0));
        }
        let strength =
            m.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |s| s.emissive_strength.0 as f64);
        let [r, g, b, _] = pbr.base_color_factor.0.map(f64::from);
        let place = format!("{}: materials[{index}]", self.path.display());
        let reflectance = not_quite_one([r, g, b], &name, &place, warnings);
        self.two_sided.push(m.double_sided);
        if mirror {
            return Material::new_mirror(&name, grey_mirror(reflectance, &name, &place, warnings));
        }
        Material::new(&name, reflectance, m.emissive_factor.0.map(|e| e as f64 * strength))
    }
}
