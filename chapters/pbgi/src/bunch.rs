//! [`Bunch`]: neighbours along the curve that together look small are one splat.
//!
//! Of a node's eight children and of a block's sixteen records most look far smaller than the threshold at
//! which it was opened. As long as the box around successive ones looks no larger than a binary tree's nodes would,
//! what is seen of each, by its own lobes or its own cosine, is summed; the sum is splatted
//! from their mean. Nothing is lost but where in the box they lie.

use crate::cut::{Chooser, Span, Splat};
use crate::packed::Record;
use chiaro_basis::math::Vec3;
use std::f32::consts::FRAC_1_PI;

/// What is seen of some neighbours.
pub(crate) struct Bunch<'a> {
    chooser: &'a Chooser,
    /// What looks larger is not summed, steradians.
    most: f32,
    low: Vec3,
    high: Vec3,
    /// Their solid angle, steradians.
    solid_angle: f32,
    /// Sums over them by solid angle: offsets from the receiver, radiance, normals.
    offset: Vec3,
    radiance: [f32; 3],
    axis: Vec3,
    /// The surfels of the one that sends most, and what that sends.
    span: Span,
    most_sent: f32,
}

impl<'a> Bunch<'a> {
    /// An empty one.
    pub(crate) fn new(chooser: &'a Chooser, most: f32) -> Self {
        Self {
            chooser,
            most,
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
            solid_angle: 0.0,
            offset: Vec3::ZERO,
            radiance: [0.0; 3],
            axis: Vec3::ZERO,
            span: Span::default(),
            most_sent: 0.0,
        }
    }

    /// Adds a record that is seen; what it does not fit to is splatted first.
    pub(crate) fn add(&mut self, record: &Record, span: Span, splats: &mut Vec<Splat>) {
        let chooser = self.chooser;
        let offset = record.position - chooser.from;
        let square = offset.length_squared();
        let radius = (record.area * FRAC_1_PI).sqrt();
        if chooser.near > 0.0 && square < (chooser.near + radius).powi(2) {
            let parts = chooser.surfel(record).into_iter().flatten();
            splats.extend(parts.map(|s| Splat { span, ..s }));
            return;
        }
        let facing = -record.normal.dot(offset);
        let (side, axis) = if facing < 0.0 { (1, -record.normal) } else { (0, record.normal) };
        let solid_angle = facing.abs() * record.side_area(side) / (square * square.sqrt());
        self.fit([offset, offset], square, splats);
        self.sum(offset, solid_angle, record.radiance[side], axis);
        self.span_of(solid_angle, record.radiance[side], span);
    }

    /// Adds what is seen of a node of a bounding sphere.
    pub(crate) fn add_node(
        &mut self,
        splat: &Splat,
        (centre, radius): (Vec3, f32),
        splats: &mut Vec<Splat>,
    ) {
        if splat.marks {
            splats.push(*splat);
            return;
        }
        let offset = centre - self.chooser.from;
        // A box as long as the sphere is wide.
        let half = Vec3::splat(radius * 3.0f32.sqrt().recip());
        self.fit([offset - half, offset + half], offset.length_squared(), splats);
        let place = splat.direction * splat.distance;
        self.sum(place, splat.solid_angle, splat.radiance, splat.axis);
        self.span_of(splat.solid_angle, splat.radiance, splat.span);
    }

    /// Makes the box hold what comes at a squared distance, if it still looks small then; else begins anew.
    fn fit(&mut self, [low, high]: [Vec3; 2], square: f32, splats: &mut Vec<Splat>) {
        let all = [self.low.min(low), self.high.max(high)];
        let looks = 0.25 * std::f32::consts::PI * (all[1] - all[0]).length_squared();
        [self.low, self.high] = if looks <= self.most * square {
            all
        } else {
            self.splat(splats);
            [low, high]
        };
    }

    fn sum(&mut self, offset: Vec3, solid_angle: f32, radiance: [f32; 3], axis: Vec3) {
        self.solid_angle += solid_angle;
        self.offset += solid_angle * offset;
        (0..3).for_each(|c| self.radiance[c] += solid_angle * radiance[c]);
        self.axis += solid_angle * axis;
    }

    fn span_of(&mut self, solid_angle: f32, radiance: [f32; 3], span: Span) {
        let sent = solid_angle * radiance.iter().sum::<f32>();
        if sent >= self.most_sent {
            (self.span, self.most_sent) = (span, sent);
        }
    }

    /// Splats what there is, and begins anew.
    pub(crate) fn splat(&mut self, splats: &mut Vec<Splat>) {
        if self.solid_angle > 0.0 {
            let share = 1.0 / self.solid_angle;
            let (direction, distance) = (self.offset * share).normalize_and_length();
            splats.push(Splat {
                direction,
                distance,
                solid_angle: self.solid_angle,
                radiance: self.radiance.map(|l| l * share),
                axis: self.axis * share,
                marks: false,
                span: self.span,
            });
        }
        *self = Self::new(self.chooser, self.most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(position: Vec3, red: f32) -> Record {
        Record {
            position,
            normal: Vec3::new(0.0, 0.6, 0.8),
            area: 0.01,
            alive: [true, false],
            albedo: [0.0; 3],
            radiance: [[red, 1.0, 0.5], [0.0; 3]],
        }
    }

    fn bunched(records: &[Record], near: f32) -> Vec<Splat> {
        let chooser = Chooser {
            from: Vec3::new(0.0, 0.0, 5.0),
            threshold: 0.01,
            near,
            mark: 0.5 * near,
            above: None,
            flat: true,
        };
        let (mut bunch, mut splats) = (Bunch::new(&chooser, 0.01), Vec::new());
        records.iter().for_each(|r| bunch.add(r, Span::default(), &mut splats));
        bunch.splat(&mut splats);
        let each: Vec<Splat> = records.iter().flat_map(|r| chooser.surfel(r)).flatten().collect();
        let sum = |of: &dyn Fn(&Splat) -> f32, splats: &[Splat]| splats.iter().map(of).sum::<f32>();
        for of in [&|s: &Splat| s.solid_angle, &|s: &Splat| s.solid_angle * s.radiance[0]]
            as [&dyn Fn(&Splat) -> f32; 2]
        {
            let (a, b) = (sum(of, &splats), sum(of, &each));
            assert!((a - b).abs() <= 1e-5 * b.abs(), "{a} {b}");
        }
        splats
    }

    #[test]
    fn what_lies_together_is_one_splat_of_the_same_light() {
        let at = |i: usize| Vec3::new(0.02 * i as f32, 0.01 * (i % 3) as f32, 0.0);
        let together: Vec<Record> = (0..8).map(|i| record(at(i), i as f32)).collect();
        let one = bunched(&together, 0.0);
        assert_eq!(one.len(), 1);
        assert!((one[0].distance - 5.0).abs() < 0.01 && (one[0].axis.length() - 1.0).abs() < 1e-5);
        assert!(bunched(&[], 0.0).is_empty());
    }

    #[test]
    fn what_lies_apart_or_near_stays_apart() {
        let wide: Vec<Record> =
            (0..8).map(|i| record(Vec3::new(2.0 * (i / 4) as f32, 0.0, 0.0), 1.0)).collect();
        assert_eq!(bunched(&wide, 0.0).len(), 2);
        let marked = bunched(&wide, 5.2);
        assert_eq!(marked.iter().filter(|s| s.marks).count(), 4);
        assert_eq!(marked.len(), 5);
    }
}
