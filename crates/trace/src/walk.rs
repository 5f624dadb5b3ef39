//! The reference walk: the paper's. A ray goes down the cyclic graph itself (\[TRAX95\] §1).
//!
//! At each node the ray is tested against the node's hyper box (\[TRAX95\] §2) and turned away if it misses. An S-node
//! passes the ray on to the rule that it selects, a C-node changes parameters, a T-node maps the ray into the frame below,
//! an operator node asks both operands, and a primitive is intersected. Nothing is unfolded or remembered from one ray to
//! the next, so that memory is proportional to the depth of the recursion. This is the walk that every faster one must
//! agree with.
//!
//! There are two ways to ask a node. Where only unions are above, the *nearest* boundary is enough: the nearest of a union
//! is the nearest of its parts, and what starts behind the best hit so far is left out. At ∩ and \ the question changes to
//! all *spans* on the whole line, because what is behind the origin or behind the best hit still decides what is inside;
//! the first boundary of the result is then a candidate like any other.
//!
//! # Changes versus the paper
//!
//! - The recursion is an explicit stack of what is left to do, so that its depth costs memory and no machine stack. A
//!   branch that is put off keeps its ray, parameters and surface by value; nothing has to be restored on the way back.
//! - The map of normals is carried down along with the ray, so that a hit costs nothing in proportion to its depth.
//! - Parameters change for what is below a C-node only; the paper calls them global.

use csg_graph::{Env, EvalError, Graph, Node, NodeId, Operator, State, Transform};
use csg_graph_bounds::HyperBoxes;
use glam::{DMat3, DVec3};
use rustc_hash::FxHashMap;

use crate::boolean::{Edge, SpanStack};
use crate::shapes::{self, End, Spans};
use crate::{Counters, Hit, Ray, Surface, slab};

/// Traces rays through a graph, one after the other. Each thread has its own.
///
/// A ray that starts inside of a union meets the walls between its parts, too; one that starts inside of the result of ∩
/// or \ does not.
///
/// See the [crate](crate)'s documentation for an example.
#[derive(Debug)]
pub struct Walk<'a> {
    graph: &'a Graph,
    boxes: Option<&'a HyperBoxes>,
    initial: Env,
    counters: Counters,
    tasks: Vec<Task>,
    spans: SpanStack,
    best: Option<Edge>,
    /// Candidates are at t before this: that of `best`, or the end of the ray.
    limit: f64,
    missed: u32,
    /// The numbers of states, if anyone wants to know which ones are hit.
    numbers: Option<&'a FxHashMap<State, u32>>,
    /// The state of the last S-node on the path to the last hit.
    last_symbol: Option<u32>,
}

/// A node that a ray has come to, and what it brings.
#[derive(Clone, Debug)]
struct Visit {
    node: NodeId,
    /// In the frame of the node.
    ray: Ray,
    /// Maps normals of that frame into the world; inverse and transposed with respect to points.
    world_from_frame: DMat3,
    env: Env,
    surface: Surface,
    /// S-nodes passed.
    depth: u32,
    /// The number of the last one's state.
    symbol: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Mode {
    Nearest,
    Spans,
}

#[derive(Debug)]
enum Task {
    Visit(Visit, Mode),
    /// The right operand of ∩ or \: no matter where the left one, whose spans are on top, is empty.
    VisitIfLeft(Visit),
    /// Both operands have their spans on top.
    Combine(Operator),
    /// The spans on top are those of a solid that only unions are above.
    Offer {
        depth: u32,
    },
}

impl<'a> Walk<'a> {
    /// A walk over `graph` with the hyper boxes that belong to it, or without any. Boxes change what a ray costs and
    /// nothing else.
    ///
    /// # Panics
    /// If `boxes` has not one box for each node.
    pub fn new(graph: &'a Graph, boxes: Option<&'a HyperBoxes>) -> Self {
        assert!(
            boxes.is_none_or(|boxes| boxes.nodes.len() == graph.node_count()),
            "hyper boxes of another graph"
        );
        Self {
            graph,
            boxes,
            initial: own_copy(graph),
            counters: Counters::default(),
            tasks: Vec::new(),
            spans: SpanStack::default(),
            best: None,
            limit: f64::INFINITY,
            missed: 0,
            numbers: None,
            last_symbol: None,
        }
    }

    /// From now on, the walk knows which [state](Self::last_symbol) it hits, which costs a look-up at each S-node.
    pub(crate) fn number_states(&mut self, numbers: &'a FxHashMap<State, u32>) {
        self.numbers = Some(numbers);
    }

    /// The state of the last S-node on the path to the last hit, if there is one and states are numbered.
    pub(crate) fn last_symbol(&self) -> Option<u32> {
        self.last_symbol
    }

