//! What a builder accepts, what it refuses, and how expressions evaluate.
#![expect(clippy::float_cmp, reason = "the language promises these values to the bit")]

mod common;

use csg_graph::{
    Binary, Expr, Fault, Function, Graph, GraphBuilder, GraphError, NodeId, Operator, PrimitiveKind,
    TransformKind, Unary,
};

fn value(expr: impl Into<Expr>) -> f64 {
    expr.into().evaluate(GraphBuilder::new().initial())
}

#[test]
fn expressions_follow_the_language() {
    let e = Expr::from;
    assert_eq!(value(e(-1.0) % 8.0), 7.0);
    assert_eq!(value(e(7.5) % -2.0), -0.5);
    assert_eq!(value(e(-1e-20) % 3.0), 3.0_f64.next_down());
    assert_eq!(value(e(1e-20) % -3.0), -3.0_f64.next_down());
    assert_eq!(value(Expr::binary(Binary::Power, 2.0, -1.0)), 0.5);
    assert_eq!(value(Expr::unary(Unary::Not, 3.0)), 0.0);
    assert_eq!(value(Expr::call(Function::Sin, [e(-90.0)])), -1.0);
    assert_eq!(value(Expr::call(Function::Atan2, [e(1.0), e(-1.0)])), 135.0);
    assert_eq!(value(Expr::call(Function::Mix, [e(2.0), e(4.0), e(0.25)])), 2.5);
    assert_eq!(value(Expr::call(Function::Sign, [e(-0.5)])), -1.0);
}

#[test]
fn not_a_number_is_contagious_except_where_it_is_not_needed() {
    let nan = || Expr::from(0.0) / 0.0;
    assert!(value(nan() + 1.0).is_nan());
    assert!(value(nan().gt(1.0)).is_nan());
    assert!(value(Expr::call(Function::Max, [nan(), 1.0.into()])).is_nan());
    assert!(value(Expr::choose(nan(), 1.0, 2.0)).is_nan());
    assert_eq!(value(Expr::choose(1.0, 2.0, nan())), 2.0);
    assert_eq!(value(Expr::binary(Binary::And, 0.0, nan())), 0.0);
    assert_eq!(value(Expr::binary(Binary::Or, 1.0, nan())), 1.0);
    assert!(value(Expr::binary(Binary::And, 1.0, nan())).is_nan());
}

#[test]
fn expressions_print_with_only_the_parentheses_that_they_need() {
    let mut b = GraphBuilder::new();
    let (x, y) = (b.param("x", 1.0), b.param("y", 2.0));
    let name = |param| if param == x { "x" } else { "y" };
    let text = |expr: Expr| expr.to_text(name);
    assert_eq!(text(Expr::from(x) - (Expr::from(y) - 1.0)), "x - (y - 1)");
    assert_eq!(text((Expr::from(x) - y) - 1.0), "x - y - 1");
    assert_eq!(text((Expr::from(x) + y) * 2.0), "(x + y) * 2");
    assert_eq!(text(-(Expr::from(x) + y)), "-(x + y)");
    assert_eq!(text(Expr::binary(Binary::Power, -Expr::from(x), 2.0)), "(-x)^2");
    assert_eq!(text(-Expr::binary(Binary::Power, x, Expr::binary(Binary::Power, y, 2.0))), "-x^y^2");
    assert_eq!(text(Expr::choose(Expr::from(x).gt(0.0), 2.0, 1.0)), "if(x > 0, 2, 1)");
}

#[test]
fn every_name_is_found_again() {
    assert!(Function::ALL.iter().all(|function| Function::named(function.name()) == Some(*function)));
    assert!(TransformKind::ALL.iter().all(|kind| TransformKind::named(kind.name()) == Some(*kind)));
    assert!(PrimitiveKind::ALL.iter().all(|kind| PrimitiveKind::named(kind.name()) == Some(*kind)));
    assert_eq!(
        (TransformKind::Rot.arity(), TransformKind::Matrix.arity(), TransformKind::FlipXy.arity()),
        (4, 12, 0)
    );
}

#[test]
fn dangling_handles_and_empty_symbols_are_refused() {
    let mut b = GraphBuilder::new();
    let stranger = NodeId::from_index(7);
    let node = b.transform(TransformKind::FlipXy, [], stranger);
    assert_eq!(b.finish(node).unwrap_err(), GraphError::Dangling { node });
    let mut b = GraphBuilder::new();
    let node = b.symbol("A");
    assert_eq!(b.finish(node).unwrap_err(), GraphError::NoRules { node, name: "A".to_owned() });
}

