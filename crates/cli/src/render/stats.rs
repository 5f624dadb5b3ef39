//! What `render --stats` writes.

use std::time::Duration;

use csg_graph_trace::Counters;
use serde::Serialize;

use super::stage::Stage;
use crate::args::MethodArg;

/// Counts and times of a picture. The counts are the same on every machine and for any number of threads.
#[derive(Serialize)]
pub(super) struct Stats {
    scene: String,
    width: u32,
    height: u32,
    samples: u32,
    boxes: &'static str,
    primitives: String,
    rays: u64,
    shadow_rays: u64,
    nodes_visited: u64,
    box_tests: u64,
    boxes_missed: u64,
    primitive_tests: u64,
    deepest_recursion: u32,
    threads: usize,
    bounding_seconds: f64,
    tracing_seconds: f64,
}

impl Stats {
    pub(super) fn new(stage: &Stage, counters: &Counters, threads: usize, tracing_time: Duration) -> Self {
        Self {
            scene: stage.loaded.name.clone(),
            width: stage.settings.width,
            height: stage.settings.height,
            samples: stage.settings.samples,
            boxes: stage.method.map_or("none", MethodArg::name),
            primitives: stage.analysis.primitives.to_string(),
            rays: counters.rays,
            shadow_rays: counters.shadow_rays,
            nodes_visited: counters.nodes_visited,
            box_tests: counters.box_tests,
            boxes_missed: counters.boxes_missed,
            primitive_tests: counters.primitive_tests,
            deepest_recursion: counters.deepest_recursion,
            threads,
            bounding_seconds: stage.bounding_time.as_secs_f64(),
            tracing_seconds: tracing_time.as_secs_f64(),
        }
    }

    pub(super) fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("counts and times are plain numbers") + "\n"
    }
}
