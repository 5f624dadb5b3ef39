//! Exact boxes, one for each *state* and not for each node of the unfolded tree.
//!
//! [TRAX95] §2 says that one box for each instance "needs a vast amount of memory, comparable to the unfolding of the
//! CSG graph into a huge CSG tree", and joins them to hyper boxes. But what is below a node depends only on its state:
//! the node, and the values that are still read below it. The Fig. 1.1a tree with branches of order 60 unfolds into
//! 1.8 · 10¹⁹ primitives, and its nodes have 774 states. Each gets its own box here, and the boxes of the
//! instances of a node, joined, are its hyper box.
//!
//! A box is six supports, and the support of a state is a maximum over the states below it:
//!
//! > h(d) = max over the parts of t·d + hₚ(Mᵀd), for a part p under x ↦ M x + t
//!
//! down to shapes, whose supports are formulas. Unfolding that would be unfolding the tree; [`query`] does it best
//! first, pruned with the boxes of the states below, which [`bottom_up`] has found before. No point set approximates
//! anything, and no box is the box of a box.
//!
//! - [`states`]: which states there are, each once.
//! - [`solids`]: the states without what has no extent of its own.
//! - [`query`]: the support of a solid.
//! - [`apart`]: whether anything is left of an intersection, by [`furthest`] points of its operands.
//! - [`bottom_up`]: all boxes.
//! - [`finest`]: how small parts are, by digits.
//!
//! A state that leads back to itself has no leaves to start from. Where the recursion shrinks, it has a bounded solid all
//! the same, the *attractor* [HUTC81], and its box comes from the other side, from boxes that are too large:
//!
//! - [`components`]: which states lead back to themselves.
//! - [`norm`]: lengths by which maps shrink that only do so in the long run.
//! - [`contraction`]: the certificate that the recursion shrinks, and the first boxes.
//! - [`attractor`]: better boxes, by queries that go round the cycle.
//! - [`guess`]: better ones where the cycle shrinks too slowly for that.
//! - [`shrinks`]: the same certificate for all that a ray goes through, what is subtracted included.
//!
//! ## What is exact
//!
//! The faces of the box of a state under which there are only unions are the supports of the solid, to within the
//! *gap* that is reported and the rounding of the maps on the way. An intersection has what is in both boxes of its
//! operands, and a difference the box of its left operand, as in the other two algorithms; above them, supports are
//! those of what encloses the solid: of the left operand of a difference, and of the box or either operand of an
//! intersection, whichever is least. That is what the chain algorithm takes as well, by point sets that are larger than
//! the shapes. Where a chain finds the boxes of both operands apart, in any frame above them, nothing is left of the
//! intersection; here, [`apart`] finds that out without a frame. So the boxes here lie in those of the chain, and these in
//! the conventional ones, unless a query reaches the limit of its expansions.

mod apart;
mod attractor;
mod bottom_up;
mod components;
mod contraction;
mod finest;
mod furthest;
mod guess;
mod norm;
mod query;
mod shrinks;
mod solids;
mod states;

use std::fmt;

use glam::DVec3;

use crate::{Aabb, BoundsError, HyperBoxes, Limits, Scene};
use bottom_up::{BottomUp, Known};
#[cfg(feature = "csg-graph")]
pub(crate) use components::Components;
use query::Search;
pub(crate) use states::{States, Term};

