//! Envelopes: bounds of states that nobody wants to enumerate.
//!
//! With random numbers every instance is a state of its own. What is below a state is then bounded without looking at it,
//! by abstract interpretation [COUS77]: instead of the values of parameters, intervals that hold them. A random number is
//! any number of its range; a parameter that leads to a different seed at each branch leads to nothing else, and is ignored.
//!
//! - [`control`]: which parameters are known exactly although numbers are random, such as counters of levels; which are
//!   known by intervals; and which do not matter.
//! - [`keys`]: the states without what varies, of which there are few.
//! - [`general`]: an envelope for each key, once and for all. For an ordinary random tree every question is answered by
//!   these.
//! - [`question`]: where parameters vary, as the heights at the corners of a terrain, their intervals on all ways down.
//! - [`fixpoint`]: recursion that ends by chance, or never.
//!
//! An envelope comes from those below it as the solid does ([`assemble`]):
//!
//! - [`body`]: what it is, slabs within a ball; supports in any direction are hardly larger than those of the solid.
//! - [`transform`]: images under chains of transformations with intervals for arguments; [`straight`]: those of boxes,
//!   under what turns by right angles only.
//! - [`primitive`]: primitives with intervals for measures.
//!
//! [`refine`] looks closer at one state, where that matters; [`nowhere`] finds recursion of which there is nothing to bound.

mod assemble;
mod body;
mod control;
mod fixpoint;
mod general;
mod keys;
mod nowhere;
mod primitive;
mod question;
mod refine;
mod straight;
mod transform;

use std::fmt;
use std::sync::Arc;

use csg_graph::{EvalError, Graph, Interval, State};
use glam::DVec3;

use crate::{Aabb, BoundsError, Limits, Slabs, Volume};
use body::Body;
use general::{Failure, Known};
use keys::Keys;
use question::Question;

/// Conservative bounds for the solids of all states of a graph, without a look at what is below them.
///
/// ```
/// use csg_graph::{Expr, Function, GraphBuilder, PrimitiveKind, TransformKind};
/// use csg_graph_bounds::{Envelopes, Limits};
///
/// // A chain of balls, each turned by chance and somewhat smaller than the one before.
/// // C if(n > 0, 2, 1)
/// // 1: C -> sphere
/// // 2: C -> sphere | {n = n-1} roty(rand(-10, 10)) move(0, 0, 2) uscale(0.8) C
/// let mut builder = GraphBuilder::new();
/// let (n, seed) = (builder.param("n", 1e3), builder.param("seed", 0.0));
/// let chain = builder.symbol("C");
/// let ball = builder.primitive(PrimitiveKind::Sphere, []);
/// let small = builder.transform(TransformKind::UScale, [0.8.into()], chain);
/// let moved = builder.transform(TransformKind::Move, [0.0, 0.0, 2.0].map(Expr::from), small);
/// let angle = Expr::draw(Function::Rand, seed, 1, [(-10.0).into(), 10.0.into()]);
/// let turned = builder.transform(TransformKind::RotY, [angle], moved);
/// let reseeded = builder.reseed(seed, 1, turned);
/// let next = builder.calculate([(n, Expr::from(n) - 1.0)], reseeded);
/// let both = builder.union([ball, next]);
/// builder.rules(chain, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [ball, both]);
/// let graph = builder.finish(chain)?;
///
/// let envelopes = Envelopes::new(graph.clone(), &Limits::default());
/// let all_chains = envelopes.of(&graph.root_state())?.aabb();
/// assert!(all_chains.size().z < 15.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # What is enclosed
/// The solid below the state, whatever the random numbers below it are. That is more than there is below this state: the
/// seed is not looked at. To bound it more closely, bound the states that it leads to and join those.
///
/// The envelope of an intersection is what both envelopes have in common, that of a difference is that of its left operand. An
/// evaluation that fails has nothing below it; it fails when its state is expanded.
///
/// Recursion that ends by chance, or never, has an envelope if its transformations shrink it even at their extremes.
///
/// # Cost
/// Making them takes some microseconds for each state of the graph without chance, at most [`Limits::keys`] of these.
/// A question is a look-up where all random numbers are arguments of transformations and primitives. Where they change
/// parameters that go further down, some ten nanoseconds for each node on the way down and for each level, if it is for a
/// [box](Self::aabb) and nothing below turns; some hundred for a whole envelope.
///
/// An answer depends on the graph, the limits and the state alone. Threads may share this.
pub struct Envelopes {
    graph: Arc<Graph>,
    keys: Keys,
    /// By key.
    general: Vec<Known>,
}

impl fmt::Debug for Envelopes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Envelopes").field("keys", &self.key_count()).finish_non_exhaustive()
    }
}

/// What is between 26 planes and within a ball, about the solid of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Envelope(Body);

