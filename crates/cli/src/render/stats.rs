//! What `render --stats` writes.

use std::time::Duration;

use csg_graph_trace::{Counters, Integrator, Settings};
use serde::Serialize;

use crate::args::{EngineArg, MethodArg};
use crate::process::Taken;
use crate::stage::Stage;

/// Counts and times of a picture. The counts are the same on every machine and for any number of threads.
#[derive(Serialize)]
pub(super) struct Stats {
    scene: String,
    width: u32,
    height: u32,
    /// The most of a pixel.
    samples: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<f64>,
    /// Those of all pixels together.
    samples_taken: u64,
    integrator: &'static str,
    bounces: u32,
    exposure: f64,
    engine: String,
    boxes: &'static str,
    /// What the engine takes besides the graph.
    bytes: usize,
    primitives: String,
    rays: u64,
    shadow_rays: u64,
    box_tests: u64,
    primitive_tests: u64,
    #[serde(flatten)]
    walked: Option<Walked>,
    threads: usize,
    bounding_seconds: f64,
    /// Bounding, and what else comes before the first ray.
    setup_seconds: f64,
    /// Of this run, if it goes on from another one.
    tracing_seconds: f64,
    /// Of the process, until the files are written.
    #[serde(flatten)]
    process: Taken,
}

/// What only the reference walk has.
#[derive(Serialize)]
struct Walked {
    nodes_visited: u64,
    boxes_missed: u64,
    deepest_recursion: u32,
}

impl Stats {
    pub(super) fn new(
        stage: &Stage<'_>,
        settings: &Settings,
        samples_taken: u64,
        counters: &Counters,
        threads: usize,
        tracing_time: Duration,
    ) -> Self {
        let prepared = &stage.prepared;
        let walked = Walked {
            nodes_visited: counters.nodes_visited,
            boxes_missed: counters.boxes_missed,
            deepest_recursion: counters.deepest_recursion,
        };
        Self {
            scene: stage.loaded.name.clone(),
            width: settings.width,
            height: settings.height,
            samples: settings.samples,
            noise: settings.noise,
            samples_taken,
            integrator: match settings.integrator {
                Integrator::Path => "path",
                _ => "direct",
            },
            bounces: settings.bounces,
            exposure: settings.exposure,
            engine: prepared.kind().to_string(),
            boxes: prepared.method.map_or("none", MethodArg::name),
            bytes: prepared.bytes(),
            primitives: stage.regime.primitives(),
            rays: counters.rays,
            shadow_rays: counters.shadow_rays,
            box_tests: counters.box_tests,
            primitive_tests: counters.primitive_tests,
            walked: (prepared.kind() == EngineArg::Reference).then_some(walked),
            threads,
            bounding_seconds: prepared.bounding_time.as_secs_f64(),
            setup_seconds: prepared.setup_time.as_secs_f64(),
            tracing_seconds: tracing_time.as_secs_f64(),
            process: Taken::now(),
        }
    }

    pub(super) fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("counts and times are plain numbers") + "\n"
    }
}
