//! [`Bright`]: the few bright things far from receivers, each asked for by rays to its surfels.
//!
//! A lit inside of a lampshade, a sunlit floor behind a door: a splat of it covers but a part of a texel, and so does what
//! hides it, of which the texel cannot know whether it stands before it or beside it. Where the one is far
//! brighter than all the rest, that is most of the light. So bright splats enter the buffer black, and rays between
//! receivers and surfels tell how much of their light arrives: all of it, none, or a share that each
//! receiver finds out by itself.

use crate::cube::CubeShape;
use crate::cut::Splat;
use crate::hierarchy::Hierarchy;
use crate::pack::{LANES, Pack};
use crate::surfel::Surfel;
use chiaro_basis::math::Vec3;
use chiaro_basis::random;
use chiaro_image::colour::luminance;
use chiaro_trace::{Tracer, Vertex};
use std::f32::consts::{FRAC_1_PI, PI};

/// Splats of more than so many times the mean radiance are bright, if those in a texel send more than a share of all light.
const BRIGHT: f32 = 4.0;
const MUCH: f32 = 0.01;
/// Surfels that are taken from a splat.
const SOME: usize = 64;
/// How far above a surfel rays end, in its radii: further than a coded tree may put it wrong.
const LIFT: f32 = 0.25;
/// Rays that must agree that nothing or everything of a group arrives, and those that are tried: receivers may face away.
const TESTS: usize = 32;
const TRIES: usize = 3 * TESTS;
/// Rays of a receiver to all that is bright, and the least of one group.
const RAYS: f32 = 128.0;
const LEAST: f32 = 2.0;
/// So many of a group's are cast first, and the others where these do not agree.
const FIRST: usize = 16;

/// A surfel that rays ask for.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// A little above the surface, scene units.
    position: Vec3,
    /// The sum of this one's and all earlier ones' shares of the light; the last is 1.
    until: f32,
}

/// Bright splats in one texel.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    texel: usize,
    /// Radiance times solid angle.
    pub(crate) light: [f32; 3],
    /// From where they were seen, scene units.
    pub(crate) place: Vec3,
    /// The mean normal.
    pub(crate) axis: Vec3,
    samples: Vec<Sample>,
}

/// How much of a group's light arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arrives {
    All,
    Some,
    None,
}

/// Makes the bright ones of the splats seen from a place black; what they send, by texels of a cube.
pub(crate) fn take<T: Hierarchy>(
    tree: &T,
    from: Vec3,
    shape: &CubeShape,
    splats: &mut [Splat],
) -> Vec<Group> {
    let far = || splats.iter().filter(|s| !s.marks);
    let light = |s: &Splat| s.solid_angle * luminance(s.radiance);
    let sent: f32 = far().map(light).sum();
    let seen: f32 = far().map(|s| s.solid_angle).sum();
    let bright = BRIGHT * sent / seen.max(4.0 * PI);
    let mut found: Vec<(usize, usize)> = (0..splats.len())
        .filter(|&i| !splats[i].marks && luminance(splats[i].radiance) > bright)
        .map(|i| (shape.texel(splats[i].direction), i))
        .collect();
    found.sort_unstable();
    let mut surfels = Vec::new();
    let mut groups = Vec::new();
    for some in found.chunk_by(|a, b| a.0 == b.0) {
        let of_texel = some.iter().map(|(_, i)| &splats[*i]);
        let own: f32 = of_texel.clone().map(light).sum();
        if own < MUCH * sent {
            continue;
        }
        if let Some(group) = Group::of(tree, from, (some[0].0, of_texel), &mut surfels) {
            some.iter().for_each(|(_, i)| splats[*i].radiance = [0.0; 3]);
            groups.push(group);
        }
    }
    groups
}

