//! The paper's figures, small: whole files, numbers in range, errors below a bound, the same bytes again.
//! On the twin, so that no driver is asked; `ci/pictures` makes them in full on a device.

use raycell::paper::{Figure, Press, fig1, fig2, fig3, fig4, page};
use raycell::{Backend, Error, Flow};
use std::collections::BTreeMap;
use std::path::Path;

fn press<T>(dir: &Path, make: impl FnOnce(&mut Press) -> T) -> T {
    make(&mut Press { dir, backend: &Backend::Cpu, seed: 1, tell: &mut |_| Flow::Continue })
}

/// The files of a folder.
fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let read = |e: std::fs::DirEntry| (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap());
    std::fs::read_dir(dir).unwrap().map(|e| read(e.unwrap())).collect()
}

/// Makes a figure twice, and asserts that its files are whole and the same.
fn twice(make: impl Fn(&mut Press) -> raycell::Result<Figure>) -> (Figure, tempfile::TempDir) {
    let made = [(); 2].map(|()| {
        let dir = tempfile::tempdir().unwrap();
        let figure = press(dir.path(), |p| make(p)).unwrap();
        page::write(dir.path(), std::slice::from_ref(&figure)).unwrap();
        (figure, dir)
    });
    let [(figure, dir), (again, other)] = made;
    assert_eq!(figure, again);
    let there = files(dir.path());
    assert!(there == files(other.path()), "the same seed makes the same bytes");
    let mut named = figure.files.clone();
    named.push("index.html".into());
    named.sort();
    assert_eq!(there.keys().cloned().collect::<Vec<_>>(), named, "all files are named, and nothing else is there");

    let png = image::load_from_memory(&there[&format!("{}.png", figure.name)]).expect("a PNG").to_rgb8();
    assert!(png.pixels().any(|p| p.0 != [255; 3]), "an empty picture");
    let svg = std::str::from_utf8(&there[&format!("{}.svg", figure.name)]).expect("text");
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n") && svg.contains("<text "), "an SVG");
    let html = std::str::from_utf8(&there["index.html"]).expect("text");
    assert!(html.contains("data:image/png;base64,") && html.ends_with("</html>\n"), "a page that needs no other file");
    for n in &figure.numbers {
        assert!(n.value.is_finite() && n.value >= 0.0, "{n:?}");
        eprintln!("{}: {}: {:.4} {}", figure.name, n.what, n.value, n.unit);
    }
    (figure, dir)
}

fn number(figure: &Figure, what: &str) -> f64 {
    let mut found = figure.numbers.iter().filter(|n| n.what.starts_with(what));
    let value = found.next().unwrap_or_else(|| panic!("no '{what}' in {:?}", figure.numbers)).value;
    assert!(found.next().is_none(), "'{what}' is there twice");
    value
}

/// The rows of a figure's data; every cell is a finite number.
fn rows(dir: &Path, name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(dir.join(name)).unwrap();
    let columns = text.lines().next().unwrap().split(',').count();
    let row = |l: &str| l.split(',').map(|c| c.parse().expect(l)).collect::<Vec<f64>>();
    let rows: Vec<Vec<f64>> = text.lines().skip(1).map(row).collect();
    assert!(!rows.is_empty() && rows.iter().flatten().all(|x| x.is_finite()), "{name}");
    assert!(rows.iter().all(|r| r.len() == columns), "{name}");
    rows
}

#[test]
fn figure_1_shows_one_solution_twice() {
    let options = fig1::Options { rays: 4096, width: 24, height: 16 };
    let (figure, dir) = twice(|p| fig1::make(p, &options));
    for view in ["hall", "enfilade"] {
        assert!(dir.path().join(format!("fig1_{view}.exr")).is_file());
    }
    // Every ray's weight is told; single precision and the clamp at 0 leave little. What is left is the scatter of 16,384
    // rays from emitters (four times the bake's): 1.5 %, three of them.
    assert!(number(&figure, "energy not accounted for") < 0.045);
}

#[test]
fn figure_2_fits_functions_of_the_plane() {
    let options = fig2::Options { cells: 100, points: 64, ..fig2::Options::default() };
    let (figure, dir) = twice(|p| fig2::make(p, &options));
    // A step that crosses the square blurs over a cell's width, n^-1/2 = 0.1, and takes about its root of the norm.
    let error = number(&figure, "error (the paper's");
    assert!(error < 0.3, "{error}");
    assert!(number(&figure, "error with local linear cells") < error);
    // Claim (c) of the paper: samples go where the function varies. Evenly drawn, a tenth of them would.
    let (with, without) = (number(&figure, "samples in the tenth"), number(&figure, "the same without resampling"));
    assert!(with > 1.4 * without && (without - 0.1).abs() < 0.03, "{with} {without}");
    for row in rows(dir.path(), "fig2.csv") {
        assert!(row.iter().all(|x| (-0.1..=1.1).contains(x)), "{row:?}");
    }
    let cells = rows(dir.path(), "fig2_cells.csv").len();
    assert_eq!(cells, 100);
    for edge in rows(dir.path(), "fig2_edges.csv") {
        assert!(edge[0] < edge[1] && (edge[1] as usize) < cells, "{edge:?}");
    }
    let samples = rows(dir.path(), "fig2_samples.csv");
    assert_eq!(samples.len(), 2400);

    // A smooth function is easier; an image is a function, too.
    let bells = fig2::Options { function: "bells".into(), ..options.clone() };
    let dir = tempfile::tempdir().unwrap();
    let smooth = press(dir.path(), |p| fig2::make(p, &bells)).unwrap();
    assert!(number(&smooth, "error (the paper's") < 0.5 * error);
    let path = dir.path().join("half.png");
    image::GrayImage::from_fn(16, 16, |x, _| image::Luma([if x < 8 { 0 } else { 200 }])).save(&path).unwrap();
    let half = fig2::Function::named(path.to_str().unwrap()).unwrap();
    assert!(half.at(0.1, 0.5) == 0.0 && (half.at(0.9, 0.5) - 200.0 / 255.0).abs() < 1e-6);
    for (wrong, cells, k) in [("nonsense", 100, 2), ("ridge-step", 1, 2), ("ridge-step", 100, 5)] {
        let options = fig2::Options { function: wrong.into(), cells, k, ..fig2::Options::default() };
        assert!(matches!(press(dir.path(), |p| fig2::make(p, &options)), Err(Error::InvalidParam { .. })), "{wrong}");
    }
}

