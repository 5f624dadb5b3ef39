//! One question: the envelope of a state whose varying parameters are known, or only its box.
//!
//! The [plan] goes down through the keys below with the intervals of their parameters; then the envelopes come from the bottom
//! up. When corners of a terrain are displaced by less and less, that is the whole of a geometric series, and costs a visit a
//! level. A recursion that ends when something has become small enough ends here as well. What does not end within some
//! rounds, and what is too much, is bounded by what is known [in general](super::general).
//!
//! Of what is under nothing but [straight](super::straight) maps, the boxes are enough for a box.

#[cfg(test)]
mod plainly;
mod plan;

use std::cell::RefCell;

use csg_graph::Interval;

use super::body::Body;
use super::general::{Failure, Known};
use super::keys::Keys;
use super::primitive;
use super::transform::{image, image_box};
use crate::{Aabb, Volume};
use plan::{Part, Plan, Source};

/// Who is asked.
#[derive(Clone, Copy)]
pub(super) struct Question<'a> {
    pub(super) keys: &'a Keys,
    pub(super) general: &'a [Known],
}

/// What has become of a visit.
#[derive(Clone, Copy)]
enum Found {
    Box(Aabb),
    Body(Body),
    /// It has no envelope, since that key has none.
    Nothing(u32),
}

/// What a thread has allocated for its questions.
#[derive(Default)]
struct Scratch {
    plan: Plan,
    /// By visit, whether its whole envelope is wanted.
    whole: Vec<bool>,
    found: Vec<Found>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

impl<'a> Question<'a> {
    /// The envelope of all states with a key whose varying parameters are in these intervals.
    pub(super) fn body(self, key: u32, varying: impl Iterator<Item = Interval>) -> Result<Body, &'a Failure> {
        let found = body(self.ask(key, varying, true)).map_err(|key| self.failure(key))?;
        let general = self.general[key as usize].as_ref();
        Ok(general.map_or(found, |general| found.intersect(*general)))
    }

    /// The box of that envelope.
    pub(super) fn aabb(self, key: u32, varying: impl Iterator<Item = Interval>) -> Result<Aabb, &'a Failure> {
        let found = aabb(self.ask(key, varying, false)).map_err(|key| self.failure(key))?;
        let general = self.general[key as usize].as_ref();
        Ok(general.map_or(found, |general| found.intersect(general.slabs.aabb())))
    }

    fn failure(self, key: u32) -> &'a Failure {
        self.general[key as usize].as_ref().expect_err("a key without an envelope")
    }

    fn ask(self, key: u32, varying: impl Iterator<Item = Interval>, whole: bool) -> Found {
        let mut scratch = SCRATCH.take();
        let Scratch { plan, whole: wanted, found } = &mut scratch;
        plan.make(self.keys, key, varying);
        wanted.clear();
        wanted.resize(plan.made().len(), false);
        wanted[0] = whole;
        for visit in plan.made() {
            let (parts, meets) = plan.parts(*visit);
            let whole = wanted[*visit as usize] || meets;
            for part in parts {
                if let Source::Visit(number) = part.source {
                    wanted[number as usize] |= whole || !plan.is_straight(part.link);
                }
            }
        }
        found.clear();
        found.resize(plan.made().len(), Found::Box(Aabb::EMPTY));
        for visit in plan.made().iter().rev() {
            let (parts, meets) = plan.parts(*visit);
            let made = if meets {
                self.meet(plan, parts, found).map(Found::Body)
            } else if wanted[*visit as usize] {
                let join = |all: Body, part| Ok(all.join(self.part(plan, part, found)?));
                parts.iter().try_fold(Body::EMPTY, join).map(Found::Body)
            } else {
                let join = |all: Aabb, part| Ok(all.join(self.part_box(plan, part, found)?));
                parts.iter().try_fold(Aabb::EMPTY, join).map(Found::Box)
            };
            found[*visit as usize] = made.unwrap_or_else(Found::Nothing);
        }
        let answer = found[0];
        SCRATCH.set(scratch);
        answer
    }

    /// What all operands have in common. One without an envelope bounds nothing.
    fn meet(self, plan: &Plan, parts: &[Part], found: &[Found]) -> Result<Body, u32> {
        let operands = parts.iter().map(|part| self.part(plan, part, found));
        let meet = |all: Result<Body, u32>, operand: Result<Body, u32>| match (all, operand) {
            (Ok(all), Ok(operand)) => Ok(all.intersect(operand)),
            (all, Err(_)) => all,
            (Err(_), operand) => operand,
        };
        operands.reduce(meet).unwrap_or(Ok(Body::EMPTY))
    }

    /// The envelope of a part.
    fn part(self, plan: &Plan, part: &Part, found: &[Found]) -> Result<Body, u32> {
        let below = self.source(plan, part.source, found)?;
        let maps = plan.chain(self.keys, part.link);
        Ok(if maps.is_empty() { below } else { image(&maps, &below) })
    }

    /// The box of the envelope of a part.
    fn part_box(self, plan: &Plan, part: &Part, found: &[Found]) -> Result<Aabb, u32> {
        if !plan.is_straight(part.link) {
            let below = self.source(plan, part.source, found)?;
            return Ok(image_box(&plan.chain(self.keys, part.link), &below));
        }
        let below = match part.source {
            Source::General(key) => self.general[key as usize].as_ref().map_err(|_| key)?.slabs.aabb(),
            Source::Visit(visit) => aabb(found[visit as usize])?,
            Source::Solid(solid) => self.keys.solid(solid).slabs.aabb(),
            Source::Primitive(kind, from, count) => primitive::aabb(kind, plan.measures(from, count)),
        };
        let maps = plan.maps(self.keys, part.link);
        Ok(maps.fold(below, |below, map| map.image_of_box(&below).unwrap_or(Aabb::ALL)))
    }

    fn source(self, plan: &Plan, source: Source, found: &[Found]) -> Result<Body, u32> {
        Ok(match source {
            Source::General(key) => *self.general[key as usize].as_ref().map_err(|_| key)?,
            Source::Visit(visit) => body(found[visit as usize])?,
            Source::Solid(solid) => *self.keys.solid(solid),
            Source::Primitive(kind, from, count) => primitive::body(kind, plan.measures(from, count)),
        })
    }
}

fn body(found: Found) -> Result<Body, u32> {
    match found {
        Found::Body(body) => Ok(body),
        Found::Nothing(key) => Err(key),
        Found::Box(_) => unreachable!("the whole envelope was wanted"),
    }
}

fn aabb(found: Found) -> Result<Aabb, u32> {
    match found {
        Found::Box(bounds) => Ok(bounds),
        Found::Body(body) => Ok(body.slabs.aabb()),
        Found::Nothing(key) => Err(key),
    }
}
