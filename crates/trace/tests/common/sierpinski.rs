//! A solid as deep as one likes.

use csg_graph::{Expr, Graph, GraphBuilder, PrimitiveKind, TransformKind};

/// Sierpiński's tetrahedron of balls.
pub(crate) fn sierpinski(levels: f64) -> Graph {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", levels);
    let symbol = builder.symbol("ST");
    let ball = builder.primitive(PrimitiveKind::Sphere, []);
    let corners = [[0.5, 0.5, 0.5], [0.5, -0.5, -0.5], [-0.5, 0.5, -0.5], [-0.5, -0.5, 0.5]];
    let parts = corners.map(|corner| {
        let half = builder.transform(TransformKind::UScale, [0.5.into()], symbol);
        builder.transform(TransformKind::Move, corner.map(Expr::from), half)
    });
    let union = builder.union(parts);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], union);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [ball, rest]);
    builder.finish(symbol).expect("a sound graph")
}
