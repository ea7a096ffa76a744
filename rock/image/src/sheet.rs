//! [`Sheet`]: a contact sheet, pictures in a grid with a caption under each.
//!
//! The page is light grey, so that both white and black pictures stand out, each in a thin frame.
//! Columns are as wide as the widest picture, rows as high as their highest; pictures stand at the
//! left of the foot of their cell, above their captions. A caption that needs too many lines is
//! drawn smaller, and then cut.

use crate::Plane;
use crate::colour::{srgb_decode, srgb_encode, to_byte};
use crate::resample::area_average;
use crate::text::{LINE_HEIGHT, draw_text, fill, text_width, wrap_text};

const PAGE: [u8; 3] = [238, 238, 236];
const FRAME: [u8; 3] = [176, 176, 172];
const INK: [u8; 3] = [46, 46, 48];

/// Pixels around the sheet and between its cells.
const MARGIN: usize = 16;

/// Pixels between a picture and its caption.
const CAPTION_GAP: usize = 6;

/// The narrowest column, in which captions still read.
const NARROWEST: usize = 96;

/// Lines of a caption at its size; at scale 1, twice as many.
const LINES: usize = 2;

/// A contact sheet in the making.
///
/// ```
/// use chiaro_image::{Plane, sheet::Sheet};
/// let mut sheet = Sheet::new(2).title("Two greys");
/// sheet.add(Plane::filled(120, 80, [90; 3]), "dark");
/// sheet.add(Plane::filled(120, 80, [200; 3]), "light");
/// assert_eq!(sheet.draw().width(), 16 + 122 + 16 + 122 + 16);
/// ```
#[derive(Clone, Debug)]
pub struct Sheet {
    columns: usize,
    scale: usize,
    largest: (usize, usize),
    title: Option<String>,
    cells: Vec<(Plane<[u8; 3]>, String)>,
}

impl Sheet {
    /// An empty sheet of so many columns, at least one.
    pub fn new(columns: usize) -> Self {
        let largest = (usize::MAX, usize::MAX);
        Self { columns: columns.max(1), scale: 1, largest, title: None, cells: Vec::new() }
    }

    /// A line above the pictures, twice as large as the captions.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into());
        self
    }

    /// Captions so many times larger: 1 (the default) or 2.
    pub fn text_scale(mut self, scale: usize) -> Self {
        self.scale = scale.clamp(1, 2);
        self
    }

    /// Shrinks pictures that are added from now on until they fit this width and height.
    pub fn thumbnails(mut self, width: usize, height: usize) -> Self {
        self.largest = (width.max(1), height.max(1));
        self
    }

    /// Adds a picture, sRGB-encoded, and what stands beneath it.
    pub fn add(&mut self, picture: Plane<[u8; 3]>, caption: impl Into<String>) {
        self.cells.push((thumbnail(picture, self.largest), caption.into()));
    }

    /// The sheet as a picture.
    pub fn draw(&self) -> Plane<[u8; 3]> {
        let layout = Layout::of(self);
        let mut page = Plane::filled(layout.width, layout.height, PAGE);
        for (i, line) in layout.title.iter().enumerate() {
            let y = MARGIN + i * LINE_HEIGHT * 2;
            draw_text(&mut page, (MARGIN, y), line, 2, INK);
        }
        for (i, (picture, _)) in self.cells.iter().enumerate() {
            let row = &layout.rows[i / self.columns];
            let x = MARGIN + i % self.columns * (layout.column + MARGIN);
            let top = row.top + row.pictures - framed(picture.height());
            place(&mut page, picture, (x, top));
            let caption = &layout.captions[i];
            let y = row.top + row.pictures + CAPTION_GAP;
            for (n, line) in caption.lines.iter().enumerate() {
                let at = (x, y + n * LINE_HEIGHT * caption.scale);
                draw_text(&mut page, at, line, caption.scale, INK);
            }
        }
        page
    }
}

