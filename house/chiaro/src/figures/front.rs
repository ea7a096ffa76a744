//! The front of what can be had: points that no mixture of two others beats.

/// The upper convex hull of points, from the least abscissa up to the greatest ordinate.
pub(super) fn front(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(b[1].total_cmp(&a[1])));
    let mut hull: Vec<[f64; 2]> = Vec::new();
    for p in sorted {
        if hull.last().is_some_and(|last| p[1] <= last[1]) {
            continue;
        }
        while let [.., a, b] = hull[..]
            && (b[1] - a[1]) * (p[0] - a[0]) <= (p[1] - a[1]) * (b[0] - a[0])
        {
            hull.pop();
        }
        hull.push(p);
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_leaves_out_what_costs_more_or_lies_under_a_chord() {
        let all =
            [[4.0, 1.0], [1.0, 0.0], [2.0, 3.0], [3.0, 3.1], [2.5, 2.9], [4.0, 4.0], [5.0, 4.0]];
        assert_eq!(front(&all), [[1.0, 0.0], [2.0, 3.0], [4.0, 4.0]]);
        assert!(front(&[]).is_empty());
    }
}
