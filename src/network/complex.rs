//! The cells' topology: a complex of k-dimensional simplices, after growing cell structures (Fritzke 1994):
//! insertion splits an edge with all its simplices, deletion keeps what still holds.

/// Simplices of one dimension over cells, with the inverse table.
#[derive(Clone, Debug)]
pub struct Complex {
    /// Cells of a simplex: k + 1.
    corners: usize,
    /// The simplices' cells, `corners` each.
    simplices: Vec<u32>,
    of_cell: Vec<Vec<u32>>,
}

impl Complex {
    /// One simplex of dimension `k` (1: an edge, 2: a triangle) over cells 0 to k.
    pub fn simplex(k: usize) -> Complex {
        Complex { corners: k + 1, simplices: (0..=k as u32).collect(), of_cell: vec![vec![0]; k + 1] }
    }

    /// No simplex at all: the complex of cells that were not grown.
    pub fn empty() -> Complex {
        Complex { corners: 3, simplices: Vec::new(), of_cell: Vec::new() }
    }

    /// The complex of dimension `k` that [`Complex::simplices`] of `cells` cells described. None where a simplex
    /// repeats a cell or names one that is not there, or a cell is in no simplex.
    pub fn from_simplices(k: usize, cells: usize, simplices: Vec<u32>) -> Option<Complex> {
        let corners = k + 1;
        if !simplices.len().is_multiple_of(corners) {
            return None;
        }
        let mut of_cell = vec![Vec::new(); cells];
        for (i, s) in simplices.chunks_exact(corners).enumerate() {
            for &c in s {
                of_cell.get_mut(c as usize)?.push(i as u32);
            }
        }
        // The order in which a cell lists its simplices leaves no trace: splits and deletions work on sets.
        let complex = Complex { corners, simplices, of_cell };
        complex.check().ok().map(|()| complex)
    }

    /// The dimension k of the simplices.
    pub fn k(&self) -> usize {
        self.corners - 1
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.of_cell.len()
    }

    /// The cells of all simplices, k + 1 each.
    pub fn simplices(&self) -> &[u32] {
        &self.simplices
    }

    /// The cells of a simplex.
    fn simplex_at(&self, s: u32) -> &[u32] {
        &self.simplices[s as usize * self.corners..(s as usize + 1) * self.corners]
    }

