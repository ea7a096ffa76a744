//! [`LineStyle`]: what lines look like: which are drawn, with what brush, by line type and object.
//!
//! A style file has a table `[lines]` of the knobs of lines, a table `[stroke]` of the brush that
//! draws them all, tables such as `[stroke.crease]` and `[stroke.hidden]` with what is different for
//! a line type or for hidden lines, and any number of `[[rule]]` for lines of certain objects,
//! materials or types; later ones win.

use super::ready::Names;
use crate::disk;
use crate::pattern::matches;
use crate::style::in_file;
use crate::write;
use chiaro_basis::{Error, Knobs, Result, nearest};
use chiaro_image::codec::{self, Limits};
use chiaro_image::colour::parse_colour;
use chiaro_ink::brush::{Brush, Grain, Mark, Texture};
use chiaro_lines::{Hidden, Kind, LinesKnobs};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a style file says at its end to whoever edits it.
const HINT: &str = "
# What is different for a type of line goes into [stroke.crease], [stroke.border] and so on, for hidden
# lines (--hidden style) into [stroke.hidden]. What is different for some objects goes into rules:
# [[rule]]
# object = \"hat*\"        # the name of a node; material = and type = narrow it further
# width = 5
";

/// What lines look like.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineStyle {
    /// Which lines there are.
    pub knobs: LinesKnobs,
    /// What draws them.
    pub brush: Brush,
    /// What is different for some, later ones winning.
    rules: Vec<Rule>,
    /// Pictures of strokes by the names that brushes have for them.
    textures: BTreeMap<String, Arc<Loaded>>,
}

/// A brush's picture, its file and the hash of that.
#[derive(Clone, Debug, PartialEq)]
struct Loaded {
    texture: Texture,
    path: PathBuf,
    sha256: String,
}

/// What is different for some lines.
#[derive(Clone, Debug, Default, PartialEq)]
struct Rule {
    kind: Option<Kind>,
    hidden: bool,
    object: Option<String>,
    material: Option<String>,
    sets: Vec<(String, String)>,
}

/// A line, as rules see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Subject<'a> {
    pub(crate) kind: Kind,
    pub(crate) visible: bool,
    pub(crate) object: &'a str,
    pub(crate) material: &'a str,
}

impl LineStyle {
    /// Reads the table `[lines]`.
    pub(crate) fn read_knobs(&mut self, file: &str, table: &toml::Table) -> Result<()> {
        for (key, value) in table {
            let fail = |e: Error| in_file(file, "[lines]", key, e);
            self.knobs.set(key, &text_of(value)).map_err(fail)?;
        }
        Ok(())
    }

    /// Reads the table `[stroke]` and those within.
    pub(crate) fn read_stroke(&mut self, file: &str, table: &toml::Table) -> Result<()> {
        // Hidden lines of every type come last.
        let (hidden, others): (Vec<_>, Vec<_>) =
            table.iter().partition(|(key, _)| *key == "hidden");
        for (key, value) in others.into_iter().chain(hidden) {
            match value {
                toml::Value::Table(inner) => {
                    let place = format!("[stroke.{key}]");
                    let mut rule = Self::rule_for(key)
                        .ok_or_else(|| Error::input(file, &place, no_type(key)))?;
                    rule.read(file, &place, inner)?;
                    self.rules.push(rule);
                }
                _ => set_brush(&mut self.brush, file, "[stroke]", (key, value))?,
            }
        }
        Ok(())
    }

