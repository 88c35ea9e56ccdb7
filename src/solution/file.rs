//! `solution.rcell`: everything a query or a new solve needs, and nothing that differs between two
//! bakes of one seed (no timings, no goal, no adapter, no path).

use super::{Baked, Solution, check, sections};
use crate::effects::Switches;
use crate::error::Result;
use crate::layout::{Node, NodeLight};
use crate::network::candidates::worth_marking;
use crate::network::nodes::surface_of;
use crate::output::rcell::{self, Container, Section};
use crate::output::report::{EstimatedError, RelitReport, Report, Seconds};
use crate::params::{Mode, Params};
use crate::scene::{Environment, Face, Geometry, Light, Map, Material, Scene, SkyMap, Space, Texels, Texture};
use crate::twin::winner::Feature;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The caller's part of the container's header.
#[derive(Serialize, Deserialize)]
struct Header {
    content: String,
    name: String,
    /// In flatland: how high its walls are drawn, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    flatland: Option<f64>,
    /// What the medium absorbs, 1/m.
    #[serde(default, skip_serializing_if = "is_zero")]
    absorption: f64,
    materials: Vec<MaterialEntry>,
    /// Textures, whose texels are sections; in files without them: none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    textures: Vec<TextureEntry>,
    objects: Vec<String>,
    /// Effects that were switched by hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    effects: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    lights: Vec<Light>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    environment: Option<EnvironmentEntry>,
    params: Params,
    /// How the scene was prepared: triangles, planar pieces and tiles, to tell a version that does it otherwise.
    prepared: [u32; 3],
    report: Report,
    /// Where it was relit: its bake. The bake's light has a section of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    baked: Option<BakedEntry>,
}

#[derive(Serialize, Deserialize)]
struct BakedEntry {
    materials: Vec<MaterialEntry>,
    of: Vec<u32>,
    error: Option<EstimatedError>,
}

#[derive(Serialize, Deserialize)]
struct MaterialEntry {
    name: String,
    reflectance: [f64; 3],
    emission: [f64; 3],
    #[serde(default, skip_serializing_if = "is_zero")]
    mirror: f64,
    /// Of reflectance, emission and alpha.
    #[serde(default, skip_serializing_if = "Maps::is_empty")]
    maps: Maps,
}

/// What is not there is not written.
fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

impl MaterialEntry {
    fn all(materials: &[Material]) -> Vec<MaterialEntry> {
        materials.iter().map(material_entry).collect()
    }

    fn read(all: Vec<MaterialEntry>) -> Vec<Material> {
        all.into_iter().map(material).collect()
    }
}

/// A material's maps, where it has some.
#[derive(Default, Serialize, Deserialize)]
struct Maps {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reflectance: Option<MapEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    emission: Option<MapEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    alpha: Option<MapEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cutoff: Option<f64>,
}

impl Maps {
    fn is_empty(&self) -> bool {
        self.reflectance.is_none() && self.emission.is_none() && self.alpha.is_none()
    }
}

#[derive(Serialize, Deserialize)]
struct EnvironmentEntry {
    radiance: [f64; 3],
    rotation: f64,
    /// Width and height of the map in section 'sky'.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    map: Option<[u32; 2]>,
}

#[derive(Serialize, Deserialize)]
struct MapEntry {
    texture: u32,
    transform: [[f64; 3]; 2],
    clamp: [bool; 2],
}

/// How a texture's texels are stored.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Depth {
    Srgb,
    Linear,
    Float,
}

#[derive(Serialize, Deserialize)]
struct TextureEntry {
    name: String,
    width: u32,
    height: u32,
    depth: Depth,
}

fn map_entry(map: Map) -> MapEntry {
    MapEntry { texture: map.texture, transform: map.transform, clamp: map.clamp }
}

fn map(entry: MapEntry) -> Map {
    Map { texture: entry.texture, transform: entry.transform, clamp: entry.clamp }
}

fn material_entry(m: &Material) -> MaterialEntry {
    let maps = Maps {
        reflectance: m.reflectance_map.map(map_entry),
        emission: m.emission_map.map(map_entry),
        alpha: m.alpha_map.map(map_entry),
        cutoff: m.alpha_map.map(|_| m.alpha_cutoff),
    };
    MaterialEntry { name: m.name.clone(), reflectance: m.reflectance, emission: m.emission, mirror: m.mirror, maps }
}

