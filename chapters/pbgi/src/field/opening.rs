//! What of a field's openness reaches a receiver, and from where.

use super::{Field, LANES, Lanes};
use crate::opening::Opening;
use chiaro_trace::Vertex;

impl Field {
    /// The opening of a receiver by the far field under a dome of `radiance` by its texels; texels are
    /// weighed as those of [`Field::irradiance`].
    pub(crate) fn opening(&self, at: &Vertex, radiance: &[[f32; 3]]) -> Opening {
        let receiver = self.receiver(at);
        let mut sum = [[0.0f32; LANES]; 6];
        for &index in &self.lit {
            let t = &self.packs[index as usize];
            let dome: [Lanes; 3] = std::array::from_fn(|c| {
                let texel =
                    |k| radiance.get(index as usize * LANES + k).map_or(0.0, |l: &[f32; 3]| l[c]);
                std::array::from_fn(texel)
            });
            for k in 0..LANES {
                let (way, weight) = t.seen(k, &receiver);
                let open = weight * t.light[3][k];
                let length = way.iter().map(|v| v * v).sum::<f32>().sqrt();
                let along = open / length.max(f32::MIN_POSITIVE);
                (0..3).for_each(|c| sum[c][k] += along * way[c]);
                (0..3).for_each(|c| sum[3 + c][k] += open * dome[c][k]);
            }
        }
        sum.map(|lanes| lanes.iter().sum())
    }
}
