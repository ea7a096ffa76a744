use super::*;
use crate::colours::Colours;
use crate::project::{Options, Project};
use crate::style::Style;
use chiaro_basis::math::Vec3;
use chiaro_binary::BinaryKnobs;
use chiaro_image::codec::{ExrChannel, ExrImage, write_exr, write_png_rgba};

const SIZE: usize = 96;

/// A folder with a picture and a normal map of a ball, and their paths.
fn ball() -> (tempfile::TempDir, String, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let at = |x: usize| (x as f32 + 0.5) / SIZE as f32 * 2.4 - 1.2;
    let normal = |x: usize, y: usize| {
        let (u, v) = (at(x), -at(y));
        let z2 = 1.0 - u * u - v * v;
        (z2 > 0.0).then(|| Vec3::new(u, v, z2.sqrt()))
    };
    let byte = |v: f32| (v * 255.0).round() as u8;
    let map = Plane::from_fn(SIZE, SIZE, |x, y| match normal(x, y) {
        Some(n) => [byte(0.5 * n.x + 0.5), byte(0.5 * n.y + 0.5), byte(0.5 * n.z + 0.5), 255],
        None => [0, 0, 0, 255],
    });
    let picture = Plane::from_fn(SIZE, SIZE, |x, y| {
        let light = normal(x, y).map_or(0.0, |n| n.dot(Vec3::new(-0.6, 0.6, 0.5)).clamp(0.0, 1.0));
        [byte(light), byte(light), byte(light), 255]
    });
    let (name, normals) = (dir.path().join("ball.png"), dir.path().join("normals.png"));
    std::fs::write(&name, write_png_rgba(&picture, None).unwrap()).unwrap();
    std::fs::write(&normals, write_png_rgba(&map, None).unwrap()).unwrap();
    (dir, name.display().to_string(), normals)
}

fn drawn(given: &Given) -> Picture {
    let style = Style::find("ink").unwrap();
    let target = Target::Single("a.png".into());
    let job = Job { given, look: Look::of(&style), target };
    job.picture(&Run::default()).unwrap().0
}

#[test]
fn a_picture_with_normals_is_shaded() {
    let (_dir, name, normals) = ball();
    let maps = Maps { normals: Some(normals), ..Maps::default() };
    let picture = drawn(&Given::open(&name, &maps, &Run::default()).unwrap());
    let covered = &picture.covered;
    assert!(!covered[(1, 1)] && covered[(48, 48)]);
    // The light comes from the upper left.
    assert!(picture.white[(30, 30)] && !picture.white[(75, 75)]);
}

#[test]
fn a_map_draws_each_outline_once() {
    let (dir, name, normals) = ball();
    let at = |x: usize| (x as f32 + 0.5) / SIZE as f32 * 2.4 - 1.2;
    let ring = Plane::from_fn(SIZE, SIZE, |x, y| match at(x).hypot(at(y)) {
        r if (0.97..1.04).contains(&r) => [0u8, 0, 0, 255],
        _ => [255; 4],
    });
    let map = dir.path().join("map.png");
    std::fs::write(&map, write_png_rgba(&ring, None).unwrap()).unwrap();
    let maps = Maps { normals: Some(normals), discontinuity: Some(map.clone()), ..Maps::default() };
    let given = Given::open(&name, &maps, &Run::default()).unwrap();
    for palette in ["", "3"] {
        let mut style = Style::find("ink").unwrap();
        style.binary.palette = palette.into();
        let job =
            Job { given: &given, look: Look::of(&style), target: Target::Single("a.png".into()) };
        let picture = job.picture(&Run::default()).unwrap().0.displayed(&Colours::default());
        // From the left into the lit side, and from the right into the shade.
        let row: Vec<bool> = (0..SIZE).map(|x| picture[(x, SIZE / 2)][0] < 128).collect();
        let changes = |row: &[bool]| row.windows(2).filter(|p| p[0] != p[1]).count();
        assert_eq!(changes(&row[..SIZE / 4]), 2, "{palette}: {row:?}");
        assert_eq!(changes(&row[3 * SIZE / 4..]), 1, "{palette}: {row:?}");
    }
}

