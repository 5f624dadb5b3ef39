//! The states that matter to a ray: those that are more than a name, a choice or a transformation of another one.
//!
//! Following S-, C- and T-nodes down to the next operator or primitive leads to an [instance](super::instance) of a state that
//! matters. Unions in unions of one rule are one union, and successive subtractions one subtraction: a \\ b \\ c has the
//! operands a and b ∪ c.
//!
//! A state has a number as soon as something leads to it, and is [resolved](States::resolve) once, when somebody wants to
//! know what it is: all of them before the first ray, or, where there are too many, few at a time.

use std::cell::OnceCell;

use csg_graph::{EvalError, Fault, Graph, Node, Operator, Primitive, State, Step};
use csg_graph_bounds::Aabb;
use rustc_hash::{FxBuildHasher, FxHashMap};

use super::bounds::{Bounds, Extent};
use super::instance::{Instance, inverse, paint_over};
use super::slabs::Reach;
use super::unions::Unions;
use crate::narrow::index;

/// The most S-nodes that may follow each other without an operator. Where all states are listed there are never as many.
const LONGEST: u32 = 5_000_000;

/// States with their numbers, those that are not resolved yet among them.
pub(crate) struct States<'a> {
    pub(super) graph: &'a Graph,
    pub(super) unions: &'a Unions,
    pub(super) bounds: Bounds<'a>,
    pub(crate) states: Vec<Resolved>,
    numbers: FxHashMap<State, u32>,
    /// The numbers of those that are resolved, each behind those below it if all are.
    pub(crate) order: Vec<u32>,
}

/// A state in a walk that comes to it before what is below it, and again after that.
enum Visit {
    Before(u32),
    After(u32),
}

pub(crate) struct Resolved {
    pub(crate) state: State,
    pub(crate) kind: Kind,
    /// Once somebody has asked for it.
    extent: OnceCell<Extent>,
}

#[derive(Clone)]
pub(crate) enum Kind {
    /// Not resolved yet.
    Unknown,
    /// Of parts, those of unions in unions among them.
    Union(Vec<Instance>),
    /// Of operands, with the parts of those that are unions.
    Solid(Operator, [Vec<Instance>; 2]),
    Primitive(Primitive),
}

impl<'a> States<'a> {
    /// No states yet, with room for some.
    pub(crate) fn new(graph: &'a Graph, unions: &'a Unions, bounds: Bounds<'a>, room: usize) -> Self {
        let (states, order) = (Vec::with_capacity(room), Vec::with_capacity(room));
        let numbers = FxHashMap::with_capacity_and_hasher(room, FxBuildHasher);
        Self { graph, unions, bounds, states, numbers, order }
    }

    /// Resolves all states that the root leads to.
    pub(crate) fn all(
        graph: &'a Graph,
        unions: &'a Unions,
        bounds: Bounds<'a>,
    ) -> Result<(Self, Instance), EvalError> {
        let mut all = Self::new(graph, unions, bounds, 0);
        let root = all.instance(graph.root_state())?;
        all.resolve_down_to(root.target, true)?;
        Ok((all, root))
    }

    /// What a state is. Only now is what is directly below it looked at, and what is in the same rule.
    pub(crate) fn resolve(&mut self, number: u32) -> Result<&Kind, EvalError> {
        self.resolve_down_to(number, false)?;
        Ok(&self.states[number as usize].kind)
    }

    /// Resolves a state, and all that is below it if that is wanted.
    fn resolve_down_to(&mut self, number: u32, all: bool) -> Result<(), EvalError> {
        let mut open = vec![Visit::Before(number)];
        while let Some(visit) = open.pop() {
            let number = match visit {
                Visit::Before(number) if matches!(self.states[number as usize].kind, Kind::Unknown) => number,
                Visit::Before(_) => continue,
                Visit::After(number) => {
                    self.order.push(number);
                    continue;
                }
            };
            open.push(Visit::After(number));
            let before = |part: &Instance| Visit::Before(part.target);
            let kind = match self.graph.step(&self.states[number as usize].state)? {
                Step::Operator(Operator::Union, [left, right]) => {
                    let room = self.unions.parts(self.states[number as usize].state.node());
                    let parts =
                        self.parts_of(vec![(Instance::at(0), right), (Instance::at(0), left)], room)?;
                    if all {
                        open.extend(parts.iter().rev().map(before));
                    }
                    Kind::Union(parts)
                }
                Step::Operator(operator, operands) => {
                    let [left, right] = self.operands_of(operator, operands)?;
                    if all {
                        open.extend(left.iter().chain(&right).rev().map(before));
                    }
                    Kind::Solid(operator, [left, right])
                }
                Step::Primitive(primitive) => Kind::Primitive(primitive),
                other => unreachable!("{other:?} was followed"),
            };
            self.states[number as usize].kind = kind;
        }
        Ok(())
    }

