//! Families of cuts against cuts one by one, and labellings against all there are.

use chiaro_mincut::{
    Distance, Family, Grid, LabelError, LabelGrid, LabelStack, Labelling, Lattice, Links,
    Neighbours, Solver, TimeLink, expand, expand_stack, solve, solve_ordered,
};
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

fn problem() -> impl Strategy<Value = Problem> {
    let most = prop::sample::select(vec![(3, 2), (20, 20), (400, 30), (60_000, 9000)]);
    (1..=9_usize, 1..=9_usize, most, 2..=10_u32).prop_flat_map(
        |(width, height, (most, bond), masked)| {
            let pixels = width * height;
            let mask = prop::bool::weighted(f64::from(masked) / 10.0);
            (
                prop::collection::vec(mask, pixels),
                prop::collection::vec([0..=most, 0..=most], pixels),
                prop::collection::vec(prop::array::uniform4(0..=bond), pixels),
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

impl Problem {
    fn grid(&self) -> Grid<'_> {
        Grid {
            width: self.width,
            height: self.height,
            mask: &self.mask,
            terminal: &self.terminal,
            neighbour: &self.neighbour,
        }
    }

    fn shifted(&self, shift: i32) -> Self {
        let pull = |&[white, black]: &[i32; 2]| white - black + shift;
        let terminal = self.terminal.iter().map(pull).map(|p| [p.max(0), (-p).max(0)]).collect();
        Self { terminal, ..self.clone() }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..Default::default() })]

    #[test]
    fn every_member_of_a_family_is_the_cut_of_its_shift(
        problem in problem(), first in -70..40_i32, count in 0..90_i32, stride in 1..7_i32,
    ) {
        let last = first + count * stride - 1;
        let family = Family::new(&problem.grid(), first..=last).unwrap();
        for shift in (first..=last).step_by(stride as usize) {
            let cut = solve(&problem.shifted(shift).grid()).unwrap();
            prop_assert_eq!(family.labels(shift), cut.labels, "shift {}", shift);
        }
    }
}

#[test]
fn a_family_holds_the_extremes_of_its_shifts() {
    let problem = Problem {
        width: 3,
        height: 1,
        mask: vec![true, true, false],
        terminal: vec![[i32::MAX, 0], [0, i32::MAX], [9, 0]],
        neighbour: vec![[5, 0, 0, 0]; 3],
    };
    let family = Family::new(&problem.grid(), i32::MIN..=i32::MAX).unwrap();
    assert_eq!(family.breakpoints(), [-i32::MAX + 6, i32::MAX - 4, i32::MAX]);
    assert_eq!(family.labels(0), [true, false, false]);
    assert_eq!(family.labels(i32::MAX - 1), [true, true, false]);
    let none = Family::new(&problem.grid(), std::ops::RangeInclusive::new(1, 0)).unwrap();
    assert_eq!(none.breakpoints(), [i32::MAX; 3]);
}

/// A label problem that owns its parts, small enough to try every labelling.
#[derive(Clone, Debug)]
struct Labels {
    width: usize,
    height: usize,
    labels: usize,
    mask: Vec<bool>,
    data: Vec<i32>,
    neighbour: Vec<[i32; 4]>,
    tones: Vec<i32>,
    convex: Vec<i32>,
}

fn labels() -> impl Strategy<Value = Labels> {
    let size = prop::sample::select(vec![(1, 1), (2, 2), (3, 2), (2, 3), (5, 1)]);
    (size, 1..=4_usize, prop::bool::ANY, 1..=12_i32).prop_flat_map(
        |((width, height), labels, is_convex, bond)| {
            let pixels = width * height;
            (
                prop::collection::vec(prop::bool::weighted(0.9), pixels),
                prop::collection::vec(prop::collection::vec(0..=20_i32, labels), pixels),
                prop::collection::vec(prop::array::uniform4(0..=bond), pixels),
                prop::collection::vec(1..=3_i32, labels),
                prop::collection::vec(0..=3_i32, labels),
            )
                .prop_map(move |(mask, data, neighbour, steps, bends)| {
                    let tones: Vec<i32> = steps
                        .iter()
                        .scan(-5, |t, s| {
                            *t += s;
                            Some(*t)
                        })
                        .collect();
                    let data = data.into_iter().flat_map(|prices| {
                        // Squares around a tone are convex; the prices themselves need not be.
                        let squares = |t: &i32| (t + prices[0] / 2).pow(2);
                        if is_convex { tones.iter().map(squares).collect() } else { prices }
                    });
                    let (mut slope, mut value) = (0, 0);
                    let convex = bends.iter().map(|bend| {
                        let here = value;
                        slope += bend;
                        value += slope;
                        here
                    });
                    Labels {
                        width,
                        height,
                        labels,
                        mask,
                        neighbour,
                        data: data.collect(),
                        convex: convex.collect(),
                        tones: tones.clone(),
                    }
                })
        },
    )
}

impl Labels {
    fn grid<'a>(&'a self, distance: Distance<'a>) -> LabelGrid<'a> {
        LabelGrid {
            width: self.width,
            height: self.height,
            labels: self.labels,
            mask: &self.mask,
            data: &self.data,
            neighbour: &self.neighbour,
            distance,
        }
    }
}

/// The least energy, and the lowest labels that have it, by trying all.
fn best(grid: &LabelGrid) -> Labelling {
    let nodes: Vec<usize> = (0..grid.mask.len()).filter(|&p| grid.mask[p]).collect();
    let mut best = Labelling { labels: Vec::new(), energy: i64::MAX };
    for code in 0..grid.labels.pow(nodes.len() as u32) {
        let mut labels = vec![0; grid.mask.len()];
        let mut rest = code;
        for &p in &nodes {
            labels[p] = (rest % grid.labels) as u8;
            rest /= grid.labels;
        }
        let energy = grid.energy(&labels);
        let lower = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| *a.min(b)).collect();
        if energy < best.energy {
            best = Labelling { labels, energy };
        } else if energy == best.energy {
            best.labels = lower(&best.labels, &labels);
        }
    }
    best
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 700, failure_persistence: None, ..Default::default() })]

    #[test]
    fn ordered_labels_are_the_best_and_the_lowest(problem in labels()) {
        for distance in [Distance::Tones(&problem.tones), Distance::Convex(&problem.convex)] {
            let grid = problem.grid(distance);
            prop_assert_eq!(solve_ordered(&grid).unwrap(), best(&grid), "{:?}", distance);
        }
    }

    #[test]
    fn expansions_never_raise_the_energy_and_keep_their_bound(problem in labels(), far in 1..3_i32) {
        let k = problem.labels;
        let table: Vec<i32> =
            (0..k * k).map(|i| if i / k == i % k { 0 } else { 2 + (i / k + i % k) as i32 % far }).collect();
        for distance in [Distance::Metric(&table), Distance::Tones(&problem.tones)] {
            let grid = problem.grid(distance);
            let found = expand(&grid, &vec![0; problem.mask.len()]).unwrap();
            let energies = &found.energies;
            prop_assert!(energies.is_sorted_by(|a, b| a > b), "{:?}", energies);
            prop_assert_eq!(grid.energy(&found.labelling.labels), found.labelling.energy);
            prop_assert_eq!(energies.last(), Some(&found.labelling.energy));
            let least = best(&grid).energy;
            prop_assert!(found.labelling.energy >= least);
            if let Distance::Metric(_) = distance {
                // Twice the ratio of the largest to the smallest distance, at most 3 to 2.
                prop_assert!(found.labelling.energy <= 3 * least);
            }
            if k == 2 {
                prop_assert_eq!(found.labelling.energy, least);
            }
        }
    }
}

