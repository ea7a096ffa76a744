//! Regions and lines as SVG in millimetres, for printers and screens (closed fills beneath strokes)
//! or for a pen (hatching, inset outlines and strokes).
//!
//! 1. The labels are smoothed as the picture is, and their borders traced once each.
//! 2. Fills: one path a region with its holes, one layer a colour. Beneath them a thin stroke follows
//!    each border that two fills share, or the page would shine through where both are antialiased.
//!    With a pen: each colour but the paper's is hatched, the wider apart the lighter it is.
//!    A stencil: its holes alone, filled, or their outlines where there is a pen.
//! 3. Lines: joined within 0.1 mm, fitted to 0.05 mm, ordered for little travel, one layer a pen. With a
//!    pen, those of a map follow their centre lines.

use crate::binary::Look;
use crate::colours::Colours;
use chiaro_basis::Result;
use chiaro_binary::{BinaryKnobs, Lines, scaled};
use chiaro_image::Plane;
use chiaro_ink::{
    Area, Colour, Drawing, Fit, Hatch, Layer, Mark, NOTHING, Partition, Path, Placement, Polyline,
    SEAM_WIDTH, Soft, Travel, centre_lines, fit, joined, seams,
};
pub use chiaro_ink::{Sheet, length};
use serde_json::{Value, json};

/// Ends of strokes that are nearer than this are joined, in millimetres.
const JOIN: f64 = 0.1;
/// How far strokes may be from the lines of the picture, in millimetres.
const STROKE_TOLERANCE: f64 = 0.05;

/// What a map says of a line in ink.
const INK: u8 = 1;

/// How a picture lies on paper, and what draws it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Print {
    /// The paper.
    pub sheet: Sheet,
    /// The width of a plotter's pen in millimetres; `None`: regions are filled.
    pub pen: Option<f64>,
}

impl Print {
    /// For recipes.
    pub fn settings(&self) -> Value {
        let Sheet { paper, turns, margin, fits } = self.sheet;
        json!({ "paper": paper, "turns": turns, "margin": margin, "fits": fits, "pen": self.pen })
    }
}

/// What is drawn.
pub struct Plate<'a> {
    /// Labels of covered pixels, from 0 on.
    pub labels: &'a Plane<u8>,
    /// Where there is something.
    pub covered: &'a Plane<bool>,
    /// The colour of each label.
    pub colours: &'a [Colour],
    /// Lines on top.
    pub lines: &'a Lines,
    /// A map of lines over all: 0 none, 1 ink, 2 paper, and the sigma in pixels that smooths it.
    pub map: Option<&'a (Plane<u8>, f32)>,
    /// Colours of lines and background.
    pub scheme: &'a Colours,
}

/// Draws a plate as a whole SVG file; with how far the pen goes.
///
/// # Errors
/// [`chiaro_basis::Error::Setting`] when the margins leave nothing of the paper.
pub fn draw(
    plate: &Plate<'_>,
    knobs: &BinaryKnobs,
    print: &Print,
    title: &str,
    recipe: &str,
) -> Result<(String, Travel)> {
    let place = print.sheet.place(plate.labels.size())?;
    let (layers, travel) = layers(plate, knobs, print.pen, &place);
    let background = plate.scheme.background;
    let drawing = Drawing {
        page: place.page,
        title: title.into(),
        recipe: Some(recipe.into()),
        background: (background[3] > 0.0 && print.pen.is_none()).then_some(background),
        picture: None,
        layers,
    };
    Ok((drawing.to_svg(), travel))
}

/// The layers of a plate on a page: fills and strokes, or a plotter's strokes alone.
pub(crate) fn layers(
    plate: &Plate<'_>,
    knobs: &BinaryKnobs,
    pen: Option<f64>,
    place: &Placement,
) -> (Vec<Layer>, Travel) {
    let sigma = scaled(knobs.smooth, plate.labels.height());
    let count = plate.colours.len();
    let regions = Regions::trace(plate.labels, plate.covered, count, sigma, (knobs, place));
    let (mut layers, travel) = match pen {
        None => fill(plate, &regions, place),
        Some(pen) => Plotter { plate, knobs, place, pen }.layers(&regions),
    };
    let mut travel = travel;
    match (plate.map, pen) {
        (Some((map, _)), Some(pen)) => {
            let ink = plate.scheme.ink;
            let lines = strokes(&centre_lines(&map.map(|line| *line == INK)), place);
            let name = format!("{} map {}", layers.len() + 1, hex(ink));
            let (layer, way) = Layer::strokes(name, lines, pen, ink, JOIN);
            travel = travel + way;
            layers.push(layer);
        }
        (Some((map, sigma)), None) => {
            let lines = Regions::trace(map, &map.map(|_| true), 3, *sigma, (knobs, place));
            layers.extend(mapped(lines, plate.scheme, layers.len()));
        }
        (None, _) => {}
    }
    (layers, travel)
}

