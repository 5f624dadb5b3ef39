//! Rays of a packet through what is left of one primitive, A \\ B with a convex A: together, while their points are.
//!
//! [One ray](super::solid) gets outside of a union by leaving, again and again, some part that holds its point. Here the
//! points of all rays go down the tree of B side by side, each with a t of its own: a box holds some of them, a part moves
//! some of them on to its exit, and those that were moved start again from the top, until no part holds any. A ray is done
//! where nothing holds its point, or where A ends.
//!
//! Points of neighbouring rays fall apart into ever smaller boxes. Even one that is left in a box is cheaper to follow here
//! than [by itself](super::solid): for a point there is nothing to divide, to sort or to keep for later. But each start from
//! the top costs its depth again. So rays that go on from part to part in deep recursion go by themselves in the end. Rays
//! that come to operators in B are left to the other way as a whole.
//!
//! A shadow ray begins in a hole, among all the others, but need not know the first boundary: if there is a t at which it is
//! in A and in no part of B, it meets one. The parts leave no such t if each begins before the one before it ends, from
//! whichever side they are gone through. So shadow rays are turned round, and come from the light: what is lit is passed as
//! before, and what is not is mostly behind some large piece. A ray that ends in A cannot be, as it may have been inside all
//! the way.

mod front;
mod level;

use csg_graph::Operator;
use fearless_simd::{Select, Simd, SimdBase, f64x8};

use self::front::Front;
use self::level::{Level, inside, push};
use super::compiled::{Compiled, Content, Solid, SuperNode};
use super::held::Held;
use super::hits::{Hits, Place};
use super::inquiry::Ask;
use super::lanes::{HALF, LANES, Lanes, Mask, Rays, Vec3x8, bits, each};
use super::shapes;
use super::solid::Solids;
use super::tree::{Child, Target};
use crate::Ray;

/// Rays start from the top until they have gone down through so many super-nodes, all times together. Those that still go
/// from part to part are in some deep corner, each by itself.
const WAY: usize = 24;

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

/// What is left to do for the points of some rays.
#[derive(Clone, Copy, Debug)]
struct Open {
    child: Child,
    level: u32,
    lanes: Mask,
}

impl Cuts {
    /// The first boundaries of a solid on rays of a set that are given in its super-node, none behind its end, or any
    /// if that is what rays ask for; or nothing if the solid is of another kind.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "what is asked, and where")]
    pub(super) fn first<S: Simd>(
        &mut self,
        simd: S,
        held: &Held<'_>,
        hits: &mut Hits,
        solids: &mut Solids,
        ask: Ask,
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
                let left_at = block.supers[left as usize].root?.as_item()?;
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
                let is_turned = ask == Ask::Any && turn(simd, solid_rays, &mut spans, &hits.t, lanes);
                let range = if is_turned { (f64::NEG_INFINITY, &spans[1]) } else { (0.0, &hits.t) };
                let mut met = lanes & self.front.begin(simd, &spans, range, Place::new(way, left_at));
                let ball = &block.supers[right as usize];
                if let Some(root) = ball.root
                    && met != 0
                {
                    self.levels.iter_mut().for_each(|level| level.entered = None);
                    self.levels[0].set(simd, None, ball, (number, way), met);
                    met = self.get_out(simd, held, hits, solids, (right, way), root, &spans[1], met);
                }
                let Front { t, mut faces, tied, alone, .. } = self.front;
                let alone = met & if is_turned { alone } else { alone | self.front.at_origin(simd) };
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
        (right, way): (u32, u32),
        root: Child,
        exits: &Lanes,
        mut lanes: Mask,
    ) -> Mask {
        let mut met = 0;
        let mut way_down = 0;
        while lanes != 0 && way_down < WAY {
            self.front.moved = 0;
            self.levels[0].lanes = lanes;
            self.stack.clear();
            self.stack.push(Open { child: root, level: 0, lanes });
            way_down += self.go_down(simd, held, hits, solids);
            let Front { moved, alone, .. } = self.front;
            met |= lanes & (!moved | alone);
            lanes &= moved & !alone & self.front.going(simd, exits);
        }
        each(lanes, |lane| {
            let Self { front, levels, .. } = self;
            let (range, face) = ([front.t.0[lane], front.ends.0[lane]], front.faces[lane]);
            let ray = levels[0].rays.get(lane);
            let (t, face) = solids.leave(simd, held, hits, (right, way), &ray, range, face);
            front.move_on(lane, t, face);
            front.tied |= u32::from(solids.tied) << lane;
        });
        met | lanes & self.front.going(simd, exits)
    }

    /// Moves rays on that are in parts of B. Says how many super-nodes they went down through to the deepest.
    #[inline(always)]
    fn go_down<S: Simd>(&mut self, simd: S, held: &Held<'_>, hits: &mut Hits, solids: &mut Solids) -> usize {
        let mut deepest = 0;
        while let Some(Open { child, level, lanes }) = self.stack.pop() {
            let lanes = lanes & !self.front.alone;
            if lanes == 0 {
                continue;
            }
            deepest = deepest.max(level as usize);
            let here = &mut self.levels[level as usize];
            let block = held.block(here.block);
            let at = match child.target() {
                Target::Node(node) => {
                    if here.changes != self.front.changes {
                        here.set_points(simd, &self.front);
                    }
                    let node = &block.nodes[node];
                    solids.work.boxes += u64::from(node.count * lanes.count_ones());
                    push(simd, &mut self.stack, node, here, level, lanes);
                    continue;
                }
                Target::Item(at) => at,
            };
            let item = &block.items[at];
            let place = Place::new(here.way, at);
            match item.content {
                Content::Super(_) | Content::Gate(_) => {
                    if held.is_crowded(0, hits, here.way) {
                        continue;
                    }
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
        deepest + 1
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
}

/// Turns rays round, with their spans in A, if those of a set leave it before they end: then they go from there to where
/// they start.
#[inline(always)]
fn turn<S: Simd>(simd: S, rays: &mut Rays, spans: &mut [Lanes; 2], ends: &Lanes, lanes: Mask) -> bool {
    let mut staying = 0;
    for half in 0..2 {
        let is_staying = spans[1].half(simd, half).simd_ge(ends.half(simd, half));
        staying |= bits(is_staying) << (half * HALF);
    }
    if lanes & staying != 0 {
        return false;
    }
    let zero = f64x8::splat(simd, 0.0);
    for half in 0..2 {
        let [origin, Vec3x8 { x, y, z }] = rays.half(simd, half);
        rays.set_half(half, origin, Vec3x8 { x: -x, y: -y, z: -z });
        let (enter, exit) = (spans[0].half(simd, half), spans[1].half(simd, half));
        spans[0].set_half(half, -exit);
        spans[1].set_half(half, enter.simd_le(zero).select(zero, -enter));
    }
    true
}
