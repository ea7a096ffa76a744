//! Direct light at the pixels of a buffer, free of noise.
//!
//! 1. Lamps without size are visited one by one. What shines and the sky stand as fixed sets of
//!    small lamps, the same for every pixel; what shines near a pixel is parted further, into pieces.
//! 2. Small lamps, and the pieces of each, are dealt to the 16 pixels of a 4 x 4 tile, the sky's to the 64
//!    of an 8 x 8 one; then every pixel takes the mean of the window of that size around it,
//!    which holds the whole set once. Each of the four small tiles in a large one has other quarters of
//!    what shines: where a shadow's edge is wide, the mean is of the large window, with them all.
//!    Shining triangles give, where nothing stands between, what they do in closed form; their
//!    small lamps tell how much of that arrives (Heitz et al. 2018).
//! 3. Where the window does not lie on one smooth surface, the pixel visits the set by itself. The sky's
//!    may stand a little aside, and is the smaller one, with a quarter of the set, where a surface bends.
//!
//! Guaranteed: deterministic, and smooth on smooth surfaces. Not guaranteed: shadows of small lamps
//! a few pixels wide are softened by the window.

use crate::gbuffer::GBuffer;
use crate::glow::{Cluster, Glow, QUARTERS};
use crate::light::Lamp;
use crate::lights::{Lights, lamp_at};
use crate::sample::Sequence;
use crate::sky::Sky;
use crate::tracer::Tracer;
use crate::vertex::Vertex;
use chiaro_basis::math::Vec3;
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::colour::luminance;

/// Pixels along a tile's side, and in a tile.
const TILE: usize = 4;
const DEAL: usize = TILE * TILE;
/// The same of the sky's larger tiles.
const SKY_TILE: usize = 2 * TILE;
const SKY_DEAL: usize = SKY_TILE * SKY_TILE;
/// Small lamps for what shines, and for the sky: so many for each pixel of a tile.
const SHARED: usize = 8;
const SKY_SHARE: usize = 8;
/// A pixel by itself visits so many for what shines, over the pixels of a tile, one in so many of the pieces, and of
/// the sky's lamps.
const ALONE_SHARE: usize = 4;
const ALONE: usize = 2;
const SKY_ALONE: usize = 4;
/// Differences between what arrives by the small and by the large window, over what chance makes of them: up to the
/// first the large one stands, beyond the second, beside a shadow's narrow edge, the small one.
const EVEN: [f32; 2] = [0.7, 1.6];
/// The least cosine between normals of a window: of a flat one, and of one that is merely bent.
const FLAT: f32 = 0.97;
const BENT: f32 = 0.75;
/// Directions found more densely than this, per steradian, are a sun's: their shadows have edges,
/// which the small tiles keep.
const SUN: f32 = 200.0;
/// Small lamps of suns at most.
const SUN_LAMPS: usize = 64;

type Pixel = (usize, usize);

/// The fixed lamps of a frame.
struct Fixed {
    hard: Vec<Lamp>,
    /// What shines, for pixels that share it, and for those that stand alone.
    shared: Vec<[Cluster; QUARTERS]>,
    glow: Vec<Cluster>,
    suns: Vec<Lamp>,
    sky: Vec<Lamp>,
}

impl Fixed {
    fn of(lights: &Lights) -> Self {
        let shared = lights.glow.quartered(DEAL * SHARED);
        let glow = lights.glow.clusters(DEAL * ALONE_SHARE);
        let (suns, sky) = lights.sky.as_deref().map(sky_lamps).unwrap_or_default();
        Self { hard: lights.lamps.clone(), shared, glow, suns, sky }
    }

    /// Whether any stand for what has a size.
    fn is_soft(&self) -> bool {
        !self.glow.is_empty() || !self.sky.is_empty()
    }

    /// From what shines and from suns, by the share of them that falls to a pixel of a tile.
    fn dealt(&self, scene: (&Tracer, &Glow), at: &Vertex, [tile, place]: [usize; 2]) -> Soft {
        let clusters =
            || self.shared.iter().enumerate().map(|(i, q)| &q[(tile + i + i / DEAL) % QUARTERS]);
        let far = clusters().skip(place).step_by(DEAL).map(|c| afar(c, at));
        let near = clusters().flat_map(|c| {
            let share = c.nearness(at.position);
            let pieces = if share > 0.0 { &c.pieces[..] } else { &[] };
            pieces.iter().skip(place).step_by(DEAL).map(move |l| (*l, share))
        });
        let suns = self.suns.iter().skip(place).step_by(DEAL).map(|l| (*l, DEAL as f32));
        let glow = far.chain(near).map(|(l, share)| (l, DEAL as f32 * share));
        Soft::of(scene, at, glow, suns)
    }

