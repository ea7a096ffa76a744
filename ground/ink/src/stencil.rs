//! Stencils: a sheet with holes where the ink goes, in one piece.
//!
//! 1. The picture gets a rim of sheet as wide as a bridge. Holes and loose parts smaller than the
//!    smallest part are closed or fall out.
//! 2. *Cores* are where the sheet is at least as wide as a bridge. Parts without a core are too thin
//!    to hold and fall out; cores that hang together by less count as apart.
//! 3. Bridges join all cores to the rim: of the cheapest ways between them over the prices of the
//!    pixels they change, those that span all cores at the least price ([`route`]). A part that costs
//!    less to leave out than to join is left out.
//! 4. Parts wider than twenty bridges get a second bridge, away from the first ones, so that they do
//!    not swing.
//! 5. Bridges are drawn, and what holes they leave under the smallest part are closed.
//!
//! Guaranteed: the sheet is connected by sides; every bridge is as wide as asked for, or up to two
//! pixels wider. Not guaranteed: the least price of all, which is a Steiner tree in the plane; ours
//! is within a factor of two of it over the grid.
//!
//! After Bronson, Rheingans and Olano, *Semi-automatic stencil creation through error minimization*,
//! 2008; the prices here are those of the cut that made the picture.

mod cores;
mod route;

use self::cores::{Cores, NONE};
use chiaro_image::labels::{components, components_by_sides};
use chiaro_image::{Plane, filter};
use std::f32::consts::PI;

/// Rounds of bridges; the first joins all, the others what a bridge of the first cut off.
const ROUNDS: usize = 4;

/// Parts wider than so many bridges get a second one, so many bridges away from the first if it can
/// be had at a price up to so much dearer.
const LARGE: f32 = 20.0;
const APART: f32 = 10.0;
const DEARER: f32 = 20.0;

/// What a stencil's sheet must hold, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StencilForm {
    /// Width of a bridge.
    pub bridge: f32,
    /// Holes and parts of the sheet smaller than a disc of this diameter are left out.
    pub part: f32,
}

impl StencilForm {
    fn least_area(&self) -> f32 {
        0.25 * PI * self.part * self.part
    }
}

/// A line of sheet across a hole.
#[derive(Clone, Debug, PartialEq)]
pub struct Bridge {
    /// Its middle line in pixels, from inside one part to inside another.
    pub points: Vec<[f32; 2]>,
    /// How much of it spans holes, in pixels.
    pub span: f32,
}

/// A sheet with holes.
#[derive(Clone, Debug)]
pub struct Stencil {
    /// The sheet where true, holes where false.
    pub sheet: Plane<bool>,
    /// What was drawn to hold it together.
    pub bridges: Vec<Bridge>,
    /// Parts of the sheet that were left out.
    pub dropped: usize,
    /// Holes that were closed.
    pub closed: usize,
}

/// A stencil of a picture: `sheet` where true, ink elsewhere. `price` is what it costs to change a
/// pixel, 0 or more. Panics when the sizes differ.
pub fn stencil(sheet: &Plane<bool>, price: &Plane<f32>, form: &StencilForm) -> Stencil {
    assert_eq!(sheet.size(), price.size(), "prices have the picture's size");
    let mut work =
        Stencil { sheet: with_rim(sheet, form.bridge), bridges: Vec::new(), dropped: 0, closed: 0 };
    work.drop_small(form);
    work.close_small(form);
    for round in 0..ROUNDS {
        let cores = Cores::find(&work.sheet, form);
        work.drop_loose(&cores);
        if cores.areas.len() <= 1 {
            break;
        }
        let tree = route::join((&work.sheet, sheet), &cores, price, form);
        for core in &tree.dropped {
            work.drop_core(&cores, *core);
        }
        let second =
            if round == 0 { work.support((sheet, &cores), price, form, &tree) } else { Vec::new() };
        work.draw(&tree.ways, form);
        work.draw(&second, form);
    }
    work.drop_loose(&Cores::main(&work.sheet));
    work.sheet = strengthened(&work.sheet);
    work.close_small(form);
    work
}

