//! Fig. 2.1 as a program: how boxes grow when each is the box of a turned box, and how they do not when each comes from
//! the points of the primitives.
//!
//! ```text
//! cargo run --release -p csg-graph-bounds --example growth
//! ```
//!
//! The first table turns a cube by 45° again and again. The conventional box doubles its volume at every step; the box
//! through the chain is the least box about the turned cube, which is a cube again after every second step. The second
//! table is the sympodial tree of Fig. 1.1a, where the steps are the orders of its branches.

#![expect(clippy::print_stdout, reason = "it prints tables")]

mod sympodial;

use std::time::Instant;

use csg_graph::{Expr, GraphBuilder, PrimitiveKind, TransformKind};
use csg_graph_bounds::{HyperBoxes, Limits, chain, conventional, exact};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    rotations()?;
    println!();
    tree()
}

/// A cube under one T-node after the other: the boxes of the T-nodes are the steps.
fn rotations() -> Result<(), Box<dyn std::error::Error>> {
    let mut builder = GraphBuilder::new();
    let mut top = builder.primitive(PrimitiveKind::Cube, []);
    for _ in 0..8 {
        top = builder.transform(TransformKind::RotZ, [Expr::from(45.0)], top);
    }
    let graph = builder.finish(top)?;
    let limits = Limits::default();
    let conventional = conventional(&graph, &limits)?;
    let chain = chain(&graph, &limits)?;

    println!("A cube under successive rotations by 45°: volume, and its ratio to the step before");
    println!("{:>5} {:>14} {:>7} {:>14} {:>7}", "turns", "conventional", "ratio", "chain", "ratio");
    let volume = |boxes: &HyperBoxes, turns: usize| boxes.nodes[turns].volume();
    for turns in 0..=8 {
        print!("{turns:>5}");
        for boxes in [&conventional, &chain] {
            let now = volume(boxes, turns);
            let before = volume(boxes, turns.max(1) - 1);
            print!(" {now:>14.3} {:>7.3}", now / before);
        }
        println!();
    }
    Ok(())
}

/// The root box of the sympodial tree by all algorithms. The exact one takes no notice of how much is unfolded.
fn tree() -> Result<(), Box<dyn std::error::Error>> {
    println!("The sympodial tree of Fig. 1.1a: volume of the root box, and the time that it takes");
    println!(
        "{:>5} {:>10} {:>14} {:>9} {:>10} {:>9} {:>10} {:>9} {:>7}",
        "cnt", "primitives", "conventional", "seconds", "chain", "seconds", "exact", "seconds", "states"
    );
    let limits = Limits::default();
    for cnt in [4, 8, 12, 60, 1000] {
        let graph = sympodial::sympodial(cnt);
        print!("{cnt:>5} {:>10}", format!("2^{}", cnt + 4));
        if cnt <= 12 {
            let (boxes, seconds) = timed(|| conventional(&graph, &limits))?;
            print!(" {:>14.3} {seconds:>9.3}", boxes.root.volume());
            let (boxes, seconds) = timed(|| chain(&graph, &limits))?;
            print!(" {:>10.3} {seconds:>9.3}", boxes.root.volume());
        } else {
            print!(" {:>14} {:>9} {:>10} {:>9}", "-", "-", "-", "-");
        }
        let (boxes, seconds) = timed(|| exact(&graph, &limits))?;
        println!(" {:>10.3} {seconds:>9.5} {:>7}", boxes.root.volume(), boxes.counts.states);
    }
    Ok(())
}

/// What a function gives, and the seconds that it takes.
fn timed<T, E>(compute: impl FnOnce() -> Result<T, E>) -> Result<(T, f64), E> {
    let start = Instant::now();
    let found = compute()?;
    Ok((found, start.elapsed().as_secs_f64()))
}