    /// The same by a pixel that stands alone.
    fn alone(&self, scene: (&Tracer, &Glow), at: &Vertex) -> Soft {
        // All clusters: one may be the only lamp of its room.
        let far = self.glow.iter().map(|c| afar(c, at));
        let many = ALONE as f32;
        let near = self.glow.iter().flat_map(|c| {
            let share = c.nearness(at.position);
            let pieces = if share > 0.0 { &c.pieces[..] } else { &[] };
            pieces.iter().step_by(ALONE).map(move |l| (*l, many * share))
        });
        let suns = self.suns.iter().map(|l| (*l, 1.0));
        Soft::of(scene, at, far.chain(near), suns)
    }
}

/// A cluster as one lamp, and the share of its light that this gives.
fn afar(cluster: &Cluster, at: &Vertex) -> (Lamp, f32) {
    (cluster.seen_from(at.position), 1.0 - cluster.nearness(at.position))
}

/// Irradiance from what shines and from suns.
#[derive(Clone, Copy, Default)]
struct Soft {
    /// From what shines.
    glow: [f32; 3],
    /// The same if nothing stood between.
    open: [f32; 3],
    /// The sum of squares of what each lamp would give, luminance.
    squares: f32,
    suns: [f32; 3],
}

impl Soft {
    fn of(
        scene @ (tracer, glow): (&Tracer, &Glow),
        at: &Vertex,
        lamps: impl Iterator<Item = (Lamp, f32)>,
        suns: impl Iterator<Item = (Lamp, f32)>,
    ) -> Self {
        let mut soft = Self { suns: sum(scene, at, suns), ..Self::default() };
        for (lamp, share) in lamps.filter(|(l, share)| share * l.strength > 0.0) {
            let Some((e, ray)) = lamp_at(&lamp, at) else { continue };
            let e = e.map(|e| share * e);
            soft.open = plus(soft.open, e);
            soft.squares += luminance(e).powi(2);
            if glow.is_free(tracer, &ray, &lamp) {
                soft.glow = plus(soft.glow, e);
            }
        }
        soft
    }

    /// All of it, where what shines would give `open` in closed form.
    fn whole(&self, open: Option<[f32; 3]>) -> [f32; 3] {
        let glow = match open {
            Some(open) => std::array::from_fn(|i| match self.open[i] {
                all if all > 0.0 => open[i] * (self.glow[i] / all),
                _ => 0.0,
            }),
            None => self.glow,
        };
        plus(glow, self.suns)
    }

    /// By the lamps of a small window; where those of the large one say much the same, by these.
    fn with(self, large: Option<Self>) -> Self {
        let Some(large) = large else { return self };
        let chance = self.chance();
        if chance <= 0.0 {
            return self;
        }
        let differ = (self.arriving() - large.arriving()).abs() / chance;
        let share = (1.0 - (differ - EVEN[0]) / (EVEN[1] - EVEN[0])).clamp(0.0, 1.0);
        let mix =
            |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|i| (1.0 - share) * a[i] + share * b[i]);
        Self { glow: mix(self.glow, large.glow), open: mix(self.open, large.open), ..self }
    }

    /// The share of what shines that arrives.
    fn arriving(&self) -> f32 {
        let open = luminance(self.open);
        if open > 0.0 { luminance(self.glow) / open } else { 1.0 }
    }

    /// How far that share may differ by chance: one over the root of how many lamps of equal strength do as much, in a
    /// small window.
    fn chance(&self) -> f32 {
        let open = luminance(self.open).max(f32::MIN_POSITIVE);
        (self.squares / DEAL as f32).sqrt() / open
    }

    fn mean(pixels: &[Pixel], of: impl Fn(Pixel) -> Self) -> Self {
        Self {
            glow: mean(pixels, |at| of(at).glow),
            open: mean(pixels, |at| of(at).open),
            squares: pixels.iter().map(|at| of(*at).squares).sum::<f32>() / pixels.len() as f32,
            suns: mean(pixels, |at| of(at).suns),
        }
    }
}

fn plus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}