/// The picture with `width` pixels of sheet around its frame, inwards.
fn with_rim(sheet: &Plane<bool>, width: f32) -> Plane<bool> {
    let (w, h) = sheet.size();
    let rim = width.ceil() as usize;
    Plane::from_fn(w, h, |x, y| {
        let to_frame = x.min(y).min(w - 1 - x).min(h - 1 - y);
        to_frame < rim || sheet[(x, y)]
    })
}

/// The sheet with what is thinner than three pixels made that wide: borders that are smoothed would
/// pinch it off.
fn strengthened(sheet: &Plane<bool>) -> Plane<bool> {
    let (w, h) = sheet.size();
    let around = |(x, y): (usize, usize)| {
        let rows = y.saturating_sub(1)..(y + 2).min(h);
        rows.flat_map(move |v| (x.saturating_sub(1)..(x + 2).min(w)).map(move |u| (u, v)))
    };
    let inner = Plane::from_fn(w, h, |x, y| around((x, y)).all(|p| sheet[p]));
    let thin = Plane::from_fn(w, h, |x, y| sheet[(x, y)] && !around((x, y)).any(|p| inner[p]));
    Plane::from_fn(w, h, |x, y| sheet[(x, y)] || around((x, y)).any(|p| thin[p]))
}

impl Stencil {
    /// Parts of the sheet under the smallest fall out.
    fn drop_small(&mut self, form: &StencilForm) {
        let parts = components_by_sides(&self.sheet, &self.sheet);
        let rim = parts.ids.pixels().first().copied();
        let goes: Vec<bool> = (0u32..)
            .zip(&parts.pieces)
            .map(|(id, p)| Some(id) != rim && (p.area as f32) < form.least_area())
            .collect();
        self.dropped += self.turn(&parts.ids, &goes, false);
    }

    /// Holes under the smallest part are closed.
    fn close_small(&mut self, form: &StencilForm) {
        let ink = self.sheet.map(|s| !*s);
        let holes = components(&ink, &ink);
        let goes: Vec<bool> =
            holes.pieces.iter().map(|p| (p.area as f32) < form.least_area()).collect();
        self.closed += self.turn(&holes.ids, &goes, true);
    }

    /// Parts of the sheet without a core fall out.
    fn drop_loose(&mut self, cores: &Cores) {
        let parts = components_by_sides(&self.sheet, &self.sheet);
        let mut goes = vec![true; parts.pieces.len()];
        for (part, core) in parts.ids.pixels().iter().zip(cores.ids.pixels()) {
            if *core != NONE {
                goes[*part as usize] = false;
            }
        }
        self.dropped += self.turn(&parts.ids, &goes, false);
    }

    /// The part of the sheet around a core falls out.
    fn drop_core(&mut self, cores: &Cores, core: u32) {
        let parts = components_by_sides(&self.sheet, &self.sheet);
        let inside = cores.ids.pixels().iter().position(|id| *id == core);
        let Some(part) = inside.map(|i| parts.ids.pixels()[i] as usize) else { return };
        let goes: Vec<bool> = (0..parts.pieces.len()).map(|i| i == part).collect();
        self.dropped += self.turn(&parts.ids, &goes, false);
    }

    /// Makes the chosen pieces sheet or holes; how many they are.
    fn turn(&mut self, ids: &Plane<u32>, goes: &[bool], to: bool) -> usize {
        let count = goes.iter().filter(|g| **g).count();
        if count > 0 {
            for (sheet, id) in self.sheet.pixels_mut().iter_mut().zip(ids.pixels()) {
                if goes.get(*id as usize) == Some(&true) {
                    *sheet = to;
                }
            }
        }
        count
    }

    /// A second way to each large part, away from the bridges of a tree.
    fn support(
        &self,
        (given, cores): (&Plane<bool>, &Cores),
        price: &Plane<f32>,
        form: &StencilForm,
        tree: &route::Tree,
    ) -> Vec<Vec<[f32; 2]>> {
        let large = cores.over(0.25 * PI * (LARGE * form.bridge).powi(2));
        if large.areas.len() < 2 {
            return Vec::new();
        }
        let mut bridged = given.map(|_| false);
        for way in &tree.ways {
            way.windows(2).for_each(|p| bar(&mut bridged, p[0], p[1], 1.0));
        }
        let far = filter::distance_to(&bridged);
        let dear = |p: &f32, d: &f32| if *d < APART * form.bridge { p * DEARER } else { *p };
        let price = price.zip(&far, dear).expect("one size");
        // Bridges hold more than they cost here: nothing is left out.
        route::join((&self.sheet, given), &large, &price, form).ways
    }

