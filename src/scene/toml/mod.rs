//! `.toml` scenes: files put together and placed, meshes written out, materials by name, cameras.

mod document;
mod lights;

use super::images::{Images, below_one, find};
use super::load::{Kind, Reader, Up, kind, place};
use super::mtl::GREY;
use super::polygon::{Cut, cut};
use super::text::decode;
use super::texture::check_uv;
use super::texture::{Channel, Map, Meaning};
use super::transform::{self, From};
use super::unread::Unread;
use super::{Face, Material, Scene, Space, View, fits, gltf, obj, sides};
use crate::error::{Error, Result};
use crate::layout::NONE;
use crate::solution;
use document::{Document, Side, Values};
use glam::{DMat4, DQuat, DVec3, EulerRot};
use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;

/// Luminous efficacy of a watt of white light, lm/W, as Radiance takes it.
const EFFICACY: f64 = 179.0;
/// Share of red, green and blue in luminance, Rec.709.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Reads a TOML scene with the files it names.
///
/// Errors: [`Error::Format`], [`Error::InvalidVertex`] and [`Error::IndexOutOfRange`] with file and line, and
/// those of the files it names.
pub fn read(path: &Path, reader: &mut Reader) -> Result<Scene> {
    let text = decode(reader.read(path)?);
    let document: Document = toml::from_str(&text).map_err(|e| Error::Format {
        path: path.into(),
        line: e.span().map(|s| line_of(&text, s)),
        what: e.message().trim().replace('\n', ", "),
        cure: "docs/scenes.md lists the tables and keys".into(),
    })?;
    let at = Place { path, text: &text };
    let mut scene = Scene { name: path.display().to_string(), ..Scene::default() };

    // Files, placed; then meshes.
    let overridden: Vec<String> = document
        .material
        .iter()
        .map(|m| m.as_ref())
        .filter(|m| m.reflectance.is_some() || m.reflectance_map.is_some() || m.mirror.is_some())
        .map(|m| m.name.clone())
        .collect();
    for entry in &document.file {
        let from = From::end(&scene);
        file(&at, entry.span(), entry.as_ref(), &overridden, reader, &mut scene)?;
        at.finite(entry.span(), "file", &entry.as_ref().path, &scene, from.vertices)?;
    }
    let mut crossing = Unread::default();
    for entry in &document.mesh {
        let from = From::end(&scene);
        mesh(&at, entry.span(), entry.as_ref(), &overridden, &mut scene, &mut crossing)?;
        at.finite(entry.span(), "mesh", &entry.as_ref().name, &scene, from.vertices)?;
    }
    if let Some(first) = document.segment.first() {
        if !document.file.is_empty() || !document.mesh.is_empty() {
            return Err(at.fault(first.span(), "is a flatland segment beside files or meshes; a scene has one kind or the other"));
        }
        if reader.options.up != Up::Y {
            return Err(at.fault(first.span(), "lies in flatland, which has no upward axis to choose; leave --up away"));
        }
        scene.space = Space::Flatland { height: 0.0 };
    }
    for entry in &document.segment {
        let from = From::end(&scene);
        segment(&at, entry.span(), entry.as_ref(), &overridden, &mut scene)?;
        at.finite(entry.span(), "segment", &entry.as_ref().name, &scene, from.vertices)?;
    }
    let height = document.height.as_ref().map(|h| (*h.as_ref(), h.span()));
    match (&mut scene.space, height) {
        (Space::Solid, Some((_, span))) => {
            return Err(at.fault(span, "is the height of flatland's walls, and there is no [[segment]]"));
        }
        (Space::Flatland { .. }, Some((height, span))) if !(height > 0.0 && height.is_finite()) => {
            return Err(at.fault(span, &format!("is a height of {height}; give metres, more than 0")));
        }
        (Space::Flatland { height }, Some((given, _))) => *height = given,
        (Space::Flatland { .. }, None) => scene.space = Space::Flatland { height: scene.wall_height() },
        (Space::Solid, None) => {}
    }
    crossing.warn_as(path, "cut into triangles that overlap", "give triangles", &mut scene.warnings);

    // Materials by name; lumens last, when all areas are known.
    let two_sided = |name: &str| document.material.iter().any(|m| m.as_ref().two_sided && m.as_ref().name == name);
    let names: Vec<bool> = scene.materials.iter().map(|m| two_sided(&m.name)).collect();
    sides::mirror(&mut scene, |face| reader.options.two_sided || names[face.material as usize]);
    let mut images = Images::default();
    for entry in &document.material {
        material(&at, entry.span(), entry.as_ref(), &mut images, reader, &mut scene)?;
    }
    if let Some(medium) = &document.medium {
        scene.absorption = medium.as_ref().absorption;
        if !(scene.absorption >= 0.0 && scene.absorption.is_finite()) {
            let what = format!("is a medium of absorption {}; give 1/m, 0 or more", scene.absorption);
            return Err(at.fault(medium.span(), &what));
        }
    }
    for entry in &document.camera {
        let c = entry.as_ref();
        // Flatland's walls stand on the plane z = 0.
        let up = c.up.unwrap_or(if scene.is_flatland() { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] });
        let camera =
            solution::Camera { eye: c.eye, target: c.target, up, vfov_degrees: c.vfov, width: c.width, height: c.height };
        camera.check().map_err(|e| at.fault(entry.span(), &format!("camera '{}' cannot be used: {e}", c.name)))?;
        scene.cameras.push(View { name: c.name.clone(), camera });
    }
    for entry in &document.light {
        let light = lights::light(&at, entry.span(), entry.as_ref(), scene.is_flatland())?;
        scene.lights.push(light);
    }
    if let Some(entry) = &document.environment {
        scene.environment = Some(lights::environment(&at, entry.span(), entry.as_ref(), scene.is_flatland(), reader)?);
    }
    Ok(scene)
}