fn material(entry: MaterialEntry) -> Material {
    let plain = Material::new(&entry.name, entry.reflectance, entry.emission);
    Material {
        mirror: entry.mirror,
        reflectance_map: entry.maps.reflectance.map(map),
        emission_map: entry.maps.emission.map(map),
        alpha_map: entry.maps.alpha.map(map),
        alpha_cutoff: entry.maps.cutoff.unwrap_or(plain.alpha_cutoff),
        ..plain
    }
}

/// The name of a texture's section.
fn section_of(texture: usize) -> String {
    format!("texture{texture}")
}

/// What the header says it holds.
const CONTENT: &str = "solution";

impl Solution {
    /// Writes the solution with its scene: whoever has the file can query it, elsewhere and later.
    /// Same bake, same bytes. Errors: [`crate::Error::Write`].
    pub fn save(&self, path: &Path) -> Result<()> {
        let name = Path::new(&self.scene.name).file_name().map_or(self.scene.name.clone(), |n| n.to_string_lossy().into_owned());
        let mut report = Report {
            adapter: None,
            seconds: Seconds::default(),
            target: None,
            memory_bytes: Default::default(),
            extra: Default::default(),
            ..self.report.clone()
        };
        report.scene.path = name.clone();
        report.relit = report.relit.map(|relit| RelitReport { from: None, seconds: None, ..relit });
        report.effects.iter_mut().flatten().for_each(|effect| effect.seconds = None);
        let header = Header {
            content: CONTENT.into(),
            name,
            flatland: match self.scene.space {
                Space::Solid => None,
                Space::Flatland { height } => Some(height),
            },
            absorption: self.scene.absorption,
            materials: MaterialEntry::all(&self.scene.materials),
            textures: (self.scene.textures.iter())
                .map(|t| TextureEntry {
                    // No path: the same bake elsewhere has the same bytes.
                    name: Path::new(&t.name).file_name().map_or(t.name.clone(), |n| n.to_string_lossy().into_owned()),
                    width: t.width,
                    height: t.height,
                    depth: match t.texels {
                        Texels::Srgb(_) => Depth::Srgb,
                        Texels::Linear(_) => Depth::Linear,
                        Texels::Float(_) => Depth::Float,
                    },
                })
                .collect(),
            objects: self.scene.objects.clone(),
            effects: (self.scene.effects != Switches::default()).then(|| self.scene.effects.to_string()),
            lights: self.scene.lights.clone(),
            environment: self.scene.environment.as_ref().map(|e| EnvironmentEntry {
                radiance: e.radiance,
                rotation: e.rotation,
                map: e.map.as_ref().map(|m| [m.width, m.height]),
            }),
            params: self.params.clone(),
            prepared: prepared(&self.geometry),
            report,
            baked: self.baked.as_ref().map(|b| BakedEntry {
                materials: MaterialEntry::all(&b.materials),
                of: b.of.clone(),
                error: b.error.clone(),
            }),
        };
        let faces: Vec<[u32; 5]> =
            (self.scene.faces.iter()).map(|f| [f.vertices[0], f.vertices[1], f.vertices[2], f.material, f.object]).collect();
        let sections = [
            Section::new("vertices", &self.scene.vertices),
            Section::new("faces", &faces),
            Section::new("nodes", &self.surface.nodes),
            Section::new("light", &self.light),
            Section::new("cells", &self.cells),
        ];
        let baked = self.baked.as_ref().map(|b| Section::new("baked_light", &b.light));
        let map = self.scene.environment.as_ref().and_then(|e| e.map.as_ref()).map(|m| Section::new("sky", &m.rgb));
        let names: Vec<String> = (0..self.scene.textures.len()).map(section_of).collect();
        let texels = self.scene.textures.iter().zip(&names).map(|(t, name)| match &t.texels {
            Texels::Srgb(t) | Texels::Linear(t) => Section::new(name, t),
            Texels::Float(t) => Section::new(name, t),
        });
        let uvs = [Section::new("uvs", &self.scene.uvs), Section::new("face_uvs", &self.scene.face_uvs)];
        let uvs = uvs.into_iter().filter(|_| !names.is_empty());
        let more: Vec<Section> = baked.into_iter().chain(map).chain(uvs).chain(texels).collect();
        rcell::write(path, &header, &[&sections[..], &sections::of(&self.system), &more].concat())
    }

    /// Reads a solution that [`Solution::save`] has written, checking all of it.
    ///
    /// Errors: [`crate::Error::Read`]; [`crate::Error::Format`] where the file is no solution, damaged, or of another version.
    pub fn load(path: &Path) -> Result<Solution> {
        Self::from_container(rcell::read(path)?)
    }

