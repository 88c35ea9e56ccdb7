//! The catalogue itself: every case has a test, or says why it has none.

use super::common::root;

/// Cases that the catalogue has.
const CASES: usize = 105;
/// Most cases that may be not applicable.
const LEFT_OUT: usize = 8;
const SOURCES: [&str; 8] = [
    include_str!("geometry.rs"),
    include_str!("input.rs"),
    include_str!("scale.rs"),
    include_str!("visibility.rs"),
    include_str!("solutions.rs"),
    include_str!("network.rs"),
    include_str!("sums.rs"),
    include_str!("gpu.rs"),
];

#[test]
fn every_case_has_a_test_or_says_why_not() {
    let text = std::fs::read_to_string(root("docs/hard_cases.md")).unwrap();
    let rows: Vec<Vec<&str>> = text
        .lines()
        .filter(|line| line.starts_with("| ") && line.as_bytes()[3].is_ascii_digit())
        .map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect())
        .collect();
    assert_eq!(rows.len(), CASES);
    let (mut left_out, mut missing) = (0, Vec::new());
    for row in &rows {
        let test = format!("#[test]\nfn {}_", row[0].to_lowercase());
        let tested = SOURCES.iter().any(|source| source.contains(&test));
        let excluded = row[row.len() - 1].contains("n/a:");
        left_out += usize::from(excluded);
        if tested == excluded {
            missing.push(row[0]);
        }
    }
    assert!(missing.is_empty(), "neither tested nor not applicable, or both: {missing:?}");
    assert!(left_out <= LEFT_OUT, "{left_out} cases are not applicable, {LEFT_OUT} may be");
}
