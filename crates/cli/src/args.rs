//! The command line: what can be asked, and the help that teaches it.

mod bench;
mod bounds;
mod engine;
mod values;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, Parser, Subcommand, ValueEnum};
use csg_graph_grammar::Image;
use csg_graph_trace::{FEWEST_SAMPLES, Integrator, MAX_BOUNCES, MAX_PIXELS, MAX_SAMPLES, View};

use crate::Failure;

pub use bench::BenchArgs;
pub use bounds::{BooleansArg, BoundsArgs, MethodArg, Sweep, VolumeArg};
pub use engine::{BoxesArg, EngineArg, EngineArgs};
pub(crate) use engine::{Plan, USUAL_MEMORY};
use values::{assignment, picture_path, steps, stops, whole, zoom_factor};

/// Recursive solids, from a grammar file to a picture
///
/// A .pcsg file is a grammar whose words are solids: symbols with rules, parameters that steer them, and ∪, ∩ and \ of
/// transformed primitives. pcsg turns it into a cyclic graph of a few kilobytes, bounds every node of the graph, and ray
/// traces the graph as it is, without ever unfolding it.
#[derive(Debug, Parser)]
#[command(name = "pcsg", version, after_help = EXAMPLES)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  pcsg render tree.pcsg                        a picture: tree.png
  pcsg render tree.pcsg --set cnt=5 -o 5.png   the same with another parameter
  pcsg render bush.pcsg --seed 7               another one of its kind, where there are random numbers
  pcsg render tree.pcsg -o tree.exr            colours beyond a screen's, with depth, normals, and more in layers
  pcsg render tree.pcsg --samples 1000         a long one: Ctrl-C keeps what there is, --resume goes on from it
  pcsg render tree.pcsg --integrator path --samples 64
                                               the same in the light of the sky, from surface to surface
  pcsg check tree.pcsg                         mistakes, or how large the thing is
  pcsg bounds tree.pcsg                        the bounding boxes of all nodes
  pcsg bounds tree.pcsg --compare              all methods and volumes side by side
  pcsg bench tree.pcsg                         how fast it is traced
  pcsg graph tree.pcsg | dot -Tsvg > tree.svg  the graph as a drawing

A mistake in a file ends with exit code 1, a mistake in the command line with 2, an interrupted render with 130.";

/// The commands.
#[derive(Debug, Subcommand)]
#[non_exhaustive]
pub enum Command {
    /// Render a scene to a PNG or EXR picture
    ///
    /// The picture is named after the scene and written to the current folder, unless -o says otherwise. What the file
    /// does not say about the camera and the light is chosen so that the solid is well seen.
    Render(RenderArgs),
    /// Compute the bounding boxes of all nodes
    ///
    /// Each node of the graph gets its hyper bounding box: the union over all its instances, in the node's own frame. A
    /// transformation's box is in the frame that it maps into. --volume asks for other volumes than boxes, --compare for
    /// all of them side by side, and --plot draws how boxes grow with the recursion.
    Bounds(BoundsArgs),
    /// Find mistakes, or tell how large the solid is
    ///
    /// Reports every mistake that the text has, or else the first one that the recursion comes to. Without any, counts the
    /// states of the graph and, exactly, what it unfolds into, and shows that the recursion ends, or that it shrinks to a
    /// solid although it never ends.
    Check(CheckArgs),
    /// Measure how fast a scene is traced
    ///
    /// Sets the engine up, traces the primary rays alone, and makes the whole picture, each several times. Times named cpu
    /// are those that the tracing threads were running, which other programs on the machine disturb least.
    Bench(BenchArgs),
    /// Draw the graph of a scene, for Graphviz
    Graph(GraphArgs),
    /// Print a scene in the standard layout
    Fmt(FmtArgs),
    /// Print a completion script for a shell
    ///
    /// For example: pcsg completions bash > ~/.local/share/bash-completion/completions/pcsg
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// A scene file with parameters changed.
#[derive(Debug, Args)]
pub struct SceneArgs {
    /// The scene: a .pcsg file
    pub scene: PathBuf,
    /// Give an initial parameter another value
    ///
    /// EXPR is an expression of the language; it may use the parameters declared above NAME. Parameters that the file
    /// computes from NAME follow.
    #[arg(long, value_name = "NAME=EXPR", value_parser = assignment)]
    pub set: Vec<String>,
    /// The seed of all random numbers, in place of the file's: another seed, another of its kind
    ///
    /// A whole number below 2^53. It is what --set seed=N does, so that they may not differ.
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = whole::<u64>(0..=(1 << 53) - 1))]
    pub seed: Option<u64>,
    /// The most states to list
    ///
    /// Of a scene with more, check tells how large it may be, and the fast engine traces it without a list.
    #[arg(long, value_name = "N", allow_hyphen_values = true, default_value_t = csg_graph::Limits::default().states, value_parser = whole::<usize>(1..=u64::MAX))]
    pub max_states: usize,
}