    /// Reads the tables `[[rule]]`.
    pub(crate) fn read_rules(&mut self, file: &str, rules: &[toml::Value]) -> Result<()> {
        for (i, value) in rules.iter().enumerate() {
            let place = format!("[[rule]] {}", i + 1);
            let toml::Value::Table(table) = value else {
                return Err(Error::input(file, place, "is no table; write [[rule]] above it"));
            };
            let mut rule = Rule::default();
            let mut rest = toml::Table::new();
            for (key, value) in table {
                let text = text_of(value);
                match key.as_str() {
                    "type" if text == "hidden" => rule.hidden = true,
                    "type" => {
                        let kind = kind_of(&text);
                        rule.kind =
                            Some(kind.ok_or_else(|| Error::input(file, &place, no_type(&text)))?);
                    }
                    "object" => rule.object = Some(text),
                    "material" => rule.material = Some(text),
                    _ => drop(rest.insert(key.clone(), value.clone())),
                }
            }
            rule.read(file, &place, &rest)?;
            self.rules.push(rule);
        }
        Ok(())
    }

    /// A rule for a line type, or for hidden lines.
    fn rule_for(name: &str) -> Option<Rule> {
        match name {
            "hidden" => Some(Rule { hidden: true, ..Rule::default() }),
            _ => kind_of(name).map(|kind| Rule { kind: Some(kind), ..Rule::default() }),
        }
    }

    /// Loads the pictures that brushes name, beside the style's file.
    pub(crate) fn load_textures(&mut self, folder: &Path) -> Result<()> {
        let of_rules = self.rules.iter().flat_map(|r| &r.sets).filter(|(k, _)| k == "picture");
        let names = of_rules.map(|(_, v)| v.clone()).chain([self.brush.picture.clone()]);
        for name in names.filter(|n| !n.is_empty()).collect::<Vec<_>>() {
            self.load_texture(&folder.join(&name), name)?;
        }
        Ok(())
    }

    /// Loads a picture that brushes have a name for.
    fn load_texture(&mut self, path: &Path, name: String) -> Result<()> {
        let bytes = disk::read(path)?;
        let picture = codec::read_picture(&bytes, &path.display().to_string(), &Limits::default())?;
        let (texture, path, sha256) = (Texture::of(&picture), path.into(), write::sha256(&bytes));
        let loaded = Loaded { texture, path, sha256 };
        self.textures.insert(name, Arc::new(loaded));
        Ok(())
    }

