//! Which of three regimes a scene is in, which decides how it is traced.
//!
//! - *Finite*: all states fit into memory. They are listed, each gets its exact box, and the graph is compiled as a whole.
//! - *Vast*: the states do not fit, as where random numbers make every instance another one. What rays come to is compiled
//!   when they come to it.
//! - *Endless*: the recursion never ends, but shrinks. It is compiled in the same way, and rays do not look into what is too
//!   small to be seen.

use std::fmt;

use csg_graph::{Analysis, StatesError};

use crate::Failure;
use crate::args::Plan;
use crate::load::{Loaded, MAX_STATES, MEMORY};

/// What a listed state takes with its box, in bytes, or somewhat less.
const STATE: usize = 1024;

/// So many states are listed in any case. It is more than what never ends has, in general, which is another picture when it
/// is not known to.
const FEW: usize = 1 << 12;

/// What is known of all states of a scene.
pub(crate) enum Regime {
    Finite(Box<Analysis>),
    /// There are more states than this.
    Vast(Limit),
    Endless,
}

/// How many states may be listed.
#[derive(Clone, Copy)]
pub(crate) struct Limit {
    pub(crate) states: usize,
    /// The option that allows more.
    pub(crate) option: &'static str,
}

/// The memory that it takes to list so many states.
pub(crate) fn listing_bytes(states: usize) -> usize {
    if states <= FEW { 0 } else { states.saturating_mul(STATE) }
}

impl Regime {
    /// Finds out, for an engine that is planned; and why the states are not listed, if they are not.
    pub(crate) fn of(loaded: &Loaded, plan: Plan) -> Result<(Self, Option<StatesError>), Failure> {
        let mut limits = loaded.limits;
        let mut option = MAX_STATES;
        if let Plan::Fast { memory, .. } = plan
            && listing_bytes(limits.states) > memory
        {
            limits.states = (memory / STATE).max(FEW);
            option = MEMORY;
        }
        match loaded.scene.graph.analyse(&limits) {
            Ok(analysis) => Ok((Self::Finite(Box::new(analysis)), None)),
            Err(unlisted @ StatesError::Endless { .. }) => Ok((Self::Endless, Some(unlisted))),
            Err(unlisted @ StatesError::TooMany { limit: states, .. }) => {
                Ok((Self::Vast(Limit { states, option }), Some(unlisted)))
            }
            Err(error) => Err(loaded.failure(&error)),
        }
    }

    /// The option that would have more states listed.
    pub(crate) fn limiting_option(&self) -> &'static str {
        if let Self::Vast(limit) = self { limit.option } else { MAX_STATES }
    }

    /// The number of primitives, in words if nobody can count them.
    pub(crate) fn primitives(&self) -> String {
        match self {
            Self::Finite(analysis) => analysis.primitives.to_string(),
            Self::Vast(_) => "uncounted".to_owned(),
            Self::Endless => "endless".to_owned(),
        }
    }
}

impl fmt::Display for Regime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Finite(_) => "finite",
            Self::Vast(_) => "vast",
            Self::Endless => "endless",
        })
    }
}
