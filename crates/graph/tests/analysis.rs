//! Counts, depth and termination, against numbers that are known otherwise.

mod common;

use common::{movement, sympodial};
use csg_graph::{
    Expr, Fault, GraphBuilder, Limits, Operator, PrimitiveKind, StatesError, TransformKind, UnfoldError,
    UnfoldedNode,
};

#[test]
fn the_sympodial_tree_is_counted_without_unfolding_it() {
    // (cnt, primitives, nodes of the unfolded tree, states, distinct states, depth)
    let known = [
        (8.0, "4097", "31042", 26, 15, 14),
        (12.0, "65537", "496642", 34, 19, 18),
        (60.0, "18446744073709551617", "139791732433580195842", 130, 67, 66),
    ];
    for (cnt, primitives, instances, states, distinct, depth) in known {
        let analysis = sympodial(cnt).analyse(&Limits::default()).unwrap();
        assert_eq!(analysis.primitives.to_string(), primitives, "cnt = {cnt}");
        assert_eq!(analysis.instances.to_string(), instances, "cnt = {cnt}");
        assert_eq!((analysis.states, analysis.distinct_states, analysis.depth), (states, distinct, depth));
    }
}

#[test]
fn counts_agree_with_the_unfolded_tree() {
    for cnt in 0..7 {
        let graph = sympodial(f64::from(cnt));
        let tree = graph.unfold(1_000_000).unwrap();
        let primitives =
            tree.nodes().iter().filter(|node| matches!(node, UnfoldedNode::Primitive { .. })).count();
        let analysis = graph.analyse(&Limits::default()).unwrap();
        assert_eq!(analysis.primitives, primitives.into(), "cnt = {cnt}");
    }
    assert_eq!(sympodial(8.0).unfold(1000).unwrap_err(), UnfoldError::TooLarge { limit: 1000 });
}

/// A symbol over its own copy with `n` less by one, from `n` down to 1, and its leaf.
fn tower(n: f64) -> csg_graph::Graph {
    let mut b = GraphBuilder::new();
    let n = b.param("n", n);
    let symbol = b.symbol("CT");
    let cone = b.primitive(PrimitiveKind::Cone, []);
    let up = movement(&mut b, [0.0.into(), 0.0.into(), 0.6.into()], symbol);
    let rest = b.calculate([(n, Expr::from(n) - 1.0)], up);
    let both = b.operator(Operator::Union, cone, rest);
    b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [cone, both]);
    b.finish(symbol).expect("a tower is sound")
}

#[test]
fn what_is_computed_for_nobody_need_not_be_known() {
    // The last assignment is to what nothing reads, so that nothing reads the two before it, nor what they are computed from.
    let mut b = GraphBuilder::new();
    let [n, first, second, third] = [("n", 3.0), ("first", 1.0), ("second", 0.0), ("third", 0.0)]
        .map(|(name, value)| b.param(name, value));
    let symbol = b.symbol("CT");
    let ball = b.primitive(PrimitiveKind::Sphere, []);
    let assignments = [
        (n, Expr::from(n) - 1.0),
        (first, Expr::from(first) + 1.0),
        (second, first.into()),
        (third, second.into()),
    ];
    let rest = b.calculate(assignments, symbol);
    b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [ball, rest]);
    let graph = b.finish(symbol).expect("it is sound");
    assert_eq!(graph.analyse(&Limits::default()).expect("it ends").depth, 4);
}

#[test]
fn a_tower_of_100_000_levels_needs_no_machine_stack() {
    let analysis = tower(100_000.0).analyse(&Limits::default()).unwrap();
    assert_eq!(analysis.primitives, 100_000_u32.into());
    assert_eq!(analysis.depth, 100_000);
    assert_eq!(analysis.chain_boxes, (100_000_u64 * 100_001 / 2).into());
    assert_eq!(tower(100_000.0).unfold(1_000_000).unwrap().nodes().len(), 199_999);
}

#[test]
fn a_state_that_comes_back_to_itself_is_a_counterexample() {
    let mut b = GraphBuilder::new();
    let n = b.param("n", 3.0);
    let (a, c) = (b.symbol("A"), b.symbol("B"));
    let flipped = b.calculate([(n, Expr::from(3.0) - n)], c);
    b.rules(a, None, [flipped]);
    let small = b.transform(TransformKind::UScale, [(Expr::from(n) + 1.0) / 8.0], a);
    b.rules(c, None, [small]);
    let error = b.finish(a).unwrap().analyse(&Limits::default()).unwrap_err();
    let StatesError::Endless { path } = &error else { panic!("{error}") };
    assert_eq!(path.iter().map(|s| s.name.as_str()).collect::<String>(), "ABABA");
    assert_eq!(path[0], path[4]);
    assert_eq!(
        error.to_string(),
        "the recursion never ends: A where n = 3 → B where n = 0 → A where n = 0 → B where n = 3 → A where n = 3"
    );
}

