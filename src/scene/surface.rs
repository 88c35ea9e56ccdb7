//! Looking up the surface at a given point, for queries. All in f64.

use super::Geometry;
use glam::DVec3;

/// How far a point may lie off its surface, as a share of the scene's largest extent.
const REACH: f64 = 1e-3;
/// Least cosine between the asked normal and the triangle's.
const AGREE: f64 = 0.5;
/// Distances that differ by less (local) are the same; the better normal decides.
const SAME: f64 = 1e-6;

/// A point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// Triangle, an index into [`Geometry::tris`].
    pub tri: u32,
    /// The point, local, projected onto the triangle.
    pub p: [f32; 3],
}

impl Geometry {
    /// The nearest triangle that faces the way of `n`, within 1e-3 of the scene's largest extent of `p` (world).
    /// Among equally near ones the best agreeing normal wins, then the lowest triangle. `None`: off every surface.
    pub fn locate(&self, p: [f64; 3], n: [f64; 3]) -> Option<Located> {
        let p = DVec3::from_array(self.to_local(p));
        let n = DVec3::from_array(n).try_normalize()?;
        if !p.is_finite() {
            return None;
        }
        self.nodes.first()?;
        let mut reach = REACH * self.local_extent();

        // Everything within `SAME` of the nearest so far: (distance, agreement, triangle, point).
        let mut found: Vec<(f64, f64, u32, DVec3)> = Vec::new();
        let mut stack = vec![0u32];
        while let Some(i) = stack.pop() {
            let node = &self.nodes[i as usize];
            let (low, high) = (vec(node.min), vec(node.max));
            if p.distance(p.clamp(low, high)) > reach {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first + 1, node.first]);
                continue;
            }
            for t in node.first..node.first + node.count {
                let tri = &self.tris[t as usize];
                let agreement = n.dot(vec(tri.normal));
                if agreement <= AGREE {
                    continue;
                }
                let on = nearest_on_triangle(p, [tri.v0, tri.v1, tri.v2].map(vec));
                let distance = p.distance(on);
                if distance <= reach {
                    found.push((distance, agreement, t, on));
                    reach = reach.min(distance + SAME);
                }
            }
        }
        let nearest = found.iter().map(|f| f.0).fold(f64::INFINITY, f64::min);
        found
            .into_iter()
            .filter(|f| f.0 <= nearest + SAME)
            .min_by(|a, b| b.1.total_cmp(&a.1).then(a.2.cmp(&b.2)))
            .map(|(_, _, tri, on)| Located { tri, p: on.as_vec3().to_array() })
    }
}

fn vec(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
pub(crate) fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let whole = va + vb + vc;
    a + ab * (vb / whole) + ac * (vc / whole)
}

#[cfg(test)]
mod tests {
    use super::super::{Material, Scene};
    use super::*;

    /// A floor of two triangles, and a sheet above it that faces both ways.
    fn geometry() -> Geometry {
        let quad = |y: f64, up: bool| {
            let (a, b, c, d) = ([0.0, y, 0.0], [0.0, y, 10.0], [10.0, y, 10.0], [10.0, y, 0.0]);
            if up { [([a, b, c], 0), ([a, c, d], 0)] } else { [([a, c, b], 0), ([a, d, c], 0)] }
        };
        let triangles: Vec<_> = [quad(0.0, true), quad(4.0, true), quad(4.0, false)].concat();
        let grey = Material::new("grey", [0.5; 3], [1.0; 3]);
        Geometry::new(&Scene::from_triangles("sheet", &triangles, vec![grey]).unwrap()).unwrap()
    }

    #[test]
    fn the_facing_side_is_found() {
        let g = geometry();
        for (p, n, face) in
            [([1.0, 0.0, 5.0], [0.0, 1.0, 0.0], 0), ([5.0, 4.0, 1.0], [0.0, 2.0, 0.0], 3), ([1.0, 4.0, 5.0], [0.1, -1.0, 0.0], 4)]
        {
            let at = g.locate(p, n).unwrap();
            assert_eq!(g.source[at.tri as usize], face);
            for k in 0..3 {
                assert!((at.p[k] as f64 - g.to_local(p)[k]).abs() < 1e-7);
            }
        }
        // The extent is 10: up to 0.01 off is still the surface, and the answer lies on it.
        let at = g.locate([1.0, 0.0099, 5.0], [0.0, 1.0, 0.0]).unwrap();
        assert_eq!(at.p[1] as f64, g.to_local([1.0, 0.0, 5.0])[1]);
        for (p, n) in [
            ([1.0, 0.0101, 5.0], [0.0, 1.0, 0.0]),
            ([1.0, 0.0, 5.0], [0.0, -1.0, 0.0]),
            ([1.0, 0.0, 5.0], [1.0, 0.0, 0.0]),
            ([1.0, 0.0, 5.0], [0.0, 0.0, 0.0]),
            ([f64::NAN, 0.0, 5.0], [0.0, 1.0, 0.0]),
            ([-0.011, 0.0, 5.0], [0.0, 1.0, 0.0]),
        ] {
            assert_eq!(g.locate(p, n), None, "{p:?} {n:?}");
        }
    }

    #[test]
    fn ties_go_to_the_lowest_triangle() {
        let g = geometry();
        // On the diagonal both halves of the floor are at distance 0.
        let at = g.locate([5.0, 0.0, 5.0], [0.0, 1.0, 0.0]).unwrap();
        let floor: Vec<u32> = (0..g.tris.len() as u32).filter(|&t| g.source[t as usize] < 2).collect();
        assert_eq!(at.tri, *floor.iter().min().unwrap());
    }
}
