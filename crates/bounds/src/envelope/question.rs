//! One question: the envelope of a state whose varying parameters are known.
//!
//! What is below is visited key by key, from the top down, each only after all ways that lead into it: the intervals of its
//! parameters are their join. Then the envelopes come from the bottom up. When corners of a terrain are displaced by less and
//! less, that is the whole of a geometric series, and costs a few visits a level.
//!
//! Where keys lead back to themselves, each time round is a round of its own: (key, round) takes the place of the key. A
//! recursion that ends when something has become small enough ends here as well. What does not end within some rounds, and
//! what is too much, is bounded by what is known [in general](super::general).

use std::collections::BinaryHeap;
use std::ops::Range;

use csg_graph::{Graph, Interval};
use rustc_hash::FxHashMap;

use super::assemble::{Make, assemble, wanted};
use super::body::Body;
use super::general::Known;
use super::keys::Keys;

/// The most keys that a question visits, some hundred nanoseconds each.
const VISITS: usize = 4096;

/// The most times that it goes round.
const ROUNDS: u32 = 64;

/// Where the envelope of a part comes from.
#[derive(Clone, Copy)]
enum Source {
    /// What is known of that key in general.
    General(u32),
    /// The visit with that number, in the order in which visits are planned.
    Visit(u32),
}

/// A visit of a key: how it is made, and the range of its sources.
struct Visit<'a> {
    number: u32,
    make: Make<'a>,
    sources: Range<usize>,
}

/// The visits that are planned.
struct Plan {
    /// By round and key.
    numbers: FxHashMap<(u32, u32), u32>,
    /// The intervals of varying parameters of all visits.
    intervals: Vec<Interval>,
    /// What is next: of the first round, the highest key.
    queue: BinaryHeap<(std::cmp::Reverse<u32>, u32, u32)>,
}

/// The envelope of all states with a key whose varying parameters are in these intervals.
pub(super) fn envelope(
    graph: &Graph,
    keys: &Keys,
    general: &[Known],
    key: u32,
    varying: &[Interval],
) -> Known {
    let mut plan = Plan { numbers: FxHashMap::default(), intervals: Vec::new(), queue: BinaryHeap::new() };
    plan.reach(0, key, varying);
    let (mut visits, mut sources, mut values, mut below) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    while let Some((std::cmp::Reverse(round), key, number)) = plan.queue.pop() {
        let from = number as usize * varying.len();
        keys.fill(key, &plan.intervals[from..from + varying.len()], &mut values);
        let (make, parts) = keys.make(graph, key, &mut values);
        let start = sources.len();
        let count = if matches!(make, Make::Left) { 1 } else { usize::MAX };
        for part in keys.below(key)[parts].iter().take(count) {
            let next = if *part >= key { round + 1 } else { round };
            let known = !keys.varies(*part) || next == ROUNDS;
            let planned = plan.numbers.contains_key(&(next, *part));
            if known || !planned && plan.numbers.len() >= VISITS {
                sources.push(Source::General(*part));
            } else {
                keys.varying(*part, &values, &mut below);
                sources.push(Source::Visit(plan.reach(next, *part, &below)));
            }
        }
        visits.push(Visit { number, make, sources: start..sources.len() });
    }
    // By the number of a visit; visits are in the order in which they were made.
    let mut place = vec![0; visits.len()];
    visits.iter().enumerate().for_each(|(index, visit)| place[visit.number as usize] = index);
    let look = |source: Source| match source {
        Source::General(_) => None,
        Source::Visit(number) => {
            let Visit { make, sources: parts, .. } = &visits[place[number as usize]];
            Some((make, &sources[parts.clone()]))
        }
    };
    // Parts were visited after what they are parts of. Within a chain of transformations none is asked for.
    let mut asked = vec![false; visits.len()];
    asked[0] = true;
    for visit in &visits {
        if asked[visit.number as usize] {
            wanted(&visit.make, &sources[visit.sources.clone()], look, |source| {
                if let Source::Visit(number) = source {
                    asked[number as usize] = true;
                }
            });
        }
    }
    let mut found: Vec<Known> = vec![Ok(Body::EMPTY); visits.len()];
    for visit in visits.iter().rev().filter(|visit| asked[visit.number as usize]) {
        let known = |source: Source| match source {
            Source::General(key) => general[key as usize].as_ref(),
            Source::Visit(number) => found[number as usize].as_ref(),
        };
        found[visit.number as usize] = assemble(&visit.make, &sources[visit.sources.clone()], look, known);
    }
    match (found.swap_remove(0), &general[key as usize]) {
        (Ok(found), Ok(general)) => Ok(found.intersect(*general)),
        (found, _) => found,
    }
}

impl Plan {
    /// Plans a visit, or adds a way that leads into it.
    fn reach(&mut self, round: u32, key: u32, varying: &[Interval]) -> u32 {
        let fresh = u32::try_from(self.numbers.len()).unwrap_or(u32::MAX);
        let number = *self.numbers.entry((round, key)).or_insert(fresh);
        if number == fresh {
            self.intervals.extend(varying);
            self.queue.push((std::cmp::Reverse(round), key, number));
        } else {
            let known = &mut self.intervals[number as usize * varying.len()..][..varying.len()];
            known.iter_mut().zip(varying).for_each(|(known, new)| *known = known.join(*new));
        }
        number
    }
}
