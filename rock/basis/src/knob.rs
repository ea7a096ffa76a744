//! Knobs: a chapter's parameters in one table.
//!
//! [`knobs!`](crate::knobs) declares a plain struct and, beside it, the table that command line,
//! style files, sliders and the manual read. There is no second list.

use crate::{Error, Result};
use std::fmt;

/// What a knob takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KnobKind {
    /// A number between two ends, both included.
    Number {
        /// The smallest value.
        min: f64,
        /// The largest value.
        max: f64,
    },
    /// A whole number between two ends, both included.
    Count {
        /// The smallest value.
        min: i64,
        /// The largest value.
        max: i64,
    },
    /// Yes or no.
    Switch,
    /// One of a few words.
    Choice(&'static [&'static str]),
    /// Any text, which its user reads further.
    Text,
}

/// One row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Knob {
    /// The name in `--set`, in style files and in the struct.
    pub name: &'static str,
    /// The thesis's symbol and equation, or empty.
    pub symbol: &'static str,
    /// The unit ("px at 480", "rad/px"), or empty.
    pub unit: &'static str,
    /// What it takes.
    pub kind: KnobKind,
    /// One line of help.
    pub help: &'static str,
}

/// A knob's value, as read from or written to text.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// A whole number.
    Count(i64),
    /// Yes or no.
    Switch(bool),
    /// A word.
    Word(String),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(x) => write!(f, "{x}"),
            Self::Count(n) => write!(f, "{n}"),
            Self::Switch(b) => write!(f, "{b}"),
            Self::Word(w) => f.write_str(w),
        }
    }
}

impl Knob {
    /// What it accepts, in words.
    pub fn range(&self) -> String {
        match self.kind {
            KnobKind::Number { min, max } => format!("a number from {min} to {max}"),
            KnobKind::Count { min, max } => format!("a whole number from {min} to {max}"),
            KnobKind::Switch => "true or false".into(),
            KnobKind::Choice(words) => format!("one of {}", words.join(", ")),
            KnobKind::Text => "a text".into(),
        }
    }

    /// Reads `text` as this knob's value; [`Error::Setting`] when it does not fit.
    pub fn parse(&self, text: &str) -> Result<Value> {
        let text = text.trim();
        let value = match self.kind {
            KnobKind::Number { min, max } => {
                text.parse::<f64>().ok().filter(|x| (min..=max).contains(x)).map(Value::Number)
            }
            KnobKind::Count { min, max } => {
                text.parse::<i64>().ok().filter(|n| (min..=max).contains(n)).map(Value::Count)
            }
            KnobKind::Switch => match text {
                "true" | "yes" | "on" | "1" => Some(Value::Switch(true)),
                "false" | "no" | "off" | "0" => Some(Value::Switch(false)),
                _ => None,
            },
            KnobKind::Choice(words) => {
                words.iter().find(|w| **w == text).map(|w| Value::Word((*w).into()))
            }
            KnobKind::Text => Some(Value::Word(text.into())),
        };
        value.ok_or_else(|| Error::setting(self.name, text, self.range()))
    }
}

/// A struct of knobs with its table.
pub trait Knobs: Default {
    /// The rows, in the order of the struct.
    fn table() -> &'static [Knob];
    /// The value of the knob in row `row`.
    fn value(&self, row: usize) -> Value;
    /// Sets the knob in row `row`; the value must fit its kind.
    fn assign(&mut self, row: usize, value: Value);

    /// Sets the knob `name` from text; [`Error::Setting`] when the name or the value is unknown.
    fn set(&mut self, name: &str, text: &str) -> Result<()> {
        let row = Self::table().iter().position(|k| k.name == name);
        let row = row.ok_or_else(|| Error::setting(name, text, unknown::<Self>(name)))?;
        let value = Self::table()[row].parse(text)?;
        self.assign(row, value);
        Ok(())
    }

    /// All knobs with their values, in the order of the table.
    fn values(&self) -> Vec<(&'static Knob, Value)> {
        Self::table().iter().enumerate().map(|(row, knob)| (knob, self.value(row))).collect()
    }
}

fn unknown<K: Knobs>(name: &str) -> String {
    let names = K::table().iter().map(|k| k.name);
    match nearest(name, names) {
        Some(near) => format!("a known knob; did you mean {near}?"),
        None => "a known knob".into(),
    }
}

/// The name most like `word`, if one is near enough to be a slip of the hand.
pub fn nearest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    names
        .into_iter()
        .map(|n| (edits(word, n), n))
        .filter(|(d, n)| *d <= 1 + n.chars().count().min(word.chars().count()) / 3)
        .min_by_key(|(d, _)| *d)
        .map(|(_, n)| n)
}

/// Levenshtein's distance between two words.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let change = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// How a Rust type is a knob's value. Implemented for `f32`, `f64`, `u32`, `bool`, and by the words
/// of a choice.
pub trait KnobValue: Clone {
    /// To a [`Value`].
    fn to_value(&self) -> Value;
    /// From a [`Value`] that fits; other kinds leave the default.
    fn from_value(value: &Value) -> Option<Self>;
}

impl KnobValue for f32 {
    fn to_value(&self) -> Value {
        // Through the shortest text, so that 0.35f32 shows as 0.35.
        Value::Number(self.to_string().parse().unwrap_or(f64::from(*self)))
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Number(x) => Some(*x as f32),
            Value::Count(n) => Some(*n as f32),
            _ => None,
        }
    }
}

