//! Convexity: the proof that nothing can stand between two points of a scene that face each other.

use super::Scene;
use glam::DVec3;

/// How far behind a plane a corner may lie, by the scene's extent: rounding of corners that are on it.
const BEHIND: f64 = 1e-9;
/// Faces beyond which nothing is proven: convex scenes that large are rare, and the proof grows with the square.
const FACES: usize = 4_096;

/// What keeps a scene from being convex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Obstacle {
    /// Nothing does.
    None,
    /// A part of the scene lies behind this face's plane.
    Behind(u32),
    /// It is too large to tell.
    Unknown,
}

/// Looks for a face behind whose plane anything lies. Where there is none, the scene lies in the intersection of its faces' half
/// spaces, a straight line between two of its points stays in it, and nothing in it can block the line: a face that crossed
/// it would have one of its ends behind.
pub(crate) fn obstacle(scene: &Scene) -> Obstacle {
    if scene.faces.len() > FACES {
        return Obstacle::Unknown;
    }
    let mut corners: Vec<u32> = scene.faces.iter().flat_map(|f| f.vertices).collect();
    corners.sort_unstable();
    corners.dedup();
    let corners: Vec<DVec3> = corners.iter().map(|&v| scene.vertices[v as usize].into()).collect();
    let first = corners.first().copied().unwrap_or_default();
    let extent = corners.iter().map(|p| p.distance(first)).fold(0.0, f64::max);
    let flat = scene.is_flatland();
    let blocks = |face: &usize| {
        let [a, b, c] = scene.corners(*face).map(DVec3::from);
        let normal = if flat { DVec3::new(a.y - b.y, b.x - a.x, 0.0) } else { (b - a).cross(c - a) };
        // A face without an area has no back.
        normal.try_normalize().is_some_and(|n| corners.iter().any(|&p| n.dot(p - a) < -BEHIND * extent))
    };
    match (0..scene.faces.len()).find(blocks) {
        Some(face) => Obstacle::Behind(face as u32),
        None => Obstacle::None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, shapes};

    fn found(triangles: &shapes::Triangles) -> Obstacle {
        obstacle(&Scene::from_triangles("scene", triangles, vec![Material::new("grey", [0.5; 3], [0.0; 3]); 4]).unwrap())
    }

    #[test]
    fn what_is_convex_is_found_to_be() {
        let (low, high) = ([0.0; 3], [1.0, 2.0, 3.0]);
        let room = shapes::room(low, high, [0; 6]);
        assert_eq!(found(&room), Obstacle::None);
        // Turned, cut, far away, and a sphere seen from inside.
        let turn = glam::DQuat::from_scaled_axis(DVec3::new(0.3, 1.1, -0.7));
        let moved = shapes::moved(shapes::cut(&room, 4), |p| (turn * DVec3::from(p) + DVec3::splat(1e3)).to_array());
        assert_eq!(found(&moved), Obstacle::None);
        assert_eq!(found(&shapes::flipped(shapes::sphere(3, 0))), Obstacle::None);
        assert_eq!(found(&shapes::moved(shapes::tetrahedron(), |p| p.map(|x| 7.0 * x))), Obstacle::None);
        // Two plates that face each other.
        let [floor, ceiling] = [2, 3].map(|side| shapes::sides(low, high, [0; 6])[side].clone());
        assert_eq!(found(&[floor.clone(), ceiling.clone()].concat()), Obstacle::None);
        // What can block is not taken for convex: outward faces, a block, a sheet across the room, a room beside.
        assert!(matches!(found(&shapes::block(low, high, 0)), Obstacle::Behind(_)));
        let block = shapes::block([0.2; 3], [0.4; 3], 0);
        assert_eq!(found(&[room.clone(), block].concat()), Obstacle::Behind(12));
        let sheet = shapes::quad([[0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [1.0, 1.0, 3.0], [0.0, 1.0, 3.0]], 0);
        assert_eq!(found(&[room.clone(), sheet].concat()), Obstacle::Behind(12));
        let beside = shapes::moved(room.clone(), |p| [p[0] + 2.0, p[1], p[2]]);
        assert!(matches!(found(&[room, beside].concat()), Obstacle::Behind(_)));
        assert_eq!(found(&shapes::sphere(5, 0)), Obstacle::Unknown);
    }
}
