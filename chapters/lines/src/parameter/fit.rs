//! [`Fit`]: u along one line by least squares in its neighbours: a tridiagonal system.

/// Normal equations of rows in one unknown, or in two that follow each other.
pub(crate) struct Fit {
    diagonal: Vec<f64>,
    above: Vec<f64>,
    right: Vec<f64>,
}

impl Fit {
    pub(crate) fn new(unknowns: usize) -> Self {
        let zero = || vec![0.0; unknowns];
        Self { diagonal: zero(), above: zero(), right: zero() }
    }

    /// u_(k+1) - u_k = `target`.
    pub(crate) fn step(&mut self, k: usize, target: f64, weight: f64) {
        self.diagonal[k] += weight;
        self.diagonal[k + 1] += weight;
        self.above[k] -= weight;
        self.right[k] -= weight * target;
        self.right[k + 1] += weight * target;
    }

    /// u a share of the way from sample k to the next = `target`.
    pub(crate) fn value(&mut self, k: usize, share: f64, target: f64, weight: f64) {
        let next = (k + 1).min(self.diagonal.len() - 1);
        let (a, b) = if next == k { (1.0, 0.0) } else { (1.0 - share, share) };
        self.diagonal[k] += weight * a * a;
        self.right[k] += weight * a * target;
        if next > k {
            self.diagonal[next] += weight * b * b;
            self.above[k] += weight * a * b;
            self.right[next] += weight * b * target;
        }
    }

    /// The solution, by elimination from the first to the last.
    pub(crate) fn solve(mut self) -> Vec<f64> {
        let n = self.diagonal.len();
        for k in 1..n {
            let factor = self.above[k - 1] / self.diagonal[k - 1];
            self.diagonal[k] -= factor * self.above[k - 1];
            self.right[k] -= factor * self.right[k - 1];
        }
        for k in (0..n).rev() {
            let after = if k + 1 < n { self.above[k] * self.right[k + 1] } else { 0.0 };
            self.right[k] = (self.right[k] - after) / self.diagonal[k];
        }
        self.right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_samples_are_met() {
        let mut fit = Fit::new(4);
        (0..3).for_each(|k| fit.step(k, 2.0, 1.0));
        fit.value(1, 0.25, 10.0, 5.0);
        let u = fit.solve();
        for (k, u) in u.iter().enumerate() {
            assert!((u - (7.5 + 2.0 * k as f64)).abs() < 1e-9, "{u}");
        }
    }

    #[test]
    fn contradictions_are_shared_by_weight() {
        let mut fit = Fit::new(2);
        fit.step(0, 1.0, 1.0);
        fit.value(0, 0.0, 0.0, 1e9);
        fit.value(1, 0.0, 3.0, 3.0);
        assert!((fit.solve()[1] - 2.5).abs() < 1e-6);
    }
}
