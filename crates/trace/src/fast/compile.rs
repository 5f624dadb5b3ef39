//! From states to super-nodes: the graph as a ray finds it fastest.
//!
//! Following one state at a time, as the [reference walk](crate::Walk) does, a ray meets a transformation and a box at each
//! step. Here a state is *opened*: what is below it is written out into one list of items, the largest by surface area
//! first, until the list is as long as memory allows. The items are primitives and the states where the list breaks off,
//! each with the product of the transformations on its way; a [tree](super::tree) of exact boxes makes them fast to
//! search. Each state where some list breaks off is opened likewise, once, however many lists lead to it. This is partial
//! re-braiding \[BENT17\] over a graph that is cyclic, and the entry states of \[TRAX95\] §4 with a tree instead of a grid.
//!
//! The result of ∩ or \\ is an item, too: a *solid*, compiled once for each state, with a list and a tree for each of its
//! operands, in its own frame. As nothing of an operand matters outside of the result, their boxes are clipped by that of
//! the result, Cameron's S-bounds \[CAME89\] within one operator; what is left without a box is dropped. Successive
//! subtractions are one: a \\ b \\ c has the operands a and b ∪ c.
//!
//! Nothing is unfolded: the work and the memory are the number of such states times the length of a list, and the lists
//! become shorter the more states there are.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, VecDeque};

use csg_graph::{AttributeTerm, EvalError, Graph, NodeId, Operator, Primitive, State, Step};
use csg_graph_bounds::{Aabb, ExactBoxes, Shape};
use glam::{DAffine3, DMat3, DVec3};
use rustc_hash::FxHashMap;

use super::tree::{self, Child, Node};

/// A graph compiled for tracing.
#[derive(Debug, Default)]
pub(super) struct Compiled {
    pub(super) supers: Vec<SuperNode>,
    pub(super) nodes: Vec<Node>,
    pub(super) items: Vec<Item>,
    pub(super) shapes: Vec<Primitive>,
    pub(super) solids: Vec<Solid>,
    pub(super) paints: Vec<Vec<(AttributeTerm, f64)>>,
    /// Of each item, the state of the last S-node between, by its place among all states; not among the items, where rays
    /// would carry it along.
    pub(super) symbols: Vec<Option<u32>>,
}

/// A state with what is below it written out.
#[derive(Clone, Debug)]
pub(super) struct SuperNode {
    /// The ball around it, in the frame of the state.
    pub(super) center: DVec3,
    pub(super) radius: f64,
    /// One by the radius.
    pub(super) to_unit: f64,
    /// How far its items reach: the radius, or infinitely far if some are unbounded.
    pub(super) reach: f64,
    /// Where its tree begins; `None` if it is empty.
    pub(super) root: Option<Child>,
}

/// The result of ∩ or \\.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solid {
    pub(super) operator: Operator,
    /// The operands, super-nodes in the frame of the solid.
    pub(super) operands: [u32; 2],
}

/// A part of a super-node.
#[derive(Clone, Debug)]
pub(super) struct Item {
    /// From the frame of the super-node into that of the item.
    pub(super) item_from_super: DAffine3,
    pub(super) content: Content,
    /// The node of a primitive.
    pub(super) node: NodeId,
    /// S-nodes between.
    pub(super) depth: u32,
    /// An index into the paints.
    pub(super) paint: Option<u32>,
}

/// What an item is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    /// An index into the shapes.
    Shape(u32),
    /// An index into the super-nodes.
    Super(u32),
    /// The result of ∩ or \\: an index into the solids.
    Solid(u32),
}

/// The least number of items that a list is opened to.
const SHORTEST: usize = 8;

/// What an item takes with its share of the tree.
const BYTES: usize = size_of::<Item>() + size_of::<Node>() / 5;

