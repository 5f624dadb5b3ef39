//! The slow obvious twin of the walk: the unfolded tree, point by point.
//!
//! All primitives of the unfolded tree are intersected, whatever is above them; their boundaries cut the line into pieces;
//! and a point in the middle of each piece is classified by asking every primitive whether it contains it, and the operators
//! whether that makes it inside. There is no graph, no box, no order of evaluation, and no algebra of spans in this, and
//! so it is what walks are tested against. It costs time in proportion to the square of the tree's size for each ray.

use csg_graph::{NodeId, Operator, Primitive, UnfoldedNode, UnfoldedTree};
use glam::{DAffine3, DVec3, Vec3Swizzles};

use crate::{Ray, shapes};

/// Where a line meets the solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// All boundaries of the solid, in order of t.
    pub crossings: Vec<Crossing>,
    /// The least distance, in t, between boundaries of primitives, whether or not they are boundaries of the solid. Where
    /// it is of the size of rounding errors, chance decides which of two comes first.
    pub clearance: f64,
}

/// A boundary of the solid on a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The parameter of the line.
    pub t: f64,
    /// Outward from the solid, of length 1, in the world.
    pub normal: DVec3,
    /// The primitive node whose surface it is.
    pub node: NodeId,
}

/// Where the whole line of `ray` meets the solid.
pub fn line(tree: &UnfoldedTree, ray: &Ray) -> Line {
    let mut boundaries: Vec<Crossing> = tree.nodes().iter().flat_map(|node| boundaries(node, ray)).collect();
    boundaries.sort_by(|a, b| a.t.total_cmp(&b.t));
    let ts: Vec<f64> = boundaries.iter().map(|boundary| boundary.t).collect();
    let clearance = ts.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let before = ts.first().map(|t| t - 1.0);
    let after = ts.last().map(|t| t + 1.0);
    let middles = before.into_iter().chain(ts.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]))).chain(after);
    let inside: Vec<bool> = middles.map(|t| contains(tree, ray.at(t))).collect();
    let changes = boundaries.into_iter().zip(inside.windows(2)).filter(|(_, sides)| sides[0] != sides[1]);
    let crossings = changes.map(|(boundary, sides)| {
        let leaving = sides[0];
        let turned = (boundary.normal.dot(ray.direction) > 0.0) != leaving;
        Crossing { normal: if turned { -boundary.normal } else { boundary.normal }, ..boundary }
    });
    Line { crossings: crossings.collect(), clearance }
}

/// Whether a point of the world is inside of the solid.
pub fn contains(tree: &UnfoldedTree, point: DVec3) -> bool {
    let mut inside: Vec<bool> = Vec::with_capacity(tree.nodes().len());
    for node in tree.nodes() {
        inside.push(match node {
            UnfoldedNode::Primitive { primitive, world_from_object, .. } => {
                primitive_contains(primitive, world_from_object.inverse().transform_point3(point))
            }
            UnfoldedNode::Operator { operator, operands: [left, right] } => {
                let (left, right) = (inside[*left], inside[*right]);
                match operator {
                    Operator::Union => left || right,
                    Operator::Intersection => left && right,
                    Operator::Difference => left && !right,
                }
            }
        });
    }
    inside.last().copied().unwrap_or(false)
}

/// Whether a point of the object frame is inside of a primitive: its definition as inequalities.
///
/// # Panics
/// If `csg-graph` has gained a primitive that this crate does not know.
pub fn primitive_contains(primitive: &Primitive, p: DVec3) -> bool {
    let radius = p.xy().length();
    let between_caps = 0.0 <= p.z && p.z <= 1.0;
    match primitive {
        Primitive::Sphere => p.length() <= 1.0,
        Primitive::Cylinder => between_caps && radius <= 1.0,
        Primitive::Cone => between_caps && radius <= 1.0 - p.z,
        Primitive::Frustum { top } => between_caps && radius <= 1.0 + (top - 1.0) * p.z,
        Primitive::Cube => p.abs().max_element() <= 1.0,
        Primitive::Torus { minor } => (radius - 1.0) * (radius - 1.0) + p.z * p.z <= minor * minor,
        Primitive::Hull(hull) => hull.faces().iter().all(|face| face.normal.dot(p) <= face.offset),
        Primitive::HalfSpace => p.z <= 0.0,
        other => unreachable!("{other:?} has no definition here"),
    }
}

fn boundaries(node: &UnfoldedNode, ray: &Ray) -> Vec<Crossing> {
    let UnfoldedNode::Primitive { primitive, world_from_object, node } = node else { return Vec::new() };
    let object_from_world = world_from_object.inverse();
    let object_ray = Ray {
        origin: object_from_world.transform_point3(ray.origin),
        direction: object_from_world.transform_vector3(ray.direction),
    };
    let spans = shapes::spans(primitive, &object_ray);
    let ends = spans.iter().flat_map(|span| [span.enter, span.exit]).filter(|end| end.t.is_finite());
    ends.map(|end| Crossing { t: end.t, normal: world_normal(&object_from_world, end.normal), node: *node })
        .collect()
}

fn world_normal(object_from_world: &DAffine3, normal: DVec3) -> DVec3 {
    (object_from_world.matrix3.transpose() * normal).normalize()
}