#[test]
fn normals_may_point_down_and_maps_must_fit() {
    let (dir, name, normals) = ball();
    let maps = Maps { normals: Some(normals.clone()), normals_y_down: true, ..Maps::default() };
    let given = Given::open(&name, &maps, &Run::default()).unwrap();
    assert!(given.layers.normal.as_ref().unwrap()[(48, 30)][1] < -0.2);
    let small = dir.path().join("small.png");
    let plane = Plane::filled(5, 5, [128u8, 128, 255, 255]);
    std::fs::write(&small, write_png_rgba(&plane, None).unwrap()).unwrap();
    let maps = Maps { normals: Some(small), ..Maps::default() };
    let error = Given::open(&name, &maps, &Run::default()).err().unwrap().to_string();
    assert!(error.contains("small.png") && error.contains("5 x 5"), "{error}");
}

#[test]
fn one_pixel_and_empty_masks_are_pictures() {
    for alpha in [0u8, 255] {
        for (w, h) in [(1, 1), (1, 300), (7, 3)] {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("a.png");
            let plane = Plane::filled(w, h, [90u8, 90, 90, alpha]);
            std::fs::write(&path, write_png_rgba(&plane, None).unwrap()).unwrap();
            let name = path.display().to_string();
            let given = Given::open(&name, &Maps::default(), &Run::default()).unwrap();
            assert_eq!(drawn(&given).white.size(), (w, h));
        }
    }
}

/// The layers that Blender would write of a procedural scene: combined, depth, world normals.
fn blender(with_position: bool) -> (Given, chiaro_binary::View) {
    let options = Options { size: Some((160, 120)), ..Options::default() };
    let run = Run::default();
    let project = Project::open("demo:torus", options, &run).unwrap();
    let knobs = BinaryKnobs::default();
    let shot = crate::binary::Shot::survey(&project, &knobs, &run).unwrap();
    let poser = project.poser();
    let frame = project.pose(&poser, 1, &run);
    let scene = shot.everything(&frame, 1, &run).unwrap();
    let b = &scene.buffer;
    let mut layers = Vec::new();
    let mut push = |name: &str, plane: Plane<f32>| {
        layers.push((format!("View Layer.{name}"), ExrChannel::F32(plane)));
    };
    for (i, axis) in ["X", "Y", "Z"].into_iter().enumerate() {
        push(&format!("Normal.{axis}"), b.normal.map(|n| n[i]));
        if with_position {
            push(&format!("Position.{axis}"), b.position.map(|n| n[i]));
        }
    }
    let depth = b.depth.zip(&b.covered, |d, c| if *c { *d } else { 1e10 }).unwrap();
    push("Depth.Z", depth);
    for channel in ["R", "G", "B", "A"] {
        push(&format!("Combined.{channel}"), b.covered.map(|c| if *c { 0.5 } else { 0.0 }));
    }
    // Blender writes indices that nobody set as zeros.
    push("Object Index.X", b.object.map(|_| 0.0));
    push("CryptoObject00.r", b.object.map(|o| f32::from_bits(*o)));
    let bytes = write_exr(&ExrImage { size: b.size(), layers, ..ExrImage::default() }).unwrap();
    let layers = read_layers("render.exr", &bytes).unwrap();
    let (name, files) = ("render.exr".into(), Vec::new());
    (Given { name, files, hash: String::new(), maps: Map::new(), layers }, scene)
}

#[test]
fn renders_by_others_have_the_geometry_of_the_scene() {
    for with_position in [true, false] {
        let (given, scene) = blender(with_position);
        let view = view::view(&given.layers, &BinaryKnobs::default());
        let (ours, theirs) = (&scene.buffer, &view.buffer);
        assert_eq!(ours.covered, theirs.covered);
        let turn = ours.pose.forward.dot(theirs.pose.forward).clamp(-1.0, 1.0).acos().to_degrees();
        let limit = if with_position { 0.1 } else { 8.0 };
        assert!(turn < limit, "positions {with_position}: the camera is {turn} degrees off");
        let ratio = theirs.radius / ours.radius;
        assert!((0.6..1.7).contains(&ratio), "radius {ratio}");
        if with_position {
            let off = ours.geometric_normal.pixels().iter().zip(theirs.geometric_normal.pixels());
            let close = off.filter(|(a, b)| Vec3::from(**a).dot(Vec3::from(**b)) > 0.9).count();
            let covered = ours.covered.pixels().iter().filter(|c| **c).count();
            assert!(close as f64 > 0.9 * covered as f64, "{close} of {covered}");
        }
        assert!(theirs.object == ours.object, "ids come bit by bit");
    }
}

