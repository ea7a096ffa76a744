//! Triangles from a primitive's mode and indices (glTF 2.0, section 3.7.2.1).

use super::accessor::Accessor;
use super::context::{Context, Place};
use super::json::Value;
use chiaro_basis::Result;

/// How vertices make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    List,
    Strip,
    Fan,
}

/// What a primitive's mode says.
pub(super) enum Drawing {
    Triangles(Mode),
    PointsOrLines,
    Unknown,
}

/// The mode of a primitive.
pub(super) fn drawing(primitive: &Value) -> Drawing {
    match primitive.whole("mode", 4) {
        Ok(0..=3) => Drawing::PointsOrLines,
        Ok(4) => Drawing::Triangles(Mode::List),
        Ok(5) => Drawing::Triangles(Mode::Strip),
        Ok(6) => Drawing::Triangles(Mode::Fan),
        _ => Drawing::Unknown,
    }
}

impl Mode {
    /// How many triangles that many corners make.
    pub(super) fn triangles(self, corners: usize) -> usize {
        match self {
            Self::List => corners / 3,
            Self::Strip | Self::Fan => corners.saturating_sub(2),
        }
    }

    /// The corners of the `i`-th triangle. Every other triangle of a strip is turned, so that all
    /// have one side in front.
    fn corners(self, i: usize) -> [usize; 3] {
        match self {
            Self::List => [3 * i, 3 * i + 1, 3 * i + 2],
            Self::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Self::Fan => [i + 1, i + 2, 0],
        }
    }
}

/// Triangles between `vertices` vertices, through `indices` or in order; those with a corner that
/// does not exist are left out with a note.
pub(super) fn triangles(
    mode: Mode,
    indices: Option<&Accessor>,
    vertices: usize,
    place: Place,
    cx: &mut Context,
) -> Result<Vec<[u32; 3]>> {
    let corners = indices.map_or(vertices, Accessor::count);
    let count = mode.triangles(corners);
    cx.spend("triangles", |b| &mut b.triangles, count)?;
    cx.hold::<[u32; 3]>(place, count)?;
    let Some(indices) = indices.map(|a| a.indices(cx)).transpose()? else {
        return Ok((0..count).map(|i| mode.corners(i).map(|c| c as u32)).collect());
    };
    let mut triangles: Vec<[u32; 3]> =
        (0..count).map(|i| mode.corners(i).map(|c| indices[c])).collect();
    triangles.retain(|t| t.iter().all(|v| (*v as usize) < vertices));
    if triangles.len() < count {
        let gone = count - triangles.len();
        cx.note(place, format!("{gone} triangles with vertices that do not exist are left out"));
    }
    Ok(triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_wind_as_the_specification_says() {
        let all = |mode: Mode, corners: usize| {
            (0..mode.triangles(corners)).map(|i| mode.corners(i)).collect::<Vec<_>>()
        };
        assert_eq!(all(Mode::List, 7), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(all(Mode::Strip, 6), [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]);
        assert_eq!(all(Mode::Fan, 5), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        for mode in [Mode::List, Mode::Strip, Mode::Fan] {
            assert!((0..3).all(|corners| all(mode, corners).is_empty()));
        }
    }
}
