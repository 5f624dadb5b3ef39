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
use super::point::{Mark, Points};
use super::single::{Open, met, push};
use super::tree::Child;
use crate::Ray;
use crate::shapes::{self, Extents};

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
    points: Points,
    pub(super) work: Work,
}

/// An operand that has not answered yet.
#[derive(Clone, Copy, Debug)]
enum Call {
    Operation(Operation),
    Entering(Entering),
    Leaving(Leaving),
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

/// A union that is being searched for where a ray comes inside.
#[derive(Clone, Copy, Debug)]
struct Entering {
    question: Question,
    /// The nearest so far.
    t: f64,
    /// Where its parts of the stack and of the levels begin.
    stack: usize,
    level: usize,
}

/// A union that is being searched for where a ray gets outside.
#[derive(Clone, Copy, Debug)]
struct Leaving {
    question: Question,
    /// Up to where the parts reach that are known to follow each other.
    t: f64,
    /// Where this pass through the tree has begun.
    pass: f64,
    operand: u32,
    ray: Ray,
    mark: Mark,
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
    fn answer(&self, extents: &Extents) -> f64 {
        let from = self.from;
        match self.seek {
            Seek::Inside => {
                let extent = extents.iter().find(|[enter, exit]| enter < exit && from < *exit);
                extent.map_or(f64::INFINITY, |[enter, _]| enter.max(from))
            }
            Seek::Outside => {
                let extent = extents.iter().find(|[enter, exit]| *enter <= from && from < *exit);
                extent.map_or(from, |[_, exit]| *exit)
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

impl Entering {
    /// The s between which a box matters.
    #[inline(always)]
    fn range(&self, narrow: &Narrow) -> [f32; 2] {
        [narrow.start(self.question.from), narrow.end(self.t.min(self.question.limit))]
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
        self.points.clear();
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
                (Some(Call::Entering(union)), answer) => {
                    let mut union = *union;
                    self.calls.pop();
                    union.t = answer.map_or(union.t, |t| union.t.min(t));
                    self.come_in(simd, compiled, union)
                }
                (Some(Call::Leaving(union)), answer) => {
                    let mut union = *union;
                    self.calls.pop();
                    union.t = answer.map_or(union.t, |t| union.t.max(t));
                    self.get_out(simd, compiled, union)
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
                        return Some(
                            question.answer(&shapes::extents(&compiled.shapes[shape as usize], &ray)),
                        );
                    }
                    Content::Solid(solid) => {
                        ray = transform(&ray, &item.item_from_super);
                        operand = self.begin(compiled, solid, &ray, question);
                        continue;
                    }
                    Content::Super(_) => {}
                }
            }
            match question.seek {
                Seek::Inside => {
                    let Some(narrow) = Narrow::new(ray, ball, START) else { return Some(f64::INFINITY) };
                    let (stack, level) = (self.stack.len(), self.levels.len());
                    self.open(narrow, root);
                    self.calls.push(Call::Entering(Entering { question, t: f64::INFINITY, stack, level }));
                }
                Seek::Outside => {
                    let (t, mark) = (question.from, self.points.mark());
                    self.points.enter(compiled, operand, ray, START);
                    self.calls.push(Call::Leaving(Leaving { question, t, pass: t, operand, ray, mark }));
                }
            }
            return None;
        }
    }

    fn open(&mut self, narrow: Narrow, root: Child) {
        let level = u32::try_from(self.levels.len()).expect("2³² levels outgrow memory");
        self.levels.push(narrow);
        self.stack.push(Open { near: f32::NEG_INFINITY, child: root, level });
    }

    /// Searches a union, nearest boxes first, until it has an answer, or until a part has to be asked that is on the stack
    /// then.
    #[inline(always)]
    fn come_in<S: Simd>(&mut self, simd: S, compiled: &Compiled, mut union: Entering) -> Option<f64> {
        let from = union.question.from;
        let mut level = u32::MAX;
        let mut known = union.t;
        let [mut start, mut end] = [0.0; 2];
        // Nothing is nearer than where the ray is already.
        while union.t > from && self.stack.len() > union.stack {
            let Some(open) = self.stack.pop() else { break };
            if open.level != level || union.t < known {
                (level, known) = (open.level, union.t);
                self.levels.truncate(level as usize + 1);
                [start, end] = union.range(&self.levels[level as usize]);
            }
            if open.near > end {
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
            let question = Question { limit: union.question.limit.min(union.t), ..union.question };
            match item.content {
                Content::Super(number) => {
                    let below = &compiled.supers[number as usize];
                    if let Some(root) = below.root
                        && let Some(narrow) = Narrow::new(ray, below, START)
                    {
                        self.open(narrow, root);
                    }
                }
                Content::Shape(shape) => {
                    self.work.primitives += 1;
                    let extents = shapes::extents(&compiled.shapes[shape as usize], &ray);
                    union.t = union.t.min(question.answer(&extents));
                }
                Content::Solid(solid) => {
                    self.calls.push(Call::Entering(union));
                    let left = self.begin(compiled, solid, &ray, question);
                    return self.ask(compiled, left, ray, question);
                }
            }
        }
        self.stack.truncate(union.stack);
        self.levels.truncate(union.level);
        Some(union.t)
    }

    /// Searches a union for parts that reach further, until no part does, or until a part has to be asked that is on the
    /// stack then.
    #[inline(always)]
    fn get_out<S: Simd>(&mut self, simd: S, compiled: &Compiled, mut union: Leaving) -> Option<f64> {
        let limit = union.question.limit;
        while union.t <= limit && union.t.is_finite() {
            let boxes = &mut self.work.boxes;
            let Some(part) = self.points.next(simd, compiled, union.mark, union.t, boxes, |_, _| START)
            else {
                if union.t <= union.pass {
                    break;
                }
                // Parts that were passed by may hold the point where the others have ended.
                union.pass = union.t;
                self.points.enter(compiled, union.operand, union.ray, START);
                continue;
            };
            let question = Question { seek: Seek::Outside, from: union.t, limit };
            match compiled.items[part.at].content {
                Content::Shape(shape) => {
                    self.work.primitives += 1;
                    let extents = shapes::extents(&compiled.shapes[shape as usize], &part.ray);
                    union.t = question.answer(&extents);
                }
                Content::Solid(solid) => {
                    self.calls.push(Call::Leaving(union));
                    let left = self.begin(compiled, solid, &part.ray, question);
                    return self.ask(compiled, left, part.ray, question);
                }
                Content::Super(_) => unreachable!("super-nodes are entered"),
            }
        }
        self.points.rewind(union.mark);
        Some(union.t)
    }
}
