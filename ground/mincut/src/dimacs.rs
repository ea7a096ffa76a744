//! Maximum-flow problems in the DIMACS format, read and written, and their solutions written.
//!
//! ```text
//! c a comment
//! p max 4 5        nodes, arcs
//! n 1 s            the source
//! n 4 t            the sink
//! a 1 2 7          from, to, capacity
//! ```
//!
//! After "Network flows and matching: first DIMACS implementation challenge" (1993). Nodes count
//! from 1. Reading trusts nothing: memory is at most a fixed multiple of the text's length, and
//! what is wrong is one sentence with its line.

use crate::certificate::{Flaw, verify};
use crate::sparse::{Edge, Graph, GraphCut, GraphError, MAX_EDGES, solve_graph};
use std::fmt::{self, Write};

/// A maximum-flow problem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaxFlow {
    /// The number of nodes; they are counted from 0 here, from 1 in files.
    pub nodes: u32,
    /// Where the flow comes from.
    pub source: u32,
    /// Where it goes; another node than the source.
    pub sink: u32,
    /// `(from, to, capacity)`, 0 or more.
    pub arcs: Vec<(u32, u32, i64)>,
}

/// The solution of a [`MaxFlow`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaxFlowSolution {
    /// The maximal flow.
    pub flow: i64,
    /// The capacity of the minimal cut; equal to `flow`.
    pub cut: i64,
    /// The flow of each arc.
    pub arc_flow: Vec<i64>,
    /// Of each node, whether it is on the source's side: what the source still reaches.
    pub side: Vec<bool>,
}

/// Why a text is no maximum-flow problem.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DimacsError {
    /// The line, from 1; 0 if something is missing from the whole.
    pub line: usize,
    /// What is wrong and what to do.
    pub why: String,
}

impl fmt::Display for DimacsError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.line {
            0 => f.write_str(&self.why),
            line => write!(f, "line {line}: {}", self.why),
        }
    }
}

impl std::error::Error for DimacsError {}

/// Nodes that any text may name; more must be matched by its length.
const FREE_NODES: u64 = 1 << 20;
/// Bytes of the shortest line of an arc.
const SHORTEST_ARC: usize = 8;

/// What has been read so far.
#[derive(Default)]
struct Reader {
    /// Nodes and arcs that the problem line promises.
    promised: Option<(u32, usize)>,
    ends: [Option<u32>; 2],
    arcs: Vec<(u32, u32, i64)>,
}

/// Reads a maximum-flow problem.
///
/// # Errors
/// The first line that does not fit the format, or what is missing at the end.
pub fn read_dimacs(bytes: &[u8]) -> Result<MaxFlow, DimacsError> {
    let mut reader = Reader::default();
    for (index, line) in bytes.split(|&b| b == b'\n').enumerate() {
        reader.line(line, bytes.len()).map_err(|why| DimacsError { line: index + 1, why })?;
    }
    reader.finish().map_err(|why| DimacsError { line: 0, why })
}

impl Reader {
    fn line(&mut self, line: &[u8], length: usize) -> Result<(), String> {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        match words.next() {
            None | Some(b"c") => return Ok(()),
            Some(b"p") => self.problem(&mut words, length)?,
            Some(b"n") => self.end(&mut words)?,
            Some(b"a") => self.arc(&mut words)?,
            Some(other) => {
                return Err(format!("a line begins with c, p, n or a, not with `{}`", show(other)));
            }
        }
        match words.next() {
            Some(word) => Err(format!("`{}` is one word too many", show(word))),
            None => Ok(()),
        }
    }