/// The line of a place in a text, from 1.
fn line_of(text: &str, span: Range<usize>) -> usize {
    text.bytes().take(span.start).filter(|&b| b == b'\n').count() + 1
}

/// Where things are said, for messages.
struct Place<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Place<'_> {
    fn name(&self, span: Range<usize>) -> String {
        format!("{}:{}", self.path.display(), line_of(self.text, span))
    }

    fn fault(&self, span: Range<usize>, what: &str) -> Error {
        let cure = "correct the table that begins there".into();
        Error::Format { path: self.path.into(), line: Some(line_of(self.text, span)), what: what.into(), cure }
    }

    /// Checks that the vertices from `first` on are numbers.
    fn finite(&self, span: Range<usize>, kind: &str, name: &str, scene: &Scene, first: usize) -> Result<()> {
        match scene.vertices[first..].iter().position(|v| !fits(v)) {
            Some(index) => Err(Error::InvalidVertex {
                place: format!("{}: {kind} '{name}'", self.name(span)),
                index,
                value: scene.vertices[first + index],
            }),
            None => Ok(()),
        }
    }
}

/// Reads a file, places it, and adds it to the scene.
fn file(
    at: &Place,
    span: Range<usize>,
    entry: &document::File,
    overridden: &[String],
    reader: &mut Reader,
    scene: &mut Scene,
) -> Result<()> {
    let fault = |what: &str| at.fault(span.clone(), &format!("file '{}' {what}", entry.path));
    if !(entry.unit > 0.0 && entry.unit.is_finite()) {
        return Err(fault("has a unit that is no positive number of metres"));
    }
    let matrix = match (entry.matrix, entry.scale, entry.rotate, entry.translate) {
        (None, scale, rotate, translate) => {
            let [x, y, z] = rotate.unwrap_or_default().map(f64::to_radians);
            DMat4::from_scale_rotation_translation(
                DVec3::from_array(scale.map_or([1.0; 3], document::Values::three)),
                if rotate.is_some() { DQuat::from_euler(EulerRot::XYZEx, x, y, z) } else { DQuat::IDENTITY },
                DVec3::from_array(translate.unwrap_or_default()),
            )
        }
        (Some(rows), None, None, None) => DMat4::from_cols_array_2d(&rows).transpose(),
        _ => return Err(fault("has a matrix beside scale, rotate or translate; one of both is enough")),
    };
    if !matrix.is_finite() || matrix.row(3) != glam::DVec4::W {
        return Err(fault("is moved by what is no affine matrix of finite numbers"));
    }

    let path = at.path.parent().unwrap_or(Path::new("")).join(&entry.path);
    let kd_space = reader.options.kd_space;
    reader.options.kd_space = entry.kd_space.unwrap_or(kd_space);
    let part = match kind(&path)? {
        Kind::Obj => obj::read(&path, reader, overridden),
        Kind::Gltf => gltf::read(&path, reader),
        Kind::Toml => Err(fault("is a .toml itself; name the files it is made of")),
    };
    reader.options.kd_space = kd_space;
    let mut part = part?;
    place(&mut part, entry.unit, entry.up);
    transform::apply(&mut part, From::end(&Scene::default()), matrix);
    if entry.two_sided {
        sides::mirror(&mut part, |_| true);
    }

    // Numbers of vertices, materials and objects go on where the scene's end.
    if scene.vertices.len() + part.vertices.len() > u32::MAX as usize {
        return Err(fault("brings more than 4294967295 vertices into the scene"));
    }
    let (v, m, o) = (scene.vertices.len() as u32, scene.materials.len() as u32, scene.objects.len() as u32);
    let (t, c) = (scene.textures.len() as u32, scene.uvs.len() as u32);
    for (i, corners) in part.face_uvs.iter().enumerate() {
        scene.set_uv(scene.faces.len() + i, corners.map(|k| if k == NONE { k } else { k + c }));
    }
    scene.uvs.extend(part.uvs);
    scene.textures.extend(part.textures);
    for material in &mut part.materials {
        for map in [&mut material.reflectance_map, &mut material.emission_map, &mut material.alpha_map].into_iter().flatten() {
            map.texture += t;
        }
    }
    let moved = |f: Face| Face { vertices: f.vertices.map(|i| i + v), material: f.material + m, object: f.object + o };
    scene.faces.extend(part.faces.into_iter().map(moved));
    scene.vertices.extend(part.vertices);
    scene.materials.extend(part.materials);
    scene.material_places.extend(part.material_places);
    scene.objects.extend(part.objects);
    scene.cameras.extend(part.cameras);
    scene.lights.extend(part.lights);
    scene.warnings.extend(part.warnings);
    Ok(())
}

