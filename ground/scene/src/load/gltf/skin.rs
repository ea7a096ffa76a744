//! Skins: joints and inverse bind matrices.

use super::accessor::{Accessors, named};
use super::context::{Context, Place};
use super::json::Value;
use super::primitive::survive;
use super::tree::Tree;
use crate::Skin;
use chiaro_basis::Result;
use chiaro_basis::math::Mat4;

/// All skins, as many as the document has. Matrices that are missing or not finite are the
/// identity; a skin without joints bends nothing.
pub(super) fn read(
    root: &Value,
    tree: &Tree,
    accessors: &Accessors,
    cx: &mut Context,
) -> Result<Vec<Skin>> {
    let skins = root.list("skins").iter().enumerate();
    skins.map(|(i, item)| skin(item, Place::new("skin", i), tree, accessors, cx)).collect()
}

fn skin(
    item: &Value,
    place: Place,
    tree: &Tree,
    accessors: &Accessors,
    cx: &mut Context,
) -> Result<Skin> {
    let items = item.list("joints");
    if items.is_empty() {
        cx.note(place, "it has no joints and bends nothing");
    }
    cx.hold::<Mat4>(place, items.len())?;
    let joint = |v: &Value| v.as_index("joint", tree.items.len()).map(|node| tree.id(node));
    let joints: std::result::Result<Vec<_>, String> = items.iter().map(joint).collect();
    let joints = joints.map_err(|why| cx.wrong(place, why))?;
    let mut inverse_bind = matrices(item, place, joints.len(), accessors, cx)?;
    inverse_bind.resize(joints.len(), Mat4::IDENTITY);
    inverse_bind.iter_mut().filter(|m| !m.is_finite()).for_each(|m| *m = Mat4::IDENTITY);
    Ok(Skin { joints, inverse_bind })
}

/// The inverse bind matrices that the file has, at most `joints`.
fn matrices(
    item: &Value,
    place: Place,
    joints: usize,
    accessors: &Accessors,
    cx: &mut Context,
) -> Result<Vec<Mat4>> {
    const NAME: &str = "inverseBindMatrices";
    let accessor = survive(named(item, NAME, place, accessors, cx), NAME, place, cx)?.flatten();
    let Some(accessor) = accessor else { return Ok(Vec::new()) };
    if accessor.count() < joints {
        let has = accessor.count();
        cx.note(place, format!("it has {has} inverse bind matrices for {joints} joints"));
    }
    let picks: Vec<u32> = (0..accessor.count().min(joints) as u32).collect();
    let rows = survive(accessor.floats::<16>(&picks, cx), NAME, place, cx)?;
    Ok(rows.unwrap_or_default().iter().map(Mat4::from_cols_array).collect())
}
