//! The states of a scene, each once, children before their parents: a graph where the unfolded tree repeats itself.
//!
//! A depth-first search with an explicit path. Two places of the unfolded tree with equal states are the same solid, so
//! that the search enters each state once, and takes time and memory in proportion to their number. A state met again
//! while it is still on the path is a recursion that never ends, since equal states unfold alike; there, and only there,
//! a state has a lower number than one below it.

use std::collections::hash_map::Entry;
use std::ops::Range;

use glam::DAffine3;
use rustc_hash::FxHashMap;

use crate::limits::Round;
use crate::narrow::index;
use crate::{BoundsError, Limits, Map, Scene, Step};

/// The states below a root, numbered so that each has a higher number than those below it, unless they lead back to it.
pub(crate) struct States<S: Scene> {
    /// Each state by its number; the root is the last.
    pub(crate) states: Vec<S::State>,
    /// What each is.
    pub(crate) terms: Vec<Term>,
    /// The maps of T-nodes.
    pub(crate) maps: Vec<DAffine3>,
    pub(super) shapes: Vec<S::Shape>,
    /// The numbers of the parts of all unions.
    pub(crate) parts: Vec<u32>,
    /// Whether any state leads back to itself.
    pub(crate) cyclic: bool,
    /// When each state was entered, and by that the number it got when it was left.
    entered: FxHashMap<S::State, u32>,
    numbers: Vec<u32>,
}

/// What a state is, by the numbers of what is below it.
#[derive(Clone)]
pub(crate) enum Term {
    /// An index into the shapes.
    Shape(u32),
    Same(u32),
    /// An index into the maps, and what is mapped.
    Map(u32, u32),
    /// A range of the parts.
    Union(Range<u32>),
    Intersection([u32; 2]),
    Difference([u32; 2]),
}

/// The number of a state on the path, which has none yet.
const ON_PATH: u32 = u32::MAX;

/// Stands for the number of a state on the path, with when that was entered, until it is known.
const BACK: u32 = 1 << 31;

/// A state on the path of the search.
struct Frame<S: Scene> {
    state: S::State,
    entered: usize,
    kind: Kind<S>,
    /// How many states were waiting before those below this one.
    waiting: usize,
    /// How many numbers were known before those of the states below this one.
    known: usize,
}

enum Kind<S: Scene> {
    Shape(S::Shape),
    Same,
    Map(DAffine3),
    Union,
    Intersection,
    Difference,
}

impl<S: Scene> States<S> {
    /// Finds all states below the root of a scene.
    pub(super) fn explore(scene: &S, limits: &Limits) -> Result<Self, BoundsError<S::Error>> {
        let mut found = Self {
            states: Vec::new(),
            terms: Vec::new(),
            maps: Vec::new(),
            shapes: Vec::new(),
            parts: Vec::new(),
            cyclic: false,
            entered: FxHashMap::default(),
            numbers: Vec::new(),
        };
        let mut path: Vec<Frame<S>> = Vec::new();
        // Of all states on the path: those below that are yet to be entered, the next one last, and the numbers of
        // those that were.
        let mut waiting = vec![scene.root()];
        let mut known: Vec<u32> = Vec::new();
        loop {
            if waiting.len() > path.last().map_or(0, |frame| frame.waiting)
                && let Some(state) = waiting.pop()
            {
                match found.entered.entry(state) {
                    Entry::Occupied(entry) => match found.numbers[*entry.get() as usize] {
                        ON_PATH => {
                            found.cyclic = true;
                            known.push(BACK | *entry.get());
                        }
                        number => known.push(number),
                    },
                    Entry::Vacant(_) if found.numbers.len() >= limits.states => {
                        return Err(BoundsError::TooManyStates { limit: limits.states });
                    }
                    Entry::Vacant(entry) => {
                        let state = entry.key().clone();
                        let entered = found.numbers.len();
                        entry.insert(index(entered));
                        found.numbers.push(ON_PATH);
                        let (waited, known) = (waiting.len(), known.len());
                        let step = scene.step(&state).map_err(BoundsError::Scene)?;
                        let kind = open(step, &mut waiting);
                        path.push(Frame { state, entered, kind, waiting: waited, known });
                    }
                }
            } else if let Some(frame) = path.pop() {
                let number = found.close(frame, &mut known);
                known.push(number);
            } else {
                if found.cyclic {
                    found.close_cycles();
                }
                return Ok(found);
            }
        }
    }

