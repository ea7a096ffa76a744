//! The solver against the oracle and closed forms.

mod oracle;

use chiaro_mincut::{Grid, GridError, MAX_NEIGHBOUR, MAX_PIXELS, energy, solve, solve_on};
use proptest::prelude::*;

/// A grid that owns its capacities.
#[derive(Clone, Debug)]
struct Problem {
    width: usize,
    height: usize,
    mask: Vec<bool>,
    terminal: Vec<[i32; 2]>,
    neighbour: Vec<[i32; 4]>,
}

impl Problem {
    fn uniform(width: usize, height: usize, terminal: [i32; 2], neighbour: i32) -> Self {
        let pixels = width * height;
        Self {
            width,
            height,
            mask: vec![true; pixels],
            terminal: vec![terminal; pixels],
            neighbour: vec![[neighbour; 4]; pixels],
        }
    }

    fn grid(&self) -> Grid<'_> {
        Grid {
            width: self.width,
            height: self.height,
            mask: &self.mask,
            terminal: &self.terminal,
            neighbour: &self.neighbour,
        }
    }

    /// Same flow, same canonical labels, and the flow is the cut.
    fn agrees(&self) {
        let cut = solve(&self.grid()).expect("the strategy keeps to the bounds");
        let (labels, flow) = oracle::solve(&(&self.grid()).into());
        assert_eq!((cut.flow, cut.cut), (flow, flow));
        assert_eq!(cut.labels, labels);
        assert_eq!(energy(&self.grid(), &labels), flow);
    }
}

/// Capacities from nothing but ties to the largest allowed; `zeros` in 4 are zero.
fn capacity(largest: i32, zeros: u32) -> impl Strategy<Value = i32> + Clone {
    prop_oneof![zeros => Just(0), (4 - zeros) => 0..=largest]
}

