//! What is to be changed about a scene that is solved, by the names of its materials and objects.

use crate::error::{Error, Result};
use crate::scene::{Material, Scene};

/// Whether rays are traced anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Retrace {
    /// Where the network cannot carry the new light, or not as well as the bake says of itself.
    #[default]
    Auto,
    /// In any case: a bake of the changed scene.
    Always,
    /// Never: what the network cannot carry at all is an error.
    Never,
}

/// What is to be changed. A name is a material's, or else an object's: then only the object's faces change, also where they
/// share their material with others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Change {
    /// New emitted radiance of what bears a name, W/m²/sr, linear Rec.709; 0 turns a lamp off.
    pub emission: Vec<(String, [f64; 3])>,
    /// New diffuse reflectance of what bears a name, each band in [0, 1).
    pub reflectance: Vec<(String, [f64; 3])>,
    /// What the emission of what bears a name is multiplied by, after `emission`: light groups are scaled with it.
    pub scale: Vec<(String, f64)>,
    /// Whether rays are traced anew.
    pub retrace: Retrace,
}

/// A changed scene.
pub(super) struct Changed {
    pub scene: Scene,
    /// For each of its materials the one that it was.
    pub of: Vec<u32>,
}

impl Change {
    /// The changes in words, one each.
    pub(super) fn words(&self) -> Vec<String> {
        let bands = |[r, g, b]: [f64; 3]| format!("{r},{g},{b}");
        let emission = self.emission.iter().map(|(name, e)| format!("emission {name}={}", bands(*e)));
        let reflectance = self.reflectance.iter().map(|(name, rho)| format!("reflectance {name}={}", bands(*rho)));
        emission.chain(reflectance).chain(self.scale.iter().map(|(name, s)| format!("scale {name}={s}"))).collect()
    }

    /// The changed scene. Errors: [`Error::UnknownName`], [`Error::InvalidReflectance`], [`Error::InvalidEmission`],
    /// [`Error::InvalidParam`] for a factor that is negative or not finite.
    pub(super) fn apply(&self, scene: &Scene) -> Result<Changed> {
        let of = (0..scene.materials.len() as u32).collect();
        let mut changed = Changed { scene: scene.clone(), of };
        for (name, emission) in &self.emission {
            changed.set(name, &|m| m.emission = *emission)?;
        }
        for (name, reflectance) in &self.reflectance {
            changed.set(name, &|m| m.reflectance = *reflectance)?;
        }
        for (name, factor) in &self.scale {
            if !(*factor >= 0.0 && factor.is_finite()) {
                let range = "light is multiplied by a finite number, 0 or more";
                return Err(Error::InvalidParam { name: "scale", value: format!("{name}={factor}"), range });
            }
            changed.set(name, &|m| m.emission = m.emission.map(|e| e * factor))?;
        }
        (0..changed.scene.materials.len()).try_for_each(|m| changed.scene.check_material(m))?;
        Ok(changed)
    }
}

impl Changed {
    /// Changes what bears a name.
    fn set(&mut self, name: &str, change: &dyn Fn(&mut Material)) -> Result<()> {
        let mut found = false;
        for m in self.scene.materials.iter_mut().filter(|m| m.name == name) {
            change(m);
            found = true;
        }
        if found {
            return Ok(());
        }
        let named = |scene: &Scene, object: u32| scene.objects.get(object as usize).is_some_and(|o| o == name);
        let mut inside: Vec<u32> = self.scene.faces.iter().filter(|f| named(&self.scene, f.object)).map(|f| f.material).collect();
        inside.sort_unstable();
        inside.dedup();
        if inside.is_empty() {
            return Err(self.unknown(name));
        }
        for material in inside {
            let here = |scene: &Scene, i: usize| named(scene, scene.faces[i].object);
            let own = (0..self.scene.faces.len()).all(|i| self.scene.faces[i].material != material || here(&self.scene, i));
            let changed = if own { material } else { self.split(material, name) };
            change(&mut self.scene.materials[changed as usize]);
        }
        Ok(())
    }

    /// Gives an object's faces of a material one of their own.
    fn split(&mut self, material: u32, object: &str) -> u32 {
        let scene = &mut self.scene;
        let own = scene.materials.len() as u32;
        let old = scene.materials[material as usize].clone();
        scene.materials.push(Material { name: format!("{} ({object})", old.name), ..old });
        if let Some(place) = scene.material_places.get(material as usize).cloned() {
            scene.material_places.push(place);
        }
        self.of.push(self.of[material as usize]);
        for face in scene
            .faces
            .iter_mut()
            .filter(|f| f.material == material && scene.objects.get(f.object as usize).is_some_and(|o| o == object))
        {
            face.material = own;
        }
        own
    }

    fn unknown(&self, name: &str) -> Error {
        let list = |names: &mut dyn Iterator<Item = &String>| {
            let mut names: Vec<&str> = names.map(String::as_str).filter(|n| !n.is_empty()).collect();
            names.sort_unstable();
            names.dedup();
            names.join(", ")
        };
        let materials = list(&mut self.scene.materials.iter().map(|m| &m.name));
        let objects = list(&mut self.scene.objects.iter());
        Error::UnknownName { name: name.into(), known: format!("materials: {materials}; objects: {objects}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;

    #[test]
    fn an_object_gets_a_material_of_its_own_only_where_it_shares_one() {
        let room = shapes::room([0.0; 3], [1.0; 3], [0, 0, 0, 1, 0, 0]);
        let materials = vec![Material::new("grey", [0.5; 3], [0.0; 3]), Material::new("lamp", [0.0; 3], [1.0; 3])];
        let mut scene = Scene::from_triangles("room", &room, materials).unwrap();
        scene.objects = vec!["walls".into(), "floor".into(), "bulb".into()];
        for (i, f) in scene.faces.iter_mut().enumerate() {
            f.object = if f.material == 1 { 2 } else { u32::from(i < 2) };
        }
        let change = Change { scale: vec![("bulb".into(), 2.0)], ..Change::default() };
        let bulb = change.apply(&scene).unwrap();
        assert_eq!((bulb.scene.materials.len(), bulb.scene.materials[1].emission), (2, [2.0; 3]));
        let change = Change { reflectance: vec![("floor".into(), [0.2; 3])], ..Change::default() };
        let floor = change.apply(&scene).unwrap();
        assert_eq!(floor.of, [0, 1, 0]);
        assert_eq!((floor.scene.materials[0].reflectance, floor.scene.materials[2].reflectance), ([0.5; 3], [0.2; 3]));
        let of = |scene: &Scene| scene.faces.iter().filter(|f| f.material == 2).count();
        assert_eq!((of(&floor.scene), of(&scene)), (2, 0));
        assert_eq!(change.words(), ["reflectance floor=0.2,0.2,0.2"]);

        let said = |change: Change| change.apply(&scene).map(|_| ()).unwrap_err().to_string();
        let missing = said(Change { emission: vec![("lmap".into(), [1.0; 3])], ..Change::default() });
        assert!(
            missing.contains("lmap") && missing.contains("grey, lamp") && missing.contains("bulb, floor, walls"),
            "{missing}"
        );
        let bright = said(Change { reflectance: vec![("grey".into(), [0.5, 1.0, 0.5])], ..Change::default() });
        assert!(bright.contains("'grey'") && bright.contains("green"), "{bright}");
        assert!(said(Change { emission: vec![("lamp".into(), [-1.0; 3])], ..Change::default() }).contains("'lamp'"));
        assert!(said(Change { scale: vec![("lamp".into(), f64::NAN)], ..Change::default() }).contains("lamp=NaN"));
    }
}
