//! Pictures that scenes name, decoded within the budget.

use super::Door;
use crate::{Filter, Texture, Wrap};
use chiaro_basis::{Error, Result};
use chiaro_image::Plane;
use chiaro_image::codec::{Limits, read_picture};
use std::sync::Arc;

/// The picture at `uri` beside the scene; `None` when it is missing or cannot be read as one.
pub(super) fn open(uri: &str, door: &mut Door) -> Result<Option<Texture>> {
    match door.open(uri) {
        Ok(bytes) => decode(uri, &bytes, door),
        Err(e @ Error::Limit { .. }) => Err(e),
        Err(_) => Ok(None),
    }
}

/// The picture in some bytes; `None` when they hold none. [`Error::Limit`] over the budget.
pub(super) fn decode(name: &str, bytes: &[u8], door: &mut Door) -> Result<Option<Texture>> {
    let limits = Limits { pixels: door.left.pixels, ..Limits::default() };
    let pixels = match read_picture(bytes, name, &limits) {
        Ok(pixels) => pixels,
        Err(e @ Error::Limit { .. }) => return Err(e),
        Err(_) => return Ok(None),
    };
    door.spend("pixels", |b| &mut b.pixels, pixels.len() as u64)?;
    Ok(Some(texture(name, pixels)))
}

fn texture(name: &str, pixels: Plane<[u8; 4]>) -> Texture {
    let name = name.to_owned();
    Texture { name, pixels: Arc::new(pixels), wrap: [Wrap::Repeat; 2], filter: Filter::Linear }
}

/// Whether a picture looks like tangent-space normals: blue on the whole, and not grey.
pub(super) fn is_normal_map(texture: &Texture) -> bool {
    let pixels = texture.pixels.pixels();
    let step = pixels.len() / 1000 + 1;
    let (mut blue, mut all) = (0, 0);
    for p in pixels.iter().step_by(step) {
        all += 1;
        blue += usize::from(p[2] > 150 && p[2] > p[0].saturating_add(20));
    }
    blue * 2 > all
}
