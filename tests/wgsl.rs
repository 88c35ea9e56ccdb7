//! The shaders without a GPU: they parse, validate within the feature budget, keep the limits, and
//! share their records with the host byte for byte.

use naga::valid::{Capabilities, ValidationFlags, Validator};
use raycell::gpu::Constants;
use raycell::gpu::specialise::specialise;
use raycell::gpu::wgsl::{KERNELS, LIBS, Text, compose};
use std::collections::BTreeSet;
use std::mem::{offset_of, size_of};

/// Textures that hold what effects read.
const EFFECTS: [&str; 3] = ["sky", "lights", "texels"];

/// Parses a kernel; a failure names the true file and line.
fn parse(kernel: &str) -> naga::Module {
    parse_text(kernel, false)
}

fn parse_text(kernel: &str, paged: bool) -> naga::Module {
    let composed = compose(kernel, Text { paged, grey: false });
    naga::front::wgsl::parse_str(&composed.source).unwrap_or_else(|e| {
        let at = e.location(&composed.source).map_or(String::new(), |l| composed.locate(l.line_number as usize));
        panic!("{at}: {}", e.emit_to_string(&composed.source))
    })
}

#[test]
fn every_file_is_listed() {
    assert!(!KERNELS.is_empty() && !LIBS.is_empty());
    for (folder, list) in [("wgsl", KERNELS), ("wgsl/lib", LIBS)] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let on_disk: BTreeSet<String> = std::fs::read_dir(path)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter_map(|name| name.strip_suffix(".wgsl").map(String::from))
            .collect();
        let listed: BTreeSet<String> = list.iter().map(|(name, _)| name.to_string()).collect();
        assert_eq!(on_disk, listed, "{folder}");
    }
}

#[test]
fn kernels_validate_within_the_budget() {
    let mut paged_texts = 0;
    for (kernel, paged) in KERNELS.iter().flat_map(|(kernel, _)| [(kernel, false), (kernel, true)]) {
        let composed = compose(kernel, Text { paged, grey: false });
        let module = parse_text(kernel, paged);
        // No capability at all: core WebGPU only.
        Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).unwrap_or_else(|e| {
            let at = e.location(&composed.source).map_or(String::new(), |l| composed.locate(l.line_number as usize));
            panic!("{kernel} {at}: {}", e.emit_to_string(&composed.source))
        });

        assert_eq!(module.entry_points.len(), 1, "{kernel}");
        let entry = &module.entry_points[0];
        assert_eq!(entry.name, "main", "{kernel}");
        assert_eq!(entry.workgroup_size, [raycell::gpu::kernel::WORKGROUP, 1, 1], "{kernel}");

        // Binding 0 is the uniform; storage buffers follow without a gap.
        let (mut bindings, mut effects, mut textures) = (BTreeSet::new(), BTreeSet::new(), 0);
        for (_, var) in module.global_variables.iter() {
            let Some(binding) = &var.binding else {
                continue;
            };
            assert_eq!(binding.group, 0, "{kernel}");
            match var.space {
                naga::AddressSpace::Uniform => assert_eq!(binding.binding, 0, "{kernel}"),
                naga::AddressSpace::Storage { .. } => assert!(bindings.insert(binding.binding), "{kernel}"),
                // An effect's data, which takes no storage buffer, behind them.
                naga::AddressSpace::Handle if EFFECTS.contains(&var.name.as_deref().unwrap_or_default()) => {
                    assert!(effects.insert(binding.binding), "{kernel}");
                }
                // A scene's records, where they are paged.
                naga::AddressSpace::Handle if paged => {
                    assert!(bindings.insert(binding.binding), "{kernel}");
                    textures += 1;
                }
                other => panic!("{kernel}: {other:?}"),
            }
        }
        assert!(bindings.len() <= 8, "{kernel} binds {} storage buffers", bindings.len());
        assert_eq!(bindings, (1..=bindings.len() as u32).collect(), "{kernel}");
        let behind = bindings.len() as u32 + 1;
        assert_eq!(effects, (behind..behind + effects.len() as u32).collect(), "{kernel}");
        // Every binding of triangles or boxes is paged together with the module that reads it.
        let records = composed.source.matches("array<Tri>;").count() + composed.source.matches("array<BvhNode>;").count();
        assert!(!paged || records == 0, "{kernel}");
        paged_texts += usize::from(textures > 0);
    }
    assert_eq!(paged_texts, 10, "emit, probe, shoot, kernel, direct, assign, gather, deposit, flux, feature");
}

