//! [`Fold`]: what becomes of an edge where two faces meet.

use super::CreaseRule;
use chiaro_basis::math::Vec3;
use chiaro_scene::topology::{Topology, crease};
use chiaro_scene::{Mesh, NormalSource};

/// Normals of the file that are further apart than this mark an edge as hard, radians.
const HARD_NORMALS: f32 = 0.1;
/// The least bend of an edge between facets, radians: those of one plane have none between them.
const FACET: f32 = 0.02;

/// What becomes of an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Fold {
    /// The surface goes on smoothly.
    #[default]
    Smooth,
    /// Opened, for silhouettes to run along.
    Facet,
    /// Opened, and a line of its own.
    Crease,
}

impl Fold {
    /// Whether the two sides have normals of their own.
    pub(crate) fn opens(self) -> bool {
        self != Self::Smooth
    }
}

/// The folds of a mesh in a pose; hard edges that bend little are smooth unless `facets` are wanted.
pub(super) fn folds(
    topology: &Topology,
    mesh: &Mesh,
    positions: &[Vec3],
    rule: &CreaseRule,
    facets: bool,
) -> Vec<Fold> {
    let told = !matches!(&mesh.normals, NormalSource::Given(normals) if normals.is_empty());
    // What a skin folds alone, as an armpit, is shaded smooth and is no edge of what it is of.
    let at_rest = crease::by_angle(topology, &mesh.positions, rule.smooth_angle);
    let sharp: Vec<bool> = crease::by_angle(topology, positions, rule.smooth_angle)
        .into_iter()
        .zip(at_rest)
        .map(|(here, rest)| here && rest)
        .collect();
    let bent = crease::by_angle(topology, positions, rule.angle);
    let hard = match told {
        true => crease::by_normals(topology, mesh, HARD_NORMALS),
        false => vec![true; bent.len()],
    };
    let facet = match facets && told {
        true => bends(topology, mesh, positions, FACET),
        false => vec![false; bent.len()],
    };
    let fold = |e: usize| match hard[e] {
        _ if sharp[e] || (bent[e] && hard[e]) => Fold::Crease,
        true if facet[e] => Fold::Facet,
        _ => Fold::Smooth,
    };
    (0..bent.len()).map(fold).collect()
}

/// Whether no smooth edge bends, so that nothing is rounder than it is.
pub(super) fn is_faceted(
    topology: &Topology,
    mesh: &Mesh,
    positions: &[Vec3],
    folds: &[Fold],
) -> bool {
    let bent = bends(topology, mesh, positions, HARD_NORMALS);
    bent.iter().zip(folds).all(|(bent, fold)| !bent || fold.opens())
}

/// Whether each edge bends by an angle, in a pose or at rest.
fn bends(topology: &Topology, mesh: &Mesh, positions: &[Vec3], angle: f32) -> Vec<bool> {
    let rest = crease::by_angle(topology, &mesh.positions, angle);
    let here = crease::by_angle(topology, positions, angle);
    here.iter().zip(rest).map(|(here, rest)| *here || rest).collect()
}
