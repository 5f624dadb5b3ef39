//! A scene in the column.

use std::error::Error;
use std::path::Path;

use csg_graph::Graph;
use csg_graph_bounds::{ExactBoxes, Limits, exact};
use csg_graph_grammar::{Override, load};
use csg_graph_trace::Ray;
use glam::DVec3;

use crate::deformation::WIDTH;

/// A scene of the corpus with its boxes, and its place in the column: p ↦ foot + scale · p is what is there of it at p.
pub(crate) struct Column {
    pub(crate) graph: Graph,
    pub(crate) boxes: ExactBoxes<Graph>,
    pub(crate) foot: DVec3,
    pub(crate) scale: f64,
}

impl Column {
    pub(crate) fn load(name: &str, set: &str) -> Result<Self, Box<dyn Error>> {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
        let source = std::fs::read_to_string(scenes.join(name).with_extension("pcsg"))?;
        let overrides = [Override::parse(set).map_err(|_| "a mistake in the parameters")?];
        let graph = load(&source, &overrides).map_err(|_| "a mistake in the scene")?.scene.graph;
        let boxes = exact(&graph, &Limits::default())?;
        let (low, size) = (boxes.root.min, boxes.root.size());
        let foot = low + DVec3::new(size.x, size.y, 0.0) / 2.0;
        let scale = (size.x.max(size.y) / (2.0 * WIDTH)).max(size.z);
        Ok(Self { graph, boxes, foot, scale })
    }

    /// A ray of the column in the scene, with the same parameter.
    pub(crate) fn ray(&self, ray: Ray) -> Ray {
        Ray { origin: self.foot + ray.origin * self.scale, direction: ray.direction * self.scale }
    }
}
