//! A graph as the prover walks it: its states by number, each with what is directly below it.

use std::collections::HashMap;

use csg_graph::{Graph, Primitive, Transform};
use csg_graph_bounds::{Aabb, ExactBoxes, Scene, Step};
use glam::{DAffine3, DVec3};

use super::random::Random;

/// The states of a graph, children before their parents, the root last.
pub(crate) struct States {
    pub(crate) all: Vec<State>,
}

pub(crate) struct State {
    pub(crate) state: csg_graph::State,
    pub(crate) node: usize,
    pub(crate) term: Term,
    /// Its exact box: for search, and to be proved.
    pub(crate) bounds: Aabb,
    /// The most T-nodes on a path below.
    pub(crate) height: usize,
}

pub(crate) enum Term {
    Shape(Primitive),
    Same(usize),
    Map(Transform, usize),
    Union(Vec<usize>),
    Intersection([usize; 2]),
    Difference([usize; 2]),
}

impl Term {
    /// The states directly below.
    pub(crate) fn below(&self) -> &[usize] {
        match self {
            Self::Shape(_) => &[],
            Self::Same(below) | Self::Map(_, below) => std::slice::from_ref(below),
            Self::Union(parts) => parts,
            Self::Intersection(operands) | Self::Difference(operands) => operands,
        }
    }
}

impl States {
    pub(crate) fn new(graph: &Graph, boxes: &ExactBoxes<Graph>) -> Self {
        let numbers: HashMap<&csg_graph::State, usize> =
            boxes.states().enumerate().map(|(number, (state, _))| (state, number)).collect();
        let mut all: Vec<State> = Vec::with_capacity(numbers.len());
        for (state, found) in boxes.states() {
            let step = Scene::step(graph, state).expect("the boxes come from the same steps");
            let term = match step {
                Step::Shape(primitive) => Term::Shape(primitive),
                Step::Same(below) => Term::Same(numbers[&below]),
                Step::Map(map, below) => Term::Map(map, numbers[&below]),
                Step::Union(parts) => Term::Union(parts.iter().map(|part| numbers[part]).collect()),
                Step::Intersection(operands) => Term::Intersection(operands.map(|operand| numbers[&operand])),
                Step::Difference(operands) => Term::Difference(operands.map(|operand| numbers[&operand])),
            };
            let below = term.below().iter().map(|below| all[*below].height).max();
            let height = below.unwrap_or(0) + usize::from(matches!(term, Term::Map(..)));
            let (state, node) = (state.clone(), Scene::node(graph, state));
            all.push(State { state, node, term, bounds: found.aabb, height });
        }
        Self { all }
    }

    pub(crate) fn root(&self) -> usize {
        self.all.len() - 1
    }

    /// A path from the root down to a primitive: the numbers of its states.
    ///
    /// Half of all paths wander and pass some random number of T-nodes, as far as there are so many. The others look for
    /// the furthest point in some direction along an axis of the root, and go where the boxes reach furthest.
    pub(crate) fn path(&self, random: &mut Random) -> Vec<usize> {
        let sought = random.sign() * random.pick(&DVec3::AXES);
        let greedy = random.chance(0.5);
        let mut root_from_here = DAffine3::IDENTITY;
        let mut wanted = random.below(self.all[self.root()].height + 1);
        let mut path = vec![self.root()];
        let mut here = self.root();
        loop {
            let below = self.all[here].term.below();
            let enough = |state: &usize| self.all[*state].height >= wanted;
            here = match (&self.all[here].term, below) {
                (Term::Shape(_), _) => return path,
                (Term::Map(parent_from_child, below), _) => {
                    wanted = wanted.saturating_sub(1);
                    root_from_here *= parent_from_child.to_affine();
                    *below
                }
                (_, [below]) => *below,
                _ if greedy => {
                    let direction = root_from_here.matrix3.transpose() * sought;
                    let reach = |state: &usize| self.all[*state].bounds.support(direction);
                    let furthest = below.iter().max_by(|a, b| reach(a).total_cmp(&reach(b)));
                    *furthest.expect("there are operands")
                }
                _ => {
                    let high: Vec<usize> = below.iter().copied().filter(enough).collect();
                    random.pick(if high.is_empty() || wanted == 0 { below } else { &high })
                }
            };
            path.push(here);
        }
    }

    /// Directions in the frame of the primitive at the end of a path that are along the axes of frames above it.
    pub(crate) fn directions(&self, path: &[usize], random: &mut Random) -> Vec<DVec3> {
        let mut directions = DVec3::AXES.to_vec();
        let mut frame_from_primitive = DAffine3::IDENTITY;
        for state in path.iter().rev() {
            if let Term::Map(parent_from_child, _) = &self.all[*state].term {
                frame_from_primitive = parent_from_child.to_affine() * frame_from_primitive;
                let rows = frame_from_primitive.matrix3.transpose();
                directions.extend((0..3).map(|axis| random.sign() * rows.col(axis)));
            }
        }
        directions.retain(|direction| direction.is_finite() && *direction != DVec3::ZERO);
        directions
    }
}
