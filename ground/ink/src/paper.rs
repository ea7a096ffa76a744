//! Paper: where a picture of so many pixels lies on a sheet, in millimetres.

use crate::Point;
use chiaro_basis::{Error, Result};

/// Millimetres in an inch.
const INCH: f64 = 25.4;

/// Pixels an inch of a picture without paper, as browsers have it.
const SCREEN_DPI: f64 = 96.0;

/// Papers by name, portrait, in millimetres.
const PAPERS: [(&str, Point); 11] = [
    ("A0", [841.0, 1189.0]),
    ("A1", [594.0, 841.0]),
    ("A2", [420.0, 594.0]),
    ("A3", [297.0, 420.0]),
    ("A4", [210.0, 297.0]),
    ("A5", [148.0, 210.0]),
    ("A6", [105.0, 148.0]),
    ("letter", [215.9, 279.4]),
    ("legal", [215.9, 355.6]),
    ("tabloid", [279.4, 431.8]),
    ("postcard", [100.0, 148.0]),
];

/// A sheet of paper with its margin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Width and height in millimetres; `None`: as large as the picture with its margins.
    pub paper: Option<Point>,
    /// Whether the paper may be turned to suit the picture.
    pub turns: bool,
    /// What stays free on every side, in millimetres.
    pub margin: f64,
    /// Whether the picture fills what the margins leave; else it keeps its own size, 96 pixels to
    /// the inch, in the middle.
    pub fits: bool,
}

impl Default for Sheet {
    fn default() -> Self {
        Self { paper: None, turns: true, margin: 0.0, fits: true }
    }
}

/// Where pixels lie on a page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Width and height of the page in millimetres.
    pub page: Point,
    /// Millimetres a pixel.
    pub scale: f64,
    /// The picture's upper left corner on the page, in millimetres.
    pub origin: Point,
}

impl Sheet {
    /// Sets the paper by name (`A4`, `letter`), by name and direction (`A4-landscape`), or by size
    /// (`200x300mm`).
    ///
    /// # Errors
    /// [`Error::Setting`] for what is neither.
    pub fn set_paper(&mut self, text: &str) -> Result<()> {
        let (name, turn) = match text.rsplit_once('-') {
            Some((name, turn @ ("landscape" | "portrait"))) => (name, Some(turn)),
            _ => (text, None),
        };
        let [a, b] = named(name).map_or_else(|| sized(name), Ok)?;
        self.paper = Some(match turn {
            Some("landscape") => [f64::max(a, b), f64::min(a, b)],
            Some(_) => [f64::min(a, b), f64::max(a, b)],
            None => [a, b],
        });
        self.turns = turn.is_none() && named(name).is_some();
        Ok(())
    }

    /// Where a picture of `width` x `height` pixels lies: in the middle of what the margins leave.
    ///
    /// # Errors
    /// [`Error::Setting`] when the margins leave nothing.
    pub fn place(&self, (width, height): (usize, usize)) -> Result<Placement> {
        let own = INCH / SCREEN_DPI;
        let pixels = [width as f64, height as f64];
        let Some(paper) = self.paper else {
            let page = pixels.map(|n| n * own + 2.0 * self.margin);
            return Ok(Placement { page, scale: own, origin: [self.margin; 2] });
        };
        let turned = self.turns && (pixels[0] > pixels[1]) != (paper[0] > paper[1]);
        let page = if turned { [paper[1], paper[0]] } else { paper };
        let room = page.map(|side| side - 2.0 * self.margin);
        if room[0].min(room[1]) < 1.0 {
            let range = format!("less than half of the paper, {} x {} mm", page[0], page[1]);
            return Err(Error::setting("--margin", format!("{}mm", self.margin), range));
        }
        let full = (room[0] / pixels[0]).min(room[1] / pixels[1]);
        let scale = if self.fits { full } else { own };
        let origin = std::array::from_fn(|i| 0.5 * (page[i] - pixels[i] * scale));
        Ok(Placement { page, scale, origin })
    }
}

