//! Lattices of every neighbourhood, solved and solved again after changes, against the oracle.

mod oracle;

use chiaro_mincut::{GridError, Lattice, Links, MAX_NEIGHBOUR, Neighbours, Solver, TimeLink};

/// A lattice that owns its capacities. There are always eight links; a neighbourhood uses the
/// first two, four or eight.
#[derive(Clone, Debug)]
struct Problem {
    width: usize,
    height: usize,
    frames: usize,
    links: usize,
    directed: bool,
    mask: Vec<bool>,
    terminal: Vec<[i32; 2]>,
    capacity: Vec<[[i32; 2]; 8]>,
    time: Vec<Option<TimeLink>>,
    fixed: Vec<Option<bool>>,
}

/// Capacities that differ forth and back, and those that do not.
type Store<const L: usize> = (Vec<[[i32; 2]; L]>, Vec<[i32; L]>);

impl Problem {
    fn with<R>(&self, use_lattice: impl FnOnce(&Lattice) -> R) -> R {
        match self.links {
            2 => use_lattice(&self.lattice(Neighbours::Four(self.draw(&mut Default::default())))),
            4 => use_lattice(&self.lattice(Neighbours::Eight(self.draw(&mut Default::default())))),
            _ => {
                use_lattice(&self.lattice(Neighbours::Sixteen(self.draw(&mut Default::default()))))
            }
        }
    }

    /// The first `L` links of each pixel, kept in `store`.
    fn draw<'a, const L: usize>(&self, store: &'a mut Store<L>) -> Links<'a, L> {
        let links = |c: &[[i32; 2]; 8]| std::array::from_fn(|l| c[l]);
        store.0 = self.capacity.iter().map(links).collect();
        store.1 = store.0.iter().map(|links| links.map(|[forth, _]| forth)).collect();
        if self.directed { Links::Directed(&store.0) } else { Links::Symmetric(&store.1) }
    }

    fn lattice<'a>(&'a self, neighbours: Neighbours<'a>) -> Lattice<'a> {
        Lattice {
            width: self.width,
            height: self.height,
            frames: self.frames,
            mask: &self.mask,
            terminal: &self.terminal,
            neighbours,
            time: &self.time,
            fixed: &self.fixed,
        }
    }

    /// `solver` has the oracle's flow and canonical labels, and they cost what the flow says.
    fn agrees(&self, solver: &Solver) {
        let (labels, flow) = self.with(oracle::solve);
        assert_eq!(solver.flow(), flow);
        assert_eq!(solver.labels(), labels);
        assert_eq!(self.with(|lattice| lattice.energy(&labels)), flow);
    }
}

/// Draws numbers that are the same on every machine.
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        ((self.0 >> 33) % n as u64) as usize
    }

    fn capacity(&mut self, largest: i32, zeros: usize) -> i32 {
        if self.below(4) < zeros { 0 } else { self.below(largest as usize + 1) as i32 }
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }
}

/// The character of a problem's capacities.
#[derive(Clone, Copy)]
struct Taste {
    terminal: i32,
    link: i32,
    zeros: usize,
}

fn problem(dice: &mut Dice) -> (Problem, Taste) {
    let link = dice.pick(&[1, 3, 20, 1000, 40_000, MAX_NEIGHBOUR]);
    let terminal = link.saturating_mul(dice.pick(&[1, 4, 16]));
    let taste = Taste { terminal, link, zeros: dice.below(4) };
    let (width, height) = dice.pick(&[(1, 1), (7, 1), (1, 7), (3, 3), (6, 5), (9, 8)]);
    let frames = dice.pick(&[1, 1, 2, 3]);
    let (frame, pixels) = (width * height, width * height * frames);
    let (masked, fixed) = (dice.below(4), dice.below(2));
    let directed = dice.below(2) == 0;
    let capacity = |dice: &mut Dice| {
        let forth = dice.capacity(taste.link, taste.zeros);
        [forth, if directed { dice.capacity(taste.link, taste.zeros) } else { forth }]
    };
    let mut time = Vec::new();
    for pixel in 0..if frames > 1 { pixels } else { 0 } {
        // Some lead straight back, some crowd on a few pixels.
        let anywhere = dice.below(frame);
        let to = dice.pick(&[pixel % frame, 0, anywhere]) as u32;
        let linked = pixel >= frame && dice.below(5) > 0;
        time.push(linked.then(|| TimeLink { to, capacity: capacity(dice) }));
    }
    let problem = Problem {
        width,
        height,
        frames,
        links: dice.pick(&[2, 4, 8]),
        directed,
        mask: (0..pixels).map(|_| dice.below(8) >= masked).collect(),
        terminal: (0..pixels)
            .map(|_| [0, 1].map(|_| dice.capacity(taste.terminal, taste.zeros)))
            .collect(),
        capacity: (0..pixels).map(|_| [0; 8].map(|_| capacity(dice))).collect(),
        time,
        fixed: match fixed {
            0 => Vec::new(),
            _ => (0..pixels)
                .map(|_| dice.pick(&[None, None, None, Some(true), Some(false)]))
                .collect(),
        },
    };
    (problem, taste)
}