/// The number of a material of this name; a new one is grey until a table says more.
fn material_named(at: &Place, span: Range<usize>, name: &String, overridden: &[String], scene: &mut Scene) -> u32 {
    if let Some(known) = scene.materials.iter().position(|m| m.name == *name) {
        return known as u32;
    }
    scene.materials.push(Material::new(name, [GREY; 3], [0.0; 3]));
    let place = at.name(span);
    if !overridden.contains(name) {
        scene.warnings.push(format!(
            "{place}: material '{name}' has no reflectance and is taken for {GREY} grey; add it under [[material]]"
        ));
    }
    scene.material_places.push(place);
    scene.materials.len() as u32 - 1
}

/// Adds flatland segments.
fn segment(at: &Place, span: Range<usize>, entry: &document::Segment, overridden: &[String], scene: &mut Scene) -> Result<()> {
    let count = entry.points.len();
    if count < 2 {
        return Err(at.fault(span, &format!("segment '{}' has fewer than two points", entry.name)));
    }
    let from = From::end(scene);
    let first = scene.vertices.len() as u32;
    scene.vertices.extend(entry.points.iter().map(|&[x, y]| [x, y, 0.0]));
    let material = material_named(at, span, &entry.material, overridden, scene);
    let object = scene.objects.len() as u32;
    scene.objects.push(entry.name.clone());
    for i in 0..if entry.closed { count } else { count - 1 } {
        let (a, b) = (first + i as u32, first + ((i + 1) % count) as u32);
        let [a, b] = if entry.side == Side::Left { [a, b] } else { [b, a] };
        scene.faces.push(Face { vertices: [a, b, b], material, object });
    }
    if entry.two_sided {
        let faces = from.faces..scene.faces.len();
        sides::mirror_range(scene, faces, |_| true);
    }
    Ok(())
}

