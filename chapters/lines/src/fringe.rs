//! [`Fringe`]: where a masked surface ends inside its faces: the outlines of leaves on cards.
//!
//! Opacity minus cutoff is one more function on the surface, and its zero set a line. Textures are finer
//! than faces, so each face gets a grid of its own, about [`CELL`] pixels wide where the shot shows it
//! largest; opacity is averaged over a cell, so that texels below a pixel make no lines. Zero sets are
//! found in the grid's triangles and joined across edges of faces, creases too. Where they are on the surface never
//! changes, so a fringe is the same line in every frame, like an edge.
//!
//! Not done: fringes are not joined to the borders of their faces.

use crate::contour::Scenery;
use crate::film::{Ground, Reel};
use crate::mask::Masks;
use crate::path::{Kind, Path, Point, Segment};
use crate::surface::{NONE, Surface};
use chiaro_basis::math::DVec3;
use std::collections::HashMap;

/// Side of a grid's cells, pixels.
const CELL: f64 = 2.0;
/// Most cells along an edge of a face.
const MOST: u32 = 128;
/// Cells along the edges of faces that reach behind the camera.
const BEHIND: u32 = 64;
/// Most cells along an edge for each texel.
const MAGNIFIED: f64 = 2.0;
/// Most cells of all faces; grids are made coarser until there are fewer.
const ALL: u64 = 4_000_000;
/// Frames of the shot in which faces are measured.
const LOOKS: usize = 5;

/// A place on a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The face.
    pub face: u32,
    /// Weights of its corners.
    pub weights: [f32; 3],
}

/// A line on the surface along which it ends; what is there is on the left, seen from the front.
#[derive(Clone, Debug, PartialEq)]
pub struct Fringe {
    /// Its points; if it is closed the last is at the place of the first.
    pub spots: Vec<Spot>,
    /// The face of each segment: one less than spots.
    pub faces: Vec<u32>,
    /// Whether it ends where it begins.
    pub closed: bool,
}

/// The fringes of a shot's surface.
pub(crate) fn fringes(reel: &Reel<'_>, ground: &Ground) -> Vec<Fringe> {
    let masked: Vec<u32> =
        (0..ground.surface.real_faces as u32).filter(|f| ground.masks.has(*f)).collect();
    if masked.is_empty() {
        return Vec::new();
    }
    let mut sizes = sizes(reel, ground, &masked);
    let cells = |sizes: &[u32]| sizes.iter().map(|n| u64::from(*n).pow(2)).sum::<u64>();
    while cells(&sizes) > ALL && sizes.iter().any(|n| *n > 1) {
        sizes.iter_mut().for_each(|n| *n = n.div_ceil(2));
    }
    let mut found = Found::default();
    for (face, n) in masked.iter().zip(sizes) {
        Grid { masks: &ground.masks, face: *face, n }.trace(&mut found);
    }
    found.joined(&ground.surface).chained()
}

/// Cells along the edges of each of some faces: a power of two, so that neighbours agree where they can.
fn sizes(reel: &Reel<'_>, ground: &Ground, faces: &[u32]) -> Vec<u32> {
    let mut longest = vec![0.0f64; faces.len()];
    let looks = LOOKS.min(reel.count);
    for i in 0..looks {
        let (frame, view) = (reel.at)(i * (reel.count - 1) / (looks - 1).max(1));
        let positions = crate::posed::positions(&ground.surface, &frame);
        for (face, longest) in faces.iter().zip(&mut longest) {
            let corners = ground.surface.faces[*face as usize];
            let [a, b, c] = corners.map(|v| view.see(positions[v as usize]));
            let length = match (a, b, c) {
                (Some(a), Some(b), Some(c)) => {
                    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| p.at.distance(q.at));
                    sides.into_iter().fold(0.0, f64::max)
                }
                _ if [a, b, c].iter().all(Option::is_none) => 0.0,
                _ => CELL * f64::from(BEHIND),
            };
            *longest = longest.max(length);
        }
    }
    let size = |(face, length): (&u32, f64)| {
        let texels = MAGNIFIED * ground.masks.texels(*face);
        let cells = (length / CELL).min(texels).ceil().clamp(1.0, f64::from(MOST));
        (cells as u32).next_power_of_two()
    };
    faces.iter().zip(longest).map(size).collect()
}

