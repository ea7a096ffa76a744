//! Which short lines go round all of an object: the outline of something small, and no noise of
//! something large.

use crate::path::{Kind, Path};
use crate::surface::Surface;
use crate::view::View;
use chiaro_basis::math::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::ops::Range;

/// Least extent of a line that goes round an object, in parts of the object's.
const SHARE: f64 = 0.5;

/// For each path, whether it is closed, shorter than `longest` pixels, and as large as the object that it is on.
pub(crate) fn whole(
    paths: &[Path],
    surface: &Surface,
    (positions, view): (&[DVec3], &View),
    longest: f64,
) -> Vec<bool> {
    let mut extents: BTreeMap<u32, f64> = BTreeMap::new();
    let is_whole = |path: &Path| {
        let outlines = matches!(path.kind, Kind::Silhouette | Kind::Border);
        if !outlines || !path.closed || path.total() >= longest {
            return false;
        }
        let owner = path.segments.iter().find_map(|s| surface.owner(s.own));
        let Some(object) = owner.map(|o| o.object) else { return false };
        // What is larger has no outline as short as this.
        let enough = longest / SHARE;
        let extent = *extents.entry(object).or_insert_with(|| {
            extent(&positions[vertices(surface, object)], view, enough).unwrap_or(f64::INFINITY)
        });
        path.extent() >= SHARE * extent
    };
    paths.iter().map(is_whole).collect()
}

/// The vertices of an object, which follow each other.
fn vertices(surface: &Surface, object: u32) -> Range<usize> {
    let at = |object: u32| surface.anchors.partition_point(|a| a.object < object);
    at(object)..at(object + 1)
}

/// The diagonal of the part of the picture that some points take, pixels; `None` if it is over `enough`, or if some
/// are behind the eye.
fn extent(points: &[DVec3], view: &View, enough: f64) -> Option<f64> {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for point in points {
        let at = view.see(*point)?.at;
        (low, high) = (low.min(at), high.max(at));
        if low.distance(high) > enough {
            return None;
        }
    }
    Some(low.distance(high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::math::Vec3;
    use chiaro_scene::{Pose, Projection};

    #[test]
    fn an_extent_ends_where_it_is_enough() {
        let projection = Projection::Orthographic { half_height: 50.0 };
        let pose = Pose::look_at(Vec3::Z * 10.0, Vec3::ZERO, Vec3::Y, projection);
        let view = View::new(pose, (100, 100));
        let points = [DVec3::ZERO, DVec3::new(3.0, 4.0, 0.0), DVec3::new(1.0, 1.0, -2.0)];
        assert!((extent(&points, &view, 8.0).unwrap_or(0.0) - 5.0).abs() < 1e-9);
        assert_eq!(extent(&points, &view, 4.0), None);
        assert_eq!(extent(&[DVec3::Z * 20.0], &view, 4.0), None);
    }
}
