//! A small grid of noise that tests solve in several ways.

use crate::grid::Grid;
use crate::planes::Planes;
use crate::residual::Residual;
use crate::search::Search;

pub(crate) const WIDTH: usize = 61;
pub(crate) const HEIGHT: usize = 47;

/// The capacities of a grid.
pub(crate) struct Noise {
    terminal: Vec<[i32; 2]>,
    neighbour: Vec<[i32; 4]>,
}

impl Noise {
    /// One pixel in `rare` has a terminal: where they are few, trees are large.
    pub(crate) fn new(rare: u64) -> Self {
        let mut state = 7_u64;
        let mut random = |below: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % below) as i32
        };
        let mut terminal = || match random(2 * rare) {
            0 => [random(60), 0],
            1 => [0, random(60)],
            _ => [0; 2],
        };
        let terminal = (0..WIDTH * HEIGHT).map(|_| terminal()).collect();
        let neighbour = (0..WIDTH * HEIGHT).map(|_| [(); 4].map(|()| random(6))).collect();
        Self { terminal, neighbour }
    }

    /// Which nodes are white and the flow that is left, of a search that `begin` has begun.
    pub(crate) fn cut(&self, begin: impl FnOnce(&mut Search<Residual<i16>>)) -> (Vec<bool>, i64) {
        let mask = vec![true; WIDTH * HEIGHT];
        let (terminal, neighbour) = (&self.terminal[..], &self.neighbour[..]);
        let grid = Grid { width: WIDTH, height: HEIGHT, mask: &mask, terminal, neighbour };
        let planes = Planes::read(&grid, 1).expect("the capacities are small");
        let mut search = Search::new(Residual::new(planes));
        begin(&mut search);
        search.run().expect("distances are short");
        ((0..search.label.len()).map(|v| search.is_white(v)).collect(), search.left)
    }
}
