//! Checkpoints: a picture in the making as a file beside its place, `tree.png.part`, from which `--resume` goes on.
//!
//! ```text
//! "pcsg checkpoint\n"   16 bytes
//! 2                     u32: the version of this layout
//! length, text          u32 and UTF-8: what picture it is of, as JSON pairs of names and values
//! the picture           as csg_graph_trace::LatentImage saves it, to the end but for
//! checksum              u32: CRC-32 of all before
//! ```
//!
//! Numbers are little-endian. What picture it is of is everything that its bytes depend on, the text of the scene first of
//! all. To go on with anything else would make a picture of neither, and is refused.

use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use csg_graph_trace::{LatentImage, Settings};

use crate::args::{MethodArg, Plan};
use crate::stage::Stage;
use crate::{Failure, output};

const MAGIC: &[u8; 16] = b"pcsg checkpoint\n";

const LAYOUT: u32 = 2;

/// The name of what is the text of a scene, which is too long for a message.
const SCENE: &str = "scene";

/// Where the checkpoint of a picture is, and what picture that is.
pub(super) struct Checkpoint {
    path: PathBuf,
    identity: Vec<(String, String)>,
}

/// The checkpoint of a picture is beside it.
pub(super) fn path_of(picture: &Path) -> PathBuf {
    let mut name = picture.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

impl Checkpoint {
    pub(super) fn new(
        path: &Path,
        stage: &Stage<'_>,
        plan: Plan,
        zoom: Option<f64>,
        settings: &Settings,
    ) -> Self {
        let Settings { width, height, samples, noise, view, integrator, bounces, exposure } = settings;
        let or_none = |value: Option<String>| value.unwrap_or_else(|| "none".to_owned());
        let (budget, resolution, detail, memory) = match plan {
            Plan::Reference { .. } => (None, None, None, None),
            Plan::Fast { budget, detail, memory } => (Some(budget), None, detail, Some(memory)),
            Plan::Grid { budget, resolution } => (Some(budget), resolution, None, None),
        };
        let set = stage.loaded.set().collect::<Vec<_>>().join("; ");
        let identity = [
            ("program", concat!("pcsg ", env!("CARGO_PKG_VERSION")).to_owned()),
            (SCENE, stage.loaded.source().to_owned()),
            ("set", or_none(Some(set).filter(|set| !set.is_empty()))),
            ("size", format!("{width}x{height}")),
            ("samples", samples.to_string()),
            ("noise", or_none(noise.map(|noise| noise.to_string()))),
            ("view", format!("{view:?}").to_lowercase()),
            ("integrator", format!("{integrator:?}").to_lowercase()),
            ("bounces", bounces.to_string()),
            ("exposure", exposure.to_string()),
            ("zoom", or_none(zoom.map(|factor| factor.to_string()))),
            ("regime", stage.regime.to_string()),
            ("engine", stage.prepared.kind().to_string()),
            ("boxes", or_none(stage.prepared.method.map(|method| MethodArg::name(method).to_owned()))),
            ("budget", or_none(budget.map(|bytes| bytes.to_string()))),
            ("detail", or_none(detail.map(|pixels| pixels.to_string()))),
            ("memory", or_none(memory.map(|bytes| bytes.to_string()))),
            ("resolution", or_none(resolution.map(|voxels| voxels.to_string()))),
        ];
        Self {
            path: path.to_owned(),
            identity: identity.map(|(name, value)| (name.to_owned(), value)).into(),
        }
    }

    /// Keeps a picture, in place of what was kept before.
    pub(super) fn save(&self, image: &LatentImage) -> Result<(), Failure> {
        let identity = serde_json::to_string(&self.identity).expect("text is JSON");
        output::write_with(&self.path, |file| {
            let mut to = Summed::new(BufWriter::new(file));
            to.write_all(MAGIC)?;
            to.write_all(&LAYOUT.to_le_bytes())?;
            let length = u32::try_from(identity.len()).map_err(io::Error::other)?;
            to.write_all(&length.to_le_bytes())?;
            to.write_all(identity.as_bytes())?;
            image.save(&mut to)?;
            let sum = to.sum.finalize();
            to.inner.write_all(&sum.to_le_bytes())?;
            to.inner.flush()
        })
    }

    /// What was kept, if there is anything.
    pub(super) fn load(&self, settings: &Settings) -> Result<Option<LatentImage>, Failure> {
        let reading = |error| Failure::file(&self.path, "read it")(error);
        let mut file = match File::open(&self.path) {
            Ok(file) => BufReader::new(file),
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(reading(error)),
        };
        let refused = |reason: &str| {
            Failure::refused(&self.path, format!("{reason}; remove it, and the picture is begun again"))
        };
        let start: Option<[u8; MAGIC.len()]> = next(&mut file).map_err(reading)?;
        if start.as_ref() != Some(MAGIC) {
            return Err(refused("it is no checkpoint"));
        }
        match next(&mut file).map_err(reading)?.map(u32::from_le_bytes) {
            Some(LAYOUT) => {}
            Some(other) => return Err(refused(&format!("its layout has version {other}, not {LAYOUT}"))),
            None => return Err(refused(DAMAGED)),
        }
        if !is_whole(&self.path).map_err(reading)? {
            return Err(refused(DAMAGED));
        }

        let identity = identity(&mut file).map_err(|_| refused(DAMAGED))?;
        let differences = self.differences(&identity);
        if !differences.is_empty() {
            return Err(refused(&format!("it is of another picture: {}", differences.join(", "))));
        }
        let image = LatentImage::load(settings, &mut file)
            .map_err(|error| refused(&format!("it does not hold such a picture: {error}")))?;
        let mut rest = Vec::new();
        file.read_to_end(&mut rest).map_err(reading)?;
        if rest.len() == size_of::<u32>() { Ok(Some(image)) } else { Err(refused(DAMAGED)) }
    }

    /// Removes what was kept, if anything was.
    pub(super) fn remove(&self) -> Result<(), Failure> {
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                Err(Failure::file(&self.path, "remove it")(error))
            }
            _ => Ok(()),
        }
    }

    /// What is different in another picture, for people.
    fn differences(&self, other: &[(String, String)]) -> Vec<String> {
        if self.identity.len() != other.len() {
            return vec!["it says other things of itself".to_owned()];
        }
        let pairs = self.identity.iter().zip(other).filter(|(own, other)| own != other);
        pairs
            .map(|((name, own), (_, other))| {
                if name == SCENE {
                    "the scene has changed since".to_owned()
                } else {
                    format!("{name} was {other} and is {own}")
                }
            })
            .collect()
    }
}

