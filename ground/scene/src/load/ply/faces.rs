//! The faces of a PLY file: polygons, and strips of triangles.

use super::super::polygon::Triangulator;
use super::super::text::Tally;
use super::header::Element;
use super::values::Values;
use super::vertices::{count, texture_coordinate};
use chiaro_basis::math::{Vec2, Vec3};

/// Triangles, and what they came from.
#[derive(Default)]
pub(super) struct Faces {
    pub(super) triangles: Vec<[u32; 3]>,
    /// The face of each triangle.
    pub(super) polygons: Vec<u32>,
    /// Faces that were kept.
    pub(super) faces: u32,
    /// The texture coordinates of each triangle's corners, v down; empty if the faces have none.
    pub(super) uvs: Vec<[Vec2; 3]>,
    /// Faces that were left out, by row.
    pub(super) skipped: Tally,
    /// Triangles as the file stores them, those left out included.
    pub(super) stored: u64,
}

/// The columns of a face that count.
struct Columns {
    corners: Option<usize>,
    uvs: Option<usize>,
}

impl Columns {
    fn of(element: &Element) -> Self {
        let find = |names: &[&str]| {
            let is = |p: &super::header::Property| {
                p.length.is_some() && names.contains(&p.name.as_str())
            };
            element.properties.iter().position(is)
        };
        Self {
            corners: find(&["vertex_indices", "vertex_index"]),
            uvs: find(&["texcoord", "texcoords"]),
        }
    }
}

impl Faces {
    /// Reads the rows of a `face` element; the number of the first that is not whole if they end
    /// early.
    pub(super) fn polygons(
        &mut self,
        element: &Element,
        values: &mut Values,
        positions: &[Vec3],
    ) -> Result<(), u64> {
        let columns = Columns::of(element);
        let mut lists = Vec::new();
        let mut cut = Cut::default();
        for number in 1..=element.rows {
            read_lists(element, values, &mut lists).ok_or(number)?;
            let column = |i: Option<usize>| i.map_or(&[][..], |i| lists[i].as_slice());
            let corners = column(columns.corners);
            self.stored += (corners.len() as u64).saturating_sub(2);
            if !cut.polygon(corners, positions) {
                self.skipped.note(number);
                continue;
            }
            let from = self.triangles.len();
            self.triangles.extend(cut.triangles.iter().map(|t| t.map(|i| cut.corners[i])));
            self.polygons.resize(self.triangles.len(), self.faces);
            self.faces += 1;
            if columns.uvs.is_some() {
                let uvs = column(columns.uvs);
                self.uvs.resize(from, [Vec2::ZERO; 3]);
                self.uvs.extend(cut.triangles.iter().map(|t| t.map(|i| corner_uv(uvs, i))));
            }
        }
        Ok(())
    }

    /// Reads the rows of a `tristrips` element, whose lists are strips between -1s.
    pub(super) fn strips(
        &mut self,
        element: &Element,
        values: &mut Values,
        vertices: usize,
    ) -> Result<(), u64> {
        let column = Columns::of(element).corners;
        let mut lists = Vec::new();
        for number in 1..=element.rows {
            read_lists(element, values, &mut lists).ok_or(number)?;
            let strips = column.map_or(&[][..], |i| lists[i].as_slice());
            for strip in strips.split(|v| *v < 0.0) {
                self.strip(strip, vertices, number);
            }
        }
        if !self.uvs.is_empty() {
            self.uvs.resize(self.triangles.len(), [Vec2::ZERO; 3]);
        }
        Ok(())
    }

    fn strip(&mut self, strip: &[f64], vertices: usize, number: u64) {
        for (i, t) in strip.windows(3).enumerate() {
            self.stored += 1;
            let turned = if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            match turned.map(|v| vertex(v, vertices)) {
                [Some(a), Some(b), Some(c)] => {
                    // Equal corners only turn the strip round.
                    if a != b && b != c && c != a {
                        self.polygons.push(self.faces);
                        self.faces += 1;
                        self.triangles.push([a, b, c]);
                    }
                }
                _ => self.skipped.note(number),
            }
        }
    }
}

/// One face cut into triangles, in memory that is used again.
#[derive(Default)]
struct Cut {
    triangulator: Triangulator,
    corners: Vec<u32>,
    points: Vec<Vec3>,
    triangles: Vec<[usize; 3]>,
}

impl Cut {
    /// Cuts the polygon with these vertices; false when it is none.
    fn polygon(&mut self, list: &[f64], positions: &[Vec3]) -> bool {
        self.corners.clear();
        self.corners.extend(list.iter().map_while(|v| vertex(*v, positions.len())));
        if self.corners.len() < list.len().max(3) {
            return false;
        }
        self.points.clear();
        self.points.extend(self.corners.iter().map(|v| positions[*v as usize]));
        self.triangles.clear();
        self.triangulator.cut(&self.points, &mut self.triangles);
        true
    }
}

fn vertex(index: f64, vertices: usize) -> Option<u32> {
    count(index).filter(|i| *i < vertices as u64).map(|i| i as u32)
}

fn corner_uv(list: &[f64], corner: usize) -> Vec2 {
    let at = |i: usize| list.get(i).map_or(0.0, |x| *x as f32);
    texture_coordinate(at(2 * corner), at(2 * corner + 1))
}

/// Reads the lists of a row, one for each column; single numbers are passed over. `None` when the
/// row is not whole.
fn read_lists(element: &Element, values: &mut Values, lists: &mut Vec<Vec<f64>>) -> Option<()> {
    lists.resize(element.properties.len(), Vec::new());
    for (property, list) in element.properties.iter().zip(lists) {
        let Some(length) = property.length else {
            values.next(property.kind)?;
            continue;
        };
        let count = count(values.next(length)?)?;
        if !values.can_hold(count, property.kind) {
            return None;
        }
        list.clear();
        for _ in 0..count {
            list.push(values.next(property.kind)?);
        }
    }
    Some(())
}
