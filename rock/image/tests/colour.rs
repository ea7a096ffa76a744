//! Colours as bytes.

use chiaro_image::colour::to_byte;

#[test]
fn bytes_are_rounded_as_numbers_are() {
    let round = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    for half in 0..=512 {
        let middle = 0.5 * half as f32 / 255.0;
        for step in -4..=4i32 {
            let value = f32::from_bits(middle.to_bits().saturating_add_signed(step));
            assert_eq!(to_byte(value), round(value), "{value}");
        }
    }
    for value in [-1.0, 7.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
        assert_eq!(to_byte(value), round(value), "{value}");
    }
}
