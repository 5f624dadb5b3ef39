//! S-bounds: sweeps over the state graph that let operands cut each other ([CAME89]).
//!
//! Box algebra knows what is below a state, and nothing of where the state is used. Yet of the left operand of an
//! intersection only what is in the box of the right one can matter, and so on downward; with less of the operands left,
//! the boxes above shrink, and upward sweeps and downward sweeps alternate until nothing more is gained.
//!
//! What is kept for a state is its *context*: a box outside of which the state can be cut off without any change to the
//! root, **provided that all states are cut off at their contexts**. It is not a box of the state, which may reach far
//! beyond.
//!
//! - *Downward*, each use of a state lets through what is in the context above it, mapped into the frame of the state:
//!   for an operand of ∩ what is also in the context of the other; for the left operand of \ what is in the box of the
//!   right one's complement; for the right operand what is in the context of the left one. The context is the union of
//!   what all uses let through.
//! - *Upward*, the context shrinks to what box algebra makes of the contexts below.
//!
//! **Why two operands may cut each other at once.** Let p be A ∩ B, and x a point of the context of p. If x is in p, it
//! is in A and in B, and by induction over the sweeps no box that ever cut A or B was without it. If it is not in p, it is
//! missing from A or from B, and cutting off adds nothing. For A \ B let x be in A and in B, so that it is not in p. If
//! B is cut off at x, the context of A had lost x before, and contexts only shrink: A is cut off there as well.
//!
//! ## Changes versus the paper
//! Cameron bounds trees, where each node has one place. A state has many, so that its context is joined over all of
//! them, in the state's frame, and sweeps go by the numbers of states instead of up and down a tree. Recursion that never
//! ends has no such order; there, contexts stay the boxes of the states.

use std::fmt;

use super::enclosures::Enclosures;
use super::inverse::Inverse;
use crate::exact::Term;
use crate::{Aabb, ExactBoxes, Scene};

/// What [`ExactBoxes::s_bounds`] finds.
#[non_exhaustive]
pub struct SBounds<'a, S: Scene> {
    /// The S-bound of the root: a box that encloses the solid.
    pub root: Aabb,
    /// For each node the union of the [contexts](Self::context_of) of its states. **Not boxes of the nodes**, which may
    /// reach far beyond: what is outside can only not matter to the root.
    pub contexts: Vec<Aabb>,
    /// How many times sweeps went down and up.
    pub rounds: u32,
    exact: &'a ExactBoxes<S>,
    by_state: Vec<Aabb>,
}

impl<S: Scene> fmt::Debug for SBounds<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { root, contexts, rounds, .. } = self;
        f.debug_struct("SBounds")
            .field("root", root)
            .field("contexts", contexts)
            .field("rounds", rounds)
            .finish_non_exhaustive()
    }
}

impl<S: Scene> SBounds<'_, S> {
    /// The context of a state, in its own frame: the root stays the same solid if every state is cut off at its context.
    /// Empty for a state that does not matter at all; `None` for one that the root does not lead to.
    pub fn context_of(&self, state: &S::State) -> Option<Aabb> {
        self.exact.graph().number(state).map(|number| self.by_state[number])
    }
}

/// No more than so many rounds. Most scenes need two.
const ROUNDS: u32 = 12;

/// Another round is worth it if a context shrank by more than this part of its extent.
const WORTH: f64 = 0.01;

pub(super) fn s_bounds<'a, S: Scene>(exact: &'a ExactBoxes<S>, scene: &S) -> SBounds<'a, S> {
    let root = exact.graph().terms.len() - 1;
    let (by_state, rounds) = contexts(exact, &Enclosures::new(exact), root);
    let mut contexts = vec![Aabb::EMPTY; scene.node_count()];
    for (state, context) in exact.graph().states.iter().zip(&by_state) {
        let node = scene.node(state);
        contexts[node] = contexts[node].join(*context);
    }
    SBounds { root: by_state[root], contexts, rounds, exact, by_state }
}

