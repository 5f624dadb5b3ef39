//! The states that matter to a ray: those that are more than a name, a choice or a transformation of another one.
//!
//! Following S-, C- and T-nodes down to the next operator or primitive makes a *place* of them: a state, the product of the
//! transformations that lead to it, and what paints it. Unions in unions of one rule are one union, and successive
//! subtractions one subtraction: a \\ b \\ c has the operands a and b ∪ c.
//!
//! A state has a number as soon as something leads to it, and is [resolved](States::resolve) once, when somebody wants to
//! know what it is: all of them before the first ray, or, where there are too many, few at a time.

use std::cell::OnceCell;
use std::hash::Hasher;

use csg_graph::{AttributeTerm, EvalError, Fault, Graph, Node, Operator, Primitive, State, Step, Transform};
use csg_graph_bounds::Aabb;
use glam::{DAffine3, DMat3, DVec3};
use rustc_hash::{FxBuildHasher, FxHashMap, FxHasher};
use smallvec::SmallVec;

use super::bounds::{Bounds, Extent};
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
    Union(Vec<Place>),
    /// Of operands, with the parts of those that are unions.
    Solid(Operator, [Vec<Place>; 2]),
    Primitive(Primitive),
}

/// A state under the transformations and attributes that lead to it.
#[derive(Clone)]
pub(crate) struct Place {
    /// The number of the state.
    pub(crate) target: u32,
    pub(crate) above_from_target: DAffine3,
    pub(crate) target_from_above: DAffine3,
    /// S-nodes between.
    pub(crate) depth: u32,
    /// The state of the last of these, by its place among all states, if they are listed.
    pub(crate) symbol: Option<u32>,
    pub(crate) paint: Paint,
}

/// What paints something: each term once. A colour has three terms.
pub(crate) type Paint = SmallVec<[(AttributeTerm, f64); 3]>;

