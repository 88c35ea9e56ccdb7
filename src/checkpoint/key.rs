//! Which bake a checkpoint is of: everything that its contents depend on.

use crate::effects::Switches;
use crate::engine::Backend;
use crate::params::{Method, Mode, Params};
use crate::scene::{Geometry, Scene};
use bytemuck::Pod;
use serde::{Deserialize, Serialize};

/// What a bake's results depend on. Kept in the file in words where words can say what differs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Key {
    /// Version of raycell.
    raycell: String,
    /// Digest of the triangles, as prepared, and of the objects they make up.
    triangles: String,
    /// Digest of reflectances and emissions.
    materials: String,
    /// Effects that were switched by hand; of older files none.
    #[serde(default)]
    effects: String,
    /// Digest of the sky and of lights without a surface; none where there are none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lights: Option<String>,
    /// What the medium absorbs, 1/m.
    #[serde(default)]
    absorption: f64,
    /// Adapter and driver, or cpu: another one rounds otherwise.
    device: String,
    params: Params,
}

impl Key {
    /// The key of a bake.
    pub fn new(backend: &Backend, scene: &Scene, geometry: &Geometry, params: &Params) -> Key {
        let device = match backend {
            Backend::Cpu => "cpu".into(),
            Backend::Gpu(gpu) => {
                let i = gpu.device.adapter_info();
                format!("{} ({:?}, {} {})", i.name, i.backend, i.driver, i.driver_info)
            }
        };
        // Warnings name objects.
        let objects: Vec<u32> = scene.faces.iter().map(|f| f.object).collect();
        let names = scene.objects.join("\n");
        Key {
            raycell: env!("CARGO_PKG_VERSION").into(),
            triangles: digest(&[bytes(&geometry.tris), bytes(&[geometry.scale]), bytes(&objects), names.as_bytes()]),
            materials: digest(&[bytes(&geometry.materials), bytes(&[geometry.emission_scale]), bytes(&geometry.texels)]),
            effects: if scene.effects == Switches::default() { String::new() } else { scene.effects.to_string() },
            lights: (geometry.is_surfaceless())
                .then(|| digest(&[bytes(&geometry.sky.texels), bytes(&geometry.lights.all), bytes(&[geometry.lights.suns])])),
            absorption: scene.absorption,
            device,
            params: params.clone(),
        }
    }

    /// Parameters of the bake.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Rays of the bake.
    pub fn rays(&self) -> u32 {
        self.params.rays
    }

    /// Whether the bake trains a network of light rays: other methods have no such cells.
    pub fn is_network(&self) -> bool {
        self.params.method == Method::Network && self.params.mode == Mode::Flux
    }

    /// What the first difference is, in words; none where the keys agree.
    pub fn difference(&self, now: &Key) -> Option<String> {
        let changed = |what: &str, then: &str, now: &str| Some(format!("{what} was {then} and is {now}"));
        if self.raycell != now.raycell {
            return changed("raycell's version", &self.raycell, &now.raycell);
        }
        if self.device != now.device {
            return changed("the device", &self.device, &now.device);
        }
        if self.effects != now.effects {
            let words = |effects: &str| if effects.is_empty() { "auto".to_string() } else { effects.into() };
            return changed("--effects", &words(&self.effects), &words(&now.effects));
        }
        if self.triangles != now.triangles {
            return Some("the scene's triangles, mirrors or its objects' names have changed".into());
        }
        if self.absorption != now.absorption {
            let per_metre = |x: f64| format!("{x} /m");
            return changed("the medium's absorption", &per_metre(self.absorption), &per_metre(now.absorption));
        }
        let words = |p: &Params| serde_json::to_value(p).unwrap_or_default();
        let (then, params) = (words(&self.params), words(&now.params));
        // What a parameter's default leaves out is in one of both only.
        let mut names = then.as_object().into_iter().chain(params.as_object()).flat_map(|object| object.keys());
        if let Some(name) = names.find(|&name| then[name] != params[name]) {
            return changed(name, &then[name].to_string(), &params[name].to_string());
        }
        // After the parameters: the norm is in the materials too; and lights before: their scale is.
        if self.lights != now.lights {
            return Some("the scene's lights or its environment have changed".into());
        }
        (self.materials != now.materials).then(|| "the scene's materials have changed".into())
    }
}

pub(crate) fn bytes<T: Pod>(records: &[T]) -> &[u8] {
    bytemuck::cast_slice(records)
}

/// FNV-1a over 64 bits: tells a changed scene from the same one, and stays what it is from compiler to
/// compiler, unlike std's hashes.
pub(crate) fn digest(parts: &[&[u8]]) -> String {
    let hash =
        parts.iter().copied().flatten().fold(0xcbf2_9ce4_8422_2325u64, |h, &b| (h ^ b as u64).wrapping_mul(0x100_0000_01b3));
    format!("{hash:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Norm;
    use crate::scene::{Material, Scene};

    #[test]
    fn every_difference_is_named() {
        let scene = |z: f64, kd: f64| {
            let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, z]];
            Scene::from_triangles("s", &[(corners, 0)], vec![Material::new("m", [kd; 3], [1.0; 3])]).unwrap()
        };
        let key = |z, kd, params: Params| {
            let scene = scene(z, kd);
            Key::new(&Backend::Cpu, &scene, &Geometry::new(&scene).unwrap(), &params)
        };
        let base = key(0.0, 0.5, Params::default());
        let differs = |other: Key, part: &str| {
            let said = base.difference(&other).expect(part);
            assert!(said.contains(part), "{said}");
        };
        assert_eq!(base.difference(&key(0.0, 0.5, Params::default())), None);
        differs(key(1e-6, 0.5, Params::default()), "triangles");
        differs(key(0.0, 0.500001, Params::default()), "materials");
        differs(key(0.0, 0.5, Params { rays: 2048, ..Params::default() }), "rays was 524288 and is 2048");
        differs(key(0.0, 0.5, Params { norm: Norm::Paper1997, ..Params::default() }), "norm was null and is \"paper1997\"");
        differs(key(0.0, 0.5, Params { cells: Some(99), ..Params::default() }), "cells was null and is 99");
        differs(Key { absorption: 0.5, ..base.clone() }, "the medium's absorption was 0 /m and is 0.5 /m");
        differs(Key { device: "abacus".into(), ..base.clone() }, "the device was cpu and is abacus");
        differs(Key { raycell: "0.0.0".into(), ..base.clone() }, "version");
        let mut lit = scene(0.0, 0.5);
        lit.environment = Some(crate::scene::Environment::constant([1.0; 3]));
        differs(Key::new(&Backend::Cpu, &lit, &Geometry::new(&lit).unwrap(), &Params::default()), "environment");
        let back: Key = serde_json::from_str(&serde_json::to_string(&base).unwrap()).unwrap();
        assert_eq!(back, base);
    }
}
