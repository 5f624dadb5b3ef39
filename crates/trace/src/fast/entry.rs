//! Where the rays of a beam come into the scene.
//!
//! From close by, all rays through a tile of the picture take the same way down: through dozens of super-nodes, one inside
//! of the other, before they meet anything by which they differ. So that way is gone once for the tile, by a [`Beam`] that
//! holds all of its rays, and they begin where it ends: at a few *entries*, parts of super-nodes beyond which the beam
//! meets nothing. \[RESH05\] look for such entry points in a kd-tree.
//!
//! Boxes are tested by interval arithmetic, in double precision, as the beam may be 10¹⁰ sizes of a part away from where the
//! coordinates of the world are 0. Rays are moved into the frames of entries step by step, as on any other way, so that
//! they meet the same things at the same t to the last bit. Where small parts are judged, they are tested against the boxes
//! of entries as well, since where they meet these counts.

use csg_graph_bounds::Aabb;
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3Swizzles};

use super::compiled::Content;
use super::detail::{Detail, Footprint};
use super::frame::DRIFT;
use super::held::Held;
use super::hits::{Hits, Place, ROOT, START, Trail};
use super::lanes::{LANES, Rays};
use super::tree::{Child, Target};

/// The most entries of a beam.
const MOST: usize = 16;

/// Only what is so many times as large as the beam is wide is looked into: in what is smaller, its rays go different ways,
/// and some of it may be too small for any of them.
const WIDE: f64 = 4.0;

/// The most super-nodes on the ways to them.
const FARTHEST: usize = 1 << 8;

/// How far t, u and v may be off by rounding, relative to what they are.
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

/// Where the rays of a beam meet something.
#[derive(Clone, Copy, Debug)]
struct Sight {
    /// They do not meet it before that t.
    near: f64,
    /// Nor do those that are not in there.
    window: Window,
}

/// A part of a super-node where the rays of a beam begin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// The way to the super-node, and its number in its block.
    pub(super) way: u32,
    pub(super) number: u32,
    pub(super) child: Child,
    /// If that is a node, the slot of the item that they begin with; none for all that is in it.
    pub(super) slot: Option<usize>,
    sight: Sight,
}

/// Where rays begin.
#[derive(Debug, Default)]
pub(super) struct Entries {
    /// The nearest first.
    pub(super) list: Vec<Entry>,
    /// The ways to them.
    pub(super) trail: Trail,
    /// The beam that they are for, and what was small then.
    beam: Option<Beam>,
    small: Option<Footprint>,
}

/// A super-node that a beam may look into.
struct Candidate {
    way: u32,
    number: u32,
    /// The beam in its frame.
    beam: Beam,
    /// How many times as large it is as the beam is wide there.
    size: f64,
    /// Where rays begin if it is not looked into: with its box.
    entry: Entry,
}

/// An item of a super-node that a beam meets.
struct Met {
    item: usize,
    entry: Entry,
    /// How many times as large it is as the beam is wide there.
    size: f64,
}

impl Sight {
    const ALL: Self = Self { near: 0.0, window: Window::ALL };
}

impl Window {
    const ALL: Self = Self { min: DVec2::NEG_INFINITY, max: DVec2::INFINITY };

