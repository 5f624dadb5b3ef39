//! What lines see of the parts that stop them.

use csg_graph::AttributeTerm;
use fearless_simd::dispatch;

use super::lines::on_sphere;
use super::{Meeting, Survey};
use crate::fast::compiled::{Content, SuperNode};
use crate::fast::cover::behind;
use crate::fast::frame::Narrow;
use crate::fast::hits::{ROOT, START};
use crate::fast::lanes::transform;
use crate::fast::look::Seen;
use crate::fast::sample::{Dice, Sample};
use crate::fast::tree::Target;
use crate::narrow::{index, narrow};
use crate::{Ray, shapes};

impl Survey<'_> {
    /// What a line sees of those that it meets of the children of a node, the nearest first: each stops it by chance.
    pub(super) fn see_first(
        &mut self,
        ball: &SuperNode,
        node: usize,
        met: &[Meeting],
        line: &Ray,
        dice: &mut Dice,
    ) -> Option<Seen> {
        let patience = narrow(dice.throw());
        let mut left = 1.0;
        let first = *met.iter().find(|meeting| {
            left = behind(left, meeting.cover, meeting.apart);
            left < patience
        })?;
        let face = self.see(first, line, dice)?;
        let open = face.open * self.open(ball, node, first, line, &face, dice);
        Some(Seen { open, ..face })
    }

    /// The part of the light to a face that parts do not stop, other than the one where it is: of what comes from one
    /// side, by chance.
    fn open(
        &self,
        ball: &SuperNode,
        node: usize,
        at: Meeting,
        line: &Ray,
        seen: &Seen,
        dice: &mut Dice,
    ) -> f32 {
        let direction = seen.normal.as_dvec3() + on_sphere(dice);
        let ray = Ray { origin: line.at(at.t), direction };
        let Some(narrow) = Narrow::new(ray, ball, ROOT, START, false) else { return 1.0 };
        let met = dispatch!(self.level, simd => self.meet(simd, node, &narrow));
        let others = met.iter().filter(|meeting| meeting.child != at.child);
        others.fold(1.0, |left, meeting| behind(left, meeting.cover, meeting.apart))
    }

    /// What a line sees of a part that stops it.
    fn see(&mut self, Meeting { t, child, .. }: Meeting, line: &Ray, dice: &mut Dice) -> Option<Seen> {
        let block = self.block;
        let at = match child.target() {
            Target::Node(node) => return self.found.looks[node].draw(line.direction, dice),
            Target::Item(at) => at,
        };
        let item = &block.items[at];
        let inside = transform(line, &item.item_from_super);
        let outer = item.paint.map_or(&[][..], |paint| &block.paints[paint as usize]);
        let (normal, node, depth, paint, open) = match item.content {
            Content::Shape(shape) => {
                let end = shapes::boundary(&block.shapes[shape as usize], &inside, t)?;
                (end.normal, item.node, 0, self.paint(outer, &[]), 1.0)
            }
            Content::Super(number) => {
                let root = block.root_node(number)?;
                let seen = self.found.looks[root].draw(inside.direction, dice)?;
                let inner = self.found.paints[seen.paint as usize].clone();
                (seen.normal.as_dvec3(), seen.node, seen.depth, self.paint(outer, &inner), seen.open)
            }
            Content::Solid(_) | Content::Gate(_) => {
                let (sample, _) = Sample::of_item(block, at, dice);
                let normal = sample.normal(&inside).unwrap_or(-inside.direction);
                (normal, sample.node, sample.depth, self.paint(outer, &sample.paint), 1.0)
            }
        };
        let normal = (item.item_from_super.matrix3.transpose() * normal).try_normalize()?.as_vec3();
        let normal = if normal.dot(line.direction.as_vec3()) > 0.0 { -normal } else { normal };
        Some(Seen { normal, node, depth: item.depth + depth, paint, open })
    }

    /// The index of what is painted from the outside and then from the inside.
    fn paint(&mut self, outer: &[(AttributeTerm, f64)], inner: &[(AttributeTerm, f64)]) -> u32 {
        let mut terms: Vec<(AttributeTerm, f64)> = Vec::new();
        for (term, value) in outer.iter().chain(inner) {
            match terms.iter_mut().find(|(known, _)| known == term) {
                Some((_, known)) => *known = *value,
                None => terms.push((*term, *value)),
            }
        }
        terms.sort_unstable_by_key(|(term, _)| *term);
        let key = terms.iter().map(|(term, value)| (*term, value.to_bits())).collect();
        *self.numbers.entry(key).or_insert_with(|| {
            self.found.paints.push(terms);
            index(self.found.paints.len() - 1)
        })
    }
}
