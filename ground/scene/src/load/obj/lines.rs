//! The lines of OBJ and MTL files.

use std::borrow::Cow;

/// Logical lines without white space around them: a `\` at the end of a line joins the next one,
/// but for comments, which may end in a path. Lines end in LF, CR LF or, in files without any LF,
/// in CR.
pub(in super::super) struct Lines<'a> {
    rest: Option<&'a [u8]>,
    end: u8,
    /// Lines so far.
    number: u64,
}

impl<'a> Lines<'a> {
    pub(in super::super) fn new(bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        let end = if bytes.contains(&b'\n') { b'\n' } else { b'\r' };
        Self { rest: Some(bytes), end, number: 0 }
    }

    fn physical(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        self.number += 1;
        match rest.iter().position(|b| *b == self.end) {
            Some(length) => {
                self.rest = Some(&rest[length + 1..]);
                Some(rest[..length].trim_ascii())
            }
            None => {
                self.rest = None;
                Some(rest.trim_ascii())
            }
        }
    }
}

impl<'a> Iterator for Lines<'a> {
    /// The number of the line's first part, from 1, and its text.
    type Item = (u64, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let line = self.physical()?;
        let number = self.number;
        let Some(start) = line.strip_suffix(b"\\").filter(|_| !line.starts_with(b"#")) else {
            return Some((number, line.into()));
        };
        let mut joined = start.to_vec();
        while let Some(line) = self.physical() {
            joined.push(b' ');
            match line.strip_suffix(b"\\") {
                Some(part) => joined.extend(part),
                None => {
                    joined.extend(line);
                    break;
                }
            }
        }
        Some((number, joined.into()))
    }
}

/// A line up to its comment: a `#` at its start or after white space, for names may hold one.
pub(in super::super) fn without_comment(line: &[u8]) -> &[u8] {
    let starts = |i: &usize| line[*i] == b'#' && (*i == 0 || line[*i - 1].is_ascii_whitespace());
    (0..line.len()).find(starts).map_or(line, |i| line[..i].trim_ascii_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<(u64, String)> {
        let read = Lines::new(text.as_bytes());
        read.map(|(n, line)| (n, String::from_utf8(line.into_owned()).unwrap())).collect()
    }

    #[test]
    fn lines_are_joined_and_numbered() {
        let text = "\u{feff}a\r\n b \\\r\nc\\\nd\n# x\\\ne";
        let expected =
            [(1, "a"), (2, "b  c d"), (5, "# x\\"), (6, "e")].map(|(n, t)| (n, t.to_owned()));
        assert_eq!(lines(text), expected);
        assert_eq!(lines("a\rb").len(), 2);
        assert_eq!(lines("a\\"), [(1, "a".to_owned())]);
    }

    #[test]
    fn names_may_hold_a_hash() {
        assert_eq!(without_comment(b"usemtl a#1 # red"), b"usemtl a#1");
        assert_eq!(without_comment(b"# all"), b"");
    }
}