/// Paints what is inside of something painted. Of each term, the innermost value is seen.
pub(crate) fn paint_over(paint: &mut Paint, inner: impl IntoIterator<Item = (AttributeTerm, f64)>) {
    for (term, value) in inner {
        match paint.iter_mut().find(|(known, _)| *known == term) {
            Some((_, seen)) => *seen = value,
            None => paint.push((term, value)),
        }
    }
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
    ) -> Result<(Self, Place), EvalError> {
        let mut all = Self::new(graph, unions, bounds, 0);
        let root = all.place(graph.root_state())?;
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
            let before = |part: &Place| Visit::Before(part.target);
            let kind = match self.graph.step(&self.states[number as usize].state)? {
                Step::Operator(Operator::Union, [left, right]) => {
                    let room = self.unions.parts(self.states[number as usize].state.node());
                    let parts = self.parts_of(vec![(Place::at(0), right), (Place::at(0), left)], room)?;
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
    fn parts_of(&mut self, mut open: Vec<(Place, State)>, room: usize) -> Result<Vec<Place>, EvalError> {
        let mut parts = Vec::with_capacity(room);
        while let Some((mut place, state)) = open.pop() {
            let state = self.follow(&mut place, state)?;
            let is_union = self.is_operator_at(&state, Operator::Union);
            if place.depth == 0 && is_union && self.unions.is_written_out(state.node()) {
                let [left, right] = self.operands_at(&state)?;
                open.extend([(place.clone(), right), (place, left)]);
            } else {
                place.target = self.number(state);
                parts.push(place);
            }
        }
        Ok(parts)
    }

    /// The parts of the operands of ∩ or \\; of successive subtractions in the same rule, of all that is subtracted.
    fn operands_of(
        &mut self,
        operator: Operator,
        [mut left, right]: [State; 2],
    ) -> Result<[Vec<Place>; 2], EvalError> {
        let mut above = Place::at(0);
        // What is subtracted first comes last, where it is taken from.
        let mut rights = vec![(above.clone(), right)];
        loop {
            let mut place = above.clone();
            let state = self.follow(&mut place, left.clone())?;
            let goes_on = operator == Operator::Difference && place.depth == 0;
            if !(goes_on && self.is_operator_at(&state, operator)) {
                break;
            }
            let right;
            [left, right] = self.operands_at(&state)?;
            rights.push((place.clone(), right));
            above = place;
        }
        let room = rights.len();
        Ok([self.parts_of(vec![(above, left)], 1)?, self.parts_of(rights, room)?])
    }

    /// The place that a state leads to: the next operator or primitive.
    pub(crate) fn place(&mut self, state: State) -> Result<Place, EvalError> {
        let mut place = Place::at(0);
        let state = self.follow(&mut place, state)?;
        place.target = self.number(state);
        Ok(place)
    }

    /// Goes on from a place to the state of the next operator or primitive, which is not its target yet.
    fn follow(&self, place: &mut Place, mut state: State) -> Result<State, EvalError> {
        loop {
            state = match self.graph.node(state.node()) {
                Node::Operator(_) | Node::Primitive(_) => return Ok(state),
                _ => match self.graph.step(&state)? {
                    Step::Select(_) if place.depth == LONGEST => return Err(self.nothing(&state)),
                    Step::Select(below) => {
                        place.depth += 1;
                        place.symbol = self.bounds.index_of(&state);
                        below
                    }
                    Step::Calculate(below) => below,
                    Step::Attribute(terms, below) => {
                        paint_over(&mut place.paint, terms);
                        below
                    }
                    Step::Transform(parent_from_child, below) => {
                        place.above_from_target *= parent_from_child.to_affine();
                        place.target_from_above = inverse(&parent_from_child) * place.target_from_above;
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

    pub(crate) fn get(&self, place: &Place) -> &Resolved {
        &self.states[place.target as usize]
    }

    /// Whether a place is a union, resolved or not.
    pub(crate) fn is_union(&self, place: &Place) -> bool {
        self.is_operator_at(&self.get(place).state, Operator::Union)
    }

    /// Whether the box of a place becomes closer by a look at what is behind it, and for what that takes.
    pub(super) fn is_worth_a_look(&self, place: &Place) -> bool {
        self.is_union(place) && self.bounds.are_common(&self.get(place).state)
    }

    /// How many parts a place has as a union, resolved or not.
    pub(crate) fn part_count(&self, place: &Place) -> usize {
        self.unions.parts(self.get(place).state.node())
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

    /// Whether a place is a primitive, resolved or not.
    pub(crate) fn is_primitive(&self, place: &Place) -> bool {
        matches!(self.graph.node(self.get(place).state.node()), Node::Primitive(_))
    }

    /// The box of a place in the frame above: six supports, not the box of a box.
    pub(crate) fn exact_box(&self, place: &Place) -> Result<Aabb, EvalError> {
        let Resolved { state, kind, .. } = self.get(place);
        let extent = self.extent(place.target)?;
        Ok(self.bounds.image(state, extent, kind.primitive(), &place.above_from_target))
    }

    /// How far a place reaches along the diagonals of the frame above: eight supports more.
    pub(super) fn slabs(&self, place: &Place) -> Result<Reach, EvalError> {
        let Resolved { state, kind, .. } = self.get(place);
        let extent = self.extent(place.target)?;
        Ok(self.bounds.slabs(state, extent, kind.primitive(), &place.above_from_target))
    }
}

impl Kind {
    fn primitive(&self) -> Option<&Primitive> {
        if let Self::Primitive(primitive) = self { Some(primitive) } else { None }
    }
}

impl Place {
    /// A state where it is.
    pub(crate) fn at(target: u32) -> Self {
        Self {
            target,
            above_from_target: DAffine3::IDENTITY,
            target_from_above: DAffine3::IDENTITY,
            depth: 0,
            symbol: None,
            paint: Paint::new(),
        }
    }

    /// The same for places that coincide, and hardly for others.
    pub(super) fn fingerprint(&self) -> u64 {
        let mut hasher = FxHasher::default();
        hasher.write_u32(self.target);
        // Zero has two signs.
        let entries = self.target_from_above.to_cols_array();
        entries.into_iter().for_each(|entry| hasher.write_u64((entry + 0.0).to_bits()));
        hasher.finish()
    }

    /// Whether nobody can tell the places from each other.
    pub(super) fn coincides(&self, other: &Self) -> bool {
        let Self { target, above_from_target: _, target_from_above, depth, symbol, paint } = self;
        (*target, *target_from_above, *depth, *symbol)
            == (other.target, other.target_from_above, other.depth, other.symbol)
            && *paint == other.paint
    }

    /// A place in the frame of this one's target, seen from above this one.
    pub(crate) fn then(&self, below: &Self) -> Self {
        let mut paint = self.paint.clone();
        paint_over(&mut paint, below.paint.iter().copied());
        Self {
            target: below.target,
            above_from_target: self.above_from_target * below.above_from_target,
            target_from_above: below.target_from_above * self.target_from_above,
            depth: self.depth + below.depth,
            symbol: below.symbol.or(self.symbol),
            paint,
        }
    }
}

/// The map back, as rays take it.
pub(super) fn inverse(parent_from_child: &Transform) -> DAffine3 {
    let [x, y, z] = DVec3::AXES.map(|axis| parent_from_child.inverse_vector(axis));
    let translation = parent_from_child.inverse_point(DVec3::ZERO);
    DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation }
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