/// Tight boxes for all states of a scene, found without unfolding it.
///
/// Each encloses its solid, rounding included. The box of a union of transformed shapes is the least one, but for its
/// [`gap`](StateBox::gap) and for rounding: some 10⁻¹⁴ of the largest coordinates below it, and as much more as the maps
/// lose by cancellation. An intersection gets the intersection of the boxes, or the empty box where a plane between its
/// operands is found; a difference gets the box of its left operand.
///
/// A recursion that never ends has a box if it shrinks: that of its attractor, the largest bounded solid that is what the
/// recursion makes of it. Such a recursion needs no shape at all:
///
/// ```
/// use std::convert::Infallible;
///
/// use csg_graph_bounds::{Aabb, Limits, Scene, Step, exact};
/// use glam::{DAffine3, DVec3};
///
/// /// Cantor's dust: two copies of itself at a third of its size, at both ends.
/// struct Dust;
///
/// #[derive(Clone, PartialEq, Eq, Hash)]
/// enum State {
///     Dust,
///     Copy { right: bool },
/// }
///
/// impl Scene for Dust {
///     type State = State;
///     type Map = DAffine3;
///     type Shape = Aabb;
///     type Error = Infallible;
///
///     fn root(&self) -> State {
///         State::Dust
///     }
///
///     fn step(&self, state: &State) -> Result<Step<Self>, Infallible> {
///         Ok(match *state {
///             State::Dust => Step::Union(vec![State::Copy { right: false }, State::Copy { right: true }]),
///             State::Copy { right } => {
///                 let end = DVec3::X * if right { 2.0 / 3.0 } else { 0.0 };
///                 Step::Map(DAffine3::from_translation(end) * DAffine3::from_scale(DVec3::ONE / 3.0), State::Dust)
///             }
///         })
///     }
///
///     fn node(&self, _: &State) -> usize {
///         0
///     }
///
///     fn node_count(&self) -> usize {
///         1
///     }
/// }
///
/// let dust = exact(&Dust, &Limits::default())?;
/// assert!(dust.root.min.abs().max_element() < 1e-11);
/// assert!(dust.root.max.distance(DVec3::X) < 1e-11);
/// assert!(dust.endless.unwrap().contraction < 0.334);
/// # Ok::<(), csg_graph_bounds::BoundsError<Infallible>>(())
/// ```
///
/// # Cost
/// Memory in proportion to the states: about half a kilobyte each. Time too, and for each transformation that turns or
/// shears up to six support queries. One query expands, in what shrinks as it recurses, some multiple of the levels until
/// a part is smaller than the gap; at most [`Limits::expansions`]. For each intersection, a few searches in addition, of
/// some dozens of expansions at most. None depends on the size of the unfolded tree. For
/// states that lead back to themselves, rounds of such queries, some ten of few expansions each.
///
/// # Errors
/// If the scene fails to expand a state, there are too many states, or one is below itself without being smaller there.
///
/// # Panics
/// If the scene numbers a node at or above its [`node_count`](Scene::node_count).
pub fn exact<S: Scene>(scene: &S, limits: &Limits) -> Result<ExactBoxes<S>, BoundsError<S::Error>> {
    let found = BottomUp::new(scene, limits, usize::MAX)?;
    let mut nodes = vec![Aabb::EMPTY; scene.node_count()];
    for (state, found) in found.states.states.iter().zip(&found.boxes) {
        let node = scene.node(state);
        nodes[node] = nodes[node].join(found.aabb);
    }
    let counts = Counts {
        states: found.boxes.len(),
        solids: found.solids.len(),
        queries: found.search.queries,
        expansions: found.search.expansions,
    };
    let gap = found.boxes.iter().fold(0.0, |gap: f64, state| gap.max(state.gap));
    let (root, endless) = (found.root().aabb, found.endless);
    Ok(ExactBoxes { root, nodes, gap, endless, counts, limits: *limits, found })
}

/// The box of the root alone, as [`exact`] gives it but in less time: where `exact` asks for the box of each state until
/// it is certain, this one asks six times, and for the other boxes only until they are of use for that.
///
/// Where there is an intersection nothing is saved: its box is what the boxes of its operands have in common, and these must
/// be as certain as its own.
///
/// # Cost
/// As for `exact`; of each query, the first few expansions.
///
/// # Errors
/// As for `exact`.
pub fn root_box<S: Scene>(scene: &S, limits: &Limits) -> Result<StateBox, BoundsError<S::Error>> {
    Ok(BottomUp::new(scene, limits, ROUGH)?.refined_root(limits))
}

/// How many expansions a query needs whose answer only prunes others: with fewer the boxes grow from level to level and
/// prune little, and more cost more than they save.
const ROUGH: usize = 3;

/// The boxes of all states of a scene, and of all nodes.
pub struct ExactBoxes<S: Scene> {
    /// The box of the root, in the frame of the world.
    pub root: Aabb,
    /// For each node the union of the boxes of all its states, each in the node's frame; for a T-node that is the frame
    /// that it maps *into*. [`Aabb::EMPTY`] for a node that is never reached.
    pub nodes: Vec<Aabb>,
    /// The largest gap of all states.
    pub gap: f64,
    /// How recursion that never ends shrinks; `None` if all of it ends.
    pub endless: Option<Endless>,
    /// What it took.
    pub counts: Counts,
    limits: Limits,
    found: BottomUp<S>,
}