/// The contexts of all states up to the root, which may be any state, and how many rounds they took.
pub(super) fn contexts<S: Scene>(
    exact: &ExactBoxes<S>,
    enclosures: &Enclosures,
    root: usize,
) -> (Vec<Aabb>, u32) {
    let inverses = exact.graph().maps.iter().map(Inverse::of).collect();
    let contexts = enclosures.inside[..=root].to_vec();
    let mut sweeps = Sweeps { exact, contexts, complements: &enclosures.outside, inverses };
    let mut rounds = 0;
    // Where states lead back to themselves, a sweep down would not meet all uses of a state before the state. Their own
    // boxes are contexts too.
    while rounds < ROUNDS && !exact.graph().cyclic {
        let before = sweeps.contexts.clone();
        sweeps.down();
        sweeps.up();
        rounds += 1;
        if !before.iter().zip(&sweeps.contexts).any(|(before, now)| shrank(*before, *now)) {
            break;
        }
    }
    (sweeps.contexts, rounds)
}

fn shrank(before: Aabb, now: Aabb) -> bool {
    let least = before.size() * (1.0 - WORTH);
    // Infinite extents that stay so have not shrunk.
    before != now && (now.is_empty() || now.size().cmplt(least).any())
}

struct Sweeps<'a, S: Scene> {
    exact: &'a ExactBoxes<S>,
    /// By the number of the state, up to the root. To begin with, the boxes of the states.
    contexts: Vec<Aabb>,
    /// Boxes of all that is not in a state.
    complements: &'a [Aabb],
    /// Of the maps, where they have one.
    inverses: Vec<Option<Inverse>>,
}

impl<S: Scene> Sweeps<'_, S> {
    /// Lets each use of a state say what it lets through.
    fn down(&mut self) {
        let states = self.exact.graph();
        let count = self.contexts.len();
        let mut through = vec![Aabb::EMPTY; count];
        through[count - 1] = Aabb::ALL;
        for number in (0..count).rev() {
            self.contexts[number] = self.contexts[number].intersect(through[number]);
            let context = self.contexts[number];
            let mut pass = |below: u32, part: Aabb| {
                let through = &mut through[below as usize];
                *through = through.join(part);
            };
            let of = |operand: u32| self.contexts[operand as usize];
            match states.terms[number] {
                Term::Shape(_) => {}
                Term::Same(below) => pass(below, context),
                Term::Map(map, below) => {
                    let inverse = self.inverses[map as usize];
                    pass(below, inverse.map_or(Aabb::ALL, |inverse| inverse.image(context)));
                }
                Term::Union(ref parts) => {
                    let parts = &states.parts[parts.start as usize..parts.end as usize];
                    parts.iter().for_each(|part| pass(*part, context));
                }
                Term::Intersection([left, right]) => {
                    pass(left, context.intersect(of(right)));
                    pass(right, context.intersect(of(left)));
                }
                Term::Difference([left, right]) => {
                    pass(left, context.intersect(self.complements[right as usize]));
                    pass(right, context.intersect(of(left)));
                }
            }
        }
    }

    /// Shrinks each context to what is left of the operands.
    fn up(&mut self) {
        let states = self.exact.graph();
        for number in 0..self.contexts.len() {
            let of = |operand: u32| self.contexts[operand as usize];
            let left_over = match states.terms[number] {
                Term::Shape(_) => continue,
                Term::Same(below) => of(below),
                Term::Map(map, below) => of(below).image(&states.maps[map as usize]),
                Term::Union(ref parts) => {
                    let parts = &states.parts[parts.start as usize..parts.end as usize];
                    parts.iter().fold(Aabb::EMPTY, |all, part| all.join(of(*part)))
                }
                Term::Intersection([left, right]) => of(left).intersect(of(right)),
                Term::Difference([left, right]) => of(left).intersect(self.complements[right as usize]),
            };
            self.contexts[number] = self.contexts[number].intersect(left_over);
        }
    }
}
