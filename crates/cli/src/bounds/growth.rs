//! `pcsg bounds --plot`: what the drawing shows, drawn and in numbers.

use std::path::Path;

use serde::Serialize;

use super::plot::{self, Caption};
use super::sweep::{Sample, Samples, guess, samples};
use crate::args::{BoundsArgs, Format, MethodArg, Sweep};
use crate::load::Loaded;
use crate::text::{push_table, seconds, short};
use crate::{Failure, output, print, progress};

/// What `--format json` prints.
#[derive(Serialize)]
struct Report {
    scene: String,
    parameter: String,
    left_out: Vec<i32>,
    samples: Vec<SampleReport>,
}

#[derive(Serialize)]
struct SampleReport {
    value: i32,
    conventional: RunReport,
    chain: RunReport,
    exact: RunReport,
}

/// The volume of the root box relative to the exact one, and the seconds, are null where the work was out of reach.
#[derive(Serialize)]
struct RunReport {
    boxes: String,
    volume_ratio: Option<f64>,
    seconds: Option<f64>,
}

/// Bounds the scene along a sweep, and draws it: the drawing, and the numbers as they are printed.
pub(super) fn grow(args: &BoundsArgs, loaded: &Loaded) -> Result<(String, String), Failure> {
    let (sweep, guessed) = match &args.sweep {
        Some(sweep) => (sweep.clone(), false),
        None => (guess(&loaded.scene.graph).ok_or_else(|| nothing_counts(loaded))?, true),
    };
    let found = samples(loaded, &sweep, args.limit.each())?;
    if !found.left_out.is_empty() {
        let values: Vec<_> = found.left_out.iter().map(i32::to_string).collect();
        crate::say(format_args!(
            "left out {} = {}: `pcsg check {} --set {0}={}` says why",
            sweep.name,
            values.join(", "),
            loaded.name,
            values[0]
        ));
    }
    let caption = Caption { scene: loaded.file_name(), command: command(loaded, &sweep) };
    let drawing = plot::svg(&found, &sweep, caption);
    let numbers = match args.format {
        Format::Table => table(&found, &sweep, guessed),
        Format::Json => json(loaded, found, sweep),
    };
    Ok((drawing, numbers))
}

pub(super) fn run(args: &BoundsArgs, loaded: &Loaded, path: &Path) -> Result<(), Failure> {
    if loaded.is_file(path) {
        return Err(Failure::refused(path, "it would be written over the scene"));
    }
    output::check_writable(path)?;
    let (drawing, numbers) = grow(args, loaded)?;
    output::write(path, drawing.as_bytes())?;
    print(numbers)?;
    progress::tell(path.display());
    Ok(())
}

fn nothing_counts(loaded: &Loaded) -> Failure {
    loaded.refused(
        "no parameter counts the recursion down by one, as `{n = n - 1}` would; choose one with --sweep NAME=A..B",
    )
}

/// The command that draws this, with the scene as if it were in the current folder.
fn command(loaded: &Loaded, sweep: &Sweep) -> String {
    let Sweep { name, first, last } = sweep;
    let set = loaded.options_without(name);
    format!("pcsg bounds {}{set} --plot FILE.svg --sweep {name}={first}..{last}", loaded.file_name())
}

fn table(found: &Samples, sweep: &Sweep, guessed: bool) -> String {
    let Sweep { name, first, last } = sweep;
    let mut text = format!("{name} from {first} to {last}");
    if guessed {
        text.push_str(", which counts the recursion down; --sweep chooses another");
    }
    text.push_str("\nvolumes of the root box are relative to the exact one\n\n");
    let heads = [name, "conventional", "boxes", "time", "chain", "boxes", "time", "exact boxes", "time"];
    let cells = |sample: &Sample, method| {
        let ratio = sample.growth(method).map_or("-".to_owned(), |ratio| format!("{ratio:.3}"));
        let time = sample.run(method).map_or("-".to_owned(), |run| seconds(run.seconds));
        [ratio, short(sample.boxes(method)), time]
    };
    let row = |sample: &Sample| {
        let [a, b, c] = cells(sample, MethodArg::Conventional);
        let [d, e, f] = cells(sample, MethodArg::Chain);
        let [_, g, h] = cells(sample, MethodArg::Exact);
        [sample.value.to_string(), a, b, c, d, e, f, g, h]
    };
    let rows: Vec<_> = found.samples.iter().map(row).collect();
    push_table(&mut text, heads, [true; 9], &rows);
    text
}

fn json(loaded: &Loaded, found: Samples, sweep: Sweep) -> String {
    let run = |sample: &Sample, method| RunReport {
        boxes: sample.boxes(method).to_string(),
        volume_ratio: sample.growth(method),
        seconds: sample.run(method).map(|run| run.seconds),
    };
    let sample = |sample: &Sample| SampleReport {
        value: sample.value,
        conventional: run(sample, MethodArg::Conventional),
        chain: run(sample, MethodArg::Chain),
        exact: run(sample, MethodArg::Exact),
    };
    let report = Report {
        scene: loaded.name.clone(),
        parameter: sweep.name,
        left_out: found.left_out,
        samples: found.samples.iter().map(sample).collect(),
    };
    crate::text::json(&report)
}
