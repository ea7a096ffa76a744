//! Named styles: sets of knobs as editable TOML.
//!
//! A style file has a one-line `description` and a table `[binary]` of knobs; knobs that it does
//! not name keep their defaults.

use chiaro_basis::{Error, Knobs, Result, Value, nearest};
use chiaro_binary::BinaryKnobs;
use std::path::Path;

/// A named style.
#[derive(Clone, Debug)]
pub struct Style {
    /// Its name.
    pub name: String,
    /// What it looks like, in one line.
    pub description: String,
    /// Its knobs.
    pub binary: BinaryKnobs,
}

/// The styles that ship with the program: name and text.
pub const BUILT_IN: [(&str, &str); 12] = [
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
];

impl Style {
    /// The style called `name`, or the one in the file of that name.
    pub fn find(name: &str) -> Result<Self> {
        if let Some((name, text)) = BUILT_IN.iter().find(|(n, _)| *n == name) {
            return Self::parse(name, text);
        }
        if name.ends_with(".toml") || Path::new(name).is_file() {
            let bytes = crate::disk::read(Path::new(name))?;
            let text = String::from_utf8(bytes)
                .map_err(|_| Error::input(name, "", "is no text; name a TOML file"))?;
            return Self::parse(name, &text);
        }
        let names = BUILT_IN.map(|(n, _)| n);
        let hint = nearest(name, names).map(|n| format!("; did you mean {n}?")).unwrap_or_default();
        let range = format!("one of {}, or a TOML file{hint}", names.join(", "));
        Err(Error::setting("--style", name, range))
    }

    /// All styles that ship with the program.
    pub fn all() -> Result<Vec<Self>> {
        BUILT_IN.iter().map(|(name, text)| Self::parse(name, text)).collect()
    }

    fn parse(name: &str, text: &str) -> Result<Self> {
        let table: toml::Table = text.parse().map_err(|e: toml::de::Error| {
            let line =
                e.span().map_or(1, |s| text[..s.start.min(text.len())].matches('\n').count() + 1);
            Error::input(name, format!("line {line}"), e.message().to_string())
        })?;
        let mut style =
            Self { name: name.into(), description: String::new(), binary: BinaryKnobs::default() };
        for (key, value) in &table {
            match (key.as_str(), value) {
                ("description", toml::Value::String(s)) => style.description = s.clone(),
                ("binary", toml::Value::Table(knobs)) => set_all(&mut style.binary, name, knobs)?,
                _ => {
                    let why =
                        "is not part of a style; a style has a description and a table [binary]";
                    return Err(Error::input(name, key, why));
                }
            }
        }
        Ok(style)
    }

    /// The whole style as TOML, every knob with its help.
    pub fn to_toml(&self) -> String {
        let mut text = format!("description = {:?}\n\n[binary]\n", self.description);
        for (knob, value) in self.binary.values() {
            let value = match value {
                Value::Word(word) => format!("{word:?}"),
                other => other.to_string(),
            };
            let unit =
                if knob.unit.is_empty() { String::new() } else { format!(" [{}]", knob.unit) };
            let symbol =
                if knob.symbol.is_empty() { String::new() } else { format!(" {}", knob.symbol) };
            text += &format!("{} = {value} # {}{unit}{symbol}\n", knob.name, knob.help);
        }
        text
    }
}

fn set_all(knobs: &mut BinaryKnobs, file: &str, table: &toml::Table) -> Result<()> {
    for (key, value) in table {
        let text = match value {
            toml::Value::String(s) => s.clone(),
            other => other.to_string(),
        };
        knobs
            .set(key, &text)
            .map_err(|e| Error::input(file, format!("[binary] {key}"), e.to_string()))?;
    }
    Ok(())
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
            let again = Style::parse(&style.name, &style.to_toml()).unwrap();
            assert_eq!(again.binary, style.binary, "{}", style.name);
            assert!(!style.description.is_empty());
        }
    }

    #[test]
    fn styles_differ_in_more_than_two_knobs() {
        let styles = Style::all().unwrap();
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
        let error = Style::parse("my.toml", "[binary]\nglobul = 0.3").unwrap_err().to_string();
        assert!(error.contains("my.toml") && error.contains("did you mean global?"), "{error}");
        let error = Style::find("inc").unwrap_err().to_string();
        assert!(error.contains("did you mean ink?"), "{error}");
    }
}
