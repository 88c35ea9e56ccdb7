//! Materials of a glTF file: the diffuse and the emitting part.

use super::buffers::Buffers;
use crate::scene::images::{Images, below_one};
use crate::scene::load::Reader;
use crate::scene::mtl::{GREY, grey_mirror, map_of_mirror};
use crate::scene::texture::{CUTOFF, Map, Meaning};
use crate::scene::unread::Unread;
use crate::scene::{Material, Scene};
use gltf::json::material::AlphaMode;
use gltf::json::texture::{Info, WrappingMode};
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
    images: Images,
    unread: Unread,
    metallic: Unread,
}

impl<'a> Materials<'a> {
    pub fn new(path: &'a Path, root: &'a Root) -> Materials<'a> {
        let (unread, metallic) = Default::default();
        Materials { path, root, used: HashMap::new(), two_sided: Vec::new(), images: Images::default(), unread, metallic }
    }

    /// The scene's index of a material that the primitive at `place` uses.
    pub fn used(
        &mut self,
        material: Option<Index<gltf::json::Material>>,
        buffers: &mut Buffers,
        reader: &mut Reader,
        scene: &mut Scene,
        place: &str,
    ) -> u32 {
        let index = material.map(|m| m.value());
        if let Some(&known) = self.used.get(&index) {
            return known;
        }
        let made = match index {
            Some(m) => self.make(m, buffers, reader, scene),
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

    /// A texture of a material as a map; none where it cannot be had.
    fn map(
        &mut self,
        info: &Info,
        place: &str,
        instead: &str,
        buffers: &mut Buffers,
        reader: &mut Reader,
        scene: &mut Scene,
    ) -> Option<Map> {
        let texture = &self.root.textures[info.index.value()];
        let source = texture.source.value();
        let image = self.root.images.get(source)?;
        // What is no file is known by its place.
        let name = match image.uri.as_deref().filter(|uri| !uri.starts_with("data:")) {
            Some(uri) => uri.to_string(),
            None => format!("images[{source}]"),
        };
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        if transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord) != 0 {
            self.unread.add("texture coordinates other than TEXCOORD_0", place);
            return None;
        }
        let file = format!("{}: {place}", self.path.display());
        let number = self.images.take(&name, Meaning::Colour, || buffers.image(source, reader), &file, instead, scene)?;
        let mut map = Map::new(number);
        if let Some(t) = transform {
            let (s, c) = f64::from(t.rotation.0).sin_cos();
            let ([x, y], [ox, oy]) = (t.scale.0.map(f64::from), t.offset.0.map(f64::from));
            // KHR_texture_transform: offset after rotation after scale.
            map.transform = [[c * x, s * y, ox], [-s * x, c * y, oy]];
        }
        if let Some(sampler) = texture.sampler {
            let sampler = &self.root.samplers[sampler.value()];
            map.clamp = [sampler.wrap_s, sampler.wrap_t].map(|w| w == Checked::Valid(WrappingMode::ClampToEdge));
            if [sampler.wrap_s, sampler.wrap_t].contains(&Checked::Valid(WrappingMode::MirroredRepeat)) {
                self.unread.add("mirrored repeat of a texture (it is repeated as it is)", place);
            }
        }
        Some(map)
    }

    fn make(&mut self, index: usize, buffers: &mut Buffers, reader: &mut Reader, scene: &mut Scene) -> Material {
        let m = &self.root.materials[index];
        let name = m.name.clone().unwrap_or_else(|| format!("materials[{index}]"));
        let pbr = &m.pbr_metallic_roughness;
        let place = format!("materials[{index}] '{name}'");
        for (there, what) in [
            (pbr.metallic_roughness_texture.is_some(), "metallicRoughnessTexture"),
            (m.normal_texture.is_some(), "normalTexture"),
            (m.occlusion_texture.is_some(), "occlusionTexture"),
            (m.alpha_mode == Checked::Valid(AlphaMode::Blend), "transparency (alphaMode BLEND)"),
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
        let [r, g, b, alpha] = pbr.base_color_factor.0.map(f64::from);
        let mut map =
            |info: Option<&Info>, instead: &str, scene: &mut Scene| self.map(info?, &place, instead, buffers, reader, scene);
        let reflectance_map = map(pbr.base_color_texture.as_ref(), "its factor is taken alone", scene);
        let emission_map = map(m.emissive_texture.as_ref(), "its factor is taken alone", scene);
        let mask = m.alpha_mode == Checked::Valid(AlphaMode::Mask);
        let cutoff = m.alpha_cutoff.as_ref().map_or(CUTOFF, |c| f64::from(c.0));
        let alpha_map = reflectance_map.filter(|_| mask);
        if mask && reflectance_map.is_none() {
            self.unread.add("alphaMode MASK without a texture", &place);
        }
        let place = format!("{}: materials[{index}]", self.path.display());
        let reflectance = below_one([r, g, b], reflectance_map.filter(|_| !mirror), &name, &place, scene);
        self.two_sided.push(m.double_sided);
        // Where the factor is 0 nothing reaches a cutoff above it.
        let alpha_cutoff = if alpha > 0.0 {
            cutoff / alpha
        } else if cutoff > 0.0 {
            f64::from(f32::MAX)
        } else {
            0.0
        };
        if mirror {
            if reflectance_map.is_some() {
                scene.warnings.push(map_of_mirror(&name, &place, "baseColorTexture"));
            }
            let mirror = grey_mirror(reflectance, &name, &place, &mut scene.warnings);
            return Material { alpha_map, alpha_cutoff, ..Material::new_mirror(&name, mirror) };
        }
        let plain = Material::new(&name, reflectance, m.emissive_factor.0.map(|e| e as f64 * strength));
        Material { reflectance_map, emission_map, alpha_map, alpha_cutoff, ..plain }
    }
}
