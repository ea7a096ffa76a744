//! NPY, NumPy's array file, version 1.0: planes for numerical programs. Writing only.

use crate::Plane;

/// Integers as an array of shape (height, width, N), little-endian `int32`.
pub fn write_npy<const N: usize>(plane: &Plane<[i32; N]>) -> Vec<u8> {
    let (width, height) = plane.size();
    let mut bytes = header("<i4", &format!("{height}, {width}, {N}"), plane.len() * N * 4);
    bytes.extend(plane.pixels().as_flattened().iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// Labels as an array of shape (height, width), `uint8`: 1 where true.
pub fn write_npy_labels(plane: &Plane<bool>) -> Vec<u8> {
    let (width, height) = plane.size();
    let mut bytes = header("|u1", &format!("{height}, {width}"), plane.len());
    bytes.extend(plane.pixels().iter().map(|&v| u8::from(v)));
    bytes
}

/// Magic, version, and a Python dictionary padded so that `data` bytes begin at a multiple of 64.
fn header(kind: &str, shape: &str, data: usize) -> Vec<u8> {
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}");
    let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = Vec::with_capacity(10 + length + data);
    bytes.extend(b"\x93NUMPY\x01\x00");
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{text:<width$}\n", width = length - 1).into_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_begin_at_a_multiple_of_64_and_are_row_major() {
        let plane = Plane::from_pixels(2, 1, vec![[1, -2, 300], [4, 5, 6]]);
        let bytes = write_npy(&plane);
        let text = String::from_utf8_lossy(&bytes[10..]);
        assert!(text.starts_with("{'descr': '<i4', 'fortran_order': False, 'shape': (1, 2, 3), }"));
        let data = &bytes[bytes.len() - 24..];
        assert_eq!((bytes.len() - 24) % 64, 0);
        assert_eq!(bytes[bytes.len() - 25], b'\n');
        assert_eq!(data[..12], [1, 0, 0, 0, 254, 255, 255, 255, 44, 1, 0, 0]);
    }

    #[test]
    fn labels_are_ones_and_zeros() {
        let bytes = write_npy_labels(&Plane::from_pixels(1, 3, vec![true, false, true]));
        assert_eq!(bytes.len(), 128 + 3);
        assert_eq!(bytes[128..], [1, 0, 1]);
        assert_eq!(&bytes[..6], b"\x93NUMPY");
    }
}
