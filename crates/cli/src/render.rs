//! `pcsg render`: a scene as a picture.

mod stage;
mod stats;

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::time::Instant;

use csg_graph_trace::{Film, RenderError, render};
use image::{ImageError, ImageFormat, RgbImage};

use crate::args::RenderArgs;
use crate::load::{Loaded, load};
use crate::progress::Bar;
use crate::{Failure, output, progress};
use stage::Stage;
use stats::Stats;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
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
    let (image, measured) = trace(loaded, args)?;
    let bytes =
        encode(&image).map_err(|error| Failure::file(&path, "write it")(std::io::Error::other(error)))?;
    output::write(&path, &bytes)?;
    progress::tell(format_args!("{}: {} × {} pixels", path.display(), image.width(), image.height()));
    args.stats.as_deref().map_or(Ok(()), |stats| output::write(stats, measured.to_json().as_bytes()))
}

/// The picture that `render` would write.
///
/// # Errors
/// If the scene has mistakes, which are reported, or asks for what cannot be done.
pub fn picture(args: &RenderArgs) -> Result<RgbImage, Failure> {
    trace(load(&args.scene)?, args).map(|(image, _)| image)
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

fn trace(loaded: Loaded, args: &RenderArgs) -> Result<(RgbImage, Stats), Failure> {
    let stage = Stage::set(loaded, args)?;
    let world = stage.world();
    let start = Instant::now();
    let bar = Bar::new(u64::from(stage.settings.width) * u64::from(stage.settings.height));
    let threads = args.threads.map_or(0, |threads| threads as usize);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| stage.loaded.refused(format!("cannot start the threads: {error}")))?;
    let rendered = pool.install(|| render(&world, &stage.settings, &|done| bar.show(done)));
    drop(bar);
    let (film, counters) = rendered.map_err(|error| match error {
        RenderError::Eval(error) => stage.loaded.failure(&error.into()),
        other => stage.loaded.refused(other),
    })?;
    let stats = Stats::new(&stage, &counters, pool.current_num_threads(), start.elapsed());
    Ok((to_image(&film), stats))
}

fn to_image(film: &Film) -> RgbImage {
    let image = RgbImage::from_raw(film.width(), film.height(), film.to_srgb8());
    image.expect("a film has three bytes a pixel")
}