    fn problem<'a>(
        &mut self,
        words: &mut impl Iterator<Item = &'a [u8]>,
        length: usize,
    ) -> Result<(), String> {
        if self.promised.is_some() {
            return Err("a second problem line; keep one problem a file".into());
        }
        match words.next() {
            Some(b"max") => {}
            Some(kind) => return Err(format!("a `{}` problem, not a `max` one", show(kind))),
            None => return Err("the problem line has no kind; it reads `p max NODES ARCS`".into()),
        }
        let nodes = number(words.next(), "the number of nodes", u32::MAX.into())?;
        let arcs = number(words.next(), "the number of arcs", MAX_EDGES as u64)?;
        if nodes > FREE_NODES.max(length as u64) || arcs > (length / SHORTEST_ARC) as u64 {
            return Err(format!(
                "{nodes} nodes and {arcs} arcs are more than {length} bytes can describe; \
                 correct the problem line"
            ));
        }
        self.promised = Some((nodes as u32, arcs as usize));
        self.arcs.reserve_exact(arcs as usize);
        Ok(())
    }

    fn node(&self, word: Option<&[u8]>, what: &str) -> Result<u32, String> {
        let (nodes, _) = self.promised.ok_or("the problem line `p max NODES ARCS` comes first")?;
        match number(word, what, u64::MAX)? {
            0 => Err(format!("{what} is 0; nodes count from 1")),
            n if n > u64::from(nodes) => Err(format!("{what} is {n}, but there are {nodes} nodes")),
            n => Ok(n as u32 - 1),
        }
    }

    fn end<'a>(&mut self, words: &mut impl Iterator<Item = &'a [u8]>) -> Result<(), String> {
        let node = self.node(words.next(), "the node")?;
        let (index, name) = match words.next() {
            Some(b"s") => (0, "source"),
            Some(b"t") => (1, "sink"),
            _ => return Err("a node line ends with s or t".into()),
        };
        if self.ends[index].replace(node).is_some() {
            return Err(format!("a second {name}; join them by arcs to one"));
        }
        if self.ends[0] == self.ends[1] {
            return Err(format!("node {} is both source and sink", node + 1));
        }
        Ok(())
    }

    fn arc<'a>(&mut self, words: &mut impl Iterator<Item = &'a [u8]>) -> Result<(), String> {
        let from = self.node(words.next(), "the arc's first node")?;
        let to = self.node(words.next(), "the arc's second node")?;
        let capacity = number(words.next(), "the capacity", i64::MAX as u64)?;
        if self.promised.is_some_and(|(_, arcs)| arcs == self.arcs.len()) {
            return Err(format!("more arcs than the {} promised", self.arcs.len()));
        }
        self.arcs.push((from, to, capacity as i64));
        Ok(())
    }

    fn finish(self) -> Result<MaxFlow, String> {
        let (nodes, arcs) =
            self.promised.ok_or("no problem line; a file begins with `p max NODES ARCS`")?;
        let [Some(source), Some(sink)] = self.ends else {
            let missing =
                if self.ends[0].is_none() { "source, `n ID s`" } else { "sink, `n ID t`" };
            return Err(format!("there is no line for the {missing}"));
        };
        if self.arcs.len() < arcs {
            return Err(format!("{} arcs, but {arcs} are promised", self.arcs.len()));
        }
        Ok(MaxFlow { nodes, source, sink, arcs: self.arcs })
    }
}

/// A whole number up to `most`.
fn number(word: Option<&[u8]>, what: &str, most: u64) -> Result<u64, String> {
    let word = word.ok_or_else(|| format!("{what} is missing"))?;
    let digits = word.iter().all(u8::is_ascii_digit);
    let value = std::str::from_utf8(word).ok().and_then(|t| t.parse().ok());
    match value.filter(|&v| digits && v <= most) {
        Some(value) => Ok(value),
        None => Err(format!("{what} is `{}`; a whole number up to {most} is expected", show(word))),
    }
}

/// A word of an untrusted file, fit to be printed.
fn show(word: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(word).chars().take(24).collect();
    text.escape_default().to_string()
}

impl MaxFlow {
    /// The problem as a graph: arcs from the source and to the sink become terminals. Nothing is
    /// gained by flow into the source or out of the sink.
    fn graph(&self) -> Graph {
        let mut graph = Graph::new(self.nodes as usize);
        let mut sums = vec![[0i128; 2]; self.nodes as usize];
        let mut pairing = Pairing::default();
        for &(from, to, capacity) in &self.arcs {
            match self.role([from, to]) {
                Role::White => sums[to as usize][0] += i128::from(capacity),
                Role::Black => sums[from as usize][1] += i128::from(capacity),
                Role::Inner => match (pairing.next([from, to]), graph.edges.last_mut()) {
                    (Way::Back, Some(edge)) => edge.back = capacity,
                    _ => graph.edges.push(Edge { ends: [from, to], forth: capacity, back: 0 }),
                },
                Role::Direct | Role::None => {}
            }
        }
        for (terminal, sum) in graph.terminal.iter_mut().zip(sums) {
            *terminal = sum.map(|s| i64::try_from(s).unwrap_or(i64::MAX));
        }
        graph
    }

    fn role(&self, [from, to]: [u32; 2]) -> Role {
        match () {
            () if from == to || to == self.source || from == self.sink => Role::None,
            () if from == self.source && to == self.sink => Role::Direct,
            () if from == self.source => Role::White,
            () if to == self.sink => Role::Black,
            () => Role::Inner,
        }
    }

    /// A maximal flow and the canonical minimal cut.
    ///
    /// # Errors
    /// A [`GraphError`] when the sums are beyond its limits.
    pub fn solve(&self) -> Result<MaxFlowSolution, GraphError> {
        let direct =
            |&&(from, to, _): &&(u32, u32, i64)| matches!(self.role([from, to]), Role::Direct);
        let direct: i128 = self.arcs.iter().filter(direct).map(|a| i128::from(a.2)).sum();
        let cut = solve_graph(&self.graph())?;
        let add = |value: i64| {
            i64::try_from(direct + i128::from(value)).map_err(|_| GraphError::TooMuchFlow)
        };
        let (flow, capacity) = (add(cut.flow)?, add(cut.cut)?);
        let arc_flow = self.arc_flow(&cut);
        let mut side = cut.labels;
        side[self.source as usize] = true;
        Ok(MaxFlowSolution { flow, cut: capacity, arc_flow, side })
    }

