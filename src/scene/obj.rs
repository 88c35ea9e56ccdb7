//! OBJ + MTL through tobj.
use super::*;

/// Reads an OBJ file with its materials.
pub fn load_obj(path: &Path) -> Result<Scene> {
    let opt = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    let (models, mats) = tobj::load_obj(path, &opt).map_err(|e| Error::Format {
        path: path.into(),
        line: None,
        what: e.to_string(),
        cure: "".into(),
    })?;
    let mats = mats.unwrap_or_default();
    let mut scene = Scene { name: path.display().to_string(), ..Default::default() };
    for m in &mats {
        let ke = m
            .unknown_param
            .get("Ke")
            .map(|s| s.split_whitespace().map(|v| v.parse().unwrap_or(0.0)).collect::<Vec<f64>>())
            .unwrap_or_default();
        scene.materials.push(Material {
            name: m.name.clone(),
            reflectance: m.diffuse.unwrap_or([0.5; 3]),
            emission: [0, 1, 2].map(|i| ke.get(i).copied().unwrap_or(0.0)),
        });
    }
    for (o, m) in models.iter().enumerate() {
        let base = scene.vertices.len() as u32;
        scene.objects.push(m.name.clone());
        scene.vertices.extend(m.mesh.positions.chunks_exact(3).map(|c| [c[0], c[1], c[2]]));
        for t in m.mesh.indices.chunks_exact(3) {
            scene.faces.push(Face {
                vertices: [base + t[0], base + t[1], base + t[2]],
                material: m.mesh.material_id.unwrap_or(0) as u32,
                object: o as u32,
            });
        }
    }
    scene.check()?;
    Ok(scene)
}