    /// All edges once, the lower cell first, ascending.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        (0..self.cells() as u32)
            .flat_map(|c| self.neighbours(c).into_iter().filter(move |&n| n > c).map(move |n| [c, n]))
            .collect()
    }

    /// Cells that share an edge with `cell`, ascending.
    pub fn neighbours(&self, cell: u32) -> Vec<u32> {
        let mut n: Vec<u32> =
            self.of_cell[cell as usize].iter().flat_map(|&s| self.simplex_at(s)).copied().filter(|&c| c != cell).collect();
        n.sort_unstable();
        n.dedup();
        n
    }

    /// All neighbourhoods in CSR form.
    pub fn adjacency(&self) -> (Vec<u32>, Vec<u32>) {
        let (mut offsets, mut all) = (vec![0], Vec::new());
        for c in 0..self.cells() as u32 {
            all.extend(self.neighbours(c));
            offsets.push(all.len() as u32);
        }
        (offsets, all)
    }

    /// Splits the edge (q, f): a new cell in its middle, every simplex that holds the edge becomes two.
    /// Returns the new cell. The edge must exist.
    pub fn split(&mut self, q: u32, f: u32) -> u32 {
        let new = self.of_cell.len() as u32;
        self.of_cell.push(Vec::new());
        let sharing: Vec<u32> = self.of_cell[q as usize].iter().copied().filter(|&s| self.simplex_at(s).contains(&f)).collect();
        debug_assert!(!sharing.is_empty(), "({q}, {f}) is no edge");
        for s in sharing {
            // The old simplex keeps q, its copy keeps f; both get the new cell.
            let copy = (self.simplices.len() / self.corners) as u32;
            let old = self.simplex_at(s).to_vec();
            self.simplices.extend(old.iter().map(|&c| if c == q { new } else { c }));
            for c in &mut self.simplices[s as usize * self.corners..(s as usize + 1) * self.corners] {
                *c = if *c == f { new } else { *c };
            }
            self.of_cell[f as usize].retain(|&x| x != s);
            self.of_cell[f as usize].push(copy);
            self.of_cell[new as usize].extend([s, copy]);
            for c in old {
                if c != q && c != f {
                    self.of_cell[c as usize].push(copy);
                }
            }
        }
        new
    }

    /// Deletes the cells marked, every simplex that holds one, and cells left without a simplex.
    /// Refuses (returns `None`, nothing changed) where no simplex would be left.
    /// Returns for each old cell its new index.
    pub fn delete(&mut self, doomed: &[bool]) -> Option<Vec<Option<u32>>> {
        let whole = |s: &&[u32]| s.iter().all(|&c| !doomed[c as usize]);
        let kept: Vec<u32> = self.simplices.chunks_exact(self.corners).filter(whole).flatten().copied().collect();
        if kept.is_empty() {
            return None;
        }
        let mut used = vec![false; self.cells()];
        for c in &kept {
            used[*c as usize] = true;
        }
        let mut next = 0;
        let map: Vec<Option<u32>> = used
            .iter()
            .map(|&u| {
                u.then(|| {
                    next += 1;
                    next - 1
                })
            })
            .collect();
        self.simplices = kept.into_iter().map(|c| map[c as usize].unwrap_or(0)).collect();
        self.of_cell = vec![Vec::new(); next as usize];
        for (i, &c) in self.simplices.iter().enumerate() {
            self.of_cell[c as usize].push((i / self.corners) as u32);
        }
        Some(map)
    }

    /// Checks every invariant: at least k + 1 cells, distinct corners, every cell in a simplex, both
    /// tables agree. Errors name the first violation.
    pub fn check(&self) -> Result<(), String> {
        if self.cells() < self.corners {
            return Err(format!("{} cells are fewer than a simplex has", self.cells()));
        }
        for (i, s) in self.simplices.chunks_exact(self.corners).enumerate() {
            if s.iter().enumerate().any(|(k, c)| s[..k].contains(c)) {
                return Err(format!("simplex {i} {s:?} repeats a cell"));
            }
            for &c in s {
                if c as usize >= self.cells() || !self.of_cell[c as usize].contains(&(i as u32)) {
                    return Err(format!("cell {c} does not list its simplex {i}"));
                }
            }
        }
        for (c, list) in self.of_cell.iter().enumerate() {
            if list.is_empty() {
                return Err(format!("cell {c} is in no simplex"));
            }
            if let Some(s) = list.iter().find(|&&s| !self.simplex_at(s).contains(&(c as u32))) {
                return Err(format!("cell {c} lists simplex {s}, which does not hold it"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariants_hold_through_random_insertions_and_deletions() {
        let mut state = 1u32;
        let mut random = |n: usize| {
            state = crate::twin::math::hash(state.wrapping_add(1));
            state as usize % n
        };
        for k in 1..=4 {
            let mut complex = Complex::simplex(k);
            for step in 0..3_000 {
                let cells = complex.cells();
                if step % 3 < 2 {
                    let q = random(cells) as u32;
                    let n = complex.neighbours(q);
                    let f = n[random(n.len())];
                    let new = complex.split(q, f);
                    assert!(complex.neighbours(new).contains(&q) && !complex.neighbours(q).contains(&f), "the edge is split");
                } else {
                    let mut doomed = vec![false; cells];
                    doomed[random(cells)] = true;
                    let before = complex.cells();
                    match complex.delete(&doomed) {
                        Some(map) => assert_eq!(map.iter().flatten().count(), complex.cells()),
                        None => assert_eq!(complex.cells(), before, "a refusal changes nothing"),
                    }
                }
                complex.check().unwrap_or_else(|e| panic!("k {k}, step {step}: {e}"));
            }
            let again = Complex::from_simplices(k, complex.cells(), complex.simplices().to_vec()).unwrap();
            assert_eq!(again.adjacency(), complex.adjacency());
            assert_eq!(complex.edges().len() * 2, complex.adjacency().1.len(), "each edge once");
            let (offsets, all) = complex.adjacency();
            for c in 0..complex.cells() as u32 {
                for &n in &all[offsets[c as usize] as usize..offsets[c as usize + 1] as usize] {
                    assert!(complex.neighbours(n).contains(&c), "adjacency is symmetric");
                }
            }
        }
    }

    #[test]
    fn what_is_no_complex_is_refused() {
        for (cells, simplices) in [
            (3, vec![]),
            (3, vec![0, 1, 3]),
            (3, vec![0, 1, 1]),
            (4, vec![0, 1, 2]),
            (0, vec![]),
            (2, vec![0, 1, 0]),
            (3, vec![0, 1]),
        ] {
            assert!(Complex::from_simplices(2, cells, simplices.clone()).is_none(), "{cells} {simplices:?}");
        }
    }

    #[test]
    fn the_last_simplex_is_never_deleted() {
        for k in 1..=4 {
            let mut complex = Complex::simplex(k);
            let mut doomed = vec![false; k + 1];
            doomed[0] = true;
            assert!(complex.delete(&doomed).is_none());
            assert_eq!((complex.cells(), complex.check()), (k + 1, Ok(())));
        }
    }
}
