//! `pcsg bounds --plot`: the growth of boxes as a drawing, as Fig. 2.1 of [TRAX95] shows it for two steps.
//!
//! Two panels share the axis of the parameter: how much larger than the exact one each algorithm's root box is, and how
//! many boxes the algorithm computes for it. Both are counted, not timed, so that the same scene gives the same bytes
//! everywhere. The number of boxes is known without computing them; a marker says that they were.

use csg_graph::BigUint;

use super::sweep::{Sample, Samples};
use crate::args::{MethodArg, Sweep};
use crate::plot::{Curve, Drawing, Panel, Point, Style, Values, power};

/// Counts of boxes beyond this leave the panel.
const MOST_BOXES: f64 = 1e12;

const CONVENTIONAL: Style = Style::ORANGE;
const CHAIN: Style = Style::BLUE;
const EXACT: Style = Style::GREEN;

/// What the drawing says besides the samples.
pub(super) struct Caption {
    pub(super) scene: String,
    /// The command that draws it.
    pub(super) command: String,
}

/// The drawing as an SVG file.
pub(super) fn svg(samples: &Samples, sweep: &Sweep, caption: Caption) -> String {
    let growth = |method| -> Vec<Point> {
        let point = |sample: &Sample| Some((sample.value, sample.growth(method)?, true));
        samples.samples.iter().filter_map(point).collect()
    };
    let boxes = |method| -> Vec<Point> {
        let point =
            |sample: &Sample| (sample.value, number(&sample.boxes(method)), sample.run(method).is_some());
        samples.samples.iter().map(point).take_while(|(_, boxes, _)| *boxes <= MOST_BOXES).collect()
    };
    // The exact boxes are often drawn over by those of the chain.
    let curves = |points: &dyn Fn(MethodArg) -> Vec<Point>| {
        let back_to_front =
            [(EXACT, MethodArg::Exact), (CONVENTIONAL, MethodArg::Conventional), (CHAIN, MethodArg::Chain)];
        back_to_front.map(|(style, method)| Curve { style, points: points(method) }).into()
    };
    let drawing = Drawing {
        title: format!("How boxes grow: {}", caption.scene),
        command: caption.command,
        legend: &[
            (0, CONVENTIONAL, "conventional: box of a box"),
            (250, CHAIN, "chain: box of mapped points"),
            (510, EXACT, "exact: one box a state"),
        ],
        x_title: &sweep.name,
        values: Values::Linear(sweep.first..sweep.last),
        panels: [
            Panel {
                title: "Volume of the root box, relative to the exact one",
                curves: curves(&growth),
                y_label: |ratio| format!("{ratio}×"),
                least: 1.0,
            },
            Panel {
                title: "Boxes computed (no marker: counted, not computed)",
                curves: curves(&boxes),
                y_label: power,
                least: 1.0,
            },
        ],
    };
    drawing.svg()
}

fn number(count: &BigUint) -> f64 {
    count.to_string().parse().expect("digits are a number")
}
