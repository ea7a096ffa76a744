//! `chiaro compare`: how two pictures differ.

use crate::disk;
use crate::record::Record;
use chiaro_basis::{Error, Result, Run};
use chiaro_image::codec::{self, Limits};
use chiaro_image::{Plane, metric};
use serde_json::{Value, json};
use std::path::Path;

/// Measures between two pictures (PNG, JPEG or EXR): of displayed values (sRGB-encoded, in [0, 1]),
/// but for `rmse_relative`, which is of linear light.
pub fn compare(a: &Path, b: &Path, run: &Run) -> Result<Record> {
    let mut record = Record::new("compare");
    let (a, b) = run.stage("load", 2, || Ok::<_, Error>((open(a)?, open(b)?)))?;
    let (shown_a, shown_b) = (metric::displayed(&a), metric::displayed(&b));
    let number = |value: Option<f64>| value.map_or(Value::Null, |v| json!(v));
    for (name, value) in [
        ("psnr_db", number(metric::psnr_db(&shown_a, &shown_b)?)),
        ("rmse", json!(metric::rmse(&shown_a, &shown_b)?)),
        (
            "rmse_relative",
            number(metric::rmse_relative(
                &rgb(&a),
                &rgb(&b),
                &Plane::filled(a.width(), a.height(), true),
            )?),
        ),
        ("flip", json!(metric::flip(&shown_a, &shown_b)?)),
        ("different_pixels", json!(metric::different_pixels(&shown_a, &shown_b)?)),
        ("changed_pixels", json!(metric::changed_pixels(&shown_a, &shown_b)?)),
        ("max_difference", json!(metric::max_difference(&shown_a, &shown_b)?)),
    ] {
        record.count(name, value);
    }
    record.count("pixels", a.len());
    Ok(record)
}

/// Linear light of a picture file.
fn open(path: &Path) -> Result<Plane<[f32; 4]>> {
    let bytes = disk::read(path)?;
    codec::read_colour(&bytes, &path.display().to_string(), &Limits::default())
}

fn rgb(picture: &Plane<[f32; 4]>) -> Plane<[f32; 3]> {
    picture.map(|&[r, g, b, _]| [r, g, b])
}
