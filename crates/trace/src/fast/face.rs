//! Which face of which primitive is seen at a boundary of a solid, once it is known where that is.
//!
//! At one t there may be several: where faces coincide, where a hole ends in a face, where parts of a union are cut off by
//! one plane. The [search](super::solid) does not ask, as most boundaries that it comes to are not seen in the end. Here
//! all operands say whether the ray is inside just before t and just behind it, and the rule is that of the
//! [reference walk](crate::Walk), by identity and not by closeness: an operator shows the face of its left operand, if
//! that one changes at exactly this t in the way in which the result does, and else that of the right one; a union shows
//! the leftmost.

use csg_graph::Operator;
use fearless_simd::Simd;

use super::compile::{Compiled, Content, Solid};
use super::frame::Narrow;
use super::hits::{Hits, Place};
use super::lanes::transform;
use super::single::{Open, met, push};
use crate::Ray;
use crate::boolean::inside;
use crate::shapes::{self, Spans};

/// A face of a primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub(super) place: Place,
    /// Whether the solid is on the outer side of the face: it is the face of something subtracted.
    pub(super) turned: bool,
}

/// What a ray does at t.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// Whether it is inside just before.
    before: bool,
    /// And just behind.
    behind: bool,
    /// The face between, and whether the ray enters its primitive there.
    face: Option<(Place, bool)>,
}

/// The memory of the search.
#[derive(Debug, Default)]
pub(super) struct Faces {
    calls: Vec<Call>,
    levels: Vec<Narrow>,
    stack: Vec<Open>,
    items: Vec<u32>,
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
    operator: Operator,
    right: u32,
    ray: Ray,
    way: u32,
    /// What the left operand has answered.
    left: Option<Crossing>,
}

/// A union whose tree is being searched.
#[derive(Clone, Copy, Debug)]
struct Union {
    before: bool,
    behind: bool,
    /// The leftmost faces of parts that are left, and of those that are entered.
    faces: [Option<(Place, bool)>; 2],
    /// Where its part of the stack begins.
    stack: usize,
    level: u32,
}

impl Crossing {
    const OUTSIDE: Self = Self { before: false, behind: false, face: None };

    #[inline(always)]
    fn new(spans: &Spans, t: f64, place: Place) -> Self {
        let before = spans.iter().any(|span| span.enter.t < t && t <= span.exit.t);
        let behind = spans.iter().any(|span| span.enter.t <= t && t < span.exit.t);
        Self { before, behind, face: (before != behind).then_some((place, behind)) }
    }

    fn combine(operator: Operator, left: Self, right: Self) -> Self {
        let before = inside(operator, left.before, right.before);
        let behind = inside(operator, left.behind, right.behind);
        let fits = left.before != left.behind && left.behind == behind;
        let face = if fits { left.face } else { right.face };
        Self { before, behind, face: face.filter(|_| before != behind) }
    }
}

impl Union {
    fn take(&mut self, part: Crossing, hits: &Hits) {
        self.before |= part.before;
        self.behind |= part.behind;
        if let Some((place, _)) = part.face {
            let leftmost = &mut self.faces[usize::from(part.behind)];
            if leftmost.is_none_or(|(other, _)| hits.is_left(place, Some(other))) {
                *leftmost = part.face;
            }
        }
    }

    fn answer(&self) -> Crossing {
        let Self { before, behind, faces, .. } = *self;
        Crossing { before, behind, face: faces[usize::from(behind)].filter(|_| before != behind) }
    }
}