    /// Puts numbers where states were met again before they had one.
    fn close_cycles(&mut self) {
        let numbers = &self.numbers;
        let close = |below: &mut u32| {
            if *below & BACK != 0 {
                *below = numbers[(*below & !BACK) as usize];
            }
        };
        for term in &mut self.terms {
            match term {
                Term::Shape(_) | Term::Union(_) => {}
                Term::Same(below) | Term::Map(_, below) => close(below),
                Term::Intersection(operands) | Term::Difference(operands) => {
                    operands.iter_mut().for_each(close)
                }
            }
        }
        self.parts.iter_mut().for_each(close);
    }

    /// The states that the box of a state is made from: all directly below it, but for what is subtracted.
    pub(super) fn below(&self, number: u32) -> &[u32] {
        match &self.terms[number as usize] {
            Term::Shape(_) => &[],
            Term::Same(below) | Term::Map(_, below) => std::slice::from_ref(below),
            Term::Union(parts) => &self.parts[parts.start as usize..parts.end as usize],
            Term::Intersection(operands) => operands,
            Term::Difference(operands) => &operands[..1],
        }
    }

    /// All states directly below a state.
    pub(super) fn operands(&self, number: u32) -> &[u32] {
        match &self.terms[number as usize] {
            Term::Difference(operands) => operands,
            _ => self.below(number),
        }
    }

    /// The error that names a cycle of states, and says what it does each time round.
    pub(super) fn endless(&self, scene: &S, mut cycle: Vec<u32>, round: Round) -> BoundsError<S::Error> {
        // From where the search came first, which it left last.
        let entered = (0..cycle.len()).max_by_key(|at| cycle[*at]).unwrap_or(0);
        cycle.rotate_left(entered);
        let labels = cycle.iter().map(|state| scene.label(&self.states[*state as usize]));
        BoundsError::Endless { cycle: labels.collect(), round }
    }

    /// Numbers a state whose children all have numbers, the last ones known.
    fn close(&mut self, frame: Frame<S>, known: &mut Vec<u32>) -> u32 {
        let below = &known[frame.known..];
        let term = match frame.kind {
            Kind::Shape(shape) => {
                self.shapes.push(shape);
                Term::Shape(index(self.shapes.len() - 1))
            }
            Kind::Same => Term::Same(below[0]),
            Kind::Map(map) => {
                self.maps.push(map);
                Term::Map(index(self.maps.len() - 1), below[0])
            }
            Kind::Union => {
                let start = self.parts.len();
                self.parts.extend_from_slice(below);
                Term::Union(index(start)..index(self.parts.len()))
            }
            Kind::Intersection => Term::Intersection([below[0], below[1]]),
            Kind::Difference => Term::Difference([below[0], below[1]]),
        };
        known.truncate(frame.known);
        let number = index(self.states.len());
        self.numbers[frame.entered] = number;
        self.states.push(frame.state);
        self.terms.push(term);
        number
    }

    /// The number of a state.
    pub(crate) fn number(&self, state: &S::State) -> Option<usize> {
        self.entered.get(state).map(|entered| self.numbers[*entered as usize] as usize)
    }
}

/// Lets the states below a state wait, the first one last.
fn open<S: Scene>(step: Step<S>, waiting: &mut Vec<S::State>) -> Kind<S> {
    match step {
        Step::Shape(shape) => Kind::Shape(shape),
        Step::Same(below) => {
            waiting.push(below);
            Kind::Same
        }
        Step::Map(map, below) => {
            waiting.push(below);
            Kind::Map(map.affine())
        }
        Step::Union(parts) => {
            waiting.extend(parts.into_iter().rev());
            Kind::Union
        }
        Step::Intersection([left, right]) => {
            waiting.extend([right, left]);
            Kind::Intersection
        }
        Step::Difference([left, right]) => {
            waiting.extend([right, left]);
            Kind::Difference
        }
    }
}