#[test]
fn what_is_no_label_problem_is_said() {
    let good = Labels {
        width: 2,
        height: 1,
        labels: 2,
        mask: vec![true; 2],
        data: vec![1; 4],
        neighbour: vec![[1; 4]; 2],
        tones: vec![0, 1],
        convex: vec![0, 1],
    };
    let grid = good.grid(Distance::Tones(&good.tones));
    let metric = LabelGrid { distance: Distance::Metric(&[0, 1, 2, 0]), ..grid };
    let cases = [
        (solve_ordered(&LabelGrid { labels: 0, ..grid }), LabelError::Labels(0)),
        (
            solve_ordered(&LabelGrid { data: &[1; 3], ..grid }),
            LabelError::Length { slice: "data", got: 3, expected: 4 },
        ),
        (solve_ordered(&LabelGrid { data: &[-1; 4], ..grid }), LabelError::Price(-1)),
        (
            solve_ordered(&LabelGrid { distance: Distance::Tones(&[0, i32::MAX]), ..grid }),
            LabelError::TooFar { neighbour: 1, distance: i64::from(i32::MAX) },
        ),
    ];
    for (got, expected) in cases {
        let got = got.unwrap_err();
        assert_eq!(got, expected);
        assert!(!got.to_string().contains('\n'));
    }
    let distances = [
        solve_ordered(&metric).unwrap_err(),
        expand(&metric, &[0, 0]).unwrap_err(),
        solve_ordered(&LabelGrid { distance: Distance::Tones(&[1, 1]), ..grid }).unwrap_err(),
        solve_ordered(&LabelGrid { distance: Distance::Convex(&[1, 2]), ..grid }).unwrap_err(),
        expand(&LabelGrid { distance: Distance::Convex(&[0, 2]), ..grid }, &[0, 0]).unwrap_err(),
    ];
    assert!(distances.iter().all(|e| matches!(e, LabelError::Distance(_))), "{distances:?}");
    assert_eq!(expand(&grid, &[0, 2]).unwrap_err(), LabelError::Labels(3));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..Default::default() })]

    /// Two labels are one cut; more are never dearer than the start, and no single move helps.
    #[test]
    fn stacks_of_frames_are_labelled_through_time(
        problem in problem(),
        frames in 1..=3_usize,
        seed in any::<u32>(),
    ) {
        let Problem { width, height, .. } = problem;
        let (mask, neighbour, terminal) = (
            (0..frames).flat_map(|_| problem.mask.clone()).collect::<Vec<_>>(),
            (0..frames).flat_map(|_| problem.neighbour.clone()).collect::<Vec<_>>(),
            (0..frames).flat_map(|f| {
                let turned = move |[w, b]: [i32; 2]| if f % 2 == 0 { [w, b] } else { [b, w] };
                problem.terminal.clone().into_iter().map(turned)
            }).collect::<Vec<_>>(),
        );
        let frame = width * height;
        let random = |p: usize| (p as u32).wrapping_mul(2_654_435_761).wrapping_add(seed) >> 7;
        let time: Vec<Option<TimeLink>> = (0..mask.len())
            .map(|p| {
                let capacity = [(random(p) % 7) as i32; 2];
                let linked = p >= frame && random(p) % 5 > 0;
                linked.then_some(TimeLink { to: random(p + 99) % frame as u32, capacity })
            })
            .collect();
        let lattice = Lattice {
            width,
            height,
            frames,
            mask: &mask,
            terminal: &terminal,
            neighbours: Neighbours::Eight(Links::Symmetric(&neighbour)),
            time: &time,
            fixed: &[],
        };
        let data: Vec<i32> = terminal.iter().flatten().copied().collect();
        let grid = LabelGrid {
            width,
            height: height * frames,
            labels: 2,
            mask: &mask,
            data: &data,
            neighbour: &neighbour,
            distance: Distance::Metric(&[0, 1, 1, 0]),
        };
        let stack = LabelStack { grid, frames, time: &time };
        let start = vec![0; mask.len()];
        let found = expand_stack(&stack, &start).unwrap();
        prop_assert_eq!(found.labelling.energy, Solver::new(&lattice).unwrap().flow());
        prop_assert_eq!(stack.energy(&found.labelling.labels), found.labelling.energy);

        let third = |[w, b]: &[i32; 2]| [*w, *b, (w + b) / 2];
        let data: Vec<i32> = terminal.iter().flat_map(third).collect();
        let apart = [0, 1, 1, 1, 0, 1, 1, 1, 0];
        let grid = LabelGrid { labels: 3, data: &data, distance: Distance::Metric(&apart), ..grid };
        let stack = LabelStack { grid, frames, time: &time };
        let found = expand_stack(&stack, &start).unwrap();
        prop_assert!(found.energies.windows(2).all(|e| e[1] < e[0]));
        for p in (0..mask.len()).filter(|p| mask[*p]) {
            for label in 0..3 {
                let mut other = found.labelling.labels.clone();
                other[p] = label;
                prop_assert!(stack.energy(&other) >= found.labelling.energy);
            }
        }
        if frames > 1 {
            let broken = LabelStack { frames: mask.len() + 1, ..stack };
            prop_assert!(expand_stack(&broken, &start).is_err());
        }
    }
}
