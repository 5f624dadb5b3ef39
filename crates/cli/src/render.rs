//! `pcsg render`: a scene as a picture.

mod layers;
mod stats;

use std::error::Error;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use std::time::Instant;

use csg_graph_trace::{Film, Probe, Settings, render, survey};
use image::{ImageError, ImageFormat, RgbImage};

use crate::args::{PictureFormat, RenderArgs};
use crate::load::{Loaded, load};
use crate::progress::Bar;
use crate::stage::Stage;
use crate::{Failure, output, progress};
use stats::Stats;

/// The size of a picture that nobody asked for, in pixels.
const DEFAULT_SIZE: u32 = 512;
/// The rays a pixel that nobody asked for.
const DEFAULT_SAMPLES: u32 = 4;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    // What is wrong with the arguments is said before anything of the file.
    args.engine.plan(args.view)?;
    let path = args.output.clone().unwrap_or_else(|| picture_path(&args.scene.scene));
    let loaded = load(&args.scene)?;
    let outputs: Vec<&Path> = [Some(path.as_path()), args.stats.as_deref()].into_iter().flatten().collect();
    for (index, output) in outputs.iter().enumerate() {
        let taken = outputs[..index].iter().copied().chain([args.scene.scene.as_path()]);
        if taken.into_iter().any(|taken| output::is_same(taken, output)) {
            return Err(Failure::refused(output, "it would be written over another file of this command"));
        }
        output::check_writable(output)?;
    }
    let has_layers = PictureFormat::of(&path) == Some(PictureFormat::Exr);
    let Picture { film, probes, stats } = trace(&loaded, args, has_layers)?;
    let bytes = match probes {
        Some(probes) => layers::encode(&film, &probes, &loaded).map_err(unwritable(&path))?,
        None => encode(&to_image(&film)).map_err(unwritable(&path))?,
    };
    output::write(&path, &bytes)?;
    progress::tell(format_args!("{}: {} × {} pixels", path.display(), film.width(), film.height()));
    args.stats.as_deref().map_or(Ok(()), |path| output::write(path, stats.to_json().as_bytes()))
}

/// The picture that `render` would write.
///
/// # Errors
/// If the scene has mistakes, which are reported, or asks for what cannot be done.
pub fn picture(args: &RenderArgs) -> Result<RgbImage, Failure> {
    trace(&load(&args.scene)?, args, false).map(|picture| to_image(&picture.film))
}

/// A picture as a PNG file.
///
/// # Errors
/// If the picture is larger than the format allows.
pub fn encode(image: &RgbImage) -> Result<Vec<u8>, ImageError> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// The scene's name with `.png`, in the current folder.
fn picture_path(scene: &Path) -> PathBuf {
    let mut name = PathBuf::from(scene.file_name().unwrap_or(scene.as_os_str()));
    name.set_extension("png");
    name
}

fn unwritable<E: Error + Send + Sync + 'static>(path: &Path) -> impl Fn(E) -> Failure {
    move |error| Failure::file(path, "write it")(io::Error::other(error))
}

struct Picture {
    film: Film,
    /// What primary rays meet, if it was asked for.
    probes: Option<Vec<Probe>>,
    stats: Stats,
}

fn trace(loaded: &Loaded, args: &RenderArgs, has_layers: bool) -> Result<Picture, Failure> {
    let settings = settings(loaded, args);
    let Settings { width, height, .. } = settings;
    let mut stage = Stage::set(loaded, args.engine.plan(args.view)?, f64::from(width) / f64::from(height))?;
    let pool = stage.threads(args.threads.unwrap_or(0))?;
    if let Some(factor) = args.zoom {
        pool.install(|| stage.zoom(factor))?;
    }
    let world = stage.world();
    let start = Instant::now();
    let bar = Bar::new(u64::from(width) * u64::from(height));
    let rendered = pool.install(|| {
        let (film, counters) = render(&world, &settings, &|done| bar.show(done))?;
        let probes = has_layers.then(|| survey(&world, width, height)).transpose()?;
        Ok((film, counters, probes))
    });
    drop(bar);
    let (film, counters, probes) = rendered.map_err(|error| stage.failure(error))?;
    let stats = Stats::new(&stage, &settings, &counters, pool.current_num_threads(), start.elapsed());
    Ok(Picture { film, probes, stats })
}

/// What the command line says, or else the file, or else the defaults.
fn settings(loaded: &Loaded, args: &RenderArgs) -> Settings {
    let image = &loaded.scene.look.image;
    let (width, height) = match args.size {
        Some(size) => (size.width, size.height),
        None => (image.width.unwrap_or(DEFAULT_SIZE), image.height.unwrap_or(DEFAULT_SIZE)),
    };
    let samples = args.samples.or(image.samples).unwrap_or(DEFAULT_SAMPLES);
    Settings { width, height, samples, view: args.view.into() }
}

fn to_image(film: &Film) -> RgbImage {
    let image = RgbImage::from_raw(film.width(), film.height(), film.to_srgb8());
    image.expect("a film has three bytes a pixel")
}