    /// Whether it has anything in common with another one.
    fn meets(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

impl Beam {
    /// How many times as large a box is as the beam is wide at t.
    fn times(&self, bounds: &Aabb, t: f64) -> f64 {
        let [low, high] = self.range();
        bounds.size().length() / (t * (high - low).length())
    }

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

    /// From a vector to x, x · u and x · v, where it is x · (corner + u · across + v · down).
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
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for direction in directions {
            let along = inverse * direction;
            let place = along.yz() / along.x;
            // A beam as flat as a sheet or a line tells no places apart.
            if !(along.x > 0.0 && place.is_finite()) {
                return Window::ALL;
            }
            (min, max) = (min.min(place), max.max(place));
        }
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
    /// Where all rays begin; nowhere if there is nothing.
    fn root(held: &Held<'_>) -> Option<Self> {
        let child = held.block(ROOT).supers[0].root?;
        Some(Self { way: START, number: 0, child, slot: None, sight: Sight::ALL })
    }

    /// Whether rays in a window may meet anything there.
    pub(super) fn is_seen(&self, window: &Window) -> bool {
        self.sight.window.meets(window)
    }

    /// No ray of the beam meets anything there before that t.
    pub(super) fn near(&self) -> f64 {
        self.sight.near
    }
}

impl Candidate {
    /// The items in it that the beam meets, unless there are more than `most`.
    fn met(&self, held: &Held<'_>, hits: &Hits, most: usize) -> Option<Vec<Met>> {
        let Self { way, number, .. } = *self;
        let block = held.block(hits.block(way));
        let ball = &block.supers[number as usize];
        let drift = DRIFT * (self.beam.origin - ball.center).abs().element_sum();
        let mut met = Vec::new();
        let mut open = Vec::new();
        match ball.root.map(|root| (root, root.target())) {
            None => {}
            Some((child, Target::Item(item))) => {
                let entry = Entry { way, number, child, slot: None, ..self.entry };
                met.push(Met { item, entry, size: self.size });
            }
            Some((_, Target::Node(node))) => open.push(node),
        }
        while let Some(at) = open.pop() {
            let node = &block.nodes[at];
            for slot in node.slots() {
                let Aabb { min, max } = ball.bounds(node.bounds(slot));
                let bounds = Aabb { min: min - drift, max: max + drift };
                let Some(near) = self.beam.meets(&bounds) else { continue };
                match node.children[slot].target() {
                    Target::Node(below) => open.push(below),
                    Target::Item(_) if met.len() == most => return None,
                    Target::Item(item) => {
                        let sight = Sight { near, window: self.beam.window(&bounds) };
                        let entry = Entry { way, number, child: Child::node(at), slot: Some(slot), sight };
                        met.push(Met { item, entry, size: self.beam.times(&bounds, near) });
                    }
                }
            }
        }
        Some(met)
    }
}

impl Entries {
    /// Those of all rays: the root.
    pub(super) fn root(&mut self, held: &Held<'_>) {
        self.beam = None;
        self.list.clear();
        self.trail.clear();
        self.list.extend(Entry::root(held));
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
        let small = hits.detail.as_ref().map(Detail::footprint);
        if self.beam == Some(*beam) && self.small == small && self.trail.is_for(hits) {
            return;
        }
        (self.beam, self.small) = (Some(*beam), small);
        self.list.clear();
        hits.clear([0.0; LANES]);
        let root = Entry::root(held).map(|entry| {
            let Entry { way, number, .. } = entry;
            Candidate { way, number, beam: *beam, size: f64::INFINITY, entry }
        });
        let mut open: Vec<_> = root.into_iter().collect();
        // The largest is looked into first.
        while let Some(at) = (0..open.len()).max_by(|a, b| open[*a].size.total_cmp(&open[*b].size)) {
            let next = open.swap_remove(at);
            let room = MOST - self.list.len() - open.len();
            let met = if hits.way_count() < FARTHEST { next.met(held, hits, room) } else { None };
            let Some(met) = met else {
                self.list.push(next.entry);
                continue;
            };
            let number = hits.block(next.way);
            let block = held.block(number);
            for Met { item: at, entry, size } in met {
                let item = &block.items[at];
                let is_small = |detail: &Detail| detail.hides_part(next.way, &block.parts[at], entry.near());
                let is_open = size > WIDE
                    && matches!(item.content, Content::Super(_) | Content::Gate(_))
                    && !hits.detail.as_ref().is_some_and(is_small);
                let inside = if is_open { held.inside_ahead(number, item.content) } else { None };
                let Some((below, _)) = inside else {
                    self.list.push(entry);
                    continue;
                };
                let way = hits.enter(Place::new(next.way, at), block, below);
                let number = if let Content::Super(number) = item.content { number } else { 0 };
                let beam = next.beam.transform(&item.item_from_super);
                open.push(Candidate { way, number, beam, size, entry });
            }
        }
        self.list.sort_by(|a, b| a.near().total_cmp(&b.near()));
        self.trail.keep(hits);
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::Camera;
    use crate::fast::lanes::transform;
    use crate::fast::sample::Dice;

    /// Whatever a ray of a beam comes to, the beam meets its box, no later, and sees it in the window of the ray: from narrow
    /// lenses and wide ones, in the corners of the picture, and in frames that are sheared and far away.
    #[test]
    fn beams_meet_what_their_rays_come_to() {
        let mut dice = Dice::at(DVec3::ONE);
        for fov in [1e-6, 0.1, 40.0, 150.0, 179.0] {
            let camera = Camera { eye: DVec3::new(3.0, -2.0, 1.0), target: DVec3::ZERO, up: DVec3::Z, fov };
            let lens = camera.lens(512, 300).unwrap();
            for (column, row) in [(0, 0), (496, 0), (0, 284), (496, 284), (256, 144), (511, 299)] {
                let beam = lens.beam(&(column..512.min(column + 16)), &(row..300.min(row + 16)));
                for number in 0..200 {
                    let mut throw = || dice.throw();
                    let size = [f64::from(512.min(column + 16) - column), f64::from(300.min(row + 16) - row)];
                    // Also along the edges of the beam.
                    let [x, y] = [throw(), throw()].map(|place| (2.0 * place - 0.5).clamp(0.0, 1.0 - 1e-12));
                    let ray = lens.ray(f64::from(column) + x * size[0], f64::from(row) + y * size[1]);
                    let t = [1e-3, 0.1, 1.0, 30.0, 1e3][number % 5];
                    let mut vector = || DVec3::new(throw(), throw(), throw()) - 0.5;
                    let turned = DMat3::from_cols(vector(), vector(), vector());
                    let inner_from_world = DAffine3 { matrix3: turned, translation: 1e3 * vector() };
                    let (ray, beam) = (transform(&ray, &inner_from_world), beam.transform(&inner_from_world));
                    // What is added in a search for the drift of rays.
                    let around = DVec3::splat(DRIFT * ray.origin.abs().element_sum());
                    let bounds = Aabb::new(ray.at(t) - around, ray.at(t) + around);
                    let near = beam.meets(&bounds).expect("the ray goes there");
                    assert!(near <= t, "at {fov}: {near} after {t}");
                    let window = beam.window_of([ray.direction].into_iter());
                    assert!(beam.window(&bounds).meets(&window), "at {fov}: {window:?} of {ray:?}");
                    // Also of one that is no more than its rays.
                    let flat = Beam { corner: ray.direction, across: DVec3::ZERO, ..beam };
                    let window = flat.window_of([ray.direction].into_iter());
                    assert!(flat.window(&bounds).meets(&window), "at {fov}: {window:?} of {ray:?}");
                }
            }
        }
    }
}
