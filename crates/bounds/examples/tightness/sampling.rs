//! The slow twin: the box of points that are in the solid, found by asking for many.
//!
//! A grid in the exact box first. Then, for each of the six directions, steps from the furthest point found so far, of
//! random direction and ever shorter; those that stay inside and lead further count.

use csg_graph::{Graph, Operator, Primitive, UnfoldedNode, UnfoldedTree};
use csg_graph_bounds::Aabb;
use glam::{DAffine3, DVec3};

use crate::random::Random;

const GRID: u32 = 40;
const STEPS: u32 = 4000;

pub(crate) fn sample(graph: &Graph, bounds: Aabb) -> Result<Aabb, Box<dyn std::error::Error>> {
    let solid = Solid::new(&graph.unfold(1_000_000)?);
    let size = bounds.size();
    let mut found = Vec::new();
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(GRID);
    for x in 0..GRID {
        for y in 0..GRID {
            for z in 0..GRID {
                let point = bounds.min + size * DVec3::new(at(x), at(y), at(z));
                if solid.contains(point) {
                    found.push(point);
                }
            }
        }
    }
    let mut random = Random::new(1);
    let grid = Aabb::from_points(found.iter().copied());
    let ends = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]).filter_map(|direction| {
        let furthest = found.iter().copied().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))?;
        Some(climb(&solid, furthest, direction, size / f64::from(GRID), &mut random))
    });
    Ok(grid.join(Aabb::from_points(ends)))
}

/// Goes on from a point as long as steps lead further.
fn climb(solid: &Solid, mut point: DVec3, direction: DVec3, mut step: DVec3, random: &mut Random) -> DVec3 {
    let mut failed = 0;
    for _ in 0..STEPS {
        let next = point + step * DVec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
        if next.dot(direction) > point.dot(direction) && solid.contains(next) {
            (point, failed) = (next, 0);
        } else {
            failed += 1;
            if failed == 100 {
                (step, failed) = (0.6 * step, 0);
            }
        }
    }
    point
}

/// The unfolded tree with inverted maps.
struct Solid {
    nodes: Vec<Node>,
}

enum Node {
    Primitive(Primitive, DAffine3),
    Operator(Operator, [usize; 2]),
}

impl Solid {
    fn new(tree: &UnfoldedTree) -> Self {
        let nodes = tree.nodes().iter().map(|node| match node {
            UnfoldedNode::Primitive { primitive, world_from_object, .. } => {
                Node::Primitive(primitive.clone(), world_from_object.inverse())
            }
            UnfoldedNode::Operator { operator, operands } => Node::Operator(*operator, *operands),
        });
        Self { nodes: nodes.collect() }
    }

    fn contains(&self, point: DVec3) -> bool {
        let mut inside = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            inside.push(match node {
                Node::Primitive(primitive, object_from_world) => {
                    contains(primitive, object_from_world.transform_point3(point))
                }
                Node::Operator(operator, [left, right]) => match operator {
                    Operator::Union => inside[*left] || inside[*right],
                    Operator::Intersection => inside[*left] && inside[*right],
                    Operator::Difference => inside[*left] && !inside[*right],
                },
            });
        }
        inside.last().copied().unwrap_or(false)
    }
}

fn contains(primitive: &Primitive, p: DVec3) -> bool {
    let radius = p.truncate().length();
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
        other => unreachable!("{other:?} is not in these scenes"),
    }
}
