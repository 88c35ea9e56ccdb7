//! Polygons of any number of corners, cut into triangles.

use glam::{DVec2, DVec3};

/// Most corners of a polygon whose ears are cut; its time grows with their cube at worst.
const MOST_CORNERS: usize = 512;

/// What became of a polygon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// Its triangles cover it, each once.
    Clean,
    /// It crosses itself, or has too many corners and a dent: the triangles of its fan overlap.
    Overlapping,
}

/// Cuts a polygon: a fan where it is convex, else by ears (Meisters, 1975). Calls `emit` with three positions in
/// `corners` a triangle, of the same winding. Vertices are looked up by the numbers in `corners`.
pub fn cut(corners: &[u32], vertices: &[[f64; 3]], mut emit: impl FnMut([usize; 3])) -> Cut {
    let n = corners.len();
    let at = |i: usize| DVec3::from_array(vertices[corners[i] as usize]);
    let fan = |emit: &mut dyn FnMut([usize; 3])| (1..n - 1).for_each(|i| emit([0, i, i + 1]));
    if n == 3 {
        emit([0, 1, 2]);
        return Cut::Clean;
    }

    // A convex polygon turns the same way at each corner, once round. Newell's normal is twice its area.
    let normal: DVec3 = (1..n - 1).map(|i| (at(i) - at(0)).cross(at(i + 1) - at(0))).sum();
    let slack = -1e-12 * normal.length_squared();
    if (1..n - 1).all(|i| (at(i) - at(0)).cross(at(i + 1) - at(0)).dot(normal) >= slack) {
        fan(&mut emit);
        return Cut::Clean;
    }
    if n > MOST_CORNERS || normal == DVec3::ZERO || !normal.is_finite() {
        fan(&mut emit);
        return Cut::Overlapping;
    }

    // Along the normal's longest axis onto a plane, with the winding kept.
    let a = normal.abs();
    let flat = |p: DVec3| {
        if a.x >= a.y && a.x >= a.z {
            DVec2::new(p.y, p.z) * DVec2::new(normal.x.signum(), 1.0)
        } else if a.y >= a.z {
            DVec2::new(p.z, p.x) * DVec2::new(normal.y.signum(), 1.0)
        } else {
            DVec2::new(p.x, p.y) * DVec2::new(normal.z.signum(), 1.0)
        }
    };
    let p: Vec<DVec2> = (0..n).map(|i| flat(at(i) - at(0))).collect();
    let turn = |a: usize, b: usize, c: usize| (p[b] - p[a]).perp_dot(p[c] - p[a]);
    let mut ring: Vec<usize> = (0..n).collect();
    let mut triangles = Vec::with_capacity(n - 2);
    while ring.len() > 3 {
        let m = ring.len();
        let corner = |i: usize| [ring[(i + m - 1) % m], ring[i], ring[(i + 1) % m]];
        let is_ear = |&i: &usize| {
            let [a, b, c] = corner(i);
            // Another corner inside, or on an edge but not at an end, forbids the cut.
            turn(a, b, c) > 0.0
                && ring.iter().all(|&o| {
                    let outside = turn(a, b, o) < 0.0 || turn(b, c, o) < 0.0 || turn(c, a, o) < 0.0;
                    outside || [a, b, c].iter().any(|&k| p[k] == p[o])
                })
        };
        // A corner that turns nowhere can go too: what it cuts off has no area.
        let Some(ear) = (0..m).find(is_ear).or_else(|| (0..m).find(|&i| turn(corner(i)[0], corner(i)[1], corner(i)[2]) == 0.0))
        else {
            fan(&mut emit);
            return Cut::Overlapping;
        };
        triangles.push(corner(ear));
        ring.remove(ear);
    }
    if turn(ring[0], ring[1], ring[2]) < 0.0 {
        fan(&mut emit);
        return Cut::Overlapping;
    }
    triangles.push([ring[0], ring[1], ring[2]]);
    triangles.into_iter().for_each(emit);
    Cut::Clean
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Areas of the triangles a polygon in a tilted plane is cut into, and what became of it.
    fn areas(outline: &[[f64; 2]]) -> (Vec<f64>, Cut) {
        let vertices: Vec<[f64; 3]> = outline.iter().map(|&[x, y]| [x, y, 0.5 * x - 0.25 * y + 3.0]).collect();
        let corners: Vec<u32> = (0..outline.len() as u32).collect();
        let normal = DVec3::new(-0.5, 0.25, 1.0).normalize();
        let mut areas = Vec::new();
        let cut = cut(&corners, &vertices, |t| {
            let [a, b, c] = t.map(|i| DVec3::from_array(vertices[i]));
            areas.push(0.5 * (b - a).cross(c - a).dot(normal) * normal.z);
        });
        (areas, cut)
    }

    #[test]
    fn dented_polygons_are_covered_once() {
        let comb: Vec<[f64; 2]> = vec![
            [0., 0.],
            [7., 0.],
            [7., 5.],
            [5., 5.],
            [5., 1.],
            [4., 1.],
            [4., 5.],
            [3., 5.],
            [3., 1.],
            [2., 1.],
            [2., 5.],
            [0., 5.],
        ];
        let arrow = vec![[0., 0.], [1., 0.2], [2., 0.], [1., 3.]];
        let step = vec![[0., 0.], [1., 0.], [2., 0.], [2., 2.], [1., 2.], [1., 1.], [0., 1.]];
        for (outline, area) in [(comb, 27.0), (arrow, 2.8), (step, 3.0)] {
            for turned in 0..outline.len() {
                let mut outline = outline.clone();
                outline.rotate_left(turned);
                let (areas, cut) = areas(&outline);
                assert_eq!((areas.len(), cut), (outline.len() - 2, Cut::Clean));
                assert!(areas.iter().all(|&a| a > -1e-12), "{areas:?}");
                assert!((areas.iter().sum::<f64>() - area).abs() < 1e-12 * area, "{areas:?}");
            }
        }
    }

    #[test]
    fn convex_polygons_become_fans() {
        let (areas, cut) = areas(&[[0., 0.], [2., 0.], [3., 1.], [2., 2.], [0., 2.]]);
        assert_eq!((areas.len(), cut), (3, Cut::Clean));
        assert!((areas.iter().sum::<f64>() - 5.0).abs() < 1e-12);
    }

    #[test]
    fn crossing_polygons_are_told() {
        assert_eq!(areas(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.5]]).1, Cut::Overlapping);
    }
}