/// A side with its frame.
fn framed(length: usize) -> usize {
    length + 2
}

/// Draws a picture and the frame around it.
fn place(page: &mut Plane<[u8; 3]>, picture: &Plane<[u8; 3]>, (left, top): (usize, usize)) {
    fill(page, (left, top), (framed(picture.width()), framed(picture.height())), FRAME);
    for y in 0..picture.height() {
        let start = (top + 1 + y) * page.width() + left + 1;
        page.pixels_mut()[start..start + picture.width()].copy_from_slice(picture.row(y));
    }
}

/// Where everything on a sheet goes, in pixels.
struct Layout {
    width: usize,
    height: usize,
    column: usize,
    title: Vec<String>,
    captions: Vec<Caption>,
    rows: Vec<Row>,
}

/// A row of cells: its upper edge, and the height of its pictures.
struct Row {
    top: usize,
    pictures: usize,
}

/// A caption in lines that fit its column.
struct Caption {
    scale: usize,
    lines: Vec<String>,
}

impl Layout {
    fn of(sheet: &Sheet) -> Self {
        let widest = sheet.cells.iter().map(|(picture, _)| framed(picture.width())).max();
        let column = widest.unwrap_or(0).max(NARROWEST * sheet.scale);
        let columns = sheet.columns.min(sheet.cells.len().max(1));
        let width = columns * (column + MARGIN) + MARGIN;
        let title = sheet.title.as_deref().map(|title| wrap_text(title, width - 2 * MARGIN, 2));
        let title = title.unwrap_or_default();
        let captions: Vec<Caption> =
            sheet.cells.iter().map(|(_, text)| Caption::of(text, column, sheet.scale)).collect();
        let mut height = MARGIN + title.len() * LINE_HEIGHT * 2;
        height += if title.is_empty() { 0 } else { MARGIN / 2 };
        let mut rows = Vec::new();
        for (cells, captions) in sheet.cells.chunks(columns).zip(captions.chunks(columns)) {
            let pictures = cells.iter().map(|(picture, _)| framed(picture.height())).max();
            let row = Row { top: height, pictures: pictures.unwrap_or(0) };
            let text = captions.iter().map(Caption::height).max().unwrap_or(0);
            height += row.pictures + text + MARGIN;
            rows.push(row);
        }
        Self { width, height: height.max(2 * MARGIN), column, title, captions, rows }
    }
}

impl Caption {
    fn of(text: &str, width: usize, scale: usize) -> Self {
        let lines = wrap_text(text, width, scale);
        if scale > 1 && lines.len() > LINES {
            return Self::of(text, width, scale - 1);
        }
        let most = if scale > 1 { LINES } else { 2 * LINES };
        Self { scale, lines: cut(lines, most, width, scale) }
    }

    /// Pixels from the foot of the picture to the foot of the caption.
    fn height(&self) -> usize {
        if self.lines.is_empty() {
            0
        } else {
            CAPTION_GAP + self.lines.len() * LINE_HEIGHT * self.scale
        }
    }
}

/// The first `most` lines, the last of them ending in dots when there were more.
fn cut(mut lines: Vec<String>, most: usize, width: usize, scale: usize) -> Vec<String> {
    if lines.len() > most {
        lines.truncate(most);
        if let Some(last) = lines.last_mut() {
            while !last.is_empty() && text_width(&format!("{last}..."), scale) > width {
                last.pop();
            }
            last.push_str("...");
        }
    }
    lines
}

