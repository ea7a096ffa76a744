//! What the statements of an OBJ file define.

use super::super::mtl::{Library, linear};
use super::super::text::{Tally, number, parse, text, words};
use super::super::{Door, Up};
use super::lines::{Lines, without_comment};
use crate::MaterialId;
use crate::mesh::is_in_reach;
use chiaro_basis::Result;
use chiaro_basis::math::{Vec2, Vec3, vec2};
use std::collections::HashMap;

/// Marks a corner without texture coordinate or normal.
pub(super) const NONE: u32 = u32::MAX;
/// Marks an index that points nowhere.
const NOWHERE: u32 = u32::MAX - 1;

/// A face's corner: indices from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub(super) position: u32,
    pub(super) uv: u32,
    pub(super) normal: u32,
}

/// A polygon of at least three corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    start: u32,
    count: u32,
    line: u32,
    pub(super) material: MaterialId,
    /// 0 = off or never said.
    pub(super) smoothing: u32,
    pub(super) object: u32,
    pub(super) group: u32,
}

/// Everything a file says, in its own lists.
pub(super) struct File {
    pub(super) positions: Vec<Vec3>,
    /// As long as `positions`, or empty; NaN where a vertex has none.
    colours: Vec<Vec3>,
    /// v down.
    pub(super) uvs: Vec<Vec2>,
    pub(super) normals: Vec<Vec3>,
    corners: Vec<Corner>,
    faces: Vec<Face>,
    /// Names of objects; the first for faces before any.
    pub(super) objects: Vec<String>,
    /// Names of groups; the first for faces before any.
    pub(super) groups: Vec<String>,
    pub(super) library: Library,
    pub(super) up: Option<Up>,
    /// As stored: fans of all polygons.
    pub(super) triangles: u64,
    /// What colours count up to.
    white: f32,
    left_out: LeftOut,
}

/// What is left out, by line.
#[derive(Default)]
struct LeftOut {
    short: Tally,
    nowhere: Tally,
    infinite: Tally,
    attributes: Tally,
    curves: Tally,
}

/// A file as it is read, and what holds for the next faces.
struct Reader {
    file: File,
    group_numbers: HashMap<String, u32>,
    material: MaterialId,
    smoothing: u32,
    group: u32,
    line: u64,
}

impl File {
    /// Reads the statements; material libraries come through the door as they are named.
    pub(super) fn read(bytes: &[u8], door: &mut Door) -> Result<Self> {
        let file = Self {
            positions: Vec::new(),
            colours: Vec::new(),
            uvs: Vec::new(),
            normals: Vec::new(),
            corners: Vec::new(),
            faces: Vec::new(),
            objects: vec![String::new()],
            groups: vec![String::new()],
            library: Library::default(),
            up: None,
            triangles: 0,
            white: 1.0,
            left_out: LeftOut::default(),
        };
        let mut reader = Reader {
            file,
            group_numbers: HashMap::from([(String::new(), 0)]),
            material: MaterialId::new(0),
            smoothing: 0,
            group: 0,
            line: 0,
        };
        for (number, line) in Lines::new(bytes) {
            reader.line = number;
            reader.statement(&line, door)?;
        }
        let mut file = reader.file;
        let most = file.colours.iter().map(|c| c.max_element()).filter(|c| c.is_finite());
        file.white = if most.fold(0.0, f32::max) > 1.0 { 255.0 } else { 1.0 };
        Ok(file)
    }

    /// The corners of a face.
    pub(super) fn corners(&self, face: &Face) -> &[Corner] {
        &self.corners[face.start as usize..][..face.count as usize]
    }

    /// The linear colour of a vertex, if it has one.
    pub(super) fn colour(&self, position: u32) -> Option<[f32; 3]> {
        let colour = self.colours.get(position as usize).filter(|c| c.is_finite())?;
        Some(linear((*colour / self.white).to_array()))
    }

