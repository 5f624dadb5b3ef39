//! Graphs that several tests use, made without any text.

use csg_graph::{Binary, Expr, Graph, GraphBuilder, NodeId, Operator, PrimitiveKind, TransformKind};

/// The sympodial tree of the paper's Fig. 1.1a.
pub(crate) fn sympodial(cnt: f64) -> Graph {
    let mut b = GraphBuilder::new();
    let cnt = b.param("cnt", cnt);
    let trunk = b.param("trunk", 2.0);
    let [f_tr, gamma, alpha1, alpha2] =
        [("fTR", 0.96), ("gamma", -72.0), ("alpha1", -60.0), ("alpha2", 20.0)].map(|(n, v)| b.param(n, v));
    let [f_br1, f_br2, no_leaves] =
        [("fBR1", 0.73), ("fBR2", 0.67), ("noleaves", 3.0)].map(|(n, v)| b.param(n, v));
    let segments = b.param("segments", 2.0);
    let [fx, d, f_lv] = [("fxSG", 1.0 / 7.0), ("dSG", 0.5), ("fLV", 0.6)].map(|(n, v)| b.param(n, v));

    let leaf = {
        let sphere = b.primitive(PrimitiveKind::Sphere, []);
        let up = movement(&mut b, [0.0.into(), 0.0.into(), 1.0.into()], sphere);
        b.transform(TransformKind::Scale, [0.12, 0.02, 0.35].map(Expr::from), up)
    };
    let segment = {
        let cylinder = b.primitive(PrimitiveKind::Cylinder, []);
        let stem = b.transform(TransformKind::Scale, [fx.into(), fx.into(), d.into()], cylinder);
        let small = b.transform(TransformKind::UScale, [f_lv.into()], leaf);
        let turned = b.transform(TransformKind::RotX, [45.0.into()], small);
        let one = movement(&mut b, [0.0.into(), 0.0.into(), d.into()], turned);
        let other = b.transform(TransformKind::FlipXz, [], one);
        b.union([stem, one, other])
    };
    let sg = b.symbol("SG");
    let bare = {
        let cylinder = b.primitive(PrimitiveKind::Cylinder, []);
        b.transform(TransformKind::Scale, [fx.into(), fx.into(), 1.0.into()], cylinder)
    };
    let more = {
        let turned = b.transform(TransformKind::RotZ, [(-90.0).into()], sg);
        let up = movement(&mut b, [0.0.into(), 0.0.into(), d.into()], turned);
        let fewer = b.calculate([(segments, Expr::from(segments) - 1.0)], up);
        b.union([segment, fewer])
    };
    let leafless = Expr::binary(Binary::Less, cnt, no_leaves);
    let selection = Expr::choose(leafless, Expr::choose(Expr::from(segments).gt(0.0), 3.0, 2.0), 1.0);
    b.rules(sg, Some(selection), [bare, segment, more]);

    let tr = b.symbol("TR");
    let taller = {
        let smaller = b.transform(TransformKind::UScale, [f_tr.into()], tr);
        let up = movement(&mut b, [0.0.into(), 0.0.into(), 1.0.into()], smaller);
        let next = b.calculate([(trunk, Expr::from(trunk) - 1.0)], up);
        b.union([sg, next])
    };
    let branches = {
        let branch = |b: &mut GraphBuilder, alpha, factor| {
            let smaller = b.transform(TransformKind::UScale, [Expr::from(factor)], tr);
            let turned = b.transform(TransformKind::RotX, [Expr::from(alpha)], smaller);
            b.calculate([(cnt, Expr::from(cnt) - 1.0)], turned)
        };
        let left = branch(&mut b, alpha1, f_br1);
        let right = branch(&mut b, alpha2, f_br2);
        let both = b.operator(Operator::Union, left, right);
        let turned = b.transform(TransformKind::RotZ, [gamma.into()], both);
        let up = movement(&mut b, [0.0.into(), 0.0.into(), 1.0.into()], turned);
        b.union([sg, up])
    };
    let selection =
        Expr::choose(Expr::from(trunk).gt(0.0), 2.0, Expr::choose(Expr::from(cnt).gt(0.0), 3.0, 1.0));
    b.rules(tr, Some(selection), [sg, taller, branches]);
    b.finish(tr).expect("Fig. 1.1a is sound")
}

/// A node moved.
pub(crate) fn movement(b: &mut GraphBuilder, offset: [Expr; 3], body: NodeId) -> NodeId {
    b.transform(TransformKind::Move, offset, body)
}