    /// The first boundary of the solid at t > 0, or `None` if the ray meets none. Of several at the same t, the leftmost in
    /// the graph.
    ///
    /// # Errors
    /// If an expression of the graph has no usable value at a state that the ray comes to.
    pub fn nearest(&mut self, ray: &Ray) -> Result<Option<Hit>, EvalError> {
        self.counters.rays += 1;
        self.run(self.root_visit(ray), f64::INFINITY, false)?;
        Ok(self.take_hit(ray))
    }

    /// The first boundary at 0 < t < `end` of the solid of a state, for a ray in the frame of the state, where surfaces
    /// are `surface` unless they are painted below.
    pub(crate) fn nearest_below(
        &mut self,
        state: &State,
        ray: &Ray,
        end: f64,
        surface: Surface,
    ) -> Result<Option<Hit>, EvalError> {
        let visit = Visit { surface, ..self.visit_of(state, ray) };
        self.run(visit, end, false)?;
        Ok(self.take_hit(ray))
    }

    /// Whether the ray, in the frame of a state, meets the solid of that state at 0 < t < `end`.
    pub(crate) fn occluded_below(&mut self, state: &State, ray: &Ray, end: f64) -> Result<bool, EvalError> {
        self.run(self.visit_of(state, ray), end, true)?;
        Ok(self.best.take().is_some())
    }

    fn take_hit(&mut self, ray: &Ray) -> Option<Hit> {
        self.last_symbol = self.best.and_then(|edge| edge.symbol);
        self.best.take().map(|edge| Hit {
            t: edge.t,
            point: ray.at(edge.t),
            normal: unit(edge.normal).unwrap_or(-ray.direction),
            surface: edge.surface,
            node: edge.node,
            depth: edge.depth,
        })
    }

    /// Whether the ray meets the solid at 0 < t < `end`.
    ///
    /// # Errors
    /// As for [`nearest`](Self::nearest).
    pub fn occluded(&mut self, ray: &Ray, end: f64) -> Result<bool, EvalError> {
        self.counters.shadow_rays += 1;
        self.run(self.root_visit(ray), end, true)?;
        Ok(self.best.take().is_some())
    }

    /// The deepest recursion at which the last ray was turned away by a box, a primitive, or a Boolean result: the number
    /// of S-nodes that it had passed.
    pub fn missed_depth(&self) -> u32 {
        self.missed
    }

    /// What was counted since the walk was made or its counters were taken.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// For what is counted on the way to the walk.
    pub(crate) fn counters_mut(&mut self) -> &mut Counters {
        &mut self.counters
    }

    /// The counters, which start again from zero.
    pub fn take_counters(&mut self) -> Counters {
        std::mem::take(&mut self.counters)
    }

    fn root_visit(&self, ray: &Ray) -> Visit {
        Visit {
            node: self.graph.root(),
            ray: *ray,
            world_from_frame: DMat3::IDENTITY,
            env: self.initial.clone(),
            surface: Surface::default(),
            depth: 0,
            symbol: None,
        }
    }

    fn visit_of(&self, state: &State, ray: &Ray) -> Visit {
        Visit { node: state.node(), env: state.env().clone(), ..self.root_visit(ray) }
    }

    fn run(&mut self, start: Visit, end: f64, any: bool) -> Result<(), EvalError> {
        self.tasks.clear();
        self.spans.clear();
        (self.best, self.limit, self.missed) = (None, end, 0);
        self.visit(start, Mode::Nearest)?;
        while let Some(task) = self.tasks.pop() {
            if any && self.best.is_some() {
                break;
            }
            match task {
                Task::Visit(visit, mode) => self.visit(visit, mode)?,
                Task::VisitIfLeft(_) if self.spans.top().is_empty() => self.spans.open(),
                Task::VisitIfLeft(visit) => self.visit(visit, Mode::Spans)?,
                Task::Combine(operator) => self.spans.combine(operator),
                Task::Offer { depth } => self.offer(depth),
            }
        }
        Ok(())
    }

