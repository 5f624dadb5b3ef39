//! How much work and memory an algorithm may take, and the errors that say so.

use std::fmt;

/// How much an algorithm may do before it gives up with an error.
///
/// A few lines of a scene unfold into a tree that no machine can walk, or into one that never ends, and may as easily have
/// endlessly many states. Work and memory are therefore counted, and the counts limited.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Limits {
    /// Steps of the algorithms that walk the unfolded tree, [`conventional`](crate::conventional) and
    /// [`chain`](crate::chain): nodes visited plus boxes computed, those of the frames above a shape included. Of a chain's
    /// boxes, each maps all points of a shape.
    ///
    /// By default 200 million, about as much as someone waits for: some twenty seconds of the conventional algorithm, a
    /// minute or more of the chain algorithm.
    pub steps: u64,
    /// Nodes, maps and boxes that those algorithms hold at one time: they grow with the depth of the unfolded tree.
    ///
    /// By default 5 million, which is a recursion of about a million levels and some hundred megabytes: an endless
    /// recursion is stopped before it takes the machine's memory.
    pub held: usize,
    /// The most states that [`exact`](crate::exact) visits.
    ///
    /// By default 4 million, which is about two gigabytes and some seconds.
    pub states: usize,
    /// How many states a support query of [`exact`](crate::exact) may expand, before it adds what is still uncertain to
    /// the box.
    ///
    /// By default 10,000, which is a millisecond. Most queries need less than a hundred.
    pub expansions: usize,
    /// The gap, relative to the extent of the box, at which a support query of [`exact`](crate::exact) may end and add
    /// it to the box. Gaps from below add to it: up to a few times as much.
    ///
    /// By default 10⁻¹². In deep scenes, larger ones make the queries faster, and the boxes larger by as much. What is not above
    /// 0, or no number, is as 0: queries end where rounding does.
    pub gap: f64,
    /// The most states without chance that `Envelopes` tell apart. If there are more, they know the
    /// parameter with the most values by intervals alone.
    ///
    /// By default 50,000, which is some twenty megabytes and a tenth of a second.
    pub keys: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            steps: 200_000_000,
            held: 5_000_000,
            states: 4_000_000,
            expansions: 10_000,
            gap: 1e-12,
            keys: 50_000,
        }
    }
}

impl Limits {
    /// These limits with another number of [`steps`](Self::steps).
    #[must_use]
    pub fn with_steps(self, steps: u64) -> Self {
        Self { steps, ..self }
    }

    /// These limits with another number of [`states`](Self::states).
    #[must_use]
    pub fn with_states(self, states: usize) -> Self {
        Self { states, ..self }
    }

    /// These limits with another number of [`expansions`](Self::expansions).
    #[must_use]
    pub fn with_expansions(self, expansions: usize) -> Self {
        Self { expansions, ..self }
    }

    /// These limits with another [`gap`](Self::gap).
    #[must_use]
    pub fn with_gap(self, gap: f64) -> Self {
        Self { gap, ..self }
    }

    /// These limits with another number of [`keys`](Self::keys).
    #[must_use]
    pub fn with_keys(self, keys: usize) -> Self {
        Self { keys, ..self }
    }

    /// These limits with another number of things [`held`](Self::held).
    #[must_use]
    pub fn with_held(self, held: usize) -> Self {
        Self { held, ..self }
    }
}

/// Why there are no boxes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BoundsError<E> {
    /// The scene could not expand a state.
    #[error(transparent)]
    Scene(E),
    /// The unfolded tree is too large.
    #[error(
        "the boxes take more than {limit} steps, for the algorithm walks the whole unfolded tree; \
         unfold less deeply, or raise `Limits::steps`"
    )]
    TooManySteps {
        /// The limit that was set.
        limit: u64,
    },
    /// The unfolded tree is too deep.
    #[error(
        "the walk for the boxes holds more than {limit} nodes, maps and boxes at one time; does the recursion \
         ever end? If it does, raise `Limits::held`"
    )]
    TooDeep {
        /// The limit that was set.
        limit: usize,
    },
    /// There are too many states.
    #[error("there are more than {limit} states; does the recursion end? If it does, raise `Limits::states`")]
    TooManyStates {
        /// The limit that was set.
        limit: usize,
    },
    /// A state is below itself, and not known to be smaller there: there is no bounded solid, or none was found.
    #[error("the recursion never ends: {} leads back to itself and {round}", Cycle(.cycle))]
    Endless {
        /// The [labels](crate::Scene::label) of the states from the one that is met again to the last one before.
        cycle: Vec<String>,
        /// What happens once round this cycle.
        round: Round,
    },
}

/// What a cycle of states does to its solid each time round, instead of making it smaller.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Round {
    /// It comes back as it was: without a transformation, or with some that cancel.
    Unchanged,
    /// It neither grows nor shrinks in the long run: it turns, moves or shears.
    Turns,
    /// In the long run it grows by this factor each time round.
    Grows(f64),
    /// In the long run the cycle alone shrinks by this factor each time round. But together with the other cycles about it,
    /// no norms were found in which all of them do.
    Unproven(f64),
    /// It is unbounded, so that no part of it is ever too small to matter.
    Infinite,
    /// Bounds of it, which take all transformations at their extremes, grow by this factor after many rounds.
    Unbounded(f64),
}

impl fmt::Display for Round {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unchanged => write!(f, "comes back unchanged"),
            Self::Turns => write!(f, "does not shrink on the way"),
            Self::Grows(factor) => write!(f, "grows by a factor of {factor:.4} each time round"),
            Self::Unproven(factor) => write!(
                f,
                "shrinks by a factor of {factor:.4} each time round, but cannot be shown to shrink on all ways"
            ),
            Self::Infinite => write!(f, "is unbounded, so that none of its parts is ever small"),
            Self::Unbounded(factor) => write!(
                f,
                "is not known to shrink on the way: with all transformations at their extremes, what bounds it grows \
                 by a factor of {factor:.4} each time round, or comes back as large"
            ),
        }
    }
}

/// `a → b → c`, without the middle if it is long.
struct Cycle<'a>(&'a [String]);

impl fmt::Display for Cycle<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 8;
        let (first, rest) = self.0.split_at(self.0.len().min(SHOWN));
        write!(f, "{}", first.join(" → "))?;
        if rest.is_empty() { Ok(()) } else { write!(f, " → … ({} more)", rest.len()) }
    }
}

/// Counts against the limits.
pub(crate) struct Meter {
    limits: Limits,
    steps: u64,
}

impl Meter {
    pub(crate) fn new(limits: Limits) -> Self {
        Self { limits, steps: 0 }
    }

    /// Counts steps that are about to be done.
    pub(crate) fn spend<E>(&mut self, steps: u64) -> Result<(), BoundsError<E>> {
        self.steps = self.steps.saturating_add(steps);
        let limit = self.limits.steps;
        if self.steps > limit { Err(BoundsError::TooManySteps { limit }) } else { Ok(()) }
    }

    /// Checks how much is held.
    pub(crate) fn hold<E>(&self, held: usize) -> Result<(), BoundsError<E>> {
        let limit = self.limits.held;
        if held > limit { Err(BoundsError::TooDeep { limit }) } else { Ok(()) }
    }
}