impl Compiled {
    /// Compiles within a budget of bytes, as far as the number of states allows.
    pub(super) fn new(graph: &Graph, boxes: &ExactBoxes<Graph>, budget: usize) -> Result<Self, EvalError> {
        let (states, root) = States::resolve(graph, boxes)?;
        let affordable = budget / BYTES;
        let mut length = affordable.max(SHORTEST);
        loop {
            // A try is given up as soon as it does not fit, so that all of them cost about as much as the last.
            if let Some(lists) = Lists::open(&states, &root, length, affordable) {
                return Ok(lists.close(&states));
            }
            length = (length / 2).max(SHORTEST);
        }
    }

    /// The memory that it takes for rays; what is looked up for hits alone is not counted.
    pub(super) fn bytes(&self) -> usize {
        let Self { supers, nodes, items, shapes, solids, paints: _, symbols: _ } = self;
        size_of_val(&**supers)
            + size_of_val(&**nodes)
            + size_of_val(&**items)
            + size_of_val(&**shapes)
            + size_of_val(&**solids)
    }
}

/// The states of a graph that are more than a name, a choice or a transformation of another one, each resolved once.
pub(crate) struct States<'a> {
    graph: &'a Graph,
    boxes: &'a ExactBoxes<Graph>,
    pub(crate) states: Vec<Resolved>,
    numbers: FxHashMap<State, u32>,
}

pub(crate) struct Resolved {
    pub(crate) state: State,
    pub(crate) bounds: Aabb,
    pub(crate) kind: Kind,
}

#[derive(Clone)]
pub(crate) enum Kind {
    /// Of parts, those of unions in unions among them.
    Union(Vec<Place>),
    /// Of operands, with the parts of those that are unions.
    Solid(Operator, [Vec<Place>; 2]),
    Primitive(Primitive),
}

/// A state under the transformations and attributes that lead to it.
#[derive(Clone)]
pub(crate) struct Place {
    /// An index into the resolved states.
    pub(crate) target: u32,
    pub(crate) above_from_target: DAffine3,
    pub(crate) target_from_above: DAffine3,
    /// S-nodes between.
    pub(crate) depth: u32,
    /// The state of the last of these, by its place among all states.
    pub(crate) symbol: Option<u32>,
    pub(crate) paint: Vec<(AttributeTerm, f64)>,
}

impl<'a> States<'a> {
    /// Resolves all states that the root leads to. The root comes last, and each state behind those below it.
    pub(crate) fn resolve(
        graph: &'a Graph,
        boxes: &'a ExactBoxes<Graph>,
    ) -> Result<(Self, Place), EvalError> {
        let mut all = Self { graph, boxes, states: Vec::new(), numbers: FxHashMap::default() };
        let (root, target) = all.follow(graph.root_state())?;
        // Places whose targets are not resolved yet; the state of an operator waits below those of its operands.
        let mut open = vec![target.clone()];
        while let Some(state) = open.last() {
            if all.numbers.contains_key(state) {
                open.pop();
                continue;
            }
            let state = state.clone();
            let kind = match graph.step(&state)? {
                Step::Operator(operator, [left, right]) => {
                    let followed = [all.follow(left)?, all.follow(right)?];
                    let waiting = open.len();
                    for (_, below) in followed.iter().rev() {
                        if !all.numbers.contains_key(below) {
                            open.push(below.clone());
                        }
                    }
                    if open.len() > waiting {
                        continue;
                    }
                    let operands =
                        followed.map(|(place, below)| Place { target: all.numbers[&below], ..place });
                    all.operator(operator, operands)
                }
                Step::Primitive(primitive) => Kind::Primitive(primitive),
                other => unreachable!("{other:?} was followed"),
            };
            let bounds = boxes.of(&state).map_or(Aabb::EMPTY, |found| found.aabb);
            all.numbers.insert(state.clone(), index(all.states.len()));
            all.states.push(Resolved { state, bounds, kind });
            open.pop();
        }
        let root = Place { target: all.numbers[&target], ..root };
        Ok((all, root))
    }

