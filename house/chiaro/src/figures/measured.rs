//! Tables 6.1 to 6.3, figure 6.6, and codes side by side: what is measured, beside the thesis's numbers.

use super::chart::{Axis, COLOURS, Chart, Scale, Series, table};
use super::front::front;
use super::lessons::{self, DENSE, SIZE, SPARSE};
use super::quantized::{Measured, name_of};
use crate::light::{Still, nearness, still};
use crate::record::resident_bytes;
use chiaro_basis::{Result, Run};
use chiaro_image::sheet::Sheet;
use chiaro_pbgi::classic::{Classic, Leaf};
use chiaro_pbgi::code::{Book, Gains, Pen, Recipe};
use chiaro_pbgi::compact::Compact;
use chiaro_pbgi::curve::Cube;
use chiaro_pbgi::packed::{Packed, Record};
use chiaro_pbgi::{Exact, LightKnobs, stream};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const ONE: [&str; 1] = ["demo:courtyard"];
const SCENES: [&str; 3] = ["demo:cornell-box", "demo:courtyard", "demo:sphere-field"];

pub(super) const FIGURES: [Measured; 5] = [
    Measured {
        name: "table-6.1",
        title: "memory of the thesis's tree, for 10 million leaves",
        message: "Megabytes of 10^6 bytes, measured on a tree of fewer leaves and scaled; compression over \
                  the unquantized tree with leaf A. The print has 392.50 for 10 000 words and leaf B; its \
                  own rate is that of 297.50. It counts no radii and no lobes of area (a node has 27 + 9 \
                  numbers; the 9 are in floats here), and sets leaf B against leaf A: like with like, 5.05 is 4.71.",
        columns: 1,
        scenes: &ONE,
        draw: memory,
    },
    Measured {
        name: "table-6.2",
        title: "leaf formats",
        message: "Bytes of a leaf. B's position is 3 x 5 bits in its parent's sphere. Errors are root mean \
                  squares; positions over the leaf's radius, the rest relative.",
        columns: 1,
        scenes: &ONE,
        draw: leaves,
    },
    Measured {
        name: "table-6.3",
        title: "seconds to learn words and to build the tree",
        message: "One thread, this machine against the thesis's (2.83 GHz, 5 million surfels): seconds for \
                  a million leaves. The thesis's build includes the light of its leaves; more: what quantization \
                  adds to tree and light. Last rows: ours, blocks of 16, one node for 14 leaves.",
        columns: 1,
        scenes: &ONE,
        draw: seconds,
    },
    Measured {
        name: "6.6",
        title: "memory while the tree is built",
        message: "Resident bytes over time: the tree with lobes in floats, and the tree that is quantized \
                  on the fly (Algorithm 1), from the same leaves.",
        columns: 1,
        scenes: &ONE,
        draw: curve,
    },
    Measured {
        name: "6.rate",
        title: "what codes cost and lose",
        message: "Bytes a surfel of the whole tree against decibels of the displayed picture to the same \
                  tree in floats, and against the 99th percentile of a node's relative error. The thesis's \
                  own tree has one surfel a leaf; all others have blocks of 16. The line is the codes' \
                  front: no mixture of two others has more decibels, or less error, in as many bytes.",
        columns: 2,
        scenes: &SCENES,
        draw: rate,
    },
];

fn row(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|c| (*c).to_owned()).collect()
}

/// The leaves of a scene, and what a tenth of its surfels teaches.
fn leaves_of(at: &Still, run: &Run) -> Result<Vec<Record>> {
    Ok(at.sides(&at.points(DENSE, run)?))
}

