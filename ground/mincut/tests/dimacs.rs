//! DIMACS files in and out, and certificates that catch what is wrong.

use chiaro_mincut::{Edge, Flaw, Graph, MaxFlow, read_dimacs, solve_graph, verify};
use proptest::prelude::*;

const SMALL: &[u8] =
    b"c a diamond\np max 4 5\nn 1 s\nn 4 t\na 1 2 7\na 1 3 2\na 2 3 3\na 2 4 4\na 3 4 9\n";

#[test]
fn a_small_file_is_read_solved_and_written() {
    let problem = read_dimacs(SMALL).unwrap();
    let solution = problem.solve().unwrap();
    assert_eq!((solution.flow, solution.cut), (9, 9));
    assert_eq!(solution.arc_flow, [7, 2, 3, 4, 5]);
    assert_eq!(solution.side, [true, false, false, false]);
    assert_eq!(problem.verify(&solution), Ok(()));
    let text = problem.solution_to_dimacs(&solution);
    assert_eq!(text, "s 9\nf 1 2 7\nf 1 3 2\nf 2 3 3\nf 2 4 4\nf 3 4 5\n");
    assert_eq!(read_dimacs(problem.to_dimacs().as_bytes()).unwrap(), problem);
}

#[test]
fn arcs_that_no_flow_needs_carry_none() {
    let text =
        b"p max 3 7\nn 3 s\nn 1 t\na 3 1 5\na 3 1 6\na 1 3 9\na 2 2 8\na 2 3 4\na 1 2 3\na 3 2 1\n";
    let problem = read_dimacs(text).unwrap();
    let solution = problem.solve().unwrap();
    assert_eq!(solution.arc_flow, [5, 6, 0, 0, 0, 0, 0]);
    assert_eq!(solution.side, [false, true, true]);
    assert_eq!(problem.verify(&solution), Ok(()));
}

#[test]
fn wrong_files_are_one_sentence_with_its_line() {
    let cases: [(&[u8], usize, &str); 20] = [
        (b"", 0, "no problem line"),
        (b"p max 2 0\n", 0, "source"),
        (b"p max 2 0\nn 1 s\n", 0, "sink"),
        (b"a 1 2 3\n", 1, "comes first"),
        (b"p min 2 1\n", 1, "`min`"),
        (b"p max 2\n", 1, "number of arcs is missing"),
        (b"p max 4294967295 0\n", 1, "bytes can describe"),
        (b"p max 2 1000000000\n", 1, "bytes can describe"),
        (b"p max 2 1 1\n", 1, "one word too many"),
        (b"p max 2 1\n\np max 2 1\n", 3, "second problem line"),
        (b"p max 2 1\nn 1 s\nn 1 t\n", 3, "both source and sink"),
        (b"p max 2 1\nn 1 s\nn 2 s\n", 3, "second source"),
        (b"p max 2 1\nn 0 s\n", 2, "count from 1"),
        (b"p max 2 1\nn 3 s\n", 2, "there are 2 nodes"),
        (b"p max 2 1\nn 1 x\n", 2, "ends with s or t"),
        (b"p max 2 1\na 1 2 -3\n", 2, "`-3`"),
        (b"p max 2 1\na 1 2 9223372036854775808\n", 2, "up to 9223372036854775807"),
        (b"p max 2 1\na 1 2 3\na 1 2 3\n", 3, "more arcs than the 1"),
        (b"p max 2 1\nn 1 s\nn 2 t\n", 0, "1 are promised"),
        (b"p max 2 1\n\x00\xff\x1b[31m\n", 2, "begins with c, p, n or a"),
    ];
    for (text, line, said) in cases {
        let error = read_dimacs(text).unwrap_err();
        assert_eq!(error.line, line, "{error}");
        assert!(error.to_string().contains(said), "{error}");
        assert!(!error.to_string().contains(|c: char| c.is_control()), "{error}");
    }
}

