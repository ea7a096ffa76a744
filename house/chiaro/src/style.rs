//! Named styles: sets of knobs as editable TOML.
//!
//! A style file has a one-line `description`, a table `[binary]` of knobs for regions, tables
//! `[lines]`, `[stroke]` and `[[rule]]` for lines ([`LineStyle`]), the colours `ink`, `paper` and
//! `background` where they are its own, and `over`: what its lines are drawn over; over regions they
//! take the place of the regions' own. What a file does not name keeps its default.

use crate::colours::Colours;
use crate::lines::LineStyle;
use chiaro_basis::{Error, Knobs, Result, Value, nearest};
use chiaro_binary::BinaryKnobs;
use chiaro_image::colour::parse_colour;
use std::path::Path;

/// A named style.
#[derive(Clone, Debug)]
pub struct Style {
    /// Its name.
    pub name: String,
    /// What it looks like, in one line.
    pub description: String,
    /// Its knobs for regions.
    pub binary: BinaryKnobs,
    /// Its lines.
    pub lines: LineStyle,
    /// What lines are drawn over: nothing, binary, light, or pictures.
    pub over: String,
    /// Its own ink, paper and background, as typed.
    colours: [Option<String>; 3],
    parts: Parts,
}

/// Which parts of a style its file has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Parts {
    binary: bool,
    lines: bool,
}

/// The styles that ship with the program: name and text.
pub const BUILT_IN: [(&str, &str); 27] = [
    ("ink", include_str!("../styles/ink.toml")),
    ("brush", include_str!("../styles/brush.toml")),
    ("etched", include_str!("../styles/etched.toml")),
    ("gloss", include_str!("../styles/gloss.toml")),
    ("noir", include_str!("../styles/noir.toml")),
    ("poster", include_str!("../styles/poster.toml")),
    ("woodcut", include_str!("../styles/woodcut.toml")),
    ("manga", include_str!("../styles/manga.toml")),
    ("scratchboard", include_str!("../styles/scratchboard.toml")),
    ("pen", include_str!("../styles/pen.toml")),
    ("shadow", include_str!("../styles/shadow.toml")),
    ("lino", include_str!("../styles/lino.toml")),
    ("blueprint", include_str!("../styles/blueprint.toml")),
    ("grisaille", include_str!("../styles/grisaille.toml")),
    ("charcoal", include_str!("../styles/charcoal.toml")),
    ("pencil", include_str!("../styles/pencil.toml")),
    ("chalk", include_str!("../styles/chalk.toml")),
    ("wash", include_str!("../styles/wash.toml")),
    ("calligraphy", include_str!("../styles/calligraphy.toml")),
    ("dashes", include_str!("../styles/dashes.toml")),
    ("dots", include_str!("../styles/dots.toml")),
    ("thorns", include_str!("../styles/thorns.toml")),
    ("fur", include_str!("../styles/fur.toml")),
    ("double", include_str!("../styles/double.toml")),
    ("cactus", include_str!("../styles/cactus.toml")),
    ("comic", include_str!("../styles/comic.toml")),
    ("lit", include_str!("../styles/lit.toml")),
];

impl Style {
    /// The style called `name`, or the one in the file of that name.
    pub fn find(name: &str) -> Result<Self> {
        if let Some((name, text)) = BUILT_IN.iter().find(|(n, _)| *n == name) {
            return Self::parse(name, text, Path::new(""));
        }
        if name.ends_with(".toml") || Path::new(name).is_file() {
            let bytes = crate::disk::read(Path::new(name))?;
            let text = String::from_utf8(bytes)
                .map_err(|_| Error::input(name, "", "is no text; name a TOML file"))?;
            let folder = Path::new(name).parent().unwrap_or(Path::new(""));
            return Self::parse(name, &text, folder);
        }
        let names = BUILT_IN.map(|(n, _)| n);
        let hint = nearest(name, names).map(|n| format!("; did you mean {n}?")).unwrap_or_default();
        let range = format!("one of {}, or a TOML file{hint}", names.join(", "));
        Err(Error::setting("--style", name, range))
    }

