//! The figures of the documents: each is what a command draws. What can be the same twice must be what it draws now.

mod memory;

use std::path::Path;
use std::process::ExitCode;
use std::{fs, io};

use csg_graph_cli::bounds::Cost;
use csg_graph_cli::{BenchArgs, BoundsArgs, Failure};
use image::{GenericImage, Rgb, RgbImage};

use crate::example::{cargo_run, printed};
use crate::golden::Comparison;
use crate::{exit_code, line};

/// Drawings of boxes, by their names in `docs/figures`, and the arguments of `pcsg bounds` that draw them.
const GROWTHS: [(&str, &str); 1] = [("sympodial_growth.svg", "scenes/sympodial.pcsg --sweep cnt=0..12")];

/// Drawings of costs, and the arguments of `pcsg bench`. They are measured, so that nobody can check them.
const COSTS: [(&str, &str); 5] = [
    ("cost_sympodial.svg", "scenes/peers/sympodial.pcsg --reps 3 --sweep cnt=4..60"),
    ("cost_sierpinski.svg", "scenes/peers/sierpinski.pcsg --reps 3 --sweep n=4..40"),
    ("cost_cheese.svg", "scenes/peers/cheese.pcsg --reps 1 --sweep n=2..20"),
    ("cost_size.svg", "scenes/peers/sympodial.pcsg --set cnt=20 --reps 1 --sweep log2(side)=5..10"),
    ("cost_budget.svg", "scenes/peers/sympodial.pcsg --set cnt=20 --reps 1 --sweep log2(budget)=12..24"),
];

/// The drawing of what boxes cost, and the example of the crate of bounds that measures it.
const STATES: (&str, &str) = ("cost_states.svg", "states");

/// Ten times closer in each picture, row by row: the sheet, the scene with the arguments of `pcsg render`, the pictures,
/// and how many stand in a row.
const ZOOM: (&str, &str, u32, u32) =
    ("zoom.png", "scenes/peers/sympodial.pcsg --set cnt=60 --samples 9 --size 160x160", 10, 5);

/// What never ends, a hundred times closer in each picture of a row: the sheet, the scenes, the arguments of `pcsg render`,
/// and how many stand in a row.
const ENDLESS: (&str, [&str; 3], &str, u32) = (
    "zoom_endless.png",
    ["scenes/endless/sierpinski.pcsg", "scenes/endless/fern.pcsg", "scenes/endless/menger.pcsg"],
    "--integrator direct --samples 9 --size 160x160",
    4,
);

/// A picture, the same one with parts below a pixel left out, and how far they differ, four times as bright.
const DETAIL: (&str, &str) =
    ("detail.png", "scenes/peers/sympodial.pcsg --set cnt=60 --samples 16 --size 320x320");

