//! [`Solver`]: a lattice that is solved, changed, and solved again.
//!
//! It owns the residual graph and the trees of its last solution. A change is made in numbers at
//! once and mended with the next [`Solver::solve`] ([`crate::repair`] tells how), so that a stroke
//! costs what the stroke moves, not what the picture holds. Whatever was changed before, in
//! whatever order, flow and labels are those of a fresh solution, for both are unique.
//!
//! Memory: 56 bytes a pixel for eight neighbours in one frame; else `4 N + 27` for `N` neighbours,
//! and 20 more with links in time. Capacities that differ forth and back add 4 bytes a link.

use crate::capacity::Capacity;
use crate::grid::{Grid, GridError};
use crate::lattice::{LINK_STEPS, Lattice, Links, Neighbours, check_link, neighbour};
use crate::planes::bounded;
use crate::repair::Mutable;
use crate::residual::Residual;
use crate::search::Search;
use crate::solved;
use crate::stencil::Stencil;

/// Links of a pixel at most: half of sixteen, and one in time.
const MOST_LINKS: usize = LINK_STEPS.len() + 1;

/// A solved lattice whose capacities can be changed.
pub struct Solver {
    engine: Box<dyn Engine>,
    width: usize,
    height: usize,
    /// The steps of the links within a frame.
    steps: &'static [(isize, isize)],
    mask: Vec<bool>,
    terminal: Vec<[i32; 2]>,
    /// The label each pixel must have; empty while none must.
    fixed: Vec<Option<bool>>,
    /// Links of a pixel, the one in time included.
    links: usize,
    /// How much more each link carries forth than back; empty while none does.
    skew: Vec<i32>,
    /// What every cut pays: of each pixel the smaller terminal, and what its bound leaves out.
    direct: i64,
    /// The positive differences of the terminals.
    supply: i64,
    labels: Vec<bool>,
}

impl Solver {
    /// Takes up a lattice and solves it.
    ///
    /// # Errors
    /// See [`Lattice::check`].
    pub fn new(lattice: &Lattice) -> Result<Self, GridError> {
        lattice.check()?;
        let mut solver = Self::empty(lattice);
        match lattice.neighbours {
            Neighbours::Eight(Links::Symmetric(neighbour)) if is_flat(lattice) => {
                solver.load_grid(lattice, neighbour);
            }
            _ => solver.load(lattice, |_, _| 0),
        }
        solver.solve();
        Ok(solver)
    }

    /// Takes up a lattice and solves it, beginning with `flow(pixel, link)` on each link, links
    /// counted as for [`Solver::set_link`], negative for flow that goes back.
    ///
    /// Any guess gives the same labels; a good one saves work. When frames leave a window and others
    /// come, when links in time lead elsewhere or the picture is cropped anew, what
    /// [`Solver::link_flow`] says of the links that stay is a good guess, and 0 for the others.
    ///
    /// # Errors
    /// See [`Lattice::check`].
    pub fn resumed(
        lattice: &Lattice,
        flow: impl Fn(usize, usize) -> i64,
    ) -> Result<Self, GridError> {
        lattice.check()?;
        let mut solver = Self::empty(lattice);
        solver.load(lattice, flow);
        solver.solve();
        Ok(solver)
    }

    /// A solver of a checked lattice, without any capacity.
    fn empty(lattice: &Lattice) -> Self {
        Self {
            engine: engine(lattice),
            width: lattice.width,
            height: lattice.height,
            steps: lattice.neighbours.steps(),
            mask: lattice.mask.to_vec(),
            terminal: lattice.terminal.to_vec(),
            fixed: lattice.fixed.to_vec(),
            links: lattice.links(),
            skew: Vec::new(),
            direct: 0,
            supply: 0,
            labels: vec![false; lattice.pixels()],
        }
    }

    fn load(&mut self, lattice: &Lattice, flow: impl Fn(usize, usize) -> i64) {
        for pixel in (0..self.mask.len()).filter(|&pixel| lattice.mask[pixel]) {
            let [direct, difference] = self.stated(pixel);
            self.count(direct, difference);
            self.engine.change_excess(pixel, difference);
            let mut present = [(0, [0; 2]); MOST_LINKS];
            let mut count = 0;
            lattice.each_link(pixel, |link, capacity| {
                present[count] = (link, capacity);
                count += 1;
            });
            let present = &present[..count];
            self.engine.take_up(pixel, present);
            for &(link, [forth, back]) in present {
                self.lean(pixel * self.links + link, forth - back);
                match flow(pixel, link) {
                    0 => {}
                    flow => self.engine.send(pixel, link, flow),
                }
            }
        }
        self.engine.restart();
    }

