//! Parts that are too small to be seen, and what stands for them.
//!
//! A part that covers less than some share of a pixel need not be looked into: its box in the frame of its super-node
//! stands for it. That is what makes recursion that never ends a picture, and what keeps the cost of one that hardly ever
//! ends to what is in sight. The box holds the part and touches it on all sides, so that a silhouette is off by no more
//! than its size.
//!
//! How large a box is in the world is a matter of all transformations on the way to it. What they do to lengths, the
//! *stretch*, is kept for each way while rays have a [`Footprint`]. It is in single precision, rounded alike on every
//! machine, since on its last digits depends whether a part is looked into. So a node of a tree or an item is judged by one
//! comparison, of its diagonal with the footprint where the ray meets its box.
//!
//! It is measured how many rays a part stops: [before the first ray](super::survey) of what is compiled at once, and of what is
//! compiled on demand, [when one comes to it](super::survey::demand). A ray goes through what it meets of such parts until they
//! cover more than some number by chance that it has: so they are as light as they are. [Operators](super::solid) ask in any
//! order, and for each part again and again. Below them, each stops a ray or not by a number that the two of them have.

use csg_graph_bounds::Aabb;
use glam::{DVec3, Mat3, Mat3A, Vec3, Vec3A};

use super::compiled::{Compiled, Content, Item, SuperNode};
use super::cover::behind;
use super::held::Held;
use super::hits::Place;
use super::lanes::LANES;
use super::sample::Dice;
use super::survey::outline::{Outline, flux};
use super::tree::{Child, Target};
use crate::Ray;
use crate::narrow::narrow;
use crate::shapes::Extents;

/// The size of a pixel along a ray: at t, `width + spread · t`, in units of the world.
///
/// Rays through pixels have no width where they start and spread with the distance; those that leave a surface have the
/// width that the first ones have come to there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Footprint {
    /// Where the ray begins.
    pub width: f64,
    /// And how much more with each unit of t.
    pub spread: f64,
}

impl Footprint {
    /// That of a line.
    pub const LINE: Self = Self { width: 0.0, spread: 0.0 };

    /// The size at t.
    pub fn at(&self, t: f64) -> f64 {
        self.width + self.spread * t
    }

    /// That of rays that leave what this one has come to at t.
    #[must_use]
    pub fn onward(&self, t: f64) -> Self {
        Self { width: self.at(t), spread: 0.0 }
    }
}

/// How large an item is.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Its box in the frame of its super-node.
    pub(super) bounds: Aabb,
    /// The diagonal of that. A primitive is never small: there is nothing in it to look into.
    pub(super) size: f32,
    /// The linear part of the map from the frame of the item, how many times as long it makes a vector at most, and whether
    /// it does so with all.
    super_from_item: Mat3,
    most: f32,
    is_similar: bool,
    /// Whether nothing stands for it, since no line has met it that measured what is small.
    pub(super) is_unseen: bool,
    /// How many of the rays that meet the box, and its slabs if it has some, are stopped: its place among the covers, if that
    /// was measured.
    pub(super) cover: u32,
    /// What slabs leave of the box, if it has some and is measured when rays come to it.
    pub(super) outline: Option<Box<Outline>>,
}

impl Part {
    fn new(item: &Item) -> Self {
        let super_from_item = item.item_from_super.matrix3.inverse().as_mat3();
        let most = largest(&Mat3A::from(super_from_item));
        // Of a similarity, all columns are as long, and upright on each other.
        let excess =
            super_from_item.transpose() * super_from_item - Mat3::from_diagonal(Vec3::splat(most * most));
        let is_similar = excess.to_cols_array().iter().all(|entry| entry.abs() <= 1e-5 * most * most);
        Self {
            bounds: Aabb::ALL,
            size: f32::INFINITY,
            super_from_item,
            most,
            is_similar,
            is_unseen: false,
            cover: u32::MAX,
            outline: None,
        }
    }

    /// The share of the rays through its box that meet what slabs leave of it.
    fn outlined(&self, direction: DVec3) -> f32 {
        let share = |outline: &Outline| narrow(outline.flux(direction) / flux(&self.bounds, direction));
        self.outline.as_deref().map_or(1.0, share)
    }
}

/// What is needed to judge how large a part is seen.
#[derive(Clone, Debug)]
pub(super) struct Detail {
    footprint: Footprint,
    /// What is smaller than that is small even if nothing stands for it.
    finest: Footprint,
    ways: Vec<Stretch>,
    /// Of each ray of a packet that has come to anything small: what share of such rays is left, and at what share it is
    /// stopped.
    left: [Option<[f32; 2]>; LANES],
}

/// What the linear part of a map does to sizes: a similarity, which comes last, and what there is before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    /// How many times as long the similarity makes a vector.
    scale: f32,
    /// What is before it, unless all of it is a similarity.
    before: Option<Mat3A>,
    /// How many times as long a vector becomes at most.
    most: f32,
}