fn problem() -> impl Strategy<Value = Problem> {
    let largest = prop::sample::select(vec![1, 3, 20, 1000, 16383, 40_000, MAX_NEIGHBOUR]);
    let ratio = prop::sample::select(vec![1, 4, 16]);
    (1..=12_usize, 1..=12_usize, largest, ratio, 0..4_u32, 0..4_u32, 1..=10_u32).prop_flat_map(
        |(width, height, largest, ratio, no_terminal, no_neighbour, masked)| {
            let pixels = width * height;
            let terminal = capacity(largest.saturating_mul(ratio), no_terminal);
            let neighbour = capacity(largest, no_neighbour);
            let mask = prop::bool::weighted(f64::from(masked) / 10.0);
            (
                prop::collection::vec(mask, pixels),
                prop::collection::vec(prop::array::uniform2(terminal), pixels),
                prop::collection::vec(prop::array::uniform4(neighbour), pixels),
            )
                .prop_map(move |(mask, terminal, neighbour)| Problem {
                    width,
                    height,
                    mask,
                    terminal,
                    neighbour,
                })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn random_grids_match_the_oracle(problem in problem()) {
        problem.agrees();
    }
}

/// A hash with the look of noise: the same on every machine.
fn noise(x: usize, y: usize, salt: usize) -> i32 {
    let mut h = (x * 0x9e37_79b1 + y * 0x85eb_ca6b + salt * 0xc2b2_ae35) as u32;
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    ((h ^ (h >> 15)) >> 8) as i32
}

#[test]
fn wide_textures_with_long_paths_match_the_oracle() {
    for (seed, cell) in [(1, 1), (2, 3), (3, 8), (4, 16)] {
        let mut problem = Problem::uniform(61, 47, [0, 0], 30);
        for i in 0..problem.mask.len() {
            let (x, y) = (i % 61, i / 61);
            problem.terminal[i] = [0, 1].map(|k| noise(x / cell, y / cell, seed + 10 * k) % 90);
            problem.neighbour[i] = [0, 1, 2, 3].map(|k| noise(x, y, seed + 20 + k) % 60);
            problem.mask[i] = noise(x / 4, y / 4, seed + 40) % 10 != 0;
        }
        problem.agrees();
    }
}

#[test]
fn bands_on_any_number_of_threads_give_the_same_cut() {
    for (seed, cell, bond) in [(1, 1, 60), (2, 5, 60), (3, 40, 200), (4, 90, 20_000)] {
        let (width, height) = (11, 300);
        let mut problem = Problem::uniform(width, height, [0, 0], 0);
        for i in 0..problem.mask.len() {
            let (x, y) = (i % width, i / width);
            problem.terminal[i] = [0, 1].map(|k| noise(x / cell, y / cell, seed + 10 * k) % 90);
            problem.neighbour[i] = [0, 1, 2, 3].map(|k| noise(x, y, seed + 20 + k) % bond);
            problem.mask[i] = noise(x / 4, y / 4, seed + 40) % 10 != 0;
        }
        problem.agrees();
        let one = solve(&problem.grid()).unwrap();
        for threads in [0, 2, 3, 8, 1000] {
            assert_eq!(solve_on(&problem.grid(), threads).unwrap(), one);
        }
    }
}

#[test]
fn degenerate_sizes_have_a_cut() {
    for (width, height) in [(0, 0), (0, 7), (7, 0), (1, 1), (1, 9), (9, 1), (2, 2)] {
        Problem::uniform(width, height, [3, 1], 2).agrees();
        Problem::uniform(width, height, [1, 3], 2).agrees();
    }
}

#[test]
fn an_empty_mask_is_black_and_free() {
    let mut problem = Problem::uniform(5, 4, [9, 1], 7);
    problem.mask.fill(false);
    let cut = solve(&problem.grid()).unwrap();
    assert_eq!((cut.flow, cut.cut), (0, 0));
    assert_eq!(cut.labels, [false; 20]);
}

#[test]
fn without_neighbours_each_pixel_takes_its_cheaper_side_and_ties_are_black() {
    let mut problem = Problem::uniform(3, 1, [0, 0], 0);
    problem.terminal = vec![[5, 2], [2, 5], [4, 4]];
    let cut = solve(&problem.grid()).unwrap();
    assert_eq!(cut.labels, [true, false, false]);
    assert_eq!(cut.flow, 2 + 2 + 4);
}

#[test]
fn a_strip_is_cut_at_its_weakest_bond() {
    let mut problem = Problem::uniform(30, 1, [0, 0], 50);
    (problem.terminal[0], problem.terminal[29]) = ([1000, 0], [0, 1000]);
    problem.neighbour[17][0] = 8;
    let cut = solve(&problem.grid()).unwrap();
    assert_eq!(cut.flow, 8);
    assert_eq!(cut.labels, (0..30).map(|x| x <= 17).collect::<Vec<_>>());
}

#[test]
fn of_equal_bonds_the_canonical_cut_takes_the_first_from_white() {
    let mut problem = Problem::uniform(30, 1, [0, 0], 8);
    (problem.terminal[0], problem.terminal[29]) = ([1000, 0], [0, 1000]);
    let cut = solve(&problem.grid()).unwrap();
    assert_eq!(cut.labels, (0..30).map(|x| x == 0).collect::<Vec<_>>());
}

#[test]
fn a_square_of_white_survives_only_if_its_area_outweighs_its_border() {
    // A side of n pays n * n * gain to turn; its border of bond 1 costs 4n straight bonds and
    // 2 * (4n - 2) diagonal ones.
    for (side, gain) in [(4, 2), (4, 3), (4, 4), (8, 1), (8, 2), (10, 1), (13, 1)] {
        let mut problem = Problem::uniform(20, 20, [0, 1000], 1);
        for i in 0..400 {
            let inside = [i % 20, i / 20].into_iter().all(|c| (3..3 + side).contains(&c));
            if inside {
                problem.terminal[i] = [gain, 0];
            }
        }
        let (area, border) = (side * side * gain as usize, 12 * side - 4);
        let cut = solve(&problem.grid()).unwrap();
        assert_eq!(cut.flow, energy(&problem.grid(), &cut.labels));
        if area > border {
            assert!(cut.labels[3 * 20 + 3 + side / 2], "{side} {gain}");
        }
        problem.agrees();
    }
}

#[test]
fn a_serpentine_corridor_carries_its_flow_to_the_end() {
    // One corridor over the whole picture: the longest path a mask can make.
    let (width, height) = (41, 41);
    let mut problem = Problem::uniform(width, height, [0, 0], 5);
    for y in (1..height).step_by(2) {
        let open = if y % 4 == 1 { width - 1 } else { 0 };
        (0..width).filter(|&x| x != open).for_each(|x| problem.mask[y * width + x] = false);
    }
    problem.terminal[0] = [3, 0];
    problem.terminal[width * height - 1] = [0, 4];
    let cut = solve(&problem.grid()).unwrap();
    assert_eq!(cut.flow, 3);
    assert!(cut.labels.iter().all(|&white| !white));
    problem.agrees();
}

#[test]
fn what_is_wrong_is_said_in_one_sentence() {
    let good = Problem::uniform(4, 3, [1, 2], 3);
    let error = |change: &dyn Fn(&mut Problem)| {
        let mut problem = good.clone();
        change(&mut problem);
        solve(&problem.grid()).unwrap_err()
    };
    let cases = [
        (error(&|p| p.mask.truncate(5)), GridError::Length { slice: "mask", got: 5, expected: 12 }),
        (error(&|p| p.terminal[6][1] = -4), GridError::Negative { x: 2, y: 1, got: -4 }),
        (
            error(&|p| p.neighbour[11][2] = i32::MIN),
            GridError::Negative { x: 3, y: 2, got: i32::MIN },
        ),
        (
            error(&|p| p.neighbour[1][3] = MAX_NEIGHBOUR + 1),
            GridError::TooLarge { x: 1, y: 0, got: MAX_NEIGHBOUR + 1 },
        ),
        (
            error(&|p| (p.width, p.height) = (usize::MAX, 2)),
            GridError::TooManyPixels { width: usize::MAX, height: 2 },
        ),
        (
            error(&|p| (p.width, p.height) = (MAX_PIXELS + 1, 1)),
            GridError::TooManyPixels { width: MAX_PIXELS + 1, height: 1 },
        ),
    ];
    for (got, expected) in cases {
        assert_eq!(got, expected);
        assert!(!got.to_string().contains('\n') && got.to_string().len() > 20);
    }
}
