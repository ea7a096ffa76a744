//! Brushes on known lines: coverage, joints, loops, crossings, haloes, and what travels with u.

use chiaro_basis::Knobs;
use chiaro_basis::math::Vec2;
use chiaro_image::Plane;
use chiaro_ink::brush::{Axis, Brush, Grain, Knot, Mark, Side, Spine, Stroke, paint, ribbons};

const BLACK: [f32; 4] = [0.0, 0.0, 0.0, 1.0];
const WHITE: [f32; 4] = [1.0; 4];

fn brush(sets: &[(&str, &str)]) -> Brush {
    let mut brush = Brush { smooth: 0.0, slender: 0.0, ..Brush::default() };
    sets.iter().for_each(|(k, v)| brush.set(k, v).expect("a knob of brushes"));
    brush
}

fn spine(points: &[[f32; 2]], shift: f64) -> Spine {
    let mut u = shift;
    let mut last: Option<Vec2> = None;
    let knots = points.iter().map(|p| {
        let at = Vec2::from(*p);
        u += last.map_or(0.0, |l| f64::from(l.distance(at)));
        last = Some(at);
        Knot { at, u, depth: 0.0 }
    });
    Spine::new(knots.collect(), false, Axis { seed: 4, period: None })
}

/// A circle about (60, 60); `start` turns where it closes, u goes with it.
fn ring(radius: f32, start: usize) -> Spine {
    let n = 96;
    let period = f64::from(radius) * std::f64::consts::TAU;
    let knot = |i: usize| {
        let turn = (start + i) as f64 / n as f64;
        let a = (turn * std::f64::consts::TAU) as f32;
        Knot { at: Vec2::splat(60.0) + radius * Vec2::from_angle(a), u: turn * period, depth: 0.0 }
    };
    Spine::new((0..=n).map(knot).collect(), true, Axis { seed: 4, period: Some(period) })
}

fn draw(strokes: &[(&Spine, &Brush)], size: (usize, usize)) -> Plane<f32> {
    let (texture, colour, hides, right) = (None, BLACK, false, false);
    let strokes = strokes.iter().copied();
    let strokes: Vec<Stroke<'_>> = strokes
        .map(|(spine, brush)| Stroke { spine, brush, texture, colour, hides, right })
        .collect();
    paint(&strokes, &Plane::filled(size.0, size.1, WHITE), WHITE).map(|p| 1.0 - p[0])
}

fn difference(a: &Plane<f32>, b: &Plane<f32>) -> f32 {
    a.pixels().iter().zip(b.pixels()).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max)
}

#[test]
fn a_line_covers_its_width() {
    for width in [0.5f32, 1.0, 1.7, 4.0, 9.0] {
        let brush = brush(&[("width", &width.to_string()), ("cap", "flat")]);
        for slope in [0.0, 0.37] {
            let line = spine(&[[10.0, 30.3], [110.0, 30.3 + 100.0 * slope]], 0.0);
            let total: f32 = draw(&[(&line, &brush)], (120, 120)).pixels().iter().sum();
            let area = width * line.length();
            assert!((total / area - 1.0).abs() < 0.06, "{width} {slope}: {total} for {area}");
        }
    }
}

#[test]
fn no_joint_bend_or_crossing_is_darker_or_open() {
    let mut wide = brush(&[("width", "10"), ("opacity", "0.5")]);
    // A hairpin, a loop over itself, and a sharp corner.
    let hairpin: Vec<[f32; 2]> = (0..60)
        .map(|i| i as f32 / 59.0 * 3.1)
        .map(|a| [60.0 + 4.0 * a.cos() * 10.0, 40.0 + 3.0 * a.sin()])
        .collect();
    let eight: Vec<[f32; 2]> = (0..=120)
        .map(|i| i as f32 / 120.0 * 6.2)
        .map(|a| [60.0 + 40.0 * a.sin(), 60.0 + 30.0 * (2.0 * a).sin()])
        .collect();
    let corner = vec![[20.0, 100.0], [60.0, 20.0], [70.0, 100.0]];
    for points in [hairpin, eight, corner] {
        let line = spine(&points, 0.0);
        let cover = draw(&[(&line, &wide)], (120, 120));
        let most = cover.pixels().iter().fold(0.0f32, |m, c| m.max(*c));
        assert!(most < 0.501, "{most}");
        wide.opacity = 1.0;
        let full = draw(&[(&line, &wide)], (120, 120));
        for knot in &line.knots {
            for way in 0..8 {
                let at = knot.at + 3.5 * Vec2::from_angle(way as f32 * 0.785);
                assert!(full[(at.x as usize, at.y as usize)] > 0.97, "a gap at {at}");
            }
        }
        wide.opacity = 0.5;
    }
}

