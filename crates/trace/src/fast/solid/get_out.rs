//! Where a ray gets outside of a union: where all parts that it is in have been left.
//!
//! t becomes the last exit, and so on until no part holds the point at t. Boxes that begin behind t wait for t to get there;
//! none is opened twice, and neither those that the ray does not get to nor those that it has left meanwhile are ever
//! opened: boxes are kept with where it leaves them, as the near end of the ray backwards. Parts that are elsewhere cost
//! nothing.

use fearless_simd::Simd;

use super::question::{Answer, Question, Seek};
use super::{Call, Solids, extents};
use crate::Ray;
use crate::fast::held::Held;
use crate::fast::hits::{Hits, Place, ROOT};
use crate::fast::lanes::transform;
use crate::fast::single::{Open, crossed};
use crate::fast::tree::{Target, WIDTH};

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
        let (mut level, mut from) = (u32::MAX, union.last.t);
        let [mut start, mut here, mut end] = [0.0; 3];
        let mut block = held.block(ROOT);
        while union.last.t <= limit && union.last.t.is_finite() {
            let t = union.last.t;
            if self.stack.len() == union.stack && !self.wake(union.waiting, t) {
                break;
            }
            let Some(open) = self.stack.pop() else { break };
            let narrow = &self.levels[open.level as usize];
            if open.level != level {
                block = held.block(narrow.block);
            }
            if open.level != level || t > from {
                (level, from) = (open.level, t);
                [start, here, end] = [narrow.start(t), narrow.end(t), narrow.end(limit)];
            }
            // Left behind since it was put there.
            if -open.near < start {
                continue;
            }
            let at = match open.child.target() {
                Target::Node(node) => {
                    let node = &block.nodes[node];
                    self.work.boxes += u64::from(node.count);
                    let ([near, far], mut met) = crossed(simd, node, &narrow.line, start, end);
                    while met != 0 {
                        let slot = met.trailing_zeros() as usize % WIDTH;
                        met &= met - 1;
                        let open = Open { near: -far[slot], child: node.children[slot], level };
                        if near[slot] <= here {
                            self.stack.push(open);
                        } else {
                            self.waiting.push(Waiting { from: narrow.t(near[slot]), open });
                        }
                    }
                    continue;
                }
                Target::Item(at) => at,
            };
            let item = &block.items[at];
            let place = Place::new(narrow.way, at);
            let ray = transform(&narrow.ray, &item.item_from_super);
            let question = Question { from: t, ..union.question };
            if let Some((place, extents)) =
                extents(&mut self.work, hits, held, narrow, place, &ray, question.is_cut)
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
            let above = narrow.block;
            if let Some(solid) = self.open_item(held, hits, (block, above), place, ray) {
                // To be asked again as soon as the ray has got further.
                self.waiting.push(Waiting { from: t.next_up(), open });
                self.calls.push(Call::Leaving(union));
                let (left, way) = self.begin(held, hits, (solid, place), &ray, question);
                return self.ask(held, hits, (left, way), ray, question);
            }
        }
        self.stack.truncate(union.stack);
        self.waiting.truncate(union.waiting);
        self.levels.truncate(union.level);
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

    /// Where a ray gets outside of a union that is cut out, from the t on to which it has come by a face; and by which face.
    /// Beyond a limit it does not matter.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "what is asked, and where")]
    pub(in crate::fast) fn leave<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        operand: (u32, u32),
        ray: &Ray,
        [t, limit]: [f64; 2],
        face: Place,
    ) -> (f64, Place) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.clear(Some(face));
                let question = Question { seek: Seek::Outside, from: t, limit, is_cut: true };
                let answer = self.ask(held, hits, operand, *ray, question);
                let answer = self.go_on(simd, held, hits, answer);
                if answer.t > t { (answer.t, answer.face) } else { (t, face) }
            },
        )
    }
}
