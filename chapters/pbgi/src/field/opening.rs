//! What of a field's openness reaches a receiver, and from where.

use super::{Field, LANES, Lanes};
use crate::opening::Opening;
use chiaro_trace::Vertex;

impl Field {
    /// The opening of a receiver by the far field under a dome of `radiance` by its texels; texels are
    /// weighed as those of [`Field::irradiance`].
    #[allow(clippy::needless_range_loop, reason = "lanes are vectors of the processor")]
    pub(crate) fn opening(&self, at: &Vertex, radiance: &[[f32; 3]]) -> Opening {
        let (p, n, s) = (self.scale * (at.position - self.ball.centre), at.normal, at.side);
        let mut sum = [[0.0f32; LANES]; 6];
        for &index in &self.lit {
            let t = &self.packs[index as usize];
            let dome: [Lanes; 3] = std::array::from_fn(|c| {
                let texel =
                    |k| radiance.get(index as usize * LANES + k).map_or(0.0, |l: &[f32; 3]| l[c]);
                std::array::from_fn(texel)
            });
            for k in 0..LANES {
                let [px, py, pz] = [t.place[0][k], t.place[1][k], t.place[2][k]];
                let (x, y, z) = (px - p.x, py - p.y, pz - p.z);
                let above = x * s.x + y * s.y + z * s.z > 0.0;
                let cosine = (x * n.x + y * n.y + z * n.z).max(0.0);
                let cosine = if above { cosine } else { 0.0 };
                let facing = (x * t.slant[0][k] + y * t.slant[1][k] + z * t.slant[2][k]).max(0.0);
                let square = (x * x + y * y + z * z).max(f32::MIN_POSITIVE.sqrt());
                let open = cosine * facing / (square * square) * t.light[3][k];
                let along = open / square.sqrt();
                let found = [along * x, along * y, along * z];
                (0..3).for_each(|c| sum[c][k] += found[c]);
                (0..3).for_each(|c| sum[3 + c][k] += open * dome[c][k]);
            }
        }
        sum.map(|lanes| lanes.iter().sum())
    }
}