fn memory(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    const THESIS: [(usize, [f64; 3]); 3] = [
        (100, [8.75, 388.75, 288.75]),
        (1000, [12.5, 392.5, 292.5]),
        (10_000, [17.5, 397.5, 297.5]),
    ];
    let mut values = Vec::new();
    for scene in scenes {
        still(scene, SIZE, &lessons::knobs(), run, |at| {
            let records = leaves_of(at, run)?;
            let taught = lessons::of(at, SPARSE, run)?;
            let scale = 10.0 / records.len() as f64;
            let mb = |bytes: usize| scale * bytes as f64;
            let exact = Classic::exact(&records, Leaf::A).counted();
            let (full, light) = (mb(exact.of_thesis()), mb(exact.light));
            let mut rows = vec![
                row(&[
                    "words",
                    "bits",
                    "lobes of light",
                    "leaf A",
                    "leaf B",
                    "everything, B",
                    "thesis: lobes",
                    "A",
                    "B",
                ]),
                row(&[
                    "none",
                    "864",
                    &format!("{light:.2}"),
                    &format!("{full:.2}"),
                    "",
                    &format!("{:.2}", mb(exact.all())),
                    "1080",
                    "1460",
                    "",
                ]),
            ];
            for (words, thesis) in THESIS {
                let recipe = Recipe::thesis(words);
                let book = lessons::train(&taught, &recipe, run)?;
                let [a, b] =
                    [Leaf::A, Leaf::B].map(|l| Classic::coded(&records, l, &book).counted());
                let over = |own: f64, all: f64| format!("{own:.2} / {:.2}x", all / own);
                let (own, in_a, in_b) = (mb(a.light), mb(a.of_thesis()), mb(b.of_thesis()));
                let [t, ta, tb] = thesis;
                rows.push(vec![
                    words.to_string(),
                    recipe.bits().to_string(),
                    over(own, light),
                    over(in_a, full),
                    over(in_b, full),
                    format!("{:.2}", mb(b.all() - b.tables)),
                    over(t, 1080.0),
                    over(ta, 1460.0),
                    over(tb, 1460.0),
                ]);
                values.push(json!({
                    "scene": scene, "words": words, "lobes_mb": own, "leaf_a_mb": in_a,
                    "leaf_b_mb": in_b, "everything_b_mb": mb(b.all() - b.tables),
                    "table_bytes": b.tables, "thesis_mb": thesis,
                }));
            }
            sheet.add(
                table(&rows),
                format!("{}: {} leaves, scaled to 10M", name_of(scene), records.len()),
            );
            Ok(())
        })?;
    }
    Ok(values)
}

fn leaves(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut values = Vec::new();
    for scene in scenes {
        still(scene, SIZE, &lessons::knobs(), run, |at| {
            let records = leaves_of(at, run)?;
            let mut rows = vec![row(&[
                "leaf",
                "position",
                "colour",
                "normal",
                "area",
                "sum",
                "thesis's sum",
                "position error",
                "colour",
                "normal",
                "area",
            ])];
            for (name, leaf, thesis) in [("A", Leaf::A, 26), ("B", Leaf::B, 16)] {
                let tree = Classic::exact(&records, leaf);
                let bytes = leaf.bytes();
                let errors = tree.leaf_errors(&records);
                let mut cells = vec![name.to_owned()];
                cells.extend(bytes.map(|b| b.to_string()));
                cells.extend([bytes.iter().sum::<usize>().to_string(), thesis.to_string()]);
                cells.extend(errors.map(|e| format!("{e:.1e}")));
                rows.push(cells);
                values.push(
                    json!({ "scene": scene, "leaf": name, "bytes": bytes, "errors": errors }),
                );
            }
            sheet.add(table(&rows), name_of(scene));
            Ok(())
        })?;
    }
    Ok(values)
}

/// The least seconds of two runs.
fn least<T>(mut work: impl FnMut() -> T) -> f64 {
    let one = |_| {
        let start = Instant::now();
        std::hint::black_box(work());
        start.elapsed().as_secs_f64()
    };
    (0..2).map(one).fold(f64::INFINITY, f64::min)
}

fn seconds(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut values = Vec::new();
    for scene in scenes {
        still(scene, SIZE, &lessons::knobs(), run, |at| {
            let records = leaves_of(at, run)?;
            let taught = lessons::of(at, SPARSE, run)?;
            let sparse = stream::lessons(&at.records(&at.points(SPARSE, run)?), stream::LESSONS);
            let (rows, own) = alone(|| {
                let light = at.lighting(DENSE, run)?;
                timed((&records, at.cube(DENSE)), light, &taught, &sparse, run)
            })?;
            sheet.add(table(&rows), format!("{}: {} leaves", name_of(scene), records.len()));
            values.extend(own.into_iter().map(|mut v| {
                v["scene"] = scene.as_str().into();
                v
            }));
            Ok(())
        })?;
    }
    Ok(values)
}