impl Envelopes {
    /// Prepares for questions about all states that the root of the graph leads to.
    pub fn new(graph: impl Into<Arc<Graph>>, limits: &Limits) -> Self {
        let graph = graph.into();
        let keys = Keys::new(&graph, limits.keys);
        let general = general::envelopes(&graph, &keys);
        Self { graph, keys, general }
    }

    /// The graph.
    pub fn graph(&self) -> &Arc<Graph> {
        &self.graph
    }

    /// How many states were looked at: states without what varies.
    pub fn key_count(&self) -> usize {
        self.keys.len()
    }

    /// About how much memory this holds, without the graph. Each thread that asks keeps up to some hundred kilobytes for its next
    /// question.
    pub fn bytes(&self) -> usize {
        self.keys.bytes() + self.general.len() * size_of::<Known>()
    }

    /// An envelope of the solid below a state, in the frame of the state; for a T-node, in the frame that it maps into.
    ///
    /// # Errors
    /// [`BoundsError::Endless`] if a recursion below the state may be endless and was not found to shrink.
    ///
    /// # Panics
    /// If the root of the graph does not lead to the state.
    pub fn of(&self, state: &State) -> Result<Envelope, BoundsError<EvalError>> {
        let key = self.key(state);
        let found = if self.keys.varies(key) {
            self.question().body(key, self.varying(state))
        } else {
            self.general[key as usize].as_ref().copied()
        };
        found.map(Envelope).map_err(|failure| self.error(failure))
    }

    /// The box of the [envelope](Self::of), but for some ulps.
    ///
    /// # Cost
    /// Where no transformation below turns by anything but right angles, as in a terrain, a fraction of that of the envelope.
    ///
    /// # Errors
    /// As for `of`.
    ///
    /// # Panics
    /// As for `of`.
    pub fn aabb(&self, state: &State) -> Result<Aabb, BoundsError<EvalError>> {
        let key = self.key(state);
        let found = if self.keys.varies(key) {
            self.question().aabb(key, self.varying(state))
        } else {
            self.general[key as usize].as_ref().map(|body| body.slabs.aabb())
        };
        found.map_err(|failure| self.error(failure))
    }

    /// Whether the envelope of a state is that of all states which differ from it by random numbers alone. It is a look-up
    /// then, and becomes closer where the numbers are looked at: in what the state leads to. Otherwise there are parameters
    /// by chance, of which it knows the values.
    ///
    /// # Panics
    /// As for `of`.
    pub fn is_common(&self, state: &State) -> bool {
        !self.keys.varies(self.key(state))
    }

    /// What a state has in common with all states that differ from it by random numbers alone, where its envelope
    /// [is common](Self::is_common) to these: a number below [`key_count`](Self::key_count).
    ///
    /// # Panics
    /// As for `of`.
    pub fn class(&self, state: &State) -> Option<u32> {
        let key = self.key(state);
        (!self.keys.varies(key)).then_some(key)
    }

    /// A state that differs from one by random numbers alone: of all that has no part in the envelopes, such as the seed,
    /// nothing is left but a number. States of the same [class](Self::class) at the same node have the same typical ones.
    #[must_use]
    pub fn typical(&self, state: &State, number: f64) -> State {
        let (node, mut env) = (state.node(), state.env().clone());
        let control = self.keys.control();
        for param in control.assigned().iter().filter(|param| !control.matters(node, **param)) {
            if env.get(*param).is_some() {
                env.set(*param, number);
            }
        }
        self.graph.state(node, env)
    }

    fn key(&self, state: &State) -> u32 {
        self.keys.number(state).expect("a state that the root leads to")
    }

    fn varying(&self, state: &State) -> impl Iterator<Item = Interval> {
        let values = self.keys.control().varying().iter().map(|param| state.env().get(*param));
        values.map(|value| value.map_or(Interval::ALL, Interval::point))
    }

    fn question(&self) -> Question<'_> {
        Question { keys: &self.keys, general: &self.general }
    }

    fn error(&self, failure: &Failure) -> BoundsError<EvalError> {
        BoundsError::Endless { cycle: self.keys.labels(&self.graph, &failure.cycle), round: failure.round }
    }
}

impl Envelope {
    /// An axis-aligned box about it.
    pub fn aabb(&self) -> Aabb {
        self.0.slabs.aabb()
    }

    /// Its planes.
    pub fn slabs(&self) -> &Slabs<13> {
        &self.0.slabs
    }

    /// No point is further from the origin.
    pub fn radius(&self) -> f64 {
        self.0.radius
    }

    /// At least its support in a direction of any length: no point of the solid has a larger product with it. −∞ if it is
    /// empty, ∞ where it has no end. Some nanoseconds.
    pub fn support(&self, direction: DVec3) -> f64 {
        if self.0.is_empty() { f64::NEG_INFINITY } else { self.0.supports(direction, DVec3::ZERO)[0] }
    }
}
