//! What is seen of parts that are too small to be looked into: how many rays they stop, and what of them a ray meets.
//!
//! Where all is compiled at once, it has been measured before the first ray. On demand a part is measured when a ray first comes
//! to it, and what was found stays with the block that the part is in: it is the same for every thread.

use std::sync::Arc;

use glam::DVec3;

use super::Held;
use crate::fast::blocks::Blocks;
use crate::fast::compiled::{Content, Gate};
use crate::fast::detail::Part;
use crate::fast::hits::Place;
use crate::fast::sample::{Dice, Sample};
use crate::fast::survey::demand::measure;
use crate::fast::survey::outline::flux;
use crate::fast::tree::Child;
use crate::narrow::narrow;

impl Held<'_> {
    /// What share of the rays in a direction a small child of a super-node stops, and how with others. If nobody can say, it
    /// stops all.
    #[inline(always)]
    pub(in crate::fast) fn cover(&self, number: u32, child: Child, direction: DVec3) -> Option<[f32; 2]> {
        match self.block(number).cover(child) {
            Some(cover) => Some([cover.along(direction), cover.apart]),
            None => self.cover_on_demand(number, child, direction).map(|share| [share, 0.0]),
        }
    }

    /// The share of what is measured when a ray comes to it.
    fn cover_on_demand(&self, number: u32, child: Child, direction: DVec3) -> Option<f32> {
        let source = self.source.on_demand().filter(|_| self.rounds > 0)?;
        let block = self.block(number);
        let place = block.place_of_cover(child) as usize;
        if place < block.measured.len() {
            let measure = || {
                let block = Arc::clone(&self.visits.borrow()[number as usize].0);
                measure(self.source, &block, self.rounds)
            };
            // They belong to the block, and all that look into it ask for as many.
            debug_assert_eq!(self.rounds, self.source.rounds());
            return Some(block.covers.get_or_init(measure)[place].along(direction));
        }
        let item = child.as_item()?;
        let Content::Gate(gate) = block.items[item].content else { return None };
        let Gate { state, class, .. } = &block.gates[gate as usize];
        let known;
        let class = if self.rounds == self.source.rounds() {
            class.get_or_init(|| source.class(state, self.rounds))
        } else {
            known = source.class(state, self.rounds);
            &known
        };
        let class = class.as_ref()?;
        let inside = &block.items[item].item_from_super.matrix3;
        let stopped = class.along(self.source, inside, direction)?;
        let Part { bounds, outline, .. } = &block.parts[item];
        let all = outline.as_ref().map_or_else(|| flux(bounds, direction), |outline| outline.flux(direction));
        // What is as thin as nothing may be seen from its edge.
        let share = stopped / all;
        share.is_finite().then(|| narrow(share.clamp(0.0, 1.0)))
    }

    /// What is seen of a part that is too small to be looked into.
    pub(in crate::fast) fn sample(&self, block: u32, part: Place) -> Sample {
        let (block, at) = (self.block(block), part.item as usize);
        let (sample, gate) = if part.is_node {
            Sample::of_node(block, at, &mut Dice::at(block.nodes[at].bounds(0).min))
        } else {
            Sample::of_item(block, at, &mut Dice::at(block.parts[at].bounds.min))
        };
        let (Some(gate), Blocks::OnDemand(source)) = (gate, self.source) else { return sample };
        let inner = gate.sample.get_or_init(|| {
            // Several items may lead here, and it must not matter which of them is seen first.
            let mut dice = Dice::at(block.parts[gate.first as usize].bounds.min);
            let drawn = Sample::of_state(&source.graph, &source.unions, &gate.state, &mut dice);
            drawn.map(Box::new).map_err(Box::new)
        });
        match inner {
            Ok(inner) => sample.then(inner),
            Err(fault) => {
                self.faults.note(fault.clone());
                sample
            }
        }
    }
}
