//! Rays of a packet through what is left of one primitive, A \\ B with a convex A: together, while their points are.
//!
//! [One ray](super::solid) gets outside of a union by leaving, again and again, some part that holds its point. Here the
//! points of all rays go down the tree of B side by side, each with a t of its own: a box holds some of them, a part moves
//! some of them on to its exit, and those that were moved start again from the top, until no part holds any. A ray is done
//! where nothing holds its point, or where A ends.
//!
//! Points of neighbouring rays fall apart into ever smaller boxes. One that is left in a box goes down
//! [by itself](super::solid) from there. Rays that come to operators in B are left to the other way as a whole.

use csg_graph::Operator;
use fearless_simd::{Select, Simd, SimdBase, SimdMask, SimdNarrow, f32x8, f32x16, f64x8, mask32x16};
use glam::DVec3;

use super::blocks::Held;
use super::compile::{Compiled, Content, Item, Solid, SuperNode};
use super::frame::{DRIFT, Floats, float_bits, load};
use super::hits::{Hits, Place, ROOT, START};
use super::lanes::{HALF, LANES, Lanes, Mask, Rays, Vec3x8};
use super::packet::each;
use super::shapes::{self, bits};
use super::solid::{Part, Solids};
use super::tree::{Child, Node, WIDTH};
use crate::Ray;

/// With fewer points than this, each goes down by itself.
const FEW: u32 = 3;

/// The memory of such rays.
#[derive(Debug, Default)]
pub(super) struct Cuts {
    levels: Vec<Level>,
    stack: Vec<Open>,
    front: Front,
}

/// The first boundaries of a solid.
pub(super) struct Firsts {
    pub(super) t: Lanes,
    pub(super) faces: [Place; LANES],
    /// The way into the solid.
    pub(super) way: u32,
    /// The rays that have one.
    pub(super) met: Mask,
    /// Those that have to be asked alone.
    pub(super) alone: Mask,
}

/// Where the rays are.
#[derive(Debug)]
struct Front {
    t: Lanes,
    /// Where A ends, or the ray.
    ends: Lanes,
    /// The faces that they have come to t by.
    faces: [Place; LANES],
    /// Those that have moved since they started from the top.
    moved: Mask,
    /// Those that may have several faces at t.
    tied: Mask,
    /// Those that have come to their t by themselves, and that no part holds there.
    finished: Mask,
    /// Those that have to be asked alone.
    alone: Mask,
    /// Counts all changes of t.
    changes: u32,
}

/// What is left to do for the points of some rays.
#[derive(Clone, Copy, Debug)]
struct Open {
    child: Child,
    level: u32,
    lanes: Mask,
}

/// Rays in a super-node.
#[derive(Clone, Debug)]
struct Level {
    /// What it was entered by, unless it is B.
    entered: Option<(u32, u32)>,
    rays: Rays,
    ball: SuperNode,
    block: u32,
    way: u32,
    /// The rays whose points may be in it.
    lanes: Mask,
    /// How far off points may be, in units of the super-node's radius.
    drift: Floats,
    /// The points in the unit ball, less the drift and more.
    points: [[Floats; 3]; 2],
    /// A box around them.
    bounds: [[f32; 3]; 2],
    /// How often t had changed when they were computed.
    changes: u32,
}

impl Default for Front {
    fn default() -> Self {
        let (t, faces) = (Lanes::ZERO, [Place::NONE; LANES]);
        Self { t, ends: t, faces, moved: 0, tied: 0, finished: 0, alone: 0, changes: 0 }
    }
}