    fn operator(&self, operator: Operator, [left, right]: [Place; 2]) -> Kind {
        let (right, minuend) = (self.parts(right), left.depth == 0);
        match (operator, &self.get(&left).kind) {
            (Operator::Union, _) => Kind::Union(self.parts(left).into_iter().chain(right).collect()),
            (Operator::Difference, Kind::Solid(Operator::Difference, [first, second])) if minuend => {
                let then = |part| left.then(part);
                let subtracted = second.iter().map(then).chain(right).collect();
                Kind::Solid(operator, [first.iter().map(then).collect(), subtracted])
            }
            _ => Kind::Solid(operator, [self.parts(left), right]),
        }
    }

    /// The parts of an operand: if it is a union in the same rule, its parts.
    fn parts(&self, operand: Place) -> Vec<Place> {
        match &self.get(&operand).kind {
            Kind::Union(parts) if operand.depth == 0 => parts.iter().map(|part| operand.then(part)).collect(),
            _ => vec![operand],
        }
    }

    /// Goes down from a state to the next operator or primitive. The target of the place is not known yet.
    fn follow(&self, mut state: State) -> Result<(Place, State), EvalError> {
        let mut place = Place::HERE;
        loop {
            state = match self.graph.step(&state)? {
                Step::Select(below) => {
                    place.depth += 1;
                    place.symbol = self.boxes.index_of(&state).map(index);
                    below
                }
                Step::Calculate(below) => below,
                Step::Attribute(terms, below) => {
                    place.paint.extend(terms);
                    below
                }
                Step::Transform(parent_from_child, below) => {
                    let [x, y, z] = DVec3::AXES.map(|axis| parent_from_child.inverse_vector(axis));
                    let child_from_parent = DAffine3 {
                        matrix3: DMat3::from_cols(x, y, z),
                        translation: parent_from_child.inverse_point(DVec3::ZERO),
                    };
                    place.above_from_target *= parent_from_child.to_affine();
                    place.target_from_above = child_from_parent * place.target_from_above;
                    below
                }
                _ => return Ok((place, state)),
            };
        }
    }

    fn get(&self, place: &Place) -> &Resolved {
        &self.states[place.target as usize]
    }

    /// Opens the first union, and then others, into a list of at most `length` places, in the order of the graph.
    fn open(&self, start: Vec<Place>, length: usize) -> Vec<Place> {
        // Each with the next one in the order of the graph.
        let count = start.len();
        let mut places: Vec<(Place, Option<usize>)> =
            start.into_iter().zip((1..count).map(Some).chain([None])).collect();
        let mut open = BinaryHeap::new();
        for (at, (place, _)) in places.iter().enumerate() {
            self.enqueue(&mut open, place, at);
        }
        // One place alone is opened in any case, or the list would lead to itself.
        while places.len() < length.max(2)
            && let Some(Largest { place: at, .. }) = open.pop()
        {
            let (place, next) = &places[at];
            let Kind::Union(parts) = &self.get(place).kind else { unreachable!("only unions are opened") };
            let parts: Vec<Place> = parts.iter().map(|part| place.then(part)).collect();
            let (mut next, mut slots) = (*next, (places.len()..).take(parts.len() - 1));
            // From the last part to the first, which takes the place of the union.
            for part in parts.into_iter().rev() {
                let slot = slots.next().unwrap_or(at);
                self.enqueue(&mut open, &part, slot);
                if slot == at {
                    places[at] = (part, next);
                } else {
                    places.push((part, next));
                }
                next = Some(slot);
            }
        }
        let mut ordered = Vec::with_capacity(places.len());
        let mut at = Some(0);
        while let Some(index) = at {
            let (place, next) = std::mem::replace(&mut places[index], (Place::HERE, None));
            ordered.push(place);
            at = next;
        }
        ordered
    }