/// Work on one thread.
fn alone<T: Send>(work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

/// Table 6.3 in rows, and as values; `light` are the seconds that leaves take to be lit.
fn timed(
    (records, cube): (&[Record], Cube),
    light: f64,
    taught: &lessons::Nodes,
    sparse: &[stream::Lesson],
    run: &Run,
) -> Result<(Vec<Vec<String>>, Vec<Value>)> {
    const THESIS: [(usize, f64, f64); 3] =
        [(100, 12.25, 101.89), (1000, 17.03, 145.37), (10_000, 22.6, 193.89)];
    const PLAIN: f64 = 49.72;
    let million = 1e6 / records.len() as f64;
    let light = million * light;
    let mut values = vec![json!({ "way": "light", "seconds": light })];
    let mut rows = vec![row(&[
        "words",
        "learning",
        "tree",
        "with light",
        "more",
        "thesis: learning",
        "tree with light",
        "more",
    ])];
    let plain = million * least(|| Classic::exact(records, Leaf::A));
    let line = |name: &str, learned: f64, own: f64, plain: f64| {
        let more = 100.0 * (own - plain) / (light + plain);
        vec![
            name.to_owned(),
            format!("{learned:.2}"),
            format!("{own:.2}"),
            format!("{:.2}", light + own),
            format!("+{more:.0} %"),
        ]
    };
    let value = |name: &str, learned: f64, own: f64, plain: f64| {
        json!({
            "way": name, "learning_seconds": learned, "tree_seconds": own,
            "tree_over_plain": own / plain, "share_of_build": (own - plain) / (light + plain),
        })
    };
    let mut first = line("none", 0.0, plain, plain);
    first.extend(row(&["", &PLAIN.to_string(), "+0 %"]));
    rows.push(first);
    for (words, learning, build) in THESIS {
        let start = Instant::now();
        let book = lessons::train(taught, &Recipe::thesis(words), run)?;
        let learned = start.elapsed().as_secs_f64();
        let own = million * least(|| Classic::coded(records, Leaf::A, &book));
        let mut cells = line(&words.to_string(), learned, own, plain);
        let more = format!("+{:.0} %", 100.0 * (build / PLAIN - 1.0));
        cells.extend([learning.to_string(), build.to_string(), more]);
        rows.push(cells);
        values.push(value(&words.to_string(), learned, own, plain));
    }
    let plain = million * least(|| Packed::build(records));
    rows.push(line("ours, none", 0.0, plain, plain));
    for (name, recipe) in [
        ("ours, 1000", Recipe::clusters(1000)),
        ("ours, 10 000", Recipe::clusters(10_000)),
        ("ours, default", Recipe::default()),
    ] {
        let start = Instant::now();
        let book = stream::taught(sparse, &recipe, run)?;
        let learned = start.elapsed().as_secs_f64();
        let own = million * least(|| stream::coded_in_memory(records, cube, &book));
        rows.push(line(name, learned, own, plain));
        values.push(value(name, learned, own, plain));
    }
    Ok((rows, values))
}

/// Resident bytes, looked at again and again while work is done; seconds and bytes above the start.
fn watched<T>(work: impl FnOnce() -> T) -> (T, Vec<[f64; 2]>) {
    let done = AtomicBool::new(false);
    let before = resident_bytes();
    std::thread::scope(|scope| {
        let watch = scope.spawn(|| {
            let start = Instant::now();
            let mut seen = vec![[0.0, 0.0]];
            while !done.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(2));
                let more = resident_bytes().saturating_sub(before) as f64;
                seen.push([start.elapsed().as_secs_f64(), more / 1e6]);
            }
            seen
        });
        let result = work();
        done.store(true, Ordering::Relaxed);
        (result, watch.join().unwrap_or_default())
    })
}

fn curve(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut values = Vec::new();
    for scene in scenes {
        still(scene, SIZE, &lessons::knobs(), run, |at| {
            let records = at.sides(&at.points(4 * DENSE, run)?);
            let book = lessons::book(at, SPARSE, &Recipe::thesis(1000), run)?;
            let (coded, fly) = watched(|| Classic::coded(&records, Leaf::B, &book));
            let (alive, bytes) = (coded.alive(), coded.counted().all());
            let (whole, floats) = watched(|| Classic::exact(&records, Leaf::B));
            let most = |points: &[[f64; 2]]| points.iter().map(|p| p[1]).fold(0.0, f64::max);
            values.push(json!({
                "scene": scene, "leaves": records.len(), "peak_mb_on_the_fly": most(&fly),
                "tree_mb": bytes as f64 / 1e6, "peak_mb_floats": most(&floats),
                "floats_mb": whole.counted().all() as f64 / 1e6, "lobes_alive_a_worker": alive,
            }));
            drop(whole);
            let text = format!(
                "{}: {} leaves; at most {alive} lobes in floats were alive for a worker",
                name_of(scene),
                records.len()
            );
            let one = |name: &str, k: usize, points| Series {
                name: name.into(),
                colour: COLOURS[k],
                points,
                joined: true,
            };
            let series =
                vec![one("lobes in floats", 1, floats), one("quantized on the fly", 0, fly)];
            let x = Axis { name: "seconds", scale: Scale::Linear };
            let y = Axis { name: "resident megabytes", scale: Scale::Linear };
            sheet.add(Chart { x, y, series }.draw((760, 420)), text);
            Ok(())
        })?;
    }
    Ok(values)
}