    /// As [`Solution::load`], from memory; `path` names it in messages.
    pub fn from_bytes(bytes: Vec<u8>, path: &Path) -> Result<Solution> {
        Self::from_container(rcell::parse(bytes, path)?)
    }

    fn from_container(file: Container) -> Result<Solution> {
        let fail = |what: String| file.fail(&what);
        let header: Header = file.header(CONTENT)?;
        header.params.check().map_err(|e| fail(format!("the parameters cannot be used: {e}")))?;

        // The scene, prepared as it was for the bake.
        let faces: Vec<[u32; 5]> = file.get("faces")?;
        let environment = match header.environment {
            None => None,
            Some(e) => {
                let map = e.map.map(|[width, height]| Ok(SkyMap { width, height, rgb: file.get("sky")? })).transpose()?;
                Some(Environment { radiance: e.radiance, map, rotation: e.rotation })
            }
        };
        let scene = Scene {
            name: header.name,
            space: header.flatland.map_or(Space::Solid, |height| Space::Flatland { height }),
            vertices: file.get("vertices")?,
            faces: faces.iter().map(|&[a, b, c, material, object]| Face { vertices: [a, b, c], material, object }).collect(),
            materials: MaterialEntry::read(header.materials),
            uvs: if header.textures.is_empty() { Vec::new() } else { file.get("uvs")? },
            face_uvs: if header.textures.is_empty() { Vec::new() } else { file.get("face_uvs")? },
            textures: (header.textures.into_iter().enumerate())
                .map(|(i, t)| {
                    let texels = match t.depth {
                        Depth::Srgb => Texels::Srgb(file.get(&section_of(i))?),
                        Depth::Linear => Texels::Linear(file.get(&section_of(i))?),
                        Depth::Float => Texels::Float(file.get(&section_of(i))?),
                    };
                    Ok(Texture { name: t.name, width: t.width, height: t.height, texels })
                })
                .collect::<Result<_>>()?,
            objects: header.objects,
            effects: header.effects.as_deref().unwrap_or("auto").parse().map_err(|e| fail(format!("its effects: {e}")))?,
            lights: header.lights,
            environment,
            absorption: header.absorption,
            ..Scene::default()
        };
        if scene.faces.iter().any(|f| f.object as usize >= scene.objects.len()) {
            return Err(fail("section 'faces' names an object that is not there".into()));
        }
        let geometry = Geometry::for_bake(&scene, &header.params).map_err(|e| fail(format!("the scene cannot be used: {e}")))?;
        if prepared(&geometry) != header.prepared {
            return Err(fail("the scene is prepared otherwise by this version".into()));
        }

        // The network.
        let nodes: Vec<Node> = file.get("nodes")?;
        let light: Vec<NodeLight> = file.get("light")?;
        let cells: Vec<Feature> = file.get("cells")?;
        let system = sections::read(&file)?;
        // The coefficients of a learned kernel are not by cells.
        let speaking = if header.params.mode == Mode::Paper { usize::MAX } else { system.source.len() };
        check::nodes(&geometry, &nodes)
            .and_then(|()| check::light(&light, nodes.len()))
            .and_then(|()| check::system(&geometry, &system, nodes.len()))
            .and_then(|()| check::cells(&cells, speaking))
            .map_err(|what| file.fail(what))?;
        let surface = surface_of(&geometry, nodes, header.params.lambda as f32, worth_marking(&geometry, header.params.rays));
        let baked = match header.baked {
            None => None,
            Some(entry) => {
                let light: Vec<NodeLight> = file.get("baked_light")?;
                check::light(&light, surface.nodes.len()).map_err(|what| file.fail(what))?;
                let baked = Baked { materials: MaterialEntry::read(entry.materials), of: entry.of, light, error: entry.error };
                if baked.of.len() != scene.materials.len() || baked.of.iter().any(|&m| m as usize >= baked.materials.len()) {
                    return Err(fail("the materials of its bake do not fit its own".into()));
                }
                baked.scene(&scene).check().map_err(|e| fail(format!("the scene of its bake cannot be used: {e}")))?;
                Some(baked)
            }
        };
        Ok(Solution { scene, geometry, params: header.params, surface, light, cells, system, report: header.report, baked })
    }
}

