//! Random scenes: rooms in a row joined by doors, furniture, open courts, lamps of all sizes. A seed each.

use raycell::Scene;
use raycell::scene::Material;
use raycell::twin::math::{hash, seed_of};

type Corners = [[f64; 3]; 3];
/// Minimum and maximum corner.
type Box3 = [[f64; 3]; 2];

/// A scene in the making, with its random numbers.
struct Maker {
    state: u32,
    triangles: Vec<(Corners, u32)>,
    materials: Vec<Material>,
}

/// A room's inside.
struct Room {
    x: [f64; 2],
    z: f64,
    height: f64,
    open: bool,
    /// Circles on the floor that are taken: centre and radius.
    taken: Vec<([f64; 2], f64)>,
}

/// Least and most triangles of a scene.
pub const TRIANGLES: [usize; 2] = [40, 600];
/// Thickness of the walls between rooms, metres.
const WALL: f64 = 0.15;

/// The scene of a seed.
pub fn scene(seed: u32) -> raycell::Result<Scene> {
    let mut m = Maker { state: seed_of(0x5ce7e, seed), triangles: Vec::new(), materials: Vec::new() };
    let wanted = m.spread(TRIANGLES[0] as f64, TRIANGLES[1] as f64) as usize;
    let mut rooms = m.rooms();
    // A lamp takes 4 triangles at least, and furniture shall have half of what is left.
    let room_for = ((wanted.saturating_sub(m.triangles.len()) / 2 / 4).max(1) as f64).min(50.0);
    let lamps = m.spread(1.0, 50.5).min(room_for) as usize;
    let mut tries = 0;
    let mut lit = 0;
    while lit < lamps.max(1) && tries < 400 {
        lit += m.lamp(&mut rooms, lamps > 8) as usize;
        tries += 1;
    }
    let mut tries = 0;
    while m.triangles.len() < wanted.saturating_sub(11) && tries < 400 {
        m.furniture(&mut rooms, wanted);
        tries += 1;
    }
    Scene::from_triangles(&format!("random {seed}"), &m.triangles, m.materials)
}

impl Maker {
    /// A number in [0, 1).
    fn unit(&mut self) -> f64 {
        self.state = hash(self.state.wrapping_add(0x9e37_79b9));
        self.state as f64 / 4294967296.0
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Between two positive numbers, uniform in the logarithm.
    fn spread(&mut self, low: f64, high: f64) -> f64 {
        (self.between(low.ln(), high.ln())).exp()
    }

    fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    fn pick(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }

    /// A diffuse material: a lightness, and a colour about it.
    fn paint(&mut self) -> u32 {
        let light = self.between(0.1, 0.9);
        let colour = self.between(0.0, 0.5);
        let reflectance = [0; 3].map(|_| (light + colour * self.between(-0.5, 0.5)).clamp(0.1, 0.9));
        self.material(reflectance, [0.0; 3])
    }

    fn material(&mut self, reflectance: [f64; 3], emission: [f64; 3]) -> u32 {
        self.materials.push(Material::new(&format!("m{}", self.materials.len()), reflectance, emission));
        self.materials.len() as u32 - 1
    }

    /// Corners counter-clockwise seen from the front.
    fn quad(&mut self, [a, b, c, d]: [[f64; 3]; 4], material: u32) {
        self.triangles.push(([a, b, c], material));
        self.triangles.push(([a, c, d], material));
    }

    /// A wall in the plane x, the floor or ceiling in y, or a wall in z, from `low` to `high` along the two other axes in
    /// cyclic order; it faces up that axis, or down.
    fn sheet(&mut self, axis: usize, at: f64, low: [f64; 2], high: [f64; 2], up: bool, material: u32) {
        let corner = |u: f64, v: f64| {
            let mut p = [0.0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (at, u, v);
            p
        };
        let mut corners = [corner(low[0], low[1]), corner(high[0], low[1]), corner(high[0], high[1]), corner(low[0], high[1])];
        if !up {
            // The same diagonal either way: two sheets back to back are one.
            corners.swap(1, 3);
        }
        self.quad(corners, material);
    }

    /// A closed box seen from outside, turned about its middle; `skip` leaves one side out (2 axis + up).
    fn block(&mut self, [low, high]: Box3, turn: f64, skip: Option<usize>, material: u32, lit: Option<(usize, u32)>) {
        let (c, s) = (turn.cos(), turn.sin());
        let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[2] + high[2])];
        let first = self.triangles.len();
        for axis in 0..3 {
            for up in [false, true] {
                let side = 2 * axis + up as usize;
                if skip == Some(side) {
                    continue;
                }
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                let at = if up { high[axis] } else { low[axis] };
                let material = lit.filter(|l| l.0 == side).map_or(material, |l| l.1);
                self.sheet(axis, at, [low[u], low[v]], [high[u], high[v]], up, material);
            }
        }
        for (corners, _) in &mut self.triangles[first..] {
            for p in corners {
                let (x, z) = (p[0] - middle[0], p[2] - middle[1]);
                (p[0], p[2]) = (middle[0] + c * x + s * z, middle[1] - s * x + c * z);
            }
        }
    }

