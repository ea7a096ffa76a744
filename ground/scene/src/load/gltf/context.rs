//! [`Context`]: what all steps of reading share: the door, the memory left, and notes for the user.

use crate::load::{Budget, Door};
use chiaro_basis::{Error, Result};
use std::collections::BTreeMap;
use std::fmt;

/// A file may have as many bytes decoded from it as it has itself, times this. Formats unpack to
/// at most some six times their size; the rest is for parts that share their vertices.
const STRETCH: u64 = 64;

/// What any file may use on top, so that small files may draw one thing many times.
const SLACK: u64 = 256 << 20;

/// No more different notes than these are kept.
const MOST_NOTES: usize = 200;

/// Where in the file something is: `mesh 2 primitive 0`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    kind: &'static str,
    index: usize,
    part: Option<(&'static str, usize)>,
}

impl Place {
    pub(super) fn new(kind: &'static str, index: usize) -> Self {
        Self { kind, index, part: None }
    }

    /// The `index`-th `kind` of this place.
    pub(super) fn part(self, kind: &'static str, index: usize) -> Self {
        Self { part: Some((kind, index)), ..self }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.kind, self.index)?;
        self.part.map_or(Ok(()), |(kind, index)| write!(f, " {kind} {index}"))
    }
}

/// What all steps of reading share.
pub(super) struct Context<'c, 'd> {
    pub(super) door: &'c mut Door<'d>,
    /// Bytes that may still be decoded.
    room: u64,
    /// What to tell: in which order it came up, where first, and how often.
    notes: BTreeMap<String, (usize, Option<Place>, u64)>,
    /// Notes beyond [`MOST_NOTES`].
    untold: u64,
    /// Files that the scene names and that are not there.
    pub(super) missing: Vec<String>,
}

impl<'c, 'd> Context<'c, 'd> {
    pub(super) fn new(door: &'c mut Door<'d>) -> Self {
        Self { door, room: SLACK, notes: BTreeMap::new(), untold: 0, missing: Vec::new() }
    }

    /// Makes room for what `bytes` bytes of file may unpack to.
    pub(super) fn has_read(&mut self, bytes: usize) {
        self.room = self.room.saturating_add((bytes as u64).saturating_mul(STRETCH));
    }

    /// Takes room for `count` values of type `T`, before they are decoded.
    pub(super) fn hold<T>(&mut self, place: Place, count: usize) -> Result<()> {
        let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
        match self.room.checked_sub(bytes) {
            Some(rest) => {
                self.room = rest;
                Ok(())
            }
            None => {
                let what =
                    format!("{}: {place} unpacks to far more than the file; it", self.door.name);
                let have = format!("{} bytes; join or simplify what is repeated", self.room);
                Err(Error::limit(what, format!("{bytes} bytes"), have))
            }
        }
    }

    pub(super) fn spend(
        &mut self,
        what: &str,
        line: impl Fn(&mut Budget) -> &mut u64,
        count: usize,
    ) -> Result<()> {
        self.door.spend(what, line, count as u64)
    }

    /// An error about a place of the file; every such error has one remedy.
    pub(super) fn wrong(&self, place: Place, why: impl fmt::Display) -> Error {
        self.door.error(place.to_string(), format!("{why}; export the scene again"))
    }

    /// Tells the user about a place; what is said of several places is told once.
    pub(super) fn note(&mut self, place: Place, what: impl Into<String>) {
        self.tell(Some(place), what.into());
    }

    /// Tells the user something about the whole file.
    pub(super) fn remark(&mut self, what: impl Into<String>) {
        self.tell(None, what.into());
    }

    fn tell(&mut self, place: Option<Place>, what: String) {
        let order = self.notes.len();
        if let Some((_, _, count)) = self.notes.get_mut(&what) {
            *count += 1;
        } else if order < MOST_NOTES {
            self.notes.insert(what, (order, place, 1));
        } else {
            self.untold += 1;
        }
    }

    /// The notes, in the order in which they came up.
    pub(super) fn into_warnings(self) -> (Vec<String>, Vec<String>) {
        let mut notes: Vec<_> = self.notes.into_iter().collect();
        notes.sort_by_key(|(_, (order, ..))| *order);
        let line = |(what, (_, place, count)): (String, (usize, Option<Place>, u64))| match place {
            None => what,
            Some(place) if count == 1 => format!("{place}: {what}"),
            Some(place) => format!("{place} and {} more: {what}", count - 1),
        };
        let mut warnings: Vec<String> = notes.into_iter().map(line).collect();
        if self.untold > 0 {
            warnings.push(format!("and {} warnings more", self.untold));
        }
        (warnings, self.missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_come_in_order_and_repeats_are_counted() {
        let mut door = Door::new("a.glb", &(), Budget::default());
        let mut cx = Context::new(&mut door);
        cx.note(Place::new("mesh", 2).part("primitive", 1), "b");
        cx.remark("a");
        cx.note(Place::new("mesh", 5), "b");
        assert_eq!(cx.into_warnings().0, ["mesh 2 primitive 1 and 1 more: b", "a"]);
    }

    #[test]
    fn hostile_files_do_not_fill_the_screen() {
        let mut door = Door::new("a.glb", &(), Budget::default());
        let mut cx = Context::new(&mut door);
        (0..300).for_each(|i| cx.remark(format!("note {i}")));
        let (warnings, _) = cx.into_warnings();
        assert_eq!(warnings.len(), 201);
        assert_eq!(warnings[200], "and 100 warnings more");
    }

    #[test]
    fn room_grows_with_the_file_and_ends() {
        let mut door = Door::new("a.glb", &(), Budget::default());
        let mut cx = Context::new(&mut door);
        let place = Place::new("accessor", 3);
        cx.has_read(1 << 20);
        assert!(cx.hold::<u64>(place, 40 << 20).is_ok());
        let why = cx.hold::<u64>(place, usize::MAX).unwrap_err().to_string();
        assert!(why.contains("accessor 3"), "{why}");
    }
}
