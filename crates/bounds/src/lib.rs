//! Placeholder.
mod aabb;
mod chain;
mod conventional;
#[cfg(feature = "csg-graph")]
mod csg_graph;
mod limits;
mod point_set;
mod rounding;
mod scene;
mod walk;

pub use aabb::Aabb;
pub use chain::chain;
pub use conventional::conventional;
pub use limits::{BoundsError, Limits};
pub use point_set::{EXCESS, PointSet};
pub use scene::{Map, Scene, Shape, Step};
pub use walk::HyperBoxes;