/// A code on the chart.
struct Way {
    name: String,
    family: usize,
    bytes: f64,
    psnr: Option<f64>,
    p99: f64,
    /// Whether it is the default.
    chosen: bool,
}

impl Way {
    /// Bytes and how near the picture is, where it is not the same.
    fn near(&self) -> Option<[f64; 2]> {
        Some([self.bytes, self.psnr?])
    }

    /// Bytes and how far nodes are, in percent.
    fn far(&self) -> Option<[f64; 2]> {
        Some([self.bytes, 100.0 * self.p99])
    }
}

/// Families of codes of nodes over blocks.
const CODES: std::ops::Range<usize> = 1..6;

/// The front of the codes: the most decibels, and the least errors in logarithms, for their bytes.
fn fronts(all: &[Way]) -> [Vec<[f64; 2]>; 2] {
    let codes = || all.iter().filter(|w| CODES.contains(&w.family));
    let near: Vec<[f64; 2]> = codes().filter_map(Way::near).collect();
    let far: Vec<[f64; 2]> = codes().filter_map(Way::far).map(|[x, y]| [x, -y.ln()]).collect();
    [front(&near), front(&far).into_iter().map(|[x, y]| [x, (-y).exp()]).collect()]
}

/// Whether a point lies on a front.
fn is_on(front: &[[f64; 2]], point: Option<[f64; 2]>) -> bool {
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
    point.is_some_and(|[x, y]| front.iter().any(|p| same(p[0], x) && same(p[1], y)))
}

const FAMILIES: [&str; 7] = [
    "thesis: tree, leaf B",
    "thesis: raw sums",
    "k-means over area",
    "residual, one gain",
    "residual, gain a colour",
    "colour x shape",
    "half floats",
];

fn ways() -> Vec<(usize, String, Recipe)> {
    let mut all = Vec::new();
    for k in [1000, 10_000] {
        all.push((1, format!("{k}"), Recipe::raw(k)));
        all.push((2, format!("{k}"), Recipe::clusters(k)));
    }
    for (light, area) in [(2, 2), (3, 2), (4, 3)] {
        let name = |turned| format!("{light}+{area}{turned}");
        all.push((3, name(""), Recipe::residual(Gains::One, false, light, area)));
        all.push((3, name(" turned"), Recipe::residual(Gains::One, true, light, area)));
        all.push((4, name(""), Recipe::residual(Gains::Colours, false, light, area)));
        all.push((4, name(" turned"), Recipe::residual(Gains::Colours, true, light, area)));
    }
    all.push((5, "4096".into(), Recipe::shapes(4096, 4096)));
    all.push((5, "2x8".into(), Recipe::residual(Gains::Shape, true, 2, 2)));
    all
}

fn rate(scenes: &[String], sheet: &mut Sheet, run: &Run) -> Result<Vec<Value>> {
    let mut values = Vec::new();
    for scene in scenes {
        let knobs = LightKnobs { bounces: 1, edges: 2, ..LightKnobs::default() };
        still(scene, SIZE, &knobs, run, |at| {
            let all = compared(at, run)?;
            let fronts = fronts(&all);
            for (part, families) in [("", 0..FAMILIES.len()), (", the codes alone", CODES)] {
                let title = format!("{}{part}", name_of(scene));
                let both = charts(&all, &fronts, families).into_iter();
                for (chart, title) in both.zip([title, String::new()]) {
                    sheet.add(chart.draw((640, 400)), title);
                }
            }
            values.extend(all.iter().map(|w| {
                json!({
                    "scene": scene, "family": FAMILIES[w.family], "code": w.name,
                    "bytes_per_surfel": w.bytes, "psnr_db": w.psnr, "p99_node_error": w.p99,
                    "default": w.chosen, "on_front_of_psnr": is_on(&fronts[0], w.near()),
                    "on_front_of_p99": is_on(&fronts[1], w.far()),
                })
            }));
            Ok(())
        })?;
    }
    Ok(values)
}

