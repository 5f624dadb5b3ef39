//! The cyclic graphs of [`csg_graph`] as scenes.

use csg_graph::{EvalError, Graph, Operator, Primitive, State, Transform};
use glam::{DAffine3, DVec3};

use crate::boolean::primitive;
use crate::{Aabb, Cell, Map, PointSet, Scene, Shape, Side, Step};

impl Scene for Graph {
    type State = State;
    type Map = Transform;
    type Shape = Primitive;
    type Error = EvalError;

    fn root(&self) -> State {
        self.root_state()
    }

    fn step(&self, state: &State) -> Result<Step<Self>, EvalError> {
        Ok(match Graph::step(self, state)? {
            csg_graph::Step::Select(below)
            | csg_graph::Step::Calculate(below)
            | csg_graph::Step::Attribute(_, below) => Step::Same(below),
            csg_graph::Step::Transform(parent_from_child, below) => Step::Map(parent_from_child, below),
            csg_graph::Step::Operator(Operator::Union, operands) => Step::Union(operands.into()),
            csg_graph::Step::Operator(Operator::Intersection, operands) => Step::Intersection(operands),
            csg_graph::Step::Operator(Operator::Difference, operands) => Step::Difference(operands),
            csg_graph::Step::Primitive(primitive) => Step::Shape(primitive),
            _ => unreachable!("the two crates know the same kinds of nodes"),
        })
    }

    fn node(&self, state: &State) -> usize {
        state.node().index()
    }

    fn node_count(&self) -> usize {
        Graph::node_count(self)
    }

    fn label(&self, state: &State) -> String {
        let values = self.live_values(state).into_iter().map(|(name, value)| format!("{name} = {value}"));
        let values = values.collect::<Vec<_>>().join(", ");
        let name = self.node_name(state.node());
        if values.is_empty() { name } else { format!("{name} where {values}") }
    }
}

impl Map for Transform {
    fn affine(&self) -> DAffine3 {
        self.to_affine()
    }

    fn point(&self, point: DVec3) -> DVec3 {
        Transform::point(self, point)
    }

    fn points(&self, points: &mut [DVec3]) {
        match *self {
            Transform::Translate(offset) => points.iter_mut().for_each(|point| *point += offset),
            Transform::Scale(factors) => points.iter_mut().for_each(|point| *point *= factors),
            // As a matrix, all rotations are one loop without branches.
            _ => self.to_affine().points(points),
        }
    }
}

impl Shape for Primitive {
    fn bounds(&self) -> Aabb {
        // A body of revolution about z.
        let turned = |radius: f64, z: [f64; 2]| {
            Aabb::new(DVec3::new(-radius, -radius, z[0]), DVec3::new(radius, radius, z[1]))
        };
        match self {
            Self::Sphere | Self::Cube => turned(1.0, [-1.0, 1.0]),
            Self::Cylinder | Self::Cone => turned(1.0, [0.0, 1.0]),
            Self::Frustum { top } => turned(top.max(1.0), [0.0, 1.0]),
            // The sum is rounded, so the next number above it.
            Self::Torus { minor } => turned((1.0 + minor).next_up(), [-minor, *minor]),
            Self::Hull(hull) => Aabb::from_points(hull.points().iter().copied()),
            Self::HalfSpace => Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY.with_z(0.0) },
            // Any primitive that this version does not know.
            _ => Aabb::ALL,
        }
    }

    fn point_set(&self) -> PointSet<'_> {
        match self {
            Self::Sphere => PointSet::sphere(),
            Self::Cylinder => PointSet::cylinder(),
            Self::Cone => PointSet::cone(),
            Self::Frustum { top } => PointSet::frustum(*top),
            Self::Cube => PointSet::cube(),
            Self::Torus { minor } => PointSet::torus(*minor),
            Self::Hull(hull) => PointSet::from(hull.points()),
            _ => PointSet::Unbounded,
        }
    }

    fn support(&self, d: DVec3) -> f64 {
        match self {
            Self::Sphere => length(d),
            Self::Cylinder => length(d.with_z(0.0)) + d.z.max(0.0),
            Self::Cone => length(d.with_z(0.0)).max(d.z),
            Self::Frustum { top } => {
                let across = length(d.with_z(0.0));
                across.max(top * across + d.z)
            }
            Self::Cube => d.abs().element_sum(),
            Self::Torus { minor } => length(d.with_z(0.0)) + minor * length(d),
            Self::Hull(hull) => hull.points().iter().map(|p| p.dot(d)).fold(f64::NEG_INFINITY, f64::max),
            _ => self.bounds().support(d),
        }
    }

    fn complement_bounds(&self) -> Aabb {
        match self {
            Self::HalfSpace => Aabb { min: DVec3::NEG_INFINITY.with_z(0.0), max: DVec3::INFINITY },
            _ => Aabb::ALL,
        }
    }

    fn classify(&self, cell: &Cell) -> Side {
        primitive::classify(self, cell)
    }
}

/// The length of a vector, also where its square is out of range: directions shrink with every contraction on their way
/// down.
fn length(v: DVec3) -> f64 {
    let square = v.length_squared();
    if square > 1e-280 && square < 1e300 {
        return square.sqrt();
    }
    let largest = v.abs().max_element();
    if largest > 0.0 && largest.is_finite() { largest * (v / largest).length() } else { largest }
}