/// Kernels of a scene that calls for nothing but space and shadows are, byte for byte, those of a source tree without the
/// effects: kept in `tests/data/kernels`, with their instructions and bindings. Where a kernel itself is changed on purpose the
/// new text is taken over from where this test leaves it; where an effect was added it must not change.
#[test]
fn effects_that_are_not_called_for_leave_no_trace() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let (kept, made) = (root.join("tests/data/kernels"), root.join("target/kernels"));
    std::fs::create_dir_all(&made).unwrap();
    let mut files = vec![("counts.csv".to_string(), "kernel,instructions,bindings\n".to_string())];
    for (kernel, _) in KERNELS {
        let special = specialise(&compose(kernel, Text::default()), &Constants::NONE).unwrap();
        files[0].1 += &format!("{kernel},{},{}\n", special.instructions, special.bindings.len());
        files.push((format!("{kernel}.wgsl"), special.source));
    }
    let mut differ = Vec::new();
    for (name, text) in files {
        std::fs::write(made.join(&name), &text).unwrap();
        if std::fs::read_to_string(kept.join(&name)).ok() != Some(text) {
            differ.push(name);
        }
    }
    assert!(differ.is_empty(), "{differ:?}: other than in {}; now in {}", kept.display(), made.display());
}

/// Name and offset of each member, and the size, of a struct of a module.
fn layout_of(module: &naga::Module, name: &str) -> Option<(Vec<(String, usize)>, usize)> {
    module.types.iter().find_map(|(_, ty)| match &ty.inner {
        naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some(name) => {
            let members = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize)).collect();
            Some((members, *span as usize))
        }
        _ => None,
    })
}

/// The same of a Rust struct.
macro_rules! layout {
    ($ty:path { $($member:ident),* $(,)? }) => {{
        use $ty as Record;
        (vec![$((stringify!($member).to_string(), offset_of!(Record, $member))),*], size_of::<Record>())
    }};
}

#[test]
fn records_match() {
    use raycell::layout;
    let text = LIBS.iter().find(|(name, _)| *name == "layout").unwrap().1;
    let module = naga::front::wgsl::parse_str(text).unwrap();
    let records = [
        ("BvhNode", layout!(layout::BvhNode { min, count, max, first })),
        ("Tri", layout!(layout::Tri { v0, material, v1, plane, v2, first_tile, normal, split })),
        ("Material", layout!(layout::Material { rho, pad0, emit, pad1 })),
        ("Emitter", layout!(layout::Emitter { tri, cdf, density, near2 })),
        ("Lamp", layout!(layout::Lamp { p, slope, value, offset, d, pad0 })),
        ("Tile", layout!(layout::Tile { cdf, density })),
        ("Point", layout!(layout::Point { p, tri, tile, kind, weight, density })),
        ("Node", layout!(layout::Node { p, material, n, plane, mean, gain, clear })),
        ("Psi", layout!(layout::Psi { node, weight })),
        ("NodeLight", layout!(layout::NodeLight { h, pad0, g0, pad1, g1, pad2 })),
        ("Candidate", layout!(layout::Candidate { node, free })),
        ("DirectSum", layout!(layout::DirectSum { sum, rounds, square, pad0 })),
        ("Fixed", layout!(layout::Fixed { lo, hi })),
        ("CellSums", layout!(layout::CellSums { feature, distortion, count, pad0 })),
        ("Slot", layout!(layout::Slot { key, pad0, value, first, second })),
        ("CellFlux", layout!(layout::CellFlux { flux, source })),
        ("NodeSums", layout!(layout::NodeSums { mass, first, second, square, pad0 })),
        ("NodeSource", layout!(layout::NodeSource { value, first, second })),
        ("Link", layout!(layout::Link { other, value, first, second })),
        ("Plane", layout!(layout::Plane { i11, i12, i22, material })),
        ("Sample", layout!(layout::Sample { winner, goal, weight, output })),
        ("CellOutput", layout!(layout::CellOutput { slope, value, width, pad0 })),
        ("ResponseSums", layout!(layout::ResponseSums { feature, count, share, error, gain, activation })),
    ];
    for (name, rust) in &records {
        let wgsl = layout_of(&module, name).unwrap_or_else(|| panic!("{name} is missing in wgsl/lib/layout.wgsl"));
        assert_eq!(&wgsl, rust, "{name}");
    }
    // And nothing in WGSL that Rust lacks.
    let named = module.types.iter().filter(|(_, ty)| matches!(ty.inner, naga::TypeInner::Struct { .. })).count();
    assert_eq!(named, records.len());
}