    /// The files of the pictures that brushes have.
    pub(crate) fn picture_files(&self) -> impl Iterator<Item = PathBuf> + '_ {
        self.textures.values().map(|t| t.path.clone())
    }

    /// What rules ask for that no object and no material is called, in sentences.
    pub(crate) fn unmet(&self, names: &Names) -> Vec<String> {
        let rules = self.rules.iter().flat_map(|r| {
            let of_object = r.object.iter().map(|p| ("object", p, &names.objects));
            of_object.chain(r.material.iter().map(|p| ("material", p, &names.materials)))
        });
        let unmet = rules.filter(|(_, pattern, known)| !known.iter().any(|n| matches(pattern, n)));
        let sentence = |(what, pattern, known): (&str, &String, &Vec<String>)| {
            let named = known.iter().map(String::as_str).filter(|n| !n.is_empty());
            let near = nearest(pattern, named).map(|n| format!("; did you mean {n}?"));
            let near = near.unwrap_or_default();
            format!("[[rule]] {what} = {pattern}: no {what} of the scene is called so{near}")
        };
        unmet.map(sentence).collect()
    }

    /// Gives brushes a picture of a stroke under a name.
    pub(crate) fn add_texture(&mut self, name: &str, texture: Texture) {
        let loaded = Loaded { texture, path: PathBuf::new(), sha256: String::new() };
        self.textures.insert(name.into(), Arc::new(loaded));
    }

    /// Sets a knob of lines or of their brush, or, as in `crease.width`, of that for a line type or
    /// for hidden lines. A picture is read from where the program runs.
    pub fn set(&mut self, text: &str) -> Result<()> {
        let (key, value) = text
            .split_once('=')
            .ok_or_else(|| Error::setting("--set", text, "a knob and its value, as in width=3"))?;
        let (key, value) = (key.trim(), value.trim());
        if let Some((name, key)) = key.split_once('.') {
            let mut rule = Self::rule_for(name).ok_or_else(|| {
                let known = format!("a type of line before the point: {}", no_type(name));
                Error::setting("--set", text, known)
            })?;
            set_checked(&mut Brush::default(), key, value)?;
            if key == "picture" && !value.is_empty() {
                self.load_texture(Path::new(value), value.into())?;
            }
            rule.sets.push((key.into(), value.into()));
            self.rules.push(rule);
            return Ok(());
        }
        let names = |table: &'static [chiaro_basis::Knob]| table.iter().map(|k| k.name);
        if names(LinesKnobs::table()).any(|n| n == key) {
            return self.knobs.set(key, value);
        }
        if names(Brush::table()).any(|n| n == key) {
            if key == "picture" && !value.is_empty() {
                self.load_texture(Path::new(value), value.into())?;
            }
            return set_checked(&mut self.brush, key, value);
        }
        let near = nearest(key, names(LinesKnobs::table()).chain(names(Brush::table())));
        let hint = near.map(|n| format!("; did you mean {n}?")).unwrap_or_default();
        Err(Error::setting(key, value, format!("a known knob{hint}")))
    }

    /// Whether lines of different objects or materials may look different.
    pub(crate) fn minds_owners(&self) -> bool {
        let named = |r: &Rule| r.object.is_some() || r.material.is_some();
        let coloured = |r: &Rule| r.sets.iter().any(|(k, v)| k == "colour" && v == "object");
        self.brush.colour == "object" || self.rules.iter().any(|r| named(r) || coloured(r))
    }

    /// The brush for a line.
    pub(crate) fn brush_for(&self, subject: &Subject<'_>) -> Brush {
        let mut brush = self.brush.clone();
        if !subject.visible && self.knobs.hidden == Hidden::Dashed {
            let (mark, grain) = (Mark::Dashes, Grain::Solid);
            let (width, spacing) = (0.7 * brush.width.min(3.0), 10.0);
            brush = Brush {
                mark,
                grain,
                width,
                spacing,
                dash: 0.5,
                jitter: 0.0,
                taper: 0.0,
                repeat: 1,
                ..brush
            };
        }
        let own = self.knobs.hidden == Hidden::Style;
        for rule in self.rules.iter().filter(|r| r.holds(subject) && (own || !r.hidden)) {
            for (key, value) in &rule.sets {
                brush.set(key, value).expect("rules were checked as they were read");
            }
        }
        brush
    }

    /// The picture of a brush.
    pub(crate) fn texture(&self, brush: &Brush) -> Option<&Texture> {
        self.textures.get(&brush.picture).map(|t| &t.texture)
    }

    /// For recipes.
    pub(crate) fn settings(&self) -> Map<String, Value> {
        let mut s: Map<String, Value> = crate::record::knob_settings(&self.knobs).collect();
        s.insert("stroke".into(), brush_settings(&self.brush));
        s.insert("rules".into(), self.rules.iter().map(Rule::settings).collect());
        let hashes = self.textures.iter().map(|(name, t)| (name.clone(), t.sha256.clone().into()));
        s.insert("textures".into(), Value::Object(hashes.collect()));
        s
    }

    /// The tables of a style file.
    pub(crate) fn to_toml(&self) -> String {
        let mut text = String::from("\n[lines]\n");
        text += &crate::style::knob_lines(&self.knobs);
        text += "\n[stroke]\n";
        text += &crate::style::knob_lines(&self.brush);
        for rule in &self.rules {
            rule.write(&mut text);
        }
        text + HINT
    }
}

impl Rule {
    fn read(&mut self, file: &str, place: &str, table: &toml::Table) -> Result<()> {
        for (key, value) in table {
            set_brush(&mut Brush::default(), file, place, (key, value))?;
            self.sets.push((key.clone(), text_of(value)));
        }
        Ok(())
    }

