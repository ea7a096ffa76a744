//! [`Rows`]: the equations of a least-squares problem, without their weights and right sides.

/// Linear equations, each in a few unknowns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    unknowns: usize,
    starts: Vec<usize>,
    entries: Vec<(u32, f64)>,
}

impl Rows {
    /// No equations yet, in so many unknowns.
    pub fn new(unknowns: usize) -> Self {
        assert!(u32::try_from(unknowns).is_ok(), "unknowns are numbered in 32 bits");
        Self { unknowns, starts: vec![0], entries: Vec::new() }
    }

    /// Makes room for so many more equations with so many entries in all.
    pub fn reserve(&mut self, rows: usize, entries: usize) {
        self.starts.reserve_exact(rows);
        self.entries.reserve_exact(entries);
    }

    /// Adds the equation whose left side is the sum of coefficient times unknown; answers its index.
    ///
    /// An unknown may come more than once; coefficients add up.
    pub fn push(&mut self, entries: &[(u32, f64)]) -> usize {
        let start = self.entries.len();
        for &(unknown, coefficient) in entries {
            assert!((unknown as usize) < self.unknowns, "an equation is in the unknowns there are");
            let same = self.entries[start..].iter_mut().find(|e| e.0 == unknown);
            match same {
                Some(entry) => entry.1 += coefficient,
                None => self.entries.push((unknown, coefficient)),
            }
        }
        self.starts.push(self.entries.len());
        self.starts.len() - 2
    }

    /// How many unknowns.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// How many equations.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Unknowns and coefficients of an equation.
    pub fn row(&self, index: usize) -> &[(u32, f64)] {
        &self.entries[self.starts[index]..self.starts[index + 1]]
    }

    /// The left side of an equation at some values of the unknowns.
    pub fn left(&self, index: usize, x: &[f64]) -> f64 {
        self.row(index).iter().map(|(i, c)| c * x[*i as usize]).sum()
    }
}