impl Front {
    /// Begins where rays enter A, or where they start if they are in A, if that is before their ends. Says for which it is.
    #[inline(always)]
    fn begin<S: Simd>(&mut self, simd: S, [enters, exits]: &[Lanes; 2], ends: &Lanes, face: Place) -> Mask {
        *self = Self { faces: [face; LANES], ..Self::default() };
        let mut met = 0;
        let zero = f64x8::splat(simd, 0.0);
        for half in 0..2 {
            let (enter, exit, end) = (enters.half(simd, half), exits.half(simd, half), ends.half(simd, half));
            let t = enter.simd_gt(zero).select(enter, zero);
            self.t.set_half(half, t);
            self.ends.set_half(half, exit.simd_lt(end).select(exit, end));
            self.tied |= bits(enter.simd_eq(zero)) << (half * HALF);
            met |= bits(t.simd_lt(exit) & t.simd_le(end)) << (half * HALF);
        }
        met
    }

    /// The rays that have not come to where A ends, and not beyond their own ends.
    #[inline(always)]
    fn going<S: Simd>(&self, simd: S, exits: &Lanes) -> Mask {
        let mut going = 0;
        for half in 0..2 {
            let t = self.t.half(simd, half);
            let is_before = t.simd_lt(exits.half(simd, half)) & t.simd_le(self.ends.half(simd, half));
            going |= bits(is_before) << (half * HALF);
        }
        going
    }

    /// The rays that have not left their origins.
    #[inline(always)]
    fn at_origin<S: Simd>(&self, simd: S) -> Mask {
        let zero = f64x8::splat(simd, 0.0);
        bits(self.t.half(simd, 0).simd_le(zero)) | bits(self.t.half(simd, 1).simd_le(zero)) << HALF
    }

    /// Takes the span of a part on one ray: the first t that is in it, and the first that is not.
    #[inline(always)]
    #[expect(clippy::float_cmp, reason = "faces that differ by an ulp do not coincide")]
    fn take(&mut self, hits: &Hits, lane: usize, [enter, exit]: [f64; 2], place: Place) {
        let t = self.t.0[lane];
        // The face that the ray has come to t by is not another one.
        if enter < exit && (enter == t || exit == t) && !hits.is_same(self.faces[lane], place) {
            self.tied |= 1 << lane;
        }
        if enter <= t && t < exit {
            self.move_on(lane, exit, Place { turned: true, ..place });
        }
    }

    #[inline(always)]
    fn move_on(&mut self, lane: usize, t: f64, face: Place) {
        self.t.0[lane] = t;
        self.faces[lane] = face;
        // Other faces at the last t are behind.
        self.tied &= !(1 << lane);
        self.moved |= 1 << lane;
        self.changes += 1;
    }
}

