//! What is known of every key, whatever varies: intervals that hold the values of all its states, and an envelope of all.
//!
//! - **Intervals**, by abstract interpretation [COUS77] from the root downwards: those of a key are the join over all ways
//!   into it. Where keys lead back to themselves this goes round until nothing changes, and after some rounds *widens*: a
//!   bound that still moves jumps to the next of a few landmarks, at last to infinity.
//! - **Envelopes**, upwards from the primitives. Keys that lead back to themselves have none to start from, and so one is
//!   guessed and verified ([`fixpoint`](super::fixpoint)).
//!
//! For keys below which nothing varies that is all there is to know.

use std::ops::Range;

use csg_graph::{Graph, Interval, ParamId};

use super::assemble::Make;
use super::body::Body;
use super::fixpoint;
use super::keys::Keys;
use crate::Round;
use crate::exact::Components;

/// An envelope for every key, or what happens each time round a cycle of keys.
pub(super) type Known = Result<Body, Failure>;

/// Why a key has no envelope.
#[derive(Clone, Debug)]
pub(super) struct Failure {
    pub(super) cycle: Vec<u32>,
    pub(super) round: Round,
}

/// How a key is made, and of which of those below it.
pub(super) type Recipe<'a> = (Make<'a>, Range<usize>);

/// How many times intervals are joined before they are widened.
const PATIENCE: usize = 4;

/// Where bounds may stop on their way to infinity.
const LANDMARKS: [f64; 5] = [f64::NEG_INFINITY, -1.0, 0.0, 1.0, f64::INFINITY];

/// The envelopes of all keys, for whatever values their states may have.
pub(super) fn envelopes(graph: &Graph, keys: &Keys) -> Vec<Known> {
    let intervals = intervals(graph, keys);
    let recipes: Vec<Recipe<'_>> = (0_u32..)
        .zip(intervals)
        .map(|(key, varying)| varying.map_or((Make::Join, 0..0), |mut varying| keys.make(key, &mut varying)))
        .collect();
    let mut known: Vec<Known> = vec![Ok(Body::EMPTY); keys.len()];
    let components = Components::new(keys.len(), |key| keys.parts(key));
    components.iter().for_each(|component| fixpoint::solve(keys, component, &recipes, &mut known));
    known
}

/// For each key the intervals of its varying parameters, over all its states that the root leads to; `None` if it leads to
/// none.
fn intervals(graph: &Graph, keys: &Keys) -> Vec<Option<Vec<Interval>>> {
    let mut found: Vec<Option<Vec<Interval>>> = vec![None; keys.len()];
    let root = keys.root() as usize;
    let varying = keys.control().varying();
    let initial = |param: &ParamId| graph.initial().get(*param).map_or(Interval::EMPTY, Interval::point);
    found[root] = Some(varying.iter().map(initial).collect());
    let mut stale = vec![false; keys.len()];
    stale[root] = true;
    let mut round = 0;
    while stale.contains(&true) {
        for key in (0..keys.len()).rev() {
            if !std::mem::replace(&mut stale[key], false) {
                continue;
            }
            let Some(own) = &found[key] else { continue };
            let number = u32::try_from(key).unwrap_or(u32::MAX);
            let mut values = own.clone();
            let (_, parts) = keys.look(number, &mut values);
            for child in &keys.below(number)[parts] {
                let slot = &mut found[*child as usize];
                let mut grown = slot.is_none();
                let intervals = slot.get_or_insert_with(|| vec![Interval::EMPTY; varying.len()]);
                for (old, new) in intervals.iter_mut().zip(keys.varying(*child, &values)) {
                    let joined = old.join(new);
                    if joined != *old {
                        // Only what comes from below itself can move without end.
                        let back = *child >= number && round >= PATIENCE;
                        *old = if back { widened(*old, joined) } else { joined };
                        grown = true;
                    }
                }
                stale[*child as usize] |= grown;
            }
        }
        round += 1;
    }
    found
}

/// The bounds that moved, at the next landmark.
fn widened(old: Interval, new: Interval) -> Interval {
    let below = LANDMARKS.into_iter().rev().find(|landmark| *landmark <= new.min);
    let above = LANDMARKS.into_iter().find(|landmark| *landmark >= new.max);
    Interval {
        min: if new.min < old.min { below.unwrap_or(f64::NEG_INFINITY) } else { old.min },
        max: if new.max > old.max { above.unwrap_or(f64::INFINITY) } else { old.max },
    }
}