#[test]
fn certificates_catch_every_kind_of_flaw() {
    let edge = |a, b, forth, back| Edge { ends: [a, b], forth, back };
    let graph = Graph {
        terminal: vec![[9, 0], [0, 0], [0, 9]],
        edges: vec![edge(0, 1, 4, 1), edge(1, 2, 4, 0), edge(2, 0, 3, 0)],
    };
    let good = solve_graph(&graph).unwrap();
    assert_eq!(verify(&graph, &good), Ok(()));
    let flawed = |change: &dyn Fn(&mut chiaro_mincut::GraphCut)| {
        let mut cut = good.clone();
        change(&mut cut);
        verify(&graph, &cut).unwrap_err()
    };
    assert_eq!(flawed(&|c| c.edge_flow.truncate(1)), Flaw::Length);
    let beyond = Flaw::Capacity { place: "edge 1".into(), flow: 5 };
    assert_eq!(flawed(&|c| c.edge_flow[1] = 5), beyond);
    assert_eq!(flawed(&|c| c.edge_flow[1] = 3), Flaw::Conservation { node: 1, surplus: 1 });
    assert!(matches!(flawed(&|c| c.flow = 5), Flaw::Value { .. }));
    assert!(matches!(flawed(&|c| c.labels[2] = true), Flaw::Cut { .. }));
    let canonical = flawed(&|c| c.labels[1] = true);
    assert_eq!(canonical, Flaw::Canonical { node: 1 });
    let less = flawed(&|c| {
        c.edge_flow = vec![3, 3, 0];
        c.terminal_flow = vec![[3, 0], [0, 0], [0, 3]];
        (c.flow, c.cut) = (3, 3);
    });
    assert_eq!(less, Flaw::Cut { flow: 3, cost: 4 });
    for flaw in [beyond, canonical, less] {
        assert!(!flaw.to_string().contains('\n'));
    }
}

fn problem() -> impl Strategy<Value = MaxFlow> {
    (2..=20_u32, 0..=60_usize, prop::sample::select(vec![1_i64, 9, 1 << 40])).prop_flat_map(
        |(nodes, arcs, most)| {
            let arc = (0..nodes, 0..nodes, 0..=most);
            (0..nodes, 1..nodes, prop::collection::vec(arc, arcs)).prop_map(move |(s, t, arcs)| {
                MaxFlow { nodes, source: s, sink: (s + t) % nodes, arcs }
            })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() })]

    #[test]
    fn random_problems_survive_the_text_and_their_solutions_the_check(problem in problem()) {
        prop_assert_eq!(&read_dimacs(problem.to_dimacs().as_bytes()).unwrap(), &problem);
        let solution = problem.solve().unwrap();
        prop_assert_eq!(problem.verify(&solution), Ok(()));
    }

    #[test]
    fn a_graph_as_a_file_has_the_same_flow(problem in problem(), seed in 0..1000_i64) {
        let graph = Graph {
            terminal: (0..i64::from(problem.nodes)).map(|v| [v * seed % 7, v * seed % 5]).collect(),
            edges: problem.arcs.iter().map(|&(a, b, c)| Edge { ends: [a, b], forth: c, back: c / 2 }).collect(),
        };
        let cut = solve_graph(&graph).unwrap();
        prop_assert_eq!(verify(&graph, &cut), Ok(()));
        let solution = MaxFlow::from(&graph).solve().unwrap();
        prop_assert_eq!(solution.flow, cut.flow);
        prop_assert_eq!(&solution.side[..graph.terminal.len()], &cut.labels[..]);
    }

    #[test]
    fn damaged_files_end_in_a_sentence(at in 0..SMALL.len(), byte in any::<u8>(), cut in any::<bool>()) {
        let mut text = SMALL.to_vec();
        text[at] = byte;
        if cut {
            text.truncate(at);
        }
        if let Ok(problem) = read_dimacs(&text) {
            let solution = problem.solve().unwrap();
            prop_assert_eq!(problem.verify(&solution), Ok(()));
        }
    }
}