    fn holds(&self, subject: &Subject<'_>) -> bool {
        let fits = |pattern: &Option<String>, name: &str| {
            pattern.as_deref().is_none_or(|p| matches(p, name))
        };
        self.kind.is_none_or(|k| k == subject.kind)
            && (!self.hidden || !subject.visible)
            && fits(&self.object, subject.object)
            && fits(&self.material, subject.material)
    }

    fn settings(&self) -> Value {
        json!({
            "type": self.kind.map(Kind::name), "hidden": self.hidden, "object": self.object,
            "material": self.material, "sets": self.sets,
        })
    }

    fn write(&self, text: &mut String) {
        let named = match (self.kind, self.hidden) {
            (Some(kind), _) => Some(kind.name()),
            (None, true) => Some("hidden"),
            (None, false) => None,
        };
        let of_type = self.object.is_none() && self.material.is_none();
        let heading = named.filter(|_| of_type).map(|name| format!("[stroke.{name}]"));
        let conditions = [
            ("type", named.filter(|_| heading.is_none())),
            ("object", self.object.as_deref()),
            ("material", self.material.as_deref()),
        ];
        let conditions = conditions.into_iter().filter_map(|(k, v)| Some((k, v?)));
        let sets = self.sets.iter().map(|(k, v)| (k.as_str(), v.as_str()));
        let _ = writeln!(text, "\n{}", heading.as_deref().unwrap_or("[[rule]]"));
        for (key, value) in conditions.chain(sets) {
            let plain = value.parse::<f64>().is_ok() || value.parse::<bool>().is_ok();
            let quoted = || toml::Value::String(value.into()).to_string();
            let _ = writeln!(text, "{key} = {}", if plain { value.into() } else { quoted() });
        }
    }
}

/// A brush, for recipes and documents.
pub(crate) fn brush_settings(brush: &Brush) -> Value {
    Value::Object(crate::record::knob_settings(brush).collect())
}

fn set_brush(
    brush: &mut Brush,
    file: &str,
    place: &str,
    (key, value): (&String, &toml::Value),
) -> Result<()> {
    let fail = |e: Error| in_file(file, place, key, e);
    set_checked(brush, key, &text_of(value)).map_err(fail)
}

/// Sets a knob of a brush; colours must be known.
fn set_checked(brush: &mut Brush, key: &str, value: &str) -> Result<()> {
    if key == "colour" && !["ink", "paper", "object", "id"].contains(&value) {
        let known = |e: Error| match e {
            Error::Setting { range, .. } => {
                Error::setting(key, value, format!("ink, paper, object, id, or {range}"))
            }
            other => other,
        };
        parse_colour(value).map_err(known)?;
    }
    brush.set(key, value)
}

fn text_of(value: &toml::Value) -> String {
    match value {
        toml::Value::String(s) => s.clone(),
        other => other.to_string(),
    }
}

fn kind_of(name: &str) -> Option<Kind> {
    Kind::ALL.into_iter().find(|k| k.name() == name)
}

