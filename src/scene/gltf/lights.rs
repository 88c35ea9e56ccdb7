//! Lights of a glTF file (`KHR_lights_punctual`): they shine along their own -z.
//!
//! The format's units are photometric. A lumen is taken for a watt here, as the emission of surfaces is read (a nit for a W/m2/sr),
//! so that lamps and lights keep their proportion.

use crate::scene::unread::Unread;
use crate::scene::{Light, LightKind, Scene};
use gltf::json::extensions::scene::khr_lights_punctual::Type;
use gltf::json::validation::Checked;
use gltf::json::{Node, Root};

/// Adds the light of a node, in the node's own space.
pub fn light(root: &Root, n: usize, node: &Node, scene: &mut Scene, unread: &mut Unread) {
    let Some(light) = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref()) else { return };
    let Some(light) = root.get(light.light) else { return };
    let place = format!("nodes[{n}]");
    let name = node.name.as_ref().or(light.name.as_ref()).cloned().unwrap_or_else(|| place.clone());
    let (position, direction) = ([0.0; 3], [0.0, 0.0, -1.0]);
    let kind = match (light.type_, &light.spot) {
        // The format's sun has no size.
        (Checked::Valid(Type::Directional), _) => LightKind::Sun { direction, angle: 0.0 },
        (Checked::Valid(Type::Point), _) => LightKind::Point { position },
        (Checked::Valid(Type::Spot), Some(spot)) => {
            let [inner, outer] = [spot.inner_cone_angle, spot.outer_cone_angle].map(|a| f64::from(a).to_degrees());
            // Rounding must not take it beyond a half space.
            LightKind::Spot { position, direction, inner: inner.min(outer), outer: outer.min(90.0) }
        }
        _ => {
            unread.add("light of an unknown kind", &place);
            return;
        }
    };
    if light.range.is_some() {
        unread.add("range of a light (its light falls with the square of the distance and never ends)", &place);
    }
    let intensity = light.color.map(|c| f64::from(c) * f64::from(light.intensity));
    scene.lights.push(Light { name, intensity, kind });
}