impl Group {
    /// That of some splats in a texel; nothing where they know no surfel that faces the place.
    fn of<'a, T: Hierarchy>(
        tree: &T,
        from: Vec3,
        (texel, splats): (usize, impl Iterator<Item = &'a Splat>),
        surfels: &mut Vec<Surfel>,
    ) -> Option<Self> {
        let (light, zero) = ([0.0; 3], Vec3::ZERO);
        let mut group = Self { texel, light, place: zero, axis: zero, samples: Vec::new() };
        let mut total = 0.0;
        for splat in splats {
            let sent = splat.radiance.map(|l| l * splat.solid_angle);
            let weight = luminance(sent);
            (0..3).for_each(|c| group.light[c] += sent[c]);
            group.place += splat.direction * (splat.distance * weight);
            group.axis += splat.axis * weight;
            total += weight;
            surfels.clear();
            tree.some(splat.span, SOME, surfels);
            group.sample(surfels, from, weight);
        }
        let sum = group.samples.iter_mut().fold(0.0, |sum, s| {
            s.until += sum;
            s.until
        });
        if sum <= 0.0 || total <= 0.0 {
            return None;
        }
        group.samples.iter_mut().for_each(|s| s.until /= sum);
        group.place /= total;
        group.axis /= total;
        Some(group)
    }

    /// Adds the sides of surfels that face a place as samples, which share `weight` by what they send there.
    fn sample(&mut self, surfels: &[Surfel], from: Vec3, weight: f32) {
        let first = self.samples.len();
        for s in surfels {
            let offset = from - s.position;
            let facing = s.normal.dot(offset);
            let (side, normal) = if facing < 0.0 { (1, -s.normal) } else { (0, s.normal) };
            let square = offset.length_squared();
            let solid_angle = s.side_area(side) * facing.abs() / (square * square.sqrt());
            let sent = solid_angle * luminance(s.radiance[side]);
            if sent > 0.0 {
                let lift = LIFT * (s.area * FRAC_1_PI).sqrt();
                self.samples.push(Sample { position: s.position + normal * lift, until: sent });
            }
        }
        let own: f32 = self.samples[first..].iter().map(|s| s.until).sum();
        self.samples[first..].iter_mut().for_each(|s| s.until *= weight / own);
    }

    /// The sample that a number in [0, 1) chooses.
    fn chosen(&self, number: f32) -> Sample {
        let k = self.samples.partition_point(|s| s.until <= number);
        self.samples[k.min(self.samples.len() - 1)]
    }

    /// How much of its light arrives at some receivers.
    pub(crate) fn arrives(&self, tracer: &Tracer, receivers: &[Vertex]) -> Arrives {
        let (mut tests, mut free) = (0, 0);
        for k in 0..TRIES {
            let at = &receivers[(5 * k + 7 * self.texel) % receivers.len()];
            let [number, _] = random::r2((k + TRIES * self.texel) as u64);
            let Some(one) = self.chosen(number).is_free(tracer, at) else { continue };
            tests += 1;
            free += usize::from(one);
            if 0 < free && free < tests {
                return Arrives::Some;
            }
            if tests == TESTS {
                break;
            }
        }
        if free == 0 && tests > 0 { Arrives::None } else { Arrives::All }
    }
}

impl Sample {
    /// Whether a ray from a receiver to it meets nothing; `None` from behind the receiver.
    fn is_free(&self, tracer: &Tracer, at: &Vertex) -> Option<bool> {
        let origin = at.position + at.side * at.offset;
        let (direction, length) = (self.position - origin).normalize_and_length();
        let above = direction.dot(at.side).min(direction.dot(at.normal)) > 0.0;
        above.then(|| !tracer.occluded(&at.ray(direction, length)))
    }
}

/// What is bright around some receivers.
#[derive(Default)]
pub(crate) struct Bright {
    /// Groups as flat pieces.
    packs: Vec<Pack>,
    /// The samples that rays ask for of each, any first ones of them spread over its light; none where nothing hides it.
    targets: Vec<Vec<Sample>>,
}