impl Cuts {
    /// The first boundaries of a solid on rays of a set that are given in its super-node, none behind its end; or nothing
    /// if the solid is of another kind.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "what is asked, and where")]
    pub(super) fn first<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        solids: &mut Solids,
        (solid, place): (u32, Place),
        rays: &Rays,
        lanes: Mask,
    ) -> Option<Firsts> {
        simd.vectorize(
            #[inline(always)]
            || {
                let number = hits.block(place.way);
                let block = held.block(number);
                let Solid { operator, operands: [left, right] } = block.solids[solid as usize];
                let left_at = block.supers[left as usize].root?.get().ok()?;
                let left = &block.items[left_at];
                let Content::Shape(shape) = left.content else { return None };
                // What stands for small parts is for single rays to say.
                if operator != Operator::Difference || hits.detail.is_some() {
                    return None;
                }
                let item = &block.items[place.item as usize];
                let way = hits.enter(place, block, number);
                if self.levels.is_empty() {
                    self.levels.push(Level::EMPTY);
                }
                let solid_rays = &mut self.levels[0].rays;
                let mut spans = [Lanes::ZERO; 2];
                for half in 0..2 {
                    let [origin, direction] = inside(simd, rays, item, half);
                    solid_rays.set_half(half, origin, direction);
                    let ray = inside(simd, solid_rays, left, half);
                    let [enter, exit] = shapes::span(simd, &block.shapes[shape as usize], ray)?;
                    spans[0].set_half(half, enter);
                    spans[1].set_half(half, exit);
                }
                solids.work.primitives += u64::from(lanes.count_ones());
                let mut met = lanes & self.front.begin(simd, &spans, &hits.t, Place::new(way, left_at));
                let ball = &block.supers[right as usize];
                if let Some(root) = ball.root
                    && met != 0
                {
                    self.levels.iter_mut().for_each(|level| level.entered = None);
                    self.levels[0].set(simd, None, ball, (number, way), met);
                    met = self.get_out(simd, held, hits, solids, root, &spans[1], met);
                }
                let Front { t, mut faces, tied, alone, .. } = self.front;
                let alone = met & (alone | self.front.at_origin(simd));
                each(met & tied, |lane| faces[lane] = place);
                Some(Firsts { t, faces, way, met: met & !alone, alone })
            },
        )
    }

    /// A ray in the frame of the solid that was asked last.
    #[inline(always)]
    pub(super) fn ray(&self, lane: usize) -> Ray {
        self.levels[0].rays.get(lane)
    }

    /// Moves rays that are in A on to where they are outside of B. Says which get there in A.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "what is asked, and where")]
    fn get_out<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        solids: &mut Solids,
        root: Child,
        exits: &Lanes,
        mut lanes: Mask,
    ) -> Mask {
        let mut met = 0;
        while lanes != 0 {
            self.front.moved = 0;
            self.levels[0].lanes = lanes;
            self.stack.clear();
            self.stack.push(Open { child: root, level: 0, lanes });
            self.go_down(simd, held, hits, solids);
            let Front { moved, finished, alone, .. } = self.front;
            let going = self.front.going(simd, exits);
            met |= lanes & (!moved | finished & going | alone);
            lanes &= moved & !finished & !alone & going;
        }
        met
    }

    /// Moves rays on that are in parts of B.
    #[inline(always)]
    fn go_down<S: Simd>(&mut self, simd: S, held: &Held<'_>, hits: &mut Hits, solids: &mut Solids) {
        while let Some(Open { child, level, lanes }) = self.stack.pop() {
            let lanes = lanes & !(self.front.finished | self.front.alone);
            if lanes == 0 {
                continue;
            }
            let are_few = lanes.count_ones() < FEW;
            let here = &mut self.levels[level as usize];
            let block = held.block(here.block);
            let at = match child.get() {
                Err(_) if are_few => {
                    each(lanes, |lane| self.go_alone(simd, held, hits, solids, (child, level), lane));
                    continue;
                }
                Err(node) => {
                    if here.changes != self.front.changes {
                        here.set_points(simd, &self.front);
                    }
                    let node = &block.nodes[node];
                    solids.work.boxes += u64::from(node.count * lanes.count_ones());
                    push(simd, &mut self.stack, node, here, level, lanes);
                    continue;
                }
                Ok(at) => at,
            };
            let item = &block.items[at];
            let place = Place::new(here.way, at);
            match item.content {
                Content::Super(_) | Content::Gate(_) if are_few => {
                    each(lanes, |lane| self.go_alone(simd, held, hits, solids, (child, level), lane));
                }
                Content::Super(_) | Content::Gate(_) => {
                    let Some((number, ball)) = held.inside(here.block, item.content) else { continue };
                    let Some(root) = ball.root else { continue };
                    self.descend(simd, hits, (place, block), (ball, number), level as usize, lanes);
                    self.stack.push(Open { child: root, level: level + 1, lanes });
                }
                Content::Shape(shape) => {
                    solids.work.primitives += u64::from(lanes.count_ones());
                    for half in 0..2 {
                        let lanes = lanes >> (half * HALF) & 0xff;
                        if lanes == 0 {
                            continue;
                        }
                        let ray = inside(simd, &here.rays, item, half);
                        let Some([enter, exit]) = shapes::span(simd, &block.shapes[shape as usize], ray)
                        else {
                            self.front.alone |= lanes << (half * HALF);
                            continue;
                        };
                        let t = self.front.t.half(simd, half);
                        let touches = enter.simd_le(t) & t.simd_le(exit);
                        let mut span = [[0.0; HALF]; 2];
                        enter.store_slice(&mut span[0]);
                        exit.store_slice(&mut span[1]);
                        each(lanes & bits(touches), |lane| {
                            let span = [span[0][lane % HALF], span[1][lane % HALF]];
                            self.front.take(hits, half * HALF + lane, span, place);
                        });
                    }
                }
                Content::Solid(_) => self.front.alone |= lanes,
            }
        }
    }

    /// Brings rays into the frame of an item, at the next level.
    #[inline(always)]
    fn descend<S: Simd>(
        &mut self,
        simd: S,
        hits: &mut Hits,
        (place, from): (Place, &Compiled),
        (ball, block): (&SuperNode, u32),
        level: usize,
        lanes: Mask,
    ) {
        if self.levels.len() < level + 2 {
            self.levels.push(Level::EMPTY);
        }
        let [above, below] = &mut self.levels[level..level + 2] else {
            unreachable!("both levels are there")
        };
        let entered = Some((place.way, place.item));
        if below.entered == entered {
            (below.lanes, below.changes) = (lanes, u32::MAX);
            return;
        }
        let item = &from.items[place.item as usize];
        for half in 0..2 {
            let [origin, direction] = inside(simd, &above.rays, item, half);
            below.rays.set_half(half, origin, direction);
        }
        below.set(simd, entered, ball, (block, hits.enter(place, from, block)), lanes);
    }

    /// Moves a ray on by itself: in the part that it is in and, if it leaves that, in those around it, to its end.
    #[inline(always)]
    fn go_alone<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        solids: &mut Solids,
        (child, level): (Child, u32),
        lane: usize,
    ) {
        let Self { front, levels, .. } = self;
        let range = [front.t.0[lane], front.ends.0[lane]];
        let (ray, part) = levels[level as usize].part(lane, child);
        let end = solids.leave(simd, held, hits, part, &ray, range, front.faces[lane]);
        if let Some((t, face)) = end {
            let mut known = child;
            for here in levels[..=level as usize].iter().rev() {
                if let Some(root) = here.ball.root.filter(|root| *root != known) {
                    let (ray, part) = here.part(lane, root);
                    solids.leave_around(part, &ray, known);
                }
                known = here.entered.map_or(known, |(_, item)| Child::item(item as usize));
            }
            let (t, face) = solids.leave_on(simd, held, hits, [t, range[1]], face);
            front.move_on(lane, t, face);
            front.finished |= 1 << lane;
        }
        front.tied |= u32::from(solids.tied) << lane;
    }
}