impl KnobValue for u32 {
    fn to_value(&self) -> Value {
        Value::Count(i64::from(*self))
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Count(n) => u32::try_from(*n).ok(),
            _ => None,
        }
    }
}

impl KnobValue for bool {
    fn to_value(&self) -> Value {
        Value::Switch(*self)
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Switch(b) => Some(*b),
            _ => None,
        }
    }
}

impl KnobValue for String {
    fn to_value(&self) -> Value {
        Value::Word(self.clone())
    }
    fn from_value(value: &Value) -> Option<Self> {
        match value {
            Value::Word(word) => Some(word.clone()),
            _ => None,
        }
    }
}

/// Declares an enum whose variants are the words of a choice knob.
///
/// ```
/// chiaro_basis::choice! {
///     /// What a line is drawn against.
///     pub enum Contrast { #[default] Both = "both", White = "white" }
/// }
/// assert_eq!(Contrast::WORDS, ["both", "white"]);
/// ```
#[macro_export]
macro_rules! choice {
    ($(#[$doc:meta])* $vis:vis enum $name:ident {
        $($(#[$vdoc:meta])* $variant:ident = $word:literal),+ $(,)?
    }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
        #[allow(missing_docs, reason = "the words say themselves, and the knob's help the rest")]
        $vis enum $name { $($(#[$vdoc])* $variant),+ }

        impl $name {
            /// The words, in the order of the variants.
            #[allow(unreachable_pub, reason = "the enum itself may be private")]
            pub const WORDS: &'static [&'static str] = &[$($word),+];
        }

        impl $crate::KnobValue for $name {
            fn to_value(&self) -> $crate::Value {
                $crate::Value::Word(match self { $(Self::$variant => $word),+ }.into())
            }
            fn from_value(value: &$crate::Value) -> Option<Self> {
                match value {
                    $($crate::Value::Word(w) if w == $word => Some(Self::$variant),)+
                    _ => None,
                }
            }
        }
    };
}

/// Declares a struct of knobs and its table.
///
/// Each row reads `name: type = default, kind, "symbol", "unit", "help";`.
///
/// ```
/// use chiaro_basis::{Knobs, knobs};
/// knobs! {
///     /// How a cut is weighed.
///     pub struct Example {
///         global: f32 = 0.35, Number { min: 0.0, max: 1.0 }, "g (3.5)", "", "global against local tone";
///     }
/// }
/// let mut e = Example::default();
/// e.set("global", "0.5").unwrap();
/// assert_eq!(e.global, 0.5);
/// assert!(e.set("globul", "0.5").unwrap_err().to_string().contains("did you mean global?"));
/// ```
#[macro_export]
macro_rules! knobs {
    ($(#[$doc:meta])* $vis:vis struct $name:ident {
        $($field:ident : $ty:ty = $default:expr, $kind:ident $({ $($k:ident : $v:expr),* })? $(($words:expr))?,
          $symbol:literal, $unit:literal, $help:literal;)+
    }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        $vis struct $name {
            $(#[doc = concat!($help, " [", $unit, "] ", $symbol)] pub $field: $ty,)+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),+ }
            }
        }

        impl $crate::Knobs for $name {
            fn table() -> &'static [$crate::Knob] {
                const TABLE: &[$crate::Knob] = &[$($crate::Knob {
                    name: stringify!($field),
                    symbol: $symbol,
                    unit: $unit,
                    kind: $crate::KnobKind::$kind $({ $($k: $v),* })? $(($words))?,
                    help: $help,
                }),+];
                TABLE
            }

            fn value(&self, row: usize) -> $crate::Value {
                let mut at = 0..;
                $(if at.next() == Some(row) {
                    return $crate::KnobValue::to_value(&self.$field);
                })+
                unreachable!("row {row} is past the table")
            }

            fn assign(&mut self, row: usize, value: $crate::Value) {
                let mut at = 0..;
                $(if at.next() == Some(row) {
                    if let Some(v) = $crate::KnobValue::from_value(&value) { self.$field = v; }
                    return;
                })+
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    crate::choice! {
        /// A choice.
        enum Side { #[default] Left = "left", Right = "right" }
    }

    knobs! {
        /// A table of every kind.
        struct Every {
            number: f32 = 0.35, Number { min: 0.0, max: 1.0 }, "g (3.5)", "", "a number";
            count: u32 = 3, Count { min: 0, max: 9 }, "", "px", "a count";
            switch: bool = true, Switch, "", "", "a switch";
            side: Side = Side::Left, Choice(Side::WORDS), "", "", "a side";
        }
    }

    #[test]
    fn every_knob_survives_its_own_text() {
        let mut a = Every::default();
        for (name, text) in
            [("number", "0.25"), ("count", "7"), ("switch", "off"), ("side", "right")]
        {
            a.set(name, text).expect("these fit");
        }
        let mut b = Every::default();
        for (knob, value) in a.values() {
            b.set(knob.name, &value.to_string()).expect("a value reads back");
        }
        assert_eq!(a, b);
        assert_eq!(a.side, Side::Right);
    }

    #[test]
    fn a_value_out_of_range_names_the_range() {
        let error = Every::default().set("number", "2").expect_err("2 > 1");
        assert_eq!(error.to_string(), "number = 2: expected a number from 0 to 1");
        assert!(Every::default().set("number", "NaN").is_err());
    }

    #[test]
    fn a_slip_is_answered_with_the_nearest_name() {
        let error = Every::default().set("swich", "on").expect_err("no such knob");
        assert!(error.to_string().contains("did you mean switch?"), "{error}");
        assert_eq!(nearest("zzzzzz", ["number", "count"]), None);
    }
}