#[test]
fn grain_is_no_denser_where_a_line_lies_over_itself() {
    let zigzag: Vec<[f32; 2]> =
        (0..20).map(|i| [12.0 + 3.0 * i as f32, if i % 2 == 0 { 50.0 } else { 66.0 }]).collect();
    let straight = vec![[10.0, 60.0], [110.0, 60.0]];
    for grain in ["charcoal", "pencil", "bristle", "wash"] {
        let brush =
            |grain: &str| brush(&[("width", "10"), ("grain", grain), ("grain_size", "1.3")]);
        let density = |points: &[[f32; 2]]| {
            let line = spine(points, 0.0);
            let ink = |grain: &str| {
                draw(&[(&line, &brush(grain))], (120, 120)).pixels().iter().sum::<f32>()
            };
            ink(grain) / ink("solid")
        };
        let more = density(&zigzag) / density(&straight);
        assert!((0.85..1.1).contains(&more), "{grain}: {more} times as dense");
    }
}

#[test]
fn a_loop_does_not_show_where_it_closes() {
    for sets in [
        &[("width", "7"), ("pressure", "0.8"), ("grain", "charcoal"), ("rough", "1")][..],
        &[("width", "6"), ("grain", "bristle"), ("wobble", "2")],
        &[("mark", "dashes"), ("spacing", "11"), ("jitter", "0.5")],
        &[("mark", "dots"), ("jitter", "0.3")],
        &[("mark", "thorns"), ("jitter", "0.6")],
        &[("mark", "fur"), ("spacing", "3")],
        &[("mark", "double")],
    ] {
        let brush = brush(sets);
        let (here, there) = (ring(40.0, 0), ring(40.0, 31));
        let (a, b) = (draw(&[(&here, &brush)], (120, 120)), draw(&[(&there, &brush)], (120, 120)));
        let off = difference(&a, &b);
        assert!(off < 0.12, "{sets:?}: {off}");
    }
}

#[test]
fn marks_stay_on_their_line_where_u_leaps_and_falls() {
    // As methods without a future leave it: a loop whose u goes back by a whole period halfway round.
    let mut back = ring(40.0, 0);
    let period = back.axis.period.expect("it closes");
    back.knots[50..].iter_mut().for_each(|k| k.u -= period);
    // And one that runs backwards for a third of its way.
    let mut falls = ring(40.0, 0);
    let turn = |u: f64| if u < 32.0 { u } else { (64.0 - u).max(u - 64.0) };
    falls.knots.iter_mut().enumerate().for_each(|(i, k)| k.u = 2.5 * turn(i as f64));
    for spine in [back, falls] {
        for sets in [
            &[("mark", "dashes"), ("spacing", "9"), ("width", "3")][..],
            &[("mark", "dots"), ("spacing", "9"), ("size", "4")],
            &[("mark", "thorns"), ("spacing", "9"), ("size", "6"), ("lean", "0")],
        ] {
            let brush = brush(sets);
            let all = ribbons(&brush, &spine);
            let marks = all.iter().filter(|r| !r.closed);
            let ribs: Vec<Vec2> = marks.flat_map(|r| &r.ribs).map(|r| r.at).collect();
            let off = |p: &Vec2| (p.distance(Vec2::splat(60.0)) - 40.0).abs();
            assert!(ribs.iter().all(|p| off(p) < 7.0), "{sets:?}: a mark leaves the line");
            for way in 0..24 {
                let on = Vec2::splat(60.0) + 40.0 * Vec2::from_angle(way as f32 * 0.2618);
                let near = ribs.iter().any(|p| p.distance(on) < 13.0);
                assert!(near, "{sets:?}: nothing at {on}");
            }
            let thorns = all.iter().filter(|r| brush.mark == Mark::Thorns && r.ribs.len() == 7);
            let tips: Vec<f32> = thorns.map(|r| r.ribs[6].at.distance(Vec2::splat(60.0))).collect();
            let outside = tips.iter().filter(|r| **r > 40.0).count();
            assert!(outside == 0 || outside == tips.len(), "{outside} of {} stand out", tips.len());
        }
    }
}

