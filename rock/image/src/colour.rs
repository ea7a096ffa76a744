//! Colour: the sRGB curve, luminance, bytes, and colours as typed on a command line.
//!
//! Two spaces occur in chiaro. *Linear* values are proportional to light and have Rec. 709
//! primaries; everything is computed in them. *Encoded* values have passed the sRGB curve
//! (IEC 61966-2-1); files of bytes and screens hold them.

use chiaro_basis::{Error, Result, nearest};

/// The sRGB curve: linear to encoded. Negative values, which no display has, mirror the curve;
/// values over 1 go on along it.
pub fn srgb_encode(linear: f32) -> f32 {
    let v = linear.abs();
    if v <= 0.003_130_8 {
        return 12.92 * linear;
    }
    // In double precision, so that 1 is 1.
    let encoded = 1.055 * f64::from(v.powf(1.0 / 2.4)) - 0.055;
    (encoded as f32).copysign(linear)
}

/// The sRGB curve backwards: encoded to linear.
pub fn srgb_decode(encoded: f32) -> f32 {
    let v = encoded.abs();
    let linear = if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    linear.copysign(encoded)
}

/// The luminance Y of a linear colour with Rec. 709 primaries; white has luminance 1.
pub fn luminance(linear: [f32; 3]) -> f32 {
    0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
}

/// The byte nearest to 255 times `value`, clamped; not a number gives 0.
#[inline]
pub fn to_byte(value: f32) -> u8 {
    let value = value.clamp(0.0, 1.0) * 255.0;
    // As `round` does, which processors of the first x86-64 have no instruction for.
    let whole = value as u8;
    whole + u8::from(value - f32::from(whole) >= 0.5)
}

/// The colours that have a name: the sixteen of HTML 4, orange of CSS 2.1, and `grey`.
const NAMED: [(&str, u32); 18] = [
    ("black", 0x000000),
    ("silver", 0xC0C0C0),
    ("grey", 0x808080),
    ("gray", 0x808080),
    ("white", 0xFFFFFF),
    ("maroon", 0x800000),
    ("red", 0xFF0000),
    ("purple", 0x800080),
    ("fuchsia", 0xFF00FF),
    ("green", 0x008000),
    ("lime", 0x00FF00),
    ("olive", 0x808000),
    ("yellow", 0xFFFF00),
    ("navy", 0x000080),
    ("blue", 0x0000FF),
    ("teal", 0x008080),
    ("aqua", 0x00FFFF),
    ("orange", 0xFFA500),
];

/// A colour as a user types it: `#rgb`, `#rrggbb`, `#rrggbbaa`, a basic CSS name (`navy`), or
/// `none`, which is transparent black. Components are red, green, blue, alpha, sRGB-encoded, in
/// [0, 1].
///
/// # Errors
/// [`Error::Setting`] for anything else; it says what was meant when a name is nearly right.
pub fn parse_colour(text: &str) -> Result<[f32; 4]> {
    let word = text.trim().to_ascii_lowercase();
    if word == "none" {
        return Ok([0.0; 4]);
    }
    let parsed = match word.strip_prefix('#') {
        Some(digits) => hex(digits),
        None => NAMED.iter().find(|(name, _)| *name == word).map(|(_, rgb)| from_rgb(*rgb)),
    };
    parsed.ok_or_else(|| Error::setting("colour", text, expected(&word)))
}

fn from_rgb(rgb: u32) -> [f32; 4] {
    let [_, r, g, b] = rgb.to_be_bytes();
    [r, g, b, 255].map(|c| f32::from(c) / 255.0)
}

/// Three, six or eight hexadecimal digits.
fn hex(digits: &str) -> Option<[f32; 4]> {
    let nibbles = digits.chars().map(|c| c.to_digit(16)).collect::<Option<Vec<u32>>>()?;
    let bytes: Vec<u32> = match nibbles.len() {
        3 => nibbles.iter().map(|n| n * 17).collect(),
        6 | 8 => nibbles.chunks_exact(2).map(|pair| pair[0] * 16 + pair[1]).collect(),
        _ => return None,
    };
    let component = |i: usize| bytes.get(i).map_or(1.0, |&b| b as f32 / 255.0);
    Some([component(0), component(1), component(2), component(3)])
}

fn expected(word: &str) -> String {
    let forms = "#rgb, #rrggbb, #rrggbbaa, a basic CSS name such as navy, or none";
    let names = NAMED.iter().map(|(name, _)| *name).chain(["none"]);
    match nearest(word, names).filter(|_| !word.starts_with('#')) {
        Some(near) => format!("{forms}; did you mean {near}?"),
        None => forms.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_srgb_curve_and_its_inverse_agree_with_the_standard() {
        for i in 0..=1000 {
            let v = i as f32 / 1000.0;
            assert!((srgb_decode(srgb_encode(v)) - v).abs() < 1e-6, "{v}");
        }
        // Half of full light is byte 188; byte 128 is 21.6 % of full light.
        assert_eq!(to_byte(srgb_encode(0.5)), 188);
        assert!((srgb_decode(128.0 / 255.0) - 0.215_860_5).abs() < 1e-6);
        assert_eq!(srgb_encode(-0.5), -srgb_encode(0.5));
        assert_eq!([0.0, 1.0].map(srgb_encode), [0.0, 1.0]);
        assert_eq!([0.0, 1.0].map(srgb_decode), [0.0, 1.0]);
    }

    #[test]
    fn every_byte_survives_the_round_trip_through_linear_light() {
        for byte in 0..=255u8 {
            assert_eq!(to_byte(srgb_encode(srgb_decode(f32::from(byte) / 255.0))), byte);
        }
    }

    #[test]
    fn luminance_of_white_is_one() {
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-6);
        assert!(luminance([0.0, 1.0, 0.0]) > luminance([1.0, 0.0, 1.0]));
    }

    #[test]
    fn bytes_clamp_and_round() {
        assert_eq!([-1.0, 0.0, 0.5, 1.0, 7.0].map(to_byte), [0, 0, 128, 255, 255]);
        assert_eq!(to_byte(f32::NAN), 0);
    }

    #[test]
    fn colours_parse_in_every_form() {
        let bytes = |text: &str| parse_colour(text).unwrap().map(to_byte);
        assert_eq!(bytes("#fff"), [255, 255, 255, 255]);
        assert_eq!(bytes("#1a2B3c"), [0x1A, 0x2B, 0x3C, 255]);
        assert_eq!(bytes("#10203040"), [0x10, 0x20, 0x30, 0x40]);
        assert_eq!(bytes(" Navy "), [0, 0, 128, 255]);
        assert_eq!(bytes("none"), [0; 4]);
    }

    #[test]
    fn wrong_colours_get_a_hint() {
        let message = parse_colour("navyy").unwrap_err().to_string();
        assert!(message.contains("did you mean navy?"), "{message}");
        for text in ["", "#", "#12", "#12345", "#gggggg", "#é", "rgb(0,0,0)", "#123456789"] {
            assert!(parse_colour(text).is_err(), "{text}");
        }
    }
}
