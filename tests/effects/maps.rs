//! Scenes with maps, for the tests of textures and of cut-outs.

use raycell::accuracy::reference::{Goal, Reference};
use raycell::engine::Engine;
use raycell::layout::{DirectSum, Point};
use raycell::scene::{Geometry, Map, Material, Texels, Texture, shapes};
use raycell::twin::direct::Samples;
use raycell::{Backend, Flow, Params, Scene, Solution, SurfacePoint, bake};
use std::path::Path;

/// A texture of floats from what each texel holds.
pub fn texture(w: u32, h: u32, of: impl Fn(u32, u32) -> [f32; 4]) -> Texture {
    let texels = (0..w * h).map(|i| of(i % w, i / w)).collect();
    Texture { name: "made".into(), width: w, height: h, texels: Texels::Float(texels) }
}

/// `n` times `n` squares of two greys, 8 texels wide so that their edges are sharp.
pub fn checkers(n: u32, dark: f32, pale: f32) -> Texture {
    texture(8 * n, 8 * n, |x, y| if (x / 8 + y / 8) % 2 == 0 { [dark; 4] } else { [pale; 4] })
}

/// Texture coordinates for some faces from their corners' places.
pub fn unwrap(scene: &mut Scene, faces: std::ops::Range<usize>, uv: impl Fn([f64; 3]) -> [f64; 2]) {
    scene.face_uvs.resize(scene.faces.len(), [u32::MAX; 3]);
    for f in faces {
        let first = scene.uvs.len() as u32;
        scene.uvs.extend(scene.corners(f).map(&uv));
        scene.face_uvs[f] = [first, first + 1, first + 2];
    }
}

/// A unit room whose floor, of material 2, has coordinates (x, z); its ceiling is a lamp, material 1.
pub fn room(floor: Material, textures: Vec<Texture>) -> Scene {
    let walls = shapes::room([0.0; 3], [1.0; 3], [0, 0, 2, 1, 0, 0]);
    let materials = vec![Material::new("wall", [0.5; 3], [0.0; 3]), Material::new("lamp", [0.2; 3], [3.0; 3]), floor];
    let plain = materials.iter().map(|m| Material::new(&m.name, [0.1; 3], [0.0; 3])).collect();
    let mut scene = Scene::from_triangles("room", &walls, plain).unwrap();
    (scene.materials, scene.textures) = (materials, textures);
    unwrap(&mut scene, 4..6, |p| [p[0], p[2]]);
    scene.check().unwrap();
    scene
}

/// A material with a map of its reflectance.
pub fn painted(factor: f64) -> Material {
    Material { reflectance_map: Some(Map::new(0)), ..Material::new("painted", [factor; 3], [0.0; 3]) }
}

pub fn solve(backend: &Backend, scene: &Scene, params: &Params) -> Solution {
    bake(backend, scene, params, &mut |_| Flow::Continue).unwrap()
}

/// Rays and light by an engine: points, what they see of the emitters, what rays from the first of them meet.
pub fn passes<E: Engine>(engine: &mut E, tiles: &[raycell::layout::Tile]) -> (Vec<Point>, Vec<DirectSum>, Vec<[f32; 3]>) {
    let mut batch = engine.emit(tiles, 5, 0, 4_096, 4_096).unwrap();
    let points = engine.points(&batch).unwrap();
    engine.direct(&mut batch, None, 3, 0, 2, Samples { emitter: 4, cosine: 2 }).unwrap();
    let direct = engine.direct_sums(&batch).unwrap();
    // What the same rays' ends reflect, D alone: a gather over them.
    engine.set_irradiance(&mut batch, &vec![[0.5, 1.0, 0.25, 0.0]; points.len()]).unwrap();
    let gathered = engine.gather(&batch, 8, true, true).unwrap();
    (points, direct, gathered.iter().map(|g| g.irradiance).collect())
}

/// The truth at points of a scene, by so many paths each.
pub fn traced(scene: &Scene, points: &[SurfacePoint], paths: u64) -> Vec<[f64; 3]> {
    let geometry = Geometry::new(scene).unwrap();
    let mut reference = Reference::new(scene, &geometry, Path::new("points"), points.to_vec(), 5).unwrap();
    reference
        .run(Goal { noise: 0.0, paths, time: None }, &mut raycell::progress::Progress::new(&mut |_| Flow::Continue))
        .unwrap();
    reference.truth().b
}

/// Points on the floor, at the middles of squares of a grid.
pub fn floor(n: usize) -> Vec<SurfacePoint> {
    let at = |i: usize| (i as f64 + 0.5) / n as f64;
    (0..n * n).map(|i| SurfacePoint { p: [at(i % n), 0.0, at(i / n)], n: [0.0, 1.0, 0.0] }).collect()
}

/// Triangles, and behind them a twin of each.
pub fn two_sided(triangles: shapes::Triangles) -> shapes::Triangles {
    let twins: shapes::Triangles = triangles.iter().map(|&([a, b, c], m)| ([a, c, b], m)).collect();
    [triangles, twins].concat()
}
