//! What a few lines tell of many.

use csg_graph_bounds::Aabb;

use super::lines::{Round, Thrown};
use super::{FEW_LINES, Meeting};
use crate::Ray;
use crate::fast::cover::{CELLS, behind};
use crate::fast::sample::Dice;
use crate::narrow::narrow;

/// What lines in one direction have met, by what they count.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tally {
    weight: f64,
    squared_weight: f64,
    stopped: f64,
    squares: f64,
}

impl Tally {
    pub(super) fn add(&mut self, weight: f64, stopped: f64) {
        self.weight += weight;
        self.squared_weight += weight * weight;
        self.stopped += weight * stopped;
        self.squares += weight * stopped * stopped;
    }

    pub(super) fn with(self, other: Self) -> Self {
        Self {
            weight: self.weight + other.weight,
            squared_weight: self.squared_weight + other.squared_weight,
            stopped: self.stopped + other.stopped,
            squares: self.squares + other.squares,
        }
    }

    /// The share that is stopped.
    pub(super) fn mean(&self) -> f64 {
        self.stopped / self.weight
    }

    /// The variance of that.
    fn variance(&self) -> f64 {
        let variance = (self.squares / self.weight - self.mean() * self.mean()).max(0.0);
        variance * self.squared_weight / (self.weight * self.weight)
    }
}

/// The share of the lines through a box that are stopped, by direction, as so many of them tell. Each is given with its number
/// among those in its direction.
pub(super) fn stopped(
    bounds: &Aabb,
    lines: usize,
    mut is_stopped: impl FnMut(&Ray, usize) -> bool,
) -> [f32; CELLS] {
    let round = Round::new(&mut Dice::at(bounds.min));
    let mut tallies = [Tally::default(); CELLS];
    for Thrown { line, weight, cell, number } in round.lines(bounds, lines) {
        tallies[cell].add(weight, f64::from(u8::from(is_stopped(&line, number))));
    }
    // Nothing is known beforehand of how directions differ.
    shares(&tallies, lines, || [1.0; CELLS])
}

/// The covers in all directions, of what so many lines have met together: the same in all if there are few.
pub(super) fn shares(
    tallies: &[Tally; CELLS],
    lines: usize,
    depths: impl FnOnce() -> [f64; CELLS],
) -> [f32; CELLS] {
    if lines < FEW_LINES * CELLS {
        let all = tallies.iter().copied().fold(Tally::default(), Tally::with);
        return [narrow(all.mean()); CELLS];
    }
    shrink(tallies, &depths()).map(narrow)
}

/// The covers in all directions, of what a few lines in each have met, and of what the parts cover there.
///
/// The few lines have noise, which would grow from level to level. What the parts cover has none, but tells nothing of how
/// much of it is hidden. So the second is fitted to all of the first by one number, and what is left in single directions
/// counts as far as there is more of it than noise \[EFRO77\].
fn shrink(tallies: &[Tally; CELLS], depths: &[f64; CELLS]) -> [f64; CELLS] {
    /// Squares count as far as they are more than so many times their variance.
    const DOUBT: f64 = 2.0;
    /// Halvings of the interval that holds the number.
    const STEPS: u8 = 40;
    let all = tallies.iter().copied().fold(Tally::default(), Tally::with);
    let model = |number: f64, depth: f64| number * depth / (1.0 + number * depth);
    // The number is between 0 and infinity, and its place between is from 0 to 1.
    let [mut low, mut high] = [0.0, 1.0];
    for _ in 0..STEPS {
        let place = f64::midpoint(low, high);
        let number = place / (1.0 - place);
        let stopped: f64 =
            tallies.iter().zip(depths).map(|(tally, depth)| tally.weight * model(number, *depth)).sum();
        if stopped < all.stopped {
            low = place;
        } else {
            high = place;
        }
    }
    let number = low / (1.0 - low);
    let excess = |(tally, depth): (&Tally, &f64)| tally.mean() - model(number, *depth);
    let squares: f64 = tallies.iter().zip(depths).map(|pair| excess(pair) * excess(pair)).sum();
    let noise = DOUBT * tallies.iter().map(Tally::variance).sum::<f64>();
    let believed = if squares > noise { 1.0 - noise / squares } else { 0.0 };
    std::array::from_fn(|cell| {
        let pair = (&tallies[cell], &depths[cell]);
        (model(number, depths[cell]) + believed * excess(pair)).clamp(0.0, 1.0)
    })
}

/// What is known of how the children of a node stop lines together: the sums of a regression of what was found on what would
/// be if they were side by side or one behind the other, each less what would be by chance.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Arrangement {
    beside: [f32; 2],
    behind: [f32; 2],
    squares: f32,
    lines: f32,
}

impl Arrangement {
    /// Takes what a line has met, and what was left of it.
    pub(super) fn add(&mut self, met: &[Meeting], left: f32) {
        let [beside, by_chance, in_row] = [1.0, 0.0, -1.0]
            .map(|apart| met.iter().fold(1.0, |left, meeting| behind(left, meeting.cover, apart)));
        let excess = by_chance - left;
        let slopes = [by_chance - beside, in_row - by_chance];
        self.beside[0] += excess * slopes[0];
        self.beside[1] += slopes[0] * slopes[0];
        self.behind[0] -= excess * slopes[1];
        self.behind[1] += slopes[1] * slopes[1];
        self.squares += excess * excess;
        self.lines += 1.0;
    }

    /// From −1 to 1: how far the parts are from stopping lines by chance. What is not clear is left to chance, as it would add
    /// up from level to level.
    pub(super) fn apart(&self) -> f32 {
        /// Less than that is not clear.
        const CLEAR: f32 = 0.5;
        let noise = self.squares / self.lines.max(1.0);
        let fit = |[product, square]: [f32; 2]| {
            if square > 0.0 { (product / (square + noise)).clamp(0.0, 1.0) } else { 0.0 }
        };
        let apart = fit(self.beside) - fit(self.behind);
        if apart.abs() < CLEAR { 0.0 } else { apart }
    }
}
