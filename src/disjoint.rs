//! Disjoint sets of numbers; the lowest member stands for its set, whatever the order of joining.

use crate::layout::NONE;

/// A partition of `0..n`.
pub struct Disjoint(Vec<u32>);

impl Disjoint {
    /// Every number by itself.
    pub fn new(n: usize) -> Disjoint {
        Disjoint((0..n as u32).collect())
    }

    /// The lowest member of the set that holds `i`.
    pub fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    /// Makes one set of two; returns its lowest member.
    pub fn join(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
        a.min(b)
    }

    /// The number of each one's set, counted from 0 in order of appearance.
    pub fn numbers(mut self) -> Vec<u32> {
        let mut number = vec![NONE; self.0.len()];
        let mut count = 0;
        (0..self.0.len() as u32)
            .map(|i| {
                let root = self.root(i) as usize;
                if number[root] == NONE {
                    number[root] = count;
                    count += 1;
                }
                number[root]
            })
            .collect()
    }
}