/// Why a figure is not as it should be.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// It cannot be drawn.
    #[error(transparent)]
    Drawing(#[from] Failure),
    /// Its file cannot be read or written.
    #[error("docs/figures/{0}: {1}")]
    File(&'static str, io::Error),
    /// The program that measures it does not.
    #[error("docs/figures/{0}: what measures it fails: {1}")]
    Measurement(&'static str, io::Error),
    /// Its file is no picture, or cannot become one.
    #[error("docs/figures/{0}: {1}")]
    Picture(&'static str, image::ImageError),
    /// There is none of that name.
    #[error("docs/figures has no `{0}` that a command draws")]
    NoSuchFigure(String),
    /// Its file holds another drawing.
    #[error(
        "docs/figures/{0} is not what its command draws now; look at `cargo xtask figures` and its difference"
    )]
    Stale(&'static str),
}

/// The arguments above are right.
const SOUND: &str = "the command of a figure is sound";

/// Draws the figures of a repository again, or those among them that are named, or checks that this would not change those that
/// can be drawn twice.
///
/// # Errors
/// If a name is none of theirs, or one cannot be drawn, read or written, or is checked and stale.
pub fn figures(repository: &Path, names: &[String], check: bool) -> Result<(), FigureError> {
    let sheets: [(_, fn(&Path) -> _); 3] = [(ZOOM.0, zoom), (ENDLESS.0, endless), (DETAIL.0, detail)];
    let drawings = GROWTHS.iter().chain(&COSTS).map(|(name, _)| *name).chain([STATES.0, memory::NAME]);
    let all: Vec<_> = drawings.chain(sheets.map(|(name, _)| name)).collect();
    if let Some(name) = names.iter().find(|name| !all.contains(&name.as_str())) {
        return Err(FigureError::NoSuchFigure(name.clone()));
    }
    let is_asked = |figure: &str| names.is_empty() || names.iter().any(|name| name == figure);
    let folder = repository.join("docs/figures");
    for (name, arguments) in GROWTHS.into_iter().filter(|(name, _)| is_asked(name)) {
        let mut args: BoundsArgs = line::parse(&format!("{arguments} --plot {name}")).expect(SOUND);
        args.scene.scene = repository.join(&args.scene.scene);
        let drawing = csg_graph_cli::bounds::drawing(&args)?;
        let file = |error| FigureError::File(name, error);
        if !check {
            fs::write(folder.join(name), drawing).map_err(file)?;
        } else if fs::read_to_string(folder.join(name)).map_err(file)? != drawing {
            return Err(FigureError::Stale(name));
        }
    }
    for (name, draw) in sheets.into_iter().filter(|(name, _)| is_asked(name)) {
        let sheet = draw(repository)?;
        let picture = |error| FigureError::Picture(name, error);
        if !check {
            let bytes = csg_graph_cli::render::encode(&sheet).map_err(picture)?;
            fs::write(folder.join(name), bytes).map_err(|error| FigureError::File(name, error))?;
            continue;
        }
        let accepted = image::open(folder.join(name)).map_err(picture)?.to_rgb8();
        if !Comparison::new(&accepted, &sheet).is_some_and(|comparison| comparison.passes()) {
            return Err(FigureError::Stale(name));
        }
    }
    if check {
        return Ok(());
    }
    for (name, arguments) in COSTS.into_iter().filter(|(name, _)| is_asked(name)) {
        let mut args: BenchArgs = line::parse(&format!("{arguments} --plot {name}")).expect(SOUND);
        args.scene.scene = repository.join(&args.scene.scene);
        let drawing = csg_graph_cli::bench::drawing(&args)?;
        fs::write(folder.join(name), drawing).map_err(|error| FigureError::File(name, error))?;
    }
    let (name, _) = STATES;
    if is_asked(name) {
        fs::write(folder.join(name), states()?).map_err(|error| FigureError::File(name, error))?;
    }
    let name = memory::NAME;
    if is_asked(name) {
        let drawing = memory::drawing().map_err(|error| FigureError::Measurement(name, error))?;
        fs::write(folder.join(name), drawing).map_err(|error| FigureError::File(name, error))?;
    }
    Ok(())
}

/// The drawing of what boxes cost by the number of states.
fn states() -> Result<String, FigureError> {
    let (name, example) = STATES;
    let failed = |error| FigureError::Measurement(name, error);
    let table = printed(&mut cargo_run("csg-graph-bounds", ["--example", example])).map_err(failed)?;
    let row = |line: &str| {
        let [scene, _, states, seconds, bytes] = line.split_whitespace().collect::<Vec<_>>()[..] else {
            return None;
        };
        Some(Cost::new(scene, states.parse().ok()?, seconds.parse().ok()?, bytes.parse().ok()?))
    };
    let costs: Option<Vec<Cost>> = table.lines().skip(1).map(row).collect();
    let costs = costs.ok_or_else(|| failed(io::Error::other(table.clone())))?;
    let command = format!("cargo run --release -p csg-graph-bounds --example {example}");
    Ok(csg_graph_cli::bounds::costs_drawing(&costs, &command))
}

/// The pictures of the zoom on one sheet.
fn zoom(repository: &Path) -> Result<RgbImage, FigureError> {
    let (name, arguments, count, across) = ZOOM;
    let picture = |number| render(repository, &format!("{arguments} --zoom 1e{number}"));
    sheet(name, (0..count).map(picture), across)
}

/// The pictures of what never ends on one sheet.
fn endless(repository: &Path) -> Result<RgbImage, FigureError> {
    let (name, scenes, arguments, across) = ENDLESS;
    let pictures = scenes.iter().flat_map(|scene| {
        (0..across).map(move |number| {
            // The first is not turned to what the others are of.
            let zoom = if number == 0 { String::new() } else { format!("--zoom 1e{}", 2 * number) };
            render(repository, &format!("{scene} {arguments} {zoom}"))
        })
    });
    sheet(name, pictures, across)
}

/// The pictures with and without small parts on one sheet, and their difference.
fn detail(repository: &Path) -> Result<RgbImage, FigureError> {
    let (name, arguments) = DETAIL;
    let [all, large] = ["", "--detail 1"].map(|more| render(repository, &format!("{arguments} {more}")));
    let (all, large) = (all?, large?);
    let difference = RgbImage::from_fn(all.width(), all.height(), |x, y| {
        let [one, other] = [&all, &large].map(|picture| picture.get_pixel(x, y).0);
        Rgb([0, 1, 2].map(|channel: usize| one[channel].abs_diff(other[channel]).saturating_mul(4)))
    });
    sheet(name, [Ok(all), Ok(large), Ok(difference)].into_iter(), 3)
}

fn render(repository: &Path, arguments: &str) -> Result<RgbImage, FigureError> {
    let args = line::render(repository, arguments).expect(SOUND);
    Ok(csg_graph_cli::render::picture(&args)?)
}

/// Pictures of one size in rows.
fn sheet(
    name: &'static str,
    pictures: impl Iterator<Item = Result<RgbImage, FigureError>>,
    across: u32,
) -> Result<RgbImage, FigureError> {
    let pictures = pictures.collect::<Result<Vec<_>, _>>()?;
    let (width, height) = pictures.first().map_or((0, 0), RgbImage::dimensions);
    let rows = pictures.len().div_ceil(across as usize);
    let mut sheet = RgbImage::new(across * width, u32::try_from(rows).expect("a few rows") * height);
    for (picture, number) in pictures.iter().zip(0..) {
        let at = (number % across * width, number / across * height);
        sheet.copy_from(picture, at.0, at.1).map_err(|error| FigureError::Picture(name, error))?;
    }
    Ok(sheet)
}

/// The chore.
pub fn run(repository: &Path, names: &[String], check: bool) -> ExitCode {
    exit_code(figures(repository, names, check))
}
