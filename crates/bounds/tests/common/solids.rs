//! Recursive solids that several tests bound.

use csg_graph::{Expr, Graph, GraphBuilder, NodeId, Operator, PrimitiveKind, TransformKind};

use TransformKind::{Move, UScale};

pub(crate) fn mapped<const N: usize>(
    b: &mut GraphBuilder,
    kind: TransformKind,
    args: [f64; N],
    body: NodeId,
) -> NodeId {
    b.transform(kind, args.map(Expr::from), body)
}

/// CT if(n > 1, 2, 1); 1: CT -> cone; 2: CT -> cone | {n = n-1} move(0,0,0.6) uscale(factor) CT
pub(crate) fn cone_tower(n: u32, factor: f64) -> Graph {
    let mut b = GraphBuilder::new();
    let n = b.param("n", n.into());
    let tower = b.symbol("CT");
    let cone = b.primitive(PrimitiveKind::Cone, []);
    let smaller = mapped(&mut b, UScale, [factor], tower);
    let raised = mapped(&mut b, Move, [0.0, 0.0, 0.6], smaller);
    let rest = b.calculate([(n, Expr::from(n) - 1.0)], raised);
    let both = b.operator(Operator::Union, cone, rest);
    b.rules(tower, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [cone, both]);
    b.finish(tower).unwrap()
}

pub(crate) fn sierpinski(n: u32) -> Graph {
    let mut b = GraphBuilder::new();
    let n = b.param("n", n.into());
    let symbol = b.symbol("ST");
    let tetrahedron = b.primitive(PrimitiveKind::Tetrahedron, []);
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let copies = corners.map(|corner| {
        let half = mapped(&mut b, UScale, [0.5], symbol);
        mapped(&mut b, Move, corner.map(|x| 0.5 * x), half)
    });
    let all = b.union(copies);
    let step = b.calculate([(n, Expr::from(n) - 1.0)], all);
    b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [tetrahedron, step]);
    b.finish(symbol).unwrap()
}