#[test]
fn files_without_layers_and_damaged_ones_are_one_sentence() {
    let plane = ExrChannel::F32(Plane::filled(4, 4, 1.0));
    let image =
        ExrImage { size: (4, 4), layers: vec![("foo.bar".into(), plane)], ..ExrImage::default() };
    let bytes = write_exr(&image).unwrap();
    let error = read_layers("a.exr", &bytes).err().unwrap().to_string();
    assert!(error.starts_with("a.exr: ") && error.contains("MultiLayer"), "{error}");
    for cut in [5, 20, bytes.len() / 2, bytes.len() - 3] {
        assert!(read_layers("a.exr", &bytes[..cut]).is_err());
    }
    let nan = ExrChannel::F32(Plane::filled(4, 4, f32::NAN));
    let layers = ["N.X", "N.Y", "N.Z", "Z", "R", "G", "B"].map(|n| (n.to_owned(), nan.clone()));
    let image = ExrImage { size: (4, 4), layers: layers.to_vec(), ..ExrImage::default() };
    let layers = read_layers("a.exr", &write_exr(&image).unwrap()).unwrap();
    assert!(layers.covered().pixels().iter().all(|c| !c));
}

/// Layers of six frames of a turning torus, and the film made of them in `out`.
fn film_of_layers(folder: &Path, frames: &[u32], out: &str) -> (Map<String, Value>, Vec<String>) {
    let run = Run::default();
    let pattern = folder.join("in####.exr");
    let numbers: Vec<u32> = (1..=6).collect();
    if !folder.join("in0001.exr").exists() {
        let options = Options {
            size: Some((64, 48)),
            frames: Some(numbers.clone()),
            turntable: true,
            shot: Some((1..=60).collect()),
            ..Options::default()
        };
        let project = Project::open("demo:bumpy-torus", options, &run).unwrap();
        let target = Target::Pattern(pattern.clone());
        crate::gbuffer::Job { project: &project, target }.run(&run).unwrap();
    }
    let name = pattern.display().to_string();
    let (frames, shot) = (Some(frames.to_vec()), Some(numbers));
    let sequence = &Sequence::open(&name, Maps::default(), frames, shot).unwrap();
    let style = Style::find("ink").unwrap();
    let target = Target::Pattern(folder.join(out));
    let film = Film { sequence, look: Look::of(&style), target, fps: 24.0 };
    let record = film.run(&run).unwrap();
    (record.counts, record.outputs.into_iter().map(|o| o.sha256).collect())
}

#[test]
fn numbered_renders_are_a_film_along_their_motion() {
    let dir = tempfile::tempdir().unwrap();
    let numbers: Vec<u32> = (1..=6).collect();
    let (counts, whole) = film_of_layers(dir.path(), &numbers, "a####.png");
    assert_eq!(whole.len(), 6);
    // Most of what is seen is linked, and hardly anything flips in a slow turn.
    let flips = counts["flips_per_pixel"].as_f64().unwrap();
    assert!(flips > 0.0 && flips < 0.1, "{flips}");
    let (_, part) = film_of_layers(dir.path(), &[3, 4], "b####.png");
    assert_eq!(part, whole[2..4]);
    let pattern = dir.path().join("in####.exr").display().to_string();
    let open = |frames| Sequence::open(&pattern, Maps::default(), Some(frames), None);
    let error = open(vec![5, 9]).err().unwrap().to_string();
    assert!(error.contains('9') && error.contains("from 1 to 6"), "{error}");
}

#[test]
fn motion_vectors_of_blender_point_down_and_forth_here() {
    let scalar = |v: f32| ExrChannel::F32(Plane::filled(4, 4, v));
    let values = [("X", 1.0), ("Y", 2.0), ("Z", 3.0), ("W", 4.0)];
    let layers = values.map(|(n, v)| (format!("ViewLayer.Vector.{n}"), scalar(v))).to_vec();
    let image = ExrImage { size: (4, 4), layers, ..ExrImage::default() };
    let motion = Layers::of_exr(&image).motion.unwrap();
    assert_eq!(motion.back[(1, 1)], [1.0, -2.0]);
    assert_eq!(motion.forth.unwrap()[(1, 1)], [-3.0, 4.0]);
}

