//! Where the rays of a beam come into the scene.
//!
//! From close by, all rays through a tile of the picture take the same way down: through dozens of super-nodes, one inside
//! of the other, before they meet anything by which they differ. So that way is gone once for the tile, by a [`Beam`] that
//! holds all of its rays, and they begin where it ends: at a few *entries*, parts of super-nodes beyond which the beam
//! meets nothing. \[RESH05\] look for such entry points in a kd-tree.
//!
//! Boxes are tested by interval arithmetic, in double precision, as the beam may be 10¹⁰ sizes of a part away from where the
//! coordinates of the world are 0. Rays are moved into the frames of entries step by step, as on any other way, so that
//! they meet the same things at the same t to the last bit.

use csg_graph_bounds::Aabb;
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3Swizzles};

use super::blocks::Held;
use super::compile::{Content, SuperNode};
use super::frame::DRIFT;
use super::hits::{Hits, Place, ROOT, START, Trail};
use super::lanes::{LANES, Rays};
use super::tree::{Child, WIDTH};

/// The most entries of a beam.
const MOST: usize = 16;

/// Only what is so many times as large as the beam is wide is looked into: in what is smaller, its rays go different ways.
const WIDE: f64 = 4.0;

/// The most super-nodes on the ways to them.
const FARTHEST: usize = 1 << 8;

/// What is rounded, relative to the beam.
const ROUNDED: f64 = 1e-9;

/// Rays from one point through a part of the picture: in the directions corner + u · across + v · down, where u and v are
/// from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Where the rays begin.
    pub origin: DVec3,
    /// The direction through one corner.
    pub corner: DVec3,
    /// The way from there to the next.
    pub across: DVec3,
    /// And to the one on the other side.
    pub down: DVec3,
}

/// A part of a beam: from the least u and v to the greatest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    min: DVec2,
    max: DVec2,
}

/// A part of a super-node where the rays of a beam begin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// The way to the super-node, and its number in its block.
    pub(super) way: u32,
    pub(super) number: u32,
    pub(super) child: Child,
    /// No ray of the beam meets anything there before that t.
    pub(super) near: f64,
    /// Rays of the beam that are not in there meet nothing either.
    window: Window,
}

/// Where rays begin.
#[derive(Debug, Default)]
pub(super) struct Entries {
    /// The nearest first.
    pub(super) list: Vec<Entry>,
    /// The ways to them.
    pub(super) trail: Trail,
    /// The beam that they are for.
    beam: Option<Beam>,
}

/// A super-node that a beam meets.
struct Candidate {
    way: u32,
    number: u32,
    /// The beam in its frame.
    beam: Beam,
    near: f64,
    window: Window,
    /// How many times as large it is as the beam is wide there.
    size: f64,
}

impl Window {
    const ALL: Self = Self { min: DVec2::NEG_INFINITY, max: DVec2::INFINITY };

    /// Whether it has anything in common with another one.
    fn meets(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

impl Beam {
    fn transform(&self, map: &DAffine3) -> Self {
        Self {
            origin: map.transform_point3(self.origin),
            corner: map.transform_vector3(self.corner),
            across: map.transform_vector3(self.across),
            down: map.transform_vector3(self.down),
        }
    }

    /// The least and the greatest of each coordinate of its directions.
    fn range(&self) -> [DVec3; 2] {
        let Self { corner, across, down, .. } = *self;
        let [zero, sum] = [DVec3::ZERO, across + down];
        [corner + zero.min(across).min(down.min(sum)), corner + zero.max(across).max(down.max(sum))]
    }

    /// From a vector to its part along the corner, and what this times u and v are.
    fn inverse(&self) -> DMat3 {
        DMat3::from_cols(self.corner, self.across, self.down).inverse()
    }

    /// How far u and v may be off by rounding, of 1: the more, the narrower the beam is and the more it is sheared.
    fn rounding(&self) -> f64 {
        let [corner, across, down] = [self.corner, self.across, self.down].map(DVec3::length);
        let shear = corner * across * down / self.corner.dot(self.across.cross(self.down)).abs();
        ROUNDED.max(256.0 * f64::EPSILON * shear * shear * (1.0 + corner / across.min(down)))
    }

    /// Where a box is seen.
    fn window(&self, bounds: &Aabb) -> Window {
        let (inverse, rounded) = (self.inverse(), self.rounding());
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in bounds.corners() {
            let seen = inverse * (corner - self.origin);
            let place = seen.yz() / seen.x;
            // Behind the eye, or unbounded.
            if !(seen.x > 0.0 && place.is_finite()) {
                return Window::ALL;
            }
            (min, max) = (min.min(place), max.max(place));
        }
        let rounded = rounded * (1.0 + min.abs().max(max.abs()));
        Window { min: min - rounded, max: max + rounded }
    }

    /// The window of some of its rays.
    fn window_of(&self, directions: impl Iterator<Item = DVec3>) -> Window {
        let (inverse, rounded) = (self.inverse(), self.rounding());
        let places = directions.map(|direction| {
            let along = inverse * direction;
            along.yz() / along.x
        });
        let (min, max) = places.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), place| {
            (min.min(place), max.max(place))
        });
        Window { min: min - rounded, max: max + rounded }
    }