    /// Checks that `solution` holds a maximal flow and the canonical minimal cut.
    ///
    /// # Errors
    /// The first [`Flaw`] found.
    pub fn verify(&self, solution: &MaxFlowSolution) -> Result<(), Flaw> {
        let mut graph = Graph::new(self.nodes as usize);
        let mut terminal_flow = graph.terminal.clone();
        for (side, node) in [self.source, self.sink].into_iter().enumerate() {
            // More than the flow, so that the terminals themselves are no cut.
            graph.terminal[node as usize][side] = solution.flow.saturating_add(1);
            terminal_flow[node as usize][side] = solution.flow;
        }
        let edge = |&(from, to, forth): &(u32, u32, i64)| Edge { ends: [from, to], forth, back: 0 };
        graph.edges = self.arcs.iter().map(edge).collect();
        let cut = GraphCut {
            labels: solution.side.clone(),
            flow: solution.flow,
            cut: solution.cut,
            edge_flow: solution.arc_flow.clone(),
            terminal_flow,
        };
        verify(&graph, &cut)
    }

    /// Hands the flow of terminals out to their arcs, first come first served.
    fn arc_flow(&self, cut: &GraphCut) -> Vec<i64> {
        let mut left = cut.terminal_flow.clone();
        let mut inner = cut.edge_flow.iter();
        let mut edge = 0;
        let mut pairing = Pairing::default();
        let mut serve = |v: u32, side: usize, capacity: i64| {
            let flow = left[v as usize][side].min(capacity);
            left[v as usize][side] -= flow;
            flow
        };
        let flow = |&(from, to, capacity): &(u32, u32, i64)| match self.role([from, to]) {
            Role::White => serve(to, 0, capacity),
            Role::Black => serve(from, 1, capacity),
            Role::Direct => capacity,
            Role::Inner => match pairing.next([from, to]) {
                Way::Forth => {
                    edge = *inner.next().expect("an inner arc is half an edge at least");
                    edge.max(0)
                }
                Way::Back => (-edge).max(0),
            },
            Role::None => 0,
        };
        self.arcs.iter().map(flow).collect()
    }

    /// The problem as text, ready to be read again.
    pub fn to_dimacs(&self) -> String {
        let mut text = format!("p max {} {}\n", self.nodes, self.arcs.len());
        let mut line = |args: fmt::Arguments| text.write_fmt(args).expect("memory takes any text");
        line(format_args!("n {} s\nn {} t\n", self.source + 1, self.sink + 1));
        for &(from, to, capacity) in &self.arcs {
            line(format_args!("a {} {} {capacity}\n", from + 1, to + 1));
        }
        text
    }

    /// A solution in the DIMACS format: a line `s FLOW`, and `f FROM TO FLOW` for each arc that
    /// carries flow.
    pub fn solution_to_dimacs(&self, solution: &MaxFlowSolution) -> String {
        let mut text = format!("s {}\n", solution.flow);
        for (&(from, to, _), &flow) in self.arcs.iter().zip(&solution.arc_flow) {
            if flow != 0 {
                writeln!(text, "f {} {} {flow}", from + 1, to + 1).expect("memory takes any text");
            }
        }
        text
    }
}

impl From<&Graph> for MaxFlow {
    /// The graph with a source after its last node and a sink after that.
    fn from(graph: &Graph) -> Self {
        let (source, sink) = (graph.terminal.len() as u32, graph.terminal.len() as u32 + 1);
        let mut arcs = Vec::with_capacity(graph.terminal.len() + graph.edges.len());
        let mut add = |from: u32, to: u32, capacity: i64| {
            if capacity > 0 {
                arcs.push((from, to, capacity));
            }
        };
        for (v, &[white, black]) in graph.terminal.iter().enumerate() {
            add(source, v as u32, white);
            add(v as u32, sink, black);
        }
        for edge in &graph.edges {
            add(edge.ends[0], edge.ends[1], edge.forth);
            add(edge.ends[1], edge.ends[0], edge.back);
        }
        Self { nodes: sink + 1, source, sink, arcs }
    }
}

/// What an arc is to the graph.
enum Role {
    /// From the source.
    White,
    /// To the sink.
    Black,
    /// From the source to the sink.
    Direct,
    /// Between two other nodes.
    Inner,
    /// Of no use to any flow.
    None,
}

/// Which way along its edge an inner arc goes.
enum Way {
    /// Along an edge of its own.
    Forth,
    /// Back along the edge of the inner arc before it.
    Back,
}

/// Makes one edge of two inner arcs that follow each other and lead there and back.
#[derive(Default)]
struct Pairing {
    /// The last arc, if it has no partner.
    single: Option<[u32; 2]>,
}

impl Pairing {
    fn next(&mut self, [from, to]: [u32; 2]) -> Way {
        if self.single == Some([to, from]) {
            self.single = None;
            Way::Back
        } else {
            self.single = Some([from, to]);
            Way::Forth
        }
    }
}
