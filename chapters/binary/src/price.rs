//! What it costs to change pixels of a finished picture, by the weights that made it.

use crate::cut::Graph;
use chiaro_image::Plane;
use rayon::prelude::*;

/// What any change costs at least, in weights a pixel, and what one beside the objects costs.
const LEAST: f32 = 0.02;
const OUTSIDE: f32 = 0.05;

impl Graph {
    /// For each pixel of a picture in two colours, `white` where true, what it costs to change it,
    /// in weights, where changes are bars `width` pixels wide: the difference of its terminals, its
    /// share of two borders along the bar, and a little. At least 0.02.
    pub fn prices(&self, white: &Plane<bool>, width: f32) -> Plane<f32> {
        let per_border = 2.0 / (4.0 * width.max(1.0));
        let price = |i: usize| {
            if !self.mask.pixels()[i] {
                return OUTSIDE;
            }
            let [to_white, to_black] = self.terminal.pixels()[i];
            let kept = if white.pixels()[i] { to_white - to_black } else { to_black - to_white };
            let border: i32 = self.neighbour.pixels()[i].iter().sum();
            LEAST + (kept.max(0) as f32 + per_border * border as f32) / self.scale
        };
        let (w, h) = white.size();
        Plane::from_pixels(w, h, (0..white.len()).into_par_iter().map(price).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BinaryKnobs;

    #[test]
    fn what_is_wanted_less_costs_less_to_change() {
        let mask = Plane::from_fn(4, 1, |x, _| x < 3);
        let difference = Plane::from_pixels(4, 1, vec![-0.5, -0.1, 0.3, 0.0]);
        let factors = Plane::filled(4, 1, [0.0; 4]);
        let graph = Graph::new(&mask, &difference, &factors, &BinaryKnobs::default());
        let black = graph.prices(&Plane::filled(4, 1, false), 4.0);
        let expected = [0.52, 0.12, 0.02, 0.05];
        assert!(black.pixels().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3));
        let white = graph.prices(&Plane::filled(4, 1, true), 4.0);
        assert!((white[(2, 0)] - 0.32).abs() < 1e-3 && (white[(0, 0)] - 0.02).abs() < 1e-6);
    }
}