    /// One to four rooms along x, a door in each wall between them; courts are as high as the highest, and open.
    fn rooms(&mut self) -> Vec<Room> {
        let count = 1 + self.pick(4);
        let mut x = 0.0;
        let mut rooms: Vec<Room> = (0..count)
            .map(|_| {
                let width = self.between(1.8, 6.0);
                let room = Room {
                    x: [x, x + width],
                    z: self.between(2.0, 6.0),
                    height: self.between(2.2, 3.6),
                    open: false,
                    taken: vec![],
                };
                x += width + WALL;
                room
            })
            .collect();
        let highest = rooms.iter().map(|r| r.height).fold(0.0, f64::max);
        for room in &mut rooms {
            if self.chance(0.25) {
                (room.open, room.height) = (true, highest);
            }
        }
        // A door between each two: z from, z to, height.
        let doors: Vec<[f64; 3]> = (1..count)
            .map(|i| {
                let deep = rooms[i - 1].z.min(rooms[i].z);
                let width = self.between(0.5, 1.2);
                let z = self.between(0.1, deep - width - 0.1);
                [z, z + width, self.between(1.7, 2.1)]
            })
            .collect();
        for i in 0..count {
            let [x0, x1] = rooms[i].x;
            let (z, h) = (rooms[i].z, rooms[i].height);
            let (walls, floor) = (self.paint(), self.paint());
            self.sheet(1, 0.0, [0.0, x0], [z, x1], true, floor);
            if !rooms[i].open {
                let ceiling = self.paint();
                self.sheet(1, h, [0.0, x0], [z, x1], false, ceiling);
            }
            self.sheet(2, 0.0, [x0, 0.0], [x1, h], true, walls);
            self.sheet(2, z, [x0, 0.0], [x1, h], false, walls);
            for (at, up, door) in [(x0, true, i.checked_sub(1)), (x1, false, Some(i))] {
                match door.and_then(|d| doors.get(d)).copied() {
                    None => self.sheet(0, at, [0.0, 0.0], [h, z], up, walls),
                    Some([a, b, top]) => {
                        self.sheet(0, at, [0.0, 0.0], [h, a], up, walls);
                        self.sheet(0, at, [0.0, b], [h, z], up, walls);
                        self.sheet(0, at, [top, a], [h, b], up, walls);
                        rooms[i].taken.push(([at, 0.5 * (a + b)], 0.4));
                    }
                }
            }
        }
        for (i, &[a, b, top]) in doors.iter().enumerate() {
            let (x0, x1) = (rooms[i].x[1], rooms[i + 1].x[0]);
            let jamb = self.paint();
            self.sheet(1, 0.0, [a, x0], [b, x1], true, jamb);
            self.sheet(1, top, [a, x0], [b, x1], false, jamb);
            self.sheet(2, a, [x0, 0.0], [x1, top], true, jamb);
            self.sheet(2, b, [x0, 0.0], [x1, top], false, jamb);
        }
        rooms
    }

    /// A free circle on the floor, if one is found soon.
    fn place(&mut self, room: &mut Room, radius: f64) -> Option<[f64; 2]> {
        for _ in 0..20 {
            let [x0, x1] = room.x;
            let (dx, dz) = (x1 - x0 - 2.0 * radius, room.z - 2.0 * radius);
            if dx <= 0.0 || dz <= 0.0 {
                return None;
            }
            let at = [x0 + radius + dx * self.unit(), radius + dz * self.unit()];
            if room.taken.iter().all(|(p, r)| (p[0] - at[0]).hypot(p[1] - at[1]) > r + radius) {
                room.taken.push((at, radius));
                return Some(at);
            }
        }
        None
    }

