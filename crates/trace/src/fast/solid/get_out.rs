//! Where a ray gets outside of a union: where all parts that it is in have been left.
//!
//! t becomes the last exit, and so on until no part holds the point at t. Boxes that begin behind t wait for t to get there;
//! none is opened twice, and neither those that the ray does not get to nor those that it has left meanwhile are ever
//! opened: boxes are kept with where it leaves them, as the near end of the ray backwards. Parts that are elsewhere cost
//! nothing.
//!
//! Rays of a [packet](crate::fast::cuts) that go on alone come here in the midst of a tree. They leave the part that they
//! are in. If it is left before the ray ends, the parts around it are added, and the search goes on in those.

use fearless_simd::Simd;

use super::question::{Answer, Question, Seek};
use super::{Call, Solids, extents};
use crate::Ray;
use crate::fast::blocks::Held;
use crate::fast::compile::{Content, SuperNode};
use crate::fast::frame::Narrow;
use crate::fast::hits::{Hits, Place};
use crate::fast::lanes::transform;
use crate::fast::single::{Open, crossed};
use crate::fast::tree::{Child, WIDTH};

/// A union that is being searched for where a ray gets outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaving {
    pub(super) question: Question,
    /// Up to where the parts reach that are known to follow each other.
    pub(super) last: Answer,
    /// Where its parts of the stack, of what waits, and of the levels begin.
    pub(super) stack: usize,
    pub(super) waiting: usize,
    pub(super) level: usize,
}

/// What a ray has not come to yet that gets outside of a union.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waiting {
    from: f64,
    open: Open,
}

/// A child of a super-node of a block that a ray has come to on some way.
#[derive(Clone, Copy, Debug)]
pub(in crate::fast) struct Part<'a> {
    pub(in crate::fast) ball: &'a SuperNode,
    pub(in crate::fast) child: Child,
    pub(in crate::fast) block: u32,
    pub(in crate::fast) way: u32,
}

impl Solids {
    /// Searches a union for parts that reach further, each box when the ray has come to it, until no part does, or until a
    /// part has to be asked that is on the stack then.
    #[inline(always)]
    pub(super) fn get_out<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        mut union: Leaving,
    ) -> Option<Answer> {
        let limit = union.question.limit;
        while union.last.t <= limit && union.last.t.is_finite() {
            let t = union.last.t;
            if self.stack.len() == union.stack && !self.wake(union.waiting, t) {
                break;
            }
            let Some(open) = self.stack.pop() else { break };
            let narrow = &self.levels[open.level as usize];
            // Left behind since it was put there.
            if -open.near < narrow.start(t) {
                continue;
            }
            let block = held.block(narrow.block);
            let at = match open.child.get() {
                Err(node) => {
                    let node = &block.nodes[node];
                    self.work.boxes += u64::from(node.count);
                    let ([near, far], mut met) =
                        crossed(simd, node, &narrow.line, narrow.start(t), narrow.end(limit));
                    let here = narrow.end(t);
                    let known = self.known.get(open.level.wrapping_sub(self.known_from) as usize);
                    while met != 0 {
                        let slot = met.trailing_zeros() as usize % WIDTH;
                        met &= met - 1;
                        let open = Open { near: -far[slot], child: node.children[slot], ..open };
                        if known == Some(&open.child) {
                            continue;
                        }
                        if near[slot] <= here {
                            self.stack.push(open);
                        } else {
                            self.waiting.push(Waiting { from: narrow.t(near[slot]), open });
                        }
                    }
                    continue;
                }
                Ok(at) => at,
            };
            let item = &block.items[at];
            let place = Place::new(narrow.way, at);
            let ray = transform(&narrow.ray, &item.item_from_super);
            let question = Question { from: t, ..union.question };
            if let Some((place, extents)) =
                extents(&mut self.work, hits, block, place, [&narrow.ray, &ray], question.is_cut)
            {
                let is_known = |face| hits.is_same(face, place);
                self.tied |= question.begins_at_face(&extents) && !self.come_by.is_some_and(is_known);
                let answer = question.answer(&extents, place);
                if answer.t > t {
                    union.last = answer;
                }
                let ahead = extents.iter().find(|[enter, exit]| enter < exit && *enter > union.last.t);
                if let Some([enter, _]) = ahead {
                    self.waiting.push(Waiting { from: *enter, open });
                }
                continue;
            }
            match item.content {
                Content::Super(_) | Content::Gate(_) => {
                    let above = narrow.block;
                    self.open_item(held, hits, (block, above), place, ray);
                }
                Content::Shape(_) => unreachable!("a primitive has its extents"),
                Content::Solid(solid) => {
                    // To be asked again as soon as the ray has got further.
                    self.waiting.push(Waiting { from: t.next_up(), open });
                    self.calls.push(Call::Leaving(union));
                    let (left, way) = self.begin(held, hits, (solid, place), &ray, question);
                    return self.ask(held, hits, (left, way), ray, question);
                }
            }
        }
        // What nobody waits for may be gone on with.
        if !self.calls.is_empty() {
            self.stack.truncate(union.stack);
            self.waiting.truncate(union.waiting);
            self.levels.truncate(union.level);
        }
        Some(union.last)
    }

    /// Puts what has waited until t on the stack. Says whether there was any.
    #[inline(always)]
    fn wake(&mut self, first: usize, t: f64) -> bool {
        let asleep = self.stack.len();
        for at in (first..self.waiting.len()).rev() {
            if self.waiting[at].from <= t {
                self.stack.push(self.waiting.swap_remove(at).open);
            }
        }
        self.stack.len() > asleep
    }

    /// How far a ray gets from t on within a part that is cut out, in pieces that each begin where another one has not
    /// ended; and by which face. It has come to t by a face that is known. Beyond a limit it does not matter.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "what is asked, and where")]
    pub(in crate::fast) fn leave<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        part: Part<'_>,
        ray: &Ray,
        [t, limit]: [f64; 2],
        face: Place,
    ) -> Option<(f64, Place)> {
        self.clear(Some(face));
        let narrow = Narrow::new(*ray, part.ball, part.block, part.way)?;
        self.open(narrow, part.child);
        let end = self.leave_on(simd, held, hits, [t, limit], face);
        (end.0 > t).then_some(end)
    }

    /// Adds a part around the one that was left, in which a child is known by that.
    pub(in crate::fast) fn leave_around(&mut self, part: Part<'_>, ray: &Ray, known: Child) {
        if let Some(narrow) = Narrow::new(*ray, part.ball, part.block, part.way) {
            let level = self.open(narrow, part.child);
            if self.known.is_empty() {
                self.known_from = level;
            }
            self.known.push(known);
        }
    }

    /// How far it gets from the t where it has left a part, with those that were added.
    #[inline(never)]
    pub(in crate::fast) fn leave_on<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        [t, limit]: [f64; 2],
        face: Place,
    ) -> (f64, Place) {
        simd.vectorize(
            #[inline(always)]
            || {
                let question = Question { seek: Seek::Outside, from: t, limit, is_cut: true };
                let last = Answer { t, face };
                self.calls.push(Call::Leaving(Leaving { question, last, stack: 0, waiting: 0, level: 0 }));
                let Answer { t, face } = self.go_on(simd, held, hits, None);
                (t, face)
            },
        )
    }
}
