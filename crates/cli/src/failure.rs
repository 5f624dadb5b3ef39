//! Why a command fails, and its exit code.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::interrupt;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// The scene has mistakes, reported as they were found.
    #[error("{}: {count} {}", scene.display(), if *count == 1 { "mistake" } else { "mistakes" })]
    Mistakes {
        /// The file.
        scene: PathBuf,
        /// How many mistakes.
        count: usize,
    },
    /// The scene is right, but asks for more than the limits allow, or for what cannot be done.
    #[error("{}: {reason}", scene.display())]
    Refused {
        /// The file.
        scene: PathBuf,
        /// Why, and what to do about it.
        reason: String,
    },
    /// A file cannot be read or written.
    #[error("{}: cannot {action}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// What the system says.
        source: io::Error,
    },
    /// The arguments do not fit together.
    #[error("{0}")]
    Usage(String),
    /// Someone pressed Ctrl-C. What there is was written.
    #[error(
        "interrupted: {} has {percent:.1} % of the samples; --resume goes on from {}",
        picture.display(),
        checkpoint.display()
    )]
    Interrupted {
        /// The picture of the samples so far.
        picture: PathBuf,
        /// How many those are.
        percent: f64,
        /// What is needed to go on.
        checkpoint: PathBuf,
    },
    /// `fmt --check` found another layout.
    #[error("{}: not in the standard layout; `pcsg fmt --write` changes it", scene.display())]
    Layout {
        /// The file.
        scene: PathBuf,
    },
    /// Writing to the terminal or a pipe failed.
    #[error("cannot write the output: {0}")]
    Output(#[from] io::Error),
}

impl Failure {
    /// For `map_err`: the file and what was tried with it.
    pub(crate) fn file(path: &Path, action: &'static str) -> impl Fn(io::Error) -> Self {
        move |source| Self::File { path: path.to_owned(), action, source }
    }

    pub(crate) fn refused(scene: &Path, reason: impl ToString) -> Self {
        Self::Refused { scene: scene.to_owned(), reason: reason.to_string() }
    }

    /// 2 for wrong usage, as of arguments that cannot be parsed; 130 for an interruption; otherwise 1.
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Usage(_) => ExitCode::from(2),
            Self::Interrupted { .. } => ExitCode::from(interrupt::EXIT_CODE),
            _ => ExitCode::FAILURE,
        }
    }

    /// Whether it is only that nobody reads the output any more, as after `pcsg … | head`.
    pub(crate) fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe)
    }
}
