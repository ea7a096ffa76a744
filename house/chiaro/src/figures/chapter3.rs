//! Figures 3.4 to 3.8 and 3.10.

use super::Figure;
use super::plate::Plate;
use chiaro_basis::{Result, Run};
use chiaro_binary::{BinaryKnobs, Channel};
use chiaro_image::sheet::Sheet;

const HEIGHT: usize = 480;

/// The scenes that the figures are drawn on.
const HEAD: &str = "head";
const OBJECT: &str = "multipod";
const PATTERN: &str = "golf-ball";

pub(super) const FIGURES: [Figure; 6] = [
    Figure {
        name: "3.4",
        title: "weights to white",
        message: "Raising w turns regions white, and none turns back; b is 0.5 throughout.",
        columns: 5,
        draw: weights,
    },
    Figure {
        name: "3.5",
        title: "appearance channels",
        message: "Channels above, what they give below: the head lamp darkens outlines, highlights \
                  open the black.",
        columns: 3,
        draw: channels,
    },
    Figure {
        name: "3.6",
        title: "global and local",
        message: "Global tone follows the light, local contrast finds every fold.",
        columns: 3,
        draw: global_local,
    },
    Figure {
        name: "3.7",
        title: "neighbour weight",
        message: "At N~ = 0 the cut is a threshold; raising it joins small regions to large ones.",
        columns: 5,
        draw: neighbour,
    },
    Figure {
        name: "3.8",
        title: "geometry",
        message: "A constant neighbour weight rounds everything; geometry puts the borders back on \
                  ridges and depth edges.",
        columns: 3,
        draw: geometry,
    },
    Figure {
        name: "3.10",
        title: "against thresholds",
        message: "A threshold keeps noise, a blurred one loses features; the cut does neither.",
        columns: 4,
        draw: thresholds,
    },
];

fn plate(scene: &str, run: &Run) -> Result<Plate> {
    Plate::of(scene, HEIGHT, &BinaryKnobs::default(), run)
}

fn weights(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in [HEAD, PATTERN] {
        let plate = plate(scene, run)?;
        for w in [0.2, 0.4, 0.6, 0.9, 1.4] {
            let set = |k: &mut BinaryKnobs| (k.diffuse_w, k.diffuse_b, k.neighbour) = (w, 0.5, 0.3);
            sheet.add(plate.thesis(set, run)?, format!("w = {w}"));
        }
    }
    Ok(())
}

fn channels(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let plate = plate(HEAD, run)?;
    for channel in [Channel::Diffuse, Channel::Headlamp, Channel::Specular] {
        sheet.add(plate.channel(channel), channel.name());
    }
    let diffuse = |k: &mut BinaryKnobs| k.neighbour = 0.3;
    sheet.add(plate.thesis(diffuse, run)?, "diffuse");
    let both = |k: &mut BinaryKnobs| {
        diffuse(k);
        (k.diffuse_w, k.diffuse_b, k.headlamp_w, k.headlamp_b) = (0.6, 0.6, 0.4, 0.6);
    };
    sheet.add(plate.thesis(both, run)?, "diffuse and head lamp");
    let all = |k: &mut BinaryKnobs| {
        both(k);
        k.specular_w = 1.5;
    };
    sheet.add(plate.thesis(all, run)?, "and highlights, to white alone");
    Ok(())
}

fn global_local(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in [HEAD, OBJECT] {
        let plate = plate(scene, run)?;
        for (g, caption) in [(1.0, "global, g = 1"), (0.3, "g = 0.3"), (0.0, "local, g = 0")] {
            let set = |k: &mut BinaryKnobs| (k.diffuse_g, k.neighbour) = (g, 0.03);
            sheet.add(plate.thesis(set, run)?, caption);
        }
    }
    Ok(())
}

fn neighbour(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in [HEAD, OBJECT] {
        let plate = plate(scene, run)?;
        for n in [0.0, 0.1, 0.3, 0.8, 2.0] {
            let set = |k: &mut BinaryKnobs| {
                (k.diffuse_g, k.neighbour, k.use_geometry) = (0.4, n, false);
            };
            sheet.add(plate.thesis(set, run)?, format!("N~ = {n}"));
        }
    }
    Ok(())
}

fn geometry(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in [HEAD, PATTERN] {
        let plate = plate(scene, run)?;
        let cells: [(f32, bool, &str); 3] = [
            (0.0, false, "N~ = 0: a threshold"),
            (0.5, false, "N~ = 0.5, constant"),
            (0.5, true, "N~ = 0.5, lowered by geometry"),
        ];
        for (n, by_geometry, caption) in cells {
            let set = |k: &mut BinaryKnobs| (k.neighbour, k.use_geometry) = (n, by_geometry);
            sheet.add(plate.thesis(set, run)?, caption);
        }
    }
    Ok(())
}

fn thresholds(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in [HEAD, PATTERN, OBJECT] {
        let plate = plate(scene, run)?;
        sheet.add(plate.channel(Channel::Diffuse), "diffuse light");
        sheet.add(plate.threshold(0.0), "threshold");
        // A box of 10 x 10 pixels has this deviation.
        sheet.add(plate.threshold(2.9), "threshold of the blurred light");
        let set = |k: &mut BinaryKnobs| k.neighbour = 0.5;
        sheet.add(plate.thesis(set, run)?, "minimal cut with geometry");
    }
    Ok(())
}
