//! Point lists: `--points in.csv` and the answering `points.csv`.
//!
//! In: columns `px,py,pz` (metres) and `nx,ny,nz` in any order, others ignored. Out: the same rows in
//! the same order with `B` (radiosity), `H` (irradiance) and `D` (direct irradiance), W/m² a band, and
//! `status`: `ok`, `covered` (dark by construction), or `off_surface` and `mirror` (an ideal one has no radiosity), whose
//! number cells are empty.

use super::atomic;
use crate::error::{Error, Result};
use crate::solution::{Answer, Status, SurfacePoint};
use std::path::Path;

const IN: [&str; 6] = ["px", "py", "pz", "nx", "ny", "nz"];
const OUT: &str = "px,py,pz,nx,ny,nz,B_r,B_g,B_b,H_r,H_g,H_b,D_r,D_g,D_b,status";

/// Reads a point list, one [`SurfacePoint`] a row.
///
/// Errors: [`Error::Read`], and those of [`parse`].
pub fn read(path: &Path) -> Result<Vec<SurfacePoint>> {
    // Read whole, so that a bad path is a reading error and not a formatting one.
    let bytes = std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?;
    parse(path, &bytes)
}

/// Reads a point list from memory; `path` is for messages. Normals stay as long as they are written: the
/// answer repeats them.
///
/// Errors: [`Error::Format`] with the line where a column is missing or there twice, a row is short, a cell is not a
/// finite number, or a normal has no length.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<SurfacePoint>> {
    let refuse = |line: u64, what: String, cure: &str| Error::Format {
        path: path.into(),
        line: Some(line as usize),
        what,
        cure: if cure.is_empty() { format!("a point list has the columns {}", IN.join(",")) } else { cure.into() },
    };
    let fail = |line: u64, what: String| refuse(line, what, "");
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(refuse(1, "the file is UTF-16".into(), "save it as UTF-8"));
    }
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    // A record's position is where the one before it ended; empty lines between them count, too.
    let line_of = |at: Option<&csv::Position>| {
        let (line, from) = at.map_or((1, 0), |p| (p.line(), p.byte() as usize));
        let empty = bytes.get(from..).unwrap_or_default().iter().take_while(|b| b"\r\n".contains(b));
        line + empty.filter(|b| **b == b'\n').count() as u64
    };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let header = reader.byte_headers().map_err(|e| fail(1, e.to_string()))?.clone();
    let mut column = [0; 6];
    for (name, column) in IN.iter().zip(&mut column) {
        let mut found = header.iter().enumerate().filter(|(_, h)| *h == name.as_bytes());
        *column = match (found.next(), found.next()) {
            (Some((at, _)), None) => at,
            (Some(_), Some(_)) => return Err(fail(1, format!("column '{name}' is there twice"))),
            (None, _) if header.len() == 1 && header[0].iter().any(|c| b"; \t".contains(c)) => {
                let cure = "separate columns by commas and write decimals with a point";
                return Err(refuse(1, "the columns are not separated by commas".into(), cure));
            }
            (None, _) => return Err(fail(1, format!("column '{name}' is missing"))),
        };
    }
    let mut points = Vec::new();
    for record in reader.byte_records() {
        let record = record.map_err(|e| {
            let what = match e.kind() {
                csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
                    format!("{len} cells where the header has {expected_len}")
                }
                _ => e.to_string(),
            };
            refuse(line_of(e.position()), what, "fill the row up, or look for a quote that is not closed")
        })?;
        let line = || line_of(record.position());
        let mut v = [0.0; 6];
        for k in 0..6 {
            let cell = String::from_utf8_lossy(record.get(column[k]).unwrap_or_default());
            v[k] = cell
                .parse()
                .ok()
                .filter(|x: &f64| x.is_finite())
                .ok_or_else(|| fail(line(), format!("'{}' in column '{}' is not a finite number", short(&cell), IN[k])))?;
        }
        let point = SurfacePoint { p: [v[0], v[1], v[2]], n: [v[3], v[4], v[5]] };
        if point.n == [0.0; 3] {
            return Err(fail(line(), "the normal has no length".into()));
        }
        points.push(point);
    }
    Ok(points)
}

/// The beginning of a cell: messages are for reading.
fn short(cell: &str) -> String {
    if cell.chars().count() > 40 { cell.chars().take(40).chain(['…']).collect() } else { cell.into() }
}

/// Writes the answers. Numbers are the shortest that read back as themselves: same answers, same bytes.
///
/// Errors: [`Error::Write`]; [`Error::NotFinite`] rather than a number that is none.
pub fn write(path: &Path, points: &[SurfacePoint], answers: &[Answer]) -> Result<()> {
    assert_eq!(points.len(), answers.len(), "one answer a point");
    let mut text = format!("{OUT}\n");
    for (i, (point, answer)) in points.iter().zip(answers).enumerate() {
        for x in point.p.iter().chain(&point.n) {
            text += &number(*x);
            text.push(',');
        }
        let status = match answer.status {
            Status::Ok => "ok",
            Status::Covered => "covered",
            Status::OffSurface => "off_surface",
            Status::Mirror => "mirror",
        };
        let numbers = matches!(answer.status, Status::Ok | Status::Covered);
        for x in [answer.b, answer.h, answer.d].as_flattened() {
            if numbers {
                if !x.is_finite() {
                    return Err(Error::NotFinite { what: format!("the light at point {i}") });
                }
                text += &number(*x);
            }
            text.push(',');
        }
        text += status;
        text.push('\n');
    }
    atomic::write(path, text.as_bytes())
}