/// Stencils as a whole SVG file: a layer of holes each, in its colour, each hole one closed path with
/// what stands in it; filled, or with a pen as outlines for the blade.
///
/// # Errors
/// [`chiaro_basis::Error::Setting`] when the margins leave nothing of the paper.
pub fn stencil(
    sheets: &[(Colour, Plane<bool>)],
    look: &Look<'_>,
    (title, recipe): (&str, &str),
) -> Result<String> {
    let size = sheets.first().map_or((1, 1), |(_, sheet)| sheet.size());
    let place = look.print.sheet.place(size)?;
    let layers = sheets.iter().enumerate().map(|(i, (ink, sheet))| {
        let holes = holes(sheet, look, &place);
        match look.print.pen {
            None => {
                let marks = holes.into_iter().map(|outline| Mark::Fill { outline, colour: *ink });
                Layer { name: format!("{} holes {}", i + 1, hex(*ink)), marks: marks.collect() }
            }
            Some(pen) => {
                let paths = holes.into_iter().flatten().collect();
                let name = format!("{} cut {}", i + 1, hex(*ink));
                Layer::strokes(name, paths, pen, *ink, 0.0).0
            }
        }
    });
    let drawing = Drawing {
        page: place.page,
        title: title.into(),
        recipe: Some(recipe.into()),
        background: None,
        picture: None,
        layers: layers.collect(),
    };
    Ok(drawing.to_svg())
}

/// The outlines of a sheet's holes.
fn holes(sheet: &Plane<bool>, look: &Look<'_>, place: &Placement) -> Vec<Vec<Path>> {
    let labels = sheet.map(|s| u8::from(*s));
    let covered = sheet.map(|_| true);
    let sigma = scaled(look.knobs.smooth, sheet.height()).min(HAIR);
    Regions::trace(&labels, &covered, 2, sigma, (look.knobs, place)).by_label.swap_remove(0)
}

/// The outlines of each label's regions, on the page.
struct Regions {
    by_label: Vec<Vec<Vec<Path>>>,
    /// Borders that two labels share, as the lower label, on the page.
    seams: Vec<(u8, Path)>,
}

impl Regions {
    /// Traces labels from 0 to `count` - 1 after smoothing by `sigma` pixels.
    fn trace(
        labels: &Plane<u8>,
        covered: &Plane<bool>,
        count: usize,
        sigma: f32,
        (knobs, place): (&BinaryKnobs, &Placement),
    ) -> Self {
        let soft = Soft::new(labels, covered, count as u8, sigma);
        let (blur, rounds) = relaxing(sigma);
        let how = Fit {
            tolerance: f64::from(scaled(knobs.vector_tolerance, labels.height())),
            corner: f64::from(knobs.vector_corner).to_radians(),
            blur,
            rounds,
        };
        let partition = Partition::trace(soft.labels(), |p, q| soft.crossing(p, q), &how);
        let mut by_label = vec![Vec::new(); count];
        for region in partition.regions.iter().filter(|r| r.label != NOTHING) {
            let outline = partition.outline(region);
            let outline = outline.iter().map(|path| path.map(|p| place.at(p))).collect();
            by_label[usize::from(region.label)].push(outline);
        }
        let on_page = |(label, path): (u8, Path)| (label, path.map(|p| place.at(p)));
        let seams = seams(&partition, soft.labels()).into_iter().map(on_page).collect();
        Self { by_label, seams }
    }
}

/// Smoothing by less than this, in pixels, leaves the steps of pixels in borders.
const STEADY: f64 = 1.1;

/// Smoothing by so much, in pixels, leaves whole what is one pixel wide, along an axis or a diagonal.
const HAIR: f32 = 0.5;

/// How far borders smoothed by `sigma` pixels are smoothed in all, and the rounds along them that are
/// wanting; none where nothing is to be smoothed.
fn relaxing(sigma: f32) -> (f64, u32) {
    let sigma = f64::from(sigma);
    if sigma <= 0.0 || sigma >= STEADY {
        return (sigma.max(0.5), 0);
    }
    // A round along the border adds half a pixel's square to the variance.
    let rounds = (2.0 * (STEADY * STEADY - sigma * sigma)).ceil();
    (STEADY, rounds as u32)
}