#[test]
fn a_parameter_that_grows_for_ever_meets_the_limit() {
    let mut b = GraphBuilder::new();
    let n = b.param("n", 0.0);
    let symbol = b.symbol("GROW");
    let ball = b.primitive(PrimitiveKind::Sphere, []);
    let next = b.calculate([(n, Expr::from(n) + 1.0)], symbol);
    b.rules(
        symbol,
        Some(Expr::choose(Expr::binary(csg_graph::Binary::Less, n, 0.0), 1.0, 2.0)),
        [ball, next],
    );
    let mut limits = Limits::default();
    limits.states = 1000;
    let graph = b.finish(symbol).unwrap();
    let error = graph.analyse(&limits).unwrap_err();
    let StatesError::TooMany { limit: 1000, path } = error else { panic!("{error}") };
    let mut few_values = Limits::default();
    few_values.values = 500;
    let error = graph.analyse(&few_values).unwrap_err();
    assert!(matches!(error, StatesError::TooMany { limit: 500, .. }), "{error}");
    let values: Vec<_> = path.iter().map(|state| state.values[0].1).collect();
    assert_eq!(values, [0.0, 1.0, 2.0, 497.0, 498.0, 499.0]);
}

#[test]
fn shared_nodes_are_counted_once_a_state_and_often_unfolded() {
    // Sixty doublings of a sphere, as a dag without any symbol.
    let mut b = GraphBuilder::new();
    let mut node = b.primitive(PrimitiveKind::Sphere, []);
    for _ in 0..60 {
        let aside = movement(&mut b, [1.0.into(), 0.0.into(), 0.0.into()], node);
        node = b.operator(Operator::Union, node, aside);
    }
    let analysis = b.finish(node).unwrap().analyse(&Limits::default()).unwrap();
    assert_eq!(analysis.primitives, (1_u64 << 60).into());
    assert_eq!((analysis.states, analysis.node_states, analysis.depth), (0, 121, 0));
}

#[test]
fn dead_parameters_tell_no_states_apart() {
    // `side` is assigned on both ways and read on neither; `n` is read.
    let mut b = GraphBuilder::new();
    let (n, side) = (b.param("n", 10.0), b.param("side", 0.0));
    let symbol = b.symbol("A");
    let ball = b.primitive(PrimitiveKind::Sphere, []);
    let ways = [1.0, 2.0].map(|value| {
        let small = b.transform(TransformKind::UScale, [0.4.into()], symbol);
        b.calculate([(n, Expr::from(n) - 1.0), (side, value.into())], small)
    });
    let both = b.union(ways);
    b.rules(symbol, Some(Expr::choose(n, 2.0, 1.0)), [ball, both]);
    let graph = b.finish(symbol).unwrap();
    assert_eq!(graph.live_params(symbol).collect::<Vec<_>>(), [n]);
    assert_eq!(graph.analyse(&Limits::default()).unwrap().states, 11);
}

#[test]
fn evaluation_errors_name_the_place_and_the_values() {
    let mut b = GraphBuilder::new();
    let n = b.param("n", 2.0);
    let symbol = b.symbol("A");
    let ball = b.primitive(PrimitiveKind::Sphere, []);
    let next = b.calculate([(n, Expr::from(n) - 1.0)], symbol);
    let small = b.transform(TransformKind::UScale, [Expr::from(1.0) / (Expr::from(n) - 1.0)], next);
    let both = b.union([ball, small]);
    b.rules(symbol, None, [both]);
    let error = b.finish(symbol).unwrap().analyse(&Limits::default()).unwrap_err();
    let StatesError::Eval { errors } = error else { panic!("{error}") };
    let [error] = &errors[..] else { panic!("{errors:?}") };
    assert_eq!((error.at.node, error.at.expr), (small, Some(0)));
    assert_eq!(error.fault, Fault::Infinite(f64::INFINITY));
    assert_eq!(error.values, [("n".to_owned(), 1.0)]);
    assert_eq!(error.to_string(), "uscale: the result is inf; was something divided by zero? where n = 1");
}

#[test]
fn every_place_that_fails_is_named_once() {
    let mut b = GraphBuilder::new();
    let n = b.param("n", 4.0);
    let symbol = b.symbol("A");
    let ball = b.primitive(PrimitiveKind::Sphere, []);
    // Fails where n = 1, which is below the other where that fails, and then again at each level.
    let next = b.calculate([(n, Expr::from(n) - 1.0)], symbol);
    let inner = b.transform(TransformKind::UScale, [Expr::from(1.0) / (Expr::from(n) - 1.0)], next);
    // Fails where n = 2, 1, 0, …
    let moved = movement(&mut b, [Expr::from(1.0) / Expr::from(n).gt(2.0), 0.0.into(), 0.0.into()], inner);
    let both = b.union([ball, moved]);
    // The recursion that never ends is not told: what decides on it may be what fails.
    b.rules(symbol, None, [both]);
    let mut limits = Limits::default();
    limits.states = 1000;
    let error = b.finish(symbol).unwrap().analyse(&limits).unwrap_err();
    let StatesError::Eval { errors } = error else { panic!("{error}") };
    let told: Vec<_> = errors.iter().map(|error| (error.at.node, error.at.expr, error.values[0].1)).collect();
    assert_eq!(told, [(inner, Some(0), 1.0), (moved, Some(0), 2.0)]);
}
