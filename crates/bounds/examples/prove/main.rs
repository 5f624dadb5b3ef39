//! Proves by sampling that no box cuts off a point: surface points of random graphs, inside every volume of every state
//! that contains them.
//!
//! ```text
//! cargo run --release -p csg-graph-bounds --example prove -- --points 1e8
//! ```
//!
//! How is told in the module `prover`. The result depends on the seed and the number of points alone. An escape is
//! reported with the number of its graph; `--seed S --graph G` tries that graph again, alone.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "it prints a table, and its progress")]

mod prover;

use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use prover::{Tally, trial};

/// How many points each graph gets.
const POINTS: u64 = 1 << 15;

/// How many escapes are told in full.
const SHOWN: usize = 20;

/// What to do, as the command line says.
struct Options {
    graphs: std::ops::Range<u64>,
    seed: u64,
    threads: usize,
}

fn main() -> ExitCode {
    let options = match options(std::env::args().skip(1)) {
        Ok(options) => options,
        Err(message) => {
            eprintln!("error: {message}\nusage: prove [--points N] [--seed N] [--threads N] [--graph N]");
            return ExitCode::FAILURE;
        }
    };
    let start = Instant::now();
    let tally = run(&options);
    println!("{tally}\n{:.0} s", start.elapsed().as_secs_f64());
    tally.escapes.iter().take(SHOWN).for_each(|escape| println!("\n{escape}"));
    if tally.escapes.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn options(mut words: impl Iterator<Item = String>) -> Result<Options, String> {
    let (mut points, mut seed, mut graph) = (1e7, 0, None);
    let mut threads = std::thread::available_parallelism().map_or(1, usize::from);
    while let Some(name) = words.next() {
        let value = words.next().ok_or_else(|| format!("{name} needs a number"))?;
        let number = |_| format!("{value} is no number for {name}");
        match name.as_str() {
            "--points" => points = value.parse::<f64>().map_err(|_| number(()))?,
            "--seed" => seed = value.parse().map_err(|_| number(()))?,
            "--threads" => threads = value.parse::<usize>().map_err(|_| number(()))?.max(1),
            "--graph" => graph = Some(value.parse::<u64>().map_err(|_| number(()))?),
            _ => return Err(format!("there is no option {name}")),
        }
    }
    // A cast goes to the nearest number that there is.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let count = (points / POINTS as f64).ceil() as u64;
    Ok(Options { graphs: graph.map_or(0..count, |graph| graph..graph + 1), seed, threads })
}

/// Runs all trials: each thread takes the next graph that nobody has.
fn run(options: &Options) -> Tally {
    let next = AtomicU64::new(options.graphs.start);
    let found = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..options.threads {
            scope.spawn(|| {
                loop {
                    let graph = next.fetch_add(1, Ordering::Relaxed);
                    if graph >= options.graphs.end {
                        break;
                    }
                    let tally = trial(options.seed, graph, POINTS, std::convert::identity);
                    let mut found = found.lock().expect("no trial panics while it holds the lock");
                    found.push((graph, tally));
                    progress(found.len(), options);
                }
            });
        }
    });
    let mut found = found.into_inner().expect("a trial that panics has ended the program");
    found.sort_by_key(|(graph, _)| *graph);
    let mut total = Tally::default();
    found.into_iter().for_each(|(_, tally)| total.add(tally));
    total
}

fn progress(done: usize, options: &Options) {
    if std::io::stderr().is_terminal() {
        eprint!("\r{done} of {} graphs", options.graphs.end - options.graphs.start);
        // Progress that cannot be shown is no reason to stop.
        let _unshown = std::io::stderr().flush();
    }
}