    /// Takes a grid up solved, in the fast form for it.
    fn load_grid(&mut self, lattice: &Lattice, neighbour: &[[i32; 4]]) {
        let mut terminal = vec![[0; 2]; self.mask.len()];
        for pixel in (0..self.mask.len()).filter(|&pixel| lattice.mask[pixel]) {
            let [direct, difference] = self.stated(pixel);
            self.count(direct, difference);
            terminal[pixel] = [difference.max(0) as i32, (-difference).max(0) as i32];
        }
        let (width, height, mask) = (lattice.width, lattice.height, lattice.mask);
        let search = taken_up(&Grid { width, height, mask, terminal: &terminal, neighbour });
        self.engine = Box::new(Warm { search, touched: Vec::new() });
    }

    /// Whether the pixels' labels are white, in the lattice's order, as of the last
    /// [`Solver::solve`]; `false` outside the mask.
    pub fn labels(&self) -> &[bool] {
        &self.labels
    }

    /// The maximal flow, the smaller terminal of each pixel included: the cost of the labels as
    /// [`Lattice::energy`] counts it. As of the last [`Solver::solve`].
    pub fn flow(&self) -> i64 {
        self.direct + self.supply - self.engine.left()
    }

    /// The flow over a link of a pixel, counted as for [`Solver::set_link`], negative if it goes
    /// back; 0 if there is no such link. As of the last [`Solver::solve`].
    pub fn link_flow(&self, pixel: usize, link: usize) -> i64 {
        let skew = self.skew.get(pixel * self.links + link).map_or(0, |&skew| i64::from(skew));
        let node = self.mask.get(pixel).copied().unwrap_or(false);
        if node { self.engine.link_flow(pixel, link, skew) } else { 0 }
    }

    /// Solves again after changes; the flow.
    pub fn solve(&mut self) -> i64 {
        self.engine.run();
        self.engine.read_labels(&mut self.labels, self.width);
        self.flow()
    }

    /// Changes the terminals `[white, black]` of a pixel.
    ///
    /// # Errors
    /// A negative capacity, or a pixel that is no node.
    pub fn set_terminal(&mut self, pixel: usize, terminal: [i32; 2]) -> Result<(), GridError> {
        self.check_pixel(pixel)?;
        if let Some(&got) = terminal.iter().find(|&&c| c < 0) {
            let (x, y) = (pixel % self.width, pixel / self.width);
            return Err(GridError::Negative { x, y, got });
        }
        self.restate(pixel, |solver| solver.terminal[pixel] = terminal);
        Ok(())
    }

    /// Makes a pixel white or black whatever it costs, or frees it.
    ///
    /// # Errors
    /// A pixel that is no node.
    pub fn fix(&mut self, pixel: usize, label: Option<bool>) -> Result<(), GridError> {
        self.check_pixel(pixel)?;
        if self.fixed.is_empty() {
            self.fixed.resize(self.mask.len(), None);
        }
        self.restate(pixel, |solver| solver.fixed[pixel] = label);
        Ok(())
    }

    /// Changes the capacities `[forth, back]` of a link of a pixel; links are counted as in
    /// [`Neighbours::steps`], and the one after the last is the link in time.
    ///
    /// # Errors
    /// A capacity beyond its bounds, a pixel that is no node, or a link that leads to none.
    pub fn set_link(
        &mut self,
        pixel: usize,
        link: usize,
        capacity: [i32; 2],
    ) -> Result<(), GridError> {
        self.check_pixel(pixel)?;
        let (x, y) = (pixel % self.width, pixel / self.width);
        capacity.into_iter().try_for_each(|c| check_link(x, y, c))?;
        let exists = match self.steps.get(link) {
            Some(&step) => {
                neighbour(self.width, self.height, pixel, step).is_some_and(|end| self.mask[end])
            }
            None => self.engine.has_link(pixel, link),
        };
        if !exists {
            return Err(GridError::NoLink { pixel, link });
        }
        self.change_link(pixel, link, capacity);
        Ok(())
    }