    fn enqueue(&self, open: &mut BinaryHeap<Largest>, place: &Place, at: usize) {
        let Resolved { bounds, kind, .. } = self.get(place);
        if matches!(kind, Kind::Union(_)) {
            open.push(Largest { area: bounds.image(&place.above_from_target).surface_area(), place: at });
        }
    }

    /// The box of a place in the frame above: six supports, not the box of a box.
    fn exact_box(&self, place: &Place) -> Aabb {
        let Resolved { state, bounds, kind } = self.get(place);
        if bounds.is_empty() {
            return Aabb::EMPTY;
        }
        let outer = bounds.image(&place.above_from_target);
        let rows = place.above_from_target.matrix3.transpose();
        let translation = place.above_from_target.translation;
        let reach = |direction: DVec3, offset: f64, outer: f64| {
            let support = match kind {
                Kind::Primitive(primitive) => primitive.support(direction),
                _ => self.boxes.support(state, direction).map_or(f64::INFINITY, |support| support.upper),
            };
            // Well within the padding of trees, and more than is rounded here.
            let reach = offset + support;
            (reach + (offset.abs() + support.abs()) * 1e-14).min(outer)
        };
        let mut exact = outer;
        for axis in 0..3 {
            exact.max[axis] = reach(rows.col(axis), translation[axis], outer.max[axis]);
            exact.min[axis] = -reach(-rows.col(axis), -translation[axis], -outer.min[axis]);
        }
        exact
    }
}

impl Place {
    const HERE: Self = Self {
        target: 0,
        above_from_target: DAffine3::IDENTITY,
        target_from_above: DAffine3::IDENTITY,
        depth: 0,
        symbol: None,
        paint: Vec::new(),
    };

    /// A place in the frame of this one's target, seen from above this one.
    fn then(&self, below: &Self) -> Self {
        Self {
            target: below.target,
            above_from_target: self.above_from_target * below.above_from_target,
            target_from_above: below.target_from_above * self.target_from_above,
            depth: self.depth + below.depth,
            symbol: below.symbol.or(self.symbol),
            paint: self.paint.iter().chain(&below.paint).copied().collect(),
        }
    }
}

/// A union that can be opened, by its surface area.
struct Largest {
    area: f64,
    place: usize,
}

impl Ord for Largest {
    fn cmp(&self, other: &Self) -> Ordering {
        self.area.total_cmp(&other.area).then(other.place.cmp(&self.place))
    }
}

impl PartialOrd for Largest {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Largest {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Largest {}

/// The lists of all super-nodes, the root's first.
struct Lists {
    /// Each with the box that clips those of its places.
    lists: Vec<(Aabb, Vec<Place>)>,
    /// The super-node of each resolved state, if it has one.
    supers: Vec<Option<u32>>,
    /// The solid of each resolved state, if it has one.
    numbers: Vec<Option<u32>>,
    solids: Vec<Solid>,
}

impl Lists {
    /// Opens all states that the root leads to into lists of that length, or gives up if they have more entries
    /// together than are affordable and could have fewer.
    fn open(states: &States<'_>, root: &Place, length: usize, affordable: usize) -> Option<Self> {
        let none = || vec![None; states.states.len()];
        let mut all = Self { lists: Vec::new(), supers: none(), numbers: none(), solids: Vec::new() };
        let mut waiting = VecDeque::from([(Aabb::ALL, vec![root.clone()])]);
        let mut total = 0;
        while let Some((clip, start)) = waiting.pop_front() {
            let list = states.open(start, length);
            total += list.len();
            if total > affordable && length > SHORTEST {
                return None;
            }
            // This list is not among the lists yet.
            let next = |waiting: &VecDeque<_>| index(all.lists.len() + 1 + waiting.len());
            for place in &list {
                let target = place.target as usize;
                let Resolved { bounds, kind, .. } = states.get(place);
                match kind {
                    Kind::Union(_) if all.supers[target].is_none() => {
                        all.supers[target] = Some(next(&waiting));
                        waiting.push_back((Aabb::ALL, vec![Place { target: place.target, ..Place::HERE }]));
                    }
                    Kind::Solid(operator, operands) if all.numbers[target].is_none() => {
                        all.numbers[target] = Some(index(all.solids.len()));
                        let first = next(&waiting);
                        all.solids.push(Solid { operator: *operator, operands: [first, first + 1] });
                        waiting.extend(operands.iter().map(|parts| (*bounds, parts.clone())));
                    }
                    _ => {}
                }
            }
            all.lists.push((clip, list));
        }
        Some(all)
    }

