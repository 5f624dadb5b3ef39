//! Branch and bound: how far a solid reaches in a direction, to a tolerance.
//!
//! The box about the solid is a *cell*. Cells are taken from a queue, classified, and, if they are neither outside nor
//! inside of the solid, halved. What a cell may hold of the solid reaches no further than the cell does,
//! and no further than the term that is left of the solid in it: a union as its furthest part, an intersection as the
//! one that reaches least, a shape as its support. Points that are proven to be inside are lower bounds.
//!
//! Once there is such a point, cells are only asked what is *above* it: each is cut off just above the best one. So a
//! flat face is found in a few steps, for what is above it is outside at once, and a smooth or sharp one in about as many
//! as it takes to tell the solid from space at that distance from the top. Turn by turn, the cell that reaches furthest
//! is taken, which lowers the upper bound, and the largest one, which is where points are still to be found: going for
//! the furthest alone, one would follow every sharp edge to its end before looking at the solid below it.
//!
//! The search ends when no cell is left above the best point by more than the tolerance, or at the limit. A cell that is
//! much smaller than the tolerance and still neither outside nor inside is dropped, and what it reaches is the upper
//! bound; then only points are searched for, and not for long. Such cells are what films of no thickness leave behind,
//! as those between faces that coincide: nothing can tell them from a thin solid once maps have rounded, so they count.
//! In all cases the upper bound holds, and the gap says how good it is.
//!
//! Cells are boxes of a frame whose first axis is the direction asked for; for the faces of a box, those are boxes of
//! the state's own frame.
//!
//! **Rounding.** Cells carry it as slack, see [`terms`](super::terms); the frame's turn by an only nearly orthonormal
//! basis adds some ulps of the coordinates here, to cells and to what they reach.

use std::collections::BinaryHeap;
use std::fmt;

use glam::{DMat3, DVec3};

use super::Refinement;
use super::cell::Cell;
use super::enclosures::Enclosures;
use super::sweeps::contexts;
use super::terms::{Terms, Verdict};
use crate::best_first::best_first;
use crate::exact::Support;
use crate::rounding::EVALUATION;
use crate::{Aabb, ExactBoxes, Scene};

/// Branch and bound on the solid below a state, for one direction after the other. See [`ExactBoxes::solid`].
pub struct SolidSearch<'a, S: Scene> {
    exact: &'a ExactBoxes<S>,
    enclosures: Enclosures,
    state: usize,
    /// The S-bound of the state, if it were the root.
    bounds: Aabb,
    refinement: Refinement,
    counts: CellCounts,
    /// Points that are inside, one of each direction.
    points: Vec<DVec3>,
}

impl<S: Scene> fmt::Debug for SolidSearch<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bounds, refinement, counts, .. } = self;
        f.debug_struct("SolidSearch")
            .field("bounds", bounds)
            .field("refinement", refinement)
            .field("counts", counts)
            .finish_non_exhaustive()
    }
}

/// A box about the solid below a state.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SolidBox {
    /// The box, in the frame of the state. [`Aabb::EMPTY`] if no point is in the solid.
    pub aabb: Aabb,
    /// No face is further out than this from a point of the solid. Infinite if a search has found no point at all and
    /// could not show that there is none.
    pub gap: f64,
    /// What it took.
    pub counts: CellCounts,
}

/// How much work branch and bound was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CellCounts {
    /// Cells that were classified.
    pub cells: u64,
    /// Points that were.
    pub points: u64,
    /// States that were opened, one count for each instance.
    pub opened: u64,
}

/// Cells are not halved when their largest extent is below this part of the tolerance.
const SMALLEST: f64 = 1.0 / 256.0;

/// At what part of the tolerance above the best point cells are cut off.
const CUT: f64 = 0.5;

/// Once the upper bound is settled, points are searched for with one cell in so many of the limit.
const PATIENCE: usize = 4;

/// A piece of the search's frame that may hold the furthest point.
#[derive(Clone, Copy)]
struct Open {
    cell: Aabb,
    term: u32,
}

/// An open cell in a queue.
#[derive(Clone, Copy)]
struct Queued {
    key: f64,
    open: usize,
}

/// One search, in a frame whose first axis is the direction.
struct Search {
    state_from_search: DMat3,
    tolerance: f64,
    /// What rounding may do to a coordinate.
    rounding: f64,
    /// The cells by number, while they are open.
    cells: Vec<Option<Open>>,
    by_reach: BinaryHeap<Queued>,
    by_size: BinaryHeap<Queued>,
    /// The furthest point, and how far it is.
    point: Option<DVec3>,
    lower: f64,
    /// No point of what was dropped is further.
    dropped: f64,
}

impl<'a, S: Scene> SolidSearch<'a, S> {
    pub(super) fn new(exact: &'a ExactBoxes<S>, state: usize, refinement: Refinement) -> Self {
        let enclosures = Enclosures::new(exact);
        let (contexts, _) = contexts(exact, &enclosures, state);
        let bounds = contexts[state];
        Self {
            exact,
            enclosures,
            state,
            bounds,
            refinement,
            counts: CellCounts::default(),
            points: Vec::new(),
        }
    }

