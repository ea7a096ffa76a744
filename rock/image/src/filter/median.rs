//! The median of three by three pixels.

use crate::Plane;

/// The median of the covered values among each covered pixel and its eight neighbours: it removes
/// single outliers and keeps edges. Of an even number of values it takes the lower middle one, so
/// every result is a value of the input. Uncovered pixels stay as they are. Panics when the sizes
/// differ.
pub fn median3(plane: &Plane<f32>, mask: &Plane<bool>) -> Plane<f32> {
    assert_eq!(plane.size(), mask.size(), "a mask has the size of its plane");
    Plane::from_fn(plane.width(), plane.height(), |x, y| {
        if mask[(x, y)] { median_around(plane, mask, x, y) } else { plane[(x, y)] }
    })
}

fn median_around(plane: &Plane<f32>, mask: &Plane<bool>, x: usize, y: usize) -> f32 {
    let (mut values, mut count) = ([0.0f32; 9], 0);
    for near_y in y.saturating_sub(1)..(y + 2).min(plane.height()) {
        for near_x in x.saturating_sub(1)..(x + 2).min(plane.width()) {
            if mask[(near_x, near_y)] {
                values[count] = plane[(near_x, near_y)];
                count += 1;
            }
        }
    }
    let values = &mut values[..count];
    values.sort_unstable_by(f32::total_cmp);
    values[(count - 1) / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lone_outlier_goes_and_an_edge_stays() {
        let mut plane = Plane::from_fn(8, 6, |x, _| if x < 4 { 0.0 } else { 1.0 });
        let (edge, mask) = (plane.clone(), Plane::filled(8, 6, true));
        assert_eq!(median3(&plane, &mask), edge);
        plane[(2, 3)] = 50.0;
        assert_eq!(median3(&plane, &mask), edge);
    }

    #[test]
    fn uncovered_values_do_not_count() {
        let plane = Plane::from_pixels(3, 1, vec![9.0, 1.0, 9.0]);
        let mask = Plane::from_pixels(3, 1, vec![false, true, false]);
        assert_eq!(median3(&plane, &mask), plane);
    }
}