/// The lines of a map as fills in ink and in paper's colour.
fn mapped(lines: Regions, scheme: &Colours, before: usize) -> Vec<Layer> {
    let mut layers = Vec::new();
    for (outlines, colour) in lines.by_label.into_iter().skip(1).zip([scheme.ink, scheme.paper]) {
        if !outlines.is_empty() {
            let name = format!("{} map {}", before + layers.len() + 1, hex(colour));
            let fill = |outline| Mark::Fill { outline, colour };
            layers.push(Layer { name, marks: outlines.into_iter().map(fill).collect() });
        }
    }
    layers
}

/// What lies beneath shared borders, a layer a colour; nothing where colours let what is beneath them
/// through.
fn beneath(plate: &Plate<'_>, regions: &Regions, place: &Placement) -> Vec<Layer> {
    let mut layers = Vec::new();
    if plate.colours.iter().any(|c| c[3] < 1.0) {
        return layers;
    }
    for (label, &colour) in plate.colours.iter().enumerate() {
        let width = SEAM_WIDTH * place.scale;
        let along = regions.seams.iter().filter(|(lower, _)| usize::from(*lower) == label);
        let stroke = |(_, path): &(u8, Path)| Mark::Stroke { path: path.clone(), width, colour };
        let marks: Vec<Mark> = along.map(stroke).collect();
        if !marks.is_empty() {
            let name = format!("{} beneath borders {}", layers.len() + 1, hex(colour));
            layers.push(Layer { name, marks });
        }
    }
    layers
}

/// Closed fills, a layer a colour, and the lines as strokes of their width.
fn fill(plate: &Plate<'_>, regions: &Regions, place: &Placement) -> (Vec<Layer>, Travel) {
    let mut layers = beneath(plate, regions, place);
    for (outlines, &colour) in regions.by_label.iter().zip(plate.colours) {
        let fill = |outline: &Vec<Path>| Mark::Fill { outline: outline.clone(), colour };
        let marks: Vec<Mark> = outlines.iter().map(fill).collect();
        if !marks.is_empty() {
            layers
                .push(Layer { name: format!("{} fill {}", layers.len() + 1, hex(colour)), marks });
        }
    }
    let width = f64::from(plate.lines.width) * place.scale;
    let mut travel = Travel::default();
    for (lines, colour) in
        [(&plate.lines.white, plate.scheme.paper), (&plate.lines.black, plate.scheme.ink)]
    {
        if !lines.is_empty() {
            let name = format!("{} lines {}", layers.len() + 1, hex(colour));
            let paths = strokes(lines, place);
            let (layer, way) = Layer::strokes(name, paths, width, colour, 0.0);
            layers.push(layer);
            travel = travel + way;
        }
    }
    (layers, travel)
}

/// Strokes of one pen a colour.
struct Plotter<'a> {
    plate: &'a Plate<'a>,
    knobs: &'a BinaryKnobs,
    place: &'a Placement,
    pen: f64,
}

impl Plotter<'_> {
    fn layers(&self, regions: &Regions) -> (Vec<Layer>, Travel) {
        let mut layers = Vec::new();
        let mut travel = Travel::default();
        let scheme = self.plate.scheme;
        let free = strokes(&self.plate.lines.white, self.place);
        let tones = regions.by_label.iter().zip(self.plate.colours).enumerate();
        for (tone, (outlines, &colour)) in tones {
            let turned = self.knobs.hatch_angle + tone as f32 * self.knobs.hatch_turn;
            let mut paths = self.hatched(outlines, (colour, turned), &free);
            if colour == scheme.ink {
                paths.extend(strokes(&self.plate.lines.black, self.place));
            }
            if !paths.is_empty() {
                let name = format!("{} pen {}", layers.len() + 1, hex(colour));
                let (layer, way) = Layer::strokes(name, paths, self.pen, colour, JOIN);
                layers.push(layer);
                travel = travel + way;
            }
        }
        (layers, travel)
    }

    /// Strokes of a colour's regions at an angle in degrees; `free` lines are left out.
    fn hatched(
        &self,
        outlines: &[Vec<Path>],
        (colour, degrees): (Colour, f32),
        free: &[Path],
    ) -> Vec<Path> {
        let Some(spacing) = self.spacing(colour) else { return Vec::new() };
        let angle = f64::from(degrees).to_radians();
        let how = Hatch { angle, spacing, pen: self.pen };
        let width = f64::from(self.plate.lines.width) * self.place.scale;
        let mut paths = Vec::new();
        for outline in outlines {
            let mut area = Area::new(outline);
            area.keep_free(free, width);
            paths.extend(area.hatched(&how));
            if self.knobs.hatch_outline {
                paths.extend(area.inset(self.pen).iter().filter_map(|p| smoothed(p, self.pen)));
            }
        }
        paths
    }

    /// Millimetres from stroke to stroke: black as the knob says, lighter colours in proportion;
    /// `None` for the paper's colour.
    fn spacing(&self, colour: Colour) -> Option<f64> {
        let lightness = |c: Colour| 0.299 * c[0] + 0.587 * c[1] + 0.114 * c[2];
        let paper = lightness(self.plate.scheme.paper);
        let dark = f64::from((paper - lightness(colour)) / paper.max(1e-3));
        let full = f64::from(self.knobs.hatch_spacing) * self.pen;
        // A colour as light as paper still shows, if it is another.
        (colour != self.plate.scheme.paper).then(|| full / dark.clamp(0.1, 1.0))
    }
}

