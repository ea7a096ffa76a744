//! `chiaro figures`: figures of the thesis, remade.

use crate::record::Record;
use chiaro_basis::{Result, Run};
use std::path::Path;

/// Makes the figures called `names`, or all, in `folder`.
pub fn figures(_names: &[String], _folder: &Path, _run: &Run) -> Result<Record> {
    Ok(Record::new("figures"))
}

/// Draws a thumbnail of every style into one sheet.
pub fn style_sheet(_path: &Path, _run: &Run) -> Result<Record> {
    Ok(Record::new("style"))
}
