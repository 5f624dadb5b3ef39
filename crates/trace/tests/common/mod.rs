//! Random graphs: all operators, mirrors, shears, uneven scales, parameters and recursion.

use csg_graph::{
    AttributeTerm, Expr, Graph, GraphBuilder, NodeId, Operator, ParamId, PrimitiveKind, TransformKind,
};
use csg_graph_bounds::Aabb;
use csg_graph_trace::Ray;
use glam::DVec3;
use proptest::prelude::*;

/// A right-hand side, before it is built.
#[derive(Clone, Debug)]
pub(crate) enum Term {
    Primitive(PrimitiveKind, Vec<f64>),
    Transform(TransformKind, Vec<f64>, Box<Term>),
    /// Turns by a multiple of `n`.
    TurnByParameter(f64, Box<Term>),
    Colour([f64; 3], Box<Term>),
    Operator(Operator, Box<Term>, Box<Term>),
    /// ∩ or \ with a half-space under a transformation.
    Cut(Operator, TransformKind, Vec<f64>, Box<Term>),
    /// `{n = n - 1} symbol`, where there are symbols.
    Recur(usize),
}

fn primitive() -> impl Strategy<Value = Term> {
    let plain = prop::sample::select(vec![
        PrimitiveKind::Sphere,
        PrimitiveKind::Cylinder,
        PrimitiveKind::Cone,
        PrimitiveKind::Cube,
        PrimitiveKind::Tetrahedron,
        PrimitiveKind::Octahedron,
    ]);
    prop_oneof![
        6 => plain.prop_map(|kind| Term::Primitive(kind, vec![])),
        1 => (0.1..2.0).prop_map(|top| Term::Primitive(PrimitiveKind::Frustum, vec![top])),
        1 => (0.1..0.9).prop_map(|minor| Term::Primitive(PrimitiveKind::Torus, vec![minor])),
    ]
}

fn transform() -> impl Strategy<Value = (TransformKind, Vec<f64>)> {
    let factor = || prop_oneof![3 => 0.3..1.3, 1 => -1.3..-0.3];
    prop_oneof![
        prop::collection::vec(-1.5..1.5, 3).prop_map(|args| (TransformKind::Move, args)),
        prop::collection::vec(factor(), 3).prop_map(|args| (TransformKind::Scale, args)),
        prop::collection::vec(0.5..1.1, 1).prop_map(|args| (TransformKind::UScale, args)),
        (
            prop::sample::select(vec![TransformKind::RotX, TransformKind::RotY, TransformKind::RotZ]),
            prop_oneof![Just(90.0), -180.0..180.0]
        )
            .prop_map(|(kind, angle)| (kind, vec![angle])),
        prop::collection::vec(-0.4..0.4, 6).prop_map(|args| (TransformKind::Shear, args)),
        prop::sample::select(vec![TransformKind::FlipXy, TransformKind::FlipXz, TransformKind::FlipYz])
            .prop_map(|kind| (kind, vec![])),
    ]
}

fn operator() -> impl Strategy<Value = Operator> {
    prop::sample::select(vec![Operator::Union, Operator::Union, Operator::Intersection, Operator::Difference])
}

fn term(leaf: BoxedStrategy<Term>) -> impl Strategy<Value = Term> {
    leaf.prop_recursive(4, 12, 2, |inner| {
        let cut = prop::sample::select(vec![Operator::Intersection, Operator::Difference]);
        prop_oneof![
            4 => (transform(), inner.clone())
                .prop_map(|((kind, args), body)| Term::Transform(kind, args, Box::new(body))),
            4 => (operator(), inner.clone(), inner.clone())
                .prop_map(|(operator, left, right)| Term::Operator(operator, Box::new(left), Box::new(right))),
            1 => (-90.0..90.0, inner.clone())
                .prop_map(|(angle, body)| Term::TurnByParameter(angle, Box::new(body))),
            1 => (prop::array::uniform3(0.0..1.0), inner.clone())
                .prop_map(|(colour, body)| Term::Colour(colour, Box::new(body))),
            1 => (cut, transform(), inner)
                .prop_map(|(operator, (kind, args), body)| Term::Cut(operator, kind, args, Box::new(body))),
        ]
    })
}

/// Two symbols with an ending rule and a recursive rule each; the first is the axiom.
pub(crate) fn graph() -> impl Strategy<Value = Graph> {
    let ending = || term(primitive().boxed());
    let recursive = || {
        let leaf = prop_oneof![3 => primitive(), 2 => (0..2_usize).prop_map(Term::Recur)];
        term(leaf.boxed())
    };
    ([ending(), ending()], [recursive(), recursive()], 0..4_i32)
        .prop_map(|(endings, recursions, n)| build(&endings, &recursions, n.into()))
        .prop_filter("too large", |graph| graph.unfold(2000).is_ok_and(|tree| tree.nodes().len() < 300))
}

fn build(endings: &[Term; 2], recursions: &[Term; 2], n: f64) -> Graph {
    let mut builder = GraphBuilder::new();
    let param = builder.param("n", n);
    let symbols = ["A", "B"].map(|name| builder.symbol(name));
    for (index, symbol) in symbols.into_iter().enumerate() {
        let rules =
            [&endings[index], &recursions[index]].map(|term| add(&mut builder, term, &symbols, param));
        let selection = Expr::choose(Expr::from(param).gt(0.0), 2.0, 1.0);
        builder.rules(symbol, Some(selection), rules);
    }
    builder.finish(symbols[0]).expect("a sound graph")
}

fn add(builder: &mut GraphBuilder, term: &Term, symbols: &[NodeId; 2], n: ParamId) -> NodeId {
    let exprs = |args: &[f64]| args.iter().copied().map(Expr::from).collect::<Vec<_>>();
    match term {
        Term::Primitive(kind, args) => builder.primitive(*kind, exprs(args)),
        Term::Transform(kind, args, body) => {
            let body = add(builder, body, symbols, n);
            builder.transform(*kind, exprs(args), body)
        }
        Term::TurnByParameter(angle, body) => {
            let body = add(builder, body, symbols, n);
            builder.transform(TransformKind::RotZ, [Expr::from(n) * *angle], body)
        }
        Term::Colour(colour, body) => {
            let body = add(builder, body, symbols, n);
            builder.attribute(AttributeTerm::COLOR.into_iter().zip(exprs(colour)), body)
        }
        Term::Operator(operator, left, right) => {
            let [left, right] = [left, right].map(|operand| add(builder, operand, symbols, n));
            builder.operator(*operator, left, right)
        }
        Term::Cut(operator, kind, args, body) => {
            let body = add(builder, body, symbols, n);
            let half_space = builder.primitive(PrimitiveKind::HalfSpace, []);
            let half_space = builder.transform(*kind, exprs(args), half_space);
            builder.operator(*operator, body, half_space)
        }
        Term::Recur(symbol) => builder.calculate([(n, Expr::from(n) - 1.0)], symbols[*symbol]),
    }
}

/// Rays from outside of a box to places in it, given as numbers from 0 to 1.
pub(crate) fn ray_into(bounds: &Aabb, place: [f64; 3], from: [f64; 3]) -> Ray {
    let target = bounds.min + bounds.size() * DVec3::from(place);
    let outward = (DVec3::from(from) - 0.5).normalize_or(DVec3::X);
    let origin = bounds.center() + outward * (bounds.size().length() + 1.0);
    Ray { origin, direction: target - origin }
}
