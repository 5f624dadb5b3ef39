//! Shows that envelopes hold whatever the random numbers are: for a million seeds of every scene with chance in it, the
//! envelopes of all states enclose their exact boxes.
//!
//! ```text
//! cargo run --release -p csg-graph-bounds --example seeds -- --seeds 1e6
//! ```
//!
//! How is told in the module `sweep`. It prints a row for each scene; the result depends on the number of seeds alone.
//! `--scene NAME` looks at one scene only. A violation is told with its seed.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "it prints a table")]

mod sweep;

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use sweep::{Failure, OWN, Reduced, Subject, check, looseness};

/// How many states a scene has in which all are checked: a few levels.
const CHECKED: usize = 800;

/// And one in which there is more below a state than one expansion sees. So many seeds of it are enough for a median.
const EXPANDED: usize = 4_000;
const MEDIANS: u64 = 100;

/// Seeds between two looks at what was found.
const BLOCK: u64 = 1 << 14;

fn main() -> ExitCode {
    let report = options(std::env::args().skip(1)).and_then(|(seeds, scene)| run(seeds, scene.as_deref()));
    match report {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}\nusage: seeds [--seeds N] [--scene NAME]");
            ExitCode::FAILURE
        }
    }
}

fn options(mut words: impl Iterator<Item = String>) -> Result<(u64, Option<String>), Failure> {
    let (mut seeds, mut scene) = (1e6, None);
    while let Some(name) = words.next() {
        let value = words.next().ok_or_else(|| format!("{name} needs a value"))?;
        match name.as_str() {
            "--seeds" => {
                seeds = value.parse::<f64>().map_err(|_| format!("{value} is no number of seeds"))?
            }
            "--scene" => scene = Some(value),
            _ => return Err(format!("there is no option {name}").into()),
        }
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let seeds = seeds.max(1.0) as u64;
    Ok((seeds, scene))
}

/// Prints the table, and says whether every envelope holds.
fn run(seeds: u64, scene: Option<&str>) -> Result<bool, Failure> {
    println!(
        "| scene | seeds | states | not listed | not compared | violations | envelope | after an expansion |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    let mut sound = true;
    let mut looked_at = 0;
    for (name, source) in scenes()? {
        if scene.is_some_and(|scene| !name.ends_with(scene)) {
            continue;
        }
        let Some(subject) = Subject::new(&name, source)? else { continue };
        looked_at += 1;
        sound &= row(&subject, seeds)?;
    }
    if looked_at == 0 {
        return Err("no such scene has random numbers".into());
    }
    Ok(sound)
}

/// One scene.
fn row(subject: &Subject, seeds: u64) -> Result<bool, Failure> {
    let start = Instant::now();
    let name = subject.name();
    let (Some(small), large) = (subject.reduced(CHECKED)?, subject.reduced(EXPANDED)?) else {
        println!("| `{name}` | 0 | | | | | | |");
        eprintln!("{name}: its states cannot be listed, however small its counters are");
        return Ok(true);
    };
    let tally = checked(&small, seeds)?;
    let medians = match &large {
        Some(large) => looseness(large, 0..seeds.min(MEDIANS))?,
        None => [None; 2],
    };
    let [direct, expanded] = medians.map(|median| median.map_or_else(String::new, |m| format!("{m:.2}")));
    println!(
        "| `{name}` {small} | {} | {} | {} | {} | {} | {direct} | {expanded} |",
        tally.seeds, tally.states, tally.unlisted, tally.skipped, tally.violations
    );
    tally.told.iter().for_each(|told| eprintln!("{told}"));
    let large =
        large.map_or_else(|| "too large for medians".to_owned(), |large| format!("medians of {large}"));
    eprintln!("{name}: {large}; {:.0} s", start.elapsed().as_secs_f64());
    Ok(tally.violations == 0)
}

/// In blocks, so that a long run does not go on for long when it has failed.
fn checked(scene: &Reduced, seeds: u64) -> Result<sweep::Tally, Failure> {
    let mut tally = sweep::Tally::default();
    let mut from = 0;
    while from < seeds && tally.violations == 0 {
        let to = seeds.min(from + BLOCK);
        tally = tally.and(check(scene, from..to, 0.0)?);
        from = to;
    }
    Ok(tally)
}

/// The names and texts of all scenes of this repository, and of those that are its own.
fn scenes() -> Result<Vec<(String, String)>, Failure> {
    let mut roots = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().map(|folder| folder.join("scenes"));
    let root = roots.find(|folder| folder.is_dir()).ok_or("no folder has the scenes")?;
    let mut found = OWN.map(|(name, source)| (name.to_owned(), source.to_owned())).to_vec();
    let mut pending = vec![root.clone()];
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                pending.push(path);
            } else if path.extension().is_some_and(|extension| extension == "pcsg") {
                let name = path.strip_prefix(&root)?.with_extension("").display().to_string();
                found.push((name, std::fs::read_to_string(path)?));
            }
        }
    }
    found.sort();
    Ok(found)
}