    /// All styles that ship with the program.
    pub fn all() -> Result<Vec<Self>> {
        BUILT_IN.iter().map(|(name, text)| Self::parse(name, text, Path::new(""))).collect()
    }

    fn parse(name: &str, text: &str, folder: &Path) -> Result<Self> {
        let table: toml::Table = text.parse().map_err(|e: toml::de::Error| {
            let line =
                e.span().map_or(1, |s| text[..s.start.min(text.len())].matches('\n').count() + 1);
            Error::input(name, format!("line {line}"), e.message().to_string())
        })?;
        let mut style = Self {
            name: name.into(),
            description: String::new(),
            binary: BinaryKnobs::default(),
            lines: LineStyle::default(),
            over: NOTHING.into(),
            colours: [const { None }; 3],
            parts: Parts::default(),
        };
        // Rules come after what they change.
        let (rules, others): (Vec<_>, Vec<_>) = table.iter().partition(|(key, _)| *key == "rule");
        for (key, value) in others.into_iter().chain(rules) {
            style.read(key, value)?;
        }
        style.lines.load_textures(folder)?;
        Ok(style)
    }

    /// Takes one entry of a file.
    fn read(&mut self, key: &str, value: &toml::Value) -> Result<()> {
        let name = &self.name;
        match (key, value) {
            ("description", toml::Value::String(s)) => self.description = s.clone(),
            ("over", toml::Value::String(s)) => self.over = s.clone(),
            ("ink" | "paper" | "background", toml::Value::String(s)) => {
                parse_colour(s).map_err(|e| Error::input(name, key, e.to_string()))?;
                let place = COLOURS.iter().position(|c| *c == key).unwrap_or(0);
                self.colours[place] = Some(s.clone());
            }
            ("binary", toml::Value::Table(knobs)) => {
                self.parts.binary = true;
                set_all(&mut self.binary, name, knobs)?;
            }
            ("lines", toml::Value::Table(t)) => {
                self.parts.lines = true;
                self.lines.read_knobs(name, t)?;
            }
            ("stroke", toml::Value::Table(t)) => {
                self.parts.lines = true;
                self.lines.read_stroke(name, t)?;
            }
            ("rule", toml::Value::Array(rules)) => {
                self.parts.lines = true;
                self.lines.read_rules(name, rules)?;
            }
            _ => {
                let why = "is not part of a style; a style has description, ink, paper, background \
                           and over, the tables [binary], [lines] and [stroke], and [[rule]]";
                return Err(Error::input(name, key, why));
            }
        }
        Ok(())
    }

    /// Whether it says anything about regions, or nothing about anything.
    pub fn has_regions(&self) -> bool {
        self.parts.binary || !self.parts.lines
    }

    /// Whether it says anything about lines, or nothing about anything.
    pub fn has_lines(&self) -> bool {
        self.parts.lines || !self.parts.binary
    }

    /// The style called `name`, if it is one of regions.
    pub fn of_regions(name: &str) -> Result<Self> {
        let style = Self::find(name)?;
        if style.has_regions() {
            return Ok(style);
        }
        let why = format!("a style of regions; {name} is for chiaro lines: see chiaro style list");
        Err(Error::setting("--style", name, why))
    }

    /// The style called `name`, if it is one of lines.
    pub fn of_lines(name: &str) -> Result<Self> {
        let style = Self::find(name)?;
        if style.has_lines() {
            return Ok(style);
        }
        let why = format!("a style of lines; {name} is for chiaro binary: see chiaro style list");
        Err(Error::setting("--style", name, why))
    }

    /// Its colours: black on white where it has none of its own.
    pub fn colours(&self) -> Colours {
        let own = |i: usize, default| {
            let text = self.colours[i].as_deref();
            text.and_then(|t| parse_colour(t).ok()).unwrap_or(default)
        };
        let plain = Colours::default();
        let paper = own(1, plain.paper);
        Colours { ink: own(0, plain.ink), paper, background: own(2, paper) }
    }