fn no_type(name: &str) -> String {
    let known = Kind::ALL.map(Kind::name).into_iter().chain(["hidden"]);
    let hint = nearest(name, known.clone()).map(|n| format!("; did you mean {n}?"));
    let known: Vec<&str> = known.collect();
    format!("{name} is no type of line: one of {}{}", known.join(", "), hint.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn style(text: &str) -> Result<LineStyle> {
        let table: toml::Table = text.parse().unwrap();
        let mut style = LineStyle::default();
        if let Some(toml::Value::Table(stroke)) = table.get("stroke") {
            style.read_stroke("a.toml", stroke)?;
        }
        if let Some(toml::Value::Array(rules)) = table.get("rule") {
            style.read_rules("a.toml", rules)?;
        }
        style.knobs.hidden = Hidden::Style;
        Ok(style)
    }

    #[test]
    fn rules_hold_by_type_object_and_material() {
        let style = style(
            "[stroke]\nwidth = 3\n[stroke.crease]\nwidth = 1\n[stroke.hidden]\nmark = \"dots\"\n\
             [[rule]]\nobject = \"hat*\"\ntype = \"crease\"\nwidth = 7\n\
             [[rule]]\nmaterial = \"*wool\"\nmark = \"fur\"\n",
        )
        .unwrap();
        let brush = |kind, visible, object, material| {
            style.brush_for(&Subject { kind, visible, object, material })
        };
        assert_eq!(brush(Kind::Silhouette, true, "Hat 1", "felt").width, 3.0);
        assert_eq!(brush(Kind::Crease, true, "cup", "felt").width, 1.0);
        assert_eq!(brush(Kind::Crease, true, "Hat 1", "felt").width, 7.0);
        assert_eq!(brush(Kind::Crease, false, "cup", "felt").mark, Mark::Dots);
        assert_eq!(brush(Kind::Border, true, "cup", "red wool").mark, Mark::Fur);
    }

    #[test]
    fn no_knob_of_brushes_is_one_of_lines() {
        for knob in Brush::table() {
            assert!(LinesKnobs::table().iter().all(|k| k.name != knob.name), "{}", knob.name);
        }
    }

    #[test]
    fn wrong_tables_name_file_place_and_remedy() {
        let error = style("[stroke.crese]\nwidth = 1").unwrap_err().to_string();
        assert!(error.contains("a.toml") && error.contains("did you mean crease?"), "{error}");
        let error = style("[stroke.crease]\nwidht = 1").unwrap_err().to_string();
        assert!(
            error.contains("[stroke.crease]") && error.contains("did you mean width?"),
            "{error}"
        );
        let error = LineStyle::default().set("presure=1").unwrap_err().to_string();
        assert!(error.contains("did you mean pressure?"), "{error}");
        for text in ["colour=purplish", "crease.colour=#12"] {
            let error = LineStyle::default().set(text).unwrap_err().to_string();
            assert!(error.contains("ink, paper, object, id"), "{error}");
        }
        let error = style("[stroke]\ncolour = \"purplish\"").unwrap_err().to_string();
        assert!(error.contains("a.toml") && error.contains("purplish"), "{error}");
        let mut good = LineStyle::default();
        ["colour=id", "colour=navy", "hidden.colour=#22336680"]
            .into_iter()
            .for_each(|text| good.set(text).unwrap());
    }

    #[test]
    fn a_wrong_value_in_a_file_is_told_once_and_in_its_place() {
        let error = style("[stroke.crease]\ncap = \"butt\"").unwrap_err().to_string();
        assert!(
            error.ends_with("[stroke.crease] cap = butt: expected one of round, flat"),
            "{error}"
        );
    }

    #[test]
    fn rules_for_nothing_that_is_there_are_told() {
        let names = Names {
            objects: vec!["Hat".into(), "Head".into()],
            materials: vec!["Felt".into()],
            ..Names::default()
        };
        let rules = "[[rule]]\nobject = \"ha*\"\nwidth = 3\n[[rule]]\nobject = \"Heat\"\n\
                     material = \"felt\"\nwidth = 2\n[[rule]]\nmaterial = \"Silk\"\nwidth = 2";
        let unmet = style(rules).unwrap().unmet(&names);
        assert_eq!(unmet.len(), 2, "{unmet:?}");
        assert!(
            unmet[0].contains("object = Heat") && unmet[0].contains("did you mean"),
            "{unmet:?}"
        );
        assert!(unmet[1].contains("material = Silk"), "{unmet:?}");
    }

    #[test]
    fn a_picture_that_a_setting_names_is_read() {
        let file = tempfile::Builder::new().suffix(".png").tempfile().unwrap();
        let mut style = LineStyle::default();
        let set = format!("picture={}", file.path().display());
        assert!(style.set(&set).is_err());
        let stroke = chiaro_image::Plane::from_fn(8, 4, |x, _| 30 * x as u8);
        std::fs::write(file.path(), codec::write_png_grey(&stroke, None).unwrap()).unwrap();
        style.set(&set).unwrap();
        assert!(style.texture(&style.brush).is_some());
    }
}
