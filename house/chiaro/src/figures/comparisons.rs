//! Figures 3.11 to 3.14 and 3.16, table 3.1, and all baselines side by side.

use super::Figure;
use super::plate::Plate;
use chiaro_basis::{Result, Run};
use chiaro_binary::{BinaryKnobs, Method, Model};
use chiaro_image::Plane;
use chiaro_image::sheet::Sheet;
use std::time::Instant;

const HEIGHT: usize = 480;

pub(super) const FIGURES: [Figure; 6] = [
    Figure {
        name: "3.11",
        title: "against a local shader",
        message: "Three mixes of the thesis, and a toon threshold with lines: the cut decides over whole \
                  parts of the shape, and its borders run along ridges.",
        columns: 4,
        draw: local_shader,
    },
    Figure {
        name: "3.12",
        title: "against a cut of the image alone",
        message: "The same terminals; bonds from the picture's own edges, then from geometry, each with \
                  the sum of its bonds: what light does not show, the image cannot know.",
        columns: 4,
        draw: image_alone,
    },
    Figure {
        name: "3.13",
        title: "local terms with contours",
        message: "Local diffuse light alone (g = 0, h = 4, N~ = 0.2 of the thesis) with haloed occluding \
                  contours draws relief like a pen. Below: a colour image, its normals, and binary \
                  shading of the two with the map of discontinuities drawn on top (RGBN).",
        columns: 3,
        draw: local_with_contours,
    },
    Figure {
        name: "3.14",
        title: "a golf ball",
        message: "Lines alone, a toon threshold with lines, and binary shading: hollows read best as \
                  regions.",
        columns: 3,
        draw: golf_ball,
    },
    Figure {
        name: "3.16",
        title: "k colours",
        message: "Two, three and four tones of one light, exact cuts, then spot colours: forms read \
                  better the more tones there are.",
        columns: 4,
        draw: colours,
    },
    Figure {
        name: "table-3.1",
        title: "timings",
        message: "Seconds by part for two scenes at three sizes. The thesis, on 2010 hardware: filling \
                  took 14 to 34 times as long as the cut (1.70 s and 0.056 s at 118173 pixels).",
        columns: 3,
        draw: timings,
    },
];

fn plate(scene: &str, run: &Run) -> Result<Plate> {
    Plate::of(scene, HEIGHT, &BinaryKnobs::default(), run)
}

fn contours(k: &mut BinaryKnobs) {
    (k.lines, k.line_crease) = (true, 181.0);
}

fn local_shader(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in ["head", "bumpy-torus"] {
        let plate = plate(scene, run)?;
        let lamp = |k: &mut BinaryKnobs| {
            (k.diffuse_w, k.diffuse_b, k.headlamp_w, k.headlamp_b) = (0.0, 0.0, 1.0, 1.3);
            (k.specular_w, k.specular_b, k.neighbour) = (1.5, 0.0, 0.8);
        };
        sheet.add(plate.thesis(lamp, run)?, "head lamp, highlights to white, N~ = 0.8");
        let halo = |k: &mut BinaryKnobs| {
            k.neighbour = 1.1;
            contours(k);
        };
        sheet.add(plate.thesis(halo, run)?, "diffuse with contours, N~ = 1.1");
        let mixed = |k: &mut BinaryKnobs| (k.diffuse_g, k.neighbour) = (0.1, 0.15);
        sheet.add(plate.thesis(mixed, run)?, "local and global, g = 0.1, N~ = 0.15");
        let (picture, _) = plate.baseline(Method::Toon, &BinaryKnobs::default(), run)?;
        sheet.add(picture, "toon threshold with contours");
    }
    Ok(())
}

fn image_alone(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let knobs = BinaryKnobs {
        model: Model::Tone,
        half: 0.0,
        headlamp: 0.0,
        occlusion: 0.0,
        luminance: 0.0,
        diffuse: 1.0,
        global: 1.0,
        island: 0.0,
        lines: false,
        neighbour: 0.3,
        floor: 0.0,
        curvature_falloff: 0.03,
        ..BinaryKnobs::default()
    };
    for scene in ["head", "golf-ball"] {
        let plate = Plate::of(scene, HEIGHT, &knobs, run)?;
        sheet.add(plate.bonds(&knobs, true, run)?, "bonds from the diffuse light");
        sheet.add(plate.baseline(Method::ImageCut, &knobs, run)?.0, "cut of the image alone");
        sheet.add(plate.bonds(&knobs, false, run)?, "bonds from geometry");
        sheet.add(plate.ink(&knobs, run)?, "cut with geometry");
    }
    Ok(())
}