impl Bright {
    /// That of some groups; `scale` is of the packs' unit in a scene unit.
    pub(crate) fn of(groups: &[(Group, Arrives)], scale: f32) -> Self {
        let mut all = Self::default();
        let hidden = groups.iter().filter(|g| g.1 == Arrives::Some);
        let total: f32 = hidden.map(|g| luminance(g.0.light)).sum();
        for (i, (group, arrives)) in groups.iter().filter(|g| g.1 != Arrives::None).enumerate() {
            all.packs.resize(i / LANES + 1, Pack::default());
            all.packs[i / LANES].set(i % LANES, (group.place * scale, group.axis), group.light);
            let count = match arrives {
                Arrives::Some => (RAYS * luminance(group.light) / total).max(LEAST) as u32,
                _ => 0,
            };
            let [shift, _] = random::r2(i as u64);
            let number = |k: u32| (radical_inverse(k) + shift).fract();
            all.targets.push((0..count).map(|k| group.chosen(number(k))).collect());
        }
        all
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.targets.is_empty()
    }

    /// Irradiance by it of a receiver (in the packs' unit: its place, normal and side) if nothing hid anything.
    pub(crate) fn open(&self, receiver: &[Vec3; 3]) -> [f32; 3] {
        let mut sum = [0.0; 3];
        for i in 0..self.targets.len() {
            let pack = &self.packs[i / LANES];
            let (_, weight) = pack.seen(i % LANES, receiver);
            (0..3).for_each(|c| sum[c] += weight * pack.light[c][i % LANES]);
        }
        sum
    }

    /// Irradiance by it of a receiver (in the packs' unit: its place, normal and side) by a share of the rays, and
    /// what it would be if nothing hid anything.
    pub(crate) fn irradiance(
        &self,
        receiver: &[Vec3; 3],
        (at, tracer): (&Vertex, &Tracer),
        share: f32,
    ) -> [f32; 6] {
        let mut found = [0.0; 6];
        for (i, targets) in self.targets.iter().enumerate() {
            let pack = &self.packs[i / LANES];
            let (_, weight) = pack.seen(i % LANES, receiver);
            if weight > 0.0 {
                let arrives = arriving(targets, (at, tracer), share);
                for c in 0..3 {
                    let open = weight * pack.light[c][i % LANES];
                    found[c] += arrives * open;
                    found[3 + c] += open;
                }
            }
        }
        found
    }
}

/// The share of some targets that a share of so many rays reaches.
fn arriving(targets: &[Sample], (at, tracer): (&Vertex, &Tracer), share: f32) -> f32 {
    if targets.is_empty() {
        return 1.0;
    }
    let reached =
        |some: &[Sample]| some.iter().filter(|t| t.is_free(tracer, at) == Some(true)).count();
    let count = ((share * targets.len() as f32).ceil() as usize).clamp(1, targets.len());
    let first = FIRST.min(count);
    let free = reached(&targets[..first]);
    if free == 0 || free == first {
        return (free / first) as f32;
    }
    (free + reached(&targets[first..count])) as f32 / count as f32
}

