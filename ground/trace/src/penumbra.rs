//! [`Penumbra`]: how much of what pieces of shining surfaces give arrives.
//!
//! A piece is a point, so the half-shadow of a surface is a stair of as many steps as it has rows of
//! pieces, and what is dark in it would have a border of teeth. The share that arrives is found at
//! samples and made smooth along the surface ([`Lattice::softened`]). The edges of shadows that all
//! pieces cast at once stay as sharp as samples are apart.

use crate::gbuffer::GBuffer;
use crate::lattice::{Lattice, Softening};
use crate::panels::Panels;
use crate::shadow::Shadows;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;

/// Rows of a picture for each row from one share to the next that it is averaged with.
const ROWS: usize = 96;

/// The share of the pieces' light that arrives, between samples.
pub(crate) struct Penumbra<'a> {
    lattice: Lattice<'a>,
    share: Plane<f32>,
}

impl<'a> Penumbra<'a> {
    /// That of a picture, at every `step`th pixel of every `step`th row.
    pub(crate) fn sample(
        buffer: &'a GBuffer,
        panels: &Panels,
        shadows: &Shadows<'_>,
        step: usize,
        run: &Run,
    ) -> Result<Self> {
        let lattice = Lattice::new(buffer, step);
        let share = lattice.plane(|i, j| match lattice.pixel(i as isize, j as isize) {
            Some(pixel) if run.check().is_ok() => arriving(buffer, panels, shadows, pixel),
            _ => f32::NAN,
        });
        run.check()?;
        let spacing = (buffer.size().1 / (ROWS * step)).max(1) as isize;
        let share = lattice.softened(&share, &Softening { spacing, sloping: 1.5, alike: 0.25 });
        run.check()?;
        Ok(Self { lattice, share })
    }

    /// The share at a pixel; `None` where no sample lies on its surface.
    pub(crate) fn share(&self, pixel: (usize, usize)) -> Option<f32> {
        self.lattice.between(&self.share, 0.5, pixel)
    }
}

/// The share of light that reaches a pixel; NaN where there is none.
fn arriving(
    buffer: &GBuffer,
    panels: &Panels,
    shadows: &Shadows<'_>,
    pixel: (usize, usize),
) -> f32 {
    let position = Vec3::from(buffer.position[pixel]);
    let around = shadows.around(pixel);
    let (mut all, mut arrives) = (0.0, 0.0);
    panels.light(position, Vec3::from(buffer.normal[pixel]), |k, e| {
        all += e;
        arrives += if around.is_dark(k, position) { 0.0 } else { e };
    });
    arrives / all
}
