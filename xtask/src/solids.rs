//! What early exit saves below ∩ and \: `pcsg bench` of `scenes/solids` by the fast engine and by the reference walk, as a
//! table.
//!
//! The walk is pure span evaluation: with the least hyper box of each node, all boundaries of all operands on the whole
//! line. The table is of counts, which are the same on every machine.

use std::fmt;
use std::ops::Add;
use std::process::ExitCode;

use serde_json::Value;

use crate::exit_code;
use crate::peers::{PeersError, bench, object};

/// The scenes, and what is set in them.
const SCENES: [(&str, &[&str]); 9] = [
    ("solids/plate", &["n=4"]),
    ("solids/plate", &["n=6"]),
    ("solids/thread", &["n=8"]),
    ("solids/thread", &["n=11"]),
    ("solids/onion", &["n=41", "skin=0.97", "gap=0.985", "cut=0"]),
    ("solids/onion", &["n=41", "skin=0.97", "gap=0.985", "cut=1"]),
    ("solids/fractals", &["n=4", "m=6"]),
    ("solids/tower", &["n=14"]),
    ("cheese", &["n=5"]),
];

/// How large the picture is.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Width and height in pixels; each pixel has one ray
    #[arg(long, value_name = "WxH", default_value = "128x128")]
    size: String,
}

/// Tests that a ray takes on the average, by spans and by the fast engine.
#[derive(Clone, Copy, Default)]
struct Tests {
    spans: f64,
    fast: f64,
}

impl Add for Tests {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { spans: self.spans + other.spans, fast: self.fast + other.fast }
    }
}

impl fmt::Display for Tests {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.1} | {:.1} | {:.1}", self.spans, self.fast, self.spans / self.fast)
    }
}

/// Runs both. The table goes to the standard output; its last row is of a ray through each of the scenes.
#[expect(clippy::print_stdout, reason = "the report of a chore")]
pub fn run(options: &Options) -> ExitCode {
    let report = || -> Result<(), PeersError> {
        println!(
            "| scene | primitives | primitive tests, spans | fast | ratio | all tests, slowest 1 %, spans | fast | ratio |"
        );
        println!("|---|---:|---:|---:|---:|---:|---:|---:|");
        let mut together = [Tests::default(); 2];
        for (scene, set) in SCENES {
            let Comparison { primitives, all, slowest } = compare(options, scene, set)?;
            println!("| `{scene}` {} | {primitives} | {all} | {slowest} |", set.join(" "));
            together = [together[0] + all, together[1] + slowest];
        }
        let [all, slowest] = together;
        println!("| together | | {all} | {slowest} |");
        Ok(())
    };
    exit_code(report())
}

/// What the two take in a scene.
struct Comparison {
    primitives: String,
    /// Tests of primitives.
    all: Tests,
    /// Tests of boxes and primitives, of the hundredth of the rays with the most.
    slowest: Tests,
}

fn compare(options: &Options, scene: &str, set: &[&str]) -> Result<Comparison, PeersError> {
    let report = |engine: &[&str]| {
        let mut command = bench(scene, set);
        object(command.args(["--size", &options.size, "--reps", "1"]).args(engine))
    };
    let spans = report(&["--engine", "reference", "--boxes", "exact"])?;
    let fast = report(&["--engine", "fast"])?;
    let count = |report: &Value, fields: &[&str]| -> f64 {
        fields.iter().map(|field| report[field].as_f64().unwrap_or(f64::NAN)).sum()
    };
    let both = |fields: &[&str]| Tests { spans: count(&spans, fields), fast: count(&fast, fields) };
    let primitives = fast["primitives"].as_str().unwrap_or_default().to_owned();
    let slowest = ["slowest_box_tests_per_ray", "slowest_primitive_tests_per_ray"];
    Ok(Comparison { primitives, all: both(&["primitive_tests_per_ray"]), slowest: both(&slowest) })
}