    /// A lamp: a panel under the ceiling or before a wall, or a box that stands or hangs. `thin`: a sheet with a dark back.
    /// Whether there was room for it.
    fn lamp(&mut self, rooms: &mut [Room], thin: bool) -> bool {
        let i = self.pick(rooms.len());
        let room = &mut rooms[i];
        let power = self.spread(5.0, 500.0);
        let size = [self.spread(0.05, 1.2), self.spread(0.05, 1.2)];
        let tint = [1.0, self.between(0.6, 1.0), self.between(0.3, 1.0)];
        // Radiance of a panel of that power; a box shines less, from all its sides.
        let shine = |area: f64| tint.map(|t| t * power / (std::f64::consts::PI * area));
        let casing = self.paint();
        let kind = self.pick(3);
        if kind == 2 {
            let (edge, h) = (size[0].min(0.5), size[1].min(0.6));
            let Some([x, z]) = self.place(room, 0.75 * edge) else { return false };
            let floor = if self.chance(0.5) { 0.03 } else { self.between(0.5, room.height - h - 0.1) };
            let light = self.material([0.1; 3], shine(2.0 * edge * edge + 4.0 * edge * h));
            let turn = self.between(0.0, 1.5);
            let half = 0.5 * edge;
            self.block([[x - half, floor, z - half], [x + half, floor + h, z + half]], turn, None, light, None);
            return true;
        }
        let light = self.material([0.1; 3], shine(size[0] * size[1]));
        let gap = self.between(0.01, 0.06);
        let thick = if thin { 0.0 } else { 0.02 };
        let [x0, x1] = room.x;
        // Axis, the plane it shines from, its way, and its place along the two other axes.
        let (axis, at, up, low, span) = if kind == 0 && !room.open {
            (1, room.height - gap - thick, false, [0.05, x0 + 0.05], [room.z - 0.1, x1 - x0 - 0.1])
        } else if self.chance(0.5) {
            (2, gap + thick, true, [x0 + 0.05, 0.1], [x1 - x0 - 0.1, room.height - 0.2])
        } else {
            (2, room.z - gap - thick, false, [x0 + 0.05, 0.1], [x1 - x0 - 0.1, room.height - 0.2])
        };
        let size = [size[0].min(span[0]), size[1].min(span[1])];
        let low = [low[0] + (span[0] - size[0]) * self.unit(), low[1] + (span[1] - size[1]) * self.unit()];
        let high = [low[0] + size[0], low[1] + size[1]];
        if axis == 2 {
            let (centre, radius) = ([low[0] + 0.5 * size[0], at], 0.5 * size[0] + 0.1);
            if room.taken.iter().any(|(p, r)| (p[0] - centre[0]).hypot(p[1] - centre[1]) < r + radius) {
                return false;
            }
            room.taken.push((centre, radius));
        }
        if thin {
            self.sheet(axis, at, low, high, up, light);
            self.sheet(axis, at, low, high, !up, casing);
            return true;
        }
        let (mut a, mut b) = ([0.0; 3], [0.0; 3]);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        (a[u], a[v], b[u], b[v]) = (low[0], low[1], high[0], high[1]);
        (a[axis], b[axis]) = if up { (at - thick, at) } else { (at, at + thick) };
        self.block([a, b], 0.0, None, casing, Some((2 * axis + up as usize, light)));
        true
    }

