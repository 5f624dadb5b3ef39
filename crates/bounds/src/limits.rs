//! How much work and memory an algorithm may take, and the errors that say so.

/// How much an algorithm may do before it gives up with an error.
///
/// The algorithms of this crate walk the whole unfolded tree, which a few lines of a scene make larger than any machine
/// can walk, or endless. Work and memory are therefore counted, and the counts limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Steps: nodes visited plus boxes computed, those of the frames above a shape included. Of a chain's boxes, each
    /// maps all points of a shape.
    ///
    /// By default 200 million, about as much as someone waits for: some twenty seconds of the conventional algorithm, a
    /// minute or more of the chain algorithm.
    pub steps: u64,
    /// Nodes, maps and boxes held at one time: they grow with the depth of the unfolded tree.
    ///
    /// By default 5 million, which is a recursion of about a million levels and some hundred megabytes: an endless
    /// recursion is stopped before it takes the machine's memory.
    pub held: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { steps: 200_000_000, held: 5_000_000 }
    }
}

impl Limits {
    /// These limits with another number of [`steps`](Self::steps).
    #[must_use]
    pub fn with_steps(self, steps: u64) -> Self {
        Self { steps, ..self }
    }

    /// These limits with another number of things [`held`](Self::held).
    #[must_use]
    pub fn with_held(self, held: usize) -> Self {
        Self { held, ..self }
    }
}

/// Why there are no boxes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
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