/// Adds a mesh that is written out.
fn mesh(
    at: &Place,
    span: Range<usize>,
    entry: &document::Mesh,
    overridden: &[String],
    scene: &mut Scene,
    crossing: &mut Unread,
) -> Result<()> {
    let (first, count) = (scene.vertices.len(), entry.vertices.len());
    if !entry.uvs.is_empty() && entry.uvs.len() != count {
        let what = format!("mesh '{}' has {} uvs and {count} vertices; give one a vertex", entry.name, entry.uvs.len());
        return Err(at.fault(span, &what));
    }
    let first_uv = scene.uvs.len() as u32;
    scene.uvs.extend(entry.uvs.iter().map(|&[u, v]| [u, 1.0 - v]));
    for (i, uv) in scene.uvs[first_uv as usize..].iter().enumerate() {
        check_uv(uv, || format!("{}: mesh '{}', uv {i}", at.name(span.clone()), entry.name))?;
    }
    scene.vertices.extend(&entry.vertices);
    let material = material_named(at, span.clone(), &entry.material, overridden, scene);
    let object = scene.objects.len() as u32;
    scene.objects.push(entry.name.clone());
    let from = From::end(scene);
    for (f, face) in entry.faces.iter().enumerate() {
        if face.len() < 3 {
            return Err(at.fault(span, &format!("mesh '{}': face {f} has fewer than three corners", entry.name)));
        }
        if let Some(&index) = face.iter().find(|&&i| i as usize >= count) {
            let place = format!("{}: mesh '{}', face {f}", at.name(span), entry.name);
            return Err(Error::IndexOutOfRange { place, index: index as i64, count });
        }
        let (next, mut cuts) = (scene.faces.len(), Vec::new());
        let Scene { vertices, faces, .. } = scene;
        let shape = cut(face, &vertices[first..], |t| {
            faces.push(Face { vertices: t.map(|i| first as u32 + face[i]), material, object });
            cuts.push(t);
        });
        if !entry.uvs.is_empty() {
            cuts.into_iter().enumerate().for_each(|(i, t)| scene.set_uv(next + i, t.map(|c| first_uv + face[c])));
        }
        if shape == Cut::Overlapping {
            crossing.add(&format!("polygons of '{}' that cross themselves", entry.name), at.name(span.clone()));
        }
    }
    if entry.two_sided {
        let faces = from.faces..scene.faces.len();
        sides::mirror_range(scene, faces, |_| true);
    }
    Ok(())
}