    /// The box of the solid, by six searches.
    pub fn aabb(&mut self) -> SolidBox {
        let before = self.counts;
        let mut gap = 0.0_f64;
        let mut faces = [DVec3::ZERO; 2];
        for (face, sign) in faces.iter_mut().zip([1.0, -1.0]) {
            for axis in 0..3 {
                let found = self.support(sign * DVec3::AXES[axis]);
                if found.upper == f64::NEG_INFINITY {
                    return SolidBox { aabb: Aabb::EMPTY, gap: 0.0, counts: self.counts.since(before) };
                }
                gap = gap.max(found.gap);
                face[axis] = found.upper;
            }
        }
        let [max, min] = faces;
        let aabb = Aabb { min: DVec3::ZERO - min, max }.intersect(self.bounds);
        SolidBox { aabb, gap, counts: self.counts.since(before) }
    }

    /// The support of the solid in a direction of any length but zero. −∞ if no point is in the solid.
    ///
    /// The gap is to a point that is in the solid, and at most the [tolerance](Refinement::tolerance) times the length
    /// of the direction, if the search did not have to end before; infinite, if there is no such point.
    pub fn support(&mut self, direction: DVec3) -> Support {
        let bounds = self.bounds;
        let length = direction.length();
        if bounds.is_empty() {
            return Support { upper: f64::NEG_INFINITY, gap: 0.0 };
        }
        let outer = bounds.support_above(direction, 0.0);
        if self.enclosures.united[self.state] {
            let state = &self.exact.graph().states[self.state];
            let found = self.exact.support(state, direction).expect("the state has a number");
            return Support { upper: found.upper.min(outer), ..found };
        }
        let extent = bounds.size().max_element();
        let usable = extent.is_finite() && length.is_normal() && extent > 0.0;
        if !usable {
            return Support { upper: outer, gap: f64::INFINITY };
        }
        let (found, point) = self.search(direction / length, bounds);
        self.points.extend(point);
        if found.upper == f64::NEG_INFINITY {
            return Support { upper: found.upper, gap: 0.0 };
        }
        let upper = (found.upper * length).next_up().min(outer);
        Support { upper, gap: (upper - found.lower * length).max(0.0) }
    }

    /// What all searches took so far.
    pub fn counts(&self) -> CellCounts {
        self.counts
    }

    /// Searches in a direction of length 1.
    fn search(&mut self, direction: DVec3, bounds: Aabb) -> (Found, Option<DVec3>) {
        let limit = self.refinement.cells;
        let state = u32::try_from(self.state).expect("states are numbered in 32 bits");
        let (mut terms, root) = Terms::new(self.exact, &self.enclosures, state, direction, limit);
        let mut search = Search::new(direction, bounds, self.refinement.tolerance, root);
        for point in &self.points {
            search.attain(*point, direction);
        }
        let mut cells = 0;
        let mut left = limit;
        while cells + terms.opened < left
            && let Some(next) = search.take(cells % 2 == 0)
        {
            let top = next.cell.max.x;
            let Some(cell) = search.above(next.cell) else { continue };
            cells += 1;
            match terms.classify(&search.cell(cell), next.term) {
                Verdict::Outside => {}
                Verdict::Mixed(_, reach) if reach < cell.min.x => {}
                Verdict::Inside => {
                    search.drop_to(top);
                    let middle = cell.center();
                    search.attain(search.state_from_search * middle.with_x(top), direction);
                }
                Verdict::Mixed(term, reach) => {
                    let Some(cell) = search.above(Aabb { max: cell.max.with_x(top.min(reach)), ..cell })
                    else {
                        continue;
                    };
                    self.counts.points += search.probe(&mut terms, cell, term, direction);
                    if let Some(cell) = search.above(cell)
                        && !search.halve(cell, term)
                    {
                        search.drop_to(cell.max.x);
                        left = left.min(cells + terms.opened + limit / PATIENCE);
                    }
                }
            }
        }
        self.counts.cells += cells as u64;
        self.counts.opened += terms.opened as u64;
        let upper = search.highest().max(search.dropped).max(search.lower);
        (Found { upper: upper + search.rounding, lower: search.lower }, search.point)
    }
}

/// How far the solid reaches at most and at least.
struct Found {
    upper: f64,
    lower: f64,
}

impl Search {
    fn new(direction: DVec3, bounds: Aabb, tolerance: f64, term: u32) -> Self {
        let (second, third) = basis(direction);
        let state_from_search = DMat3::from_cols(direction, second, third);
        let rounding = 4.0 * EVALUATION * bounds.magnitude();
        let coordinate = |sign: f64| {
            let axes = [direction, second, third];
            DVec3::from_array(axes.map(|axis| bounds.support(sign * axis)))
        };
        let cell = Aabb { min: DVec3::ZERO - coordinate(-1.0), max: coordinate(1.0) }.grown(rounding);
        let mut search = Self {
            state_from_search,
            tolerance: tolerance * bounds.size().max_element(),
            rounding,
            cells: Vec::new(),
            by_reach: BinaryHeap::new(),
            by_size: BinaryHeap::new(),
            point: None,
            lower: f64::NEG_INFINITY,
            dropped: f64::NEG_INFINITY,
        };
        search.push(Open { cell, term });
        search
    }

