//! What a picture takes by `--memory`, as a drawing. `cargo xtask figures` measures and draws it for the documents.

use crate::plot::{Curve, Drawing, Panel, Point, Style, Values, prefixed};

/// What a process took that made a picture within a budget.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Budgeted {
    /// The scene.
    pub scene: String,
    /// The budget is two to this power, in bytes.
    pub log2_memory: u8,
    /// The processor time of the process.
    pub seconds: f64,
    /// The most bytes that it held.
    pub peak: f64,
}

impl Budgeted {
    /// Of a scene and a budget, two to this power.
    pub fn new(scene: impl Into<String>, log2_memory: u8, seconds: f64, peak: f64) -> Self {
        Self { scene: scene.into(), log2_memory, seconds, peak }
    }
}

/// How scenes are drawn, in the order in which they come, and where in the legend.
const STYLES: [(i32, Style); 2] = [(0, Style::GREEN), (200, Style::ORANGE)];

/// Where the line to compare with is in the legend.
const GUIDE: i32 = 430;

/// Time and peak of the memory of scenes over the budget, all as logarithms, as an SVG file. Only the first two scenes are
/// drawn.
pub fn budgets_drawing(runs: &[Budgeted], command: &str) -> String {
    let mut scenes: Vec<&str> = runs.iter().map(|run| run.scene.as_str()).collect();
    scenes.dedup();
    let least = runs.iter().map(|run| run.log2_memory).min().unwrap_or(0);
    let most = runs.iter().map(|run| run.log2_memory).max().unwrap_or(1);
    let curves = |height: fn(&Budgeted) -> f64| {
        let scenes = scenes.iter().zip(STYLES).map(move |(scene, (_, style))| {
            let runs = runs.iter().filter(|run| run.scene == **scene);
            let points = runs.map(|run| -> Point { (run.log2_memory.into(), height(run), true) });
            Curve { style, points: points.collect() }
        });
        scenes.collect::<Vec<_>>()
    };
    let budget = [least, most].map(|power| -> Point { (power.into(), libm::exp2(power.into()), false) });
    let mut peaks = vec![Curve { style: Style::GUIDE, points: budget.into() }];
    peaks.extend(curves(|run| run.peak));
    let legend = scenes.iter().zip(STYLES).map(|(scene, (x, style))| (x, style, *scene));
    let legend: Vec<_> = legend.chain([(GUIDE, Style::GUIDE, "as much as the budget")]).collect();
    let drawing = Drawing {
        title: "What a picture takes, by the memory that it may take".to_owned(),
        command: command.to_owned(),
        legend: &legend,
        x_title: "--memory",
        values: Values::Bytes(least.into()..most.into()),
        panels: [
            Panel {
                title: "Processor time of the whole process",
                curves: curves(|run| run.seconds),
                y_label: |seconds| prefixed(*seconds, ["µs", "ms", "s"], 1e-6),
                least: f64::INFINITY,
            },
            Panel {
                title: "Peak of its memory",
                curves: peaks,
                y_label: |bytes| prefixed(*bytes, ["kB", "MB", "GB"], 1e3),
                least: f64::INFINITY,
            },
        ],
    };
    drawing.svg()
}
