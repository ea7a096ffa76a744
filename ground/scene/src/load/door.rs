//! The one door for untrusted bytes.
//!
//! Every byte that a reader sees comes through a [`Door`]: it keeps the books of the [`Budget`] and
//! turns the URIs of a scene file into relative paths that cannot leave the scene's folder. The
//! door itself opens nothing: a [`Source`] does, so that readers work on memory as well as on disk.

use chiaro_basis::{Error, Result};

/// Something that has the files beside a scene.
pub trait Source {
    /// The bytes of the file at `path`, relative to the scene's folder, with forward slashes and
    /// without `..`; at most `limit` bytes. [`Error::Input`] when it is missing, unreadable or
    /// resolves to a place outside the folder.
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>>;
}

/// A source without files, for scenes that need none.
impl Source for () {
    fn read(&self, path: &str, _: u64) -> Result<Vec<u8>> {
        Err(Error::input(path, "", "not found: this scene comes without a folder"))
    }
}

/// What a scene may cost, whatever its file claims.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Bytes read, over all files.
    pub bytes: u64,
    /// Vertices, over all meshes, morph targets counted.
    pub vertices: u64,
    /// Triangles as stored.
    pub triangles: u64,
    /// Triangles as drawn, instances counted.
    pub instances: u64,
    /// Nodes.
    pub nodes: u64,
    /// Pixels of all pictures.
    pub pixels: u64,
    /// Depth of nesting (JSON, node graphs).
    pub depth: u64,
}

impl Default for Budget {
    fn default() -> Self {
        Self {
            bytes: 8 << 30,
            vertices: 200_000_000,
            triangles: 200_000_000,
            instances: 10_000_000,
            nodes: 2_000_000,
            pixels: 512 << 20,
            depth: 128,
        }
    }
}

/// The door: a source, a budget, and what is left of it.
pub struct Door<'a> {
    source: &'a dyn Source,
    /// What is left.
    pub left: Budget,
    /// The scene file's name, for error messages.
    pub name: String,
}

impl<'a> Door<'a> {
    /// A door for the scene file called `name`.
    pub fn new(name: impl Into<String>, source: &'a dyn Source, budget: Budget) -> Self {
        Self { source, left: budget, name: name.into() }
    }

    /// An [`Error::Input`] about the scene file.
    pub fn error(&self, place: impl Into<String>, why: impl Into<String>) -> Error {
        Error::input(&self.name, place, why)
    }

    /// Takes `count` from one line of the budget; [`Error::Limit`] when there is not enough.
    ///
    /// ```
    /// # use chiaro_scene::load::{Budget, Door};
    /// let mut door = Door::new("a.glb", &(), Budget { vertices: 10, ..Budget::default() });
    /// assert!(door.spend("vertices", |b| &mut b.vertices, 8).is_ok());
    /// assert!(door.spend("vertices", |b| &mut b.vertices, 8).is_err());
    /// ```
    pub fn spend(
        &mut self,
        what: &str,
        line: impl Fn(&mut Budget) -> &mut u64,
        count: u64,
    ) -> Result<()> {
        let left = line(&mut self.left);
        match left.checked_sub(count) {
            Some(rest) => {
                *left = rest;
                Ok(())
            }
            None => Err(Error::limit(
                format!("{}: its {what}", self.name),
                format!("{count} more"),
                format!("{left} {what}; simplify the scene"),
            )),
        }
    }

    /// The bytes of the file that a scene names by `uri`, percent-escapes decoded.
    pub fn open(&mut self, uri: &str) -> Result<Vec<u8>> {
        let path = relative_path(uri).map_err(|why| self.error(format!("{uri:?}"), why))?;
        let bytes = self.source.read(&path, self.left.bytes)?;
        self.spend("bytes", |b| &mut b.bytes, bytes.len() as u64)?;
        Ok(bytes)
    }
}

/// A URI of a scene file as a relative path inside the scene's folder, or why it is none.
fn relative_path(uri: &str) -> std::result::Result<String, &'static str> {
    const OUTSIDE: &str =
        "names a file outside the scene's folder; move the file beside the scene and export again";
    let path = percent_decode(uri).ok_or("is no valid URI; export the scene again")?;
    let path = path.replace('\\', "/");
    if path.is_empty() || path.contains('\0') {
        return Err("is no file name; export the scene again");
    }
    if path.starts_with('/') || path.starts_with('~') || path.contains(':') {
        return Err(OUTSIDE);
    }
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => {
                parts.pop().ok_or(OUTSIDE)?;
            }
            name => parts.push(name),
        }
    }
    if parts.is_empty() {
        Err("is no file name; export the scene again")
    } else {
        Ok(parts.join("/"))
    }
}

fn percent_decode(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        let code = (first == b'%').then(|| tail.get(..2)).flatten();
        match code.and_then(|c| u8::from_str_radix(std::str::from_utf8(c).ok()?, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            // A stray percent sign is a file name's own.
            None => {
                bytes.push(first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_in_the_folder() {
        assert_eq!(relative_path("a/./b%20c.bin").unwrap(), "a/b c.bin");
        assert_eq!(relative_path("a/../b.png").unwrap(), "b.png");
        assert_eq!(relative_path("100%.png").unwrap(), "100%.png");
        for uri in [
            "../a",
            "a/../../b",
            "/etc/passwd",
            "%2e%2e/a",
            "..%2Fa",
            "..\\a",
            "%5c%5chost/a",
            "C:\\a",
            "file:///etc/passwd",
            "http://host/a",
            "~/a",
            "",
            ".",
            "a/..",
            "a%00b",
            "//host/share",
        ] {
            assert!(relative_path(uri).is_err(), "{uri}");
        }
    }
}
