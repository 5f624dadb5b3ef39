//! What exact boxes cost by the number of states, as a drawing. `cargo xtask figures` measures and draws it for the documents.

use crate::plot::{Curve, Drawing, Panel, Point, Style, Values, prefixed};

/// What all boxes of a scene cost.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Cost {
    /// The scene, in one of its sizes.
    pub scene: String,
    /// How many states it has.
    pub states: u32,
    /// The processor time that the boxes take.
    pub seconds: f64,
    /// The memory that they take.
    pub bytes: f64,
}

impl Cost {
    /// Of a scene of so many states.
    pub fn new(scene: impl Into<String>, states: u32, seconds: f64, bytes: f64) -> Self {
        Self { scene: scene.into(), states, seconds, bytes }
    }
}

/// How scenes are drawn, in the order in which they come, and where in the legend.
const STYLES: [(i32, Style); 4] =
    [(0, Style::GREEN), (150, Style::BLUE), (300, Style::ORANGE), (430, Style::PURPLE)];

/// Where the line to compare with is in the legend.
const GUIDE: i32 = 590;

/// What a state would cost on the line to compare with, in seconds and in bytes.
const A_STATE: [f64; 2] = [1e-6, 1e3];

/// Time and memory of scenes in several sizes over their states, both as logarithms, as an SVG file. Only the first four
/// scenes are drawn.
pub fn costs_drawing(costs: &[Cost], command: &str) -> String {
    let mut scenes: Vec<&str> = costs.iter().map(|cost| cost.scene.as_str()).collect();
    scenes.dedup();
    let scenes = || scenes.iter().zip(STYLES);
    let number = |states: u32| i32::try_from(states).unwrap_or(i32::MAX);
    let least = costs.iter().map(|cost| cost.states).min().unwrap_or(1);
    let most = costs.iter().map(|cost| cost.states).max().unwrap_or(1);
    let curves = |height: fn(&Cost) -> f64, a_state: f64| {
        let ends = [least, most].map(|states| (number(states), a_state * f64::from(states), false));
        let guide = Curve { style: Style::GUIDE, points: ends.into() };
        let scene = |(scene, (_, style)): (&&str, _)| {
            let costs = costs.iter().filter(|cost| cost.scene == **scene);
            let points = costs.map(|cost| -> Point { (number(cost.states), height(cost), true) });
            Curve { style, points: points.collect() }
        };
        std::iter::once(guide).chain(scenes().map(scene)).collect()
    };
    let [time, memory] = A_STATE;
    let legend = scenes().map(|(scene, (x, style))| (x, style, *scene));
    let legend: Vec<_> = legend.chain([(GUIDE, Style::GUIDE, "1 µs, 1 kB a state")]).collect();
    let drawing = Drawing {
        title: "What exact boxes cost: all states of a scene".to_owned(),
        command: command.to_owned(),
        legend: &legend,
        x_title: "states",
        values: Values::Logarithmic(number(least / 2)..number(most.saturating_mul(2))),
        panels: [
            Panel {
                title: "Processor time",
                curves: curves(|cost| cost.seconds, time),
                y_label: |seconds| prefixed(*seconds, ["µs", "ms", "s"], 1e-6),
                least: f64::INFINITY,
            },
            Panel {
                title: "Memory",
                curves: curves(|cost| cost.bytes, memory),
                y_label: |bytes| prefixed(*bytes, ["kB", "MB", "GB"], 1e3),
                least: f64::INFINITY,
            },
        ],
    };
    drawing.svg()
}
