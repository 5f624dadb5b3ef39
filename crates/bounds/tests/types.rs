//! What every public type promises by being what it is: it goes to other threads and is shared between them.

use std::convert::Infallible;

use csg_graph_bounds::{
    Aabb, BoundsError, Cell, CellCounts, CertifiedSphere, Counts, Endless, ExactBoxes, HyperBoxes, Limits,
    Obb, PointSet, Refinement, Round, SBounds, Scene, Side, Slabs, SolidBox, SolidSearch, Sphere, StateBox,
    Step, Support, exact,
};
use glam::DAffine3;

/// The least scene there is.
struct Cube;

impl Scene for Cube {
    type State = ();
    type Map = DAffine3;
    type Shape = Aabb;
    type Error = Infallible;

    fn root(&self) {}

    fn step(&self, (): &()) -> Result<Step<Self>, Infallible> {
        Ok(Step::Shape(Aabb::from_points([glam::DVec3::NEG_ONE, glam::DVec3::ONE])))
    }

    fn node(&self, (): &()) -> usize {
        0
    }

    fn node_count(&self) -> usize {
        1
    }
}

#[test]
fn all_types_are_send_and_sync() {
    fn shared<T: Send + Sync>() {}
    shared::<(Aabb, Sphere, CertifiedSphere, Slabs<7>, Obb)>();
    shared::<(Limits, Round, Refinement, Cell, CellCounts, Side, BoundsError<Infallible>, PointSet<'_>)>();
    shared::<(HyperBoxes, ExactBoxes<Cube>, StateBox, Support, Counts, Endless)>();
    shared::<(SBounds<'_, Cube>, SolidSearch<'_, Cube>, SolidBox, Step<Cube>)>();
    #[cfg(feature = "csg-graph")]
    shared::<ExactBoxes<csg_graph::Graph>>();
}

#[test]
fn boxes_are_found_on_many_threads() {
    let boxes = exact(&Cube, &Limits::default()).expect("a cube has a box");
    std::thread::scope(|scope| {
        for axis in glam::DVec3::AXES {
            let boxes = &boxes;
            scope.spawn(move || assert!(boxes.support(&(), axis).is_some_and(|found| found.upper >= 1.0)));
        }
    });
}