impl SceneArgs {
    /// All assignments to initial parameters, of which the last to a parameter counts.
    ///
    /// # Errors
    /// If there are two options for the seed, and they give two.
    pub(crate) fn assignments(&self) -> Result<Vec<Setting>, Failure> {
        let set = self.set.iter().map(|text| Setting { option: "--set", text: text.clone() });
        let mut settings: Vec<Setting> = set.collect();
        let Some(seed) = self.seed else { return Ok(settings) };
        let own = Setting { option: "--seed", text: format!("seed={seed}") };
        if let Some(other) = settings.iter().rfind(|setting| setting.name() == own.name())
            && !other.has_value(seed)
        {
            return Err(Failure::Usage(format!(
                "--seed {seed} and --set {} give two seeds; leave one of them out",
                other.text
            )));
        }
        settings.push(own);
        Ok(settings)
    }
}

/// An assignment to an initial parameter.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    /// The option that makes it.
    pub(crate) option: &'static str,
    /// `NAME=EXPR`
    pub(crate) text: String,
}

impl Setting {
    /// The parameter that it sets.
    pub(crate) fn name(&self) -> &str {
        self.text.split('=').next().unwrap_or_default().trim()
    }

    /// Whether it says this number, not as an expression of others.
    fn has_value(&self, number: u64) -> bool {
        self.text.split_once('=').is_some_and(|(_, text)| text.trim().parse() == Ok(number as f64))
    }
}

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// What to render.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The picture to write; without it, the scene's name with .png, in the current folder
    ///
    /// A name that ends with .exr makes an OpenEXR file: the colours as they are in linear light, and in further layers
    /// what the ray through the centre of each pixel meets: depth, normal, position, recursion depth, node, state and box
    /// tests, and the number of the pixel's samples.
    #[arg(short, long, value_name = "OUT", value_parser = picture_path)]
    pub output: Option<PathBuf>,
    /// Width and height in pixels; without it what the scene says, or 512x512
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    pub size: Option<Size>,
    /// Rays a pixel; without it what the scene says, or 4; with --noise the most, and without it 256
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = whole::<u32>(1..=MAX_SAMPLES.into()))]
    pub samples: Option<u32>,
    /// Stop where the picture is known to within so many of the 255 steps from black to white
    ///
    /// A square of 4 by 4 pixels has enough samples, from 16 on, when the estimated errors of its pixels and of those
    /// around it are below this. What is smooth has few samples then, edges and what is random have many, up to --samples.
    /// 2 can hardly be seen. For the views shaded and normal.
    #[arg(long, value_name = "STEPS", allow_hyphen_values = true, value_parser = steps)]
    pub noise: Option<f64>,
    /// Go on from where an interrupted render of the same picture was, if there is any
    ///
    /// Ctrl-C ends a render soon: the picture of the samples so far is written, and beside it OUT.part, from which the same
    /// command with --resume goes on, to the same bytes as without interruption. The exit code is 130. A second Ctrl-C ends
    /// it at once. OUT.part is also written once a minute, so that no more than that is lost if the render is killed.
    #[arg(long)]
    pub resume: bool,
    /// Go so many times closer to the smallest part that is seen from where the scene's camera is
    ///
    /// That is what a ray meets after the deepest recursion; it comes to the middle of the picture.
    #[arg(long, value_name = "FACTOR", allow_hyphen_values = true, value_parser = zoom_factor)]
    pub zoom: Option<f64>,
    /// Threads; without it, one a core. The picture is the same for any number
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = whole::<u32>(1..=1024))]
    pub threads: Option<u32>,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t)]
    pub view: ViewArg,
    /// How light is computed; without it what the scene says, or direct
    #[arg(long, value_enum)]
    pub integrator: Option<IntegratorArg>,
    /// How often light is followed from surface to surface; without it what the scene says, or 16
    ///
    /// For direct, mirrors and glass count; for path, all surfaces.
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = whole::<u32>(1..=MAX_BOUNCES.into()))]
    pub bounces: Option<u32>,
    /// How much brighter the light is taken, in stops: each doubles it, -1 halves it; without it what the scene says, or 0
    ///
    /// The colours of an OpenEXR file are multiplied, too.
    #[arg(long, value_name = "STOPS", allow_hyphen_values = true, value_parser = stops)]
    pub exposure: Option<f64>,
    /// What finds the hits.
    #[command(flatten)]
    pub engine: EngineArgs,
    /// Write counts, times and the peak of the memory as JSON
    #[arg(long, value_name = "FILE.json")]
    pub stats: Option<PathBuf>,
}

impl RenderArgs {
    /// # Errors
    /// If something is said about light, and there is none in the view.
    pub(crate) fn check_view(&self) -> Result<(), Failure> {
        let said = self.integrator.map(|_| "--integrator").or(self.bounces.map(|_| "--bounces"));
        let said = said.or(self.exposure.map(|_| "--exposure"));
        match said.filter(|_| !matches!(self.view, ViewArg::Shaded | ViewArg::Plate)) {
            Some(said) => Err(Failure::Usage(format!(
                "{said} is about light, and this view shows none; leave out {said} or --view"
            ))),
            None => Ok(()),
        }
    }