/// Families of codes against decibels, and against node errors, with the front and the default.
fn charts(
    all: &[Way],
    fronts: &[Vec<[f64; 2]>; 2],
    families: std::ops::Range<usize>,
) -> [Chart; 2] {
    let series = |front: &[[f64; 2]], point: fn(&Way) -> Option<[f64; 2]>| -> Vec<Series> {
        let one = |name: &str, colour, points| Series {
            name: name.into(),
            colour,
            points,
            joined: false,
        };
        let line = Series { joined: true, ..one("front of the codes", [0.7; 3], front.to_vec()) };
        let of = |family: usize| {
            let points = all.iter().filter(|w| w.family == family).filter_map(point).collect();
            one(FAMILIES[family], COLOURS[family], points)
        };
        let chosen = all.iter().filter(|w| w.chosen).filter_map(point).collect();
        let last = one("the default", COLOURS[7], chosen);
        [line].into_iter().chain(families.clone().map(of)).chain([last]).collect()
    };
    let x = || Axis { name: "bytes a surfel", scale: Scale::Linear };
    let decibels = Axis { name: "dB of the picture", scale: Scale::Linear };
    let errors = Axis { name: "p99 node error, %", scale: Scale::Log };
    [
        Chart { x: x(), y: decibels, series: series(&fronts[0], Way::near) },
        Chart { x: x(), y: errors, series: series(&fronts[1], Way::far) },
    ]
}

/// All codes on one scene.
fn compared(at: &Still, run: &Run) -> Result<Vec<Way>> {
    let mut points = at.points(DENSE, run)?;
    let (records, cube) = (at.records(&points), at.cube(DENSE));
    let sparse = at.records(&at.points(SPARSE, run)?);
    let lessons = stream::lessons(&sparse, stream::LESSONS);
    let mut nodes = Vec::new();
    let exact = Packed::build(&records);
    exact.each_node(|node, sums| {
        nodes.push(stream::Lesson { area: node.area, axis: node.axis, sums: *sums });
    });
    let half = exact.with_lobes(|_, lobes| halved(lobes));
    points.tree = Box::new(exact);
    let truth = at.shown(&at.seen(&points, run)?, false);
    let mut all = Vec::new();
    let surfels = DENSE as f64;
    points.tree = Box::new(half);
    let near = nearness(&at.shown(&at.seen(&points, run)?, false), &truth)?;
    let coded = |book: &Book| -> Result<(Packed<Compact>, f64)> {
        let tree = stream::coded_in_memory(&records, cube, book)?;
        let bytes = tree.store.bytes() - tree.store.format.book.size();
        Ok((tree, bytes as f64 / surfels))
    };
    let plain = Recipe::clusters(16);
    let floats = coded(&stream::taught(&lessons, &plain, run)?)?.1;
    let floats = floats + (72 - plain.bytes()) as f64 * nodes.len() as f64 / surfels;
    let (name, psnr) = ("half floats".to_owned(), near.psnr);
    all.push(Way { name, family: 6, bytes: floats, psnr, p99: 5e-4, chosen: false });
    for (family, name, recipe) in ways() {
        let book = stream::taught(&lessons, &recipe, run)?;
        let mut own: Vec<f64> = nodes
            .iter()
            .map(|n| book.error(&n.lobes(), &mut Pen::default()))
            .filter(|[_, there]| *there > 0.0)
            .map(|[wrong, there]| (wrong / there).sqrt())
            .collect();
        own.sort_by(f64::total_cmp);
        let p99 = own.get(own.len() * 99 / 100).copied().unwrap_or(0.0);
        let (tree, bytes) = coded(&book)?;
        points.tree = Box::new(tree);
        let near = nearness(&at.shown(&at.seen(&points, run)?, false), &truth)?;
        let chosen = recipe == Recipe::default();
        all.push(Way { name, family, bytes, psnr: near.psnr, p99, chosen });
    }
    // The thesis's own tree, against itself in floats.
    let taught = lessons::of(at, SPARSE, run)?;
    let records = at.sides(&points);
    points.tree = Box::new(Classic::exact(&records, Leaf::B));
    let truth = at.shown(&at.seen(&points, run)?, false);
    for words in [1000, 10_000] {
        let book = lessons::train(&taught, &Recipe::thesis(words), run)?;
        let tree = Classic::coded(&records, Leaf::B, &book);
        let counted = tree.counted();
        let bytes = (counted.all() - counted.tables) as f64 / surfels;
        points.tree = Box::new(tree);
        let near = nearness(&at.shown(&at.seen(&points, run)?, false), &truth)?;
        let nodes = lessons::nodes(&Classic::exact(&records, Leaf::B));
        let p99 = lessons::p99_error(&nodes, &book);
        let (name, psnr) = (words.to_string(), near.psnr);
        all.push(Way { name, family: 0, bytes, psnr, p99, chosen: false });
    }
    Ok(all)
}

/// Eleven bits of each number, exponents as wide as needed.
fn halved(lobes: &Exact) -> Exact {
    let half = |v: f32| f32::from_bits((v.to_bits() + (1 << 12)) & !((1 << 13) - 1));
    Exact { area: lobes.area.map(half), light: lobes.light.map(|l| l.map(half)) }
}
