//! The first boundary of the results of ∩ and \\: from event to event, and no further than to the first.
//!
//! Span evaluation, as the [reference walk](crate::Walk) does it, finds all boundaries of all operands and merges them.
//! Most of them are never seen. Here an operand answers two questions only, each the other one's complement:
//!
//! - [`Seek::Inside`]: the first t, from some t on, right behind which the ray is inside;
//! - [`Seek::Outside`]: the first t right behind which it is outside.
//!
//! An operator asks its operands in the same terms, \[ROTH82\]'s combination of spans with nothing evaluated ahead. To be
//! inside of A ∩ B is to be inside of both: A is asked, then B from there on, then A again, until they agree on one t. To
//! be outside is to leave either. A \\ B is A ∩ ¬B, where to be inside of ¬B is to be outside of B. So the right operand of
//! \\ is asked only where the left one is, and both operands of ∩ only where the other one is.
//!
//! A union is a tree of parts. To come inside is to meet the nearest, as ever, and at once if some part is entered
//! already. To get outside, all parts that the ray is in at t are left, whose boxes hold the point at t; t becomes the
//! last exit, and this is repeated from there until no part holds the point. Parts that are elsewhere cost nothing.
//!
//! Being inside *right behind* t decides coincident faces without a tolerance: a span holds its first t and not its last
//! one. Where one part ends and the next begins nothing is left, and where a hole begins at the face that it is cut
//! into, nothing is entered. Which face is seen there is for the search of [faces](super::face) to find.

use csg_graph::Operator;
use fearless_simd::Simd;

use super::Work;
use super::compile::{Compiled, Content, Solid};
use super::frame::Narrow;
use super::hits::START;
use super::lanes::transform;
use super::single::{Open, met, push};
use super::tree::Child;
use crate::Ray;
use crate::shapes::{self, Spans};

/// What is asked: where the ray comes to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seek {
    Inside,
    Outside,
}

/// A question about an operand. An answer beyond the limit says only that it is beyond.
#[derive(Clone, Copy, Debug)]
struct Question {
    seek: Seek,
    from: f64,
    limit: f64,
}

/// The memory of rays through solids.
#[derive(Debug, Default)]
pub(super) struct Solids {
    calls: Vec<Call>,
    /// The rays in the super-nodes that they are in.
    levels: Vec<Narrow>,
    stack: Vec<Open>,
    pub(super) work: Work,
}

/// An operand that has not answered yet.
#[derive(Clone, Copy, Debug)]
enum Call {
    Operation(Operation),
    Union(Union),
}

/// An operator that waits for an operand.
#[derive(Clone, Copy, Debug)]
struct Operation {
    question: Question,
    operator: Operator,
    operands: [u32; 2],
    ray: Ray,
    /// Which operand was asked last.
    asked: usize,
    /// What the other operand has answered.
    other: f64,
}

/// A union whose tree is being searched.
#[derive(Clone, Copy, Debug)]
struct Union {
    question: Question,
    /// The nearest t inside so far; or, if outside is sought, up to where the parts reach that are known.
    t: f64,
    /// Where this pass through the tree has begun.
    pass: f64,
    /// Where its part of the stack begins.
    stack: usize,
    root: Child,
    /// The level of the root.
    level: u32,
}

/// What follows an answer.
enum Next {
    Answer(f64),
    /// A super-node.
    Ask(u32, Question),
}

impl Question {
    /// What spans answer.
    #[inline(always)]
    fn answer(&self, spans: &Spans) -> f64 {
        match self.seek {
            Seek::Inside => {
                let span = spans.iter().find(|span| span.exit.t > self.from);
                span.map_or(f64::INFINITY, |span| span.enter.t.max(self.from))
            }
            Seek::Outside => {
                let span = spans.iter().find(|span| span.enter.t <= self.from && self.from < span.exit.t);
                span.map_or(self.from, |span| span.exit.t)
            }
        }
    }

    /// What an empty solid answers.
    fn nowhere(&self) -> f64 {
        match self.seek {
            Seek::Inside => f64::INFINITY,
            Seek::Outside => self.from,
        }
    }
}