    /// # Errors
    /// If noise has nothing to decide.
    pub(crate) fn check_noise(&self) -> Result<(), Failure> {
        if self.noise.is_none() {
            return Ok(());
        }
        if !matches!(self.view, ViewArg::Shaded | ViewArg::Normal) {
            return Err(Failure::Usage(
                "--noise judges pixels by their colours, and this view has those of the whole picture; leave out --noise or --view"
                    .to_owned(),
            ));
        }
        match self.samples {
            Some(samples) if samples <= FEWEST_SAMPLES => Err(Failure::Usage(format!(
                "--noise has nothing to decide: pixels have {FEWEST_SAMPLES} samples in any case, and --samples asks for {samples} at most"
            ))),
            _ => Ok(()),
        }
    }
}

/// The limit on bounding.
#[derive(Debug, Args)]
pub struct StepsArg {
    /// The most steps to take: boxes to compute (chain), nodes to visit (conventional, or by every ray without boxes)
    ///
    /// Without it 200 million, which may take a minute; 5 million for each of the many runs of --compare and --plot.
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = whole::<u64>(0..=u64::MAX))]
    pub max_steps: Option<u64>,
}

impl StepsArg {
    /// The limit of a command that runs an algorithm once.
    pub(crate) fn once(&self) -> u64 {
        self.max_steps.unwrap_or(csg_graph_bounds::Limits::default().steps)
    }

    /// The limit of each run of a command that runs many.
    pub(crate) fn each(&self) -> u64 {
        const QUICK: u64 = 5_000_000;
        self.max_steps.unwrap_or(QUICK)
    }
}

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |number: &str| number.trim().parse().ok().filter(|number: &u32| *number > 0);
        let size = text
            .split_once(['x', 'X', '×'])
            .and_then(|(width, height)| Some(Self { width: parse(width)?, height: parse(height)? }))
            .ok_or("write it as WIDTHxHEIGHT in pixels, for example 800x600")?;
        if size.width.max(size.height) > Image::MAX_SIDE {
            return Err(format!("a picture has at most {} pixels along a side", Image::MAX_SIDE));
        }
        if u64::from(size.width) * u64::from(size.height) > MAX_PIXELS {
            return Err(format!("a picture has at most {MAX_PIXELS} pixels"));
        }
        Ok(size)
    }
}

/// How a picture is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PictureFormat {
    /// What a screen shows.
    Png,
    /// What is known of each pixel.
    Exr,
}

impl PictureFormat {
    /// The format that the name of a file asks for.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let is = |extension: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension));
        match () {
            () if is("png") => Some(Self::Png),
            () if is("exr") => Some(Self::Exr),
            () => None,
        }
    }
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ViewArg {
    /// The solid in its light
    #[default]
    Shaded,
    /// The paper's colour plate: the background tells at which recursion depth rays were discarded, red and blue in
    /// turn, the brighter the deeper
    Plate,
    /// The direction that the surface faces
    Normal,
    /// The distance, near is bright
    Depth,
    /// How much work each pixel took
    Cost,
}

impl From<ViewArg> for View {
    fn from(view: ViewArg) -> Self {
        match view {
            ViewArg::Shaded => Self::Shaded,
            ViewArg::Plate => Self::Plate,
            ViewArg::Normal => Self::Normal,
            ViewArg::Depth => Self::Depth,
            ViewArg::Cost => Self::Cost,
        }
    }
}

/// How light is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum IntegratorArg {
    /// Light from lights and the sun straight to the surface, with mirror images and refraction: sharp and quick
    Direct,
    /// Global illumination: light from the sky, the sun and emissive surfaces, and from one surface to another. Noisy with
    /// few samples; take 64 or more
    Path,
}

impl From<IntegratorArg> for Integrator {
    fn from(integrator: IntegratorArg) -> Self {
        match integrator {
            IntegratorArg::Direct => Self::Direct,
            IntegratorArg::Path => Self::Path,
        }
    }
}

/// For whom to print.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// A table for people
    #[default]
    Table,
    /// JSON for programs
    Json,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// What to check.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// How to print the counts
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `graph`.
#[derive(Debug, Args)]
pub struct GraphArgs {
    /// What to draw.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The language of the drawing
    #[arg(long, value_enum, default_value_t)]
    pub format: GraphFormat,
}

/// A language for drawings of graphs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum GraphFormat {
    /// Graphviz: pipe it into `dot -Tsvg`
    #[default]
    Dot,
}

/// Arguments of `fmt`.
#[derive(Debug, Args)]
pub struct FmtArgs {
    /// The scene: a .pcsg file
    pub scene: PathBuf,
    /// Change the file itself instead of printing
    #[arg(long, conflicts_with = "check")]
    pub write: bool,
    /// Print nothing; fail if the file is not in the standard layout
    #[arg(long)]
    pub check: bool,
}
