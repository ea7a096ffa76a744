//! Every solver's flow proves its cut.

use chiaro_mincut::{
    Flaw, Grid, Lattice, Links, Neighbours, Solver, TimeLink, solve, solve_flow, verify_grid,
    verify_lattice,
};
use proptest::prelude::*;

type Owned = (usize, usize, Vec<bool>, Vec<[i32; 2]>, Vec<[i32; 4]>);

fn problem() -> impl Strategy<Value = Owned> {
    let most = prop::sample::select(vec![2, 30, 16_000, 100_000, (1 << 27) - 1]);
    (1..=10_usize, 1..=10_usize, most, 5..=10_u32).prop_flat_map(|(width, height, most, masked)| {
        let pixels = width * height;
        (
            Just(width),
            Just(height),
            prop::collection::vec(prop::bool::weighted(f64::from(masked) / 10.0), pixels),
            prop::collection::vec([0..=most * 4, 0..=most * 4], pixels),
            prop::collection::vec(prop::array::uniform4(0..=most), pixels),
        )
    })
}

/// A lattice that owns its parts.
struct Parts {
    size: (usize, usize, usize),
    mask: Vec<bool>,
    terminal: Vec<[i32; 2]>,
    links: Vec<[[i32; 2]; 4]>,
    time: Vec<Option<TimeLink>>,
    fixed: Vec<Option<bool>>,
}

impl Parts {
    fn lattice(&self) -> Lattice<'_> {
        Lattice {
            width: self.size.0,
            height: self.size.1,
            frames: self.size.2,
            mask: &self.mask,
            terminal: &self.terminal,
            neighbours: Neighbours::Eight(Links::Directed(&self.links)),
            time: &self.time,
            fixed: &self.fixed,
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..Default::default() })]

    #[test]
    fn the_flow_of_a_grid_proves_its_cut((width, height, mask, terminal, neighbour) in problem()) {
        let grid = Grid { width, height, mask: &mask, terminal: &terminal, neighbour: &neighbour };
        let (cut, links) = solve_flow(&grid).unwrap();
        prop_assert_eq!(&cut, &solve(&grid).unwrap());
        prop_assert_eq!(verify_grid(&grid, &cut, &links), Ok(()));
    }

    #[test]
    fn the_flow_of_a_solver_proves_its_cut_after_changes(
        (width, height, mask, terminal, neighbour) in problem(),
        changes in prop::collection::vec((any::<u32>(), 0..4_usize, 0..1000_i32, any::<Option<bool>>()), 0..12),
    ) {
        let pixels = mask.len();
        let frames = if height % 2 == 0 { 2 } else { 1 };
        let mut parts = Parts {
            size: (width, height / frames, frames),
            links: neighbour.iter().map(|n| n.map(|c| [c, c / 3])).collect(),
            fixed: vec![None; pixels],
            // Every pixel of the second frame is linked to the one before it in the first.
            time: (0..if frames == 2 { pixels } else { 0 })
                .map(|p| Some(TimeLink { to: p.checked_sub(pixels / 2)? as u32 / 2, capacity: [3, 5] }))
                .collect(),
            mask,
            terminal,
        };
        let mut solver = Solver::new(&parts.lattice()).unwrap();
        for (at, link, value, label) in changes {
            let p = at as usize % pixels;
            if parts.mask[p] {
                parts.terminal[p] = [value, 500];
                solver.set_terminal(p, parts.terminal[p]).unwrap();
                parts.fixed[p] = label;
                solver.fix(p, label).unwrap();
                if solver.set_link(p, link, [value / 2, value]).is_ok() {
                    parts.links[p][link] = [value / 2, value];
                }
            }
        }
        let flow = solver.solve();
        let carried = |pixel, link| solver.link_flow(pixel, link);
        prop_assert_eq!(verify_lattice(&parts.lattice(), solver.labels(), flow, carried), Ok(()));
    }
}

#[test]
fn a_wrong_label_or_flow_is_found() {
    let grid = Grid {
        width: 3,
        height: 1,
        mask: &[true; 3],
        terminal: &[[9, 0], [0, 0], [0, 9]],
        neighbour: &[[4, 0, 0, 0]; 3],
    };
    let (mut cut, mut links) = solve_flow(&grid).unwrap();
    assert_eq!((cut.flow, links[0][0], links[1][0]), (4, 4, 4));
    cut.labels[1] = true;
    assert_eq!(verify_grid(&grid, &cut, &links), Err(Flaw::Canonical { node: 1 }));
    cut.labels[1] = false;
    links[1][0] = 3;
    assert_eq!(
        verify_grid(&grid, &cut, &links),
        Err(Flaw::Capacity { place: "node 1".into(), flow: 1 })
    );
}