impl Operation {
    /// Goes on with the answer of the operand that was asked last.
    #[inline(always)]
    fn resume(&mut self, t: f64) -> Next {
        let Question { seek, from, limit } = self.question;
        match seek {
            Seek::Inside if t > limit => Next::Answer(f64::INFINITY),
            // The other one is satisfied there, too.
            Seek::Inside if t <= self.other => Next::Answer(t),
            Seek::Inside => self.ask_other(t, t, limit),
            Seek::Outside if self.asked == 1 => Next::Answer(t.min(self.other)),
            Seek::Outside if t <= from => Next::Answer(t),
            Seek::Outside => self.ask_other(t, from, t.min(limit)),
        }
    }

    #[inline(always)]
    fn ask_other(&mut self, answer: f64, from: f64, limit: f64) -> Next {
        self.other = answer;
        self.asked = 1 - self.asked;
        let seek = match (self.question.seek, self.operator, self.asked) {
            (Seek::Inside, Operator::Difference, 1) => Seek::Outside,
            (Seek::Outside, Operator::Difference, 1) => Seek::Inside,
            (seek, ..) => seek,
        };
        Next::Ask(self.operands[self.asked], Question { seek, from, limit })
    }
}

impl Union {
    /// Takes the answer of a part.
    #[inline(always)]
    fn take(&mut self, t: f64) {
        self.t = match self.question.seek {
            Seek::Inside => self.t.min(t),
            Seek::Outside => self.t.max(t),
        };
    }

    /// What is asked of the next part.
    #[inline(always)]
    fn question(&self) -> Question {
        let Question { seek, from, limit } = self.question;
        match seek {
            Seek::Inside => Question { seek, from, limit: limit.min(self.t) },
            Seek::Outside => Question { seek, from: self.t, limit },
        }
    }

    /// The s between which a box matters.
    #[inline(always)]
    fn range(&self, narrow: &Narrow) -> [f32; 2] {
        match self.question.seek {
            Seek::Inside => [narrow.start(self.question.from), narrow.end(self.t.min(self.question.limit))],
            Seek::Outside => [narrow.start(self.t), narrow.end(self.t)],
        }
    }
}

impl Solids {
    /// The first boundary of a solid at t > 0 on a ray in its frame, not behind `end`.
    #[inline(never)]
    pub(super) fn first<S: Simd>(
        &mut self,
        simd: S,
        compiled: &Compiled,
        solid: u32,
        ray: &Ray,
        end: f64,
    ) -> Option<f64> {
        simd.vectorize(
            #[inline(always)]
            || {
                let inside = Question { seek: Seek::Inside, from: 0.0, limit: end };
                let mut t = self.run(simd, compiled, solid, ray, inside);
                if t <= 0.0 {
                    t = self.run(simd, compiled, solid, ray, Question { seek: Seek::Outside, ..inside });
                }
                (t <= end && t.is_finite()).then_some(t)
            },
        )
    }

    /// Asks a solid, with what it asks in turn.
    #[inline(always)]
    fn run<S: Simd>(
        &mut self,
        simd: S,
        compiled: &Compiled,
        solid: u32,
        ray: &Ray,
        question: Question,
    ) -> f64 {
        self.calls.clear();
        self.levels.clear();
        self.stack.clear();
        let left = self.begin(compiled, solid, ray, question);
        let mut answer = self.ask(compiled, left, *ray, question);
        loop {
            answer = match (self.calls.last_mut(), answer) {
                (None, Some(t)) => return t,
                (Some(Call::Operation(operation)), Some(t)) => match operation.resume(t) {
                    Next::Answer(t) => {
                        self.calls.pop();
                        Some(t)
                    }
                    Next::Ask(operand, question) => {
                        let ray = operation.ray;
                        self.ask(compiled, operand, ray, question)
                    }
                },
                (Some(Call::Union(union)), answer) => {
                    let mut union = *union;
                    self.calls.pop();
                    if let Some(t) = answer {
                        union.take(t);
                    }
                    self.search(simd, compiled, union)
                }
                (_, None) => unreachable!("only unions wait before they have asked"),
            }
        }
    }

    /// Puts an operator on the stack, which waits for its left operand, and says what that is. It is asked the same.
    #[inline(always)]
    fn begin(&mut self, compiled: &Compiled, solid: u32, ray: &Ray, question: Question) -> u32 {
        let Solid { operator, operands } = compiled.solids[solid as usize];
        let operation = Operation { question, operator, operands, ray: *ray, asked: 0, other: f64::NAN };
        self.calls.push(Call::Operation(operation));
        operands[0]
    }