    /// Draws bridges.
    fn draw(&mut self, ways: &[Vec<[f32; 2]>], form: &StencilForm) {
        let radius = 0.5 * form.bridge + 0.71;
        for points in ways {
            let span = span(&self.sheet, points);
            self.bridges.push(Bridge { points: points.clone(), span });
        }
        for way in ways {
            way.windows(2).for_each(|p| bar(&mut self.sheet, p[0], p[1], radius));
        }
    }
}

/// How much of a way leads over holes.
fn span(sheet: &Plane<bool>, points: &[[f32; 2]]) -> f32 {
    let hole =
        |p: &[f32; 2]| sheet.at(p[0].floor() as isize, p[1].floor() as isize) == Some(&false);
    let holes = along(points, 0.25).iter().filter(|p| hole(p)).count();
    holes as f32 * 0.25
}

/// Points every `step` pixels along a way.
fn along(points: &[[f32; 2]], step: f32) -> Vec<[f32; 2]> {
    let mut all = Vec::new();
    for p in points.windows(2) {
        let [dx, dy] = [p[1][0] - p[0][0], p[1][1] - p[0][1]];
        let count = (dx.hypot(dy) / step).ceil().max(1.0);
        all.extend((0..count as usize).map(|i| {
            let t = (i as f32 + 0.5) / count;
            [p[0][0] + t * dx, p[0][1] + t * dy]
        }));
    }
    all
}

