//! Points that fill arrays of unlike strands.

use std::collections::HashSet;

use super::Curves;

impl Curves {
    /// The curves without the points that fill an array behind their tips: not-a-numbers, repeats of the tip, or a
    /// number such as 0 or -1 for all three coordinates where a strand ends in two or more; and how many curves had
    /// some. A curve of which less than a segment would be left stays as it is.
    #[must_use]
    pub fn without_padding(self) -> (Self, usize) {
        let last = |s: usize, n: usize| &self.strand(s)[..n];
        // Zero has two signs.
        let constant = |x: &[f64; 3]| (*x == [x[0]; 3]).then_some((x[0] + 0.0).to_bits());
        let fill = |s: usize| match self.strand(s) {
            [_, .., a, b] if a == b => constant(b),
            _ => None,
        };
        let constants: HashSet<u64> = (0..self.len()).filter_map(fill).collect();
        let count = |s: usize| {
            let mut n = self.range(s).len();
            let fills = |strand: &[[f64; 3]]| match strand {
                [.., a, b] => {
                    a == b || b.iter().all(|x| x.is_nan()) || constant(b).is_some_and(|x| constants.contains(&x))
                }
                _ => false,
            };
            while fills(last(s, n)) {
                n -= 1;
            }
            if n < 2 { self.range(s).len() } else { n }
        };
        let counts: Vec<usize> = (0..self.len()).map(count).collect();
        let padded = counts.iter().enumerate().filter(|(s, n)| **n < self.range(*s).len()).count();
        if padded == 0 {
            return (self, 0);
        }
        let of = |s: usize| self.range(s).take(counts[s]);
        let points = (0..self.len()).flat_map(of).map(|i| self.points[i]).collect();
        let radius = (0..self.len()).flat_map(of).filter_map(|i| self.radius.get(i).copied()).collect();
        let offsets = Self::of(Vec::new(), counts.iter().map(|n| *n as u32)).offsets;
        (Self { points, radius, offsets, ..self }, padded)
    }
}