impl Placement {
    /// A point in pixels on the page, in millimetres.
    pub fn at(&self, [x, y]: Point) -> Point {
        [self.origin[0] + self.scale * x, self.origin[1] + self.scale * y]
    }

    /// The dots an inch that one pixel a dot makes.
    pub fn dpi(&self) -> f64 {
        INCH / self.scale
    }
}

fn named(name: &str) -> Option<Point> {
    PAPERS.iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, size)| *size)
}

fn sized(text: &str) -> Result<Point> {
    let wrong = || {
        let names: Vec<&str> = PAPERS.iter().map(|(n, _)| *n).collect();
        let range = format!(
            "{}, with -landscape or -portrait, or a size as in 200x300mm",
            names.join(", ")
        );
        Error::setting("--paper", text, range)
    };
    let (a, b) = text.split_once('x').ok_or_else(wrong)?;
    let unit = b.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let a = if a.ends_with(|c: char| c.is_ascii_digit()) { format!("{a}{unit}") } else { a.into() };
    let side = |t: &str| length("--paper", t, 1.0..=10_000.0).map_err(|_| wrong());
    Ok([side(&a)?, side(b)?])
}

/// A length as typed (`10mm`, `1cm`, `0.5in`, `3pt`; millimetres without a unit), in millimetres.
///
/// # Errors
/// [`Error::Setting`] under the name `option` for what is no length, or one outside `range`.
pub fn length(option: &str, text: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64> {
    let text = text.trim();
    let end = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let unit = match text[end..].to_ascii_lowercase().as_str() {
        "" | "mm" => 1.0,
        "cm" => 10.0,
        "in" => INCH,
        "pt" => INCH / 72.0,
        _ => f64::NAN,
    };
    let value = text[..end].trim().parse::<f64>().unwrap_or(f64::NAN) * unit;
    if range.contains(&value) {
        return Ok(value);
    }
    let expected =
        format!("a length from {} to {} mm, as in 3mm, 1cm or 0.5in", range.start(), range.end());
    Err(Error::setting(option, text, expected))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(paper: &str, margin: f64) -> Sheet {
        let mut sheet = Sheet { margin, ..Sheet::default() };
        sheet.set_paper(paper).unwrap();
        sheet
    }

    #[test]
    fn a_picture_fits_what_the_margins_leave() {
        let p = sheet("A4", 10.0).place((1000, 2000)).unwrap();
        assert_eq!(p.page, [210.0, 297.0]);
        assert!((p.at([500.0, 2000.0])[1] - 287.0).abs() < 1e-9);
        assert!((p.at([500.0, 0.0])[0] - 105.0).abs() < 1e-9);
        let wide = sheet("a4", 10.0).place((2000, 1000)).unwrap();
        assert_eq!(wide.page, [297.0, 210.0]);
        let kept = sheet("A4-portrait", 10.0).place((2000, 1000)).unwrap();
        assert_eq!(kept.page, [210.0, 297.0]);
    }

    #[test]
    fn without_paper_a_picture_keeps_its_size() {
        let p = Sheet::default().place((960, 480)).unwrap();
        assert_eq!(p.page, [254.0, 127.0]);
        assert_eq!(p.dpi(), 96.0);
    }

    #[test]
    fn papers_and_lengths_are_read_as_typed() {
        assert_eq!(sheet("200x300mm", 0.0).paper, Some([200.0, 300.0]));
        assert_eq!(sheet("20cmx30cm", 0.0).paper, Some([200.0, 300.0]));
        assert_eq!(length("--pen", "0.3mm", 0.0..=9.0).unwrap(), 0.3);
        assert_eq!(length("--margin", "1in", 0.0..=99.0).unwrap(), 25.4);
        for wrong in ["", "mm", "-3mm", "3m", "1e999", "nan"] {
            assert!(length("--margin", wrong, 0.0..=99.0).is_err(), "{wrong}");
        }
        for wrong in ["A9", "x", "0x3mm", "3x", "axb"] {
            let error = Sheet::default().set_paper(wrong).unwrap_err().to_string();
            assert!(error.contains("A4"), "{error}");
        }
        assert!(sheet("A6", 60.0).place((10, 10)).is_err());
    }
}