    /// Gives all entries their exact boxes and each list its tree.
    fn close(self, states: &States<'_>) -> Compiled {
        let mut compiled = Compiled { solids: self.solids, ..Compiled::default() };
        let mut painted: FxHashMap<Vec<(AttributeTerm, u64)>, u32> = FxHashMap::default();
        for (clip, list) in self.lists {
            let first = compiled.items.len();
            let mut boxes = Vec::with_capacity(list.len());
            for place in list {
                let bounds = states.exact_box(&place).intersect(clip);
                if bounds.is_empty() {
                    continue;
                }
                boxes.push(bounds);
                let Resolved { state, kind, .. } = states.get(&place);
                let number = |numbers: &[Option<u32>]| {
                    numbers[place.target as usize].expect("what is at the end of a list has its number")
                };
                let content = match kind {
                    Kind::Union(_) => Content::Super(number(&self.supers)),
                    Kind::Solid(..) => Content::Solid(number(&self.numbers)),
                    Kind::Primitive(primitive) => Content::Shape(shape(&mut compiled.shapes, primitive)),
                };
                let paint = (!place.paint.is_empty()).then(|| {
                    let key = place.paint.iter().map(|(term, value)| (*term, value.to_bits())).collect();
                    *painted.entry(key).or_insert_with(|| {
                        compiled.paints.push(place.paint.clone());
                        index(compiled.paints.len() - 1)
                    })
                });
                let Place { target_from_above: item_from_super, depth, symbol, .. } = place;
                let node = state.node();
                compiled.items.push(Item { item_from_super, content, node, depth, paint });
                compiled.symbols.push(symbol);
            }
            compiled.supers.push(super_node(&mut boxes, first, &mut compiled.nodes));
        }
        compiled
    }
}

/// The super-node whose items, the `first` and those behind it, have these boxes.
fn super_node(boxes: &mut [Aabb], first: usize, nodes: &mut Vec<Node>) -> SuperNode {
    let (bounded, unbounded): (Vec<Aabb>, Vec<Aabb>) = boxes.iter().partition(|bounds| bounds.is_bounded());
    let all = bounded.into_iter().reduce(Aabb::join);
    let (center, radius) = all.map_or((DVec3::ZERO, 0.0), |all| (all.center(), 0.5 * all.size().length()));
    // A unit of any size for boxes without one.
    let radius = if radius > 0.0 { radius } else { 1.0 };
    let reach = if unbounded.is_empty() { radius } else { f64::INFINITY };
    for bounds in &mut *boxes {
        *bounds = Aabb::new((bounds.min - center) / radius, (bounds.max - center) / radius);
    }
    let root = (!boxes.is_empty()).then(|| tree::build(boxes, first, nodes));
    SuperNode { center, radius, to_unit: 1.0 / radius, reach, root }
}

/// The index of a shape among all; one of the last is not added again.
fn shape(shapes: &mut Vec<Primitive>, shape: &Primitive) -> u32 {
    const LAST: usize = 8;
    let known = shapes.iter().rposition(|known| known == shape).filter(|at| at + LAST >= shapes.len());
    index(known.unwrap_or_else(|| {
        shapes.push(shape.clone());
        shapes.len() - 1
    }))
}

fn index(index: usize) -> u32 {
    u32::try_from(index).expect("2³² of anything outgrow memory")
}
