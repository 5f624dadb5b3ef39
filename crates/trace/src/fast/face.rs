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

use super::compiled::{Content, Solid};
use super::held::Held;
use super::hits::{Hits, Place};
use super::lanes::transform;
use super::point::{Holder, Mark, Points};
use crate::Ray;
use crate::boolean::inside;
use crate::shapes::{self, Extents};

/// What a ray does at t.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// Whether it is inside just before.
    before: bool,
    /// And just behind.
    behind: bool,
    /// The face between, turned if the ray leaves its primitive there.
    face: Option<Place>,
}

/// The memory of the search.
#[derive(Debug, Default)]
pub(super) struct Faces {
    calls: Vec<Call>,
    points: Points,
    items: Vec<(u32, u32)>,
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

/// A union whose parts are being asked.
#[derive(Clone, Copy, Debug)]
struct Union {
    before: bool,
    behind: bool,
    /// The leftmost faces of parts that are left, and of those that are entered.
    faces: [Option<Place>; 2],
    mark: Mark,
}

impl Crossing {
    const OUTSIDE: Self = Self { before: false, behind: false, face: None };

    #[inline(always)]
    fn new(extents: &Extents, t: f64, place: Place) -> Self {
        let before = extents.iter().any(|[enter, exit]| *enter < t && t <= *exit);
        let behind = extents.iter().any(|[enter, exit]| *enter <= t && t < *exit);
        Self { before, behind, face: (before != behind).then_some(Place { turned: before, ..place }) }
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
        if let Some(place) = part.face {
            let leftmost = &mut self.faces[usize::from(part.behind)];
            if leftmost.is_none_or(|other| hits.is_left(place, Some(other))) {
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
        held: &Held<'_>,
        hits: &mut Hits,
        place: Place,
        world_ray: &Ray,
        t: f64,
    ) -> Option<Place> {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut ray = *world_ray;
                hits.items(place, &mut self.items);
                for (block, item) in &self.items {
                    ray = transform(&ray, &held.item(*block, *item).item_from_super);
                }
                let item = held.item(hits.block(place.way), place.item);
                let Content::Solid(solid) = item.content else { return None };
                let crossing = self.run(simd, held, hits, place, solid, &ray, t);
                crossing.face.map(|face| Place { turned: face.turned != crossing.before, ..face })
            },
        )
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "where a solid is, and where on it")]
    fn run<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        place: Place,
        solid: u32,
        ray: &Ray,
        t: f64,
    ) -> Crossing {
        self.calls.clear();
        self.points.clear();
        let (left, way) = self.begin(held, hits, place, solid, ray);
        let mut answer = self.ask(held, hits, left, *ray, way, t);
        loop {
            answer = match (self.calls.pop(), answer) {
                (None, Some(crossing)) => return crossing,
                (Some(Call::Operation(operation)), Some(crossing)) => match operation.left {
                    Some(left) => Some(Crossing::combine(operation.operator, left, crossing)),
                    None => {
                        let Operation { right, ray, way, .. } = operation;
                        self.calls.push(Call::Operation(Operation { left: Some(crossing), ..operation }));
                        self.ask(held, hits, right, ray, way, t)
                    }
                },
                (Some(Call::Union(mut union)), answer) => {
                    if let Some(part) = answer {
                        union.take(part, hits);
                    }
                    self.search(simd, held, hits, union, t)
                }
                (_, None) => unreachable!("only unions wait before they have asked"),
            }
        }
    }

    /// Puts an operator on the stack, which waits for its left operand, and says what that is and the way to it.
    #[inline(always)]
    fn begin(&mut self, held: &Held<'_>, hits: &mut Hits, place: Place, solid: u32, ray: &Ray) -> (u32, u32) {
        let block = hits.block(place.way);
        let from = held.block(block);
        let Solid { operator, operands: [left, right] } = from.solids[solid as usize];
        let way = hits.enter(place, from, block);
        self.calls.push(Call::Operation(Operation { operator, right, ray: *ray, way, left: None }));
        (left, way)
    }

    /// Asks an operand. It answers at once, or is put on the stack.
    #[inline(always)]
    fn ask(
        &mut self,
        held: &Held<'_>,
        hits: &mut Hits,
        mut operand: u32,
        mut ray: Ray,
        mut way: u32,
        t: f64,
    ) -> Option<Crossing> {
        if held.is_bottomless(self.calls.len(), hits, way) {
            return Some(Crossing::OUTSIDE);
        }
        loop {
            let number = hits.block(way);
            let block = held.block(number);
            let ball = &block.supers[operand as usize];
            let Some(root) = ball.root else { return Some(Crossing::OUTSIDE) };
            if let Some(at) = root.as_item() {
                let place = Place::new(way, at);
                let item = &block.items[at];
                match item.content {
                    Content::Shape(shape) => {
                        let ray = transform(&ray, &item.item_from_super);
                        let extents = shapes::extents(&block.shapes[shape as usize], &ray);
                        return Some(Crossing::new(&extents, t, place));
                    }
                    Content::Solid(solid) => {
                        ray = transform(&ray, &item.item_from_super);
                        (operand, way) = self.begin(held, hits, place, solid, &ray);
                        continue;
                    }
                    Content::Super(_) | Content::Gate(_) => {}
                }
            }
            let mark = self.points.mark();
            self.points.enter(ball, number, ray, way);
            let union = Union { before: false, behind: false, faces: [None; 2], mark };
            self.calls.push(Call::Union(union));
            return None;
        }
    }

    /// Whether what is asked is cut out of the result.
    fn is_cut(&self) -> bool {
        let cuts = |call: &&Call| {
            matches!(call, Call::Operation(Operation { operator: Operator::Difference, left: Some(_), .. }))
        };
        self.calls.iter().filter(cuts).count() % 2 == 1
    }

    /// Goes through the parts of a union that hold the point at t, until it has an answer or a part has to be asked that
    /// is on the stack then.
    #[inline(always)]
    fn search<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        mut union: Union,
        t: f64,
    ) -> Option<Crossing> {
        while let Some(Holder { place, ray }) = self.points.next(simd, held, hits, union.mark, t) {
            let number = hits.block(place.way);
            let block = held.block(number);
            if place.is_small {
                let detail = hits.detail.as_ref().filter(|_| !self.is_cut());
                if let Some(extents) = detail.map(|detail| detail.extents(held, number, place, &ray)) {
                    union.take(Crossing::new(&extents, t, place), hits);
                }
                continue;
            }
            match block.items[place.item as usize].content {
                Content::Shape(shape) => {
                    let extents = shapes::extents(&block.shapes[shape as usize], &ray);
                    union.take(Crossing::new(&extents, t, place), hits);
                }
                Content::Solid(solid) => {
                    self.calls.push(Call::Union(union));
                    let (left, way) = self.begin(held, hits, place, solid, &ray);
                    return self.ask(held, hits, left, ray, way, t);
                }
                Content::Super(_) | Content::Gate(_) => unreachable!("super-nodes are entered"),
            }
        }
        self.points.rewind(union.mark);
        Some(union.answer())
    }
}
