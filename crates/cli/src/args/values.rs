//! How values on the command line are read, and what is said of those that cannot be.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use csg_graph_trace::MAX_EXPOSURE;

use super::PictureFormat;

/// A whole number in a range.
pub(super) fn whole<N: TryFrom<u64>>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<N, String> + Clone + Send + Sync + 'static {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.and_then(|number| N::try_from(number).ok()).ok_or_else(|| match (range.start(), range.end()) {
            (0, &u64::MAX) => "write it as a whole number".to_owned(),
            (least, &u64::MAX) => format!("write it as a whole number, at least {least}"),
            (least, most) => format!("write it as a whole number from {least} to {most}"),
        })
    }
}

/// An assignment, whose expression is read with the scene.
pub(super) fn assignment(text: &str) -> Result<String, String> {
    match text.split_once('=') {
        Some((name, expr)) if !name.trim().is_empty() && !expr.trim().is_empty() => Ok(text.to_owned()),
        _ => Err("write it as NAME=EXPR, for example cnt=5".to_owned()),
    }
}

/// Steps from black to white.
pub(super) fn steps(text: &str) -> Result<f64, String> {
    let steps = text.parse().ok().filter(|steps: &f64| *steps > 0.0 && steps.is_finite());
    steps.ok_or_else(|| "write it as a number above 0, for example 2 or 0.5".to_owned())
}

/// How much brighter.
pub(super) fn stops(text: &str) -> Result<f64, String> {
    let stops = text.parse().ok().filter(|stops: &f64| stops.abs() <= MAX_EXPOSURE);
    stops.ok_or_else(|| {
        format!("write it as a number from -{MAX_EXPOSURE} to {MAX_EXPOSURE}, for example 1 or -0.5")
    })
}

/// How many times closer.
pub(super) fn zoom_factor(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(factor) if (1.0..=1e12).contains(&factor) => Ok(factor),
        _ => Err("a zoom is a number from 1 to 1e12, for example 1000".to_owned()),
    }
}

/// Where a picture goes.
pub(super) fn picture_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if PictureFormat::of(&path).is_some() {
        Ok(path)
    } else {
        Err("pictures are PNG or OpenEXR files: end the name with .png or .exr".to_owned())
    }
}

/// A part of a pixel, or some.
pub(super) fn pixels(text: &str) -> Result<f64, String> {
    let pixels = text.parse().ok().filter(|pixels: &f64| (0.0..=64.0).contains(pixels));
    pixels.ok_or_else(|| "write it as a number of pixels from 0 to 64, for example 0.5".to_owned())
}

/// A number of bytes, with or without a suffix.
pub(super) fn bytes(text: &str) -> Result<usize, String> {
    let (digits, unit) = match text.char_indices().last() {
        Some((end, 'k' | 'K')) => (&text[..end], 1 << 10),
        Some((end, 'm' | 'M')) => (&text[..end], 1 << 20),
        Some((end, 'g' | 'G')) => (&text[..end], 1 << 30),
        _ => (text, 1),
    };
    let count: usize = digits
        .parse()
        .map_err(|_| "write it as a number of bytes, for example 65536, 64K or 2M".to_owned())?;
    count.checked_mul(unit).ok_or_else(|| "so much memory cannot be addressed".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_say_their_range() {
        let few = whole::<u32>(1..=64);
        assert_eq!((few("1"), few("64")), (Ok(1), Ok(64)));
        for text in ["", "0", "65", "-1", "1.5", "x", "99999999999999999999"] {
            assert_eq!(few(text), Err("write it as a whole number from 1 to 64".to_owned()));
        }
        assert_eq!(whole::<u32>(1..=u64::MAX)("0"), Err("write it as a whole number, at least 1".to_owned()));
    }

    #[test]
    fn bytes_are_read_with_their_suffixes() {
        for (text, expected) in [("0", 0), ("300", 300), ("64K", 65_536), ("2m", 1 << 21), ("1G", 1 << 30)] {
            assert_eq!(bytes(text), Ok(expected));
        }
        for text in ["", "K", "1.5M", "-1", "64KB", "99999999999999999999", "99999999999999999G", "ä"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }
}
