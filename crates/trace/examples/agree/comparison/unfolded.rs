//! The unfolded tree with a box at every node: what a program that knows no cycles would trace.
//!
//! The same solid as a graph without symbols, parameters and sharing: below operators, each instance of a primitive has
//! one T-node of its own, with the product of all transformations above it. The reference walk goes through it with the
//! least box of each node. So the algebra of ∪, ∩ and \ is the walk's, while states, calculations, chains of
//! transformations, and boxes that are joined over instances are left out.

use std::error::Error;

use csg_graph::{
    EvalError, Graph, GraphBuilder, NodeId, Primitive, PrimitiveKind, TransformKind, UnfoldedNode,
};
use csg_graph_bounds::{HyperBoxes, Limits, exact};
use csg_graph_trace::{Hit, Ray, Walk};
use glam::{DAffine3, DVec3};

/// The most nodes of an unfolded tree.
const LIMIT: usize = 2_000_000;

pub(crate) struct Unfolded {
    tree: Graph,
    boxes: HyperBoxes,
    /// For each node of the tree the node of the graph that it is an instance of.
    instance_of: Vec<NodeId>,
}

pub(crate) struct Tracer<'a> {
    walk: Walk<'a>,
    instance_of: &'a [NodeId],
}

impl Unfolded {
    pub(crate) fn new(graph: &Graph) -> Result<Self, Box<dyn Error>> {
        let mut builder = GraphBuilder::new();
        let mut built = Vec::new();
        let mut instances: Vec<(NodeId, NodeId)> = Vec::new();
        for node in graph.unfold(LIMIT)?.nodes() {
            built.push(match node {
                UnfoldedNode::Operator { operator, operands: [left, right] } => {
                    builder.operator(*operator, built[*left], built[*right])
                }
                UnfoldedNode::Primitive { primitive, world_from_object, node } => {
                    let (kind, numbers) = arguments(primitive);
                    let instance = builder.primitive(kind, numbers.into_iter().map(Into::into));
                    instances.push((instance, *node));
                    let rows = rows(world_from_object).map(Into::into);
                    builder.transform(TransformKind::Matrix, rows, instance)
                }
            });
        }
        let tree = builder.finish(*built.last().ok_or("a tree of nothing")?)?;
        let mut instance_of = vec![tree.root(); tree.node_count()];
        instances.into_iter().for_each(|(instance, node)| instance_of[instance.index()] = node);
        let boxes = exact(&tree, &Limits::default())?.into_hyper_boxes();
        Ok(Self { tree, boxes, instance_of })
    }

    pub(crate) fn tracer(&self) -> Tracer<'_> {
        Tracer { walk: Walk::new(&self.tree, Some(&self.boxes)), instance_of: &self.instance_of }
    }
}

impl Tracer<'_> {
    /// The first hit, on a node of the graph that was unfolded.
    pub(crate) fn nearest(&mut self, ray: &Ray) -> Result<Option<Hit>, EvalError> {
        let hit = self.walk.nearest(ray)?;
        Ok(hit.map(|hit| Hit { node: self.instance_of[hit.node.index()], ..hit }))
    }
}

/// A primitive as the language has it.
fn arguments(primitive: &Primitive) -> (PrimitiveKind, Vec<f64>) {
    match primitive {
        Primitive::Sphere => (PrimitiveKind::Sphere, vec![]),
        Primitive::Cylinder => (PrimitiveKind::Cylinder, vec![]),
        Primitive::Cone => (PrimitiveKind::Cone, vec![]),
        Primitive::Frustum { top } => (PrimitiveKind::Frustum, vec![*top]),
        Primitive::Cube => (PrimitiveKind::Cube, vec![]),
        Primitive::Torus { minor } => (PrimitiveKind::Torus, vec![*minor]),
        Primitive::Hull(hull) => {
            (PrimitiveKind::Hull, hull.points().iter().flat_map(DVec3::to_array).collect())
        }
        Primitive::HalfSpace => (PrimitiveKind::HalfSpace, vec![]),
        other => unreachable!("{other:?} is not in the language"),
    }
}

/// An affine map as the rows of a matrix.
fn rows(map: &DAffine3) -> [f64; 12] {
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let row = map.matrix3.row(axis);
        [row.x, row.y, row.z, map.translation[axis]]
    });
    std::array::from_fn(|at| [x, y, z][at / 4][at % 4])
}