#[test]
fn figure_3_shows_the_kernel_and_its_fissure() {
    let options = fig3::Options { cells: 256, evaluations: 8192, points: 48, patches: 50 };
    let (figure, dir) = twice(|p| fig3::make(p, &options));
    let kernel = rows(dir.path(), "fig3.csv");
    // cos cos/(2 r) between parallel walls 0.6 m apart: at most 1/1.2 per metre, and 0 in the fissure.
    let closed = |s: f64, t: f64| 0.36 / (2.0 * (0.36 + (s - t) * (s - t)).powf(1.5));
    let dark = kernel.iter().filter(|r| r[3] == 0.0).count() as f64 / kernel.len() as f64;
    assert!((0.1..0.3).contains(&dark), "{dark}");
    for r in kernel.iter().filter(|r| r[3] != 0.0) {
        assert!((r[3] / closed(r[0], r[1]) - 1.0).abs() < 1e-4, "{r:?}");
    }
    assert!(kernel.iter().all(|r| r[2] == 1.0 || (r[2] - 0.4).abs() < 1e-6), "the wall's energy");
    // A quarter of the cells of the full figure (0.10): an edge's error falls about with the root of their width.
    assert!(number(&figure, "kernel error of the paper's network") < 0.25);
    assert!(number(&figure, "error of the light: the paper's network") < 0.06);
    assert!(number(&figure, "error of the light: flux mode") < 0.03);
    // Finite elements sample the shadow's edges once a patch: about 1/50 of what they carry is on the wrong side.
    assert!(number(&figure, "error of the light: finite elements") < 0.03);
    let (with, without) =
        (number(&figure, "samples in the tenth of the pairs"), number(&figure, "the same share without resampling"));
    assert!(with > 1.4 * without, "{with} {without}");
    for name in ["fig3_cells.csv", "fig3_flux_cells.csv", "fig3_samples.csv"] {
        assert!(rows(dir.path(), name).iter().flatten().all(|x| (0.0..=1.0).contains(x)), "{name}");
    }
}

#[test]
fn figure_4_shows_one_reflection_both_ways() {
    let options = fig4::Options { flat_cells: 256, cells: 256, evaluations: 16, width: 24, points: 48 };
    // In flatland the figure's own size: a quarter of the cells errs by .12 or .35, as chance has it.
    let whole = fig4::Options { flat_cells: 1024, evaluations: 32, ..options.clone() };
    let (flat, dir) = twice(|p| fig4::flat(p, &whole));
    // Positions alone mix the blocker's sides: an error as good as the repaired network's would not be the paper's.
    let (paper, repaired) = (number(&flat, "error of the reflected light"), number(&flat, "with normals and linear cells"));
    assert!(paper < 1.0 && repaired < 0.5 * paper, "{paper} {repaired}");
    for row in rows(dir.path(), "fig4a.csv") {
        // At most what stands right under the light gets.
        assert!((0.0..=4.65).contains(&row[0]) && (0.0..0.7).contains(&row[1]), "{row:?}");
    }
    let (solid, dir) = twice(|p| fig4::solid(p, &options));
    let (paper, repaired) = (number(&solid, "error of the light on the floor"), number(&solid, "with normals and linear"));
    assert!(paper < 1.0 && repaired < paper, "{paper} {repaired}");
    assert_eq!(rows(dir.path(), "fig4bc.csv").len(), 48 * 48);
}

#[test]
fn a_figure_that_cannot_be_written_is_an_error() {
    let options = fig2::Options { cells: 16, points: 16, ..fig2::Options::default() };
    let gone = press(Path::new("gone/and/gone"), |p| fig2::make(p, &options));
    assert!(matches!(gone, Err(Error::Write { .. })), "{gone:?}");
    let dir = tempfile::tempdir().unwrap();
    let mut tell = |_: &raycell::Event| Flow::Stop;
    let mut stopped = Press { dir: dir.path(), backend: &Backend::Cpu, seed: 1, tell: &mut tell };
    assert!(matches!(fig2::make(&mut stopped, &options), Err(Error::Cancelled)));
    assert!(files(dir.path()).is_empty());
}