    /// Asks an operand. It answers at once, or is put on the stack.
    #[inline(always)]
    fn ask(
        &mut self,
        compiled: &Compiled,
        mut operand: u32,
        mut ray: Ray,
        question: Question,
    ) -> Option<f64> {
        loop {
            let ball = &compiled.supers[operand as usize];
            let Some(root) = ball.root else { return Some(question.nowhere()) };
            if let Ok(at) = root.get() {
                let item = &compiled.items[at];
                match item.content {
                    Content::Shape(shape) => {
                        let ray = transform(&ray, &item.item_from_super);
                        self.work.primitives += 1;
                        return Some(question.answer(&shapes::spans(&compiled.shapes[shape as usize], &ray)));
                    }
                    Content::Solid(solid) => {
                        ray = transform(&ray, &item.item_from_super);
                        operand = self.begin(compiled, solid, &ray, question);
                        continue;
                    }
                    Content::Super(_) => {}
                }
            }
            let Some(narrow) = Narrow::new(ray, ball, START) else { return Some(question.nowhere()) };
            let level = u32::try_from(self.levels.len()).expect("2³² levels outgrow memory");
            let t = question.nowhere();
            let union = Union { question, t, pass: t, stack: self.stack.len(), root, level };
            self.levels.push(narrow);
            self.stack.push(Open { near: f32::NEG_INFINITY, child: root, level });
            self.calls.push(Call::Union(union));
            return None;
        }
    }

    /// Searches the tree of a union until it has an answer, or until a part has to be asked that is on the stack then.
    #[inline(always)]
    fn search<S: Simd>(&mut self, simd: S, compiled: &Compiled, mut union: Union) -> Option<f64> {
        let Question { seek, from, limit } = union.question;
        let mut level = u32::MAX;
        let mut changed = true;
        let [mut start, mut end] = [0.0; 2];
        loop {
            let is_certain = match seek {
                Seek::Inside => union.t <= from,
                Seek::Outside => union.t > limit || union.t.is_infinite(),
            };
            if is_certain {
                self.stack.truncate(union.stack);
                break;
            }
            if self.stack.len() == union.stack {
                // Parts that were passed by may hold the point where the others have ended.
                if seek == Seek::Inside || union.t <= union.pass {
                    break;
                }
                union.pass = union.t;
                self.stack.push(Open { near: f32::NEG_INFINITY, child: union.root, level: union.level });
            }
            let open = self.stack.pop().expect("what is above the union's part of the stack");
            if open.level != level || changed {
                (level, changed) = (open.level, false);
                self.levels.truncate(level as usize + 1);
                [start, end] = union.range(&self.levels[level as usize]);
            }
            if seek == Seek::Inside && open.near > end {
                continue;
            }
            let narrow = &self.levels[level as usize];
            let at = match open.child.get() {
                Err(node) => {
                    let node = &compiled.nodes[node];
                    self.work.boxes += u64::from(node.count);
                    let (near, met) = met(simd, node, narrow, start, end);
                    push(&mut self.stack, node, near, met, level);
                    continue;
                }
                Ok(at) => at,
            };
            let item = &compiled.items[at];
            let ray = transform(&narrow.ray, &item.item_from_super);
            let before = union.t;
            match item.content {
                Content::Super(number) => {
                    let below = &compiled.supers[number as usize];
                    if let Some(root) = below.root
                        && let Some(narrow) = Narrow::new(ray, below, START)
                    {
                        self.levels.push(narrow);
                        self.stack.push(Open { near: f32::NEG_INFINITY, child: root, level: level + 1 });
                    }
                    continue;
                }
                Content::Shape(shape) => {
                    self.work.primitives += 1;
                    let spans = shapes::spans(&compiled.shapes[shape as usize], &ray);
                    union.take(union.question().answer(&spans));
                }
                Content::Solid(solid) => {
                    let question = union.question();
                    self.calls.push(Call::Union(union));
                    let left = self.begin(compiled, solid, &ray, question);
                    // The answer of the left operand is none of this union's.
                    return self.ask(compiled, left, ray, question);
                }
            }
            changed = before.to_bits() != union.t.to_bits();
        }
        self.levels.truncate(union.level as usize);
        Some(union.t)
    }
}