#[test]
fn marks_are_as_large_where_a_line_goes_on() {
    let brush = brush(&[("mark", "dots"), ("spacing", "10"), ("size", "4"), ("jitter", "0")]);
    let line: Vec<[f32; 2]> = (0..=20).map(|i| [3.0 * i as f32, 30.0]).collect();
    let sizes = |goes_on: [bool; 2]| -> Vec<f32> {
        let spine = Spine { goes_on, ..spine(&line, 6.0) };
        ribbons(&brush, &spine).iter().map(|r| r.ribs[0].half).collect()
    };
    let [alone, joined] = [sizes([false; 2]), sizes([true; 2])];
    assert!(alone[0] < 1.9 && (joined[0] - 2.0).abs() < 1e-3, "{alone:?} {joined:?}");
}

#[test]
fn marks_stick_to_u_while_the_ends_move() {
    let whole: Vec<[f32; 2]> = (0..=38).map(|i| [3.0 + 3.0 * i as f32, 30.0]).collect();
    for sets in [
        &[("width", "6"), ("pressure", "0.7"), ("grain", "charcoal"), ("rough", "1")][..],
        &[("mark", "dashes")],
        &[("mark", "dots"), ("jitter", "0.4")],
        &[("mark", "thorns")],
        &[("mark", "fur"), ("spacing", "3")],
    ] {
        let brush = brush(sets);
        let long = spine(&whole, 5.0);
        let short = spine(&whole[8..], 5.0 + 24.0);
        let (a, b) = (draw(&[(&long, &brush)], (120, 60)), draw(&[(&short, &brush)], (120, 60)));
        let right = |p: &Plane<f32>| Plane::from_fn(60, 60, |x, y| p[(x + 58, y)]);
        let off = difference(&right(&a), &right(&b));
        assert!(off < 0.02, "{sets:?}: {off}");
    }
}

#[test]
fn thorns_and_hairs_stand_on_the_asked_side() {
    let line = spine(&[[5.0, 30.0], [60.0, 30.0], [115.0, 30.0]], 0.0);
    for mark in [Mark::Thorns, Mark::Fur] {
        for (side, below) in [(Side::Outside, true), (Side::Inside, false)] {
            let brush = Brush { mark, side, ..brush(&[]) };
            let cover = draw(&[(&line, &brush)], (120, 60));
            let sum = |rows: std::ops::Range<usize>| -> f32 {
                rows.map(|y| cover.row(y).iter().sum::<f32>()).sum()
            };
            let (up, down) = (sum(0..27), sum(33..60));
            assert!(if below { down > 10.0 * up } else { up > 10.0 * down }, "{mark:?} {side:?}");
        }
    }
}

