//! How many lines go through boxes, and through what slabs leave of them.
//!
//! Of lines that are spread evenly, all directions and places being as likely, as many go through a convex body in a direction as
//! there is area of it to be seen: half of that of its faces, each by how far it is turned there, as the other half is behind.

use csg_graph_bounds::{Aabb, Slabs};
use glam::DVec3;

use crate::fast::compiled::Compiled;
use crate::fast::cover::{self, Cover};
use crate::fast::tree::Child;
use crate::narrow::narrow;

/// How many of evenly spread lines in a direction go through a box, for its length.
pub(in crate::fast) fn flux(bounds: &Aabb, direction: DVec3) -> f64 {
    let size = bounds.size();
    DVec3::new(size.y * size.z, size.z * size.x, size.x * size.y).dot(direction.abs())
}

/// What slabs leave of a box, by what is seen of its faces.
#[derive(Clone, Debug)]
pub(in crate::fast) struct Outline([DVec3; 7]);

impl Outline {
    /// That of slabs in a unit of some length.
    fn new(slabs: &Slabs<7>, unit: f64) -> Self {
        let areas = slabs.face_areas().map(|area| area * unit * unit);
        Self(std::array::from_fn(|at| 0.5 * areas[at] * Slabs::<7>::DIRECTIONS[at].normalize()))
    }

    /// How many of evenly spread lines in a direction go through it, for its length.
    pub(in crate::fast) fn flux(&self, direction: DVec3) -> f64 {
        self.0.iter().map(|face| face.dot(direction).abs()).sum()
    }

    /// The cover of lines that meet the slabs, by that of lines through the box: fewer, of which more are stopped.
    pub(super) fn narrow(&self, bounds: &Aabb, cover: &mut Cover) {
        for (cell, share) in cover.cells.iter_mut().enumerate() {
            let [of_box, of_outline] = cover::directions_in(cell).fold([0.0; 2], |sum, direction| {
                [sum[0] + flux(bounds, direction), sum[1] + self.flux(direction)]
            });
            *share = narrow((f64::from(*share) * of_box / of_outline).min(1.0));
        }
    }
}

impl Compiled {
    /// The outlines of all children of nodes that have slabs, in the frames of their super-nodes.
    pub(in crate::fast) fn outlines(&self) -> Vec<(Child, Outline)> {
        let mut outlines = Vec::new();
        for (number, ball) in (0..).zip(&self.supers) {
            for node in self.nodes_of(number).into_iter().map(|at| &self.nodes[at]) {
                let Some(slabs) = self.slabs.get(node.slabs as usize) else { continue };
                let of_child = |slot| Outline::new(&slabs.hull(node, slot), ball.radius);
                outlines.extend(node.slots().map(|slot| (node.children[slot], of_child(slot))));
            }
        }
        outlines
    }
}
