//! Joints and weights of a primitive's vertices (glTF 2.0, section 3.7.3.3).
//!
//! Any number of sets of four; joints that the skin does not have lose their weight, and weights of
//! a vertex are made to sum to one. A vertex without any follows the first joint it names.

use super::accessor::Accessors;
use super::context::Context;
use super::json::Value;
use super::primitive::{Kept, sound, survive};
use crate::Influences;
use chiaro_basis::Result;

/// Sets beyond these are not read: 32 joints a vertex.
const SETS: usize = 8;

/// The influences of the kept vertices, where a skin has `count` joints.
pub(super) fn read(
    attributes: &Value,
    count: usize,
    kept: &Kept,
    accessors: &Accessors,
    cx: &mut Context,
) -> Result<Influences> {
    let mut influences = Influences::default();
    for set in 0..SETS {
        let (joints, weights) = (format!("JOINTS_{set}"), format!("WEIGHTS_{set}"));
        let j = sound(attributes, &joints, kept, accessors, cx)?;
        let w = sound(attributes, &weights, kept, accessors, cx)?;
        let (Some(j), Some(w)) = (j, w) else { break };
        let j = survive(j.wholes::<4>(kept.picks, cx), &joints, kept.place, cx)?;
        let w = survive(w.floats::<4>(kept.picks, cx), &weights, kept.place, cx)?;
        let (Some(j), Some(mut w)) = (j, w) else { break };
        let strays = without_strays(&j, &mut w, count);
        if strays > 0 {
            let what =
                format!("{strays} vertices follow joints that the skin of {count} does not have");
            cx.note(kept.place, what);
        }
        let in_range = |j: u32| if (j as usize) < count { j as u16 } else { 0 };
        influences.joints.push(j.into_iter().map(|j| j.map(in_range)).collect());
        influences.weights.push(w);
    }
    normalize(&mut influences, kept.picks.len());
    Ok(influences)
}

/// Takes the weight of joints that do not exist, and weights that are none; the number of vertices
/// that followed such joints.
fn without_strays(joints: &[[u32; 4]], weights: &mut [[f32; 4]], count: usize) -> usize {
    let mut strays = 0;
    for (joints, weights) in joints.iter().zip(weights) {
        let mut stray = false;
        for (joint, weight) in joints.iter().zip(weights) {
            let exists = (*joint as usize) < count;
            stray |= !exists && *weight > 0.0;
            if !(exists && *weight > 0.0 && weight.is_finite()) {
                *weight = 0.0;
            }
        }
        strays += usize::from(stray);
    }
    strays
}

fn normalize(influences: &mut Influences, vertices: usize) {
    let sets = &mut influences.weights;
    for v in 0..vertices {
        let sum: f32 = sets.iter().flat_map(|set| set[v]).sum();
        if sum > 0.0 && sum.is_finite() {
            sets.iter_mut().for_each(|set| set[v] = set[v].map(|w| w / sum));
        } else if let Some((first, rest)) = sets.split_first_mut() {
            first[v] = [1.0, 0.0, 0.0, 0.0];
            rest.iter_mut().for_each(|set| set[v] = [0.0; 4]);
        }
    }
}