    /// What is open, the last first, and instead of each union in the same rule that is written out its parts, from left to
    /// right. There is `room` for so many.
    fn parts_of(
        &mut self,
        mut open: Vec<(Instance, State)>,
        room: usize,
    ) -> Result<Vec<Instance>, EvalError> {
        let mut parts = Vec::with_capacity(room);
        while let Some((mut instance, state)) = open.pop() {
            let state = self.follow(&mut instance, state)?;
            let is_union = self.is_operator_at(&state, Operator::Union);
            if instance.depth == 0 && is_union && self.unions.is_written_out(state.node()) {
                let [left, right] = self.operands_at(&state)?;
                open.extend([(instance.clone(), right), (instance, left)]);
            } else {
                instance.target = self.number(state);
                parts.push(instance);
            }
        }
        Ok(parts)
    }

    /// The parts of the operands of ∩ or \\; of successive subtractions in the same rule, of all that is subtracted.
    fn operands_of(
        &mut self,
        operator: Operator,
        [mut left, right]: [State; 2],
    ) -> Result<[Vec<Instance>; 2], EvalError> {
        let mut above = Instance::at(0);
        // What is subtracted first comes last, where it is taken from.
        let mut rights = vec![(above.clone(), right)];
        loop {
            let mut instance = above.clone();
            let state = self.follow(&mut instance, left.clone())?;
            let goes_on = operator == Operator::Difference && instance.depth == 0;
            if !(goes_on && self.is_operator_at(&state, operator)) {
                break;
            }
            let right;
            [left, right] = self.operands_at(&state)?;
            rights.push((instance.clone(), right));
            above = instance;
        }
        let room = rights.len();
        Ok([self.parts_of(vec![(above, left)], 1)?, self.parts_of(rights, room)?])
    }

    /// The instance that a state leads to: the next operator or primitive.
    pub(crate) fn instance(&mut self, state: State) -> Result<Instance, EvalError> {
        let mut instance = Instance::at(0);
        let state = self.follow(&mut instance, state)?;
        instance.target = self.number(state);
        Ok(instance)
    }

    /// Goes on from an instance to the state of the next operator or primitive, which is not its target yet.
    fn follow(&self, instance: &mut Instance, mut state: State) -> Result<State, EvalError> {
        loop {
            state = match self.graph.node(state.node()) {
                Node::Operator(_) | Node::Primitive(_) => return Ok(state),
                _ => match self.graph.step(&state)? {
                    Step::Select(_) if instance.depth == LONGEST => return Err(self.nothing(&state)),
                    Step::Select(below) => {
                        instance.depth += 1;
                        instance.symbol = self.bounds.index_of(&state);
                        below
                    }
                    Step::Calculate(below) => below,
                    Step::Attribute(terms, below) => {
                        paint_over(&mut instance.paint, terms);
                        below
                    }
                    Step::Transform(parent_from_child, below) => {
                        instance.above_from_target *= parent_from_child.to_affine();
                        instance.target_from_above = inverse(&parent_from_child) * instance.target_from_above;
                        below
                    }
                    other => unreachable!("{other:?} is not followed"),
                },
            };
        }
    }

    /// That there is no solid where a state leads.
    fn nothing(&self, state: &State) -> EvalError {
        let node = state.node();
        let at = csg_graph::Place { node, expr: None, label: self.graph.node_name(node) };
        EvalError { at, fault: Fault::Nothing, values: self.graph.live_values(state) }
    }

    /// The number of the state of an operator or a primitive.
    fn number(&mut self, state: State) -> u32 {
        let next = index(self.states.len());
        let number = *self.numbers.entry(state.clone()).or_insert(next);
        if number == next {
            self.states.push(Resolved { state, kind: Kind::Unknown, extent: OnceCell::new() });
        }
        number
    }

