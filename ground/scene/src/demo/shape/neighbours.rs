//! Which vertices share an edge.

/// The neighbours of every vertex, in rising order, in one list.
pub(crate) struct Neighbours {
    starts: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    /// Of the `vertices` vertices of some triangles.
    pub(crate) fn of(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut pairs: Vec<(u32, u32)> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)])
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut starts = vec![0; vertices + 1];
        pairs.iter().for_each(|p| starts[p.0 as usize + 1] += 1);
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        Self { starts, list: pairs.into_iter().map(|p| p.1).collect() }
    }

    /// Those of one vertex.
    pub(crate) fn around(&self, vertex: usize) -> &[u32] {
        &self.list[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}