    /// Goes down from a node to a primitive, or to where the ray is turned away. Right operands are put off.
    fn visit(&mut self, mut at: Visit, mut mode: Mode) -> Result<(), EvalError> {
        let graph = self.graph;
        loop {
            self.counters.nodes_visited += 1;
            if self.misses_box(&at, mode) {
                self.missed = self.missed.max(at.depth);
                if mode == Mode::Spans {
                    // No spans here, which is an answer: what it is subtracted from stays whole.
                    self.spans.open();
                }
                return Ok(());
            }
            match graph.node(at.node) {
                Node::Symbol(_) => {
                    if let Some(numbers) = self.numbers {
                        at.symbol = numbers.get(&graph.state(at.node, at.env.clone())).copied();
                    }
                    at.node = graph.select(at.node, &at.env)?;
                    at.depth += 1;
                    self.counters.deepest_recursion = self.counters.deepest_recursion.max(at.depth);
                }
                Node::Calculation(node) => {
                    graph.calculate(at.node, &mut at.env)?;
                    at.node = node.body;
                }
                Node::Transformation(node) => {
                    let frame_from_child = graph.transform(at.node, &at.env)?;
                    at.ray = at.ray.into_child(&frame_from_child);
                    at.world_from_frame *= normal_map(&frame_from_child);
                    at.node = node.body;
                }
                Node::Attribute(node) => {
                    for (term, value) in graph.attributes(at.node, &at.env)? {
                        at.surface.set(term, value);
                    }
                    at.node = node.body;
                }
                Node::Operator(node) => {
                    let [left, right] = node.operands;
                    let right = Visit { node: right, ..at.clone() };
                    at.node = left;
                    if node.operator == Operator::Union && mode == Mode::Nearest {
                        self.tasks.push(Task::Visit(right, mode));
                        continue;
                    }
                    if mode == Mode::Nearest {
                        self.tasks.push(Task::Offer { depth: at.depth });
                        mode = Mode::Spans;
                    }
                    self.tasks.push(Task::Combine(node.operator));
                    self.tasks.push(match node.operator {
                        Operator::Union => Task::Visit(right, mode),
                        Operator::Intersection | Operator::Difference => Task::VisitIfLeft(right),
                    });
                }
                Node::Primitive(_) => {
                    self.counters.primitive_tests += 1;
                    let primitive = graph.primitive(at.node, &at.env)?;
                    let spans = shapes::spans(&primitive, &at.ray);
                    self.meet(&at, mode, &spans);
                    return Ok(());
                }
                other => unreachable!("the walk does not know {}-nodes", other.kind()),
            }
        }
    }

    fn misses_box(&mut self, at: &Visit, mode: Mode) -> bool {
        let Some(boxes) = self.boxes else { return false };
        self.counters.box_tests += 1;
        let met = match slab::interval(&boxes.nodes[at.node.index()], &at.ray) {
            None => false,
            Some((near, far)) => mode == Mode::Spans || far >= 0.0 && near <= self.limit,
        };
        self.counters.boxes_missed += u64::from(!met);
        !met
    }

    /// The ray has come to a primitive.
    fn meet(&mut self, at: &Visit, mode: Mode, spans: &Spans) {
        let edge = |end: End| Edge {
            t: end.t,
            normal: at.world_from_frame * end.normal,
            surface: at.surface,
            node: at.node,
            depth: at.depth,
            symbol: at.symbol,
        };
        let ends = spans.iter().flat_map(|span| [span.enter, span.exit]);
        match mode {
            Mode::Nearest => match ends.clone().find(|end| end.t > 0.0) {
                Some(end) if end.t < self.limit => self.accept(edge(end)),
                _ => self.missed = self.missed.max(at.depth),
            },
            Mode::Spans => {
                self.spans.open();
                if spans.is_empty() {
                    self.missed = self.missed.max(at.depth);
                }
                ends.for_each(|end| self.spans.push(edge(end)));
            }
        }
    }

    /// Takes the spans on top as a solid of its own: its first boundary is a candidate.
    fn offer(&mut self, depth: u32) {
        match self.spans.top().iter().find(|edge| edge.t > 0.0).copied() {
            Some(edge) if edge.t < self.limit => self.accept(edge),
            _ => self.missed = self.missed.max(depth),
        }
        self.spans.pop();
    }

    fn accept(&mut self, edge: Edge) {
        self.limit = edge.t;
        self.best = Some(edge);
    }
}

/// The initial values in memory of their own: threads that share one copy would contend for its reference count.
fn own_copy(graph: &Graph) -> Env {
    let mut env = Env::unset(graph.params().len());
    for param in graph.params() {
        if let Some(value) = graph.initial().get(param) {
            env.set(param, value);
        }
    }
    env
}

/// [`Transform::normal`] as a matrix.
fn normal_map(transform: &Transform) -> DMat3 {
    let [x, y, z] = DVec3::AXES.map(|axis| transform.normal(axis));
    DMat3::from_cols(x, y, z)
}

/// The squares of lengths that vectors can be divided by.
pub(crate) const ORDINARY: std::ops::Range<f64> = 1e-200..1e200;

/// The vector at length 1, also where the square of its length leaves the range of numbers; `None` if it has no direction.
/// Its zeros are positive: which sign they would have is a matter of the way to them, and paths of light go by it.
pub(crate) fn unit(vector: DVec3) -> Option<DVec3> {
    let squared_length = vector.length_squared();
    let unit = if ORDINARY.contains(&squared_length) {
        Some(vector / squared_length.sqrt())
    } else {
        (vector / vector.abs().max_element()).try_normalize()
    };
    unit.map(|unit| unit + DVec3::ZERO)
}
