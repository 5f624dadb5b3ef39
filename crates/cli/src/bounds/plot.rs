//! `pcsg bounds --plot`: the growth of boxes as a drawing, as Fig. 2.1 of [TRAX95] shows it for two steps.
//!
//! Two panels share the axis of the parameter: how much larger than the exact one each algorithm's root box is, and how
//! many boxes the algorithm computes for it. Both are counted, not timed, so that the same scene gives the same bytes
//! everywhere. The number of boxes is known without computing them; a marker says that they were.

use std::ops::Range;

use csg_graph::BigUint;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::sweep::{Sample, Samples};
use crate::args::{MethodArg, Sweep};

/// Width and height of the drawing, in pixels.
const SIZE: (u32, u32) = (860, 760);
/// Where the panels begin, and where the upper one ends.
const PANELS: [u32; 2] = [112, 440];
/// What is below the panels.
const FOOT: u32 = 44;

/// The left edge of all text, and of the panels' axis.
const LEFT: i32 = 24;
const AXIS: u32 = 76;

/// Colours that are told apart by all eyes, and in grey (Okabe and Ito's).
const CONVENTIONAL: RGBColor = RGBColor(0xD5, 0x5E, 0x00);
const CHAIN: RGBColor = RGBColor(0x00, 0x72, 0xB2);
const EXACT: RGBColor = RGBColor(0x00, 0x9E, 0x73);
const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const PALE_INK: RGBColor = RGBColor(0x66, 0x66, 0x66);
const GRID: RGBColor = RGBColor(0xE4, 0xE4, 0xE4);

/// Counts of boxes beyond this leave the panel.
const MOST_BOXES: f64 = 1e12;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// What the drawing says besides the samples.
pub(super) struct Caption {
    pub(super) scene: String,
    /// The command that draws it.
    pub(super) command: String,
}

/// The drawing as an SVG file.
pub(super) fn svg(samples: &Samples, sweep: &Sweep, caption: &Caption) -> String {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
    let drawn = draw(&area, samples, sweep, caption).and_then(|()| area.present());
    drawn.expect("drawing into a string does not fail");
    drop(area);
    text
}

fn draw(area: &Area<'_>, samples: &Samples, sweep: &Sweep, caption: &Caption) -> Drawn {
    area.fill(&WHITE)?;
    let Caption { scene, command } = caption;
    write(area, &format!("How boxes grow: {scene}"), (LEFT, 26), 21, INK)?;
    legend(area)?;
    write(area, command, (LEFT, SIZE.1.cast_signed() - 32), 11, PALE_INK)?;

    let (upper, lower) = area.margin(PANELS[0], FOOT, 0, 24).split_vertically(PANELS[1] - PANELS[0]);
    let values = sweep.first..sweep.last;
    let algorithms = [MethodArg::Conventional, MethodArg::Chain, MethodArg::Exact];
    let growth = |method| -> Vec<Point> {
        let point = |sample: &Sample| Some((sample.value, sample.growth(method)?, true));
        samples.samples.iter().filter_map(point).collect()
    };
    let boxes = |method| -> Vec<Point> {
        let point =
            |sample: &Sample| (sample.value, number(&sample.boxes(method)), sample.run(method).is_some());
        samples.samples.iter().map(point).take_while(|(_, boxes, _)| *boxes <= MOST_BOXES).collect()
    };
    let title = "Volume of the root box, relative to the exact one";
    panel(&upper, title, None, values.clone(), algorithms.map(growth), |ratio| format!("{ratio}×"))?;
    let title = "Boxes computed (no marker: counted, not computed)";
    panel(&lower, title, Some(&sweep.name), values, algorithms.map(boxes), |count| power(*count))
}

/// A value of the parameter, what is drawn there, and whether with a marker.
type Point = (i32, f64, bool);