    /// A t before which none of its rays meets a box; none if they all miss it.
    fn meets(&self, bounds: &Aabb) -> Option<f64> {
        let [low, high] = self.range();
        let (mut near, mut far) = (0.0_f64, f64::INFINITY);
        for axis in 0..3 {
            // From where it begins to the planes, along directions from `low` to `high`. The box is before it or around it.
            let (mut min, mut max) =
                (bounds.min[axis] - self.origin[axis], bounds.max[axis] - self.origin[axis]);
            let (mut low, mut high) = (low[axis], high[axis]);
            if max < 0.0 {
                (min, max, low, high) = (-max, -min, -high, -low);
            }
            if min > 0.0 {
                if high <= 0.0 {
                    return None;
                }
                near = near.max(min / high);
            } else if high < 0.0 {
                far = far.min(min / high);
            }
            if low > 0.0 {
                far = far.min(max / low);
            }
        }
        (near <= far * (1.0 + ROUNDED)).then_some(near * (1.0 - ROUNDED))
    }
}

impl Entry {
    /// Whether rays in a window may meet anything there.
    pub(super) fn is_seen(&self, window: &Window) -> bool {
        self.window.meets(window)
    }
}

impl Candidate {
    fn new(held: &Held<'_>, hits: &Hits, (way, number): (u32, u32), beam: Beam, seen: (f64, Window)) -> Self {
        let ball = &held.block(hits.block(way)).supers[number as usize];
        let [low, high] = beam.range();
        let (near, window) = seen;
        let size = 2.0 * ball.radius / (near * (high - low).length());
        Self { way, number, beam, near, window, size }
    }

    /// The items in it that the beam meets, each with the t before which it does not and where it is seen, unless there are
    /// more than `most`.
    fn met(&self, held: &Held<'_>, hits: &Hits, most: usize) -> Option<Vec<(usize, (f64, Window))>> {
        let block = held.block(hits.block(self.way));
        let ball = &block.supers[self.number as usize];
        let drift = DRIFT * (self.beam.origin - ball.center).abs().element_sum();
        let mut met = Vec::new();
        let mut open: Vec<_> = ball.root.map(|root| (root, (self.near, self.window))).into_iter().collect();
        while let Some((child, seen)) = open.pop() {
            let node = match child.get() {
                Ok(_) if met.len() == most => return None,
                Ok(item) => {
                    met.push((item, seen));
                    continue;
                }
                Err(node) => &block.nodes[node],
            };
            for slot in 0..WIDTH.min(node.count as usize) {
                let Aabb { min, max } = ball.bounds(node.bounds(slot));
                let bounds = Aabb { min: min - drift, max: max + drift };
                if let Some(near) = self.beam.meets(&bounds) {
                    let is_item = node.children[slot].get().is_ok();
                    let window = if is_item { self.beam.window(&bounds) } else { Window::ALL };
                    open.push((node.children[slot], (near, window)));
                }
            }
        }
        Some(met)
    }

    fn root(&self, ball: &SuperNode) -> Option<Entry> {
        let Self { way, number, near, window, .. } = *self;
        ball.root.map(|child| Entry { way, number, child, near, window })
    }
}

impl Entries {
    /// Those of all rays: the root.
    pub(super) fn root(&mut self, held: &Held<'_>) {
        self.beam = None;
        self.list.clear();
        self.trail.clear();
        let child = held.block(ROOT).supers[0].root;
        self.list.extend(child.map(|child| Entry {
            way: START,
            number: 0,
            child,
            near: 0.0,
            window: Window::ALL,
        }));
    }

    /// The window of some rays of the beam.
    pub(super) fn window_of(&self, rays: &Rays) -> Window {
        let beam = self.beam.filter(|_| self.list.len() > 1);
        beam.map_or(Window::ALL, |beam| beam.window_of((0..LANES).map(|lane| rays.get(lane).direction)))
    }

    /// Forgets the blocks that are on the ways.
    pub(super) fn forget(&mut self) {
        self.beam = None;
    }

    /// Those of the rays of a beam, unless they are known.
    pub(super) fn aim(&mut self, held: &Held<'_>, hits: &mut Hits, beam: &Beam) {
        if self.beam == Some(*beam) && self.trail.is_for(hits) {
            return;
        }
        self.beam = Some(*beam);
        self.list.clear();
        hits.clear([0.0; LANES]);
        let mut open = vec![Candidate::new(held, hits, (START, 0), *beam, (0.0, Window::ALL))];
        // The largest is looked into first.
        while let Some(at) = (0..open.len()).max_by(|a, b| open[*a].size.total_cmp(&open[*b].size)) {
            let next = open.swap_remove(at);
            let number = hits.block(next.way);
            let block = held.block(number);
            let room = MOST - self.list.len() - open.len();
            let is_wide = next.size > WIDE && hits.way_count() < FARTHEST;
            let met = if is_wide { next.met(held, hits, room) } else { None };
            let Some(met) = met else {
                self.list.extend(next.root(&block.supers[next.number as usize]));
                continue;
            };
            for (at, seen) in met {
                let item = &block.items[at];
                let (Content::Super(_) | Content::Gate(_)) = item.content else {
                    let Candidate { way, number, .. } = next;
                    let (near, window) = seen;
                    self.list.push(Entry { way, number, child: Child::item(at), near, window });
                    continue;
                };
                if let Some((below, ball)) = held.inside(number, item.content) {
                    let way = hits.enter(Place::new(next.way, at), block, below);
                    let number = if let Content::Super(number) = item.content { number } else { 0 };
                    if ball.root.is_some() {
                        let beam = next.beam.transform(&item.item_from_super);
                        open.push(Candidate::new(held, hits, (way, number), beam, seen));
                    }
                }
            }
        }
        self.list.sort_by(|a, b| a.near.total_cmp(&b.near));
        self.trail.keep(hits);
    }
}
