//! `pcsg bench --plot`: what a ray costs along a parameter, the size of the picture, or the memory of the engine.
//!
//! The upper panel counts tests of boxes and primitives, which are the same everywhere. The lower one is measured, and
//! tells how the time of a pixel divides: the primary rays alone; with shading, but no shadows; and the whole picture.
//! The differences are what shading and shadow rays take.

use std::path::Path;

use super::{Measured, measure};
use crate::args::{BenchArgs, Plan, Size, Sweep, ViewArg};
use crate::load::Loaded;
use crate::plot::{Curve, Drawing, Panel, Style, Values, power};
use crate::{Failure, output, progress};

/// The most values that are tried.
const VALUES: u16 = 16;

/// What can be swept besides the parameters of a scene: powers of two.
const SIDE: &str = "log2(side)";
const BUDGET: &str = "log2(budget)";

/// Pixels along the side of the largest picture.
const LARGEST_SIDE: u32 = 8192;

pub(super) fn run(args: &BenchArgs, loaded: &Loaded, path: &Path, sweep: &Sweep) -> Result<(), Failure> {
    if loaded.is_file(path) {
        return Err(Failure::refused(path, "it would be written over the scene"));
    }
    output::check_writable(path)?;
    output::write(path, drawing(args, loaded, sweep)?.as_bytes())?;
    progress::tell(path.display());
    Ok(())
}

/// Measures at all values of the sweep, and draws that.
pub(crate) fn drawing(args: &BenchArgs, loaded: &Loaded, sweep: &Sweep) -> Result<String, Failure> {
    let mut samples = Vec::new();
    for value in sweep.values(VALUES) {
        samples.push((value, sample(args, loaded, sweep, value)?));
    }
    let curve = |style, height: fn(&Measured) -> f64| {
        let points = samples.iter().map(|(value, measured)| (*value, height(measured), true));
        // What is not there has no logarithm.
        Curve { style, points: points.filter(|(_, height, _)| *height > 0.0).collect() }
    };
    let drawing = Drawing {
        title: format!("What a ray costs: {}", loaded.file_name()),
        command: command(args, loaded, sweep),
        legend: &[
            (0, Style::GREEN, "boxes; whole picture"),
            (230, Style::BLUE, "primitives; without shadows"),
            (510, Style::ORANGE, "primary rays alone"),
        ],
        x_title: &sweep.name,
        values: Values::Linear(sweep.first..sweep.last),
        panels: [
            Panel {
                title: "Tests a primary ray: boxes and primitives",
                curves: vec![
                    curve(Style::GREEN, |measured| measured.box_tests),
                    curve(Style::BLUE, |measured| measured.primitive_tests),
                ],
                y_label: few,
                least: 1.0,
            },
            Panel {
                title: "CPU time a pixel: primary rays alone, with shading, and with shadows",
                curves: vec![
                    curve(Style::GREEN, |measured| measured.image_ns),
                    curve(Style::BLUE, |measured| measured.unshadowed_ns),
                    curve(Style::ORANGE, |measured| measured.primary_ns),
                ],
                y_label: |ns| format!("{} ns", few(ns)),
                least: 50.0,
            },
        ],
    };
    Ok(drawing.svg())
}

fn sample(args: &BenchArgs, loaded: &Loaded, sweep: &Sweep, value: i32) -> Result<Measured, Failure> {
    let out_of_range = || Failure::Usage(format!("2^{value} is out of range for {}", sweep.name));
    let power = || u32::try_from(value).ok().and_then(|exponent| 1_u32.checked_shl(exponent));
    let mut plan = args.engine.plan(ViewArg::Shaded)?;
    let (mut size, mut varied) = (args.size, None);
    match sweep.name.as_str() {
        SIDE => {
            let side = power().filter(|side| *side <= LARGEST_SIDE).ok_or_else(out_of_range)?;
            size = Size { width: side, height: side };
        }
        BUDGET => match &mut plan {
            Plan::Fast { budget, .. } | Plan::Grid { budget, .. } => {
                *budget = power().ok_or_else(out_of_range)? as usize;
            }
            Plan::Reference { .. } => {
                return Err(Failure::Usage("the reference walk has no budget to sweep".to_owned()));
            }
        },
        name => varied = Some(loaded.varied(name, value).map_err(|mistakes| loaded.mistakes(&mistakes))?),
    }
    measure(varied.as_ref().unwrap_or(loaded), plan, size, args)
}

/// A number in a few letters.
fn few(number: &f64) -> String {
    if *number < 1.0 { format!("{number:.1}") } else { power(number) }
}

/// The command that draws this, with the scene as if it were in the current folder.
fn command(args: &BenchArgs, loaded: &Loaded, sweep: &Sweep) -> String {
    let Sweep { name, first, last } = sweep;
    let set = loaded.options_without(name);
    let size = if name == SIDE {
        String::new()
    } else {
        format!(" --size {}x{}", args.size.width, args.size.height)
    };
    format!("pcsg bench {}{set}{size} --plot FILE.svg --sweep '{name}={first}..{last}'", loaded.file_name())
}
