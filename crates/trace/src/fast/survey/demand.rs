//! Measures what is compiled on demand, when a ray first comes to something small of it.
//!
//! What cannot be listed cannot be measured from the leaves upwards, and what never ends has no leaves. But rays can be asked:
//! lines through the box of a part are traced as if a pixel were a tenth of its size. In a round, the boxes of what is
//! then too small stop all lines; in each further one, they stop as many as was found of them by one round less. So the
//! recursion is followed some steps below what is seen, whatever the number of its levels, and then ends in boxes.
//!
//! Where states are listed, each is measured. Where they differ by chance, a [class](Class) of them is, by some that stand
//! for all. What is measured is a function of the class, so that it is no matter who comes to it first.

use std::sync::{Arc, OnceLock};

use csg_graph::State;
use csg_graph_bounds::Aabb;
use glam::{DMat3, DVec3};

use super::estimate::stopped;
use super::outline::flux;
use super::{ALL_LINES, FEW_LINES, LINES_BELOW, SHARE};
use crate::fast::Tracer;
use crate::fast::blocks::Blocks;
use crate::fast::compiled::Compiled;
use crate::fast::cover::{CELLS, Cover};
use crate::fast::tree::{Child, Target};

/// Lines through the box of a state in each direction: they go down much farther than those of what is measured ahead.
const LINES: usize = 48;

/// States that differ by chance alone, or a listed one, and what they cover in a number of rounds.
#[derive(Debug)]
pub(in crate::fast) struct Class {
    /// One of them.
    state: State,
    rounds: u8,
    /// The box of all, and the share of the lines through it that one stops; none if it is flat, or that cannot be found out.
    cells: OnceLock<Option<(Aabb, [f32; CELLS])>>,
}

impl Class {
    pub(in crate::fast) fn new(state: State, rounds: u8) -> Self {
        Self { state, rounds, cells: OnceLock::new() }
    }

    /// How many of evenly spread rays in a direction a part of this class stops, for its length; none if its box has to stand
    /// for it.
    pub(in crate::fast) fn along(
        &self,
        source: &Blocks,
        state_from_outside: &DMat3,
        direction: DVec3,
    ) -> Option<f64> {
        let (inner, cells) = self.cells(source)?;
        let inside = *state_from_outside * direction;
        let share = cells[super::cover::cell(inside)];
        Some(f64::from(share) * flux(inner, inside) / state_from_outside.determinant().abs())
    }

    fn cells(&self, source: &Blocks) -> Option<&(Aabb, [f32; CELLS])> {
        let measure = || {
            let demand = source.on_demand()?;
            let bounds = demand.bounds_of(&self.state)?;
            if !is_measured(&bounds) {
                return None;
            }
            let width = SHARE * bounds.size().length();
            let blocks =
                demand.typical(&self.state).into_iter().filter_map(|state| demand.block(&state).ok());
            let mut tracers: Vec<Tracer<'_>> =
                blocks.map(|block| Tracer::of_lines(source, block, self.rounds - 1, width)).collect();
            // Where chance makes a difference, the few that stand for all are no closer than that.
            let lines = most(demand.class_count(), LINES / tracers.len().max(1));
            (!tracers.is_empty()).then(|| (bounds, cells(&mut tracers, None, &bounds, lines)))
        };
        self.cells.get_or_init(measure).as_ref()
    }
}

/// Measures what is to be measured of a block of listed states.
pub(in crate::fast) fn measure(source: &Blocks, block: &Arc<Compiled>, rounds: u8) -> Box<[Cover]> {
    let Some(demand) = source.on_demand() else { unreachable!("all of the graph is measured ahead") };
    let lines = most(demand.class_count() * block.measured.len(), LINES_BELOW);
    // Of a block, only the first super-node has slabs: the others are operands.
    let outlines = block.outlines();
    let cover = |child: &Child| {
        let bounds = match child.target() {
            Target::Node(node) => block.node_bounds(0, node),
            Target::Item(item) => block.parts[item].bounds,
        };
        if !is_measured(&bounds) {
            return Cover::ALL;
        }
        let width = SHARE * bounds.size().length();
        let mut tracer = [Tracer::of_lines(source, Arc::clone(block), rounds - 1, width)];
        let cells = cells(&mut tracer, Some(*child), &bounds, lines);
        let mut cover = Cover { cells, apart: 0.0 };
        if let Some((_, outline)) = outlines.iter().find(|(known, _)| known == child) {
            outline.narrow(&bounds, &mut cover);
        }
        cover
    };
    block.measured.iter().map(cover).collect()
}

/// How many lines are drawn through each of so many boxes.
fn most(boxes: usize, lines: usize) -> usize {
    (ALL_LINES / boxes.max(1)).clamp(FEW_LINES * CELLS, lines * CELLS)
}

/// The share of the lines through a box that are stopped in what tracers begin with or in a child of it, by direction.
fn cells(tracers: &mut [Tracer<'_>], child: Option<Child>, bounds: &Aabb, lines: usize) -> [f32; CELLS] {
    let count = tracers.len();
    stopped(bounds, lines, |line, number| tracers[number % count].is_stopped(line, child))
}

/// Whether a box stands for what is in it, or lines through it tell more. What is flat is a piece of a sheet: as there is
/// nothing behind it, chance would make holes where it meets others.
fn is_measured(bounds: &Aabb) -> bool {
    /// Of the size: what is as thin is flat.
    const FLAT: f64 = 1e-5;
    bounds.is_bounded() && bounds.size().min_element() > FLAT * bounds.size().length()
}
