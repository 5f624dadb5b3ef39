//! OpenEXR files: the colours in linear light, and in further layers what the primary rays meet.
//!
//! The first layer is the picture, for programs that read no other. Numbers are stored as they are computed: colours beyond
//! what a screen shows, depths in units of the scene, nodes by the numbers that `pcsg graph` shows, states by those of `pcsg bounds --states`.

use std::collections::HashMap;
use std::io::Cursor;

use csg_graph_trace::{Film, Probe};
use exr::error::Error;
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::{ImageAttributes, LayerAttributes};

use crate::load::Loaded;

/// What stands for no node and no state.
const NOTHING: u32 = u32::MAX;

/// What made the file.
const SOFTWARE: &str = concat!("pcsg ", env!("CARGO_PKG_VERSION"));

/// A picture and its probes as an OpenEXR file, which says what it shows.
///
/// # Errors
/// If the picture is larger than the format allows.
pub(super) fn encode(
    film: &Film,
    samples: Vec<u32>,
    probes: &[Probe],
    loaded: &Loaded,
) -> Result<Vec<u8>, Error> {
    let colours = film.pixels();
    let colour = |index: usize| floats(colours.iter().map(move |colour| colour[index]));
    let normal = |index: usize| floats(probes.iter().map(move |probe| probe.normal[index]));
    let position = |index: usize| floats(probes.iter().map(move |probe| probe.position[index]));
    let node =
        |probe: &Probe| probe.node.and_then(|node| u32::try_from(node.index()).ok()).unwrap_or(NOTHING);
    let size = (film.width() as usize, film.height() as usize);
    let layer = |name: &str, channels: Vec<(&str, FlatSamples)>| {
        let mut attributes = LayerAttributes::named(text(name));
        attributes.software_name = Some(text(SOFTWARE));
        let set = loaded.set().collect::<Vec<_>>().join("; ");
        if !set.is_empty() {
            say(&mut attributes.other, "parameters", &set);
        }
        let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(text(name), samples));
        Layer::new(size, attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(channels.collect()))
    };
    let layers = vec![
        layer("colour", vec![("R", colour(0)), ("G", colour(1)), ("B", colour(2))]),
        layer("depth", vec![("Z", floats(probes.iter().map(|probe| probe.depth)))]),
        layer("normal", vec![("X", normal(0)), ("Y", normal(1)), ("Z", normal(2))]),
        layer("position", vec![("X", position(0)), ("Y", position(1)), ("Z", position(2))]),
        layer("recursion", vec![("depth", counts(probes.iter().map(|probe| probe.recursion)))]),
        layer("node", vec![("id", counts(probes.iter().map(node)))]),
        layer("state", vec![("id", counts(probes.iter().map(|probe| probe.state.unwrap_or(NOTHING))))]),
        layer("samples", vec![("count", FlatSamples::U32(samples))]),
        layer("box_tests", vec![("count", counts(probes.iter().map(|probe| probe.box_tests)))]),
    ];
    let mut attributes = ImageAttributes::with_size(size);
    // Of two attributes in one map, either is written first. Those that all layers share are in a map of their own.
    say(&mut attributes.other, "scene", &loaded.file_name());
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layers(attributes, layers).write().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

fn say(attributes: &mut HashMap<Text, AttributeValue>, name: &str, value: &str) {
    attributes.insert(text(name), AttributeValue::Text(text(value)));
}

fn floats(values: impl Iterator<Item = f32>) -> FlatSamples {
    FlatSamples::F32(values.collect())
}

fn counts(values: impl Iterator<Item = u32>) -> FlatSamples {
    FlatSamples::U32(values.collect())
}

/// Text as the format has it: bytes, which are meant as UTF-8.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}