    fn push(&mut self, open: Open) {
        let number = self.cells.len();
        self.by_reach.push(Queued { key: open.cell.max.x, open: number });
        self.by_size.push(Queued { key: open.cell.size().max_element(), open: number });
        self.cells.push(Some(open));
    }

    /// The next cell: the one that reaches furthest, or the largest. None if no cell can improve a bound by more than
    /// the tolerance.
    fn take(&mut self, furthest: bool) -> Option<Open> {
        if self.highest().max(self.dropped) <= self.lower + self.tolerance {
            return None;
        }
        // Nothing lowers the upper bound below what was dropped.
        let queue =
            if furthest && self.highest() > self.dropped { &mut self.by_reach } else { &mut self.by_size };
        loop {
            if let Some(open) = self.cells[queue.pop()?.open].take() {
                return Some(open);
            }
        }
    }

    /// How far the open cells reach.
    fn highest(&mut self) -> f64 {
        while let Some(first) = self.by_reach.peek() {
            if self.cells[first.open].is_some() {
                return first.key;
            }
            self.by_reach.pop();
        }
        f64::NEG_INFINITY
    }

    /// A cell in the frame of the state.
    fn cell(&self, cell: Aabb) -> Cell {
        let half = DMat3::from_diagonal(0.5 * cell.size());
        Cell::new(self.state_from_search * cell.center(), self.state_from_search * half)
            .with_slack(self.rounding)
    }

    /// What of a cell is above the best point, if anything.
    fn above(&mut self, cell: Aabb) -> Option<Aabb> {
        let cut = self.lower + CUT * self.tolerance;
        if cell.max.x <= cut {
            self.drop_to(cell.max.x);
            return None;
        }
        if cell.min.x < cut {
            self.drop_to(cut);
            return Some(Aabb { min: cell.min.with_x(cut), ..cell });
        }
        Some(cell)
    }

    fn drop_to(&mut self, reach: f64) {
        self.dropped = self.dropped.max(reach);
    }

    /// Notes a point of the solid, in the frame of the state.
    fn attain(&mut self, point: DVec3, direction: DVec3) {
        let reach = point.dot(direction) - self.rounding;
        if reach > self.lower {
            self.lower = reach;
            self.point = Some(point);
        }
    }

    /// Tries the middle of a cell and, if that is inside, goes up from it as far as it is inside. Returns how many
    /// points were tried.
    fn probe<S: Scene>(&mut self, terms: &mut Terms<S>, cell: Aabb, term: u32, direction: DVec3) -> u64 {
        let at = cell.center();
        let (mut inside, mut outside) = (at.x, cell.max.x);
        let mut tried = 0;
        let mut height = at.x;
        loop {
            let point = self.state_from_search * at.with_x(height);
            tried += 1;
            let point_cell = Cell::point(point).with_slack(self.rounding);
            if terms.contains(&point_cell, term) {
                inside = height;
                self.attain(point, direction);
            } else if tried == 1 {
                return tried;
            } else {
                outside = height;
            }
            if outside - inside <= 0.25 * CUT * self.tolerance {
                return tried;
            }
            height = 0.5 * (inside + outside);
        }
    }

    /// Puts the halves of a cell back, unless it is too small.
    fn halve(&mut self, cell: Aabb, term: u32) -> bool {
        let size = cell.size();
        let axis = if size.x >= size.y.max(size.z) {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let middle = cell.center()[axis];
        let splits = cell.min[axis] < middle && middle < cell.max[axis];
        if size[axis] < SMALLEST * self.tolerance || !splits {
            return false;
        }
        let (mut lower, mut upper) = (cell, cell);
        lower.max[axis] = middle;
        upper.min[axis] = middle;
        self.push(Open { cell: lower, term });
        self.push(Open { cell: upper, term });
        true
    }
}

/// Two directions across one of length 1: axes, if it is along an axis.
fn basis(direction: DVec3) -> (DVec3, DVec3) {
    let others = [(DVec3::Y, DVec3::Z), (DVec3::Z, DVec3::X), (DVec3::X, DVec3::Y)];
    let along = (0..3).find(|axis| direction == direction[*axis] * DVec3::AXES[*axis]);
    along.map_or_else(|| direction.any_orthonormal_pair(), |axis| others[axis])
}

impl CellCounts {
    fn since(self, before: Self) -> Self {
        Self {
            cells: self.cells - before.cells,
            points: self.points - before.points,
            opened: self.opened - before.opened,
        }
    }
}

best_first!(Queued: key, open);
