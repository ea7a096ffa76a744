//! The vertices of a PLY file.

use super::header::Element;
use super::values::{Number, Values};
use chiaro_basis::math::{Vec2, Vec3, Vec4, vec2};
use chiaro_image::colour::srgb_decode;

/// The columns that a vertex has a use for, in the order of [`SLOTS`].
const SLOTS: [&[&str]; 12] = [
    &["x"],
    &["y"],
    &["z"],
    &["nx", "normal_x"],
    &["ny", "normal_y"],
    &["nz", "normal_z"],
    &["red", "r", "diffuse_red"],
    &["green", "g", "diffuse_green"],
    &["blue", "b", "diffuse_blue"],
    &["alpha", "a", "diffuse_alpha"],
    &["s", "u", "texture_u", "texture_s"],
    &["t", "v", "texture_v", "texture_t"],
];
const NORMAL: usize = 3;
const COLOUR: usize = 6;
const ALPHA: usize = 9;
const UV: usize = 10;

/// Vertices; arrays are empty or as long as `positions`.
#[derive(Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<Vec3>,
    pub(super) normals: Vec<Vec3>,
    /// Linear.
    pub(super) colours: Vec<Vec4>,
    /// v down.
    pub(super) uvs: Vec<Vec2>,
}

impl Vertices {
    /// Reads the rows; the number of the first one that is not whole, from 1, if they end early.
    pub(super) fn read(element: &Element, values: &mut Values) -> Result<Self, u64> {
        let slots: Vec<Option<usize>> = element.properties.iter().map(|p| slot(&p.name)).collect();
        let has = |slot: usize| slots.contains(&Some(slot));
        let [normals, colours, uvs] =
            [(NORMAL..NORMAL + 3).all(has), (COLOUR..COLOUR + 3).all(has), (UV..UV + 2).all(has)];
        let mut vertices = Self::default();
        let mut row = [0.0; SLOTS.len()];
        row[ALPHA] = f64::INFINITY;
        for number in 1..=element.rows {
            element
                .row(values, |i, value| slots[i].into_iter().for_each(|s| row[s] = value))
                .ok_or(number)?;
            let v = row.map(|x| x as f32);
            vertices.positions.push(Vec3::new(v[0], v[1], v[2]));
            if normals {
                vertices.normals.push(Vec3::new(v[NORMAL], v[NORMAL + 1], v[NORMAL + 2]));
            }
            if colours {
                vertices.colours.push(Vec4::new(v[COLOUR], v[COLOUR + 1], v[COLOUR + 2], v[ALPHA]));
            }
            if uvs {
                vertices.uvs.push(texture_coordinate(v[UV], v[UV + 1]));
            }
        }
        let kind = |slot: usize| {
            let i = slots.iter().position(|s| *s == Some(slot));
            i.map_or(Number::F32, |i| element.properties[i].kind)
        };
        let white = kind(COLOUR).white();
        linearize(&mut vertices.colours, white, kind(ALPHA).white());
        Ok(vertices)
    }
}

impl Element {
    /// Reads a row and hands on its single numbers with their columns; lists are passed over.
    /// `None` when the row is not whole.
    pub(super) fn row(&self, values: &mut Values, mut each: impl FnMut(usize, f64)) -> Option<()> {
        for (i, property) in self.properties.iter().enumerate() {
            match property.length {
                None => each(i, values.next(property.kind)?),
                Some(length) => {
                    let count = count(values.next(length)?)?;
                    for _ in 0..count {
                        values.next(property.kind)?;
                    }
                }
            }
        }
        Some(())
    }
}

/// The length of a list as a number that may be one.
pub(super) fn count(length: f64) -> Option<u64> {
    (length >= 0.0 && length.fract() == 0.0).then_some(length as u64)
}

fn slot(name: &str) -> Option<usize> {
    SLOTS.iter().position(|names| names.contains(&name))
}

/// A texture coordinate of the file, v up, as one with v down; what is not finite is 0.
pub(super) fn texture_coordinate(u: f32, v: f32) -> Vec2 {
    let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
    vec2(finite(u), 1.0 - finite(v))
}

/// Colours as stored to linear ones: whole numbers are sRGB-encoded up to `white`; fractions are
/// linear, unless some are over 1, which makes them bytes by another name. Alpha counts to its own
/// white; where there is none it is infinite, and becomes 1.
fn linearize(colours: &mut [Vec4], white: Option<f32>, alpha: Option<f32>) {
    let most = |values: &dyn Fn(&Vec4) -> f32| {
        colours.iter().map(values).filter(|v| v.is_finite()).fold(0.0, f32::max)
    };
    let white = white.or((most(&|c| c.truncate().max_element()) > 1.0).then_some(255.0));
    let opaque = alpha.or((most(&|c| c.w) > 1.0).then_some(255.0)).unwrap_or(1.0);
    let unit = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    let table: Vec<f32> = (0..=255u8).map(|b| srgb_decode(f32::from(b) / 255.0)).collect();
    let decode = |c: f32| match white {
        None => unit(c),
        Some(255.0) => table[(255.0 * unit(c / 255.0)).round() as usize],
        Some(white) => srgb_decode(unit(c / white)),
    };
    for c in colours {
        *c = Vec4::new(decode(c.x), decode(c.y), decode(c.z), unit(c.w / opaque));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_linear_whatever_their_type() {
        let colour = |c: [f32; 4], white, alpha| {
            let mut colours = [Vec4::from(c)];
            linearize(&mut colours, white, alpha);
            colours[0].to_array()
        };
        let half = srgb_decode(128.0 / 255.0);
        let none = f32::INFINITY;
        assert_eq!(colour([255.0, 128.0, 0.0, none], Some(255.0), None), [1.0, half, 0.0, 1.0]);
        assert_eq!(colour([65535.0, 0.0, 0.0, 0.0], Some(65535.0), Some(255.0))[0], 1.0);
        assert_eq!(colour([0.25, 0.5, 1.0, 0.5], None, None), [0.25, 0.5, 1.0, 0.5]);
        assert_eq!(colour([255.0, 128.0, 0.0, 255.0], None, None), [1.0, half, 0.0, 1.0]);
        assert_eq!(colour([f32::NAN, -1.0, 1.0, none], None, None), [0.0, 0.0, 1.0, 1.0]);
    }
}