#[test]
fn a_halo_interrupts_what_is_behind_and_nothing_else() {
    let near = spine(&[[60.0, 5.0], [60.0, 30.0], [60.0, 55.0]], 0.0);
    let mut far = spine(&[[5.0, 30.0], [60.0, 30.0], [115.0, 30.0]], 0.0);
    far.knots.iter_mut().for_each(|k| k.depth = 100.0);
    let brush = brush(&[("width", "2"), ("halo", "5")]);
    let gap = |depth: f32, right: bool| {
        let mut far = far.clone();
        far.knots.iter_mut().for_each(|k| k.depth = depth);
        let stroke = |spine, hides| Stroke {
            spine,
            brush: &brush,
            texture: None,
            colour: BLACK,
            hides,
            right,
        };
        let white = Plane::filled(120, 60, WHITE);
        let picture = paint(&[stroke(&far, false), stroke(&near, true)], &white, WHITE);
        [55, 64].map(|x: usize| 1.0 - picture[(x, 29)][0])
    };
    // The near line runs down the picture: its right is on the left of the page.
    assert_eq!(gap(100.0, false), [0.0, 0.0]);
    let [left, right] = gap(100.0, true);
    assert!(left < 0.01 && right > 0.9, "{left} {right}");
    assert!(gap(-100.0, false).iter().all(|c| *c > 0.9));
    assert!(gap(3.0, false).iter().all(|c| *c > 0.9));
}

#[test]
fn a_halo_along_a_line_cuts_it_evenly() {
    // Two lines side by side, the lower one farther away, and half in the upper one's halo.
    let near = spine(&[[5.0, 20.0], [60.0, 28.25], [115.0, 36.5]], 0.0);
    let mut far = spine(&[[5.0, 26.0], [60.0, 34.25], [115.0, 42.5]], 0.0);
    far.knots.iter_mut().for_each(|k| k.depth = 100.0);
    let brush = brush(&[("width", "4"), ("halo", "4")]);
    let stroke = |spine, colour| Stroke {
        spine,
        brush: &brush,
        texture: None,
        colour,
        hides: true,
        right: false,
    };
    let white = Plane::filled(120, 60, WHITE);
    let picture = paint(&[stroke(&far, BLACK), stroke(&near, WHITE)], &white, WHITE);
    let column = |x: usize| (0..60).map(|y| 1.0 - picture[(x, y)][0]).sum::<f32>();
    let columns: Vec<f32> = (20..100).map(column).collect();
    let [least, most] = [f32::min, f32::max].map(|f| columns.iter().copied().reduce(f));
    let [least, most] = [least.unwrap_or_default(), most.unwrap_or_default()];
    assert!(least > 1.5 && most < 3.0 && most - least < 0.2, "{least} to {most}");
}

#[test]
fn the_picture_does_not_depend_on_threads() {
    let brushes = [
        brush(&[("mark", "fur")]),
        brush(&[("grain", "charcoal"), ("width", "9")]),
        brush(&[("mark", "double")]),
    ];
    let lines: Vec<Spine> = (1..9).map(|i| ring(6.0 * i as f32, i)).collect();
    let strokes: Vec<(&Spine, &Brush)> = lines.iter().zip(brushes.iter().cycle()).collect();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| draw(&strokes, (130, 125)))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn odd_spines_are_drawn_or_left_out() {
    let point = |x: f32, u: f64| Knot { at: Vec2::new(x, 9.0), u, depth: 0.0 };
    let axis = Axis { seed: 1, period: None };
    let spines = [
        Spine::default(),
        Spine::new(vec![point(5.0, 0.0)], false, axis),
        Spine::new(vec![point(5.0, 0.0); 4], true, axis),
        Spine::new(vec![point(5.0, 0.0), point(9.0, 0.0), point(12.0, 0.0)], false, axis),
        Spine::new(vec![point(5.0, 1e18), point(9.0, 2e18)], false, axis),
        Spine::new(vec![point(5.0, 3.0), point(1e7, 9.0)], false, axis),
        Spine::new(vec![point(f32::NAN, 3.0), point(5.0, f64::NAN)], false, axis),
    ];
    for mark in Mark::WORDS {
        for grain in Grain::WORDS {
            let brush = brush(&[("mark", mark), ("grain", grain), ("rough", "1"), ("wobble", "3")]);
            for spine in &spines {
                let cover = draw(&[(spine, &brush)], (20, 20));
                assert!(cover.pixels().iter().all(|c| (0.0..=1.0).contains(c)));
                assert!(ribbons(&brush, spine).len() < 30_000);
            }
        }
    }
}