    fn check_pixel(&self, pixel: usize) -> Result<(), GridError> {
        let pixels = self.mask.len();
        let node = self.mask.get(pixel).copied().unwrap_or(false);
        if node { Ok(()) } else { Err(GridError::NoPixel { got: pixel, pixels }) }
    }

    /// What every cut pays at a pixel, and its terminals' difference within the engine's bound.
    fn stated(&self, pixel: usize) -> [i64; 2] {
        let bound = self.engine.bound();
        let [white, black] = self.terminal[pixel].map(i64::from);
        match self.fixed.get(pixel).copied().flatten() {
            None => [white.min(black), (white - black).clamp(-bound, bound)],
            Some(true) => [black, bound],
            Some(false) => [white, -bound],
        }
    }

    fn count(&mut self, direct: i64, difference: i64) {
        self.direct += direct;
        self.supply += difference.max(0);
    }

    /// Makes a change of what a pixel states.
    fn restate(&mut self, pixel: usize, change: impl FnOnce(&mut Self)) {
        let [direct, old] = self.stated(pixel);
        self.direct -= direct;
        self.supply -= old.max(0);
        change(self);
        let [direct, new] = self.stated(pixel);
        self.count(direct, new);
        if new != old {
            self.engine.change_excess(pixel, new - old);
        }
    }

    fn change_link(&mut self, pixel: usize, link: usize, new: [i32; 2]) {
        let at = pixel * self.links + link;
        let old_skew = self.skew.get(at).map_or(0, |&skew| i64::from(skew));
        self.engine.change_link(pixel, link, old_skew, new.map(i64::from));
        self.lean(at, new[0] - new[1]);
    }

    /// Notes how much more a link carries forth than back.
    fn lean(&mut self, at: usize, skew: i32) {
        if self.skew.is_empty() && skew != 0 {
            self.skew.resize(self.mask.len() * self.links, 0);
        }
        if let Some(old) = self.skew.get_mut(at) {
            *old = skew;
        }
    }
}

fn is_flat(lattice: &Lattice) -> bool {
    lattice.frames == 1 && lattice.time.is_empty() && !lattice.mask.is_empty()
}

/// Solves a grid that is within bounds, in 16 bits if it fits.
fn taken_up(grid: &Grid) -> Search<Residual<i32>> {
    let Some((narrow, _)) = solved::<i16>(grid, 1) else {
        return solved::<i32>(grid, 1).expect("a checked grid fits 32 bits").0;
    };
    let mut search = narrow.widened();
    for (pixel, &[white, black]) in grid.terminal.iter().enumerate() {
        let (x, y) = (pixel % grid.width, pixel / grid.width);
        let (stated, taken) = (white - black, bounded::<i16>(grid, x, y, white - black));
        if taken != Some(stated) && grid.mask[pixel] {
            // A root that no flow uses up is given what 16 bits did not hold.
            let rest = stated - taken.expect("16 bits sufficed");
            search.change_excess(search.network.node(pixel), i64::from(rest));
        }
    }
    search
}

/// The smallest engine for a lattice, without any capacity.
fn engine(lattice: &Lattice) -> Box<dyn Engine> {
    match lattice.neighbours {
        Neighbours::Four(_) => Box::new(Warm::new(Stencil::<4>::empty(lattice))),
        Neighbours::Eight(_) if is_flat(lattice) => {
            Box::new(Warm::new(Residual::empty(lattice.width, lattice.height)))
        }
        Neighbours::Eight(_) => Box::new(Warm::new(Stencil::<8>::empty(lattice))),
        Neighbours::Sixteen(_) => Box::new(Warm::new(Stencil::<16>::empty(lattice))),
    }
}

