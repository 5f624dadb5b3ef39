//! The sympodial tree of the paper's Fig. 1.1a, built node by node.

use csg_graph::{Binary, Expr, Graph, GraphBuilder, NodeId, Operator, PrimitiveKind, TransformKind};

use PrimitiveKind::{Cylinder, Sphere};
use TransformKind::{FlipXz, Move, RotX, RotZ, Scale, UScale};

/// `T₁ T₂ … body`, the first transformation outermost.
fn mapped<const N: usize>(
    builder: &mut GraphBuilder,
    maps: [(TransformKind, &[f64]); N],
    body: NodeId,
) -> NodeId {
    maps.into_iter()
        .rev()
        .fold(body, |body, (kind, args)| builder.transform(kind, args.iter().copied().map(Expr::from), body))
}

/// The graph of Fig. 1.1b with branches of order `cnt`: 2^(cnt+4) + 1 primitives when it is unfolded.
pub(crate) fn sympodial(cnt: u32) -> Graph {
    let mut b = GraphBuilder::new();
    let cnt = b.param("cnt", cnt.into());
    let trunk = b.param("trunk", 2.0);
    let segments = b.param("segments", 2.0);

    let (thin, half) = (1.0 / 7.0, 0.5);
    let sphere = b.primitive(Sphere, []);
    let leaf = mapped(&mut b, [(Scale, &[0.12, 0.02, 0.35]), (Move, &[0.0, 0.0, 1.0])], sphere);
    let right_leaf = mapped(&mut b, [(Move, &[0.0, 0.0, half]), (RotX, &[45.0]), (UScale, &[0.6])], leaf);
    let left_leaf = mapped(&mut b, [(FlipXz, &[])], right_leaf);
    let cylinder = b.primitive(Cylinder, []);
    let stem = mapped(&mut b, [(Scale, &[thin, thin, half])], cylinder);
    let segment = b.union([stem, right_leaf, left_leaf]);

    // SG if(cnt < noleaves, if(segments > 0, 3, 2), 1)
    let sg = b.symbol("SG");
    let limb = mapped(&mut b, [(Scale, &[thin, thin, 1.0])], cylinder);
    let upper = mapped(&mut b, [(Move, &[0.0, 0.0, half]), (RotZ, &[-90.0])], sg);
    let fewer_segments = b.calculate([(segments, Expr::from(segments) - 1.0)], upper);
    let segments_above = b.operator(Operator::Union, segment, fewer_segments);
    let bears_leaves = Expr::binary(Binary::Less, cnt, 3.0);
    let with_leaves = Expr::choose(Expr::from(segments).gt(0.0), 3.0, 2.0);
    b.rules(sg, Some(Expr::choose(bears_leaves, with_leaves, 1.0)), [limb, segment, segments_above]);

    // TR if(trunk > 0, 2, if(cnt > 0, 3, 1))
    let tr = b.symbol("TR");
    let taller = mapped(&mut b, [(Move, &[0.0, 0.0, 1.0]), (UScale, &[0.96])], tr);
    let less_trunk = b.calculate([(trunk, Expr::from(trunk) - 1.0)], taller);
    let growing = b.operator(Operator::Union, sg, less_trunk);
    let branches = [(-60.0, 0.73), (20.0, 0.67)].map(|(alpha, factor)| {
        let branch = mapped(&mut b, [(RotX, &[alpha]), (UScale, &[factor])], tr);
        b.calculate([(cnt, Expr::from(cnt) - 1.0)], branch)
    });
    let fork = b.union(branches);
    let fork = mapped(&mut b, [(Move, &[0.0, 0.0, 1.0]), (RotZ, &[-72.0])], fork);
    let branching = b.operator(Operator::Union, sg, fork);
    let branches_left = Expr::choose(Expr::from(cnt).gt(0.0), 3.0, 1.0);
    b.rules(tr, Some(Expr::choose(Expr::from(trunk).gt(0.0), 2.0, branches_left)), [sg, growing, branching]);
    b.finish(tr).expect("Fig. 1.1a is a sound graph")
}
