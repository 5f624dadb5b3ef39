//! `pcsg render`: a scene as a picture.

mod budgets;
mod checkpoint;
mod layers;
mod stats;

use std::error::Error;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use csg_graph_grammar::Image;
use csg_graph_trace::{
    Integrator, LatentImage, MAX_BOUNCES, MAX_EXPOSURE, MAX_PIXELS, MAX_SAMPLES, Probe, Settings, probe,
};
use image::{ImageError, ImageFormat, RgbImage};
use rayon::ThreadPool;

use crate::args::{PictureFormat, Plan, RenderArgs};
use crate::interrupt::Interrupt;
use crate::load::{Loaded, load};
use crate::progress::Bar;
use crate::stage::Stage;
use crate::{Failure, output, progress, say};
use checkpoint::Checkpoint;
use stats::Stats;

pub use budgets::{Budgeted, budgets_drawing};

// What a file may ask for is what can be rendered.
const _: () = assert!(
    Image::MAX_PIXELS == MAX_PIXELS
        && Image::MAX_SAMPLES == MAX_SAMPLES
        && Image::MAX_BOUNCES == MAX_BOUNCES
        && Image::MAX_EXPOSURE == MAX_EXPOSURE
);

/// The most rays a pixel where noise decides, and nobody asked for more or less.
const NOISY_SAMPLES: u32 = 256;
/// How often a picture in the making is kept.
const KEEPING: Duration = Duration::from_secs(60);

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    // What is wrong with the arguments is said before anything of the file.
    args.engine.plan(args.view)?;
    args.check_view()?;
    args.check_noise()?;
    let path = args.output.clone().unwrap_or_else(|| picture_path(&args.scene.scene));
    let part = checkpoint::path_of(&path);
    let interrupt = Interrupt::listen().map_err(|error| Failure::refused(&args.scene.scene, error))?;
    let loaded = interrupt.or_end(|| load(&args.scene))?;
    let outputs = [Some(path.as_path()), args.stats.as_deref(), Some(part.as_path())];
    let outputs: Vec<&Path> = outputs.into_iter().flatten().collect();
    for (index, output) in outputs.iter().enumerate() {
        let taken = outputs[..index].iter().copied().chain([args.scene.scene.as_path()]);
        if taken.into_iter().any(|taken| output::is_same(taken, output)) {
            return Err(Failure::refused(output, "it would be written over another file of this command"));
        }
        output::check_writable(output)?;
    }
    if !args.resume && part.exists() {
        let reason = "an interrupted render has left it; --resume goes on from there, or remove it";
        return Err(Failure::refused(&part, reason));
    }
    let work = interrupt.or_end(|| Work::new(&loaded, args))?;
    let checkpoint = Checkpoint::new(&part, &work.stage, work.plan, args.zoom, &work.settings);
    let kept = if args.resume { checkpoint.load(&work.settings)? } else { None };
    let mut image = kept.map_or_else(|| work.blank(), Ok)?;
    let is_complete = interrupt.or_soon(|| work.expose(&mut image, &interrupt, Some(&checkpoint)))?;
    // First what the work took longest for: whoever is impatient may end the rest.
    let kept = if is_complete { Ok(()) } else { checkpoint.save(&image) };

    let taken = image.samples_taken();
    if is_complete && image.hits() == 0 {
        work.stage.warn_of_nothing();
    }
    let probes = has_layers(args).then(|| work.probe()).transpose()?;
    let stats = work.stats(&image, taken);
    let bytes = match probes {
        Some(probes) => {
            let film = work.pool.install(|| image.develop());
            layers::encode(&film, image.samples(), &probes, &loaded).map_err(unwritable(&path))?
        }
        None => encode(&work.shown(&image)).map_err(unwritable(&path))?,
    };
    output::write(&path, &bytes)?;
    if let Some(path) = &args.stats {
        output::write(path, stats.to_json().as_bytes())?;
    }
    kept?;
    if !is_complete {
        let percent = 100.0 * taken as f64 / work.all_samples() as f64;
        return Err(Failure::Interrupted { picture: path, percent, checkpoint: part });
    }
    checkpoint.remove()?;
    let Settings { width, height, .. } = work.settings;
    progress::tell(format_args!("{}: {width} × {height} pixels", path.display()));
    Ok(())
}

/// The picture that `render` would write.
///
/// # Errors
/// If the scene has mistakes, which are reported, or asks for what cannot be done.
pub fn picture(args: &RenderArgs) -> Result<RgbImage, Failure> {
    let loaded = load(&args.scene)?;
    let work = Work::new(&loaded, args)?;
    let mut image = work.blank()?;
    work.expose(&mut image, &Interrupt::default(), None)?;
    Ok(work.shown(&image))
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

/// Whether the picture is written with all that is known of its pixels.
fn has_layers(args: &RenderArgs) -> bool {
    args.output.as_deref().and_then(PictureFormat::of) == Some(PictureFormat::Exr)
}

fn unwritable<E: Error + Send + Sync + 'static>(path: &Path) -> impl Fn(E) -> Failure {
    move |error| Failure::file(path, "write it")(io::Error::other(error))
}