/// Lines of pixels as strokes on the page, joined and fitted.
fn strokes(lines: &[Polyline], place: &Placement) -> Vec<Path> {
    let on_page = |line: &Polyline| {
        let points: Vec<_> = line.points.iter().map(|p| place.at(p.map(f64::from))).collect();
        Path::through(&points, line.closed)
    };
    let paths = joined(lines.iter().filter_map(on_page).collect(), JOIN);
    paths.iter().filter_map(|path| smoothed(path, place.scale)).collect()
}

/// A path of short straight pieces, about `step` long, as few curves.
fn smoothed(path: &Path, step: f64) -> Option<Path> {
    let mut points = path.points(STROKE_TOLERANCE);
    if path.closed {
        points.pop();
    }
    let corner = std::f64::consts::FRAC_PI_4;
    fit(&points, path.closed, &Fit { tolerance: STROKE_TOLERANCE, corner, blur: step, rounds: 0 })
}

fn hex(colour: Colour) -> String {
    let [r, g, b] = [0, 1, 2].map(|i| (colour[i].clamp(0.0, 1.0) * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::Style;

    #[test]
    fn holes_of_a_pixels_width_stay_whole() {
        let slanted = |x: usize, y: usize| (10..190).contains(&x) && y == 20 + x * 7 / 20;
        let sheet = Plane::from_fn(200, 120, |x, y| !slanted(x, y) && y != 110);
        let style = Style::find("ink").unwrap();
        let look = Look::of(&style);
        let place = look.print.sheet.place(sheet.size()).unwrap();
        let holes = holes(&sheet, &look, &place);
        assert_eq!(holes.len(), 2, "one a line");
        assert!(holes.iter().all(|hole| hole.len() == 1));
    }

    #[test]
    fn hatching_of_each_lighter_colour_is_turned() {
        let style = Style::find("ink").unwrap();
        let look = Look::of(&style);
        let labels = Plane::from_fn(120, 80, |x, _| u8::from(x >= 60));
        let covered = labels.map(|_| true);
        let knobs = BinaryKnobs {
            hatch_angle: 20.0,
            hatch_turn: 50.0,
            hatch_outline: false,
            ..BinaryKnobs::default()
        };
        let plate = Plate {
            labels: &labels,
            covered: &covered,
            colours: &[[0.0, 0.0, 0.0, 1.0], [0.5, 0.5, 0.5, 1.0]],
            lines: &Lines::default(),
            map: None,
            scheme: &look.colours,
        };
        let place = look.print.sheet.place(labels.size()).unwrap();
        let (drawn, _) = layers(&plate, &knobs, Some(0.3), &place);
        assert_eq!(drawn.len(), 2);
        for (layer, wanted) in drawn.iter().zip([20.0, 70.0]) {
            // Strokes may be joined at their ends: the longest straight piece tells.
            let sides = layer.marks.iter().flat_map(|mark| {
                let Mark::Stroke { path, .. } = mark else { return Vec::new() };
                let points = path.points(0.01);
                points.windows(2).map(|p| [p[1][0] - p[0][0], p[1][1] - p[0][1]]).collect()
            });
            let length = |[x, y]: &[f64; 2]| x.hypot(*y);
            let long = sides.max_by(|a, b| length(a).total_cmp(&length(b)));
            let [x, y] = long.unwrap();
            let degrees = y.atan2(x).to_degrees().rem_euclid(180.0);
            assert!((degrees - wanted).abs() < 1.0, "{degrees} for {wanted}");
        }
    }
}
