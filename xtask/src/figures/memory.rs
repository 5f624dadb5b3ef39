//! What pictures of vast scenes take by `--memory`, each measured in a process of its own: the peak of one can only grow.

use std::io;
use std::ops::RangeInclusive;

use csg_graph_cli::render::{Budgeted, budgets_drawing};
use serde_json::Value;

use crate::example::{cargo_run, printed};

/// Its name in `docs/figures`.
pub(super) const NAME: &str = "memory.svg";

/// What the scenes are called, and the arguments of `pcsg render`.
const SCENES: [(&str, &str); 2] = [
    ("forest, 160 × 100", "scenes/vast/forest.pcsg --size 160x100"),
    ("terrain, 320 × 200", "scenes/vast/terrain.pcsg --size 320x200"),
];

/// The budgets are two to these powers: 16M to 1G.
const LOG2_MEMORY: RangeInclusive<u8> = 24..=30;

/// Measures and draws, and tells each measurement: together they take minutes.
#[expect(clippy::print_stderr, reason = "the report of a chore")]
pub(super) fn drawing() -> io::Result<String> {
    let folder = tempfile::tempdir()?;
    let [picture, stats] = ["picture.png", "stats.json"].map(|name| folder.path().join(name));
    let mut runs = Vec::new();
    for (scene, arguments) in SCENES {
        for log2_memory in LOG2_MEMORY {
            let mut command = cargo_run("csg-graph-cli", ["--bin", "pcsg"]);
            command.arg("render").args(arguments.split_whitespace()).args(["--samples", "1"]);
            command.args(["--memory", &(1_u64 << log2_memory).to_string()]);
            printed(command.arg("--output").arg(&picture).arg("--stats").arg(&stats))?;
            let stats: Value = serde_json::from_slice(&std::fs::read(&stats)?)?;
            let number = |name: &str| {
                let untold = || io::Error::other(format!("the statistics do not tell {name}"));
                stats[name].as_f64().ok_or_else(untold)
            };
            let (seconds, peak) = (number("cpu_seconds")?, number("peak_memory")?);
            eprintln!("{scene}, --memory {}M: {seconds:.1} s, {:.0} MB", 1 << (log2_memory - 20), peak / 1e6);
            runs.push(Budgeted::new(scene, log2_memory, seconds, peak));
        }
    }
    let command =
        "pcsg render scenes/vast/SCENE.pcsg --size SIZE --samples 1 --memory BYTES --stats FILE.json";
    Ok(budgets_drawing(&runs, command))
}
