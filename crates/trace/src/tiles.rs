//! Pictures in tiles: squares of pixels, which threads take one after the other.
//!
//! What a tile shows depends on nothing but its place, and tiles are put together in order, so that any number of threads
//! gives the same bytes.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::Beam;
use crate::camera::Lens;

/// Pixels on a side of a tile: enough work to be worth handing out, little enough to share the last tiles.
pub(crate) const SIDE: u32 = 16;

/// The tiles of a picture, numbered row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Tiles {
    /// The picture's, in pixels.
    pub(crate) width: u32,
    /// The picture's, in pixels.
    pub(crate) height: u32,
}

/// The pixels of a tile, or of a square of one. Those at the right and at the bottom may be smaller than others.
#[derive(Clone, Debug)]
pub(crate) struct Tile {
    pub(crate) columns: Range<u32>,
    pub(crate) rows: Range<u32>,
    /// The pixels of the picture before it, if they are put tile by tile, and square by square within tiles.
    pub(crate) start: usize,
}

impl Tiles {
    pub(crate) fn count(self) -> u32 {
        self.across() * self.down()
    }

    pub(crate) fn across(self) -> u32 {
        self.width.div_ceil(SIDE)
    }

    pub(crate) fn down(self) -> u32 {
        self.height.div_ceil(SIDE)
    }

    pub(crate) fn tile(self, index: u32) -> Tile {
        self.picture().part(SIDE, index % self.across() * SIDE, index / self.across() * SIDE)
    }

    pub(crate) fn iter(self) -> impl Iterator<Item = Tile> {
        (0..self.count()).map(move |index| self.tile(index))
    }

    /// Something of all pixels, tile by tile and row by row within tiles, as rows of the picture.
    pub(crate) fn in_rows<T: Copy>(self, pixels: &[T]) -> Vec<T> {
        let mut rows = Vec::with_capacity(pixels.len());
        self.picture().runs(SIDE).for_each(|run| rows.extend_from_slice(&pixels[run]));
        rows
    }

    fn picture(self) -> Tile {
        Tile { columns: 0..self.width, rows: 0..self.height, start: 0 }
    }
}

/// What is found in each of the parts of a picture, in their order. Whoever is ready takes the next part: some take a hundred
/// times as long as others. If any fails, it is the first one that does whose error is told, whatever the threads: then
/// only those before it are taken.
pub(crate) fn find_in_each<P: Send, W, T: Send, E: Send>(
    parts: impl Iterator<Item = P> + Send,
    worker: impl Fn() -> W + Send + Sync,
    find: impl Fn(&mut W, P) -> Result<T, E> + Send + Sync,
) -> Result<Vec<T>, E> {
    let failed = AtomicUsize::new(usize::MAX);
    let found = parts.enumerate().par_bridge().map_init(worker, |worker, (number, part)| {
        let found = (number < failed.load(Ordering::Relaxed)).then(|| find(worker, part));
        if let Some(Err(_)) = found {
            failed.fetch_min(number, Ordering::Relaxed);
        }
        (number, found)
    });
    let mut found: Vec<_> = found.collect();
    found.sort_unstable_by_key(|(number, _)| *number);
    // What was left out is behind an error.
    found.into_iter().map_while(|(_, found)| found).collect()
}

impl Tile {
    pub(crate) fn pixel_count(&self) -> usize {
        self.columns.len() * self.rows.len()
    }

    /// Where its pixels are in that order.
    pub(crate) fn places(&self) -> Range<usize> {
        self.start..self.start + self.pixel_count()
    }

    /// Its pixels, row by row.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let columns = self.columns.clone();
        self.rows.clone().flat_map(move |y| columns.clone().map(move |x| (x, y)))
    }

    /// The rays through its pixels.
    pub(crate) fn beam(&self, lens: &Lens) -> Beam {
        lens.beam(&self.columns, &self.rows)
    }

    /// It in squares with sides of `side` pixels, row by row.
    pub(crate) fn squares(&self, side: u32) -> impl Iterator<Item = Self> + use<> {
        let whole = self.clone();
        self.rows.clone().step_by(side as usize).flat_map(move |top| {
            let whole = whole.clone();
            whole.columns.clone().step_by(side as usize).map(move |left| whole.part(side, left, top))
        })
    }

    /// Where its pixels are if it is put in squares with sides of `side` pixels, row by row of it: the places of those that
    /// are in one row of one square follow each other.
    pub(crate) fn runs(&self, side: u32) -> impl Iterator<Item = Range<usize>> + use<> {
        let whole = self.clone();
        self.rows.clone().flat_map(move |y| {
            let whole = whole.clone();
            whole.columns.clone().step_by(side as usize).map(move |x| {
                let start = whole.place(side, (x, y));
                start..start + (whole.columns.end - x).min(side) as usize
            })
        })
    }

    /// Where a pixel of it is in that order, if it is put in squares with sides of `side` pixels.
    fn place(&self, side: u32, (x, y): (u32, u32)) -> usize {
        let corner = |at: u32, start: u32| at - (at - start) % side;
        let square = self.part(side, corner(x, self.columns.start), corner(y, self.rows.start));
        let above = (y - square.rows.start) as usize * square.columns.len();
        square.start + above + (x - square.columns.start) as usize
    }

    /// The square of it that has this corner.
    fn part(&self, side: u32, left: u32, top: u32) -> Self {
        let columns = left..self.columns.end.min(left.saturating_add(side));
        let rows = top..self.rows.end.min(top.saturating_add(side));
        let above = (top - self.rows.start) as usize * self.columns.len();
        let beside = (left - self.columns.start) as usize * rows.len();
        Self { columns, rows, start: self.start + above + beside }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_and_squares_have_every_pixel_once_and_in_their_order() {
        for (width, height, side) in [(1, 1, 4), (16, 16, 4), (33, 18, 4), (20, 47, 1), (5, 40, 7)] {
            let tiles = Tiles { width, height };
            let mut count = 0;
            let mut met = Vec::new();
            for tile in tiles.iter() {
                assert_eq!(tile.start, count);
                for square in tile.squares(side) {
                    for (pixel, place) in square.pixels().zip(square.places()) {
                        assert_eq!((place, tile.place(side, pixel)), (count, count));
                        met.push(pixel);
                        count += 1;
                    }
                }
            }
            met.sort_unstable_by_key(|(x, y)| (*y, *x));
            let expected = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            assert!(met.into_iter().eq(expected.clone()), "{width} by {height}");
            let pixels: Vec<_> = tiles.iter().flat_map(|tile| tile.pixels()).collect();
            assert!(tiles.in_rows(&pixels).into_iter().eq(expected), "{width} by {height}");
        }
    }

    #[test]
    fn of_many_errors_the_first_part_s_is_told() {
        // Whoever takes the twentieth part finds out late.
        let find = |(): &mut (), part: u32| {
            if part == 20 {
                std::thread::sleep(std::time::Duration::from_millis(50));
            }
            if part >= 20 && part.is_multiple_of(5) { Err(part) } else { Ok(part) }
        };
        for threads in [1, 2, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| find_in_each(0..100, || (), find)), Err(20));
            assert_eq!(pool.install(|| find_in_each(0..20, || (), find)), Ok((0..20).collect()));
        }
    }
}
