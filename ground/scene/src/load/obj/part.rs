//! Which faces of an OBJ file are one object.

use super::super::text::stem;
use super::file::{Face, File};
use chiaro_basis::Sets;
use std::collections::BTreeMap;

/// The faces of one object.
pub(super) struct Part {
    pub(super) name: String,
    pub(super) faces: Vec<Face>,
}

/// The faces by object, in the order of the file: each `o` is one; in files without any, each `g`
/// is one, but groups that share vertices are one together. What has no name is called after the
/// file.
pub(super) fn parts(file: &File, faces: Vec<Face>, file_name: &str) -> Vec<Part> {
    let by_object = file.objects.len() > 1;
    let roots = if by_object { Vec::new() } else { joined_groups(file, &faces) };
    let mut parts: BTreeMap<u32, Vec<Face>> = BTreeMap::new();
    for face in faces {
        let key = if by_object { face.object } else { roots[face.group as usize] };
        parts.entry(key).or_default().push(face);
    }
    let names = if by_object { &file.objects } else { &file.groups };
    let name = |key: u32| match names[key as usize].as_str() {
        "" => stem(file_name).to_owned(),
        name => name.to_owned(),
    };
    parts.into_iter().map(|(key, faces)| Part { name: name(key), faces }).collect()
}

/// For each group the lowest group that it is joined to by common vertices.
fn joined_groups(file: &File, faces: &[Face]) -> Vec<u32> {
    const NOBODY: u32 = u32::MAX;
    let mut sets = Sets::new(file.groups.len());
    let mut owner = vec![NOBODY; file.positions.len()];
    for face in faces {
        for corner in file.corners(face) {
            let owner = &mut owner[corner.position as usize];
            if *owner == NOBODY {
                *owner = face.group;
            }
            sets.join(*owner as usize, face.group as usize);
        }
    }
    (0..sets.len()).map(|group| sets.root(group) as u32).collect()
}
