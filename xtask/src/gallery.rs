//! The pictures of `docs/gallery.md`: what its commands make, one beside each scene.
//!
//! The page itself is the table. A line of it that begins with `cargo xtask render` is a command, and its `-o` the picture
//! that the page shows; so what is written there, what is done here, and what the tests look at cannot differ.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{fs, io};

use csg_graph_cli::{Failure, RenderArgs};
use image::ImageError;

use crate::{exit_code, line};

/// What a line of the page with a command begins with.
const COMMAND: &str = "cargo xtask render ";

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum GalleryError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A picture cannot be written.
    #[error("{}: {source}", path.display())]
    Picture {
        /// The file.
        path: PathBuf,
        /// What the image library says.
        source: ImageError,
    },
    /// A command of the page is none.
    #[error("docs/gallery.md: {line}: {reason}")]
    Command {
        /// The command.
        line: String,
        /// What is wrong with it.
        reason: String,
    },
    /// There is no such picture on the page.
    #[error("docs/gallery.md has no picture `{0}`")]
    NoSuchPicture(String),
    /// The scene cannot be rendered.
    #[error(transparent)]
    Rendering(#[from] Failure),
}

/// A picture of the page.
#[derive(Debug)]
pub struct Exhibit {
    /// The arguments of its command. Files are found from the folder of the repository.
    pub render: RenderArgs,
    /// Where it is.
    pub picture: PathBuf,
    /// What it is called: its file without folder and extension.
    pub name: String,
}

/// The pictures of the page, in its order.
///
/// # Errors
/// If the page cannot be read, or a command of it is none or does not say where its picture goes.
pub fn exhibits(repository: &Path) -> Result<Vec<Exhibit>, GalleryError> {
    let path = repository.join("docs/gallery.md");
    let page = fs::read_to_string(&path).map_err(|source| GalleryError::File { path, source })?;
    page.lines().filter_map(|line| line.strip_prefix(COMMAND)).map(|line| exhibit(repository, line)).collect()
}

fn exhibit(repository: &Path, line: &str) -> Result<Exhibit, GalleryError> {
    let fault = |reason: String| GalleryError::Command { line: line.to_owned(), reason };
    let render = line::render(repository, line).map_err(|error| fault(error.to_string()))?;
    let output = render.output.clone().ok_or_else(|| fault("it lacks -o".to_owned()))?;
    let name = output.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Exhibit { render, picture: repository.join(output), name })
}

/// Renders the pictures of the page again, or those among them that are named.
///
/// # Errors
/// If the page has mistakes, a name is none of its pictures, or a picture cannot be made or written.
pub fn gallery(repository: &Path, names: &[String]) -> Result<(), GalleryError> {
    let exhibits = exhibits(repository)?;
    if let Some(name) = names.iter().find(|name| !exhibits.iter().any(|exhibit| exhibit.name == **name)) {
        return Err(GalleryError::NoSuchPicture(name.clone()));
    }
    for exhibit in exhibits.iter().filter(|exhibit| names.is_empty() || names.contains(&exhibit.name)) {
        let path = &exhibit.picture;
        let picture = csg_graph_cli::render::picture(&exhibit.render)?;
        let bytes = csg_graph_cli::render::encode(&picture)
            .map_err(|source| GalleryError::Picture { path: path.clone(), source })?;
        fs::write(path, bytes).map_err(|source| GalleryError::File { path: path.clone(), source })?;
    }
    Ok(())
}

/// The chore.
pub fn run(repository: &Path, names: &[String]) -> ExitCode {
    exit_code(gallery(repository, names))
}
