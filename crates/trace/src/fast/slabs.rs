//! Boxes without their corners: slabs along the four diagonals of space, beside the three along the axes.
//!
//! The hull of a tetrahedron of balls fills a third of its box, and rays that come through the rest go down in vain. So the
//! children of a node can have the seven directions of \[KAY86\]: the slabs of their boxes, and those between the supports
//! of what is in them along the diagonals, from queries with a gap of their own. Where the box of a child is met, its slabs are
//! tested, too: by single rays, by the rays of a packet, and by the tube around these. Below operators there are none, nor where
//! states are not listed. How large a part is remains a matter of its box; but where that stands for it, its slabs do as well,
//! and how many rays a part stops is said of those that meet them.

use std::ops::{Add, Sub};

use csg_graph_bounds::{Aabb, Slabs as Hull};
use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask, f32x8, f32x16, mask32x16};
use glam::{DVec3, Vec3A, Vec4};

use super::line::{LEAST, Lines};
use super::tree::{Node, PADDING, Target, WIDTH};
use crate::narrow::narrow;

/// The diagonals of the cube. They are √3 long, and so are coordinates along them.
pub(super) const DIAGONALS: [DVec3; 4] = {
    let [_, _, _, diagonals @ ..] = Hull::<7>::DIRECTIONS;
    diagonals
};

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

/// A line in coordinates along the diagonals, as [`Line`](super::line::Line) is in those along the axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Diagonals {
    pub(super) inverse: Vec4,
    pub(super) near_offset: Vec4,
    pub(super) far_offset: Vec4,
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
            let reach = match node.children[slot].target() {
                Target::Item(item) => items[item - first],
                Target::Node(below) => all[below - first_node],
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

/// A vector's coordinates along the diagonals: of numbers, or of vectors of them.
#[inline(always)]
fn along<T: Copy + Add<Output = T> + Sub<Output = T>>([x, y, z]: [T; 3]) -> [T; 4] {
    [x + y + z, x + y - z, x - y + z, y + z - x]
}

impl Diagonals {
    /// The line through a point, and all that are no farther from it than `slack` along each axis.
    #[inline(always)]
    pub(super) fn new(origin: Vec3A, direction: Vec3A, slack: Vec3A) -> Self {
        let [origin, direction] = [origin, direction].map(|vector| Vec4::from(along(vector.to_array())));
        let least = Vec4::splat(LEAST);
        let direction = Vec4::select(direction.abs().cmplt(least), least.copysign(direction), direction);
        let inverse = Vec4::ONE / direction;
        let (offset, slack) = (-origin * inverse, slack.element_sum() * inverse.abs());
        Self { inverse, near_offset: offset - slack, far_offset: offset + slack }
    }
}

impl Lines<4> {
    /// The lines through points, and all that are no farther from these than `slack` along each axis.
    #[inline(always)]
    pub(super) fn set_diagonals<S: Simd>(
        &mut self,
        simd: S,
        origins: [f32x16<S>; 3],
        directions: [f32x16<S>; 3],
        slack: f32x16<S>,
    ) {
        self.set(simd, along(origins), along(directions), slack * 3.0);
    }
}

impl Slabs {
    /// What the slabs of a child leave of its box.
    pub(super) fn hull(&self, node: &Node, slot: usize) -> Hull<7> {
        let Aabb { min, max } = node.bounds(slot);
        let [min, max] = [(min, &self.least), (max, &self.most)].map(|(corner, planes)| {
            let [x, y, z] = corner.to_array();
            let [a, b, c, d] = planes.map(|planes| f64::from(planes[slot]));
            [x, y, z, a, b, c, d]
        });
        Hull { min, max }
    }

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

    /// Of the rays that meet the box of a child, between `near` and `far`, those that meet its slabs, too.
    #[inline(always)]
    pub(super) fn met_by<S: Simd>(
        &self,
        simd: S,
        slot: usize,
        lines: &Lines<4>,
        [mut near, mut far]: [f32x16<S>; 2],
    ) -> mask32x16<S> {
        for along in 0..4 {
            let inverse = lines.inverse[along].load(simd);
            let least = f32x16::splat(simd, self.least[along][slot]);
            let most = f32x16::splat(simd, self.most[along][slot]);
            // Rays whose coordinates along the axes rise and fall alike may differ here.
            let falls = inverse.simd_lt(f32x16::splat(simd, 0.0));
            let (near_plane, far_plane) = (falls.select(most, least), falls.select(least, most));
            near = near_plane.mul_add_precise(inverse, lines.near_offset[along].load(simd)).max(near);
            far = far_plane.mul_add_precise(inverse, lines.far_offset[along].load(simd)).min(far);
        }
        near.simd_le(far)
    }
}

#[cfg(test)]
mod tests {
    use csg_graph_bounds::Aabb;
    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::Ray;
    use crate::fast::compiled::SuperNode;
    use crate::fast::frame::{Narrow, NarrowRays};
    use crate::fast::lanes::LANES;
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
                let narrow = Narrow::new(ray, &ball, 0, 0, true).expect("it goes through the ball");
                let mut rays = NarrowRays::EMPTY;
                // Others of a packet, around it: all of them go through the tetrahedron.
                let spread = [0.0, 0.1, 1.0][round % 3];
                for lane in 0..LANES {
                    let aside = if lane == 0 { DVec3::ZERO } else { spread * vector() };
                    let through = cloud.iter().fold(DVec3::ZERO, |sum, corner| sum + *corner) / 4.0;
                    let through = if lane == 0 { ray.at(away) } else { through };
                    let direction = ray.direction + aside;
                    rays.rays.set(lane, &Ray { origin: through - away * direction, direction });
                }
                let (boxes, slabs, by_all, by_tube) = dispatch!(Level::new(), simd => {
                    let [low, high] = [f32::MIN, f32::MAX];
                    let (between, boxes) = crossed(simd, &nodes[0], &narrow.line, low, high);
                    let line = narrow.line.diagonals.as_ref().expect("there are slabs");
                    let met = slabs[0].met(simd, line, between, boxes);
                    rays.narrow(simd, &ball, (1 << LANES) - 1, true);
                    let lines = rays.diagonals.as_ref().expect("there are slabs");
                    let between = [low, high].map(|s| f32x16::splat(simd, s));
                    let by_all = slabs[0].met_by(simd, at, lines, between).to_bitmask();
                    let tube = rays.tube.expect("it is bounded");
                    let (between, boxes_of_tube) = crossed(simd, &nodes[0], &tube, low, high);
                    let line = tube.diagonals.as_ref().expect("there are slabs");
                    (boxes, met, by_all, slabs[0].met(simd, line, between, boxes_of_tube))
                });
                // The children of a node of eight are its items in their order.
                assert!(slabs & by_tube & 1 << at != 0, "{ray:?} goes through {through}");
                assert!(by_all == u64::from(u16::MAX), "all of {ray:?} go through {through}");
                turned_away += (boxes & !slabs).count_ones();
                all += boxes.count_ones();
            }
        }
        assert!(4 * turned_away > all - 200 * 8, "{turned_away} of {all}");
    }
}