    /// Checks all indices, now that the whole file is known: the faces that can be drawn, with every
    /// position in range and finite, every other index in range or [`NONE`].
    pub(super) fn settle(&mut self) -> Vec<Face> {
        let (uvs, normals) = (self.uvs.len(), self.normals.len());
        let mut faces = std::mem::take(&mut self.faces);
        faces.retain(|face| {
            let line = u64::from(face.line);
            let corners = &mut self.corners[face.start as usize..][..face.count as usize];
            let position = |c: &Corner| self.positions.get(c.position as usize);
            if corners.iter().any(|c| position(c).is_none()) {
                self.left_out.nowhere.note(line);
                return false;
            }
            if !corners.iter().all(|c| position(c).is_some_and(|p| is_in_reach(*p))) {
                self.left_out.infinite.note(line);
                return false;
            }
            for corner in corners {
                for (index, count) in [(&mut corner.uv, uvs), (&mut corner.normal, normals)] {
                    if *index as usize >= count && *index != NONE {
                        self.left_out.attributes.note(line);
                        *index = NONE;
                    }
                }
            }
            true
        });
        faces
    }

    /// What was left out.
    pub(super) fn warnings(&self, name: &str) -> Vec<String> {
        let left_out = &self.left_out;
        let said = [
            (left_out.short, "faces have less than three corners, and are left out"),
            (left_out.nowhere, "faces point to vertices that are not there, and are left out"),
            (left_out.infinite, "faces have vertices that are not finite, and are left out"),
            (
                left_out.attributes,
                "corners point to texture coordinates or normals that are not there",
            ),
            (left_out.curves, "curves or surfaces are not read; convert them to a mesh"),
        ];
        said.iter().filter_map(|(tally, what)| tally.warn(name, what, "line")).collect()
    }
}

impl Reader {
    fn statement(&mut self, line: &[u8], door: &mut Door) -> Result<()> {
        if line.starts_with(b"#") {
            if self.file.positions.is_empty() && self.file.up.is_none() {
                self.file.up = Up::said(&String::from_utf8_lossy(line));
            }
            return Ok(());
        }
        let key = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        let rest = &line[key.len()..];
        let name = || text(without_comment(rest));
        match key {
            b"v" => self.vertex(rest, door)?,
            b"vt" => {
                let [u, v] = numbers(rest).map(|x| if x.is_finite() { x } else { 0.0 });
                self.file.uvs.push(vec2(u, 1.0 - v));
            }
            b"vn" => self.file.normals.push(Vec3::from(numbers(rest))),
            b"f" | b"fo" => self.face(rest, door)?,
            b"o" => self.file.objects.push(name()),
            b"g" => self.group(name()),
            b"s" => self.smoothing = words(rest).next().and_then(parse).unwrap_or(0),
            b"usemtl" => self.material = self.file.library.find(&name()),
            b"mtllib" => self.file.library.load(&name(), door)?,
            b"curv" | b"curv2" | b"surf" => self.file.left_out.curves.note(self.line),
            _ => {}
        }
        Ok(())
    }

    /// `v x y z`, with a weight w, which polygons have no use for, with a colour, or with both.
    fn vertex(&mut self, rest: &[u8], door: &mut Door) -> Result<()> {
        door.spend("vertices", |b| &mut b.vertices, 1)?;
        let mut n = [f32::NAN; 7];
        let mut count = 0;
        for (slot, word) in n.iter_mut().zip(numeric_words(rest)) {
            *slot = number(word);
            count += 1;
        }
        let colour = match count {
            6 => Some(Vec3::new(n[3], n[4], n[5])),
            7 => Some(Vec3::new(n[4], n[5], n[6])),
            _ => None,
        };
        let file = &mut self.file;
        file.positions.push(Vec3::new(n[0], n[1], n[2]));
        if colour.is_some() || !file.colours.is_empty() {
            file.colours.resize(file.positions.len() - 1, Vec3::NAN);
            file.colours.push(colour.unwrap_or(Vec3::NAN));
        }
        Ok(())
    }

