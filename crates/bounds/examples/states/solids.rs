//! Recursive solids as graphs; the tests bound them too.

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
    b.finish(tower).expect("a tower is a sound graph")
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
    b.finish(symbol).expect("the tetrahedron is a sound graph")
}

/// `scenes/cheese.pcsg`: what is left of a cube after all balls of a sponge are taken out of it.
pub(crate) fn cheese(b: &mut GraphBuilder, n: u32) -> NodeId {
    let n = b.param("n", n.into());
    let holes = b.symbol("HO");
    let sphere = b.primitive(PrimitiveKind::Sphere, []);
    let ball = mapped(b, UScale, [1.07], sphere);
    let steps = [-2.0 / 3.0, 0.0, 2.0 / 3.0];
    let mut cells = Vec::new();
    for at in steps.iter().flat_map(|x| steps.iter().flat_map(move |y| steps.map(|z| [*x, *y, z]))) {
        if at.iter().filter(|step| **step == 0.0).count() < 2 {
            let smaller = mapped(b, UScale, [1.0 / 3.0], holes);
            cells.push(mapped(b, Move, at, smaller));
        }
    }
    let cells = b.union(cells);
    let rest = b.calculate([(n, Expr::from(n) - 1.0)], cells);
    let both = b.operator(Operator::Union, ball, rest);
    b.rules(holes, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [ball, both]);
    let cube = b.primitive(PrimitiveKind::Cube, []);
    b.operator(Operator::Difference, cube, holes)
}