/// A scene, what is to be made of it, and who does it.
struct Work<'a> {
    plan: Plan,
    settings: Settings,
    stage: Stage<'a>,
    pool: ThreadPool,
    start: Instant,
}

impl<'a> Work<'a> {
    fn new(loaded: &'a Loaded, args: &RenderArgs) -> Result<Self, Failure> {
        let settings = settings(loaded, args);
        let plan = args.engine.plan(args.view)?;
        let mut stage = Stage::set(loaded, plan, &settings, has_layers(args), args.engine.memory)?;
        let pool = stage.threads(args.threads.unwrap_or(0))?;
        if let Some(factor) = args.zoom {
            pool.install(|| stage.zoom(factor))?;
        }
        Ok(Self { plan, settings, stage, pool, start: Instant::now() })
    }

    /// A picture without any sample.
    fn blank(&self) -> Result<LatentImage, Failure> {
        LatentImage::new(&self.settings).map_err(|error| self.stage.failure(error))
    }

    /// Adds samples to a picture until it is complete or someone interrupts. Now and then it is kept, if there is a place.
    fn expose(
        &self,
        image: &mut LatentImage,
        interrupt: &Interrupt,
        checkpoint: Option<&Checkpoint>,
    ) -> Result<bool, Failure> {
        let world = self.stage.world();
        let bar = Bar::new(self.all_samples());
        loop {
            let start = Instant::now();
            let is_due = AtomicBool::new(false);
            let progress = |done| {
                bar.show(done);
                if checkpoint.is_some() && start.elapsed() > KEEPING {
                    is_due.store(true, Ordering::Relaxed);
                }
            };
            let stop = || is_due.load(Ordering::Relaxed) || interrupt.is_asked();
            let exposed = self.pool.install(|| image.expose(&world, &stop, &progress));
            let is_complete = exposed.map_err(|error| self.stage.failure(error))?;
            if is_complete || interrupt.is_asked() {
                return Ok(is_complete);
            }
            // Without it, a picture can still be made.
            if let Some(Err(failure)) = checkpoint.map(|checkpoint| checkpoint.save(image)) {
                say(format_args!("\x1b[1;93mwarning\x1b[0m: {failure}"));
            }
        }
    }

    /// What a screen shows of a picture.
    fn shown(&self, image: &LatentImage) -> RgbImage {
        let Settings { width, height, .. } = self.settings;
        let bytes = self.pool.install(|| image.to_srgb8());
        RgbImage::from_raw(width, height, bytes).expect("a picture has three bytes a pixel")
    }

    /// What primary rays meet.
    fn probe(&self) -> Result<Vec<Probe>, Failure> {
        let Settings { width, height, .. } = self.settings;
        let probes = self.pool.install(|| probe(&self.stage.world(), width, height));
        probes.map_err(|error| self.stage.failure(error))
    }

    fn stats(&self, image: &LatentImage, samples_taken: u64) -> Stats {
        let threads = self.pool.current_num_threads();
        let time = self.start.elapsed();
        Stats::new(&self.stage, &self.settings, samples_taken, image.counters(), threads, time)
    }

    /// The samples of all pixels, if none is saved.
    fn all_samples(&self) -> u64 {
        let Settings { width, height, samples, .. } = self.settings;
        u64::from(width) * u64::from(height) * u64::from(samples)
    }
}

/// What the command line says, or else the file, or else the defaults.
fn settings(loaded: &Loaded, args: &RenderArgs) -> Settings {
    let image = &loaded.scene.look.image;
    let default = Settings::default();
    let (width, height) = match args.size {
        Some(size) => (size.width, size.height),
        None => (image.width.unwrap_or(default.width), image.height.unwrap_or(default.height)),
    };
    let samples = match (args.samples, args.noise) {
        (Some(samples), _) => samples,
        (None, Some(_)) => NOISY_SAMPLES,
        (None, None) => image.samples.unwrap_or(default.samples),
    };
    let asked = args.integrator.map(Integrator::from).or(image.integrator.map(integrator));
    Settings {
        width,
        height,
        samples,
        noise: args.noise,
        view: args.view.into(),
        integrator: asked.unwrap_or(default.integrator),
        bounces: args.bounces.or(image.bounces).unwrap_or(default.bounces),
        exposure: args.exposure.or(image.exposure).unwrap_or(default.exposure),
    }
}

/// The integrator that a file asks for.
fn integrator(asked: csg_graph_grammar::Integrator) -> Integrator {
    match asked {
        csg_graph_grammar::Integrator::Path => Integrator::Path,
        _ => Integrator::Direct,
    }
}