/// Gives all materials of a name what the table says.
fn material(
    at: &Place,
    span: Range<usize>,
    entry: &document::Material,
    images: &mut Images,
    reader: &mut Reader,
    scene: &mut Scene,
) -> Result<()> {
    // What lengths will still be multiplied by.
    let unit = reader.options.unit;
    let fault = |what: &str| at.fault(span.clone(), &format!("material '{}' {what}", entry.name));
    let place = at.name(span.clone());
    let of_name: Vec<usize> = (0..scene.materials.len()).filter(|&m| scene.materials[m].name == entry.name).collect();
    if of_name.is_empty() {
        let name = &entry.name;
        scene.warnings.push(format!("{place}: material '{name}' is used by no face; correct its name"));
    }
    if scene.is_flatland() && (entry.radiance.is_some() || entry.lumens.is_some()) {
        return Err(fault("has radiance or lumens, which flatland does not know; give radiosity, W/m"));
    }
    let radiance = match (entry.radiance, entry.radiosity, entry.lumens) {
        (None, None, None) => None,
        (Some(radiance), None, None) => Some(radiance.three()),
        (None, Some(radiosity), None) => Some(radiosity.three().map(|b| b / PI)),
        (None, None, Some(lumens)) => {
            let area: f64 = scene
                .faces
                .iter()
                .enumerate()
                .filter(|(_, f)| of_name.contains(&(f.material as usize)))
                .map(|(i, _)| scene.area(i))
                .sum();
            let color = entry.color.unwrap_or([1.0; 3]);
            let luminance: f64 = (0..3).map(|k| LUMINANCE[k] * color[k]).sum();
            if color.iter().any(|c| !(c.is_finite() && *c >= 0.0)) || luminance <= 0.0 {
                return Err(fault("has a color that is not three numbers of 0 and above, one of them above 0"));
            }
            if area <= 0.0 && !of_name.is_empty() {
                return Err(fault("has no area to spread its lumens over"));
            }
            // A diffuse emitter of radiance L sends pi L from a square metre.
            let white = if area > 0.0 { lumens / (EFFICACY * PI * area * unit * unit * luminance) } else { 0.0 };
            Some(color.map(|c| c * white))
        }
        _ => return Err(fault("has more than one of radiance, radiosity and lumens; one says it all")),
    };
    if entry.color.is_some() && entry.lumens.is_none() {
        return Err(fault("has a color without lumens; give radiance or radiosity as three numbers instead"));
    }
    if entry.mirror.is_some() && (entry.reflectance.is_some() || radiance.is_some()) {
        return Err(fault("is a mirror beside a reflectance or light of its own; a mirror has its own reflectance alone"));
    }
    if entry.mirror.is_some() && (entry.reflectance_map.is_some() || entry.emission_map.is_some()) {
        return Err(fault("is a mirror beside a map of reflectance or light; a mirror has one reflectance everywhere"));
    }
    if let Some(mirror) = entry.mirror.filter(|m| !(0.0..1.0).contains(m)) {
        return Err(fault(&format!("is a mirror of reflectance {mirror}; give a number in [0, 1)")));
    }
    if entry.lumens.is_some() && entry.emission_map.is_some() {
        return Err(fault("has lumens beside an emission_map; give the radiance that its texels are multiplied by"));
    }
    if let Some(cutoff) = entry.alpha_cutoff.filter(|c| !(0.0..=1.0).contains(c)) {
        return Err(fault(&format!("has an alpha_cutoff of {cutoff}; give 0 to 1")));
    }
    let mut map = |name: &Option<String>, meaning, instead: &str, scene: &mut Scene| {
        let name = name.as_ref()?;
        let bytes = || find(at.path, name, reader).map(|found| found.1).map_err(|e| e.to_string());
        images.take(name, meaning, bytes, &place, instead, scene).map(Map::new)
    };
    let reflectance_map = map(&entry.reflectance_map, Meaning::Colour, "its reflectance is taken alone", scene);
    let emission_map = map(&entry.emission_map, Meaning::Colour, "its radiance is taken alone", scene);
    let alpha_map = map(&entry.alpha_map, Meaning::Alpha(Channel::Any), "nothing is cut out", scene);
    // A reflectance of its own paints over what a file says, a map too; a map alone is multiplied by 1.
    let factor = entry.reflectance.map(Values::three).or(reflectance_map.map(|_| [1.0; 3]));
    let reflectance = factor.map(|r| below_one(r, reflectance_map, &entry.name, &place, scene));
    let radiance = radiance.or(emission_map.map(|_| [1.0; 3]));
    for m in of_name {
        let material = &mut scene.materials[m];
        if let Some(reflectance) = reflectance {
            (material.reflectance, material.reflectance_map) = (reflectance, reflectance_map);
        }
        if let Some(radiance) = radiance {
            (material.emission, material.emission_map) = (radiance, emission_map);
        }
        if let Some(mirror) = entry.mirror {
            if material.emission != [0.0; 3] {
                let what =
                    format!("material '{}' shines in its file and is a mirror here, and its light is left out", entry.name);
                scene.warnings.push(format!("{place}: {what}; name the lamp's material otherwise"));
            }
            let (alpha_map, alpha_cutoff) = (material.alpha_map, material.alpha_cutoff);
            *material = Material { alpha_map, alpha_cutoff, ..Material::new_mirror(&entry.name, mirror) };
        } else if reflectance.is_some() || radiance.is_some() {
            // What a file took for a mirror is what the table says.
            material.mirror = 0.0;
        }
        material.alpha_map = alpha_map.or(material.alpha_map);
        material.alpha_cutoff = entry.alpha_cutoff.unwrap_or(material.alpha_cutoff);
        scene.material_places[m] = place.clone();
    }
    Ok(())
}