/// Small lamps in the place of a sky: those of its suns, and the others, which are black where a sun was
/// found. The sky's few brightest texels may hold most of its light: a low-discrepancy set finds them in
/// proportion. Aligned pieces of it are such sets too: a pixel's share, and the quarter of a bent window.
fn sky_lamps(sky: &Sky) -> (Vec<Lamp>, Vec<Lamp>) {
    let count = SKY_DEAL * SKY_SHARE;
    let sequence = Sequence::new(0);
    let black = Lamp { strength: 0.0, ..Lamp::sun(Vec3::Y) };
    let (mut suns, mut others) = (Vec::new(), vec![black; count]);
    for (i, other) in others.iter_mut().enumerate() {
        let Some(s) = sky.sample(sequence.point(i as u32, 0)) else { continue };
        let y = luminance(s.radiance);
        let strength = y / s.density / count as f32;
        let lamp = Lamp { strength, colour: s.radiance.map(|c| c / y), ..Lamp::sun(-s.towards) };
        if s.density > SUN { suns.push(lamp) } else { *other = lamp }
    }
    let step = suns.len().div_ceil(SUN_LAMPS).max(1);
    let all: f32 = suns.iter().map(|l| l.strength).sum();
    let mut kept: Vec<Lamp> = suns.into_iter().step_by(step).collect();
    let some: f32 = kept.iter().map(|l| l.strength).sum();
    kept.iter_mut().for_each(|l| l.strength *= all / some);
    (kept, others)
}

/// Irradiance by direct light at each covered pixel, linear RGB.
#[derive(Clone, Debug)]
pub struct Direct {
    /// From lamps without size: its shadows have sharp edges.
    pub hard: Plane<[f32; 3]>,
    /// From what shines and from the sky.
    pub soft: Plane<[f32; 3]>,
}

impl Direct {
    /// Both together.
    pub fn whole(&self) -> Plane<[f32; 3]> {
        let sum = |a: &[f32; 3], b: &[f32; 3]| std::array::from_fn(|i| a[i] + b[i]);
        self.hard.zip(&self.soft, sum).expect("both have the picture's size")
    }
}

/// Direct light at the covered pixels of a buffer.
pub fn direct_irradiance(
    tracer: &Tracer,
    buffer: &GBuffer,
    lights: &Lights,
    run: &Run,
) -> Result<Direct> {
    let fixed = Fixed::of(lights);
    let scene = (tracer, &lights.glow);
    let raw = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return Raw::default();
        }
        let at = Vertex::of_pixel(tracer, buffer, (x, y));
        let own = fixed.sky.iter().skip(SKY_SHARE * sky_place(x, y)).take(SKY_SHARE);
        Raw {
            hard: lamp_irradiance(scene, &at, &fixed.hard),
            soft: fixed.dealt(scene, &at, [tile(x, y), place(x, y)]),
            sky: sum(scene, &at, own.map(|l| (*l, SKY_DEAL as f32))),
        }
    });
    run.check()?;
    let soft = buffer.over_covered(|x, y| {
        if run.check().is_err() {
            return [0.0; 3];
        }
        let small = window(buffer, (x, y), [0; 2], TILE, FLAT);
        let large = if fixed.is_soft() { large_window(buffer, (x, y)) } else { None };
        let at = Vertex::of_pixel(tracer, buffer, (x, y));
        let over = |pixels: &Vec<Pixel>| Soft::mean(pixels, |at| raw[at].soft);
        let soft = match &small {
            Some(pixels) => over(pixels).with(large.as_ref().map(over)),
            None => fixed.alone(scene, &at),
        };
        let soft = soft.whole(lights.glow.open_irradiance(at.position, at.normal));
        if fixed.sky.is_empty() {
            return soft;
        }
        let sky = match large.or_else(|| bent(buffer, (x, y), small)) {
            Some(pixels) => mean(&pixels, |at| raw[at].sky),
            None => {
                let some = fixed.sky.iter().take(SKY_DEAL * SKY_SHARE / SKY_ALONE);
                let some = some.map(|l| (*l, SKY_ALONE as f32));
                sum(scene, &at, some)
            }
        };
        plus(soft, sky)
    });
    run.check()?;
    Ok(Direct { hard: raw.map(|r| r.hard), soft })
}

/// What a pixel finds by its share of the lamps.
#[derive(Clone, Copy, Default)]
struct Raw {
    hard: [f32; 3],
    soft: Soft,
    sky: [f32; 3],
}

/// Each pixel's place in the deal, far from its neighbours'.
fn place(x: usize, y: usize) -> usize {
    const ORDER: [usize; DEAL] = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5];
    ORDER[(y % TILE) * TILE + x % TILE]
}

/// Which of the tiles of 4 x 4 in one of 8 x 8: each has a quarter of the lamps.
fn tile(x: usize, y: usize) -> usize {
    const TURN: [usize; QUARTERS] = [0, 2, 3, 1];
    TURN[(y / TILE % 2) * 2 + x / TILE % 2]
}

/// A pixel's place in the sky's tiles.
fn sky_place(x: usize, y: usize) -> usize {
    DEAL * tile(x, y) + place(x, y)
}

/// Irradiance at a vertex from lamps, each with a shadow ray, through what shines.
pub fn lamp_irradiance(scene: (&Tracer, &Glow), at: &Vertex, lamps: &[Lamp]) -> [f32; 3] {
    sum(scene, at, lamps.iter().map(|l| (*l, 1.0)))
}

