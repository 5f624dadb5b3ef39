//! `cargo xtask`: the commands of `pcsg` without an installation, and the chores of this repository.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use csg_graph_cli::Command;
use xtask::{agree, exit_code, figures, gallery, golden, peers, prove, repository, seeds, solids};

/// The commands of pcsg without an installation, and the chores of this repository
#[derive(Debug, Parser)]
#[command(name = "cargo xtask")]
struct Xtask {
    #[command(subcommand)]
    command: Chore,
}

#[derive(Debug, Subcommand)]
enum Chore {
    #[command(flatten)]
    Pcsg(Command),
    /// Compare the golden images in tests/golden with what is rendered now
    ///
    /// What differs is written to tests/golden/failed: expected, actual and difference.
    Golden {
        /// Accept the picture of this case as it is rendered now
        #[arg(long, value_name = "NAME")]
        bless: Vec<String>,
    },
    /// Draw the figures of the documents, docs/figures, again
    Figures {
        /// Only those with these names, as memory.svg
        #[arg(value_name = "NAME")]
        only: Vec<String>,
        /// Draw nothing; fail if that would change one
        #[arg(long)]
        check: bool,
    },
    /// Render the pictures of docs/gallery.md again: what its commands make. Some take minutes
    Gallery {
        /// Only the pictures with these names, without .png
        #[arg(value_name = "NAME")]
        only: Vec<String>,
    },
    /// Sample surface points of random graphs, and show that no bounding volume cuts one off
    Prove(prove::Options),
    /// Trace a million rays through each of many scenes by all engines, and show that they agree
    Agree(agree::Options),
    /// Compare the envelopes of random scenes with exact boxes for a million seeds, and show that they enclose them
    Seeds(seeds::Options),
    /// Count what the fast engine and pure span evaluation test in scenes/solids
    Solids(solids::Options),
    /// Trace the scenes of scenes/peers in turn with a program over Embree, and print the ratios of their speeds
    Peers(peers::Options),
}

fn main() -> ExitCode {
    match Xtask::parse().command {
        Chore::Pcsg(command) => csg_graph_cli::run(command),
        Chore::Golden { bless } => golden_images(&bless),
        Chore::Figures { only, check } => figures::run(&repository(), &only, check),
        Chore::Gallery { only } => gallery::run(&repository(), &only),
        Chore::Prove(options) => prove::run(&options),
        Chore::Agree(options) => agree::run(&options),
        Chore::Seeds(options) => seeds::run(&options),
        Chore::Solids(options) => solids::run(&options),
        Chore::Peers(options) => peers::run(&options),
    }
}

#[expect(clippy::print_stderr, reason = "the report of a chore")]
fn golden_images(bless: &[String]) -> ExitCode {
    let repository = repository();
    match golden::run(&repository, &repository.join("tests/golden"), bless) {
        Ok(report) => {
            report.blessed.iter().for_each(|name| eprintln!("accepted {name}"));
            report.failures.iter().for_each(|failure| eprintln!("{failure}"));
            eprintln!("{} passed, {} failed", report.passed, report.failures.len());
            if report.failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(error) => exit_code(Err(error)),
    }
}