impl Level {
    const EMPTY: Self = Self {
        entered: None,
        rays: Rays::ZERO,
        ball: SuperNode { center: DVec3::ZERO, radius: 1.0, to_unit: 1.0, reach: 1.0, root: None },
        block: ROOT,
        way: START,
        lanes: 0,
        drift: Floats::ZERO,
        points: [[Floats::ZERO; 3]; 2],
        bounds: [[0.0; 3]; 2],
        changes: u32::MAX,
    };

    /// A child of the super-node, and a ray there.
    #[inline(always)]
    fn part(&self, lane: usize, child: Child) -> (Ray, Part<'_>) {
        (self.rays.get(lane), Part { ball: &self.ball, child, block: self.block, way: self.way })
    }

    /// Makes it that of a super-node for rays that are in its frame already.
    #[inline(always)]
    fn set<S: Simd>(
        &mut self,
        simd: S,
        entered: Option<(u32, u32)>,
        ball: &SuperNode,
        (block, way): (u32, u32),
        lanes: Mask,
    ) {
        let mut drifts = [f64x8::splat(simd, 0.0); 2];
        for (half, drift) in drifts.iter_mut().enumerate() {
            let from_center = self.rays.half(simd, half)[0].offset(-ball.center);
            let sum = from_center.x.abs() + from_center.y.abs() + from_center.z.abs();
            *drift = sum * (DRIFT * ball.to_unit);
        }
        self.drift = Floats::from_vector(drifts[0].narrow(drifts[1]));
        self.ball.clone_from(ball);
        (self.entered, self.block, self.way) = (entered, block, way);
        (self.lanes, self.changes) = (lanes, u32::MAX);
    }