/// A piece of a zero set in a cell, from node to node.
struct Piece {
    face: u32,
    nodes: [u32; 2],
}

/// What the grids of all faces hold.
#[derive(Default)]
struct Found {
    spots: Vec<Spot>,
    pieces: Vec<Piece>,
    /// Nodes on the half-edges of faces: where, which, and how wide a cell is there.
    rims: HashMap<u32, Vec<(f32, u32, f32)>>,
}

/// The grid of a face: corners at (0, 0), (n, 0) and (0, n).
struct Grid<'a> {
    masks: &'a Masks,
    face: u32,
    n: u32,
}

impl Grid<'_> {
    fn weights(&self, i: u32, j: u32) -> [f32; 3] {
        let n = self.n as f32;
        [(self.n - i - j) as f32 / n, i as f32 / n, j as f32 / n]
    }

    /// Adds the zero set's pieces in this face.
    fn trace(&self, found: &mut Found) {
        let n = self.n;
        let at = |i: u32, j: u32| (j * (n + 1) + i) as usize;
        let mut values = vec![0.0; at(n, n) + 1];
        for (i, j) in (0..=n).flat_map(|j| (0..=n - j).map(move |i| (i, j))) {
            values[at(i, j)] = self.masks.excess(self.face, self.weights(i, j), n);
        }
        let mut nodes = HashMap::new();
        for (i, j) in (0..n).flat_map(|j| (0..n - j).map(move |i| (i, j))) {
            self.cell([(i, j), (i + 1, j), (i, j + 1)], &values, &mut nodes, found);
            if i + j + 2 <= n {
                let upper = [(i + 1, j), (i + 1, j + 1), (i, j + 1)];
                self.cell(upper, &values, &mut nodes, found);
            }
        }
    }

    fn cell(
        &self,
        corners: [(u32, u32); 3],
        values: &[f32],
        nodes: &mut HashMap<[u32; 2], u32>,
        found: &mut Found,
    ) {
        let ids = corners.map(|(i, j)| j * (self.n + 1) + i);
        let value = ids.map(|id| values[id as usize]);
        let there = value.map(|v| v >= 0.0);
        let mut ends = [NONE; 2];
        for k in 0..3 {
            let m = (k + 1) % 3;
            if there[k] == there[m] {
                continue;
            }
            let key = [ids[k].min(ids[m]), ids[k].max(ids[m])];
            let node = *nodes.entry(key).or_insert_with(|| {
                let (p, q) = if ids[k] < ids[m] { (k, m) } else { (m, k) };
                let t = value[p] / (value[p] - value[q]);
                let [a, b] = [p, q].map(|c| self.weights(corners[c].0, corners[c].1));
                let weights = std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t);
                self.add(weights, found)
            });
            // What is there is on the left: the line goes out where the way round leaves it.
            ends[usize::from(there[k])] = node;
        }
        if ends[0] != NONE {
            found.pieces.push(Piece { face: self.face, nodes: [ends[1], ends[0]] });
        }
    }

    fn add(&self, weights: [f32; 3], found: &mut Found) -> u32 {
        let node = found.spots.len() as u32;
        found.spots.push(Spot { face: self.face, weights });
        // The corner across from an edge has no weight on it.
        for (half, across) in [2, 0, 1].into_iter().enumerate() {
            if weights[across] == 0.0 {
                let rim = found.rims.entry(3 * self.face + half as u32).or_default();
                rim.push((weights[(half + 1) % 3], node, 1.0 / self.n as f32));
            }
        }
        node
    }
}