fn panel(
    area: &Area<'_>,
    title: &str,
    x_title: Option<&str>,
    values: Range<i32>,
    curves: [Vec<Point>; 3],
    y_label: impl Fn(&f64) -> String,
) -> Drawn {
    write(area, title, (LEFT, 2), 14, INK)?;
    let highest = curves.iter().flatten().fold(1.0_f64, |highest, (_, y, _)| highest.max(*y));
    // Room above the highest marker and below the line at 1.
    let heights = 0.8..(highest * 1.5).max(10.0);
    let ticks = ticks(heights.end);
    let heights = heights.log_scale().with_key_points(ticks);
    let mut chart = ChartBuilder::on(area)
        .margin_top(30)
        .margin_left(LEFT)
        .x_label_area_size(if x_title.is_some() { 46 } else { 42 })
        .y_label_area_size(AXIS - LEFT.unsigned_abs())
        .build_cartesian_2d(values, heights)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(PALE_INK)
        .label_style(font(12, INK))
        .axis_desc_style(font(13, INK))
        .x_desc(x_title.unwrap_or_default())
        .y_label_formatter(&y_label)
        .draw()?;
    let [conventional, chain, exact] = curves;
    let line = |points: &[Point], colour: RGBColor, width| {
        LineSeries::new(points.iter().map(|(x, y, _)| (*x, *y)), colour.stroke_width(width))
    };
    let marked =
        |points: Vec<Point>| points.into_iter().filter(|(.., marked)| *marked).map(|(x, y, _)| (x, y));
    // The exact boxes are often drawn over by those of the chain, and are wide enough to be seen beneath.
    chart.draw_series(line(&exact, EXACT, 4))?;
    chart.draw_series(line(&conventional, CONVENTIONAL, 2))?;
    chart.draw_series(line(&chain, CHAIN, 2))?;
    chart.draw_series(marked(exact).map(|at| EmptyElement::at(at) + exact_marker()))?;
    chart.draw_series(marked(conventional).map(|at| EmptyElement::at(at) + conventional_marker()))?;
    chart.draw_series(marked(chain).map(|at| EmptyElement::at(at) + chain_marker()))?;
    Ok(())
}

fn exact_marker() -> Circle<(i32, i32), i32> {
    Circle::new((0, 0), 6, EXACT.filled())
}

fn conventional_marker() -> Rectangle<(i32, i32)> {
    Rectangle::new([(-4, -4), (4, 4)], CONVENTIONAL.filled())
}

fn chain_marker() -> TriangleMarker<(i32, i32), i32> {
    TriangleMarker::new((0, 0), 5, CHAIN.filled())
}

/// Where the axis of an upper end has its labels: seven at most.
fn ticks(end: f64) -> Vec<f64> {
    let decades: Vec<f64> =
        std::iter::successors(Some(1.0), |tick| Some(tick * 10.0)).take_while(|tick| *tick < end).collect();
    match decades.len() {
        0..=2 => decades
            .iter()
            .flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| digit * decade))
            .filter(|tick| *tick < end)
            .collect(),
        count => decades.into_iter().step_by(count.div_ceil(7)).collect(),
    }
}

fn number(count: &BigUint) -> f64 {
    count.to_string().parse().expect("digits are a number")
}

/// A power of ten in a few letters.
fn power(count: f64) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = format!("{count:.0}");
    if digits.len() <= 3 {
        return digits;
    }
    let exponent = (digits.len() - 1).to_string();
    let raised = exponent.chars().filter_map(|digit| digit.to_digit(10)).map(|digit| DIGITS[digit as usize]);
    format!("10{}", raised.collect::<String>())
}

/// What each curve is, in a row above the panels, where no curve can be.
fn legend(area: &Area<'_>) -> Drawn {
    const Y: i32 = 78;
    let entries = [
        (LEFT, CONVENTIONAL, 2, "conventional: box of a box"),
        (LEFT + 250, CHAIN, 2, "chain: box of mapped points"),
        (LEFT + 510, EXACT, 4, "exact: one box a state"),
    ];
    for (x, colour, width, meaning) in entries {
        area.draw(&PathElement::new([(x, Y), (x + 34, Y)], colour.stroke_width(width)))?;
        write(area, meaning, (x + 44, Y - 5), 13, INK)?;
    }
    let [conventional, chain, exact] = entries.map(|(x, ..)| EmptyElement::at((x + 17, Y)));
    area.draw(&(conventional + conventional_marker()))?;
    area.draw(&(chain + chain_marker()))?;
    area.draw(&(exact + exact_marker()))
}

/// Text with its upper left corner at a point.
fn write(area: &Area<'_>, text: &str, at: (i32, i32), size: i32, colour: RGBColor) -> Drawn {
    area.draw(&Text::new(text, at, font(size, colour)))
}

fn font<'a>(size: i32, colour: RGBColor) -> TextStyle<'a> {
    // The library writes sizes divided by this, the height of a line.
    const LINE: f64 = 1.24;
    ("sans-serif", LINE * f64::from(size)).into_font().color(&colour)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_few_and_short() {
        assert_eq!(ticks(10.0), [1.0, 2.0, 5.0]);
        assert_eq!(ticks(37.5), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(ticks(5e3), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(ticks(1.5e12), [1.0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12]);
        assert_eq!([1.0, 100.0, 1e3, 1e12].map(power), ["1", "100", "10³", "10¹²"]);
    }
}