    /// A piece of furniture: a box on the floor, a stack, a table, or a box centimetres off the wall or the floor.
    fn furniture(&mut self, rooms: &mut [Room], wanted: usize) {
        let left = wanted - self.triangles.len();
        let i = self.pick(rooms.len());
        let room = &mut rooms[i];
        let paint = self.paint();
        let size = [self.spread(0.15, 1.6), self.spread(0.1, 1.8).min(room.height - 0.3), self.spread(0.15, 1.2)];
        let kind = self.pick(5);
        if kind == 3 {
            // Off a wall along x, by centimetres.
            let gap = self.between(0.005, 0.06);
            let [x0, x1] = room.x;
            let width = size[0].min(x1 - x0 - 0.2);
            let depth = size[2].min(0.6);
            let radius = 0.5 * width.hypot(depth);
            let far = self.chance(0.5);
            let z = if far { room.z - gap - depth } else { gap };
            let x = self.between(x0 + 0.05, x1 - width - 0.05);
            let centre = [x + 0.5 * width, z + 0.5 * depth];
            if room.taken.iter().any(|(p, r)| (p[0] - centre[0]).hypot(p[1] - centre[1]) < r + radius) {
                return;
            }
            room.taken.push((centre, radius));
            let foot = if self.chance(0.3) { self.between(0.3, 0.9) } else { 0.0 };
            let top = (foot + size[1]).min(room.height - 0.1);
            let skip = (foot == 0.0).then_some(2);
            self.block([[x, foot, z], [x + width, top, z + depth]], 0.0, skip, paint, None);
            return;
        }
        let radius = 0.5 * size[0].hypot(size[2]);
        let Some([x, z]) = self.place(room, radius) else { return };
        let turn = if self.chance(0.5) { self.between(0.0, 3.0) } else { 0.0 };
        let cuboid = |low: f64, high: f64, share: f64| {
            let (a, b) = (0.5 * share * size[0], 0.5 * share * size[2]);
            [[x - a, low, z - b], [x + a, high, z + b]]
        };
        match kind {
            // A table: a top on four legs, 1 mm apart so that nothing coincides.
            1 if left >= 60 => {
                let (height, thick) = (self.between(0.3, 0.9), self.between(0.02, 0.08));
                let leg = 0.08 * size[0].min(size[2]);
                for (sx, sz) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                    let at = [sx * (0.45 * size[0] - leg), sz * (0.45 * size[2] - leg)];
                    let (c, s) = (turn.cos(), turn.sin());
                    let [px, pz] = [x + c * at[0] + s * at[1], z - s * at[0] + c * at[1]];
                    self.block([[px - leg, 0.0, pz - leg], [px + leg, height - 0.001, pz + leg]], turn, Some(2), paint, None);
                }
                self.block(cuboid(height, height + thick, 1.0), turn, None, paint, None);
            }
            // A stack of two.
            2 if left >= 22 => {
                let middle = 0.5 * size[1];
                let (share, other) = (self.between(0.3, 0.8), self.between(0.0, 3.0));
                let above = self.paint();
                self.block(cuboid(0.0, middle, 1.0), turn, Some(2), paint, None);
                self.block(cuboid(middle + 0.002, size[1], share), other, None, above, None);
            }
            // Off the floor, by centimetres.
            4 => {
                let gap = self.between(0.005, 0.05);
                self.block(cuboid(gap, gap + size[1], 1.0), turn, None, paint, None);
            }
            _ => self.block(cuboid(0.0, size[1], 1.0), turn, Some(2), paint, None),
        }
    }
}

/// What a scene is made of, in words.
pub fn describe(scene: &Scene) -> String {
    let lamps = scene.materials.iter().filter(|m| m.emission != [0.0; 3]).count();
    let rho = |f: fn(f64, f64) -> f64, start| scene.materials.iter().flat_map(|m| m.reflectance).fold(start, f);
    format!(
        "{} triangles, {lamps} lamps, reflectances {:.2} to {:.2}",
        scene.faces.len(),
        rho(f64::min, f64::MAX),
        rho(f64::max, 0.0)
    )
}

/// Writes a scene as OBJ, with its materials beside it.
pub fn write(scene: &Scene, path: &std::path::Path) -> std::io::Result<()> {
    use std::fmt::Write as _;
    let library = path.with_extension("mtl");
    let mut mtl = String::new();
    for m in &scene.materials {
        let ([r, g, b], [x, y, z]) = (m.reflectance, m.emission);
        let _ = writeln!(mtl, "newmtl {}\nKd {r} {g} {b}\nKe {x} {y} {z}", m.name);
    }
    let mut obj = format!("mtllib {}\n", library.file_name().unwrap_or_default().to_string_lossy());
    for [x, y, z] in &scene.vertices {
        let _ = writeln!(obj, "v {x} {y} {z}");
    }
    for face in &scene.faces {
        let [a, b, c] = face.vertices.map(|v| v + 1);
        let _ = writeln!(obj, "usemtl {}\nf {a} {b} {c}", scene.materials[face.material as usize].name);
    }
    std::fs::write(library, mtl)?;
    std::fs::write(path, obj)
}
