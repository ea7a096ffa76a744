//! Where a sheet is wide enough to hold.

use super::StencilForm;
use chiaro_image::labels::{Components, components, components_by_sides};
use chiaro_image::{Plane, filter};
use std::f32::consts::PI;

/// The number of no core.
pub(super) const NONE: u32 = u32::MAX;

/// The sheet without all that is nearer to a hole than half a bridge, in connected pieces.
pub(super) struct Cores {
    /// The core of each pixel, or [`NONE`].
    pub(super) ids: Plane<u32>,
    /// Their pixels. The first is that of the rim.
    pub(super) areas: Vec<usize>,
}

impl Cores {
    /// The cores of a sheet with a rim. Those that stand for less than the smallest part do not
    /// count.
    pub(super) fn find(sheet: &Plane<bool>, form: &StencilForm) -> Self {
        let far = filter::distance_to(&sheet.map(|s| !*s));
        let radius = 0.5 * form.bridge;
        let inner = far.map(|d| *d >= radius && *d > 0.0);
        // What a core stands for is at least its area grown by the radius.
        let grown = |area: f32| area + 2.0 * radius * (PI * area).sqrt() + PI * radius * radius;
        Self::of(components(&inner, &inner), |area| grown(area as f32) >= form.least_area())
    }

    /// The part of the sheet that the rim belongs to as one core, by sides.
    pub(super) fn main(sheet: &Plane<bool>) -> Self {
        Self::of(components_by_sides(sheet, sheet), |_| false)
    }

    /// The rim and the cores of at least so many pixels.
    pub(super) fn over(&self, area: f32) -> Self {
        Self::renumbered(&self.ids, self.areas.iter().copied(), |a| a as f32 >= area)
    }

    fn of(pieces: Components<bool>, counts: impl FnMut(usize) -> bool) -> Self {
        Self::renumbered(&pieces.ids, pieces.pieces.iter().map(|p| p.area), counts)
    }

    /// Pieces that count, the first one always.
    fn renumbered(
        ids: &Plane<u32>,
        all: impl Iterator<Item = usize>,
        mut counts: impl FnMut(usize) -> bool,
    ) -> Self {
        let mut areas = Vec::new();
        let number = |(i, area): (usize, usize)| {
            if !counts(area) && i > 0 {
                return NONE;
            }
            areas.push(area);
            areas.len() as u32 - 1
        };
        let numbers: Vec<u32> = all.enumerate().map(number).collect();
        let ids = ids.map(|id| numbers.get(*id as usize).copied().unwrap_or(NONE));
        Self { ids, areas }
    }
}
