//! How many of the lines through the box of a solid are stopped.
//!
//! What ∩ and \ make of their operands cannot be told from what these stop. So lines are traced through a solid as through
//! [what is compiled on demand](super::demand): what is small below its operators is boxes, and stops all lines.

use fearless_simd::{Level, dispatch};

use super::estimate::{Tally, shares};
use super::lines::Throws;
use super::{SHARE, STRIDE};
use crate::fast::blocks::Blocks;
use crate::fast::compile::{Compiled, Content};
use crate::fast::cover::{CELLS, Cover};
use crate::fast::detail::{Detail, Footprint};
use crate::fast::held::Held;
use crate::fast::hits::{Hits, Place, START};
use crate::fast::lanes::{LANES, transform};
use crate::fast::sample::Dice;
use crate::fast::solid::Solids;

/// Lines through the box of a solid in each direction, unless there are too many solids.
pub(super) const LINES: usize = 48;

/// Traces lines through solids.
pub(super) struct Tracing<'b> {
    level: Level,
    held: Held<'b>,
    hits: Hits,
    solids: Solids,
}

impl<'b> Tracing<'b> {
    pub(super) fn new(source: &'b Blocks, level: Level) -> Self {
        let mut hits = Hits::new();
        hits.detail = Some(Detail::new());
        Self { level, held: Held::new(source, 0), hits, solids: Solids::default() }
    }

    /// The cover of an item that is a solid, by so many lines; none if no line has met it.
    pub(super) fn cover(&mut self, block: &Compiled, at: usize, lines: usize) -> Option<Cover> {
        let Self { level, held, hits, solids } = self;
        let item = &block.items[at];
        let Content::Solid(solid) = item.content else { unreachable!("it is the cover of a solid") };
        let bounds = &block.parts[at].bounds;
        if !bounds.is_bounded() {
            return Some(Cover::ALL);
        }
        let small = Footprint { width: SHARE * bounds.size().length(), spread: 0.0 };
        hits.detail.iter_mut().for_each(|detail| detail.set_footprint(small, small));
        let mut dice = Dice::at(bounds.min);
        let throws: [Throws; CELLS] = std::array::from_fn(|_| Throws::new(&mut dice));
        let mut tallies = [Tally::default(); CELLS];
        for number in 0..lines {
            let cell = number * STRIDE % CELLS;
            let (line, weight) = throws[cell].line(bounds, cell, number / CELLS);
            hits.clear([f64::INFINITY; LANES]);
            let place = Place::new(START, at);
            let inside = transform(&line, &item.item_from_super);
            let first = dispatch!(*level, simd => solids.first(simd, held, hits, (solid, place), &inside, f64::INFINITY));
            tallies[cell].add(weight, f64::from(u8::from(first.is_some())));
        }
        let cells = shares(&tallies, lines, || [1.0; CELLS]);
        cells.iter().any(|share| *share > 0.0).then_some(Cover { cells, apart: 0.0 })
    }
}
