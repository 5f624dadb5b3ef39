//! How tight boxes about intersections and differences are: the algebra of boxes, S-bounds, and branch and bound on the
//! solid, side by side with dense sampling.
//!
//! ```text
//! cargo run --release -p csg-graph-bounds --example tightness
//! ```
//!
//! The numbers are surface areas relative to the box of the samples, which is a little too small itself. The last rows
//! are a thousand random solids, the same ones on every machine.

#![expect(clippy::print_stdout, reason = "it prints a table")]

mod random;
mod sampling;
mod scenes;

use std::time::Instant;

use csg_graph::Graph;
use csg_graph_bounds::{Limits, Refinement, exact};

/// What the three algorithms make of a solid.
struct Row {
    /// Surface areas: box algebra, S-bounds, branch and bound.
    areas: [f64; 3],
    /// Of the samples.
    sampled: Option<f64>,
    /// Certified, relative to the largest extent of the S-bound, as the tolerance is.
    gap: f64,
    /// The largest distance of a face from the sampled one, relative to the same.
    excess: Option<f64>,
    /// Of S-bounds and of branch and bound, in milliseconds.
    times: [f64; 2],
    cells: u64,
    opened: u64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| solid | box algebra | S-bounds | branch and bound | certified gap | S-bounds, ms | b. and b., ms | cells | opened |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (name, graph, sampled) in scenes::all() {
        let row = measure(&graph, sampled, &Refinement::default())?;
        print!("| {name} |");
        for area in row.areas {
            match row.sampled {
                Some(sampled) => print!(" {:.3} |", area / sampled),
                None => print!(" ({area:.3}) |"),
            }
        }
        let [sweeps, search] = row.times;
        println!(" {:.1e} | {sweeps:.3} | {search:.1} | {} | {} |", row.gap, row.cells, row.opened);
    }
    random_solids(1000)
}

/// A name and what it stands for.
type Column<'a> = (&'a str, &'a dyn Fn(&Row) -> f64);

fn random_solids(count: u64) -> Result<(), Box<dyn std::error::Error>> {
    // Some are mere films where they reach furthest, and the usual limit of cells is not enough for one of them.
    let patient = Refinement::default().with_cells(1_000_000);
    let mut rows = Vec::new();
    let mut none = 0;
    let mut empty = 0;
    for seed in 0..count {
        let row = measure(&random::solid(seed), true, &patient)?;
        if row.sampled.is_some_and(|area| area > 0.0) {
            rows.push(row);
        } else {
            none += 1;
            empty += u32::from(row.areas[2] <= 0.0);
        }
    }
    let ratio = |row: &Row, which: usize| row.areas[which] / row.sampled.unwrap_or(f64::NAN);
    let columns: [Column<'_>; 8] = [
        ("box algebra", &|row| ratio(row, 0)),
        ("S-bounds", &|row| ratio(row, 1)),
        ("branch and bound", &|row| ratio(row, 2)),
        ("certified gap", &|row| row.gap),
        ("face beyond the samples", &|row| row.excess.unwrap_or(f64::NAN)),
        ("S-bounds, ms", &|row| row.times[0]),
        ("branch and bound, ms", &|row| row.times[1]),
        ("cells", &|row| row.cells as f64),
    ];
    println!(
        "\n{} random solids with points in the samples, and {none} without, {empty} of which are",
        rows.len()
    );
    print!("shown to be empty. ");
    let within = rows.iter().filter(|row| row.gap <= Refinement::default().tolerance).count();
    println!("Certified within the tolerance: {within}.\n");
    println!("| | median | 95 % | max |\n|---|---|---|---|");
    for (name, column) in columns {
        let mut values: Vec<f64> = rows.iter().map(column).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: usize| values[(values.len() - 1) * share / 100];
        println!("| {name} | {:.4} | {:.4} | {:.4} |", at(50), at(95), at(100));
    }
    Ok(())
}

fn measure(graph: &Graph, sampled: bool, refinement: &Refinement) -> Result<Row, Box<dyn std::error::Error>> {
    let boxes = exact(graph, &Limits::default())?;
    let (s_bounds, sweeps) = timed(|| boxes.s_bounds(graph).root);
    let (solid, search) = timed(|| boxes.root_solid(refinement).aabb());
    let extent = s_bounds.size().max_element();
    let found = if sampled { Some(sampling::sample(graph, boxes.root)?) } else { None };
    let excess = found
        .filter(|found| !found.is_empty())
        .map(|found| (found.min - solid.aabb.min).max(solid.aabb.max - found.max).max_element() / extent);
    Ok(Row {
        areas: [boxes.root, s_bounds, solid.aabb].map(|bounds| bounds.surface_area()),
        sampled: found.map(|found| found.surface_area()),
        gap: solid.gap / extent,
        excess,
        times: [sweeps, search],
        cells: solid.counts.cells,
        opened: solid.counts.opened,
    })
}

/// What a function gives, and the milliseconds that it takes.
fn timed<T>(compute: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let found = compute();
    (found, start.elapsed().as_secs_f64() * 1e3)
}