#[test]
fn parameters_match() {
    use raycell::pass;
    let params = [
        ("sentinel", layout!(raycell::gpu::sentinel::Params { base, count, trips, bits })),
        ("emit", layout!(pass::emit::Params { base, count, flag, seed, first, total, tiles, rays, bits, pad0, pad1, pad2 })),
        ("probe", layout!(pass::emit::ProbeParams { base, count, flag, seed, first, pad0, pad1, pad2 })),
        ("shoot", layout!(pass::shoot::Params { base, count, flag, seed, first, rays, pad0, pad1 })),
        ("kernel", layout!(pass::kernel::Params { base, count, flag, pad0 })),
        (
            "direct",
            layout!(pass::direct::Params {
                base,
                count,
                flag,
                seed,
                first,
                rounds,
                emitter,
                cosine,
                emitters,
                emitter_density,
                pad0,
                pad1
            }),
        ),
        ("assign", layout!(pass::assign::Params { base, count, flag, inv_unit, lambda, first_list, joint, pad1 })),
        ("feature", layout!(pass::feature::Params { base, count, inv_unit, lambda, mu, pad0, pad1, pad2 })),
        ("winner", layout!(pass::winner::Params { base, count, flag, features, first, end, pad0, pad1 })),
        ("accumulate", layout!(pass::accumulate::Params { base, count, start, pad0 })),
        ("adapt", layout!(pass::adapt::Params { base, count, flag, eta })),
        (
            "coefficients",
            layout!(pass::coefficients::Params {
                base,
                count,
                flag,
                first,
                end,
                slots,
                masses,
                normalise,
                rays,
                pad0,
                pad1,
                pad2
            }),
        ),
        ("deposit", layout!(pass::deposit::Params { base, count, known, normalise })),
        ("flux", layout!(pass::coefficients::FluxParams { base, count, exact, normalise })),
        ("beta", layout!(pass::jacobi::Params { base, count, flag, pad0 })),
        ("update", layout!(pass::jacobi::Params { base, count, flag, pad0 })),
        ("readout", layout!(pass::readout::Params { base, count, pad0, pad1 })),
        ("respond", layout!(pass::respond::Params { base, count, flag, linear, rows, pad0, pad1, pad2 })),
        ("gather", layout!(pass::gather::Params { base, count, flag, rays, first, end, lit, exact })),
    ];
    let listed: BTreeSet<&str> = params.iter().map(|(kernel, _)| *kernel).collect();
    assert_eq!(listed, KERNELS.iter().map(|(name, _)| *name).collect(), "a kernel's Params are not compared");
    for (kernel, rust) in params {
        let wgsl = layout_of(&parse(kernel), "Params").unwrap_or_else(|| panic!("{kernel} has no Params"));
        assert_eq!(wgsl, rust, "{kernel}");
        assert_eq!(rust.0[..2], [("base".to_string(), 0), ("count".to_string(), 4)], "{kernel}");
    }
}

#[test]
fn blocks_match() {
    use raycell::pass::winner::Block;
    let rust = layout!(Block { low, start, low_n, end, high, pad0, high_n, pad1 });
    assert_eq!(layout_of(&parse("winner"), "Block").unwrap(), rust);
}

#[test]
fn composed_lines_lead_back_to_their_files() {
    let composed = compose("shoot", Text::default());
    let count = composed.source.lines().count();
    assert_eq!(composed.lines.len(), count);
    for (name, text) in [("wgsl/shoot.wgsl", KERNELS), ("wgsl/lib/ray.wgsl", LIBS)] {
        let short = name.rsplit('/').next().unwrap().trim_end_matches(".wgsl");
        let original: Vec<&str> = text.iter().find(|(n, _)| *n == short).unwrap().1.lines().collect();
        let mine: Vec<usize> = (0..count).filter(|&i| composed.lines[i].0 == name).collect();
        // Every module comes once, line by line.
        assert_eq!(mine.len(), original.len(), "{name}");
        for (k, &i) in mine.iter().enumerate() {
            assert_eq!(composed.locate(i + 1), format!("{name}:{}", k + 1));
            assert!(composed.source.lines().nth(i).unwrap().ends_with(original[k]), "{name}:{}", k + 1);
        }
    }
}