/// What a solver asks of its search, whatever the network.
trait Engine: Send {
    /// The largest difference of terminals; more is as good as fixed.
    fn bound(&self) -> i64;
    /// Adds to the excess of a pixel.
    fn change_excess(&mut self, pixel: usize, amount: i64);
    /// Gives a pixel the capacities of its own links, of a network that had none.
    fn take_up(&mut self, pixel: usize, links: &[(usize, [i32; 2])]);
    /// Gives new capacities to a link that carries `skew` more forth than back.
    fn change_link(&mut self, pixel: usize, link: usize, skew: i64, new: [i64; 2]);
    /// Sends flow over a link, as much of it as the link carries.
    fn send(&mut self, pixel: usize, link: usize, flow: i64);
    /// The flow over a link that carries `skew` more forth than back.
    fn link_flow(&self, pixel: usize, link: usize, skew: i64) -> i64;
    /// Whether a pixel has a link, if only to a pixel that is no node.
    fn has_link(&self, pixel: usize, link: usize) -> bool;
    /// Forgets the trees, not the flow.
    fn restart(&mut self);
    /// Makes the flow maximal.
    fn run(&mut self);
    /// All positive excess.
    fn left(&self) -> i64;
    /// Reads whether each pixel is white, `width` pixels a row.
    fn read_labels(&self, labels: &mut [bool], width: usize);
}

/// A search and what was changed since it ran.
struct Warm<N: Mutable> {
    search: Search<N>,
    touched: Vec<u32>,
}

impl<N: Mutable> Warm<N> {
    fn new(network: N) -> Self {
        Self { search: Search::new(network), touched: Vec::new() }
    }
}

impl<N: Mutable> Engine for Warm<N> {
    fn bound(&self) -> i64 {
        N::BOUND
    }

    fn change_excess(&mut self, pixel: usize, amount: i64) {
        let v = self.search.network.node(pixel);
        self.search.change_excess(v, amount);
        self.touched.push(v as u32);
    }

    fn take_up(&mut self, pixel: usize, links: &[(usize, [i32; 2])]) {
        let network = &mut self.search.network;
        let v = network.node(pixel);
        for &(link, capacity) in links {
            let arc = network.arc(v, link).expect("the caller checked the link");
            network.set_residuals(v, arc, capacity.map(i64::from));
        }
    }

    fn change_link(&mut self, pixel: usize, link: usize, skew: i64, new: [i64; 2]) {
        let v = self.search.network.node(pixel);
        let arc = self.search.network.arc(v, link).expect("the caller checked the link");
        let w = self.search.network.head(v, arc);
        let forth = self.search.network.residual(v, arc);
        let both = forth + self.search.network.residual(w, self.search.network.back(v, arc));
        let old = [(both + skew) / 2, (both - skew) / 2];
        if old != new {
            self.search.change_capacities(v, arc, old, new);
            self.touched.extend([v as u32, w as u32]);
        }
    }

    fn send(&mut self, pixel: usize, link: usize, flow: i64) {
        let network = &mut self.search.network;
        let v = network.node(pixel);
        let arc = network.arc(v, link).expect("the caller checked the link");
        let w = network.head(v, arc);
        let (forth, back) = (network.residual(v, arc), network.residual(w, network.back(v, arc)));
        let flow = flow.clamp(-back, forth);
        if flow != 0 {
            network.set_residuals(v, arc, [forth - flow, back + flow]);
            network.add_excess(v, -flow);
            network.add_excess(w, flow);
        }
    }

    fn link_flow(&self, pixel: usize, link: usize, skew: i64) -> i64 {
        let network = &self.search.network;
        let v = network.node(pixel);
        let Some(arc) = network.arc(v, link) else { return 0 };
        let (w, back) = (network.head(v, arc), network.back(v, arc));
        let (forth, back) = (network.residual(v, arc), network.residual(w, back));
        (forth + back + skew) / 2 - forth
    }

    fn has_link(&self, pixel: usize, link: usize) -> bool {
        self.search.network.arc(self.search.network.node(pixel), link).is_some()
    }

    fn restart(&mut self) {
        self.search.restart();
        self.touched.clear();
    }

    fn run(&mut self) {
        if self.touched.len() > self.search.label.len() / 4 {
            // Little of the trees would last.
            self.search.restart();
        } else {
            self.search.mend(&self.touched);
        }
        self.touched.clear();
        if self.search.run().is_none() {
            // Labels have risen over many changes; new trees begin at one.
            self.search.restart();
            self.search.run().expect("a path is shorter than its labels' range");
        }
    }

    fn left(&self) -> i64 {
        self.search.left
    }

    fn read_labels(&self, labels: &mut [bool], width: usize) {
        for (row, labels) in labels.chunks_mut(width.max(1)).enumerate() {
            let first = self.search.network.node(row * width);
            for (label, at) in labels.iter_mut().zip(&self.search.label[first..]) {
                *label = at.get() > 0;
            }
        }
    }
}
