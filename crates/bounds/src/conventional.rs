//! The conventional algorithm ([TRAX95] §2): a T-node's box is the box of the transformed box from below.
//!
//! It is the one of CSG trees and of most renderers, and costs eight mapped corners a T-node. A box that is turned needs
//! a larger box about it, which is turned again by the next T-node: with every rotation by 45° it doubles. The paper's
//! Fig. 2.1 shows this; the example `growth` prints it. Under translations, scalings, mirrors and quarter turns there is
//! no growth, and the boxes are those of the chain algorithm.

use crate::walk::{Method, walk};
use crate::{Aabb, BoundsError, HyperBoxes, Limits, Scene, Shape};

/// Boxes of boxes, for the root and every node.
///
/// Each encloses its solid, rounding included, and may be much larger where rotations or shears follow each other.
///
/// # Cost
/// Time in proportion to the number of nodes of the unfolded tree, memory to its depth.
///
/// # Errors
/// If the scene fails to expand a state, or the unfolded tree exceeds the limits.
///
/// # Panics
/// If the scene numbers a node at or above its [`node_count`](Scene::node_count).
pub fn conventional<S: Scene>(scene: &S, limits: &Limits) -> Result<HyperBoxes, BoundsError<S::Error>> {
    walk(scene, limits, Conventional { maps: Vec::new() })
}

/// The maps of the T-nodes that have begun and not ended.
struct Conventional<M> {
    maps: Vec<M>,
}

impl<S: Scene> Method<S> for Conventional<S::Map> {
    fn shape(&mut self, shape: &S::Shape) -> Aabb {
        shape.bounds()
    }

    fn enter(&mut self, parent_from_child: S::Map) {
        self.maps.push(parent_from_child);
    }

    fn leave(&mut self, below: Aabb) -> Aabb {
        let parent_from_child = self.maps.pop().expect("a T-node that ends has begun");
        below.image(&parent_from_child)
    }

    fn frames(&self) -> usize {
        1
    }

    fn held(&self) -> usize {
        self.maps.len()
    }
}
