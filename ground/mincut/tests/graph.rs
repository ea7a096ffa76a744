//! The solver for general graphs against shortest augmenting paths, the grid solver and closed forms.

use chiaro_mincut::{Edge, Graph, GraphCut, GraphError, MAX_FLOW, solve_graph};
use proptest::prelude::*;

mod oracle;

/// Same flow, same canonical labels, and the flow is the cut.
fn agrees(graph: &Graph) -> GraphCut {
    let cut = solve_graph(graph).expect("the strategy keeps to the limits");
    let (labels, flow) = oracle::solve_graph(graph);
    assert_eq!((cut.flow, cut.cut), (flow, flow));
    assert_eq!(cut.labels, labels);
    cut
}

/// From nothing but ties to the largest; `zeros` in 4 are zero.
fn capacity(largest: i64, zeros: u32) -> impl Strategy<Value = i64> + Clone {
    prop_oneof![zeros => Just(0), (4 - zeros) => 0..=largest]
}

fn graph() -> impl Strategy<Value = Graph> {
    let largest = prop::sample::select(vec![1, 3, 20, 100_000, MAX_FLOW / 64, i64::MAX]);
    let terminals = prop::sample::select(vec![1, 5, 100, MAX_FLOW / 64]);
    (1..=24_usize, 0..=70_usize, largest, terminals, 0..4_u32, 0..4_u32).prop_flat_map(
        |(nodes, edges, largest, most, no_terminal, no_edge)| {
            let end = 0..nodes as u32;
            let edge = ([end.clone(), end], capacity(largest, no_edge), capacity(largest, no_edge));
            let edge = edge.prop_map(|(ends, forth, back)| Edge { ends, forth, back });
            let terminal = prop::array::uniform2(capacity(most, no_terminal));
            (prop::collection::vec(terminal, nodes), prop::collection::vec(edge, edges))
                .prop_map(|(terminal, edges)| Graph { terminal, edges })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn random_graphs_match_the_oracle(graph in graph()) {
        agrees(&graph);
    }
}

/// A hash with the look of noise: the same on every machine.
fn noise(i: usize, salt: usize) -> usize {
    let mut h = (i * 0x9e37_79b1 + salt * 0xc2b2_ae35) as u32;
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    ((h ^ (h >> 15)) >> 4) as usize
}

#[test]
fn long_and_wide_graphs_match_the_oracle() {
    for (seed, nodes, reach) in [(1, 900, 3), (2, 900, 30), (3, 600, 600), (4, 3000, 2)] {
        let mut graph = Graph::new(nodes);
        for v in 0..nodes {
            if noise(v, seed).is_multiple_of(7) {
                graph.terminal[v][noise(v, seed + 9) % 2] = (noise(v, seed + 10) % 90) as i64;
            }
            for k in 0..3 {
                let w = (v + 1 + noise(v, seed + 20 + k) % reach) % nodes;
                graph.edges.push(Edge {
                    ends: [v as u32, w as u32],
                    forth: (noise(v, seed + 30 + k) % 40) as i64,
                    back: (noise(v, seed + 40 + k) % 40) as i64,
                });
            }
        }
        agrees(&graph);
    }
}

#[test]
fn the_narrowest_arc_of_a_chain_is_cut() {
    let mut graph = Graph::new(50);
    graph.terminal[0] = [100, 0];
    graph.terminal[49] = [0, 100];
    let edge =
        |v: u32| Edge { ends: [v, v + 1], forth: if v == 30 { 4 } else { 9 }, back: i64::MAX };
    graph.edges = (0..49).map(edge).collect();
    let cut = agrees(&graph);
    assert_eq!(cut.flow, 4);
    assert!(cut.labels.iter().enumerate().all(|(v, &white)| white == (v <= 30)));
    assert_eq!(cut.edge_flow, vec![4; 49]);
}

#[test]
fn a_matching_is_as_large_as_it_can_be() {
    // Left v may go to right v and v + 1; right 0 is nobody's but left 0's.
    let mut graph = Graph::new(20);
    (0..10).for_each(|v| graph.terminal[v] = [1, 0]);
    (10..20).for_each(|v| graph.terminal[v] = [0, 1]);
    for v in 0..10 {
        for w in [10 + v, 10 + (v + 1).min(9)] {
            graph.edges.push(Edge { ends: [v, w], forth: 1, back: 0 });
        }
    }
    assert_eq!(agrees(&graph).flow, 10);
}

#[test]
fn nothing_has_a_cut_too() {
    for graph in [Graph::default(), Graph::new(3)] {
        assert_eq!(agrees(&graph).flow, 0);
    }
}

#[test]
fn what_is_beyond_the_limits_is_said() {
    let mut graph = Graph::new(2);
    graph.edges.push(Edge { ends: [0, 2], forth: 1, back: 1 });
    assert_eq!(solve_graph(&graph), Err(GraphError::NoNode { edge: 0, got: 2 }));
    graph.edges[0] = Edge { ends: [0, 1], forth: 1, back: -7 };
    let negative = GraphError::Negative { place: "edge 0".into(), got: -7 };
    assert_eq!(solve_graph(&graph), Err(negative));
    graph.edges.clear();
    graph.terminal = vec![[i64::MAX, 3], [i64::MAX, 3]];
    assert_eq!(solve_graph(&graph).unwrap().flow, 6);
    graph.terminal = vec![[i64::MAX, i64::MAX]];
    assert_eq!(solve_graph(&graph), Err(GraphError::TooMuchFlow));
}
