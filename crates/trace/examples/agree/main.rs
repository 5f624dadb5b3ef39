//! Shows that all engines agree: the same hits on a million rays a scene.
//!
//! ```text
//! cargo run --release -p csg-graph-trace --example agree -- --rays 1e6
//! ```
//!
//! How is told in the module `comparison`. It prints a row for each scene; the result depends on the number
//! of rays alone. `--scene NAME` compares in one scene only.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "it prints a table")]

mod comparison;

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use comparison::{Comparison, Other};

/// The scenes of the comparison with other programs, and the solids, in sizes that the reference walk can be run at. The
/// unfolded tree is there up to 100,000 primitives. Without boxes, a ray is tested against every primitive, and that many
/// rays against a hundred of them take a minute.
const SCENES: [(&str, &str, &[Other]); 19] = [
    ("peers/sympodial", "cnt=2", &Other::ALL),
    ("peers/sympodial", "cnt=8", &BELOW_100_000),
    ("peers/sympodial", "cnt=12", &BELOW_100_000),
    ("peers/sympodial", "cnt=20", &LARGE),
    ("peers/sympodial", "cnt=60", &LARGE),
    ("peers/sierpinski", "n=3", &Other::ALL),
    ("peers/sierpinski", "n=8", &BELOW_100_000),
    ("peers/sierpinski", "n=12", &LARGE),
    ("peers/sierpinski", "n=24", &LARGE),
    ("peers/sierpinski_tet", "n=8", &BELOW_100_000),
    ("peers/cone_tower", "n=1000", &BELOW_100_000),
    ("peers/cheese", "n=2", &Other::ALL),
    ("peers/cheese", "n=3", &BELOW_100_000),
    ("peers/cheese", "n=4", &LARGE),
    ("solids/plate", "n=3", &BELOW_100_000),
    ("solids/thread", "n=6", &BELOW_100_000),
    ("solids/onion", "n=13", &Other::ALL),
    ("solids/fractals", "n=2", &BELOW_100_000),
    ("solids/tower", "n=5", &BELOW_100_000),
];
const BELOW_100_000: [Other; 4] = [Other::Single, Other::Packets, Other::Grid, Other::Unfolded];
const LARGE: [Other; 3] = [Other::Single, Other::Packets, Other::Grid];

fn main() -> ExitCode {
    let report = options(std::env::args().skip(1)).and_then(|(rays, scene)| compare(rays, scene.as_deref()));
    match report {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}\nusage: agree [--rays N] [--scene NAME]");
            ExitCode::FAILURE
        }
    }
}

fn options(mut words: impl Iterator<Item = String>) -> Result<(usize, Option<String>), Box<dyn Error>> {
    let (mut rays, mut scene) = (1e6, None);
    while let Some(name) = words.next() {
        let value = words.next().ok_or_else(|| format!("{name} needs a value"))?;
        match name.as_str() {
            "--rays" => rays = value.parse::<f64>().map_err(|_| format!("{value} is no number of rays"))?,
            "--scene" => scene = Some(value),
            _ => return Err(format!("there is no option {name}").into()),
        }
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
    let rays = rays.max(1.0) as usize;
    Ok((rays, scene))
}

/// Prints the table, and says whether all engines agree. Rays that are answered differently count once for each engine;
/// under the name of an engine is its largest difference in t.
fn compare(rays: usize, scene: Option<&str>) -> Result<bool, Box<dyn Error>> {
    let engines = Other::ALL.map(|other| other.to_string()).join(" | ");
    println!("| scene | rays | hits | at silhouettes | otherwise | {engines} |");
    println!("|---{}|", "|---:".repeat(4 + Other::ALL.len()));
    let mut agree = true;
    for (name, set, others) in SCENES {
        if scene.is_some_and(|scene| !name.ends_with(scene)) {
            continue;
        }
        let start = Instant::now();
        let found = Comparison::new(name, &[set.to_owned()], others)?.run(rays)?;
        let tallies = || found.tallies.iter().map(|(_, tally)| tally);
        let rays = tallies().map(|tally| tally.rays).max().unwrap_or(0);
        let silhouettes: u64 = tallies().map(|tally| tally.silhouettes).sum();
        let disagreements: u64 = tallies().map(|tally| tally.disagreements).sum();
        let largest = Other::ALL.map(|other| {
            let asked = found.tallies.iter().find(|(asked, _)| *asked == other);
            asked.map_or("–".to_owned(), |(_, tally)| format!("{:.0e}", tally.largest))
        });
        let largest = largest.join(" | ");
        println!(
            "| `{name}` {set} | {rays} | {} | {silhouettes} | {disagreements} | {largest} |",
            found.hits
        );
        tallies().flat_map(|tally| &tally.told).for_each(|told| eprintln!("{told:#?}"));
        agree &= disagreements == 0;
        eprintln!("{name} {set}: {:.0} s", start.elapsed().as_secs_f64());
    }
    Ok(agree)
}