const DAMAGED: &str = "it is damaged or not complete";

/// Whether the last bytes of a file are the checksum of the others.
fn is_whole(path: &Path) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let size = size_of::<u32>() as u64;
    let Some(length) = file.metadata()?.len().checked_sub(size) else { return Ok(false) };
    let mut summed = Summed::new(io::sink());
    io::copy(&mut Read::by_ref(&mut file).take(length), &mut summed)?;
    Ok(next(&mut file)?.map(u32::from_le_bytes) == Some(summed.sum.finalize()))
}

/// What picture it is of.
fn identity(from: &mut impl Read) -> io::Result<Vec<(String, String)>> {
    let length = next(from)?.map(u32::from_le_bytes).ok_or(ErrorKind::UnexpectedEof)?;
    let mut text = Vec::new();
    from.take(length.into()).read_to_end(&mut text)?;
    serde_json::from_slice(&text).map_err(io::Error::other)
}

/// The next bytes, or `None` if there are not so many.
fn next<const N: usize>(from: &mut impl Read) -> io::Result<Option<[u8; N]>> {
    let mut bytes = [0; N];
    match from.read_exact(&mut bytes) {
        Ok(()) => Ok(Some(bytes)),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(error),
    }
}

/// A writer that sums up what goes through it.
struct Summed<W> {
    inner: W,
    sum: crc32fast::Hasher,
}

impl<W> Summed<W> {
    fn new(inner: W) -> Self {
        Self { inner, sum: crc32fast::Hasher::new() }
    }
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.inner.write(bytes)?;
        self.sum.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
