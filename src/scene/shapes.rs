//! Simple shapes as triangles, for the self-test and for tests. Corners are counter-clockwise seen from the lit side.

use super::{Face, Material, Scene};
use glam::DVec3;

/// Triangles as [`crate::Scene::from_triangles`] takes them: three corners, metres, and a material each.
pub type Triangles = Vec<([[f64; 3]; 3], u32)>;

/// A quadrilateral as two triangles, cut from `a` to `c`.
pub fn quad([a, b, c, d]: [[f64; 3]; 4], material: u32) -> Triangles {
    vec![([a, b, c], material), ([a, c, d], material)]
}

/// The six sides of a box, each two triangles, seen from inside: -x, +x, -y, +y, -z, +z.
pub fn sides(low: [f64; 3], high: [f64; 3], materials: [u32; 6]) -> [Triangles; 6] {
    std::array::from_fn(|side| {
        let (axis, up) = (side / 2, side % 2 == 1);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |s: [f64; 3], t: [f64; 3]| {
            let mut p = [0.0; 3];
            (p[axis], p[u], p[v]) = (if up { high[axis] } else { low[axis] }, s[u], t[v]);
            p
        };
        let mut corners = [corner(low, low), corner(high, low), corner(high, high), corner(low, high)];
        if up {
            corners.swap(1, 3);
        }
        quad(corners, materials[side])
    })
}

/// A box seen from inside, its materials in the order of [`sides`].
pub fn room(low: [f64; 3], high: [f64; 3], materials: [u32; 6]) -> Triangles {
    sides(low, high, materials).concat()
}

/// A box seen from outside.
pub fn block(low: [f64; 3], high: [f64; 3], material: u32) -> Triangles {
    flipped(room(low, high, [material; 6]))
}

/// The regular tetrahedron with corners on the unit cube's, seen from inside; its faces' materials are 0 to 3, each
/// opposite the corner of that number.
pub fn tetrahedron() -> Triangles {
    let p = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    vec![([p[1], p[2], p[3]], 0), ([p[0], p[3], p[2]], 1), ([p[0], p[1], p[3]], 2), ([p[0], p[2], p[1]], 3)]
}

