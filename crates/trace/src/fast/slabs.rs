//! Boxes without their corners: slabs along the four diagonals of space, beside the three along the axes.
//!
//! The hull of a tetrahedron of balls fills a third of its box, and rays that come through the rest go down in vain. So the
//! children of a node can have the seven directions of \[KAY86\]: the slabs of their boxes, and those between the supports
//! of what is in them along the diagonals, which are as exact. A ray that goes alone, and has met boxes of a node, is tested
//! against these slabs, too. Packets are not: sixteen rays share a box for a fraction of what the diagonals of each
//! would cost. Nor are rays that judge how large things are, which is a matter of their boxes.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask, f32x8};
use glam::{DVec3, Vec3A, Vec4};

use super::frame::{LEAST, narrow};
use super::tree::{Node, PADDING, WIDTH};

/// The diagonals of the cube. They are √3 long, and so are coordinates along them.
pub(super) const DIAGONALS: [DVec3; 4] = [
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
];

/// Slabs are kept for nodes where they are narrower than the boxes by that, on the average.
const WORTHWHILE: f64 = 0.9;

/// How far slabs are padded, in units of the super-node's radius: coordinates along diagonals are sums of three, those of rays
/// in single precision.
const SLAB_PADDING: f64 = 4.0 * PADDING;

/// How far something reaches along the diagonals: its least and its greatest coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    pub(super) least: [f64; 4],
    pub(super) most: [f64; 4],
}

/// The slabs of the children of a node, side by side.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Slabs {
    least: [[f32; WIDTH]; 4],
    most: [[f32; WIDTH]; 4],
}

/// A line in coordinates along the diagonals, as [`Line`](super::frame::Line) is in those along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Diagonals {
    inverse: Vec4,
    near_offset: Vec4,
    far_offset: Vec4,
}

impl Reach {
    const NOWHERE: Self = Self { least: [f64::INFINITY; 4], most: [f64::NEG_INFINITY; 4] };

    fn join(self, other: Self) -> Self {
        Self {
            least: std::array::from_fn(|at| self.least[at].min(other.least[at])),
            most: std::array::from_fn(|at| self.most[at].max(other.most[at])),
        }
    }

    /// In a frame that has its origin at `center`, and `to_unit` for a unit.
    pub(super) fn in_unit(self, center: DVec3, to_unit: f64) -> Self {
        let along = |at: usize, reach: f64| (reach - center.dot(DIAGONALS[at])) * to_unit;
        Self {
            least: std::array::from_fn(|at| along(at, self.least[at])),
            most: std::array::from_fn(|at| along(at, self.most[at])),
        }
    }

    /// The widths of the slabs together.
    fn width(&self) -> f64 {
        (0..4).map(|at| self.most[at] - self.least[at]).sum()
    }
}

/// Gives those nodes behind `first_node` slabs for which these are worth their while. The items of the tree, the `first` and
/// those behind it, reach as far as that in its frame.
pub(super) fn add(
    nodes: &mut [Node],
    first_node: usize,
    first: usize,
    items: &[Reach],
    slabs: &mut Vec<Slabs>,
) {
    let mut all = vec![Reach::NOWHERE; nodes.len() - first_node];
    // What is below a node is behind it.
    for at in (first_node..nodes.len()).rev() {
        let node = &mut nodes[at];
        let mut of_node = Slabs { least: [[0.0; WIDTH]; 4], most: [[0.0; WIDTH]; 4] };
        let (mut width, mut box_width) = (0.0, 0.0);
        for slot in node.slots() {
            let reach = match node.children[slot].get() {
                Ok(item) => items[item - first],
                Err(below) => all[below - first_node],
            };
            all[at - first_node] = all[at - first_node].join(reach);
            width += reach.width();
            // The same for all diagonals.
            box_width += 4.0 * node.bounds(slot).size().element_sum();
            for along in 0..4 {
                of_node.least[along][slot] = narrow(reach.least[along] - SLAB_PADDING);
                of_node.most[along][slot] = narrow(reach.most[along] + SLAB_PADDING);
            }
        }
        // Neither if some are unbounded.
        if width < WORTHWHILE * box_width {
            node.slabs = u32::try_from(slabs.len()).expect("2³² nodes outgrow memory");
            slabs.push(of_node);
        }
    }
}

/// A vector's coordinates along the diagonals.
#[inline(always)]
fn along(vector: Vec3A) -> Vec4 {
    let [x, y, z] = vector.to_array();
    Vec4::new(x, x, x, -x) + Vec4::new(y, y, -y, y) + Vec4::new(z, -z, z, z)
}

