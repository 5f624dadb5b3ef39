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
//! already. To get outside, all parts that the ray is in at t are left: t becomes the last exit, and so on until no part
//! holds the point at t. Boxes that begin behind t wait for t to get there; none is opened twice, and those that the ray
//! does not get to are never opened. Parts that are elsewhere cost nothing.
//!
//! Being inside *right behind* t decides coincident faces without a tolerance: a span holds its first t and not its last
//! one. Where one part ends and the next begins nothing is left, and where a hole begins at the face that it is cut
//! into, nothing is entered. Which face is seen there is for the search of [faces](super::face) to find.

use csg_graph::Operator;
use fearless_simd::Simd;

use super::Work;
use super::blocks::Held;
use super::compile::{Compiled, Content, Solid, SuperNode};
use super::frame::Narrow;
use super::hits::{Hits, Place};
use super::lanes::transform;
use super::single::{Open, met, nearest};
use super::tree::{Child, WIDTH};
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
    /// Whether what is asked is cut out of the result.
    is_cut: bool,
}

/// A child of a super-node of a block that a ray has come to on some way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<'a> {
    pub(super) ball: &'a SuperNode,
    pub(super) child: Child,
    pub(super) block: u32,
    pub(super) way: u32,
}

/// Where the ray comes to be there, and the face that it passes: unless there are several at this t, or none because it
/// has been there before.
#[derive(Clone, Copy, Debug)]
struct Answer {
    t: f64,
    /// Turned if the ray leaves its primitive there.
    face: Place,
}

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
    /// Children that have been looked at before: of the super-nodes at the levels from some one on.
    known: Vec<Child>,
    known_from: u32,
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

/// An operator that waits for an operand.
#[derive(Clone, Copy, Debug)]
struct Operation {
    question: Question,
    operator: Operator,
    operands: [u32; 2],
    ray: Ray,
    way: u32,
    /// Which operand was asked last.
    asked: usize,
    /// What the other operand has answered.
    other: Option<Answer>,
}

/// A union that is being searched for where a ray comes inside.
#[derive(Clone, Copy, Debug)]
struct Entering {
    question: Question,
    nearest: Answer,
    /// Where its parts of the stack and of the levels begin.
    stack: usize,
    level: usize,
}

/// A union that is being searched for where a ray gets outside.
#[derive(Clone, Copy, Debug)]
struct Leaving {
    question: Question,
    /// Up to where the parts reach that are known to follow each other.
    last: Answer,
    /// Where its parts of the stack, of what waits, and of the levels begin.
    stack: usize,
    waiting: usize,
    level: usize,
}

/// What a ray has not come to yet that gets outside of a union.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    from: f64,
    open: Open,
}

/// What follows an answer.
enum Next {
    Answer(Answer),
    /// A super-node.
    Ask(u32, Question),
}

impl Answer {
    const NEVER: Self = Self::at(f64::INFINITY);

    const fn at(t: f64) -> Self {
        Self { t, face: Place::NONE }
    }
}

impl Question {
    /// What a primitive answers.
    #[inline(always)]
    fn answer(&self, extents: &Extents, face: Place) -> Answer {
        let from = self.from;
        let face = Place { turned: self.seek == Seek::Outside, ..face };
        match self.seek {
            Seek::Inside => {
                let extent = extents.iter().find(|[enter, exit]| enter < exit && from < *exit);
                extent.map_or(Answer::NEVER, |[enter, _]| Answer { t: enter.max(from), face })
            }
            Seek::Outside => {
                let extent = extents.iter().find(|[enter, exit]| *enter <= from && from < *exit);
                extent.map_or(Answer::at(from), |[_, exit]| Answer { t: *exit, face })
            }
        }
    }

    /// Whether a primitive has a face just where it is asked.
    #[inline(always)]
    #[expect(clippy::float_cmp, reason = "faces that differ by an ulp do not coincide")]
    fn begins_at_face(&self, extents: &Extents) -> bool {
        extents.iter().any(|[enter, exit]| enter < exit && (*enter == self.from || *exit == self.from))
    }

    /// What an empty solid answers.
    fn nowhere(&self) -> Answer {
        match self.seek {
            Seek::Inside => Answer::NEVER,
            Seek::Outside => Answer::at(self.from),
        }
    }
}

impl Operation {
    /// Goes on with the answer of the operand that was asked last.
    #[inline(always)]
    fn resume(&mut self, answer: Answer) -> Next {
        let Question { seek, from, limit, .. } = self.question;
        match (seek, self.other) {
            (Seek::Inside, _) if answer.t > limit => Next::Answer(Answer::NEVER),
            // This one is inside where the other has come inside.
            (Seek::Inside, Some(other)) if answer.t <= other.t => Next::Answer(other),
            (Seek::Inside, _) => self.ask_other(answer, answer.t, limit),
            (Seek::Outside, Some(left)) => Next::Answer(if answer.t < left.t { answer } else { left }),
            (Seek::Outside, None) if answer.t <= from => Next::Answer(answer),
            (Seek::Outside, None) => self.ask_other(answer, from, answer.t.min(limit)),
        }
    }

    #[inline(always)]
    fn ask_other(&mut self, answer: Answer, from: f64, limit: f64) -> Next {
        self.other = Some(answer);
        self.asked = 1 - self.asked;
        let seek = match (self.question.seek, self.operator, self.asked) {
            (Seek::Inside, Operator::Difference, 1) => Seek::Outside,
            (Seek::Outside, Operator::Difference, 1) => Seek::Inside,
            (seek, ..) => seek,
        };
        let is_cut = self.question.is_cut != (self.operator == Operator::Difference && self.asked == 1);
        Next::Ask(self.operands[self.asked], Question { seek, from, limit, is_cut })
    }
}

