//! Random graphs, and the unfolded tree walked in the most obvious way.

use csg_graph::{
    Expr, Graph, GraphBuilder, NodeId, Operator, ParamId, Primitive, PrimitiveKind, State, Step,
};
use csg_graph::{Transform, TransformKind};
use csg_graph_bounds::Aabb;
use glam::DVec3;
use proptest::prelude::*;

/// The right-hand side of a rule.
#[derive(Clone, Debug)]
pub(crate) enum Term {
    Primitive(PrimitiveKind, Vec<f64>),
    Transform(TransformKind, Vec<f64>, Box<Term>),
    Operator(Operator, Box<Term>, Box<Term>),
    /// What is in a half-space, turned and moved like this, or what is not.
    Cut(Operator, [f64; 3], Box<Term>),
    /// The symbol itself, one level further down.
    Again,
}

/// A symbol that is `step` while the parameter `n` is positive, and then `base`.
#[derive(Clone, Debug)]
pub(crate) struct Recipe {
    pub(crate) n: u8,
    pub(crate) step: Term,
    pub(crate) base: Term,
}

pub(crate) fn primitives() -> impl Strategy<Value = Term> {
    let plain = prop::sample::select(vec![
        PrimitiveKind::Sphere,
        PrimitiveKind::Cylinder,
        PrimitiveKind::Cone,
        PrimitiveKind::Cube,
        PrimitiveKind::Tetrahedron,
        PrimitiveKind::Octahedron,
        PrimitiveKind::Dodecahedron,
        PrimitiveKind::Icosahedron,
    ]);
    prop_oneof![
        4 => plain.prop_map(|kind| Term::Primitive(kind, vec![])),
        1 => (0.01..=3.0).prop_map(|top| Term::Primitive(PrimitiveKind::Frustum, vec![top])),
        1 => (0.01..=1.0).prop_map(|minor| Term::Primitive(PrimitiveKind::Torus, vec![minor])),
    ]
}

/// Moves, mirrors, turns, shears, and scales that are not uniform.
pub(crate) fn transforms() -> impl Strategy<Value = (TransformKind, Vec<f64>)> {
    use TransformKind::{FlipXy, FlipXz, FlipYz, Move, Rot, RotX, RotY, RotZ, Scale, Shear, UScale};
    let factor = || prop_oneof![0.2..2.0, -2.0..-0.2];
    let angle = || -360.0..360.0;
    prop_oneof![
        prop::array::uniform3(-3.0..3.0).prop_map(|v| (Move, v.to_vec())),
        prop::array::uniform3(factor()).prop_map(|v| (Scale, v.to_vec())),
        factor().prop_map(|v| (UScale, vec![v])),
        (prop::sample::select(vec![RotX, RotY, RotZ]), angle()).prop_map(|(kind, v)| (kind, vec![v])),
        (0.1..1.0, -1.0..1.0, -1.0..1.0, angle()).prop_map(|(x, y, z, v)| (Rot, vec![x, y, z, v])),
        prop::sample::select(vec![FlipXy, FlipXz, FlipYz]).prop_map(|kind| (kind, vec![])),
        prop::array::uniform6(-0.3..0.3).prop_map(|v| (Shear, v.to_vec())),
    ]
}

/// Primitives that are the hulls of their points.
fn polytopes() -> impl Strategy<Value = Term> {
    let kinds = [PrimitiveKind::Cube, PrimitiveKind::Tetrahedron, PrimitiveKind::Dodecahedron];
    prop::sample::select(kinds.to_vec()).prop_map(|kind| Term::Primitive(kind, vec![]))
}

fn terms(
    operators: &'static [Operator],
    cuts: u32,
    primitives: impl Strategy<Value = Term> + 'static,
) -> impl Strategy<Value = Term> {
    let leaf = prop_oneof![1 => primitives, 1 => Just(Term::Again)];
    leaf.prop_recursive(8, 32, 2, move |below| {
        let boxed = || below.clone().prop_map(Box::new);
        let operator = prop::sample::select(operators);
        let cut = prop::sample::select(vec![Operator::Intersection, Operator::Difference]);
        prop_oneof![
            4 => (transforms(), boxed()).prop_map(|((kind, args), body)| Term::Transform(kind, args, body)),
            4 => (operator, boxed(), boxed()).prop_map(|(op, left, right)| Term::Operator(op, left, right)),
            cuts => (cut, prop::array::uniform3(-90.0..90.0), boxed())
                .prop_map(|(op, turn, body)| Term::Cut(op, turn, body)),
        ]
    })
}

/// Recursive solids with all operators.
pub(crate) fn recipes() -> impl Strategy<Value = Recipe> {
    let operators = &[Operator::Union, Operator::Union, Operator::Intersection, Operator::Difference];
    (0..4_u8, terms(operators, 1, primitives()), primitives()).prop_map(|(n, step, base)| Recipe {
        n,
        step,
        base,
    })
}