/// Five renders, as Blender names their layers, of a ball that moves three pixels a frame before a
/// wall; `sign` turns its motion vectors round. The film's measures, and its pictures.
fn film_of_a_ball(folder: &Path, sign: f32) -> (Map<String, Value>, Vec<Plane<bool>>) {
    let (w, h) = (72, 48);
    for number in 1..=5u32 {
        let left = 20.0 + 3.0 * number as f32;
        let ball = |x: usize, y: usize| {
            let (u, v) = ((x as f32 + 0.5 - left) / 14.0, (24.0 - y as f32 - 0.5) / 14.0);
            let z2 = 1.0 - u * u - v * v;
            (z2 > 0.0).then(|| [u, v, z2.sqrt()])
        };
        let plane = |value: &(dyn Fn(Option<[f32; 3]>) -> f32 + Sync)| {
            ExrChannel::F32(Plane::from_fn(w, h, |x, y| value(ball(x, y))))
        };
        // Cryptomatte has hashes, bit by bit.
        let hash = |n: Option<[f32; 3]>| f32::from_bits(n.map_or(0x3e12_ab34, |_| 0x41c0_0123));
        let light = |n: Option<[f32; 3]>| n.map_or(0.5, |[x, y, z]| (y - x + z).max(0.0) * 0.5);
        let moves = |n: Option<[f32; 3]>| n.map_or(0.0, |_| -3.0 * sign);
        let axis = |i: usize| move |n: Option<[f32; 3]>| n.unwrap_or([0.0, 0.0, 1.0])[i];
        let layers = [
            ("Combined.R", plane(&light)),
            ("Combined.G", plane(&light)),
            ("Combined.B", plane(&light)),
            ("Combined.A", plane(&|_| 1.0)),
            ("Depth.Z", plane(&|n| 10.0 - n.map_or(0.0, |n| 2.0 + n[2]))),
            ("Normal.X", plane(&axis(0))),
            ("Normal.Y", plane(&axis(1))),
            ("Normal.Z", plane(&axis(2))),
            ("Vector.X", plane(&moves)),
            ("Vector.Y", plane(&|_| 0.0)),
            ("Vector.Z", plane(&moves)),
            ("Vector.W", plane(&|_| 0.0)),
            ("CryptoObject00.r", plane(&hash)),
            ("CryptoObject00.g", plane(&|_| 1.0)),
        ];
        let layers = layers.map(|(name, plane)| (format!("ViewLayer.{name}"), plane)).to_vec();
        let bytes = write_exr(&ExrImage { size: (w, h), layers, ..ExrImage::default() }).unwrap();
        std::fs::write(folder.join(format!("{number:04}.exr")), bytes).unwrap();
    }
    let pattern = folder.join("####.exr").display().to_string();
    let sequence = &Sequence::open(&pattern, Maps::default(), None, None).unwrap();
    let style = Style::find("ink").unwrap();
    let target = Target::Pattern(folder.join("out####.png"));
    let film = Film { sequence, look: Look::of(&style), target, fps: 24.0 };
    let record = film.run(&Run::default()).unwrap();
    let white = |output: &crate::record::Output| {
        let bytes = std::fs::read(&output.path).unwrap();
        read_colour(&bytes, "out", &Limits::default()).unwrap().map(|p| p[0] > 0.5)
    };
    (record.counts, record.outputs.iter().map(white).collect())
}

#[test]
fn renders_with_cryptomatte_and_vectors_are_a_film() {
    let dir = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let (counts, pictures) = film_of_a_ball(dir[0].path(), 1.0);
    assert_eq!(pictures.len(), 5);
    for (n, pair) in pictures.windows(2).enumerate() {
        // The middle of the ball, three pixels on.
        let left = 23 + 3 * n;
        let inside = (12..36).flat_map(|y| (left - 9..left + 9).map(move |x| (x, y)));
        let same = inside.filter(|&(x, y)| pair[0][(x, y)] == pair[1][(x + 3, y)]).count();
        assert!(same > 24 * 18 * 97 / 100, "{same} of {} in frame {n}", 24 * 18);
        let shades: Vec<bool> = (12..36).map(|y| pair[0][(left, y)]).collect();
        assert!(shades.contains(&true) && shades.contains(&false), "the ball is shaded");
    }
    let flips = |counts: &Map<String, Value>| counts["flips_per_pixel"].as_f64().unwrap();
    let (astray, _) = film_of_a_ball(dir[1].path(), -1.0);
    assert!(flips(&counts) < 0.3 * flips(&astray), "{} {}", flips(&counts), flips(&astray));
}
