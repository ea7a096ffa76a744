//! Pooled paths: the rival of shared gathers, to be measured beside them.
//!
//! Every pixel casts rays of cosine density without an end, by the lattice of shared gathers; what
//! they meet is lit by one shadow ray, and blocks of pixels pool their hits by the balance heuristic
//! as they do (`pool`). So it has all that they have but points. Light that was reflected once.

use crate::band::Band;
use crate::indirect::Indirect;
use crate::pool;
use crate::receiver::{Lattice, Receiver};
use crate::surfel::Lit;
use chiaro_basis::{Result, Run};
use chiaro_trace::GBuffer;
use rayon::prelude::*;

/// Rows of pixels done together; even, as blocks begin at every second.
const ROWS: usize = 64;

/// Irradiance by light that was reflected once at the covered pixels, by so many rays each; `shift`
/// chooses another pattern of rays.
pub fn pooled_paths(
    lit: &Lit,
    buffer: &GBuffer,
    rays: u32,
    shift: u32,
    run: &Run,
) -> Result<Indirect> {
    let (width, height) = buffer.size();
    let lattice = Lattice::new(&[&[rays]], shift);
    let mut found = Indirect::none(width, height);
    let mut band = Band::default();
    let mut done = 0;
    for top in (0..height).step_by(ROWS) {
        let end = (top + ROWS).min(height);
        let row = |y: usize| {
            run.check()?;
            let covered = (0..width).filter(|x| buffer.covered[(*x, y)]);
            let one = |x| {
                let mut receiver = Receiver::new(lit.tracer, buffer, (x, y));
                receiver.cast_far(lit, &lattice, rays);
                (receiver, [0.0, 0.0, 0.0, std::f32::consts::PI])
            };
            Ok(covered.map(one).collect::<Vec<_>>())
        };
        let rows: Vec<Vec<_>> = (top..end).into_par_iter().map(row).collect::<Result<_>>()?;
        band.add(width, end, rows.into_iter().flatten());
        let until = if end == height { height } else { end - pool::STEP };
        band.settle(done..until, None, &mut found);
        done = until;
    }
    Ok(found)
}