    /// Computes where the points are.
    #[inline(always)]
    #[expect(
        clippy::needless_range_loop,
        reason = "iterators would be compiled without the vector instructions"
    )]
    fn set_points<S: Simd>(&mut self, simd: S, front: &Front) {
        let mut points = [[f64x8::splat(simd, 0.0); 2]; 3];
        for half in 0..2 {
            let [origin, direction] = self.rays.half(simd, half);
            let from_center = origin.at(direction, front.t.half(simd, half)).offset(-self.ball.center);
            points[0][half] = from_center.x * self.ball.to_unit;
            points[1][half] = from_center.y * self.ball.to_unit;
            points[2][half] = from_center.z * self.ball.to_unit;
        }
        let is_in = mask32x16::from_bitmask(simd, u64::from(self.lanes));
        let [least, most] = [f32::MIN, f32::MAX].map(|limit| f32x16::splat(simd, limit));
        let drift = self.drift.load(simd);
        for axis in 0..3 {
            let point = points[axis][0].narrow(points[axis][1]);
            let (low, high) = (point - drift, point + drift);
            self.points[0][axis] = Floats::from_vector(low);
            self.points[1][axis] = Floats::from_vector(high);
            self.bounds[0][axis] = is_in.select(low, most).reduce_min();
            self.bounds[1][axis] = is_in.select(high, least).reduce_max();
        }
        self.changes = front.changes;
    }
}

/// Half of the rays in the frame of an item of their super-node.
#[inline(always)]
fn inside<S: Simd>(simd: S, rays: &Rays, item: &Item, half: usize) -> [Vec3x8<S>; 2] {
    let [origin, direction] = rays.half(simd, half);
    let map = &item.item_from_super;
    [origin.transform_point(map), direction.transform_vector(map)]
}

/// Puts the children of a node that hold points of the set on the stack, the largest last.
#[inline(always)]
fn push<S: Simd>(simd: S, stack: &mut Vec<Open>, node: &Node, here: &Level, level: u32, lanes: Mask) {
    let [low, high] = [load(simd, &here.points[0]), load(simd, &here.points[1])];
    let mut candidates = overlapping(simd, node, &here.bounds);
    while candidates != 0 {
        let slot = candidates.trailing_zeros() as usize % WIDTH;
        candidates &= candidates - 1;
        let mut held = lanes;
        for axis in 0..3 {
            let is_above = high[axis].simd_ge(f32x16::splat(simd, node.planes[axis][slot]));
            let is_below = low[axis].simd_le(f32x16::splat(simd, node.planes[axis + 3][slot]));
            held &= float_bits(is_above & is_below);
        }
        if held != 0 {
            stack.push(Open { child: node.children[slot], level, lanes: held });
        }
    }
}

/// The children of a node whose boxes overlap a box.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, reason = "eight bits")]
fn overlapping<S: Simd>(simd: S, node: &Node, [low, high]: &[[f32; 3]; 2]) -> u32 {
    let mut overlap = (1 << node.count) - 1;
    for axis in 0..3 {
        let begins = f32x8::from_slice(simd, &node.planes[axis]).simd_le(f32x8::splat(simd, high[axis]));
        let ends = f32x8::from_slice(simd, &node.planes[axis + 3]).simd_ge(f32x8::splat(simd, low[axis]));
        overlap &= (begins & ends).to_bitmask() as u32;
    }
    overlap
}
