//! The embedded shader sources and their composition.
//!
//! A line `#import name` (at the start of a line) pulls in `wgsl/lib/name.wgsl` once. There are no
//! conditionals. A line map leads every line of the composed text back to its file.
//!
//! Of kernels that look at triangles there is a second text, for scenes that exceed one binding ([`super::paged`]):
//! the bindings of `PAGED` are textures there, and the modules that read them have others in their place. Of those that carry
//! colour bands through the solve there is one for scenes that are all grey.

/// Embeds `wgsl/<folder><name>.wgsl` under its name.
macro_rules! sources {
    ($folder:literal: $($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../wgsl/", $folder, $name, ".wgsl")))),*]
    };
}

/// Kernels: name and source. Every `wgsl/*.wgsl` is listed; `tests/wgsl.rs` checks that.
pub const KERNELS: &[(&str, &str)] = sources!["": "sentinel", "emit", "probe", "shoot", "kernel", "direct", "assign", "feature", "winner", "accumulate", "adapt", "coefficients", "flux", "deposit", "beta", "update", "readout", "gather", "respond"];

/// Modules that kernels import: name and source.
pub const LIBS: &[(&str, &str)] = sources!["lib/": "finish", "fixed", "invert", "layout", "lights", "math", "medium", "ray", "sky", "sobol", "sums", "surface", "texture", "bands", "bands_one", "boxes", "boxes_paged", "triangles", "triangles_paged", "way"];

/// The module of colour bands, and the one in its place where all is grey.
const BANDS: (&str, &str) = ("bands", "bands_one");

/// What differs where the scene is paged: the module that reads records, the one in its place, and the binding's type.
const PAGED: [(&str, &str, &str); 2] =
    [("boxes", "boxes_paged", "array<BvhNode>"), ("triangles", "triangles_paged", "array<Tri>")];
/// Type of a binding of paged records.
const TEXELS: &str = "texture_2d_array<u32>";

/// A line of a kernel for a paged scene.
fn paged_line(line: &str) -> String {
    for (_, _, ty) in PAGED {
        if let Some((start, rest)) = line.split_once("var<storage, read> ")
            && let Some((name, rest)) = rest.split_once(&format!(": {ty}"))
        {
            return format!("{start}var {name}: {TEXELS}{rest}");
        }
    }
    line.into()
}

/// A kernel with its imports.
#[derive(Clone, Debug)]
pub struct Composed {
    /// The text for the driver.
    pub source: String,
    /// File (relative to the project) and line, from 1, of each line of `source`.
    pub lines: Vec<(String, usize)>,
}

impl Composed {
    /// `file:line` of a line of the composed text, from 1.
    pub fn locate(&self, line: usize) -> String {
        match self.lines.get(line.wrapping_sub(1)) {
            Some((file, line)) => format!("{file}:{line}"),
            None => format!("line {line}"),
        }
    }
}

fn find(list: &[(&str, &'static str)], name: &str) -> Option<&'static str> {
    list.iter().find(|(n, _)| *n == name).map(|&(_, text)| text)
}

/// Which text of a kernel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Text {
    /// For a scene that exceeds one binding.
    pub paged: bool,
    /// For a scene that is all grey: one colour band.
    pub grey: bool,
}

/// The full text of a kernel and where its lines come from.
///
/// Panics where the kernel or an import does not exist: the sources are embedded, so that is a
/// mistake of this crate, which its tests find.
pub fn compose(kernel: &str, Text { paged, grey }: Text) -> Composed {
    let text = find(KERNELS, kernel).unwrap_or_else(|| panic!("no kernel wgsl/{kernel}.wgsl"));
    let mut composed = Composed { source: String::new(), lines: Vec::new() };
    let mut queue = vec![(format!("wgsl/{kernel}.wgsl"), text)];
    let mut seen = vec![];
    let mut next = 0;
    // Modules follow in the order of their first import: WGSL declarations may stand in any order.
    while next < queue.len() {
        let (file, text) = queue[next].clone();
        next += 1;
        for (i, line) in text.lines().enumerate() {
            composed.lines.push((file.clone(), i + 1));
            if let Some(name) = line.strip_prefix("#import ") {
                let name = name.trim();
                let name = PAGED.iter().find(|p| paged && p.0 == name).map_or(name, |p| p.1);
                let name = if grey && name == BANDS.0 { BANDS.1 } else { name };
                if !seen.contains(&name) {
                    let lib = find(LIBS, name).unwrap_or_else(|| panic!("{file}:{}: no wgsl/lib/{name}.wgsl", i + 1));
                    seen.push(name);
                    queue.push((format!("wgsl/lib/{name}.wgsl"), lib));
                }
                // Keep the line count.
                composed.source.push_str("//");
            }
            composed.source.push_str(&if paged { paged_line(line) } else { line.into() });
            composed.source.push('\n');
        }
    }
    composed
}
