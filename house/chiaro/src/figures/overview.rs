//! Figures 5.1, 5.3 (a) and 6.2: what indirect light adds to a picture, and the steps by which points find it.

use super::Figure;
use crate::light::{AnyTree, Still, still};
use chiaro_basis::{Result, Run};
use chiaro_image::Plane;
use chiaro_image::colour::to_byte;
use chiaro_image::sheet::Sheet;
use chiaro_pbgi::resolve::Seen;
use chiaro_pbgi::{LightKnobs, Prepared};

pub(super) const FIGURES: [Figure; 3] = [
    Figure {
        name: "5.1",
        title: "the visual effect of indirect lighting",
        message: "Left: direct light alone. Right: with light that was reflected up to three times.",
        columns: 2,
        draw: effect,
    },
    Figure {
        name: "5.3",
        title: "colour bleeding",
        message: "Part (a). White light takes the colour of walls with it, and leaves it on what is white: direct \
                  light, reflected light alone, both. Parts (b) and (c), caustics and dispersion, need \
                  transparent materials, which there are none of here.",
        columns: 3,
        draw: bleeding,
    },
    Figure {
        name: "6.2",
        title: "the steps of point-based global illumination",
        message: "Direct light, with a receiver marked; the surface as surfels in the light that they send; \
                  what the receiver gathers from their tree, all around it in latitude and longitude, by \
                  8 x 8 and by 32 x 32 texels a face; the indirect light of all pixels; and all light.",
        columns: 2,
        draw: steps,
    },
];

const SIZE: (usize, usize) = (400, 400);
const WIDE: (usize, usize) = (480, 360);
const SURFELS: usize = 100_000;
/// Surfels that are few enough to be told apart.
const FEW: usize = 6_000;
/// Pixels along an arm of the cross that marks the receiver.
const ARM: usize = 6;

fn on<T>(
    scene: &str,
    size: (usize, usize),
    run: &Run,
    work: impl FnOnce(&Still) -> Result<T>,
) -> Result<T> {
    still(scene, size, &LightKnobs::default(), run, work)
}

fn bytes(picture: &Plane<[f32; 3]>) -> Plane<[u8; 3]> {
    picture.map(|p| p.map(to_byte))
}

fn direct(at: &Still, seen: &Plane<Seen>) -> Plane<[u8; 3]> {
    bytes(&at.shown(&seen.map(|s| Seen { indirect: [0.0; 3], ..*s }), false))
}

fn effect(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in ["demo:courtyard", "demo:cornell-box"] {
        on(scene, WIDE, run, |at| {
            let seen = at.seen(&at.points(SURFELS, run)?, run)?;
            sheet.add(direct(at, &seen), "direct light".to_owned());
            sheet.add(bytes(&at.shown(&seen, false)), "with indirect light".to_owned());
            Ok(())
        })?;
    }
    Ok(())
}

fn bleeding(sheet: &mut Sheet, run: &Run) -> Result<()> {
    on("demo:cornell-box", SIZE, run, |at| {
        let seen = at.seen(&at.points(SURFELS, run)?, run)?;
        sheet.add(direct(at, &seen), "direct light".to_owned());
        sheet.add(bytes(&at.shown(&seen, true)), "reflected light".to_owned());
        sheet.add(bytes(&at.shown(&seen, false)), "both".to_owned());
        Ok(())
    })
}

fn steps(sheet: &mut Sheet, run: &Run) -> Result<()> {
    on("demo:cornell-box", SIZE, run, |at| {
        let mut points: Prepared<AnyTree> = at.points(SURFELS, run)?;
        let seen = at.seen(&points, run)?;
        // On the floor, in front.
        let receiver = (SIZE.0 * 2 / 5, SIZE.1 * 9 / 10);
        sheet.add(marked(direct(at, &seen), receiver), "1. direct light; a receiver".to_owned());
        let few = at.points(FEW, run)?;
        sheet.add(bytes(&at.discs(&few)), format!("2. {FEW} surfels"));
        for side in [8, 32] {
            let caption = format!("3. what it gathers, {side} x {side} texels a face");
            sheet.add(bytes(&at.received(&mut points, receiver, side)), caption);
        }
        sheet.add(bytes(&at.shown(&seen, true)), "4. indirect light".to_owned());
        sheet.add(bytes(&at.shown(&seen, false)), "5. all light".to_owned());
        Ok(())
    })
}

/// A picture with a cross at a pixel.
fn marked(mut picture: Plane<[u8; 3]>, (x, y): (usize, usize)) -> Plane<[u8; 3]> {
    for k in 0..=2 * ARM {
        picture[(x + k - ARM, y)] = [0, 80, 255];
        picture[(x, y + k - ARM)] = [0, 80, 255];
    }
    picture
}
