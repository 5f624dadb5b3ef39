//! Random solids: Boolean terms of transformed primitives, from a number.

use csg_graph::{Expr, Graph, GraphBuilder, NodeId, Operator, PrimitiveKind, TransformKind};

use PrimitiveKind::{Cone, Cube, Cylinder, Dodecahedron, Frustum, HalfSpace, Sphere, Tetrahedron, Torus};
use TransformKind::{Move, Rot, Scale, Shear};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[usize::try_from(self.next() % choices.len() as u64).expect("below a length")]
    }
}

/// A term of two to sixteen primitives.
pub(crate) fn solid(seed: u64) -> Graph {
    let mut random = Random::new(seed);
    let mut builder = GraphBuilder::new();
    let depth = random.one_of(&[1, 2, 2, 3, 3, 4]);
    let root = term(&mut builder, &mut random, depth);
    builder.finish(root).expect("half-spaces are cut with only")
}

fn term(builder: &mut GraphBuilder, random: &mut Random, depth: u32) -> NodeId {
    if depth == 0 {
        return part(builder, random);
    }
    let left = term(builder, random, depth - 1);
    let operator = random.one_of(&[Operator::Union, Operator::Intersection, Operator::Difference]);
    let cut = operator != Operator::Union && random.one_of(&[false, false, true]);
    let right = if cut {
        let half_space = builder.primitive(HalfSpace, []);
        place(builder, random, half_space)
    } else {
        term(builder, random, depth - 1)
    };
    let both = builder.operator(operator, left, right);
    place(builder, random, both)
}

fn part(builder: &mut GraphBuilder, random: &mut Random) -> NodeId {
    let kinds = [Sphere, Cylinder, Cone, Frustum, Cube, Torus, Tetrahedron, Dodecahedron];
    let kind = random.one_of(&kinds);
    let args = match kind {
        Frustum => vec![random.between(0.2, 1.5)],
        Torus => vec![random.between(0.1, 0.6)],
        _ => vec![],
    };
    let part = builder.primitive(kind, args.into_iter().map(Expr::from));
    place(builder, random, part)
}

/// Turns, scales, shears and moves.
fn place(builder: &mut GraphBuilder, random: &mut Random, body: NodeId) -> NodeId {
    let mut vector = |low: f64, high: f64| [(); 3].map(|()| random.between(low, high));
    let [x, y, z] = vector(0.1, 1.0);
    let ([angle, ..], factors, offset, [shear, ..]) =
        (vector(-180.0, 180.0), vector(0.5, 1.5), vector(-0.6, 0.6), vector(-0.3, 0.3));
    let maps: [(TransformKind, &[f64]); 4] = [
        (Scale, &factors),
        (Shear, &[shear, 0.0, 0.0, 0.0, -shear, 0.0]),
        (Rot, &[x, y, z, angle]),
        (Move, &offset),
    ];
    maps.into_iter()
        .fold(body, |body, (kind, args)| builder.transform(kind, args.iter().copied().map(Expr::from), body))
}
