//! Procedural scenes, built in code: what the program can draw without any file.
//!
//! ```
//! let scene = chiaro_scene::demo::scene("golf-ball")?;
//! assert!(scene.stored.triangles > 20_000);
//! # chiaro_basis::Result::Ok(())
//! ```
//!
//! Each has 20 000 to 200 000 triangles (the sphere fields 512 000; the courtyard as many as its
//! size asks for, through copies), several materials, and motion that loops over two seconds where
//! the thing can move. Solids are closed manifolds that wind outwards. A scene has a camera or a
//! light only where the default view and the default light would not do. The same call gives the
//! same bytes.

mod bowl;
mod cactus;
mod cornell;
mod courtyard;
mod desk;
mod fruit;
mod head;
mod metaballs;
#[allow(dead_code)]
mod motion;
mod multipod;
mod rig;
mod rocks;
#[allow(dead_code, unused_imports)]
mod shape;
mod solids;
mod sphere_field;
#[allow(dead_code)]
mod stage;

use crate::Scene;
use chiaro_basis::{Error, Result, nearest};

/// A scene's maker; it takes the scene's size, if it has one.
enum Maker {
    Fixed(fn() -> Scene),
    /// With the default and the greatest size.
    Sized(fn(u32) -> Scene, u32, u32),
}

const MAKERS: &[(&str, Maker)] = &[
    ("torus", Maker::Fixed(solids::torus)),
    ("bumpy-torus", Maker::Fixed(solids::bumpy_torus)),
    ("peanut", Maker::Fixed(solids::peanut)),
    ("multipod", Maker::Fixed(multipod::multipod)),
    ("metaballs", Maker::Fixed(metaballs::metaballs)),
    ("golf-ball", Maker::Fixed(solids::golf_ball)),
    ("head", Maker::Fixed(head::head)),
    ("desk", Maker::Fixed(desk::desk)),
    ("bowl", Maker::Fixed(bowl::bowl)),
    ("cactus", Maker::Fixed(cactus::cactus)),
    ("cornell-box", Maker::Fixed(cornell::cornell_box)),
    ("courtyard", Maker::Sized(courtyard::courtyard, 2, 64)),
    ("sphere-field", Maker::Fixed(sphere_field::flat)),
    ("sphere-field-smooth", Maker::Fixed(sphere_field::smooth)),
    ("rocks", Maker::Sized(rocks::rocks, 4, 16)),
];

const NAMES: [&str; MAKERS.len()] = {
    let mut names = [""; MAKERS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = MAKERS[i].0;
        i += 1;
    }
    names
};

/// The names that [`scene`] knows.
pub fn names() -> &'static [&'static str] {
    &NAMES
}

/// The scene of a name; some take a size after a colon, like `courtyard:8`.
///
/// [`Error::Setting`] for unknown names (with the most similar one) and sizes out of range.
pub fn scene(name: &str) -> Result<Scene> {
    let (base, size) = match name.split_once(':') {
        Some((base, size)) => (base, Some(size)),
        None => (name, None),
    };
    let known = MAKERS.iter().find(|(n, _)| *n == base);
    let (_, maker) = known.ok_or_else(|| Error::setting("demo", name, hint(base)))?;
    match (maker, size) {
        (Maker::Fixed(make), None) => Ok(make()),
        (Maker::Fixed(_), Some(_)) => {
            Err(Error::setting("demo", name, format!("{base} alone; it takes no size")))
        }
        (Maker::Sized(make, default, _), None) => Ok(make(*default)),
        (Maker::Sized(make, _, most), Some(size)) => {
            let size = size.parse().ok().filter(|s| (1..=*most).contains(s));
            let range = || format!("{base}:1 to {base}:{most}");
            Ok(make(size.ok_or_else(|| Error::setting("demo", name, range()))?))
        }
    }
}

/// What would be accepted instead of an unknown name.
fn hint(name: &str) -> String {
    match nearest(name, NAMES) {
        Some(near) => format!("a demo scene; did you mean {near}?"),
        None => format!("one of {}", NAMES.join(", ")),
    }
}

#[cfg(test)]
mod tests;
