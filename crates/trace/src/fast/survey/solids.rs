//! How many of the lines through the box of a solid are stopped.
//!
//! What ∩ and \ make of their operands cannot be told from what these stop. So lines are traced through a solid as through
//! [what is compiled on demand](super::demand): what is small below its operators is boxes, and stops all lines.

use fearless_simd::{Level, dispatch};

use super::SHARE;
use super::estimate::stopped;
use crate::fast::blocks::Blocks;
use crate::fast::compiled::{Compiled, Content};
use crate::fast::cover::Cover;
use crate::fast::detail::{Detail, Footprint};
use crate::fast::held::Held;
use crate::fast::hits::{Hits, Place, START};
use crate::fast::lanes::{LANES, transform};
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
        let cells = stopped(bounds, lines, |line, _| {
            held.renew();
            hits.clear([f64::INFINITY; LANES]);
            let inside = transform(line, &item.item_from_super);
            let at = (solid, Place::new(START, at));
            let first = dispatch!(*level, simd => solids.first(simd, held, hits, at, &inside, f64::INFINITY));
            // As on demand, what is wrong there stops it.
            first.is_some() || held.is_void()
        });
        cells.iter().any(|share| *share > 0.0).then_some(Cover { cells, apart: 0.0 })
    }
}
