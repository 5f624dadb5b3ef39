//! Pictures in tiles: squares of pixels, which threads take one after the other.
//!
//! What a tile shows depends on nothing but its place, and tiles are put together in order, so that any number of threads
//! gives the same bytes.

use std::ops::Range;

use crate::Beam;
use crate::camera::Lens;

/// Pixels on a side of a tile: enough work to be worth handing out, little enough to share the last tiles.
const SIDE: u32 = 16;

/// The tiles of a picture, numbered row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tiles {
    /// The picture's, in pixels.
    pub(crate) width: u32,
    /// The picture's, in pixels.
    pub(crate) height: u32,
}

/// The pixels of a tile. Those at the right and at the bottom may be smaller than others.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    columns: Range<u32>,
    rows: Range<u32>,
}

impl Tiles {
    pub(crate) fn count(self) -> u32 {
        self.across() * self.height.div_ceil(SIDE)
    }

    pub(crate) fn tile(self, index: u32) -> Tile {
        let range = |tile: u32, size: u32| tile * SIDE..size.min(tile.saturating_add(1).saturating_mul(SIDE));
        Tile {
            columns: range(index % self.across(), self.width),
            rows: range(index / self.across(), self.height),
        }
    }

    /// The pixels of all tiles, row by row of the picture.
    ///
    /// # Panics
    /// If these are not all tiles with all their pixels.
    pub(crate) fn in_rows<T>(self, tiles: &[Vec<T>]) -> impl Iterator<Item = &T> {
        let across = self.across();
        (0..self.height).flat_map(move |y| {
            (0..across).flat_map(move |x| {
                let index = y / SIDE * across + x;
                let tile = self.tile(index);
                let start = tile.place((tile.columns.start, y));
                &tiles[index as usize][start..start + tile.columns.len()]
            })
        })
    }

    fn across(self) -> u32 {
        self.width.div_ceil(SIDE)
    }
}

impl Tile {
    pub(crate) fn pixel_count(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// The rays through its pixels.
    pub(crate) fn beam(&self, lens: &Lens) -> Beam {
        lens.beam(&self.columns, &self.rows)
    }

    /// Where a pixel is among those of the tile, row by row.
    pub(crate) fn place(&self, (x, y): (u32, u32)) -> usize {
        (y - self.rows.start) as usize * self.columns.len() + (x - self.columns.start) as usize
    }

    /// The rows of pixels, and the columns of the picture that each has pixels in.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (u32, Range<usize>)> {
        self.rows.clone().map(|y| (y, self.columns.start as usize..self.columns.end as usize))
    }

    /// The first of the [squares](Self::squares) that have pixels in a row.
    pub(crate) fn first_square(&self, side: u32, y: u32) -> usize {
        (y - self.rows.start) as usize / side as usize * self.columns.len().div_ceil(side as usize)
    }

    /// The tile in squares with sides of `side` pixels: the pixels of each.
    pub(crate) fn squares(&self, side: u32) -> impl Iterator<Item = impl Iterator<Item = (u32, u32)>> {
        let part = move |start: u32, end: u32| start..end.min(start.saturating_add(side));
        let tops = self.rows.clone().step_by(side as usize);
        tops.flat_map(move |top| {
            let lefts = self.columns.clone().step_by(side as usize);
            lefts.map(move |left| {
                let columns = part(left, self.columns.end);
                part(top, self.rows.end).flat_map(move |y| columns.clone().map(move |x| (x, y)))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_and_squares_have_every_pixel_once() {
        for (width, height, side) in [(1, 1, 4), (16, 16, 4), (33, 18, 4), (20, 47, 1), (5, 40, 7)] {
            let tiles = Tiles { width, height };
            let pixels: Vec<Vec<(u32, u32)>> = (0..tiles.count())
                .map(|index| {
                    let tile = tiles.tile(index);
                    let mut pixels = vec![None; tile.pixel_count()];
                    for square in tile.squares(side) {
                        for pixel in square {
                            assert_eq!(pixels[tile.place(pixel)].replace(pixel), None);
                        }
                    }
                    pixels.into_iter().map(|pixel| pixel.expect("a square has it")).collect()
                })
                .collect();
            for tile in (0..tiles.count()).map(|index| tiles.tile(index)) {
                let squares: Vec<Vec<_>> = tile.squares(side).map(Iterator::collect).collect();
                for (y, columns) in tile.rows() {
                    let row = &squares[tile.first_square(side, y)..];
                    for (number, x) in columns.enumerate() {
                        assert!(row[number / side as usize].contains(&(x.try_into().unwrap(), y)));
                    }
                }
            }
            let expected = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            assert!(tiles.in_rows(&pixels).copied().eq(expected), "{width} by {height}");
        }
    }
}