fn local_with_contours(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in ["head", "bumpy-torus", "golf-ball"] {
        let set = |k: &mut BinaryKnobs| {
            (k.diffuse_g, k.diffuse_h, k.neighbour) = (0.0, 4.0, 0.02);
            (k.diffuse_w, k.diffuse_b) = (1.0, 1.0);
            k.halo = 2.0;
            contours(k);
        };
        sheet.add(plate(scene, run)?.thesis(set, run)?, format!("{scene}: g = 0, h = 4"));
    }
    let [colour, normals, shaded] = plate("desk", run)?.rgbn(&BinaryKnobs::default(), run)?;
    sheet.add(colour, "desk: colour");
    sheet.add(normals, "normals");
    sheet.add(shaded, "binary shading, map on top");
    Ok(())
}

fn golf_ball(sheet: &mut Sheet, run: &Run) -> Result<()> {
    let plate = plate("golf-ball", run)?;
    sheet.add(plate.lines_alone(run)?, "lines alone");
    sheet.add(plate.baseline(Method::Toon, &BinaryKnobs::default(), run)?.0, "toon and lines");
    sheet.add(plate.ink(&BinaryKnobs::default(), run)?, "binary shading");
    Ok(())
}

fn colours(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in ["head", "golf-ball"] {
        let plate = plate(scene, run)?;
        for palette in ["2", "3", "4", "spot:#1b1b1d,#b5432e,#e8b96a,#f6f0e2"] {
            let knobs = BinaryKnobs { palette: palette.into(), ..BinaryKnobs::default() };
            let caption = match palette.strip_prefix("spot:") {
                Some(_) => "four spot colours".to_owned(),
                None => format!("{palette} tones"),
            };
            sheet.add(plate.coloured(&knobs, run)?, caption);
        }
    }
    Ok(())
}

fn timings(sheet: &mut Sheet, run: &Run) -> Result<()> {
    for scene in ["torus", "head"] {
        for height in [120, 300, 480] {
            let knobs =
                BinaryKnobs { model: Model::Thesis, lines: false, ..BinaryKnobs::default() };
            let start = Instant::now();
            let plate = Plate::of(scene, height, &knobs, run)?;
            let traced = start.elapsed().as_secs_f64();
            let [fill, cut] = plate.seconds(&knobs, run)?;
            let picture = plate.thesis(|_| (), run)?;
            let nodes = plate.nodes();
            let caption = format!(
                "{scene}, {nodes} pixels: rays {traced:.2} s, fill {fill:.4} s, cut {cut:.4} s"
            );
            sheet.add(picture, caption);
        }
    }
    Ok(())
}

/// Every method on each scene, beside ours, with its share of border on features beyond chance and
/// its islands.
pub(super) fn baselines(sheet: &mut Sheet, scenes: &[String], run: &Run) -> Result<Vec<Row>> {
    let knobs = BinaryKnobs::default();
    let mut rows = Vec::new();
    for scene in scenes {
        let plate = Plate::open(scene, HEIGHT, &knobs, run)?;
        sheet.add(plate.tone(&knobs, run)?, format!("{}: the tone", short(scene)));
        let mut add = |name: &str, (picture, [share, islands]): (Plane<[u8; 3]>, [f64; 2])| {
            sheet.add(picture, format!("{name}: {share:.2} on features, {islands} islands"));
            rows.push(Row { scene: scene.clone(), method: name.into(), share, islands });
        };
        for method in Method::ALL {
            add(method.name(), plate.baseline(method, &knobs, run)?);
        }
        add("chiaro", plate.ours(&knobs, run)?);
    }
    Ok(rows)
}

/// One method on one scene.
pub(super) struct Row {
    pub(super) scene: String,
    pub(super) method: String,
    /// Share of the border on features beyond chance.
    pub(super) share: f64,
    pub(super) islands: f64,
}

fn short(scene: &str) -> &str {
    scene.rsplit(['/', ':']).next().unwrap_or(scene)
}