/// The unit sphere about the origin, seen from outside: an icosahedron whose triangles are cut into four, `level` times.
pub fn sphere(level: u32, material: u32) -> Triangles {
    let g = 0.5 * (1.0 + 5f64.sqrt());
    let mut corners = Vec::new();
    for (s, t) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
        corners.extend([[0.0, s, t], [s, t, 0.0], [t, 0.0, s]]);
    }
    let unit = |p: [f64; 3]| (DVec3::from(p)).normalize().to_array();
    let mut faces: Vec<[[f64; 3]; 3]> = Vec::new();
    // The faces are the triples of corners that are neighbours, 2 apart.
    let near = |a: [f64; 3], b: [f64; 3]| (DVec3::from(a).distance(b.into()) - 2.0).abs() < 1e-9;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [corners[i], corners[j], corners[k]];
                if near(a, b) && near(b, c) && near(c, a) {
                    let out = DVec3::from(a).cross(b.into()).dot(c.into()) > 0.0;
                    faces.push(if out { [a, b, c] } else { [a, c, b] }.map(unit));
                }
            }
        }
    }
    for _ in 0..level {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let half = |p: [f64; 3], q: [f64; 3]| unit([0, 1, 2].map(|k| p[k] + q[k]));
                let (ab, bc, ca) = (half(a, b), half(b, c), half(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    faces.into_iter().map(|corners| (corners, material)).collect()
}

/// The same seen from the other side.
pub fn flipped(triangles: Triangles) -> Triangles {
    triangles.into_iter().map(|([a, b, c], m)| ([a, c, b], m)).collect()
}

/// Every corner moved.
pub fn moved(triangles: Triangles, to: impl Fn([f64; 3]) -> [f64; 3]) -> Triangles {
    triangles.into_iter().map(|(corners, m)| (corners.map(&to), m)).collect()
}

/// Every triangle cut into `n` x `n`.
pub fn cut(triangles: &Triangles, n: u32) -> Triangles {
    let mut out = Triangles::new();
    for &([a, b, c], material) in triangles {
        let at = |i: u32, j: u32| {
            [0, 1, 2].map(|k| a[k] + ((b[k] - a[k]) * f64::from(i) + (c[k] - a[k]) * f64::from(j)) / f64::from(n))
        };
        for i in 0..n {
            for j in 0..n - i {
                out.push(([at(i, j), at(i + 1, j), at(i, j + 1)], material));
                if i + j + 1 < n {
                    out.push(([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], material));
                }
            }
        }
    }
    out
}

/// A lit room of white walls with eight bumpy grey balls in it, of about so many triangles: scenes of any size, made in memory.
pub fn bumpy_room(triangles: usize) -> Scene {
    let walls = room([0.0; 3], [4.0, 3.0, 4.0], [0, 0, 0, 0, 0, 0]);
    let lamp = quad([[1.5, 2.99, 1.5], [2.5, 2.99, 1.5], [2.5, 2.99, 2.5], [1.5, 2.99, 2.5]], 2);
    let materials = vec![
        Material::new("white", [0.8; 3], [0.0; 3]),
        Material::new("grey", [0.5, 0.45, 0.4], [0.0; 3]),
        Material::new("lamp", [0.0; 3], [10.0; 3]),
    ];
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (corners, material) in walls.into_iter().chain(lamp) {
        let first = vertices.len() as u32;
        vertices.extend(corners);
        faces.push(Face { vertices: [first, first + 1, first + 2], material, object: 0 });
    }
    // The six sides of a cube, cut into squares and blown up.
    let cuts = ((triangles as f64 / (8.0 * 12.0)).sqrt().round() as u32).max(1);
    let ball = |centre: DVec3| {
        move |p: [f64; 3]| {
            let d = DVec3::from(p).normalize();
            let bump = 1.0 + 0.06 * (9.0 * d.x).sin() * (11.0 * d.y).sin() * (10.0 * d.z).sin();
            (centre + 0.55 * bump * d).to_array()
        }
    };
    for (k, square) in (0..8).flat_map(|k| flipped(room([-1.0; 3], [1.0; 3], [0; 6])).into_iter().step_by(2).map(move |s| (k, s)))
    {
        let centre = DVec3::new([1.0, 3.0][k % 2], [0.7, 2.0][k / 2 % 2], [1.0, 3.0][k / 4]);
        let place = ball(centre);
        // A quad's triangle has two of its sides, at a right angle.
        let corners = square.0.map(DVec3::from);
        let at = |k: usize| (corners[k], corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]);
        let right = (0..3).find(|&k| at(k).1.dot(at(k).2).abs() < 1e-9);
        let (a, u, v) = at(right.unwrap_or(0));
        let (u, v) = if u.cross(v).dot(a + 0.5 * (u + v)) > 0.0 { (u, v) } else { (v, u) };
        let first = vertices.len() as u32;
        for j in 0..=cuts {
            for i in 0..=cuts {
                let (s, t) = (f64::from(i) / f64::from(cuts), f64::from(j) / f64::from(cuts));
                vertices.push(place((a + u * s + v * t).to_array()));
            }
        }
        for j in 0..cuts {
            for i in 0..cuts {
                let at = |di: u32, dj: u32| first + (j + dj) * (cuts + 1) + i + di;
                faces.push(Face { vertices: [at(0, 0), at(1, 0), at(1, 1)], material: 1, object: 0 });
                faces.push(Face { vertices: [at(0, 0), at(1, 1), at(0, 1)], material: 1, object: 0 });
            }
        }
    }
    Scene { name: "bumpy room".into(), vertices, faces, materials, objects: vec!["room".into()], ..Scene::default() }
}

/// A room of a metre, and in it a lamp of 4 cm that begins at `x`, 2 cm above the floor that it faces.
#[cfg(test)]
pub fn low_lamp(x: f64) -> Scene {
    let mut triangles = room([0.0; 3], [1.0; 3], [0; 6]);
    let lamp = [[x, 0.48], [x + 0.04, 0.48], [x + 0.04, 0.52], [x, 0.52]];
    triangles.extend(quad(lamp.map(|[x, z]| [x, 0.02, z]), 1));
    let materials = vec![Material::new("wall", [0.5; 3], [0.0; 3]), Material::new("lamp", [0.0; 3], [9.0; 3])];
    Scene::from_triangles("lamp", &triangles, materials).unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six times the volume that the triangles enclose, positive where they face outward.
    fn volume(triangles: &Triangles) -> f64 {
        triangles.iter().map(|([a, b, c], _)| DVec3::from(*a).cross((*b).into()).dot((*c).into())).sum()
    }

    #[test]
    fn shapes_are_closed_and_face_as_they_say() {
        let (low, high) = ([1.0, 2.0, 3.0], [2.0, 4.0, 6.0]);
        assert!((volume(&room(low, high, [0; 6])) + 36.0).abs() < 1e-12);
        assert!((volume(&block(low, high, 0)) - 36.0).abs() < 1e-12);
        assert!((volume(&cut(&block(low, high, 0), 3)) - 36.0).abs() < 1e-12);
        assert!((volume(&tetrahedron()) + 16.0).abs() < 1e-12);
        let ball = sphere(3, 0);
        assert_eq!(ball.len(), 20 * 64);
        let bumpy = bumpy_room(5_000);
        assert!((4_500..5_500).contains(&bumpy.faces.len()));
        let balls: Triangles =
            (0..bumpy.faces.len()).map(|f| (bumpy.corners(f), bumpy.faces[f].material)).filter(|t| t.1 == 1).collect();
        let each = volume(&balls) / 8.0 / (8.0 * std::f64::consts::PI * 0.55f64.powi(3));
        assert!((each - 1.0).abs() < 0.1, "{each}");
        assert!((volume(&ball) / (8.0 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{}", volume(&ball));
    }
}
