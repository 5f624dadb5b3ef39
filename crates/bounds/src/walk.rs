//! The walk through the unfolded tree that both of the paper's algorithms share, and the hyper boxes that it fills.
//!
//! [TRAX95] §2 calls the union of all boxes that a node gets, one for each instance in the unfolded tree, its *hyper
//! bounding box*. What is passed from a node to the one above it is the box of the instance, never the hyper box. The
//! algorithms differ in how a T-node comes to its box; S-, C- and operator nodes are the same in both.
//!
//! Changes versus the paper: the recursion is two explicit stacks, one of what is left to do and one of boxes that wait
//! for the node above, so that its depth costs memory and no machine stack.

use crate::limits::Meter;
use crate::{Aabb, BoundsError, Limits, Scene, Step};

/// Boxes for a whole scene: one for the root and one for every node.
///
/// Each box is in the frame in which its node stands. For a T-node that is the frame that it maps *into*: its box
/// encloses the mapped solid.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HyperBoxes {
    /// The box of the root, in the frame of the world. Its node may have a larger one, if it is met again further down.
    pub root: Aabb,
    /// For each node the union of the boxes of all its instances, each in the instance's own frame;
    /// [`Aabb::EMPTY`] for a node that is never reached.
    ///
    /// Operands of ∩ and \ have the boxes of what they are themselves, not clipped by the other operand.
    pub nodes: Vec<Aabb>,
}

/// How an algorithm comes to the boxes of shapes and T-nodes. The calls nest as the unfolded tree does.
pub(crate) trait Method<S: Scene> {
    /// The box of a shape in its own frame.
    fn shape(&mut self, shape: &S::Shape) -> Aabb;

    /// A T-node begins.
    fn enter(&mut self, parent_from_child: S::Map);

    /// A T-node ends: its box, given that of what is below it.
    fn leave(&mut self, below: Aabb) -> Aabb;

    /// The left operand of an intersection begins.
    fn enter_left(&mut self) {}

    /// The left operand of an intersection ends and the right one begins.
    fn enter_right(&mut self) {}

    /// The right operand of an intersection ends.
    fn leave_intersection(&mut self) {}

    /// The right operand of a difference begins.
    fn enter_subtrahend(&mut self) {}

    /// The right operand of a difference ends.
    fn leave_subtrahend(&mut self) {}

    /// How many boxes a shape or an intersection takes at this place.
    fn frames(&self) -> usize;

    /// How many maps and boxes are held at this place.
    fn held(&self) -> usize;
}

/// What is left to do, the last first.
enum Task<State> {
    Visit(State),
    RightOperand,
    Subtrahend,
    Close(usize, Close),
}

/// How a node's box comes from the boxes of what is below it, which are the last ones waiting.
enum Close {
    Same,
    Map,
    Union(usize),
    Intersection,
    Difference,
}

/// Walks the unfolded tree from left to right.
pub(crate) fn walk<S: Scene>(
    scene: &S,
    limits: &Limits,
    mut method: impl Method<S>,
) -> Result<HyperBoxes, BoundsError<S::Error>> {
    let mut nodes = vec![Aabb::EMPTY; scene.node_count()];
    let mut meter = Meter::new(*limits);
    let mut waiting: Vec<Aabb> = Vec::new();
    let mut tasks = vec![Task::Visit(scene.root())];
    while let Some(task) = tasks.pop() {
        match task {
            Task::Visit(state) => {
                meter.spend(1)?;
                meter.hold(tasks.len() + waiting.len() + method.held())?;
                let node = scene.node(&state);
                match scene.step(&state).map_err(BoundsError::Scene)? {
                    Step::Shape(shape) => {
                        meter.spend(method.frames() as u64)?;
                        waiting.push(method.shape(&shape));
                        tasks.push(Task::Close(node, Close::Same));
                    }
                    Step::Same(below) => {
                        tasks.extend([Task::Close(node, Close::Same), Task::Visit(below)]);
                    }
                    Step::Map(parent_from_child, below) => {
                        method.enter(parent_from_child);
                        tasks.extend([Task::Close(node, Close::Map), Task::Visit(below)]);
                    }
                    Step::Union(parts) => {
                        tasks.push(Task::Close(node, Close::Union(parts.len())));
                        tasks.extend(parts.into_iter().rev().map(Task::Visit));
                    }
                    Step::Intersection([left, right]) => {
                        meter.spend(method.frames() as u64)?;
                        method.enter_left();
                        tasks.extend([
                            Task::Close(node, Close::Intersection),
                            Task::Visit(right),
                            Task::RightOperand,
                            Task::Visit(left),
                        ]);
                    }
                    Step::Difference([left, right]) => tasks.extend([
                        Task::Close(node, Close::Difference),
                        Task::Visit(right),
                        Task::Subtrahend,
                        Task::Visit(left),
                    ]),
                }
            }
            Task::RightOperand => method.enter_right(),
            Task::Subtrahend => method.enter_subtrahend(),
            Task::Close(node, close) => {
                let mut take = || waiting.pop().expect("what is below a node left its box");
                let bounds = match close {
                    Close::Same => take(),
                    Close::Map => method.leave(take()),
                    Close::Union(parts) => (0..parts).fold(Aabb::EMPTY, |union, _| union.join(take())),
                    Close::Intersection => {
                        method.leave_intersection();
                        take().intersect(take())
                    }
                    Close::Difference => {
                        method.leave_subtrahend();
                        let _subtrahend = take();
                        take()
                    }
                };
                nodes[node] = nodes[node].join(bounds);
                waiting.push(bounds);
            }
        }
    }
    let root = waiting.pop().expect("the root left its box");
    Ok(HyperBoxes { root, nodes })
}