impl Faces {
    /// The face at t on a ray of the world, which has a boundary there of the solid at that place.
    #[inline(never)]
    pub(super) fn find<S: Simd>(
        &mut self,
        simd: S,
        compiled: &Compiled,
        hits: &mut Hits,
        place: Place,
        world_ray: &Ray,
        t: f64,
    ) -> Option<Face> {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut ray = *world_ray;
                hits.items(place, &mut self.items);
                for item in &self.items {
                    ray = transform(&ray, &compiled.items[*item as usize].item_from_super);
                }
                let Content::Solid(solid) = compiled.items[place.item as usize].content else { return None };
                let crossing = self.run(simd, compiled, hits, place, solid, &ray, t);
                crossing.face.map(|(place, enters)| Face { place, turned: enters != crossing.behind })
            },
        )
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "where a solid is, and where on it")]
    fn run<S: Simd>(
        &mut self,
        simd: S,
        compiled: &Compiled,
        hits: &mut Hits,
        place: Place,
        solid: u32,
        ray: &Ray,
        t: f64,
    ) -> Crossing {
        self.calls.clear();
        self.levels.clear();
        self.stack.clear();
        let (left, way) = self.begin(compiled, hits, place, solid, ray);
        let mut answer = self.ask(compiled, hits, left, *ray, way, t);
        loop {
            answer = match (self.calls.pop(), answer) {
                (None, Some(crossing)) => return crossing,
                (Some(Call::Operation(operation)), Some(crossing)) => match operation.left {
                    Some(left) => Some(Crossing::combine(operation.operator, left, crossing)),
                    None => {
                        let Operation { right, ray, way, .. } = operation;
                        self.calls.push(Call::Operation(Operation { left: Some(crossing), ..operation }));
                        self.ask(compiled, hits, right, ray, way, t)
                    }
                },
                (Some(Call::Union(mut union)), answer) => {
                    if let Some(part) = answer {
                        union.take(part, hits);
                    }
                    self.search(simd, compiled, hits, union, t)
                }
                (_, None) => unreachable!("only unions wait before they have asked"),
            }
        }
    }

    /// Puts an operator on the stack, which waits for its left operand, and says what that is and the way to it.
    #[inline(always)]
    fn begin(
        &mut self,
        compiled: &Compiled,
        hits: &mut Hits,
        place: Place,
        solid: u32,
        ray: &Ray,
    ) -> (u32, u32) {
        let Solid { operator, operands: [left, right] } = compiled.solids[solid as usize];
        let way = hits.enter(place.way, place.item);
        self.calls.push(Call::Operation(Operation { operator, right, ray: *ray, way, left: None }));
        (left, way)
    }

    /// Asks an operand. It answers at once, or is put on the stack.
    #[inline(always)]
    fn ask(
        &mut self,
        compiled: &Compiled,
        hits: &mut Hits,
        mut operand: u32,
        mut ray: Ray,
        mut way: u32,
        t: f64,
    ) -> Option<Crossing> {
        loop {
            let ball = &compiled.supers[operand as usize];
            let Some(root) = ball.root else { return Some(Crossing::OUTSIDE) };
            if let Ok(at) = root.get() {
                let item = &compiled.items[at];
                let place = place(way, at);
                match item.content {
                    Content::Shape(shape) => {
                        let ray = transform(&ray, &item.item_from_super);
                        let spans = shapes::spans(&compiled.shapes[shape as usize], &ray);
                        return Some(Crossing::new(&spans, t, place));
                    }
                    Content::Solid(solid) => {
                        ray = transform(&ray, &item.item_from_super);
                        (operand, way) = self.begin(compiled, hits, place, solid, &ray);
                        continue;
                    }
                    Content::Super(_) => {}
                }
            }
            let Some(narrow) = Narrow::new(ray, ball, way) else { return Some(Crossing::OUTSIDE) };
            let level = u32::try_from(self.levels.len()).expect("2³² levels outgrow memory");
            let stack = self.stack.len();
            self.levels.push(narrow);
            self.stack.push(Open { near: f32::NEG_INFINITY, child: root, level });
            let union = Union { before: false, behind: false, faces: [None; 2], stack, level };
            self.calls.push(Call::Union(union));
            return None;
        }
    }

    /// Searches the tree of a union for parts around t, until it has an answer or a part has to be asked that is on the
    /// stack then.
    #[inline(always)]
    fn search<S: Simd>(
        &mut self,
        simd: S,
        compiled: &Compiled,
        hits: &mut Hits,
        mut union: Union,
        t: f64,
    ) -> Option<Crossing> {
        while self.stack.len() > union.stack {
            let Some(open) = self.stack.pop() else { break };
            let level = open.level;
            self.levels.truncate(level as usize + 1);
            let narrow = &self.levels[level as usize];
            let at = match open.child.get() {
                Err(node) => {
                    let node = &compiled.nodes[node];
                    let (near, met) = met(simd, node, narrow, narrow.start(t), narrow.end(t));
                    push(&mut self.stack, node, near, met, level);
                    continue;
                }
                Ok(at) => at,
            };
            let item = &compiled.items[at];
            let place = place(narrow.way, at);
            let ray = transform(&narrow.ray, &item.item_from_super);
            match item.content {
                Content::Super(number) => {
                    let below = &compiled.supers[number as usize];
                    if let Some(root) = below.root
                        && let Some(narrow) = Narrow::new(ray, below, hits.enter(place.way, place.item))
                    {
                        self.levels.push(narrow);
                        self.stack.push(Open { near: f32::NEG_INFINITY, child: root, level: level + 1 });
                    }
                }
                Content::Shape(shape) => {
                    let spans = shapes::spans(&compiled.shapes[shape as usize], &ray);
                    union.take(Crossing::new(&spans, t, place), hits);
                }
                Content::Solid(solid) => {
                    self.calls.push(Call::Union(union));
                    let (left, way) = self.begin(compiled, hits, place, solid, &ray);
                    return self.ask(compiled, hits, left, ray, way, t);
                }
            }
        }
        self.levels.truncate(union.level as usize);
        Some(union.answer())
    }
}

fn place(way: u32, at: usize) -> Place {
    Place { way, item: u32::try_from(at).expect("items are numbered in 31 bits") }
}