    /// What is known of the extent of a state.
    fn extent(&self, number: u32) -> Result<&Extent, EvalError> {
        let Resolved { state, extent, .. } = &self.states[number as usize];
        if let Some(known) = extent.get() {
            return Ok(known);
        }
        let found = self.bounds.of(state)?;
        Ok(extent.get_or_init(|| found))
    }

    /// The box of a state.
    pub(crate) fn aabb(&self, number: u32) -> Result<Aabb, EvalError> {
        Ok(self.extent(number)?.aabb)
    }

    pub(crate) fn get(&self, instance: &Instance) -> &Resolved {
        &self.states[instance.target as usize]
    }

    /// Whether an instance is a union, resolved or not.
    pub(crate) fn is_union(&self, instance: &Instance) -> bool {
        self.is_operator_at(&self.get(instance).state, Operator::Union)
    }

    /// Whether the box of an instance becomes closer by a look at what is behind it, and for what that takes.
    pub(super) fn is_worth_a_look(&self, instance: &Instance) -> bool {
        self.is_union(instance) && self.bounds.are_common(&self.get(instance).state)
    }

    /// How many parts an instance has as a union, resolved or not.
    pub(crate) fn part_count(&self, instance: &Instance) -> usize {
        self.unions.parts(self.get(instance).state.node())
    }

    pub(super) fn is_operator_at(&self, state: &State, operator: Operator) -> bool {
        matches!(self.graph.node(state.node()), Node::Operator(node) if node.operator == operator)
    }

    /// The operands of the operator at a state.
    fn operands_at(&self, state: &State) -> Result<[State; 2], EvalError> {
        match self.graph.step(state)? {
            Step::Operator(_, operands) => Ok(operands),
            other => unreachable!("{other:?} is no operator"),
        }
    }

    /// Whether an instance is a primitive, resolved or not.
    pub(crate) fn is_primitive(&self, instance: &Instance) -> bool {
        matches!(self.graph.node(self.get(instance).state.node()), Node::Primitive(_))
    }

    /// The box of an instance in the frame above: six supports, not the box of a box.
    pub(crate) fn exact_box(&self, instance: &Instance) -> Result<Aabb, EvalError> {
        let Resolved { state, kind, .. } = self.get(instance);
        let extent = self.extent(instance.target)?;
        Ok(self.bounds.image(state, extent, kind.primitive(), &instance.above_from_target))
    }

    /// How far an instance reaches along the diagonals of the frame above: eight supports more.
    pub(super) fn slabs(&self, instance: &Instance) -> Result<Reach, EvalError> {
        let Resolved { state, kind, .. } = self.get(instance);
        let extent = self.extent(instance.target)?;
        Ok(self.bounds.slabs(state, extent, kind.primitive(), &instance.above_from_target))
    }
}

impl Kind {
    fn primitive(&self) -> Option<&Primitive> {
        if let Self::Primitive(primitive) = self { Some(primitive) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use csg_graph_bounds::{Limits, exact};

    use super::*;

    #[test]
    fn what_is_subtracted_is_listed_once() {
        const HOLES: usize = 300;
        let holes: String = (0..HOLES).map(|x| format!(" \\ move({x}, 0, 0) sphere")).collect();
        let source = format!("{{ n = 1; }} PLATE PLATE -> cube{holes} \\ (cylinder | cone)");
        let graph = csg_graph_grammar::load(&source, &[]).expect("a scene").scene.graph;
        let boxes = exact(&graph, &Limits::default()).expect("boxes");
        let unions = Unions::new(&graph);
        let (states, root) = States::all(&graph, &unions, Bounds::Exact(&boxes)).expect("states");
        let Kind::Solid(Operator::Difference, [from, subtracted]) = &states.get(&root).kind else {
            panic!("a subtraction")
        };
        assert_eq!((from.len(), subtracted.len()), (1, HOLES + 2));
        // In the order of the file.
        let at: Vec<f64> = subtracted.iter().map(|hole| hole.above_from_target.translation.x).collect();
        assert!(at[..HOLES].is_sorted() && at[HOLES - 1] > 0.0);
        let solids = states.states.iter().filter(|state| matches!(state.kind, Kind::Solid(..)));
        assert_eq!(solids.count(), 1);
    }
}
