//! A dag of as many states as one likes, which never was a grammar.

use std::convert::Infallible;

use csg_graph_bounds::{Aabb, Scene, Step};
use glam::{DAffine3, DVec3};

/// A recursion on numbers: every level holds two copies of the next, with three states a level.
pub(crate) struct Dag {
    pub(crate) levels: u32,
    /// By how much the copies are turned, in radians.
    pub(crate) turns: [f64; 2],
}

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Place {
    Level(u32),
    Copy(u32, bool),
}

impl Scene for Dag {
    type State = Place;
    type Map = DAffine3;
    type Shape = Aabb;
    type Error = Infallible;

    fn root(&self) -> Place {
        Place::Level(self.levels)
    }

    fn step(&self, place: &Place) -> Result<Step<Self>, Infallible> {
        Ok(match *place {
            Place::Level(0) => Step::Shape(Aabb::new(DVec3::NEG_ONE, DVec3::ONE)),
            Place::Level(n) => Step::Union(vec![Place::Copy(n, false), Place::Copy(n, true)]),
            Place::Copy(n, right) => {
                let side = if right { 0.7 } else { -0.6 };
                let parent_from_level = DAffine3::from_translation(DVec3::new(side, 0.2, 0.1))
                    * DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), self.turns[usize::from(right)])
                    * DAffine3::from_scale(DVec3::splat(0.6));
                Step::Map(parent_from_level, Place::Level(n - 1))
            }
        })
    }

    fn node(&self, place: &Place) -> usize {
        usize::from(matches!(place, Place::Copy(..)))
    }

    fn node_count(&self) -> usize {
        2
    }
}
