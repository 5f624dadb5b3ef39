//! The comparison with Embree: its program and `pcsg bench` in turn, on the same scenes, as a table of ratios.
//!
//! The other program gets scenes as dags of states, one a file that begins with `scene NAME N`. Both print an object of
//! JSON. They take turns because a machine that does other things is not equally fast all the time, and what counts is the
//! median over the rounds of the CPU time of one thread.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::{fs, io};

use serde_json::Value;

use crate::example::cargo_run;
use crate::exit_code;

/// What to run and how often.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// The program over Embree
    #[arg(long, value_name = "PROGRAM")]
    embench: PathBuf,
    /// The folder with its scenes
    #[arg(long, value_name = "FOLDER")]
    dags: PathBuf,
    /// How many turns each of them has
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=100))]
    rounds: u32,
}

/// Why there is no table.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PeersError {
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: io::Error },
    #[error("{}: it does not begin with `scene NAME N`", .0.display())]
    NoScene(PathBuf),
    #[error("{}: no file of it ends with .dag", .0.display())]
    NoDags(PathBuf),
    #[error("{0} failed, or printed no JSON")]
    Run(String),
}

/// More primitives than these are not given to Embree in one tree: they would take gigabytes.
const MOST_FLAT: f64 = 2e6;
/// More primitives than these are not given to it in two levels.
const MOST_TWO_LEVEL: f64 = 1e12;
/// Rays of a packet of Embree.
const PACKET: u32 = 16;

/// Runs the comparison. Its table goes to the standard output.
#[expect(clippy::print_stdout, reason = "the report of a chore")]
pub fn run(options: &Options) -> ExitCode {
    let report = || -> Result<(), PeersError> {
        println!(
            "| scene | set-up | bytes | Mray/s | of Embree's single rays | of its packets | picture, of its best |"
        );
        println!("|---|---|---|---|---|---|---|");
        for dag in dags(&options.dags)? {
            println!("{}", compare(options, &dag)?);
        }
        Ok(())
    };
    exit_code(report())
}

/// The scenes of the other program, by name and size.
fn dags(folder: &Path) -> Result<Vec<Dag>, PeersError> {
    let at = |path: &Path| {
        let path = path.to_owned();
        move |source| PeersError::File { path: path.clone(), source }
    };
    let mut dags = Vec::new();
    for entry in fs::read_dir(folder).map_err(at(folder))? {
        let path = entry.map_err(at(folder))?.path();
        if path.extension().is_some_and(|extension| extension == "dag") {
            let text = fs::read_to_string(&path).map_err(at(&path))?;
            let mut words = text.split_whitespace();
            let found = match (words.next(), words.next(), words.next().and_then(|n| n.parse().ok())) {
                (Some("scene"), Some(name), Some(size)) => (name.to_owned(), size),
                _ => return Err(PeersError::NoScene(path)),
            };
            dags.push(Dag { name: found.0, size: found.1, path });
        }
    }
    dags.sort();
    if dags.is_empty() { Err(PeersError::NoDags(folder.to_owned())) } else { Ok(dags) }
}

#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Dag {
    name: String,
    size: u32,
    path: PathBuf,
}

/// A row of the table.
fn compare(options: &Options, dag: &Dag) -> Result<String, PeersError> {
    let parameter = if dag.name == "sympodial" { "cnt" } else { "n" };
    let mut bench = bench(&format!("peers/{}", dag.name), &[&format!("{parameter}={}", dag.size)]);
    let mut own = Vec::new();
    let mut others: BTreeMap<(&[&str], u32), Vec<Value>> = BTreeMap::new();
    for _ in 0..options.rounds {
        own.push(object(&mut bench)?);
        let primitives = own[0]["primitives"].as_str().and_then(|count| count.parse().ok());
        for (mode, rays) in ways(dag, primitives.unwrap_or(f64::INFINITY)) {
            let mut command = Command::new(&options.embench);
            command.arg(&dag.path).args(mode).args(["-t", "1", "-reps", "3", "-p", &rays.to_string()]);
            others.entry((mode, rays)).or_default().push(object(&mut command)?);
        }
    }
    let own = |field: &str| median(&own, field);
    let least = |field: &str, rays: Option<u32>| {
        let ways = others.iter().filter(|((_, own), _)| rays.is_none_or(|rays| rays == *own));
        ways.map(|(_, runs)| median(runs, field)).reduce(f64::min)
    };
    let ratio = |field: &str, rays: Option<u32>| {
        least(field, rays).map_or("–".to_owned(), |time| format!("{:.2}", time / own(field)))
    };
    Ok(format!(
        "| {} {} | {:.1} ms | {} | {:.2} | {} | {} | {} |",
        dag.name,
        dag.size,
        1e3 * own("setup_s"),
        own("bytes"),
        own("primary_mray_s"),
        ratio("primary_cpu_s", Some(1)),
        ratio("primary_cpu_s", Some(PACKET)),
        ratio("image_cpu_s", None),
    ))
}

/// `pcsg bench` of a scene, as a release build.
pub(crate) fn bench(scene: &str, set: &[&str]) -> Command {
    let mut command = cargo_run("csg-graph-cli", ["--bin", "pcsg"]);
    command.arg("bench").arg(format!("scenes/{scene}.pcsg"));
    command.args(["--format", "json"]).args(set.iter().flat_map(|set| ["--set", set]));
    command
}

/// The ways in which the other program can trace a scene: how it is stored, and how many rays go together.
fn ways(dag: &Dag, primitives: f64) -> impl Iterator<Item = (&'static [&'static str], u32)> {
    let flat = (primitives <= MOST_FLAT).then_some(&["-flat"][..]);
    // Nothing repeats in the tower, and no two levels serve.
    let two_level = primitives <= MOST_TWO_LEVEL && dag.name != "cone_tower";
    let modes = flat.into_iter().chain(two_level.then_some(&["-levels", "1"][..]));
    // It subtracts ray by ray.
    let packet = (dag.name != "cheese").then_some(PACKET);
    modes.flat_map(move |mode| [Some(1), packet].into_iter().flatten().map(move |rays| (mode, rays)))
}

/// What a program prints.
pub(crate) fn object(command: &mut Command) -> Result<Value, PeersError> {
    let output = command.stderr(Stdio::inherit()).output().ok().filter(|output| output.status.success());
    output
        .and_then(|output| serde_json::from_slice(&output.stdout).ok())
        .ok_or_else(|| PeersError::Run(command.get_program().to_string_lossy().into_owned()))
}

fn median(runs: &[Value], field: &str) -> f64 {
    let mut values: Vec<f64> = runs.iter().filter_map(|run| run[field].as_f64()).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
