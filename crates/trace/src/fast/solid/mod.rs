//! The first boundary of the results of ∩ and \\: from event to event, and no further than to the first.
//!
//! Span evaluation, as the [reference walk](crate::Walk) does it, finds all boundaries of all operands and merges them.
//! Most of them are never seen. Here an operand answers two questions only, each the other one's complement:
//!
//! - [`Seek::Inside`]: the first t, from some t on, right behind which the ray is inside;
//! - [`Seek::Outside`]: the first t right behind which it is outside.
//!
//! An [operator](question) asks its operands in the same terms. An operand is a union, a tree of parts: in that, to come
//! [inside](come_in) is to meet some part, and to get [outside](get_out) is to leave every part that the ray is in. A part
//! may be the result of an operator again. What has not answered yet is on a stack, so that depth takes memory and not the
//! machine's stack.
//!
//! Being inside *right behind* t decides coincident faces without a tolerance: a span holds its first t and not its last
//! one. Where one part ends and the next begins nothing is left, and where a hole begins at the face that it is cut
//! into, nothing is entered. Which face is seen there is for the search of [faces](super::face) to find.

mod come_in;
mod get_out;
mod question;

use fearless_simd::Simd;

use self::come_in::Entering;
use self::get_out::{Leaving, Waiting};
use self::question::{Answer, Next, Operation, Question, Seek};
use super::compiled::{Compiled, Content, Solid};
use super::frame::Narrow;
use super::held::Held;
use super::hits::{Hits, Place};
use super::inquiry::Work;
use super::lanes::transform;
use super::single::Open;
use super::tree::Child;
use crate::Ray;
use crate::shapes::{self, Extents};

/// The memory of rays through solids.
#[derive(Debug, Default)]
pub(super) struct Solids {
    calls: Vec<Call>,
    /// The rays in the super-nodes that they are in.
    levels: Vec<Narrow>,
    stack: Vec<Open>,
    waiting: Vec<Waiting>,
    /// The face that the ray has come to by, if it does not begin where the question does.
    come_by: Option<Place>,
    /// Whether there may be several faces at one t, of which the wrong one is known.
    pub(super) tied: bool,
    pub(super) work: Work,
}

/// An operand that has not answered yet.
#[derive(Clone, Copy, Debug)]
enum Call {
    Operation(Operation),
    Entering(Entering),
    Leaving(Leaving),
}