/// Recursive unions.
pub(crate) fn union_recipes() -> impl Strategy<Value = Recipe> {
    let step = terms(&[Operator::Union], 0, primitives());
    (0..4_u8, step, primitives()).prop_map(|(n, step, base)| Recipe { n, step, base })
}

/// Recursive unions of polytopes.
pub(crate) fn polytope_recipes() -> impl Strategy<Value = Recipe> {
    let step = terms(&[Operator::Union], 0, polytopes());
    (0..4_u8, step, polytopes()).prop_map(|(n, step, base)| Recipe { n, step, base })
}

impl Recipe {
    /// The cyclic graph.
    pub(crate) fn graph(&self) -> Graph {
        let mut builder = GraphBuilder::new();
        let n = builder.param("n", self.n.into());
        let symbol = builder.symbol("X");
        let base = build(&mut builder, &self.base, &mut |_| unreachable!("a base is a primitive"));
        let step = build(&mut builder, &self.step, &mut |builder| again(builder, n, symbol));
        builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 1.0, 2.0)), [step, base]);
        builder.finish(symbol).unwrap()
    }

    /// The same solid as a dag, one copy of the step a level, or as a tree, one copy of everything.
    pub(crate) fn acyclic(&self, shared: bool) -> Graph {
        let mut builder = GraphBuilder::new();
        let root = if shared {
            let mut level = build(&mut builder, &self.base, &mut |_| unreachable!("a base is a primitive"));
            for _ in 0..self.n {
                level = build(&mut builder, &self.step, &mut |_| level);
            }
            level
        } else {
            self.tree(&mut builder, self.n)
        };
        builder.finish(root).unwrap()
    }

    fn tree(&self, builder: &mut GraphBuilder, n: u8) -> NodeId {
        let body = if n > 0 { &self.step } else { &self.base };
        build(builder, body, &mut |builder| self.tree(builder, n - 1))
    }
}

fn again(builder: &mut GraphBuilder, n: ParamId, symbol: NodeId) -> NodeId {
    builder.calculate([(n, Expr::from(n) - 1.0)], symbol)
}

fn build(
    builder: &mut GraphBuilder,
    term: &Term,
    again: &mut dyn FnMut(&mut GraphBuilder) -> NodeId,
) -> NodeId {
    let exprs = |args: &[f64]| args.iter().copied().map(Expr::from).collect::<Vec<_>>();
    match term {
        Term::Primitive(kind, args) => builder.primitive(*kind, exprs(args)),
        Term::Transform(kind, args, body) => {
            let body = build(builder, body, again);
            builder.transform(*kind, exprs(args), body)
        }
        Term::Operator(operator, left, right) => {
            let left = build(builder, left, again);
            let right = build(builder, right, again);
            builder.operator(*operator, left, right)
        }
        Term::Cut(operator, [x, y, up], body) => {
            let body = build(builder, body, again);
            let half_space = builder.primitive(PrimitiveKind::HalfSpace, []);
            let moved = builder.transform(TransformKind::Move, exprs(&[0.0, 0.0, up / 90.0]), half_space);
            let turned = builder.transform(TransformKind::RotX, exprs(&[*x]), moved);
            let turned = builder.transform(TransformKind::RotY, exprs(&[*y]), turned);
            builder.operator(*operator, body, turned)
        }
        Term::Again => again(builder),
    }
}

/// One node of the unfolded tree, with its state.
pub(crate) struct Instance {
    pub(crate) state: State,
    pub(crate) kind: Kind,
}

pub(crate) enum Kind {
    Primitive(Primitive),
    Same(Box<Instance>),
    Map(Transform, Box<Instance>),
    Operator(Operator, Box<[Instance; 2]>),
}

pub(crate) fn unfold(graph: &Graph, state: &State) -> Instance {
    let below = |state: State| Box::new(unfold(graph, &state));
    let kind = match graph.step(state).unwrap() {
        Step::Select(state) | Step::Calculate(state) | Step::Attribute(_, state) => Kind::Same(below(state)),
        Step::Transform(map, state) => Kind::Map(map, below(state)),
        Step::Operator(op, operands) => Kind::Operator(op, Box::new(operands.map(|s| unfold(graph, &s)))),
        Step::Primitive(primitive) => Kind::Primitive(primitive),
        _ => unreachable!(),
    };
    Instance { state: state.clone(), kind }
}

impl Instance {
    /// The number of the graph's node.
    pub(crate) fn node(&self) -> usize {
        self.state.node().index()
    }

    /// Whether a point of the node's frame is in the solid.
    pub(crate) fn contains(&self, p: DVec3) -> bool {
        match &self.kind {
            Kind::Primitive(primitive) => inside(primitive, p),
            Kind::Same(below) => below.contains(p),
            Kind::Map(map, below) => below.contains(map.inverse_point(p)),
            Kind::Operator(operator, operands) => {
                let [left, right] = operands.each_ref().map(|operand| operand.contains(p));
                match operator {
                    Operator::Union => left || right,
                    Operator::Intersection => left && right,
                    Operator::Difference => left && !right,
                }
            }
        }
    }