/// Shortest text that reads back as the same number.
pub(crate) fn number(x: f64) -> String {
    let text = format!("{x:?}");
    text.strip_suffix(".0").map(str::to_string).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Vec<SurfacePoint>> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("in.csv");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    #[test]
    fn columns_in_any_order_others_ignored() {
        let points = read_text("\u{feff}id, nz,ny,nx,note,pz,py,px\n7,0,1,0,\"a, b\nc\",3, 2 ,1e0\r\n8,-1,0,0,,6,5,4\n").unwrap();
        assert_eq!(points[0], SurfacePoint { p: [1.0, 2.0, 3.0], n: [0.0, 1.0, 0.0] });
        assert_eq!(points[1], SurfacePoint { p: [4.0, 5.0, 6.0], n: [0.0, 0.0, -1.0] });
        assert!(read_text("px,py,pz,nx,ny,nz\n").unwrap().is_empty());
    }

    #[test]
    fn bad_cells_are_named() {
        for (text, part) in [
            ("", "in.csv:1: column 'px' is missing"),
            ("px,py,pz,nx,ny\n", "in.csv:1: column 'nz' is missing"),
            ("px,py,pz,nx,ny,nz\n0,0,0,0,1,0\n0,x,0,0,1,0\n", "in.csv:3: 'x' in column 'py'"),
            ("px,py,pz,nx,ny,nz\n0,0,nan,0,1,0\n", "in.csv:2: 'nan' in column 'pz'"),
            ("px,py,pz,nx,ny,nz\n0,0,0,0,0,0\n", "in.csv:2: the normal has no length"),
            ("px,py,pz,nx,ny,nz\n0,0,0\n", "in.csv:2: 3 cells where the header has 6; fill"),
            ("px,py,pz,nx,ny,nz\n0,0,0,0,1,0\n\n\n0,0,1e999,0,1,0\n", "in.csv:5: '1e999' in column 'pz'"),
            ("px,py,pz,nx,ny,nz\r\n0,0,0,0,1,0\r\n\r\n0,0,x,0,1,0\r\n", "in.csv:4: 'x' in column 'pz'"),
            ("\u{feff}px,py,pz,nx,ny,nz,t\n0,0,0,0,1,0,\"a\nb\"\n0,0,0,0,1\n", "in.csv:4: 5 cells"),
            ("px,py,px,pz,nx,ny,nz\n", "in.csv:1: column 'px' is there twice"),
            ("px;py;pz;nx;ny;nz\n0,5;0;0;0;1;0\n", "in.csv:1: the columns are not separated by commas; separate"),
            ("px py pz nx ny nz\n0 0 0 0 1 0\n", "in.csv:1: the columns are not separated by commas"),
        ] {
            let got = read_text(text).expect_err(text).to_string();
            assert!(got.contains(part), "expected {part:?} in {got:?}");
        }
    }

    #[test]
    fn spreadsheets_other_habits() {
        assert!(matches!(parse(Path::new("in.csv"), b"\xff\xfep\0x\0"), Err(Error::Format { line: Some(1), .. })));
        let quoted =
            parse(Path::new("in.csv"), b"\"px\",\"py\",\"pz\",\"nx\",\"ny\",\"nz\"\r\n\"1\",2,3,0,0,\"-5\"\r\n").unwrap();
        // A normal's length is its author's.
        assert_eq!(quoted, [SurfacePoint { p: [1.0, 2.0, 3.0], n: [0.0, 0.0, -5.0] }]);
        let long = format!("px,py,pz,nx,ny,nz\n{},0,0,0,1,0\n", "x".repeat(1 << 20));
        assert!(parse(Path::new("in.csv"), long.as_bytes()).unwrap_err().to_string().len() < 200);
    }

    #[test]
    fn a_million_rows() {
        let mut text = String::from("px,py,pz,nx,ny,nz\n");
        (0..1_000_000).for_each(|i| text += &format!("{i}.5,-0.25,1e-3,0,1,0\n"));
        let points = parse(Path::new("in.csv"), text.as_bytes()).unwrap();
        assert_eq!((points.len(), points[999_999].p[0]), (1_000_000, 999_999.5));
    }

    #[test]
    fn answers_keep_their_rows() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("points.csv");
        let points = [SurfacePoint { p: [0.1, -2.0, 1e-9], n: [0.0, 1.0, 0.0] }; 2];
        let ok = Answer { status: Status::Ok, b: [0.5, 1.0, 2.0], h: [3.0; 3], d: [0.25; 3] };
        let off = Answer { status: Status::OffSurface, b: [f64::NAN; 3], h: [f64::NAN; 3], d: [f64::NAN; 3] };
        write(&path, &points, &[ok, off]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(
            text,
            format!("{OUT}\n0.1,-2,1e-9,0,1,0,0.5,1,2,3,3,3,0.25,0.25,0.25,ok\n0.1,-2,1e-9,0,1,0,,,,,,,,,,off_surface\n")
        );
        // The answer is itself a point list.
        assert_eq!(read(&path).unwrap(), points);
        let mirror = Answer { status: Status::Mirror, b: [0.0; 3], h: [0.0; 3], d: [0.0; 3] };
        write(&path, &points[..1], &[mirror]).unwrap();
        assert!(std::fs::read_to_string(&path).unwrap().ends_with("\n0.1,-2,1e-9,0,1,0,,,,,,,,,,mirror\n"));
        let nan = Answer { status: Status::Ok, ..off };
        assert!(matches!(write(&path, &points, &[ok, nan]), Err(Error::NotFinite { .. })));
    }
}