impl Found {
    /// Makes nodes on both sides of an edge one: the nearest first, within a cell.
    fn joined(mut self, surface: &Surface) -> Self {
        let mut same: Vec<u32> = (0..self.spots.len() as u32).collect();
        let mut halves: Vec<u32> = self.rims.keys().copied().collect();
        halves.sort_unstable();
        for half in halves {
            let mate = surface.across(half);
            let Some(others) = self.rims.get(&mate).filter(|_| half < mate) else { continue };
            let mut pairs = Vec::new();
            for &(t, a, cell) in &self.rims[&half] {
                for &(s, b, other) in others {
                    let apart = (t - (1.0 - s)).abs();
                    if apart <= 1.5 * cell.max(other) {
                        pairs.push((apart, a, b));
                    }
                }
            }
            pairs.sort_by(|x, y| x.0.total_cmp(&y.0).then((x.1, x.2).cmp(&(y.1, y.2))));
            let mut taken = Vec::new();
            for (_, a, b) in pairs {
                if !taken.contains(&a) && !taken.contains(&b) {
                    taken.extend([a, b]);
                    same[b as usize] = a;
                }
            }
        }
        let root = |mut node: u32| {
            while same[node as usize] != node {
                node = same[node as usize];
            }
            node
        };
        self.pieces.iter_mut().for_each(|p| p.nodes = p.nodes.map(root));
        self
    }

    /// Pieces end to end; open lines first.
    fn chained(&self) -> Vec<Fringe> {
        let mut after: HashMap<u32, Vec<usize>> = HashMap::new();
        let mut entered = vec![false; self.spots.len()];
        for (i, piece) in self.pieces.iter().enumerate() {
            after.entry(piece.nodes[0]).or_default().push(i);
            entered[piece.nodes[1] as usize] = true;
        }
        let heads = (0..self.pieces.len()).filter(|i| !entered[self.pieces[*i].nodes[0] as usize]);
        let starts: Vec<usize> = heads.chain(0..self.pieces.len()).collect();
        let mut done = vec![false; self.pieces.len()];
        let mut fringes = Vec::new();
        for start in starts {
            if !done[start] {
                fringes.push(self.walk(start, &after, &mut done));
            }
        }
        fringes
    }

    fn walk(&self, start: usize, after: &HashMap<u32, Vec<usize>>, done: &mut [bool]) -> Fringe {
        let spot = |node: u32| self.spots[node as usize];
        let first = self.pieces[start].nodes[0];
        let mut fringe = Fringe { spots: vec![spot(first)], faces: Vec::new(), closed: false };
        let mut at = Some(start);
        while let Some(i) = at {
            done[i] = true;
            let Piece { face, nodes } = self.pieces[i];
            fringe.spots.push(spot(nodes[1]));
            fringe.faces.push(face);
            fringe.closed = nodes[1] == first;
            let next = after.get(&nodes[1]).into_iter().flatten().copied();
            at = next.filter(|_| !fringe.closed).find(|n| !done[*n]);
        }
        fringe
    }
}

