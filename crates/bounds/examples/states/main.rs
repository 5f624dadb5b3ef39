//! What exact boxes cost by the number of states: processor time and memory.
//!
//! ```text
//! cargo run --release -p csg-graph-bounds --example states
//! ```
//!
//! Each row is measured in a process of its own. A scene of few states is bounded again and again, and all results are
//! kept, until there are states enough to be measured; time and memory are those of one. Memory is the most that the
//! process ever held, less what it held before the first. Linux tells both, in `/proc`; other systems do not.

#![expect(clippy::print_stdout, reason = "it prints a table")]
#![expect(clippy::cast_precision_loss, reason = "no count here is beyond 2⁵³")]

mod dag;
mod solids;

use std::process::Command;

use csg_graph::GraphBuilder;
use csg_graph_bounds::{Limits, Scene, exact};
use dag::Dag;

type Error = Box<dyn std::error::Error>;

/// Scenes, each with its sizes.
const SCENES: [(&str, [u32; 4]); 4] = [
    ("cone_tower", [100, 1_000, 10_000, 100_000]),
    ("sierpinski", [5, 10, 20, 40]),
    ("cheese", [5, 10, 20, 40]),
    ("turned_dag", [333, 3_333, 33_333, 333_333]),
];

/// So many states are held at least while they are measured.
const STATES: usize = 200_000;

fn main() -> Result<(), Error> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [scene, size] = words.as_slice() {
        println!("{}", row(scene, size.parse()?)?);
        return Ok(());
    }
    println!("{:<10} {:>7} {:>8} {:>12} {:>10}", "scene", "n", "states", "seconds", "bytes");
    for (scene, sizes) in SCENES {
        for size in sizes {
            let alone = Command::new(std::env::current_exe()?).args([scene, &size.to_string()]).output()?;
            if !alone.status.success() {
                return Err(String::from_utf8_lossy(&alone.stderr).into());
            }
            print!("{}", String::from_utf8(alone.stdout)?);
        }
    }
    Ok(())
}

/// Measures a scene.
fn row(scene: &str, size: u32) -> Result<String, Error> {
    let [states, seconds, bytes] = match scene {
        "cone_tower" => measure(&solids::cone_tower(size, 0.9)),
        "sierpinski" => measure(&solids::sierpinski(size)),
        "cheese" => {
            let mut builder = GraphBuilder::new();
            let cheese = solids::cheese(&mut builder, size);
            measure(&builder.finish(cheese)?)
        }
        "turned_dag" => measure(&Dag { levels: size, turns: [-0.5, 0.8] }),
        _ => return Err(format!("no scene is called {scene}").into()),
    }?;
    Ok(format!("{scene:<10} {size:>7} {states:>8} {seconds:>12.9} {bytes:>10.0}"))
}

/// States, seconds and bytes.
fn measure<S: Scene>(scene: &S) -> Result<[f64; 3], Error>
where
    S::Error: std::error::Error + 'static,
{
    let (time, memory) = (processor_time()?, peak()?);
    let mut kept = vec![exact(scene, &Limits::default())?];
    let states = kept[0].counts.states;
    while kept.len() * states < STATES {
        kept.push(exact(scene, &Limits::default())?);
    }
    let count = kept.len() as f64;
    Ok([states as f64, (processor_time()? - time) / count, (peak()? - memory) / count])
}

/// The seconds that this process has had a processor.
fn processor_time() -> Result<f64, Error> {
    let times = std::fs::read_to_string("/proc/self/schedstat")?;
    let nanoseconds = times.split_whitespace().next().ok_or("the system does not tell")?;
    Ok(1e-9 * nanoseconds.parse::<f64>()?)
}

/// The most bytes that this process ever held.
fn peak() -> Result<f64, Error> {
    let status = std::fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB")).ok_or("the system does not tell")?;
    Ok(1024.0 * kilobytes.trim().parse::<f64>()?)
}