impl Diagonals {
    /// The line through a point, and all that are no farther from it than `slack` along any axis.
    #[inline(always)]
    pub(super) fn new(origin: Vec3A, direction: Vec3A, slack: f32) -> Self {
        let (origin, direction, slack) = (along(origin), along(direction), 3.0 * slack);
        let least = Vec4::splat(LEAST);
        let direction = Vec4::select(direction.abs().cmplt(least), least.copysign(direction), direction);
        let inverse = Vec4::ONE / direction;
        let (offset, slack) = (-origin * inverse, slack * inverse.abs());
        Self { inverse, near_offset: offset - slack, far_offset: offset + slack }
    }
}

impl Slabs {
    /// Of the children whose boxes a line meets, between `near` and `far`, those where it meets the slabs, too.
    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "eight bits")]
    pub(super) fn met<S: Simd>(
        &self,
        simd: S,
        line: &Diagonals,
        [near, far]: [[f32; WIDTH]; 2],
        met: u32,
    ) -> u32 {
        let mut near = f32x8::from_slice(simd, &near);
        let mut far = f32x8::from_slice(simd, &far);
        for along in 0..4 {
            let inverse = f32x8::splat(simd, line.inverse[along]);
            let (mut near_planes, mut far_planes) = (&self.least[along], &self.most[along]);
            if line.inverse[along] < 0.0 {
                (near_planes, far_planes) = (far_planes, near_planes);
            }
            let near_planes = f32x8::from_slice(simd, near_planes);
            let far_planes = f32x8::from_slice(simd, far_planes);
            near =
                near_planes.mul_add_precise(inverse, f32x8::splat(simd, line.near_offset[along])).max(near);
            far = far_planes.mul_add_precise(inverse, f32x8::splat(simd, line.far_offset[along])).min(far);
        }
        near.simd_le(far).to_bitmask() as u32 & met
    }
}

#[cfg(test)]
mod tests {
    use csg_graph_bounds::Aabb;
    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::Ray;
    use crate::fast::compile::SuperNode;
    use crate::fast::frame::Narrow;
    use crate::fast::sample::Dice;
    use crate::fast::single::crossed;
    use crate::fast::tree;

    fn reach_of(points: &[DVec3]) -> Reach {
        points.iter().fold(Reach::NOWHERE, |all, point| {
            let along = DIAGONALS.map(|diagonal| diagonal.dot(*point));
            all.join(Reach { least: along, most: along })
        })
    }

    /// Rays in all directions through points of what is in the boxes: along axes and diagonals, too, and from far away.
    #[test]
    fn rays_through_what_is_in_boxes_meet_its_slabs() {
        let mut dice = Dice::at(DVec3::ONE);
        let (mut turned_away, mut all) = (0, 0);
        for round in 0..200 {
            let mut vector = || DVec3::new(dice.throw(), dice.throw(), dice.throw()) - 0.5;
            // Tetrahedra, some flat.
            let clouds: [[DVec3; 4]; WIDTH] = std::array::from_fn(|at| {
                let (middle, size) = (0.6 * vector(), if at % 2 == 0 { 0.3 } else { 0.01 });
                std::array::from_fn(|_| middle + size * vector())
            });
            let boxes = clouds.map(Aabb::from_points);
            let mut nodes = Vec::new();
            let root = tree::build(&boxes, 0, &mut nodes);
            let mut slabs = Vec::new();
            add(&mut nodes, 0, 0, &clouds.map(|cloud| reach_of(&cloud)), &mut slabs);
            assert!(root == tree::Child::node(0) && nodes[0].slabs == 0, "tetrahedra are worth it");
            let ball =
                SuperNode { center: DVec3::ZERO, radius: 1.0, to_unit: 1.0, reach: 1.0, root: Some(root) };
            for (at, cloud) in clouds.iter().enumerate() {
                let weights = vector() + 0.5;
                let through =
                    cloud[0].lerp(cloud[1], weights.x).lerp(cloud[2].lerp(cloud[3], weights.y), weights.z);
                let direction = match round % 3 {
                    0 => DVec3::AXES[at % 3],
                    1 => DIAGONALS[at % 4],
                    _ => vector(),
                };
                let away = [0.0, 1.0, 1e6][at % 3];
                let ray = Ray { origin: through - away * direction, direction };
                let found = Narrow::with_diagonals(ray, &ball, 0, 0, true);
                let (narrow, Some(diagonals)) = found.expect("it goes through the ball") else {
                    panic!("diagonals were wanted")
                };
                let (boxes, slabs) = dispatch!(Level::new(), simd => {
                    let (t, boxes) = crossed(simd, &nodes[0], &narrow.line, f32::MIN, f32::MAX);
                    (boxes, slabs[0].met(simd, &diagonals, t, boxes))
                });
                assert!(slabs & !boxes == 0);
                // The children of a node of eight are its items in their order.
                assert!(slabs >> at & 1 == 1, "{ray:?} goes through {through}");
                turned_away += (boxes & !slabs).count_ones();
                all += boxes.count_ones();
            }
        }
        assert!(4 * turned_away > all - 200 * 8, "{turned_away} of {all}");
    }
}