impl Entering {
    /// Takes the answer of a part. Says whether it is at the same t as that of another one.
    #[inline(always)]
    #[expect(clippy::float_cmp, reason = "faces that differ by an ulp do not coincide")]
    fn take(&mut self, answer: Answer) -> bool {
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

/// The spans of an item that there is nothing to ask about: a primitive, or the box of what is too small to be looked
/// into. What is cut out must not be larger than it is, so that a small one is nothing. The ray is given in the super-node
/// and in the frame of the item.
#[inline(always)]
fn extents(
    work: &mut Work,
    hits: &Hits,
    block: &Compiled,
    place: Place,
    [super_ray, item_ray]: [&Ray; 2],
    is_cut: bool,
) -> Option<(Place, Extents)> {
    let item = &block.items[place.item as usize];
    if let Content::Shape(shape) = item.content {
        work.primitives += 1;
        return Some((place, shapes::extents(&block.shapes[shape as usize], item_ray)));
    }
    let detail = hits.detail.as_ref().filter(|detail| detail.is_small(block, place, super_ray))?;
    let extents = if is_cut { Extents::default() } else { detail.extents(block, place, super_ray) };
    Some((place.as_box(), extents))
}

impl Solids {
    /// The first boundary of a solid at t > 0 on a ray in its frame, not behind `end`, and the face there; or the place of
    /// the solid if there are several.
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
                let place = if self.tied { at.1 } else { Place { turned: face.turned != leaves, ..face } };
                (t <= end && t.is_finite()).then_some((t, place))
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

    /// How far a ray gets from t on within a part that is cut out, in pieces that each begin where another one has not
    /// ended; and by which face. It has come to t by a face that is known. Beyond a limit it does not matter.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "what is asked, and where")]
    pub(super) fn leave<S: Simd>(
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
    pub(super) fn leave_around(&mut self, part: Part<'_>, ray: &Ray, known: Child) {
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
    pub(super) fn leave_on<S: Simd>(
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

    #[inline(always)]
    fn clear(&mut self, come_by: Option<Place>) {
        self.calls.clear();
        self.levels.clear();
        self.stack.clear();
        self.waiting.clear();
        self.known.clear();
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
        loop {
            let number = hits.block(way);
            let block = held.block(number);
            let ball = &block.supers[operand as usize];
            let Some(root) = ball.root else { return Some(question.nowhere()) };
            if let Ok(at) = root.get() {
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
            let Some(narrow) = Narrow::new(ray, ball, number, way) else { return Some(question.nowhere()) };
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

    /// Opens a super-node, and says at which level.
    fn open(&mut self, narrow: Narrow, root: Child) -> u32 {
        let level = u32::try_from(self.levels.len()).expect("2³² levels outgrow memory");
        self.levels.push(narrow);
        self.stack.push(Open { near: f32::NEG_INFINITY, child: root, level });
        level
    }

    /// Searches a union, nearest boxes first, until it has an answer, or until a part has to be asked that is on the stack
    /// then.
    #[inline(always)]
    fn come_in<S: Simd>(
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
            let at = match open.child.get() {
                Err(node) => {
                    let node = &block.nodes[node];
                    self.work.boxes += u64::from(node.count);
                    let (near, met) = met(simd, node, &narrow.line, start, end);
                    let next = nearest(&mut self.stack, node, near, met, level);
                    self.stack.extend(next);
                    continue;
                }
                Ok(at) => at,
            };
            let item = &block.items[at];
            let place = Place::new(narrow.way, at);
            let ray = transform(&narrow.ray, &item.item_from_super);
            let question = Question { limit: union.question.limit.min(known), ..union.question };
            if let Some((place, extents)) =
                extents(&mut self.work, hits, block, place, [&narrow.ray, &ray], question.is_cut)
            {
                self.tied |= question.begins_at_face(&extents);
                self.tied |= union.take(question.answer(&extents, place));
                continue;
            }
            match item.content {
                Content::Super(_) | Content::Gate(_) => {
                    if let Some((number, below)) = held.inside(narrow.block, item.content)
                        && let Some(root) = below.root
                        && let Some(narrow) =
                            Narrow::new(ray, below, number, hits.enter(place, block, number))
                    {
                        self.open(narrow, root);
                    }
                }
                Content::Shape(_) => unreachable!("a primitive has its extents"),
                Content::Solid(solid) => {
                    self.calls.push(Call::Entering(union));
                    let (left, way) = self.begin(held, hits, (solid, place), &ray, question);
                    return self.ask(held, hits, (left, way), ray, question);
                }
            }
        }
        self.stack.truncate(union.stack);
        self.levels.truncate(union.level);
        Some(union.nearest)
    }

    /// Searches a union for parts that reach further, each box when the ray has come to it, until no part does, or until a
    /// part has to be asked that is on the stack then.
    #[inline(always)]
    fn get_out<S: Simd>(
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
            let block = held.block(narrow.block);
            let at = match open.child.get() {
                Err(node) => {
                    let node = &block.nodes[node];
                    self.work.boxes += u64::from(node.count);
                    let (near, mut met) = met(simd, node, &narrow.line, narrow.start(t), narrow.end(limit));
                    let here = narrow.end(t);
                    let known = self.known.get(open.level.wrapping_sub(self.known_from) as usize);
                    while met != 0 {
                        let slot = met.trailing_zeros() as usize % WIDTH;
                        met &= met - 1;
                        let open = Open { child: node.children[slot], ..open };
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
                    if let Some((number, below)) = held.inside(narrow.block, item.content)
                        && let Some(root) = below.root
                        && let Some(narrow) =
                            Narrow::new(ray, below, number, hits.enter(place, block, number))
                    {
                        self.open(narrow, root);
                    }
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
}