fn prepared(geometry: &Geometry) -> [u32; 3] {
    [geometry.tris.len() as u32, geometry.pieces, geometry.tiles]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::Backend;
    use crate::error::Error;
    use crate::progress::Flow;
    use crate::solution::SurfacePoint;

    fn baked(seed: u32) -> Solution {
        let scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell/scene.obj")).unwrap();
        let params = Params { rays: 4096, seed, direct_samples: 64, gather_rays: 16, ..Params::default() };
        crate::bake(&Backend::Cpu, &scene, &params, &mut |_| Flow::Continue).unwrap()
    }

    #[test]
    fn a_loaded_solution_answers_as_the_saved_one() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.rcell");
        let solution = baked(1);
        solution.save(&path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let loaded = Solution::load(&path).unwrap();
        let points: Vec<SurfacePoint> =
            (0..50).map(|i| SurfacePoint { p: [0.1 * i as f64, 0.0, 0.3], n: [0.0, 1.0, 0.0] }).collect();
        let answers = solution.query(&Backend::Cpu, &points).unwrap();
        assert_eq!(loaded.query(&Backend::Cpu, &points).unwrap(), answers);
        assert!(answers.iter().filter(|a| a.b[0] > 0.0).count() > 40);
        assert_eq!((loaded.report().seed, &loaded.report().energy), (1, &solution.report().energy));
        assert_eq!(loaded.system().cell_links, solution.system().cell_links);

        // What is loaded is saved as it was; the same seed bakes the same bytes, another one others.
        loaded.save(&path).unwrap();
        assert!(std::fs::read(&path).unwrap() == bytes);
        baked(1).save(&path).unwrap();
        assert!(std::fs::read(&path).unwrap() == bytes);
        baked(2).save(&path).unwrap();
        assert!(std::fs::read(&path).unwrap() != bytes);
        assert!(!String::from_utf8_lossy(&bytes).contains(env!("CARGO_MANIFEST_DIR")), "no path of this machine");
    }

    #[test]
    fn a_whole_file_that_makes_no_sense_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.rcell");
        let good = baked(1);
        let refuses = |name: &str, spoil: &dyn Fn(&mut Solution)| {
            let mut s = good.clone();
            spoil(&mut s);
            s.save(&path).unwrap();
            match Solution::load(&path) {
                Err(Error::Format { .. }) => (),
                other => panic!("{name}: {:?}", other.map(|_| "was read")),
            }
        };
        refuses("vertex", &|s| s.scene.vertices[3][1] = f64::NAN);
        refuses("face", &|s| s.scene.faces[0].vertices[2] = 9999);
        refuses("material of a face", &|s| s.scene.faces[0].material = 9999);
        refuses("object of a face", &|s| s.scene.faces[0].object = 9999);
        refuses("no faces", &|s| s.scene.faces.clear());
        refuses("another scene", &|s| s.scene.faces.truncate(30));
        refuses("reflectance", &|s| s.scene.materials[0].reflectance[0] = 1.5);
        refuses("parameters", &|s| s.params.slots = 0);
        refuses("node's plane", &|s| s.surface.nodes[0].plane = 9999);
        refuses("node's material", &|s| s.surface.nodes[0].material = 9999);
        refuses("node", &|s| s.surface.nodes[0].p[0] = f32::INFINITY);
        refuses("number of nodes", &|s| s.surface.nodes.truncate(5));
        refuses("light", &|s| s.light[0].g1[2] = f32::NAN);
        refuses("number of lights", &|s| s.light.truncate(5));
        refuses("cell", &|s| s.cells[0][0] = f32::NAN);
        refuses("source", &|s| s.system.source[0][0] = f32::NAN);
        refuses("gather link", &|s| s.system.cell_links[0].other = 9999);
        refuses("deposit link", &|s| s.system.node_links[0].value = f32::NAN);
        refuses("offsets", &|s| s.system.node_offsets[1] = u32::MAX);
        refuses("no offsets", &|s| s.system.cell_offsets.clear());
        refuses("plane", &|s| s.system.planes[0].material = 9999);
        refuses("node source", &|s| s.system.node_source[0].h[0] = f32::NAN);
        refuses("number of node sources", &|s| s.system.node_source.truncate(5));
        refuses("number of planes", &|s| s.system.planes.truncate(5));
        // A container with something else in it.
        rcell::write(&path, &serde_json::json!({"content": "texture"}), &[]).unwrap();
        assert!(matches!(Solution::load(&path), Err(Error::Format { .. })));
    }
}
