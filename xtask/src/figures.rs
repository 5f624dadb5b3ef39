//! The figures of the documents: each is what one command draws, and must be what it draws now.

use std::path::Path;
use std::process::ExitCode;
use std::{fs, io};

use clap::Parser;
use csg_graph_cli::{BoundsArgs, Failure};

/// The figures by their names in `docs/figures`, and the arguments of `pcsg bounds` that draw them.
const FIGURES: [(&str, &str); 1] = [("sympodial_growth.svg", "scenes/sympodial.pcsg --sweep cnt=0..12")];

/// Why a figure is not as it should be.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// It cannot be drawn.
    #[error(transparent)]
    Drawing(#[from] Failure),
    /// Its file cannot be read or written.
    #[error("docs/figures/{0}: {1}")]
    File(&'static str, io::Error),
    /// Its file holds another drawing.
    #[error(
        "docs/figures/{0} is not what its command draws now; look at `cargo xtask figures` and its difference"
    )]
    Stale(&'static str),
}

#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct Figure {
    #[command(flatten)]
    bounds: BoundsArgs,
}

/// Draws the figures of a repository again, or checks that this would not change them.
///
/// # Errors
/// If one cannot be drawn, read or written, or is checked and stale.
pub fn figures(repository: &Path, check: bool) -> Result<(), FigureError> {
    for (name, arguments) in FIGURES {
        let path = repository.join("docs/figures").join(name);
        let arguments = arguments.split_whitespace().chain(["--plot", name]);
        let mut bounds = Figure::parse_from(arguments).bounds;
        bounds.scene.scene = repository.join(&bounds.scene.scene);
        let drawing = csg_graph_cli::bounds::drawing(&bounds)?;
        if !check {
            fs::write(&path, drawing).map_err(|error| FigureError::File(name, error))?;
        } else if fs::read_to_string(&path).map_err(|error| FigureError::File(name, error))? != drawing {
            return Err(FigureError::Stale(name));
        }
    }
    Ok(())
}

/// The chore.
#[expect(clippy::print_stderr, reason = "the report of a chore")]
pub fn run(repository: &Path, check: bool) -> ExitCode {
    match figures(repository, check) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