    /// The support of a union.
    pub(crate) fn support(&self, d: DVec3) -> f64 {
        match &self.kind {
            Kind::Primitive(primitive) => support_point(primitive, d).dot(d),
            Kind::Same(below) => below.support(d),
            Kind::Map(map, below) => {
                let affine = map.to_affine();
                affine.translation.dot(d) + below.support(affine.matrix3.transpose() * d)
            }
            Kind::Operator(Operator::Union, operands) => {
                operands.iter().map(|operand| operand.support(d)).fold(f64::NEG_INFINITY, f64::max)
            }
            Kind::Operator(..) => unreachable!("only unions have a simple support"),
        }
    }

    /// The exact box of a union.
    pub(crate) fn exact_box(&self) -> Aabb {
        let h = |sign: f64| DVec3::AXES.map(|axis| sign * self.support(sign * axis));
        Aabb::new(DVec3::from_array(h(-1.0)), DVec3::from_array(h(1.0)))
    }

    /// Calls `see` for every node of the tree.
    pub(crate) fn visit(&self, see: &mut dyn FnMut(&Instance)) {
        see(self);
        match &self.kind {
            Kind::Primitive(_) => {}
            Kind::Same(below) | Kind::Map(_, below) => below.visit(see),
            Kind::Operator(_, operands) => operands.iter().for_each(|operand| operand.visit(see)),
        }
    }

    /// Points on the surfaces of the primitives that are in the solid, in the node's frame; those of every node below
    /// are shown to `see` in that node's frame.
    pub(crate) fn sample(&self, see: &mut dyn FnMut(&State, DVec3)) -> Vec<DVec3> {
        let points: Vec<DVec3> = match &self.kind {
            Kind::Primitive(primitive) => directions().map(|d| support_point(primitive, d)).collect(),
            Kind::Same(below) => below.sample(see),
            Kind::Map(map, below) => below.sample(see).into_iter().map(|p| map.point(p)).collect(),
            Kind::Operator(operator, operands) => {
                let [left, right] = operands.each_ref().map(|operand| operand.sample(see));
                let found = left.into_iter().chain(right);
                match operator {
                    Operator::Union => found.collect(),
                    _ => found.filter(|p| self.contains(*p)).collect(),
                }
            }
        };
        points.iter().for_each(|p| see(&self.state, *p));
        points
    }
}

/// Some directions all over the sphere (a Fibonacci lattice).
pub(crate) fn directions() -> impl Iterator<Item = DVec3> {
    const COUNT: i32 = 48;
    (0..COUNT).map(|i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(COUNT);
        let angle = 2.399_963_229_728_653 * f64::from(i);
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * libm::cos(angle), s * libm::sin(angle), z)
    })
}

pub(crate) fn inside(primitive: &Primitive, p: DVec3) -> bool {
    let rho = p.truncate().length();
    match primitive {
        Primitive::Sphere => p.length() <= 1.0,
        Primitive::Cylinder => rho <= 1.0 && (0.0..=1.0).contains(&p.z),
        Primitive::Cone => rho <= 1.0 - p.z && (0.0..=1.0).contains(&p.z),
        Primitive::Frustum { top } => rho <= 1.0 + (top - 1.0) * p.z && (0.0..=1.0).contains(&p.z),
        Primitive::Cube => p.abs().max_element() <= 1.0,
        Primitive::Torus { minor } => DVec3::new(rho - 1.0, 0.0, p.z).length() <= *minor,
        Primitive::Hull(hull) => hull.faces().iter().all(|face| face.normal.dot(p) <= face.offset),
        Primitive::HalfSpace => p.z <= 0.0,
        _ => unreachable!(),
    }
}

/// A point of the primitive that is the furthest in direction `d`; of a half-space, some point of its plane.
pub(crate) fn support_point(primitive: &Primitive, d: DVec3) -> DVec3 {
    let across = d.truncate().normalize_or_zero();
    let furthest = |points: &[DVec3]| {
        points.iter().copied().max_by(|a, b| a.dot(d).total_cmp(&b.dot(d))).expect("there are points")
    };
    match primitive {
        Primitive::Sphere => d.normalize_or_zero(),
        Primitive::Cylinder => furthest(&[across.extend(0.0), across.extend(1.0)]),
        Primitive::Cone => furthest(&[across.extend(0.0), DVec3::Z]),
        Primitive::Frustum { top } => furthest(&[across.extend(0.0), (*top * across).extend(1.0)]),
        Primitive::Cube => DVec3::ONE.copysign(d),
        Primitive::Torus { minor } => across.extend(0.0) + *minor * d.normalize_or_zero(),
        Primitive::Hull(hull) => furthest(hull.points()),
        Primitive::HalfSpace => (10.0 * d.truncate()).extend(0.0),
        _ => unreachable!(),
    }
}
