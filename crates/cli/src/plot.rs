//! Drawings of two panels over one axis: how something grows with a whole number, and what that costs.
//!
//! Heights are drawn as logarithms. The same curves give the same bytes everywhere.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

/// Width and height of the drawing, in pixels.
const SIZE: (u32, u32) = (860, 760);
/// Where the panels begin, and where the upper one ends.
const PANELS: [u32; 2] = [112, 440];
/// What is below the panels.
const FOOT: u32 = 44;

/// The left edge of all text, and of the panels' axis.
const LEFT: i32 = 24;
const AXIS: u32 = 76;

const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const PALE_INK: RGBColor = RGBColor(0x66, 0x66, 0x66);
const GRID: RGBColor = RGBColor(0xE4, 0xE4, 0xE4);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// A drawing.
pub(crate) struct Drawing<'a> {
    pub(crate) title: String,
    /// The command that draws it.
    pub(crate) command: String,
    /// What the curves are, each from so many pixels on.
    pub(crate) legend: &'a [(i32, Style, &'a str)],
    pub(crate) x_title: &'a str,
    pub(crate) values: Values,
    pub(crate) panels: [Panel<'a>; 2],
}

/// The axis that both panels share.
#[derive(Clone)]
pub(crate) enum Values {
    Linear(Range<i32>),
    Logarithmic(Range<i32>),
    /// Powers of two, each so many bytes.
    Bytes(Range<i32>),
}

/// One of the panels.
pub(crate) struct Panel<'a> {
    pub(crate) title: &'a str,
    /// Those in front come last.
    pub(crate) curves: Vec<Curve>,
    pub(crate) y_label: fn(&f64) -> String,
    /// The panel reaches down to this at least.
    pub(crate) least: f64,
}

pub(crate) struct Curve {
    pub(crate) style: Style,
    pub(crate) points: Vec<Point>,
}

/// A value on the axis, what is drawn there, a positive number, and whether with a marker.
pub(crate) type Point = (i32, f64, bool);

/// How a curve is drawn.
#[derive(Clone, Copy)]
pub(crate) struct Style {
    colour: RGBColor,
    width: u32,
    marker: Marker,
}

#[derive(Clone, Copy)]
enum Marker {
    None,
    Square,
    Triangle,
    Circle,
    Diamond,
}

impl Style {
    // Colours that are told apart by all eyes, and in grey (Okabe and Ito's).
    pub(crate) const ORANGE: Self =
        Self { colour: RGBColor(0xD5, 0x5E, 0x00), width: 2, marker: Marker::Square };
    pub(crate) const BLUE: Self =
        Self { colour: RGBColor(0x00, 0x72, 0xB2), width: 2, marker: Marker::Triangle };
    /// Wide enough to be seen beneath others.
    pub(crate) const GREEN: Self =
        Self { colour: RGBColor(0x00, 0x9E, 0x73), width: 4, marker: Marker::Circle };
    pub(crate) const PURPLE: Self =
        Self { colour: RGBColor(0xCC, 0x79, 0xA7), width: 2, marker: Marker::Diamond };
    /// For what is there to compare with.
    pub(crate) const GUIDE: Self = Self { colour: PALE_INK, width: 1, marker: Marker::None };
}

impl Marker {
    fn circle(colour: RGBColor) -> Circle<(i32, i32), i32> {
        Circle::new((0, 0), 6, colour.filled())
    }

    fn square(colour: RGBColor) -> Rectangle<(i32, i32)> {
        Rectangle::new([(-4, -4), (4, 4)], colour.filled())
    }

    fn triangle(colour: RGBColor) -> TriangleMarker<(i32, i32), i32> {
        TriangleMarker::new((0, 0), 5, colour.filled())
    }

    fn diamond(colour: RGBColor) -> Polygon<(i32, i32)> {
        Polygon::new([(0, -7), (6, 0), (0, 7), (-6, 0)], colour.filled())
    }
}

impl Drawing<'_> {
    /// The drawing as an SVG file.
    pub(crate) fn svg(&self) -> String {
        let mut text = String::new();
        let area = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let drawn = self.draw(&area).and_then(|()| area.present());
        drawn.expect("drawing into a string does not fail");
        drop(area);
        text
    }

    fn draw(&self, area: &Area<'_>) -> Drawn {
        area.fill(&WHITE)?;
        write(area, &self.title, (LEFT, 26), 21, INK)?;
        self.draw_legend(area)?;
        write(area, &self.command, (LEFT, SIZE.1.cast_signed() - 32), 11, PALE_INK)?;
        let (upper, lower) = area.margin(PANELS[0], FOOT, 0, 24).split_vertically(PANELS[1] - PANELS[0]);
        let [first, second] = &self.panels;
        for (panel, area, x_title) in [(first, upper, None), (second, lower, Some(self.x_title))] {
            match self.values.clone() {
                Values::Linear(values) => panel.draw(&area, x_title, values, i32::to_string)?,
                Values::Bytes(values) => panel.draw(&area, x_title, values, binary)?,
                Values::Logarithmic(values) => {
                    let decades = std::iter::successors(Some(1_i32), |decade| decade.checked_mul(10));
                    let ticks = decades.filter(|decade| values.contains(decade)).collect();
                    let values = values.log_scale().with_key_points(ticks);
                    panel.draw(&area, x_title, values, |value| power(&(*value).into()))?;
                }
            }
        }
        Ok(())
    }

    /// What each curve is, in a row above the panels, where no curve can be.
    fn draw_legend(&self, area: &Area<'_>) -> Drawn {
        const Y: i32 = 78;
        for (x, style, meaning) in self.legend {
            let x = LEFT + x;
            area.draw(&PathElement::new([(x, Y), (x + 34, Y)], style.colour.stroke_width(style.width)))?;
            write(area, meaning, (x + 44, Y - 5), 13, INK)?;
        }
        for (x, Style { colour, marker, .. }, _) in self.legend {
            let at = EmptyElement::at((LEFT + x + 17, Y));
            match marker {
                Marker::None => {}
                Marker::Diamond => area.draw(&(at + Marker::diamond(*colour)))?,
                Marker::Square => area.draw(&(at + Marker::square(*colour)))?,
                Marker::Triangle => area.draw(&(at + Marker::triangle(*colour)))?,
                Marker::Circle => area.draw(&(at + Marker::circle(*colour)))?,
            }
        }
        Ok(())
    }
}

