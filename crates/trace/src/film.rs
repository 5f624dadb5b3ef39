//! The picture.

use crate::srgb;

/// A picture in linear light, row by row from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl Film {
    /// # Panics
    /// If there are not `width` times `height` pixels.
    pub(crate) fn new(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Self {
        assert_eq!(pixels.len() as u64, u64::from(width) * u64::from(height), "pixels of a film");
        Self { width, height, pixels }
    }

    /// In pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// In pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Red, green and blue of all pixels. A screen shows 0 to 1; brighter ones are kept.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// The picture for a screen: sRGB, three bytes a pixel, row by row. The same bytes on every machine.
    pub fn to_srgb8(&self) -> Vec<u8> {
        let bytes = srgb::Bytes::new();
        let mut picture = Vec::with_capacity(3 * self.pixels.len());
        for pixel in &self.pixels {
            picture.extend_from_slice(&pixel.map(|channel| bytes.encode(channel)));
        }
        picture
    }
}
