//! Golden images: pictures that were looked at once, and must not change unnoticed.
//!
//! A case is a file `NAME.args` that holds the arguments of `pcsg render`, and beside it the accepted picture
//! `NAME.png`. A picture passes if a structural comparison finds it the same and hardly a pixel differs visibly.
//! One that fails is written to the folder `failed`, with what was expected and where they differ. Files that belong to
//! no case fail as well.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::{fs, io};

use csg_graph_cli::Failure;
use image::{ImageError, RgbImage};

use crate::line;

/// The least structural similarity (1 is equal) of a picture that passes.
const LEAST_SCORE: f64 = 0.999;
/// How much a channel of a pixel may differ without counting as different, of 255.
const TOLERANCE: u8 = 2;
/// The largest part of the pixels that may differ.
const MOST_DIFFERING: f64 = 0.0005;
/// The largest side of a stored picture.
const MOST_PIXELS: u32 = 256;
/// The largest stored picture in bytes.
const MOST_BYTES: u64 = 40 * 1024;

/// What a run found.
#[derive(Debug, Default)]
pub struct Report {
    /// How many cases passed.
    pub passed: usize,
    /// What failed, a message each.
    pub failures: Vec<String>,
    /// The cases whose new picture was accepted.
    pub blessed: Vec<String>,
}

/// Why a run could not be done at all.
#[derive(Debug, thiserror::Error)]
pub enum GoldenError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A picture cannot be read or written.
    #[error("{}: {source}", path.display())]
    Picture {
        /// The file.
        path: PathBuf,
        /// What the image library says.
        source: ImageError,
    },
    /// A name to accept is no case.
    #[error("there is no case `{0}`: a case is a file NAME.args in tests/golden")]
    NoSuchCase(String),
}

/// How much two pictures differ.
#[derive(Debug)]
pub struct Comparison {
    /// Structural similarity: 1 is equal.
    pub score: f64,
    /// The part of the pixels that differ visibly.
    pub differing: f64,
    /// Where they differ, for people.
    pub difference: RgbImage,
}

impl Comparison {
    /// Compares two pictures, or returns `None` if their sizes differ.
    pub fn new(expected: &RgbImage, actual: &RgbImage) -> Option<Self> {
        let similarity = image_compare::rgb_hybrid_compare(expected, actual).ok()?;
        let differs = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| {
            a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > TOLERANCE)
        };
        let count = expected.pixels().zip(actual.pixels()).filter(|pair| differs(*pair)).count();
        let differing = count as f64 / expected.pixels().len() as f64;
        Some(Self {
            score: similarity.score,
            differing,
            difference: similarity.image.to_color_map().to_rgb8(),
        })
    }

    /// Whether the pictures count as the same.
    pub fn passes(&self) -> bool {
        self.score >= LEAST_SCORE && self.differing <= MOST_DIFFERING
    }
}

/// Renders every case of `folder` and compares it with its accepted picture; those named in `bless` are accepted
/// instead. Scenes are found from `repository`.
///
/// # Errors
/// If files cannot be read or written, or a name to accept is no case. What merely fails is in the report.
pub fn run(repository: &Path, folder: &Path, bless: &[String]) -> Result<Report, GoldenError> {
    let failed = folder.join("failed");
    match fs::remove_dir_all(&failed) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(file_error(&failed)(error)),
        _ => {}
    }
    let (cases, strays) = list(folder)?;
    if let Some(name) = bless.iter().find(|name| !cases.contains(*name)) {
        return Err(GoldenError::NoSuchCase(name.clone()));
    }
    let mut report = Report::default();
    report.failures.extend(strays.iter().map(|stray| format!("{stray}: belongs to no case; remove it")));
    for name in cases {
        let accepted = folder.join(&name).with_extension("png");
        let actual = match picture(repository, &folder.join(&name).with_extension("args"))? {
            Ok(actual) => actual,
            Err(message) => {
                report.failures.push(format!("{name}: {message}"));
                continue;
            }
        };
        if bless.contains(&name) {
            save(&actual, &accepted)?;
            report.blessed.push(name.clone());
        }
        match judge(&name, &accepted, &actual, &failed)? {
            Ok(()) => report.passed += 1,
            Err(message) => report.failures.push(format!("{name}: {message}")),
        }
    }
    Ok(report)
}