/// From lamps, each times its share.
fn sum(
    (tracer, glow): (&Tracer, &Glow),
    at: &Vertex,
    lamps: impl Iterator<Item = (Lamp, f32)>,
) -> [f32; 3] {
    lamps
        .filter(|(l, share)| share * l.strength > 0.0)
        .filter_map(|(l, share)| lamp_at(&l, at).map(|(e, ray)| (l, share, e, ray)))
        .filter(|(l, _, _, ray)| glow.is_free(tracer, ray, l))
        .fold([0.0; 3], |s, (_, share, e, _)| plus(s, e.map(|e| share * e)))
}

fn mean(pixels: &[Pixel], of: impl Fn(Pixel) -> [f32; 3]) -> [f32; 3] {
    let sum = pixels.iter().fold([0.0; 3], |s: [f32; 3], &at| {
        let e = of(at);
        std::array::from_fn(|i| s[i] + e[i])
    });
    sum.map(|s| s / pixels.len() as f32)
}

/// The large window: around the pixel, or where that does not lie on its surface, a little aside.
fn large_window(buffer: &GBuffer, at: Pixel) -> Option<Vec<Pixel>> {
    const ASIDE: [[isize; 2]; 9] =
        [[0, 0], [2, 0], [-2, 0], [0, 2], [0, -2], [2, 2], [-2, -2], [2, -2], [-2, 2]];
    ASIDE.into_iter().find_map(|by| window(buffer, at, by, SKY_TILE, FLAT))
}

/// The small window, if the surface around it is merely too bent for the large one.
fn bent(buffer: &GBuffer, at: Pixel, small: Option<Vec<Pixel>>) -> Option<Vec<Pixel>> {
    small.filter(|_| window(buffer, at, [0; 2], SKY_TILE, BENT).is_some())
}

/// The pixels of the window of `side` x `side` around a pixel, moved by some, if all of it lies on the
/// pixel's surface and that is flat within the cosine of an angle.
fn window(
    buffer: &GBuffer,
    (x, y): Pixel,
    [right, down]: [isize; 2],
    side: usize,
    flat: f32,
) -> Option<Vec<Pixel>> {
    let (_, height) = buffer.size();
    let normal = Vec3::from(buffer.normal[(x, y)]);
    let position = Vec3::from(buffer.position[(x, y)]);
    let half = side as isize / 2;
    let width = buffer.pose.pixel_size(buffer.depth[(x, y)], height as f32);
    // What bends by an angle leaves the plane by as much.
    let tolerance = half as f32 * width * ((1.0 - flat) / (1.0 - FLAT)).sqrt();
    let mut pixels = Vec::with_capacity(side * side);
    for dy in -half + down..half + down {
        for dx in -half + right..half + right {
            let (u, v) = (x as isize + dx, y as isize + dy);
            if buffer.covered.at(u, v) != Some(&true) {
                return None;
            }
            let at = (u as usize, v as usize);
            let off_plane = (Vec3::from(buffer.position[at]) - position).dot(normal).abs();
            if off_plane > tolerance || Vec3::from(buffer.normal[at]).dot(normal) < flat {
                return None;
            }
            pixels.push(at);
        }
    }
    Some(pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sky brighter on one side, with a sun.
    fn sunny() -> Sky {
        Sky::new(Plane::from_fn(128, 64, |x, y| {
            let side = 0.2 + (x as f32 / 128.0 * std::f32::consts::TAU).sin().max(0.0);
            [if (x, y) == (40, 26) { 4000.0 } else { side }; 3]
        }))
    }

    #[test]
    fn quarters_of_a_sky_light_alike() {
        let (suns, sky) = sky_lamps(&sunny());
        assert!(!suns.is_empty() && sky.iter().any(|l| l.strength == 0.0));
        let irradiance = |lamps: &[Lamp], normal: Vec3| -> f32 {
            lamps.iter().map(|l| l.strength * (-l.direction).dot(normal).max(0.0)).sum()
        };
        for normal in [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z] {
            let all = irradiance(&sky, normal);
            for quarter in sky.chunks(sky.len() / SKY_ALONE) {
                let scaled = irradiance(quarter, normal) * SKY_ALONE as f32;
                assert!((scaled / all - 1.0).abs() < 0.25, "{normal}: {scaled} {all}");
            }
        }
    }

    #[test]
    fn the_tiles_of_a_window_share_the_whole_sky() {
        let places =
            |x: usize, y: usize| (0..SKY_DEAL).map(move |i| (x + i % SKY_TILE, y + i / SKY_TILE));
        let mut found: Vec<usize> = places(3, 6).map(|(x, y)| sky_place(x, y)).collect();
        found.sort_unstable();
        assert!(found.into_iter().eq(0..SKY_DEAL));
    }
}