impl<S: Scene> fmt::Debug for ExactBoxes<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { root, nodes, gap, endless, counts, limits, found: _ } = self;
        f.debug_struct("ExactBoxes")
            .field("root", root)
            .field("nodes", nodes)
            .field("gap", gap)
            .field("endless", endless)
            .field("counts", counts)
            .field("limits", limits)
            .finish_non_exhaustive()
    }
}

/// The box of one state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct StateBox {
    /// The box, in the frame of the state; for a T-node, in the frame that it maps into.
    pub aabb: Aabb,
    /// No face is further out than this from its least position, rounding apart. Above ∩ and \\, that is the least one that
    /// encloses the boxes or operands which stand for the solid.
    ///
    /// At most a few times [`Limits::gap`] of the extent of the box, unless a query reached the limit of its
    /// expansions. Where recursion never ends, rounding is included.
    pub gap: f64,
}

/// The support of a state: how far it reaches in a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Support {
    /// No point of the solid reaches further, rounding included.
    pub upper: f64,
    /// By how much it may be too large, rounding apart; as for [`StateBox::gap`].
    pub gap: f64,
}

/// What is known of recursion that never ends, but has a bounded solid because it shrinks.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Endless {
    /// How many states lead back to themselves.
    pub states: usize,
    /// Once round any cycle of states that boxes are made from, distances shrink to at most this share of what they were,
    /// measured in suitable norms. Below 1, and certified, rounding included. What is subtracted, or clipped by another
    /// operand, may shrink or not: [`ExactBoxes::shrinks`] tells.
    pub contraction: f64,
}

/// What boxes took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Counts {
    /// States, of all nodes.
    pub states: usize,
    /// Those that are not merely another one, moved.
    pub solids: usize,
    /// Support queries that known boxes did not answer.
    pub queries: u64,
    /// Solids that the queries replaced by their parts.
    pub expansions: u64,
}

impl<S: Scene> ExactBoxes<S> {
    /// The box of a state, or `None` if the root does not lead to it.
    pub fn of(&self, state: &S::State) -> Option<StateBox> {
        self.found.states.number(state).map(|number| self.found.boxes[number])
    }

    /// Where a state is among [all states](Self::states), or `None` if the root does not lead to it.
    pub fn index_of(&self, state: &S::State) -> Option<usize> {
        self.found.states.number(state)
    }

    /// All states with their boxes, each after those below it, the root last.
    pub fn states(&self) -> impl ExactSizeIterator<Item = (&S::State, StateBox)> {
        self.found.states.states.iter().zip(self.found.boxes.iter().copied())
    }

    /// The support of a state in any direction, of any length: a query, as those for the boxes. `None` if the root does
    /// not lead to the state.
    ///
    /// Other volumes are made from supports.
    pub fn support(&self, state: &S::State, direction: DVec3) -> Option<Support> {
        self.support_within(state, direction, self.limits.gap)
    }

    /// The same where another [gap](Limits::gap) is enough: the larger, the fewer solids the query has to replace by their
    /// parts.
    pub fn support_within(&self, state: &S::State, direction: DVec3, gap: f64) -> Option<Support> {
        let number = self.found.states.number(state)?;
        let mut search = Search::new(&self.limits.with_gap(gap));
        let known = Known { below: self.found.boxes[number], direction, offset: 0.0 };
        let image = self.found.images[number];
        Some(bottom_up::support(&self.found.solids, &mut search, image, direction, &known))
    }

    /// What all states are, by their numbers.
    pub(crate) fn graph(&self) -> &States<S> {
        &self.found.states
    }

    /// The shapes that the terms of the states refer to.
    pub(crate) fn shapes(&self) -> &[S::Shape] {
        &self.found.solids.shapes
    }

    /// The box of each state, by its number.
    pub(crate) fn boxes(&self) -> &[StateBox] {
        &self.found.boxes
    }

    /// The boxes of the root and of all nodes, without those of the states.
    pub fn into_hyper_boxes(self) -> HyperBoxes {
        HyperBoxes { root: self.root, nodes: self.nodes }
    }
}