impl Solids {
    /// The first boundary of a solid at t > 0 on a ray in its frame, not behind `end`, and the face there: if it is
    /// [tied](Self::tied), one of several.
    #[inline(never)]
    pub(super) fn first<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        at: (u32, Place),
        ray: &Ray,
        end: f64,
    ) -> Option<(f64, Place)> {
        simd.vectorize(
            #[inline(always)]
            || {
                let question = Question { seek: Seek::Inside, from: 0.0, limit: end, is_cut: false };
                let mut answer = self.run(simd, held, hits, at, ray, question);
                let leaves = answer.t <= 0.0;
                if leaves {
                    let question = Question { seek: Seek::Outside, ..question };
                    answer = self.run(simd, held, hits, at, ray, question);
                }
                let Answer { t, face } = answer;
                let face = Place { turned: face.turned != leaves, ..face };
                (t <= end && t.is_finite()).then_some((t, face))
            },
        )
    }

    /// Asks a solid, with what it asks in turn.
    #[inline(always)]
    fn run<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        (solid, place): (u32, Place),
        ray: &Ray,
        question: Question,
    ) -> Answer {
        self.clear(None);
        let (left, way) = self.begin(held, hits, (solid, place), ray, question);
        let answer = self.ask(held, hits, (left, way), *ray, question);
        self.go_on(simd, held, hits, answer)
    }

    #[inline(always)]
    fn clear(&mut self, come_by: Option<Place>) {
        self.calls.clear();
        self.levels.clear();
        self.stack.clear();
        self.waiting.clear();
        self.come_by = come_by;
        self.tied = false;
    }

    /// Goes on with the last answer until there is no question left.
    #[inline(always)]
    fn go_on<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        mut answer: Option<Answer>,
    ) -> Answer {
        loop {
            answer = match (self.calls.last_mut(), answer) {
                (None, Some(answer)) => return answer,
                (Some(Call::Operation(operation)), Some(part)) => match operation.resume(part) {
                    Next::Answer(answer) => {
                        self.calls.pop();
                        Some(answer)
                    }
                    Next::Ask(operand, question) => {
                        let (ray, way) = (operation.ray, operation.way);
                        self.ask(held, hits, (operand, way), ray, question)
                    }
                },
                (Some(Call::Entering(union)), answer) => {
                    let mut union = *union;
                    self.calls.pop();
                    if let Some(part) = answer {
                        self.tied |= union.take(part);
                    }
                    self.come_in(simd, held, hits, union)
                }
                (Some(Call::Leaving(union)), answer) => {
                    let mut union = *union;
                    self.calls.pop();
                    union.last = answer.filter(|part| part.t > union.last.t).unwrap_or(union.last);
                    self.get_out(simd, held, hits, union)
                }
                (_, None) => unreachable!("only unions wait before they have asked"),
            }
        }
    }

    /// Puts an operator on the stack, which waits for its left operand, and says what that is and the way to it. It is
    /// asked the same.
    #[inline(always)]
    fn begin(
        &mut self,
        held: &Held<'_>,
        hits: &mut Hits,
        (solid, place): (u32, Place),
        ray: &Ray,
        question: Question,
    ) -> (u32, u32) {
        let block = hits.block(place.way);
        let from = held.block(block);
        let Solid { operator, operands } = from.solids[solid as usize];
        let way = hits.enter(place, from, block);
        let (ray, asked, other) = (*ray, 0, None);
        self.calls.push(Call::Operation(Operation { question, operator, operands, ray, way, asked, other }));
        (operands[0], way)
    }

    /// Asks an operand. It answers at once, or is put on the stack.
    #[inline(always)]
    fn ask(
        &mut self,
        held: &Held<'_>,
        hits: &mut Hits,
        (mut operand, mut way): (u32, u32),
        mut ray: Ray,
        question: Question,
    ) -> Option<Answer> {
        if held.is_bottomless(self.calls.len(), hits, way) {
            return Some(question.nowhere());
        }
        loop {
            let number = hits.block(way);
            let block = held.block(number);
            let ball = &block.supers[operand as usize];
            let Some(root) = ball.root else { return Some(question.nowhere()) };
            if let Some(at) = root.as_item() {
                let item = &block.items[at];
                let place = Place::new(way, at);
                match item.content {
                    Content::Shape(shape) => {
                        let ray = transform(&ray, &item.item_from_super);
                        self.work.primitives += 1;
                        let extents = shapes::extents(&block.shapes[shape as usize], &ray);
                        self.tied |= question.begins_at_face(&extents);
                        return Some(question.answer(&extents, place));
                    }
                    Content::Solid(solid) => {
                        ray = transform(&ray, &item.item_from_super);
                        (operand, way) = self.begin(held, hits, (solid, place), &ray, question);
                        continue;
                    }
                    Content::Super(_) | Content::Gate(_) => {}
                }
            }
            let Some(narrow) = Narrow::new(ray, ball, number, way, false) else {
                return Some(question.nowhere());
            };
            let (stack, level) = (self.stack.len(), self.levels.len());
            self.open(narrow, root);
            self.calls.push(match question.seek {
                Seek::Inside => {
                    Call::Entering(Entering { question, nearest: question.nowhere(), stack, level })
                }
                Seek::Outside => {
                    let (last, waiting) = (question.nowhere(), self.waiting.len());
                    Call::Leaving(Leaving { question, last, stack, waiting, level })
                }
            });
            return None;
        }
    }

    /// Opens the super-node that an item of a block leads to, if the ray, which is given in its frame, comes to it. If the
    /// item is a solid, that has to be asked.
    #[inline(always)]
    fn open_item(
        &mut self,
        held: &Held<'_>,
        hits: &mut Hits,
        (block, above): (&Compiled, u32),
        place: Place,
        ray: Ray,
    ) -> Option<u32> {
        let content = block.items[place.item as usize].content;
        match content {
            Content::Super(_) | Content::Gate(_) => {
                let kept = size_of_val(&*self.levels) + size_of_val(&*self.waiting);
                if !held.is_crowded(kept, hits, place.way)
                    && let Some((number, below)) = held.inside(above, content)
                    && let Some(root) = below.root
                    && let Some(narrow) =
                        Narrow::new(ray, below, number, hits.enter(place, block, number), false)
                {
                    self.open(narrow, root);
                }
                None
            }
            Content::Solid(solid) => Some(solid),
            Content::Shape(_) => unreachable!("a primitive has its extents"),
        }
    }

    /// Opens a super-node.
    fn open(&mut self, narrow: Narrow, root: Child) {
        let level = u32::try_from(self.levels.len()).expect("2³² levels outgrow memory");
        self.levels.push(narrow);
        self.stack.push(Open { near: f32::NEG_INFINITY, child: root, level });
    }
}

/// The spans of an item that there is nothing to ask about: a primitive, or the box of what is too small to be looked
/// into. What is cut out must not be larger than it is, so that a small one is nothing. The ray is given in the super-node
/// and in the frame of the item.
#[inline(always)]
fn extents(
    work: &mut Work,
    hits: &Hits,
    held: &Held<'_>,
    narrow: &Narrow,
    place: Place,
    item_ray: &Ray,
    is_cut: bool,
) -> Option<(Place, Extents)> {
    let block = held.block(narrow.block);
    let item = &block.items[place.item as usize];
    if let Content::Shape(shape) = item.content {
        work.primitives += 1;
        return Some((place, shapes::extents(&block.shapes[shape as usize], item_ray)));
    }
    let detail = hits.detail.as_ref().filter(|detail| detail.is_small(block, place, &narrow.ray))?;
    let extents =
        if is_cut { Extents::default() } else { detail.extents(held, narrow.block, place, &narrow.ray) };
    Some((place.as_box(), extents))
}