#[test]
fn a_cycle_without_a_symbol_is_refused() {
    let mut b = GraphBuilder::new();
    let node = b.transform(TransformKind::FlipXy, [], NodeId::from_index(1));
    b.operator(Operator::Union, node, node);
    let error = b.finish(node).unwrap_err();
    assert_eq!(error.to_string(), "a cycle passes no symbol: flipxy → ∪ → flipxy");
}

#[test]
fn what_is_singular_or_has_no_extent_is_refused_when_it_is_written_out() {
    let mut b = GraphBuilder::new();
    let ball = b.primitive(PrimitiveKind::Sphere, []);
    let flat = b.transform(TransformKind::Scale, [1.0, 0.0, 1.0].map(Expr::from), ball);
    let error = b.finish(flat).unwrap_err();
    assert_eq!(
        error.to_string(),
        "scale: the transformation scale(1, 0, 1) is singular: it cannot be undone"
    );

    let mut b = GraphBuilder::new();
    let ring = b.primitive(PrimitiveKind::Torus, [0.0.into()]);
    let flat = b.primitive(PrimitiveKind::Hull, [0.0; 12].map(Expr::from));
    let both = b.union([ring, flat]);
    let GraphError::Constants { errors } = b.finish(both).unwrap_err() else { panic!() };
    assert_eq!(errors.len(), 2, "all are told at once: {errors:?}");
    assert!(errors.iter().all(|error| matches!(error.fault, Fault::Primitive(_))), "{errors:?}");
}

#[test]
fn a_rule_that_is_never_selected_may_divide_by_zero() {
    let mut b = GraphBuilder::new();
    let segments = b.param("segments", 0.0);
    let ball = b.primitive(PrimitiveKind::Sphere, []);
    let thin = b.transform(TransformKind::UScale, [Expr::from(1.0) / segments], ball);
    let symbol = b.symbol("A");
    b.rules(symbol, Some(Expr::choose(segments, 2.0, 1.0)), [ball, thin]);
    assert!(b.finish(symbol).unwrap().analyse(&Default::default()).is_ok());
}

#[test]
fn half_spaces_need_something_that_bounds_them() {
    let finish = |make: &dyn Fn(&mut GraphBuilder, NodeId, NodeId) -> NodeId| -> Result<Graph, GraphError> {
        let mut b = GraphBuilder::new();
        let (half, ball) =
            (b.primitive(PrimitiveKind::HalfSpace, []), b.primitive(PrimitiveKind::Sphere, []));
        let root = make(&mut b, half, ball);
        b.finish(root)
    };
    let operator = |operator, swapped: bool| {
        finish(&move |b, half, ball| {
            if swapped { b.operator(operator, ball, half) } else { b.operator(operator, half, ball) }
        })
    };
    assert!(operator(Operator::Intersection, false).is_ok());
    assert!(operator(Operator::Intersection, true).is_ok());
    assert!(operator(Operator::Difference, true).is_ok());
    for unbounded in [operator(Operator::Difference, false), operator(Operator::Union, true)] {
        assert!(matches!(unbounded, Err(GraphError::Unbounded { .. })), "{unbounded:?}");
    }
    // Through a cycle: A -> half-space | A.
    let cyclic = finish(&|b, half, _| {
        let symbol = b.symbol("A");
        let both = b.operator(Operator::Union, symbol, half);
        b.rules(symbol, None, [both]);
        symbol
    });
    assert!(matches!(cyclic, Err(GraphError::Unbounded { .. })));
}

#[test]
fn the_drawing_shows_symbols_rules_and_cycles() {
    let dot = common::sympodial(8.0).to_dot();
    assert!(dot.starts_with("digraph csg {"));
    assert!(dot.contains(r#"[label = "TR\nif(trunk > 0, 2, if(cnt > 0, 3, 1))""#), "{dot}");
    assert!(dot.contains(r#"[label = "{cnt = cnt - 1}""#), "{dot}");
    assert!(dot.contains(r#"[label = "3"]"#), "{dot}");
    assert_eq!(dot.matches("constraint = false").count(), 4, "three edges back to TR and one to SG:\n{dot}");
}