/// Changes one capacity of the problem and of its solver alike.
fn change(problem: &mut Problem, solver: &mut Solver, taste: Taste, dice: &mut Dice) {
    let pixel = dice.below(problem.mask.len());
    let done = match dice.below(5) {
        0 | 1 => {
            let terminal = [0, 1].map(|_| dice.capacity(taste.terminal, taste.zeros));
            let done = solver.set_terminal(pixel, terminal);
            if done.is_ok() {
                problem.terminal[pixel] = terminal;
            }
            done
        }
        2 => {
            let label = dice.pick(&[None, Some(true), Some(false)]);
            let done = solver.fix(pixel, label);
            if done.is_ok() {
                problem.fixed.resize(problem.mask.len(), None);
                problem.fixed[pixel] = label;
            }
            done
        }
        _ => {
            let link = dice.below(problem.links + 1);
            let forth = dice.capacity(taste.link, taste.zeros);
            let back =
                if problem.directed { dice.capacity(taste.link, taste.zeros) } else { forth };
            let done = solver.set_link(pixel, link, [forth, back]);
            if done.is_ok() {
                match problem.time.get_mut(pixel) {
                    Some(Some(time)) if link == problem.links => time.capacity = [forth, back],
                    _ => problem.capacity[pixel][link] = [forth, back],
                }
            }
            done
        }
    };
    if let Err(error) = done {
        assert!(matches!(error, GridError::NoPixel { .. } | GridError::NoLink { .. }), "{error}");
    }
}

/// Runs `rounds` of changes, each solved again and held against the oracle.
fn follow(seed: u64, rounds: usize) {
    let mut dice = Dice(seed);
    let (mut problem, taste) = problem(&mut dice);
    let mut solver = problem.with(Solver::new).expect("the draw keeps to the bounds");
    problem.agrees(&solver);
    for _ in 0..rounds {
        for _ in 0..dice.pick(&[1, 1, 3, 10, 60]) {
            change(&mut problem, &mut solver, taste, &mut dice);
        }
        solver.solve();
        problem.agrees(&solver);
    }
}

#[test]
fn lattices_and_their_changes_match_the_oracle() {
    (0..3000).for_each(|seed| follow(seed, 6));
}

#[test]
fn long_histories_match_the_oracle() {
    (0..20).for_each(|seed| follow(1 << 40 | seed, 300));
}

/// The later frames of a lattice with a new one behind them, beginning with what the links that
/// stay carried, or with nonsense, against the oracle.
#[test]
fn windows_that_move_on_match_the_oracle() {
    let mut moved = 0;
    for seed in 0..3000 {
        let mut dice = Dice(1 << 41 | seed);
        let (mut problem, taste) = problem(&mut dice);
        let solver = problem.with(Solver::new).expect("the draw keeps to the bounds");
        let frame = problem.width * problem.height;
        let kept = problem.mask.len() - frame;
        moved += u64::from(kept > 0);
        problem.terminal.rotate_left(frame);
        problem.capacity.rotate_left(frame);
        problem.mask.rotate_left(frame);
        if !problem.time.is_empty() {
            problem.time.rotate_left(frame);
            problem.time[..frame].fill(None);
            let anywhere = |dice: &mut Dice| dice.below(frame) as u32;
            for link in problem.time[kept..].iter_mut().take(if kept > 0 { frame } else { 0 }) {
                let capacity = [dice.capacity(taste.link, taste.zeros); 2];
                *link = Some(TimeLink { to: anywhere(&mut dice), capacity });
            }
        }
        if !problem.fixed.is_empty() {
            problem.fixed.rotate_left(frame);
        }
        let nonsense = dice.below(2) == 0;
        let guess = |pixel: usize, link: usize| match nonsense {
            true => (pixel * 7 + link * 5) as i64 % 11 * i64::from(taste.link) - 40,
            false if pixel < kept => solver.link_flow(pixel + frame, link),
            false => 0,
        };
        let resumed = problem.with(|lattice| Solver::resumed(lattice, guess));
        problem.agrees(&resumed.expect("the draw keeps to the bounds"));
    }
    assert!(moved > 1000, "{moved} windows had a frame that stayed");
}