/// The names of the cases, and the files that belong to none.
fn list(folder: &Path) -> Result<(BTreeSet<String>, BTreeSet<String>), GoldenError> {
    let mut files = BTreeSet::new();
    for entry in fs::read_dir(folder).map_err(file_error(folder))? {
        files.insert(PathBuf::from(entry.map_err(file_error(folder))?.file_name()));
    }
    let stem = |file: &PathBuf| file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let is = |file: &PathBuf, extension: &str| file.extension() == Some(OsStr::new(extension));
    let cases: BTreeSet<String> = files.iter().filter(|file| is(file, "args")).map(stem).collect();
    let strays =
        files.iter().filter(|file| !(is(file, "args") || is(file, "png") && cases.contains(&stem(file))));
    let strays = strays.map(|file| file.display().to_string()).collect();
    Ok((cases, strays))
}

/// The picture of a case, or why there is none.
fn picture(repository: &Path, case: &Path) -> Result<Result<RgbImage, String>, GoldenError> {
    let arguments = fs::read_to_string(case).map_err(file_error(case))?;
    let render = match line::render(repository, &arguments) {
        Ok(render) => render,
        Err(error) => return Ok(Err(error.to_string())),
    };
    Ok(csg_graph_cli::render::picture(&render).map_err(|failure: Failure| failure.to_string()))
}

/// Whether a picture is as accepted, or why not; then the evidence is written to `failed`.
fn judge(
    name: &str,
    accepted: &Path,
    actual: &RgbImage,
    failed: &Path,
) -> Result<Result<(), String>, GoldenError> {
    let write = |picture: &RgbImage, what: &str| {
        fs::create_dir_all(failed).map_err(file_error(failed))?;
        save(picture, &failed.join(format!("{name}.{what}.png")))
    };
    let (width, height) = actual.dimensions();
    if width.max(height) > MOST_PIXELS {
        return Ok(Err(format!("{width}×{height} pixels; a golden image has at most {MOST_PIXELS} a side")));
    }
    if !accepted.exists() {
        write(actual, "actual")?;
        return Ok(Err(format!("no accepted picture; look at {name}.actual.png in {}", failed.display())));
    }
    let bytes = fs::metadata(accepted).map_err(file_error(accepted))?.len();
    if bytes > MOST_BYTES {
        return Ok(Err(format!("{bytes} bytes; a golden image has at most {MOST_BYTES}")));
    }
    let expected = image::open(accepted).map_err(picture_error(accepted))?.to_rgb8();
    let Some(comparison) = Comparison::new(&expected, actual) else {
        write(&expected, "expected")?;
        write(actual, "actual")?;
        let (expected_width, expected_height) = expected.dimensions();
        return Ok(Err(format!("{width}×{height} pixels instead of {expected_width}×{expected_height}")));
    };
    if comparison.passes() {
        return Ok(Ok(()));
    }
    write(&expected, "expected")?;
    write(actual, "actual")?;
    write(&comparison.difference, "difference")?;
    Ok(Err(format!(
        "similarity {:.5}, {:.3} % of the pixels differ; see {}",
        comparison.score,
        100.0 * comparison.differing,
        failed.display()
    )))
}

fn save(picture: &RgbImage, path: &Path) -> Result<(), GoldenError> {
    csg_graph_cli::render::encode(picture)
        .map_err(picture_error(path))
        .and_then(|bytes| fs::write(path, bytes).map_err(file_error(path)))
}

fn file_error(path: &Path) -> impl Fn(io::Error) -> GoldenError + use<> {
    let path = path.to_owned();
    move |source| GoldenError::File { path: path.clone(), source }
}

fn picture_error(path: &Path) -> impl Fn(ImageError) -> GoldenError + use<> {
    let path = path.to_owned();
    move |source| GoldenError::Picture { path: path.clone(), source }
}