    /// The whole style as TOML, every knob with its help.
    pub fn to_toml(&self) -> String {
        let mut text = format!("description = {:?}\n", self.description);
        for (name, colour) in COLOURS.iter().zip(&self.colours) {
            if let Some(colour) = colour {
                text += &format!("{name} = {colour:?}\n");
            }
        }
        if self.over != NOTHING {
            text += &format!("over = {:?}\n", self.over);
        }
        if self.has_regions() {
            text += "\n[binary]\n";
            text += &knob_lines(&self.binary);
        }
        if self.has_lines() {
            text += &self.lines.to_toml();
        }
        text
    }
}

/// Colours that a style may have.
const COLOURS: [&str; 3] = ["ink", "paper", "background"];

/// What lines are drawn over by default.
const NOTHING: &str = "nothing";

/// A table of knobs as lines of TOML, each with its help.
pub(crate) fn knob_lines(knobs: &impl Knobs) -> String {
    let line = |(knob, value): (&chiaro_basis::Knob, Value)| {
        let value = match value {
            Value::Word(word) => format!("{word:?}"),
            other => other.to_string(),
        };
        let unit = if knob.unit.is_empty() { String::new() } else { format!(" [{}]", knob.unit) };
        let symbol =
            if knob.symbol.is_empty() { String::new() } else { format!(" {}", knob.symbol) };
        format!("{} = {value} # {}{unit}{symbol}\n", knob.name, knob.help)
    };
    knobs.values().into_iter().map(line).collect()
}

fn set_all(knobs: &mut BinaryKnobs, file: &str, table: &toml::Table) -> Result<()> {
    for (key, value) in table {
        let text = match value {
            toml::Value::String(s) => s.clone(),
            other => other.to_string(),
        };
        knobs.set(key, &text).map_err(|e| in_file(file, "[binary]", key, e))?;
    }
    Ok(())
}

/// What is wrong with a knob in a table of a file.
pub(crate) fn in_file(file: &str, table: &str, key: &str, error: Error) -> Error {
    match error {
        Error::Setting { got, range, .. } => {
            Error::input(file, format!("{table} {key} = {got}"), format!("expected {range}"))
        }
        other => Error::input(file, format!("{table} {key}"), other.to_string()),
    }
}

/// Sets one knob from `key=value`, as `--set` has it.
pub fn set(knobs: &mut impl Knobs, text: &str) -> Result<()> {
    let (key, value) = text
        .split_once('=')
        .ok_or_else(|| Error::setting("--set", text, "a knob and its value, as in global=0.5"))?;
    knobs.set(key.trim(), value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_style_reads_back_from_its_own_text() {
        for style in Style::all().unwrap() {
            let again = Style::parse(&style.name, &style.to_toml(), Path::new("")).unwrap();
            assert_eq!(again.binary, style.binary, "{}", style.name);
            assert_eq!(again.lines, style.lines, "{}", style.name);
            assert_eq!((again.colours(), again.over), (style.colours(), style.over));
            assert!(!style.description.is_empty());
        }
    }

    #[test]
    fn lines_over_regions_take_the_place_of_their_own() {
        let comic = Style::find("comic").unwrap();
        let look = crate::lines::Look::of(&comic).unwrap();
        assert!(comic.binary.lines && !look.binary.lines);
        let pen = Style::find("pen").unwrap();
        assert!(pen.binary.lines && crate::lines::Look::of(&pen).unwrap().binary.lines);
    }

    #[test]
    fn styles_differ_in_more_than_two_knobs() {
        let mut styles = Style::all().unwrap();
        styles.retain(Style::has_regions);
        for (i, a) in styles.iter().enumerate() {
            for b in &styles[i + 1..] {
                let pairs = a.binary.values().into_iter().zip(b.binary.values());
                let differ = pairs.filter(|((_, x), (_, y))| x != y).count();
                assert!(differ > 2, "{} and {} differ in {differ} knobs", a.name, b.name);
            }
        }
    }

    #[test]
    fn a_wrong_style_names_file_place_and_remedy() {
        let error = Style::parse("my.toml", "[binary]\nglobul = 0.3", Path::new(""))
            .unwrap_err()
            .to_string();
        assert!(error.contains("my.toml") && error.contains("did you mean global?"), "{error}");
        let error = Style::find("inc").unwrap_err().to_string();
        assert!(error.contains("did you mean ink?"), "{error}");
    }
}