/// A picture that fits `largest`, shrunk in linear light if it does not.
fn thumbnail(picture: Plane<[u8; 3]>, largest: (usize, usize)) -> Plane<[u8; 3]> {
    let (width, height) = picture.size();
    let shrink = (largest.0 as f64 / width as f64).min(largest.1 as f64 / height as f64);
    if picture.is_empty() || shrink >= 1.0 {
        return picture;
    }
    let side = |length: usize| ((length as f64 * shrink).round() as usize).max(1);
    let linear = picture.map(|p| p.map(|c| srgb_decode(f32::from(c) / 255.0)));
    let small = area_average(&linear, side(width), side(height));
    small.map(|p| p.map(|c| to_byte(srgb_encode(c))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::write_png_rgb;

    fn shade(width: usize, height: usize, tint: [u8; 3]) -> Plane<[u8; 3]> {
        Plane::from_fn(width, height, |x, y| {
            let light = (255 * (x + y) / (width + height)) as u8;
            tint.map(|c| (u32::from(c) * u32::from(light) / 255) as u8)
        })
    }

    fn sample(scale: usize) -> Sheet {
        let mut sheet =
            Sheet::new(3).title("Styles: (quick) & [clean], 0.5 < g <= 1?").text_scale(scale);
        sheet.add(shade(150, 100, [255; 3]), "woodcut");
        sheet.add(shade(150, 130, [255, 200, 90]), "linocut {bold}; line \"sliding_limit\" = 2.5");
        sheet.add(
            shade(90, 60, [90, 160, 255]),
            "a caption that goes on and on, and then on, ".repeat(6),
        );
        sheet.add(
            Plane::filled(150, 100, [255; 3]),
            "pen#4 @ 100% 'fine' ~ 3/4 * 7 + 8 - 9 = $^_|`\\",
        );
        sheet.add(
            Plane::filled(150, 100, [0; 3]),
            "the_name_of_a_style_without_any_space_to_break_at",
        );
        sheet
    }

    /// Set `CHIARO_SHEET` to a path to look at the sample.
    fn look(sheet: &Plane<[u8; 3]>) {
        if let Ok(path) = std::env::var("CHIARO_SHEET") {
            std::fs::write(path, write_png_rgb(sheet, None).unwrap()).unwrap();
        }
    }

    /// FNV-1a.
    fn hash(plane: &Plane<[u8; 3]>) -> u64 {
        plane.pixels().as_flattened().iter().fold(0xCBF2_9CE4_8422_2325, |hash, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3)
        })
    }

    #[test]
    fn the_sheet_looks_as_it_was_judged() {
        let sheet = sample(1).draw();
        look(&sheet);
        assert_eq!(sheet.size(), (520, 390));
        assert_eq!(hash(&sheet), 0x7479_86B8_6735_7ECA);
    }

    #[test]
    fn captions_are_drawn_smaller_before_they_are_cut() {
        let short = Caption::of("woodcut", 150, 2);
        assert_eq!((short.scale, short.lines.len()), (2, 1));
        let longer = Caption::of("three lines at the larger size, so not", 150, 2);
        assert_eq!((longer.scale, longer.lines.len()), (1, 2));
        let endless = Caption::of(&"on and ".repeat(50), 150, 2);
        assert_eq!((endless.scale, endless.lines.len()), (1, 4));
        assert!(endless.lines[3].ends_with("..."));
        assert!(endless.lines.iter().all(|line| text_width(line, 1) <= 150));
    }

    #[test]
    fn large_pictures_shrink_to_thumbnails_and_keep_their_light() {
        let mut sheet = Sheet::new(1).thumbnails(100, 100);
        let checks = Plane::from_fn(400, 200, |x, y| [[0u8; 3], [255; 3]][(x + y) % 2]);
        sheet.add(checks, "");
        let page = sheet.draw();
        assert_eq!(page.size(), (16 + 102 + 16, 16 + 52 + 16));
        assert_eq!(page[(60, 40)], [188; 3]);
    }

    #[test]
    fn sheets_of_nothing_are_bare_pages() {
        assert!(Sheet::new(0).draw().pixels().iter().all(|p| *p == PAGE));
        let mut sheet = Sheet::new(4).title("one empty picture");
        sheet.add(Plane::default(), "none");
        assert!(sheet.draw().len() > 1000);
    }
}
