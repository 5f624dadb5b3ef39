//! The paper's algorithm ([TRAX95] §3): boxes calculated from the geometry of the primitives through the whole chain of
//! transformations, instead of from boxes below.
//!
//! A path from the root to a primitive passes n T-nodes and so defines the frames C₀, the primitive's own, to Cₙ, the
//! world. The [point set](crate::PointSet) of the primitive is mapped from each frame into the next, as a sequence of
//! function applications Tₖ(…T₂(T₁(p))), and gives one box in each. The box in Cₖ belongs to the instance of the T-node
//! that maps into Cₖ; joined over all primitives below that instance, it is the instance's box. All nodes between two
//! T-nodes stand in one frame and pass their boxes up as always. Operator nodes combine the boxes of their operands in
//! their own frame *and in all frames above it*, frame by frame.
//!
//! ## Changes versus the paper
//!
//! - The paper hands each operator node two stacks of boxes, one of each operand, for all frames above it. A union would
//!   then hold the whole stack of its left operand while it walks the right one, and a tower of n cones n²/2 boxes.
//!   Joining is associative, so here each T-node instance on the current path holds *one* box, into which all primitives
//!   below it are joined as they are met: memory is linear in the depth. The same holds for the left operand of a
//!   difference, whose box is the difference's.
//! - Only an intersection needs stacks of its own: for each operand a new row of boxes, one for each T-node above, is
//!   opened on top of the current one, and the two rows are intersected, frame by frame, into it.
//! - Above an intersection, boxes through chains may be *larger* than boxes of boxes: two crossed rods have a small box
//!   in common, whose image is small, but the images of the rods, turned by 45°, have large boxes with much in common.
//!   Either box encloses the solid, so a T-node takes what is in both. That makes every box of this algorithm lie in the
//!   conventional one.
//! - The right operand of a difference shapes no box but those of its own nodes: its chains end at the operator node.
//! - The box of a primitive in C₀ is its exact one, which its point set encloses.
//! - Every box is rounded outward by what its chain may have rounded, see [`rounding`](crate::rounding).

use glam::DVec3;

use crate::rounding::Rounding;
use crate::walk::{Method, walk};
use crate::{Aabb, BoundsError, HyperBoxes, Limits, Map, PointSet, Scene, Shape};

/// Tight boxes through transform chains, for the root and every node.
///
/// Each encloses its solid, rounding included. A box of a union of transformed shapes exceeds the least one, along each
/// axis, by at most what the point sets exceed their shapes: nothing for polytopes, and at most
/// [`EXCESS`](crate::EXCESS) of its extent for the point sets of this crate. An intersection gets the intersection of
/// the boxes, a difference the box of its left operand.
///
/// # Cost
/// For each primitive of the unfolded tree, the number of its points times the number of T-nodes above it; for each
/// intersection, the number of T-nodes above it. Memory in proportion to the depth of the unfolded tree, times the
/// number of intersections nested in each other.
///
/// # Errors
/// If the scene fails to expand a state, or the unfolded tree exceeds the limits.
///
/// # Panics
/// If the scene numbers a node at or above its [`node_count`](Scene::node_count).
pub fn chain<S: Scene>(scene: &S, limits: &Limits) -> Result<HyperBoxes, BoundsError<S::Error>> {
    let world = Row { outermost: 0, start: 0 };
    walk(scene, limits, Chain { maps: Vec::new(), boxes: Vec::new(), rows: vec![world], points: Vec::new() })
}

/// The paper's stack of transformations and boxes.
struct Chain<M> {
    /// The T-nodes that have begun and not ended, the outermost first, with what their maps round.
    maps: Vec<(M, Rounding)>,
    /// The rows of boxes, one after the other. The last row has a box for each T-node from its outermost to the last.
    boxes: Vec<Aabb>,
    /// The rows that have begun and not ended; never empty.
    rows: Vec<Row>,
    /// The point set on its way up, kept for its memory.
    points: Vec<DVec3>,
}

/// Boxes of successive T-nodes, each in the frame that its T-node maps into.
#[derive(Clone, Copy)]
struct Row {
    /// The first T-node, as an index into the maps: chains end in the frame above it.
    outermost: usize,
    /// The box of the first T-node, as an index into the boxes.
    start: usize,
}

impl<M> Chain<M> {
    fn row(&self) -> Row {
        *self.rows.last().expect("the row of the world never ends")
    }

    /// How many T-nodes are above this place, up to where chains end.
    fn height(&self) -> usize {
        self.maps.len() - self.row().outermost
    }

    /// Opens a row of empty boxes for all T-nodes of the last one.
    fn open_row(&mut self) {
        let row = Row { start: self.boxes.len(), ..self.row() };
        self.boxes.resize(self.boxes.len() + self.height(), Aabb::EMPTY);
        self.rows.push(row);
    }
}

impl<S: Scene> Method<S> for Chain<S::Map> {
    fn shape(&mut self, shape: &S::Shape) -> Aabb {
        let row = self.row();
        let bounds = shape.bounds();
        self.points.clear();
        // An error without bound stands for points without bound: all frames above get the whole space.
        let mut error = match shape.point_set() {
            PointSet::Points(points) => {
                self.points.extend_from_slice(&points);
                0.0
            }
            PointSet::Unbounded => f64::INFINITY,
        };
        let mut magnitude = Aabb::from_points(self.points.iter().copied()).magnitude();
        let maps = &self.maps[row.outermost..];
        let boxes = &mut self.boxes[row.start..];
        for ((parent_from_child, rounding), joined) in maps.iter().zip(boxes).rev() {
            error = rounding.error_above(magnitude, error);
            parent_from_child.points(&mut self.points);
            let exact = Aabb::from_points(self.points.iter().copied());
            let image = exact.grown(error);
            magnitude = image.magnitude();
            *joined = joined.join(image);
        }
        bounds
    }

    fn enter(&mut self, parent_from_child: S::Map) {
        let rounding = Rounding::of(&parent_from_child.affine());
        self.maps.push((parent_from_child, rounding));
        self.boxes.push(Aabb::EMPTY);
    }

    fn leave(&mut self, below: Aabb) -> Aabb {
        let ended = self.maps.pop().zip(self.boxes.pop());
        let ((parent_from_child, _), through_chains) = ended.expect("a T-node that ends has begun");
        through_chains.intersect(below.image(&parent_from_child))
    }

    fn enter_left(&mut self) {
        self.open_row();
    }

    fn enter_right(&mut self) {
        self.rows.pop();
        self.open_row();
    }

    fn leave_intersection(&mut self) {
        self.rows.pop();
        let (row, height) = (self.row(), self.height());
        let operands = self.boxes.split_off(row.start + height);
        let (left, right) = operands.split_at(height);
        for ((joined, left), right) in self.boxes[row.start..].iter_mut().zip(left).zip(right) {
            *joined = joined.join(left.intersect(*right));
        }
    }

    fn enter_subtrahend(&mut self) {
        self.rows.push(Row { outermost: self.maps.len(), start: self.boxes.len() });
    }

    fn leave_subtrahend(&mut self) {
        self.rows.pop();
    }

    fn frames(&self) -> usize {
        1 + self.height()
    }

    fn held(&self) -> usize {
        self.maps.len() + self.boxes.len() + self.rows.len()
    }
}