    fn face(&mut self, rest: &[u8], door: &mut Door) -> Result<()> {
        let file = &mut self.file;
        let counts = [file.positions.len(), file.uvs.len(), file.normals.len()];
        let start = file.corners.len();
        file.corners.extend(numeric_words(rest).map(|word| corner(word, counts)));
        let count = file.corners.len() - start;
        if count < 3 {
            file.corners.truncate(start);
            file.left_out.short.note(self.line);
            return Ok(());
        }
        door.spend("triangles", |b| &mut b.triangles, count as u64 - 2)?;
        file.triangles += count as u64 - 2;
        file.faces.push(Face {
            start: start as u32,
            count: count as u32,
            line: u32::try_from(self.line).unwrap_or(u32::MAX),
            material: self.material,
            smoothing: self.smoothing,
            object: file.objects.len() as u32 - 1,
            group: self.group,
        });
        Ok(())
    }

    fn group(&mut self, name: String) {
        let groups = &mut self.file.groups;
        self.group = *self.group_numbers.entry(name).or_insert_with_key(|name| {
            groups.push(name.clone());
            groups.len() as u32 - 1
        });
    }
}

/// Words up to a comment, wherever it starts.
fn numeric_words(rest: &[u8]) -> impl Iterator<Item = &[u8]> {
    words(rest.split(|b| *b == b'#').next().unwrap_or_default())
}

/// The first numbers of a line; missing ones are 0, those that are none NaN.
fn numbers<const N: usize>(rest: &[u8]) -> [f32; N] {
    let mut words = numeric_words(rest);
    std::array::from_fn(|_| words.next().map_or(0.0, number))
}

/// `v`, `v/t`, `v//n` or `v/t/n`, given how many of each there are so far.
fn corner(word: &[u8], counts: [usize; 3]) -> Corner {
    let mut parts = word.split(|b| *b == b'/');
    let mut next = |count: usize| match parts.next() {
        None | Some(b"") => NONE,
        Some(part) => index(part, count),
    };
    Corner { position: next(counts[0]), uv: next(counts[1]), normal: next(counts[2]) }
}

/// An index from 0: positive ones count from 1, negative ones back from the last of `count`.
fn index(word: &[u8], count: usize) -> u32 {
    let (digits, negative) = match word {
        [b'-', digits @ ..] => (digits, true),
        [b'+', digits @ ..] => (digits, false),
        digits => (digits, false),
    };
    let value = digits.iter().try_fold(0u32, |value, digit| {
        let digit = digit.wrapping_sub(b'0');
        if digit > 9 { None } else { value.checked_mul(10)?.checked_add(digit.into()) }
    });
    let index = match value.filter(|_| !digits.is_empty()) {
        None | Some(0) => None,
        Some(back) if negative => (count as u64).checked_sub(back.into()),
        Some(from_one) => Some(u64::from(from_one) - 1),
    };
    index.and_then(|i| u32::try_from(i).ok()).map_or(NOWHERE, |i| i.min(NOWHERE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_count_from_both_ends() {
        let read = |word: &str| index(word.as_bytes(), 10);
        assert_eq!(["1", "10", "+3", "-1", "-10", "11"].map(read), [0, 9, 2, 9, 0, 10]);
        for word in ["0", "-11", "-0", "", "-", "1.0", "x", "99999999999", "4294967295"] {
            assert_eq!(read(word), NOWHERE, "{word}");
        }
    }

    #[test]
    fn corners_have_any_of_three_indices() {
        let read = |word: &str| {
            let c = corner(word.as_bytes(), [5, 5, 5]);
            [c.position, c.uv, c.normal]
        };
        assert_eq!(read("1"), [0, NONE, NONE]);
        assert_eq!(read("1/2"), [0, 1, NONE]);
        assert_eq!(read("1//3"), [0, NONE, 2]);
        assert_eq!(read("-1/-2/-3"), [4, 3, 2]);
        assert_eq!(read("1/"), [0, NONE, NONE]);
        assert_eq!(read("/1"), [NONE, 0, NONE]);
    }
}