impl Stretch {
    const NONE: Self = Self { scale: 1.0, before: None, most: 1.0 };

    /// That of an item below.
    #[inline(always)]
    fn then(&self, part: &Part) -> Self {
        let before = match self.before {
            None if part.is_similar => {
                let scale = self.scale * part.most;
                return Self { scale, before: None, most: scale };
            }
            None => Mat3A::from(part.super_from_item),
            Some(before) => before * Mat3A::from(part.super_from_item),
        };
        let most = if self.before.is_none() { part.most } else { largest(&before) };
        Self { scale: self.scale, before: Some(before), most: self.scale * most }
    }

    /// How long a vector becomes.
    fn length(&self, vector: Vec3A) -> f32 {
        self.scale * self.before.map_or(vector, |before| before * vector).length()
    }
}

/// The largest singular value, from above: exact where all directions are stretched alike.
fn largest(map: &Mat3A) -> f32 {
    let Mat3A { x_axis: x, y_axis: y, z_axis: z } = *map;
    let [xy, yz, zx] = [x.dot(y), y.dot(z), z.dot(x)].map(f32::abs);
    let rows = [x.length_squared() + xy + zx, y.length_squared() + xy + yz, z.length_squared() + yz + zx];
    rows[0].max(rows[1]).max(rows[2]).sqrt()
}

impl Detail {
    pub(super) fn new() -> Self {
        Self { footprint: Footprint::LINE, finest: Footprint::LINE, ways: Vec::new(), left: [None; LANES] }
    }

    /// What is not larger than that is small; what nothing stands for, if it is not larger than the finest.
    pub(super) fn set_footprint(&mut self, small: Footprint, finest: Footprint) {
        (self.footprint, self.finest) = (small, finest);
    }

    /// What is small.
    pub(super) fn footprint(&self) -> Footprint {
        self.footprint
    }

    /// At the root, with other rays.
    pub(super) fn clear(&mut self) {
        self.left = [None; LANES];
        self.ways.clear();
        self.ways.push(Stretch::NONE);
    }

    /// What is known of all ways.
    pub(super) fn stretches(&self) -> &[Stretch] {
        &self.ways
    }

    /// Goes on from ways of which that is known.
    pub(super) fn follow(&mut self, stretches: &[Stretch]) {
        self.ways.clear();
        self.ways.extend_from_slice(stretches);
    }

    /// Puts what is known of a way where another one was.
    pub(super) fn move_way(&mut self, from: u32, to: usize) {
        self.ways[to] = self.ways[from as usize];
    }

    /// Forgets the ways from one on.
    pub(super) fn forget(&mut self, first: usize) {
        self.ways.truncate(first);
    }

    /// Goes on from a way into an item. Not inlined, so that it is not in the way of rays without detail.
    #[inline(never)]
    pub(super) fn enter(&mut self, above: u32, part: &Part) {
        self.ways.push(self.ways[above as usize].then(part));
    }

    /// Whether what has that size in the super-node of a way is too small to be looked into at t.
    #[inline(always)]
    pub(super) fn hides(&self, way: u32, size: f32, t: f64) -> bool {
        f64::from(size * self.ways[way as usize].most) <= self.footprint.at(t)
    }

    /// Whether an item is too small for a ray in its super-node to look into.
    pub(super) fn is_small(&self, block: &Compiled, place: Place, ray: &Ray) -> bool {
        let part = &block.parts[place.item as usize];
        self.hides_part(place.way, part, closest(ray, part.bounds.center()).max(0.0))
    }

    /// Whether a part of the super-node of a way is too small to be looked into at t. Where directions are not stretched
    /// alike, a flat box may be much smaller than its diagonal would be at most.
    #[inline(always)]
    pub(super) fn hides_part(&self, way: u32, part: &Part, t: f64) -> bool {
        let stretch = &self.ways[way as usize];
        let small = if part.is_unseen { &self.finest } else { &self.footprint }.at(t);
        f64::from(part.size * stretch.most) <= small
            || part.size.is_finite()
                && stretch.before.is_some_and(|before| {
                    let half = (part.bounds.size() * 0.5).as_vec3a();
                    let reach = before.abs() * half;
                    f64::from(2.0 * stretch.scale * reach.length()) <= small
                })
    }

    /// Whether a ray is stopped by what stops some share of the rays, and stops them with others as `apart` says. What a ray
    /// may go through is the same for all that it meets.
    pub(super) fn stops(&mut self, lane: usize, ray: &Ray, cover: f32, apart: f32) -> bool {
        let [left, patience] = self.left[lane].get_or_insert_with(|| [1.0, narrow(Dice::of(ray).throw())]);
        *left = behind(*left, cover, apart);
        *left < *patience
    }