impl Panel<'_> {
    fn draw<X>(
        &self,
        area: &Area<'_>,
        x_title: Option<&str>,
        values: X,
        x_label: impl Fn(&i32) -> String,
    ) -> Drawn
    where
        X: AsRangedCoord<Value = i32>,
        X::CoordDescType: Ranged<ValueType = i32> + ValueFormatter<i32>,
    {
        write(area, self.title, (LEFT, 2), 14, INK)?;
        let points = self.curves.iter().flat_map(|curve| &curve.points);
        let [lowest, highest] =
            points.fold([self.least, 0.0], |[low, high], (_, y, _)| [low.min(*y), high.max(*y)]);
        // Room above the highest marker, and below the lowest one.
        let heights = lowest * 0.8..(highest * 1.5).max(lowest * 10.0);
        let ticks = ticks(&heights);
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
            .x_label_formatter(&x_label)
            .y_label_formatter(&self.y_label)
            .draw()?;
        for Curve { style, points } in &self.curves {
            let line = points.iter().map(|(x, y, _)| (*x, *y));
            chart.draw_series(LineSeries::new(line, style.colour.stroke_width(style.width)))?;
        }
        for Curve { style: Style { colour, marker, .. }, points } in &self.curves {
            let marked = points.iter().filter(|(.., marked)| *marked);
            let at = marked.map(|(x, y, _)| EmptyElement::at((*x, *y)));
            match marker {
                Marker::None => {}
                Marker::Diamond => chart.draw_series(at.map(|at| at + Marker::diamond(*colour))).map(drop)?,
                Marker::Square => chart.draw_series(at.map(|at| at + Marker::square(*colour))).map(drop)?,
                Marker::Triangle => {
                    chart.draw_series(at.map(|at| at + Marker::triangle(*colour))).map(drop)?
                }
                Marker::Circle => chart.draw_series(at.map(|at| at + Marker::circle(*colour))).map(drop)?,
            }
        }
        Ok(())
    }
}

/// Where an axis has its labels: seven at most.
fn ticks(heights: &Range<f64>) -> Vec<f64> {
    let first = libm::pow(10.0, libm::log10(heights.start).floor());
    let decades = std::iter::successors(Some(first), |tick| Some(tick * 10.0));
    let decades: Vec<f64> = decades.take_while(|tick| *tick < heights.end).collect();
    let within: Vec<f64> = decades.iter().copied().filter(|tick| heights.contains(tick)).collect();
    match within.len() {
        0..=2 => decades
            .iter()
            .flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| digit * decade))
            .filter(|tick| heights.contains(tick))
            .collect(),
        count => within.into_iter().step_by(count.div_ceil(7)).collect(),
    }
}

/// A power of ten in a few letters.
pub(crate) fn power(count: &f64) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = format!("{count:.0}");
    if digits.len() <= 3 {
        return digits;
    }
    let exponent = (digits.len() - 1).to_string();
    let raised = exponent.chars().filter_map(|digit| digit.to_digit(10)).map(|digit| DIGITS[digit as usize]);
    format!("10{}", raised.collect::<String>())
}

/// A number of units with the prefix that suits it, each a thousand times the one before.
pub(crate) fn prefixed(number: f64, units: [&str; 3], first: f64) -> String {
    let [small, middle, large] = units;
    let scaled = number / first;
    if scaled < 999.5 {
        format!("{scaled:.0} {small}")
    } else if scaled < 999.5e3 {
        format!("{:.0} {middle}", scaled / 1e3)
    } else {
        format!("{:.0} {large}", scaled / 1e6)
    }
}

/// A power of two in bytes, as the command line has it.
fn binary(power: &i32) -> String {
    let (tens, ones) = (power.div_euclid(10), power.rem_euclid(10));
    let suffix = match tens {
        0 => "",
        1 => "K",
        2 => "M",
        _ => "G",
    };
    format!("{}{suffix}", 1_u64 << (ones + 10 * (tens - 3).max(0)))
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
        assert_eq!(ticks(&(0.8..10.0)), [1.0, 2.0, 5.0]);
        assert_eq!(ticks(&(0.8..37.5)), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(ticks(&(0.8..5e3)), [1.0, 10.0, 100.0, 1000.0]);
        assert_eq!(ticks(&(0.8..1.5e12)), [1.0, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12]);
        assert_eq!(ticks(&(40.0..900.0)), [50.0, 100.0, 200.0, 500.0]);
        assert_eq!([1.0, 100.0, 1e3, 1e12].map(|count| power(&count)), ["1", "100", "10³", "10¹²"]);
        assert_eq!(
            [0, 9, 16, 24, 30, 41].map(|power| binary(&power)),
            ["1", "512", "64K", "16M", "1G", "2048G"]
        );
    }
}
