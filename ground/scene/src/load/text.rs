//! Words and numbers of text formats, from bytes that need not be text.

/// The words of some bytes, separated by white space.
pub(super) fn words(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    bytes.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// A word as a number; NaN for what is none, as for the `1.#IND` of old C libraries.
pub(super) fn number(word: &[u8]) -> f32 {
    parse(word).unwrap_or(f32::NAN)
}

/// A word as any value that reads itself from text.
pub(super) fn parse<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Bytes as text, without white space around it; what is not UTF-8 is replaced.
pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.trim_ascii()).into_owned()
}

/// The file's name without folders and ending: what to call a thing whose file has no name for it.
pub(super) fn stem(name: &str) -> &str {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    file.rsplit_once('.').map_or(file, |(stem, _)| stem)
}

/// Counts what a reader leaves out, and keeps where it met the first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    /// How many.
    pub(super) count: u64,
    /// The line or row of the first, from 1.
    pub(super) first: u64,
}

impl Tally {
    /// One more, at this line or row.
    pub(super) fn note(&mut self, place: u64) {
        if self.count == 0 {
            self.first = place;
        }
        self.count += 1;
    }

    /// The warning "`file`: `count` `what`, the first in `unit` `first`, ..." if there are any.
    pub(super) fn warn(&self, file: &str, what: &str, unit: &str) -> Option<String> {
        let Self { count, first } = self;
        (*count > 0).then(|| format!("{file}: {count} {what} (the first in {unit} {first})"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_exporters_write_them() {
        let read = |text: &str| number(text.as_bytes());
        assert_eq!([read(".8e-001"), read("-5."), read("+2"), read("1E3")], [0.08, -5.0, 2.0, 1e3]);
        assert!(["1.#IND", "-nan", "x", "", "1,5", "\u{663}"].iter().all(|t| read(t).is_nan()));
        assert!(number(b"\xFF").is_nan());
    }

    #[test]
    fn names_come_from_files() {
        assert_eq!(stem("a/b.c/Bunny.v2.PLY"), "Bunny.v2");
        assert_eq!(stem("plain"), "plain");
    }
}
