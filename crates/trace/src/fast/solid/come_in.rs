//! Where a ray comes inside of a union: at the nearest part, as ever, and at once if some part is entered already.

use fearless_simd::Simd;

use super::question::{Answer, Question};
use super::{Call, Solids, extents};
use crate::fast::frame::Narrow;
use crate::fast::held::Held;
use crate::fast::hits::{Hits, Place};
use crate::fast::lanes::transform;
use crate::fast::single::{met, nearest};
use crate::fast::tree::Target;

/// A union that is being searched for where a ray comes inside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entering {
    pub(super) question: Question,
    pub(super) nearest: Answer,
    /// Where its parts of the stack and of the levels begin.
    pub(super) stack: usize,
    pub(super) level: usize,
}

impl Entering {
    /// Takes the answer of a part. Says whether it is at the same t as that of another one.
    #[inline(always)]
    #[expect(clippy::float_cmp, reason = "faces that differ by an ulp do not coincide")]
    pub(super) fn take(&mut self, answer: Answer) -> bool {
        let tied = answer.t == self.nearest.t && answer.t < f64::INFINITY;
        if answer.t < self.nearest.t {
            self.nearest = answer;
        }
        tied
    }

    /// The s between which a box matters.
    #[inline(always)]
    fn range(&self, narrow: &Narrow) -> [f32; 2] {
        [narrow.start(self.question.from), narrow.end(self.nearest.t.min(self.question.limit))]
    }
}

impl Solids {
    /// Searches a union, nearest boxes first, until it has an answer, or until a part has to be asked that is on the stack
    /// then.
    #[inline(always)]
    pub(super) fn come_in<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        mut union: Entering,
    ) -> Option<Answer> {
        let from = union.question.from;
        let mut level = u32::MAX;
        let mut known = union.nearest.t;
        let [mut start, mut end] = [0.0; 2];
        // Nothing is nearer than where the ray is already.
        while union.nearest.t > from && self.stack.len() > union.stack {
            let Some(open) = self.stack.pop() else { break };
            if open.level != level || union.nearest.t < known {
                (level, known) = (open.level, union.nearest.t);
                self.levels.truncate(level as usize + 1);
                [start, end] = union.range(&self.levels[level as usize]);
            }
            if open.near > end {
                continue;
            }
            let narrow = &self.levels[level as usize];
            let block = held.block(narrow.block);
            let at = match open.child.target() {
                Target::Node(node) => {
                    let node = &block.nodes[node];
                    self.work.boxes += u64::from(node.count);
                    let (near, met) = met(simd, node, &narrow.line, start, end);
                    let next = nearest(&mut self.stack, node, near, met, level);
                    self.stack.extend(next);
                    continue;
                }
                Target::Item(at) => at,
            };
            let item = &block.items[at];
            let place = Place::new(narrow.way, at);
            let ray = transform(&narrow.ray, &item.item_from_super);
            let question = Question { limit: union.question.limit.min(known), ..union.question };
            if let Some((place, extents)) =
                extents(&mut self.work, hits, held, narrow, place, &ray, question.is_cut)
            {
                self.tied |= question.begins_at_face(&extents);
                self.tied |= union.take(question.answer(&extents, place));
                continue;
            }
            let above = narrow.block;
            if let Some(solid) = self.open_item(held, hits, (block, above), place, ray) {
                self.calls.push(Call::Entering(union));
                let (left, way) = self.begin(held, hits, (solid, place), &ray, question);
                return self.ask(held, hits, (left, way), ray, question);
            }
        }
        self.stack.truncate(union.stack);
        self.levels.truncate(union.level);
        Some(union.nearest)
    }
}