/// Makes the pixels within `radius` of a segment sheet.
fn bar(sheet: &mut Plane<bool>, a: [f32; 2], b: [f32; 2], radius: f32) {
    let (w, h) = sheet.size();
    let range = |i: usize, n: usize| {
        let low = (a[i].min(b[i]) - radius).floor().clamp(0.0, n as f32) as usize;
        let high = (a[i].max(b[i]) + radius).ceil().clamp(0.0, n as f32) as usize;
        low..high
    };
    for y in range(1, h) {
        for x in range(0, w) {
            if crate::stroke::distance([x as f32 + 0.5, y as f32 + 0.5], a, b) <= radius {
                sheet[(x, y)] = true;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chiaro_basis::random;

    const FORM: StencilForm = StencilForm { bridge: 4.0, part: 5.0 };

    fn pieces(sheet: &Plane<bool>) -> usize {
        components_by_sides(sheet, sheet).pieces.len()
    }

    /// A ring of ink around (30, 30), with a square of ink far from it.
    fn ring(x: usize, y: usize) -> bool {
        let r = (x as f32 - 30.0).hypot(y as f32 - 30.0);
        !(12.0..20.0).contains(&r) && !(60..70).contains(&x)
    }

    #[test]
    fn a_ring_gets_a_bridge_where_it_is_cheapest() {
        let sheet = Plane::from_fn(90, 60, ring);
        let price = Plane::from_fn(90, 60, |x, y| if x > 32 && y < 28 { 0.1 } else { 1.0 });
        let made = stencil(&sheet, &price, &FORM);
        assert_eq!(pieces(&made.sheet), 1);
        let [bridge] = made.bridges.as_slice() else { panic!("{:?}", made.bridges) };
        assert!((6.0..11.0).contains(&bridge.span), "{bridge:?}");
        let inside = |p: &[f32; 2]| p[0] > 30.0 && p[1] < 30.0;
        assert!(bridge.points.iter().any(inside));
        assert_eq!((made.dropped, made.closed), (0, 0));
    }

    #[test]
    fn bridges_are_as_wide_as_asked_for() {
        for bridge in [3.0, 4.0, 6.0] {
            let sheet = Plane::from_fn(90, 60, ring);
            let price = Plane::filled(90, 60, 1.0);
            let form = StencilForm { bridge, part: 3.0 };
            let made = stencil(&sheet, &price, &form);
            let added = made.sheet.pixels().iter().zip(sheet.pixels()).filter(|(a, b)| **a && !**b);
            let width = (added.count() as f32 - rim_of(&sheet, bridge)) / made.bridges[0].span;
            assert!(width >= bridge - 0.3 && width <= bridge + 2.5, "{bridge}: {width}");
            assert_eq!(Cores::find(&made.sheet, &form).areas.len(), 1);
        }
    }

    /// Pixels of ink that the rim takes.
    fn rim_of(sheet: &Plane<bool>, bridge: f32) -> f32 {
        let rimmed = with_rim(sheet, bridge);
        rimmed.pixels().iter().zip(sheet.pixels()).filter(|(a, b)| **a && !**b).count() as f32
    }

    #[test]
    fn what_costs_less_than_its_bridge_falls_out() {
        let sheet = Plane::from_fn(120, 120, |x, y| {
            let far = (x as f32 - 60.0).hypot(y as f32 - 60.0);
            !(4.0..50.0).contains(&far)
        });
        let made = stencil(&sheet, &Plane::filled(120, 120, 1.0), &FORM);
        assert_eq!((made.dropped, made.bridges.len(), pieces(&made.sheet)), (1, 0, 1));
        let dear = |x: usize, y: usize| if sheet[(x, y)] { 50.0 } else { 1.0 };
        let made = stencil(&sheet, &Plane::from_fn(120, 120, dear), &FORM);
        assert_eq!((made.dropped, made.bridges.len(), pieces(&made.sheet)), (0, 1, 1));
    }

    #[test]
    fn a_large_part_is_held_at_two_places() {
        let sheet = Plane::from_fn(200, 200, |x, y| {
            !(80.0..90.0).contains(&(x as f32 - 100.0).hypot(y as f32 - 100.0))
        });
        let made = stencil(&sheet, &Plane::filled(200, 200, 1.0), &FORM);
        let [a, b] = made.bridges.as_slice() else { panic!("{:?}", made.bridges) };
        let apart = (a.points[0][0] - b.points[0][0]).hypot(a.points[0][1] - b.points[0][1]);
        assert!(apart > 30.0, "{apart}");
    }

    #[test]
    fn no_part_of_the_sheet_is_thinner_than_three_pixels() {
        // A line of one pixel across the ink, from rim to rim.
        let given = Plane::from_fn(60, 60, |x, y| x == y || x == y + 1);
        let price = given.map(|_| 1.0);
        let made = stencil(&given, &price, &StencilForm { bridge: 4.0, part: 3.0 }).sheet;
        assert_eq!(pieces(&made), 1);
        assert!(made[(30, 30)] && !made[(40, 20)], "the line stays, and the ink");
        let is_inner = |x: usize, y: usize| (0..9).all(|i| made[(x + i % 3, y + i / 3)]);
        for (x, y) in (0..60).flat_map(|y| (0..60).map(move |x| (x, y))).filter(|p| made[*p]) {
            let mut squares = (0..9).map(|i| (x.wrapping_sub(i % 3), y.wrapping_sub(i / 3)));
            assert!(squares.any(|(u, v)| u < 58 && v < 58 && is_inner(u, v)), "{x} {y}");
        }
    }

    #[test]
    fn any_picture_becomes_one_piece() {
        for seed in 0..12 {
            let (w, h) = [(1, 1), (3, 200), (97, 61), (160, 120)][seed % 4];
            let cell = 1 + seed / 2;
            let sheet = Plane::from_fn(w, h, |x, y| {
                random::unit(seed as u64, (y / cell * 1000 + x / cell) as u64) < 0.5
            });
            let price = Plane::from_fn(w, h, |x, y| random::unit(99, (y * w + x) as u64));
            let form = StencilForm { bridge: 3.0 + (seed % 3) as f32, part: 4.0 };
            let made = stencil(&sheet, &price, &form);
            assert_eq!(pieces(&made.sheet), 1, "seed {seed}");
            let ink = made.sheet.map(|s| !*s);
            let least = components(&ink, &ink).pieces.iter().map(|p| p.area).min();
            assert!(least.is_none_or(|a| a as f32 >= form.least_area()));
        }
    }
}