/// A number's place in the sequence that halves what is left again and again, in [0, 1).
fn radical_inverse(k: u32) -> f32 {
    (k.reverse_bits() >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::Tree;
    use crate::veil::tests::{sheets, shifted};
    use chiaro_basis::math::vec3;
    use chiaro_scene::{Playback, Poser, Scene};

    /// The side of the square at a distance of 10, which sends 1000 to where x is less, and the solid angle of which a
    /// texel is a hundred.
    const SIDE: f32 = 0.4;

    /// Surfels of that square, and of a dim wall far behind it.
    fn surfels() -> Vec<Surfel> {
        let square = |n: usize, side: f32, x: f32, light: f32| {
            let place = move |i: usize| side * ((i as f32 + 0.5) / n as f32 - 0.5);
            (0..n * n).map(move |k| Surfel {
                position: vec3(x, place(k % n), place(k / n)),
                normal: Vec3::NEG_X,
                area: (side / n as f32).powi(2),
                alive: [true, false],
                albedo: [1.0; 3],
                radiance: [[light, 2.0 * light, light], [0.0; 3]],
            })
        };
        square(8, SIDE, 10.0, 1000.0).chain(square(40, 40.0, 30.0, 0.1)).collect()
    }

    fn receiver() -> Vertex {
        Vertex {
            position: Vec3::ZERO,
            lifted: Vec3::ZERO,
            side: Vec3::X,
            smooth: Vec3::X,
            normal: Vec3::X,
            albedo: [1.0; 3],
            emission: [0.0; 3],
            offset: 0.0,
        }
    }

    /// What a receiver at the origin has of the square of what it could have, and how much arrives at three about it, with
    /// a scene between.
    fn seen(scene: &Scene) -> ([f32; 3], Vec<Arrives>) {
        let frame = Poser::new(scene).frame(0.0, &Playback::default());
        let tracer = Tracer::new(scene, &frame);
        let tree = Tree::build(&surfels());
        let shape = CubeShape::new(7);
        let from = Vec3::ZERO;
        let threshold = 0.7 * shape.mean_solid_angle();
        let chooser =
            crate::cut::Chooser { from, threshold, near: 0.0, mark: 0.0, above: None, flat: true };
        let mut splats = Vec::new();
        chooser.cut(&tree, &mut splats);
        let groups = take(&tree, from, &shape, &mut splats);
        assert!(splats.iter().all(|s| s.radiance[0] < 0.2) && !groups.is_empty());
        let near = |y: f32| Vertex { position: vec3(0.0, y, 0.0), ..receiver() };
        let some = [near(-0.01), near(0.0), near(0.01)];
        let told = groups.iter().map(|g| g.arrives(&tracer, &some)).collect();
        let groups: Vec<_> = groups.into_iter().map(|g| (g, Arrives::Some)).collect();
        let bright = Bright::of(&groups, 1.0);
        let e = bright.irradiance(&[Vec3::ZERO, Vec3::X, Vec3::X], (&receiver(), &tracer), 1.0);
        let exact = 1000.0 * SIDE * SIDE / 100.0;
        assert!((e[3] / exact - 1.0).abs() < 0.02, "{e:?}");
        assert!((e[4] / e[3] - 2.0).abs() < 1e-4 && (e[1] - 2.0 * e[0]).abs() < 1e-3 * exact);
        ([e[0] / e[3], e[1] / e[4], e[2] / e[5]], told)
    }

    /// A sheet as wide as the square seems, so far across the way to it, in its widths: all lie in one texel.
    fn hidden_by_a_sheet(across: f64) -> ([f32; 3], Vec<Arrives>) {
        let half = 0.5 * SIDE * 0.9 + 0.01;
        seen(&shifted(sheets(half, &[(9.0, false)]), across * f64::from(SIDE) * 0.9))
    }

    #[test]
    fn what_stands_before_a_bright_square_hides_it_and_what_stands_beside_it_does_not() {
        let (none, told) = hidden_by_a_sheet(0.0);
        assert!(none.iter().all(|e| *e == 0.0), "{none:?}");
        assert!(told.iter().all(|t| *t == Arrives::None), "{told:?}");
        let (all, told) = hidden_by_a_sheet(1.2);
        assert!(all.iter().all(|e| (e - 1.0).abs() < 1e-6), "{all:?}");
        assert!(told.iter().all(|t| *t == Arrives::All), "{told:?}");
    }

    #[test]
    fn half_of_a_bright_square_behind_an_edge_is_half_as_bright() {
        let (half, told) = hidden_by_a_sheet(0.5);
        assert!((half[0] - 0.5).abs() < 0.08, "{half:?}");
        assert!(told.contains(&Arrives::Some), "{told:?}");
    }

    #[test]
    fn first_numbers_of_the_sequence_halve_the_rest() {
        let first: Vec<f32> = (0..8).map(radical_inverse).collect();
        assert_eq!(first, [0.0, 0.5, 0.25, 0.75, 0.125, 0.625, 0.375, 0.875]);
    }
}