    /// Where a ray in the super-node of an operand is in the box of a small item, if what is in there stops it. What stops
    /// rays side by side with others does so in any case: what it lets through, one of these would stop.
    pub(super) fn extents(&self, held: &Held<'_>, number: u32, place: Place, ray: &Ray) -> Extents {
        let part = &held.block(number).parts[place.item as usize];
        let extents = extents(&part.bounds, ray);
        let [[near, _], _] = extents;
        if extents == Extents::default() || self.leaves(place.way, ray, near.max(0.0)) {
            return Extents::default();
        }
        let stops = held.cover(number, Child::item(place.item as usize), ray.direction).is_none_or(
            |[cover, apart]| {
                let cover = cover * part.outlined(ray.direction);
                narrow(Dice::of_part(ray, place.item).throw()) < cover + apart.max(0.0) * (1.0 - cover)
            },
        );
        if stops { extents } else { Extents::default() }
    }

    /// Whether what a ray on a way meets at t is the place that it leaves.
    pub(super) fn leaves(&self, way: u32, ray: &Ray, t: f64) -> bool {
        let length = self.ways[way as usize].length(ray.direction.as_vec3a());
        t * f64::from(length) <= self.footprint.width
    }
}

/// Where a ray is closest to a point.
fn closest(ray: &Ray, point: DVec3) -> f64 {
    (point - ray.origin).dot(ray.direction) / ray.direction.length_squared()
}

/// Where a ray is in a box.
#[inline(never)]
fn extents(bounds: &Aabb, ray: &Ray) -> Extents {
    let [mut near, mut far] = [f64::NEG_INFINITY, f64::INFINITY];
    for axis in 0..3 {
        let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
        let [low, high] = [bounds.min[axis] - origin, bounds.max[axis] - origin];
        if direction == 0.0 {
            if low > 0.0 || high < 0.0 {
                return Extents::default();
            }
            continue;
        }
        let [one, other] = [low / direction, high / direction];
        near = near.max(one.min(other));
        far = far.min(one.max(other));
    }
    if near < far { [[near, far], [0.0; 2]] } else { Extents::default() }
}

impl Compiled {
    /// Keeps how large all items are, for rays that look into large ones only.
    pub(super) fn with_parts(mut self) -> Self {
        self.parts = self.items.iter().map(Part::new).collect();
        for ball in &self.supers {
            let mut open: Vec<usize> = ball.root.and_then(Child::as_node).into_iter().collect();
            while let Some(at) = open.pop() {
                let node = &self.nodes[at];
                for slot in node.slots() {
                    match node.children[slot].target() {
                        Target::Node(below) => open.push(below),
                        Target::Item(item) => {
                            let part = &mut self.parts[item];
                            part.bounds = ball.bounds(node.bounds(slot));
                            if !matches!(self.items[item].content, Content::Shape(_)) {
                                part.size = narrow(part.bounds.size().length());
                            }
                        }
                    }
                }
            }
        }
        self
    }

    /// Keeps what slabs leave of the boxes of all items.
    pub(super) fn with_outlines(mut self) -> Self {
        for (child, outline) in self.outlines() {
            if let Some(item) = child.as_item() {
                self.parts[item].outline = Some(Box::new(outline));
            }
        }
        self
    }

    /// Keeps how large the nodes of a block are as well, so that the box of one stands for what is in it, and what will be
    /// measured: these, and all solids. Below operators, nodes are not judged.
    pub(super) fn with_node_sizes(mut self) -> Self {
        let nodes = self.nodes_of(0);
        for at in &nodes {
            self.nodes[*at].size = narrow(self.node_bounds(0, *at).size().length());
        }
        let is_solid = |at: &usize| matches!(self.items[*at].content, Content::Solid(_));
        let solids = (0..self.items.len()).filter(is_solid);
        self.measured = nodes.into_iter().map(Child::node).chain(solids.map(Child::item)).collect();
        for (place, child) in (0..).zip(&self.measured) {
            match child.target() {
                Target::Node(node) => self.nodes[node].cover = place,
                Target::Item(item) => self.parts[item].cover = place,
            }
        }
        self
    }

    /// The box of a node of a super-node, in the frame of that.
    pub(super) fn node_bounds(&self, number: u32, at: usize) -> Aabb {
        let node = &self.nodes[at];
        let slots = node.slots().map(|slot| node.bounds(slot));
        self.supers[number as usize].bounds(slots.fold(Aabb::EMPTY, Aabb::join))
    }
}

impl SuperNode {
    /// A box in the unit ball in the frame of the state.
    pub(super) fn bounds(&self, unit: Aabb) -> Aabb {
        let [min, max] = [unit.min, unit.max].map(|corner| self.center + self.radius * corner);
        Aabb { min, max }
    }
}
