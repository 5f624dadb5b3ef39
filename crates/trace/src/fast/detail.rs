//! Parts that are too small to be seen, and what stands for them.
//!
//! A part that covers less than some share of a pixel need not be looked into: its box in the frame of its super-node
//! stands for it. That is what makes recursion that never ends a picture, and what keeps the cost of one that hardly ever
//! ends to what is in sight. The box holds the part and touches it on all sides, so that a silhouette is off by no more
//! than its size.
//!
//! How large a box is in the world is a matter of all transformations on the way to it. Their product, the *stretch*, is
//! kept for each way while rays have a [`Footprint`], in single precision: it decides what is looked into, and nothing
//! that is seen depends on its last digits.

use csg_graph_bounds::Aabb;
use glam::{DVec3, Mat3A, Vec3A};

use super::compile::{Compiled, Content, Item};
use super::hits::Place;
use super::tree::WIDTH;
use crate::Ray;
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

/// What is needed to judge how large a part is seen.
#[derive(Clone, Debug)]
pub(super) struct Detail {
    footprint: Footprint,
    /// For each way, the linear part of the map from its super-node into the world.
    stretches: Vec<Mat3A>,
}

impl Detail {
    pub(super) fn new(footprint: Footprint) -> Self {
        Self { footprint, stretches: Vec::new() }
    }

    /// At the root.
    pub(super) fn clear(&mut self) {
        self.stretches.clear();
        self.stretches.push(Mat3A::IDENTITY);
    }

    /// Goes on from a way into an item.
    pub(super) fn enter(&mut self, above: u32, item: &Item) {
        let super_from_item = Mat3A::from(item.item_from_super.matrix3.inverse().as_mat3());
        self.stretches.push(self.stretches[above as usize] * super_from_item);
    }

    /// Whether an item is too small for a ray in its super-node to look into. There is nothing in a primitive to look into.
    pub(super) fn is_small(&self, block: &Compiled, place: Place, item: &Item, ray: &Ray) -> bool {
        if let Content::Shape(_) = item.content {
            return false;
        }
        let bounds = &block.extents[place.item as usize];
        let stretch = &self.stretches[place.way as usize];
        let half = (bounds.size() * 0.5).as_vec3a();
        let reach =
            stretch.x_axis.abs() * half.x + stretch.y_axis.abs() * half.y + stretch.z_axis.abs() * half.z;
        let t = closest(ray, bounds.center()).max(0.0);
        2.0 * f64::from(reach.length()) <= self.footprint.at(t)
    }

    /// Where a ray in a super-node is in the box of an item, but for what it leaves there.
    pub(super) fn extents(&self, block: &Compiled, place: Place, ray: &Ray) -> Extents {
        extents(&block.extents[place.item as usize], ray)
    }

    /// Whether what a ray on a way meets at t is the place that it leaves.
    pub(super) fn leaves(&self, way: u32, ray: &Ray, t: f64) -> bool {
        let direction: Vec3A = self.stretches[way as usize] * ray.direction.as_vec3a();
        t * f64::from(direction.length()) <= self.footprint.width
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
    /// Keeps the boxes of all items, for rays that look into large ones only.
    pub(super) fn with_extents(mut self) -> Self {
        self.extents = vec![Aabb::ALL; self.items.len()];
        for ball in &self.supers {
            let mut open: Vec<usize> = ball.root.and_then(|root| root.get().err()).into_iter().collect();
            while let Some(at) = open.pop() {
                let node = &self.nodes[at];
                for slot in 0..WIDTH.min(node.count as usize) {
                    match node.children[slot].get() {
                        Err(below) => open.push(below),
                        Ok(item) => {
                            let corner = |first: usize| {
                                let unit = DVec3::from_array(
                                    [0, 1, 2].map(|axis| f64::from(node.planes[first + axis][slot])),
                                );
                                ball.center + ball.radius * unit
                            };
                            self.extents[item] = Aabb { min: corner(0), max: corner(3) };
                        }
                    }
                }
            }
        }
        self
    }
}