impl Fringe {
    /// The line in one frame, as a chain of borders.
    pub(crate) fn path(&self, index: u32, scenery: &Scenery<'_>) -> Path {
        let place = |spot: &Spot, of: &[DVec3]| {
            let corners = scenery.surface.faces[spot.face as usize].map(|v| of[v as usize]);
            (0..3).map(|i| corners[i] * f64::from(spot.weights[i])).sum::<DVec3>()
        };
        let point = |(k, spot): (usize, &Spot)| {
            let world = place(spot, &scenery.posed.positions);
            let next = scenery.next.map(|n| place(spot, n));
            Point { world, next, pushed: world, on_chain: k as f64 }
        };
        let points: Vec<Point> = self.spots.iter().enumerate().map(point).collect();
        let segment = |(k, face): (usize, &u32)| {
            let source = &scenery.surface.sources[*face as usize];
            let normal = scenery.posed.face_normals[*face as usize];
            let front = normal.dot(scenery.view.to_eye(points[k].world)) > 0.0;
            let buried = !source.two_sided && front == source.turned;
            Segment { buried, ..Segment::of([*face, NONE]) }
        };
        let segments: Vec<Segment> = self.faces.iter().enumerate().map(segment).collect();
        let (view, margin) = (scenery.view, scenery.margin);
        let path = Path::new(Kind::Border, index, self.closed, &points, &segments, view, margin);
        Path { fringe: true, ..path }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::knob::{Hidden, LinesKnobs};
    use crate::view::View;
    use chiaro_basis::Run;
    use chiaro_basis::math::{Vec2, vec2, vec3};
    use chiaro_scene::{
        Alpha, Filter, Frame, Material, MaterialId, Mesh, MeshId, Node, Playback, Pose, Projection,
        Scene, Texture, TextureId, TextureUse, Wrap,
    };

    /// A square of `n` x `n` x 2 faces with a disc of radius 0.3 of its side left of it.
    fn disc(n: u32) -> Scene {
        let uv = |k: u32| vec2((k % (n + 1)) as f32, (k / (n + 1)) as f32) / n as f32;
        let uvs: Vec<Vec2> = (0..(n + 1) * (n + 1)).map(uv).collect();
        let cells = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
        let triangles: Vec<[u32; 3]> =
            cells.flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]).collect();
        let opacity = |x: usize, y: usize| {
            let p = vec2(x as f32 + 0.5, y as f32 + 0.5) / 256.0 - 0.5;
            [0, 0, 0, (127.5 + 2560.0 * (0.3 - p.length())).clamp(0.0, 255.0) as u8]
        };
        let texture = Texture {
            name: String::new(),
            pixels: chiaro_image::Plane::from_fn(256, 256, opacity).into(),
            wrap: [Wrap::Clamp; 2],
            filter: Filter::Linear,
        };
        let used = TextureUse::plain(TextureId::new(0));
        let mesh = Mesh {
            materials: vec![MaterialId::new(0); triangles.len()],
            positions: uvs.iter().map(|p| vec3(p.x - 0.5, p.y - 0.5, 0.0)).collect(),
            uvs: vec![uvs],
            triangles,
            ..Mesh::default()
        };
        let material =
            Material { alpha: Alpha::Mask(0.5), base_texture: Some(used), ..Material::default() };
        Scene {
            meshes: vec![mesh],
            materials: vec![material],
            textures: vec![texture],
            nodes: vec![Node { mesh: Some(MeshId::new(0)), ..Node::default() }],
            ..Scene::default()
        }
    }

    fn film(scene: &Scene, hidden: Hidden) -> crate::Film {
        let pose = Pose::look_at(
            vec3(0.0, 0.0, 2.0),
            vec3(0.0, 0.0, 0.0),
            vec3(0.0, 1.0, 0.0),
            Projection::Perspective { fov_y: 0.7 },
        );
        let at = |_| -> (Frame, View) {
            (scene.frame(0.0, &Playback::still()), View::new(pose, (320, 320)))
        };
        let reel = Reel { scene, count: 1, at: &at };
        let knobs = LinesKnobs { hidden, ..LinesKnobs::default() };
        crate::Film::of(&reel, &knobs, &Run::default()).expect("it ends")
    }

    #[test]
    fn an_outline_runs_on_over_a_crease() {
        let mut scene = disc(2);
        scene.meshes[0].positions.iter_mut().for_each(|p| p.z = -1.2 * p.x.abs());
        let film = film(&scene, Hidden::Drop);
        let strokes = &film.frames[0].strokes;
        assert!(strokes.iter().any(|s| s.kind == Kind::Crease), "the card is folded");
        let borders: Vec<_> = strokes.iter().filter(|s| s.kind == Kind::Border).collect();
        assert_eq!(borders.len(), 1);
        assert!(borders[0].closed);
    }

    #[test]
    fn the_outline_of_a_disc_on_a_card_is_one_circle() {
        for n in [1, 3] {
            let film = film(&disc(n), Hidden::Dashed);
            // What a mask takes away is not hidden: it is not there.
            assert!(film.frames[0].hidden.is_empty(), "{n}");
            let strokes = &film.frames[0].strokes;
            assert_eq!(strokes.len(), 1, "{n}");
            assert!(strokes[0].closed && strokes[0].kind == Kind::Border);
            let off = |p: &crate::Sample| (p.world.truncate().length() - 0.3).abs();
            let worst = strokes[0].samples.iter().map(off).fold(0.0, f64::max);
            assert!(worst < 2e-3, "{n}: {worst}");
            // What is left is on the left.
            let area: f64 = (0..strokes[0].samples.len())
                .map(|i| {
                    let p = |k: usize| strokes[0].samples[k % strokes[0].samples.len()].world;
                    0.5 * p(i).truncate().perp_dot(p(i + 1).truncate())
                })
                .sum();
            assert!((area / (0.09 * std::f64::consts::PI) - 1.0).abs() < 0.01, "{area}");
        }
    }
}
