//! Lines through boxes, all being as likely.

use csg_graph_bounds::Aabb;
use glam::DVec3;

use super::outline::flux;
use crate::Ray;
use crate::fast::cover::{self, CELLS};
use crate::fast::sample::Dice;

/// From the cell of one line to that of the next, so that neighbours are far from each other. Coprime with the number of cells.
const STRIDE: usize = 10;

/// Lines in all directions, cell by cell.
pub(super) struct Round([Throws; CELLS]);

/// A line through a box.
pub(super) struct Thrown {
    pub(super) line: Ray,
    /// How much it counts.
    pub(super) weight: f64,
    /// The cell of its direction, and its number among those in that.
    pub(super) cell: usize,
    pub(super) number: usize,
}

impl Round {
    pub(super) fn new(dice: &mut Dice) -> Self {
        Self(std::array::from_fn(|_| Throws::new(dice)))
    }

    /// So many lines through a box.
    pub(super) fn lines(&self, bounds: &Aabb, count: usize) -> impl Iterator<Item = Thrown> {
        (0..count).map(|throw| {
            let (cell, number) = (throw * STRIDE % CELLS, throw / CELLS);
            let (line, weight) = self.0[cell].line(bounds, cell, number);
            Thrown { line, weight, cell, number }
        })
    }
}

/// Numbers by which lines are drawn: the multiples of powers of one number, which fill the cube of four dimensions evenly
/// from wherever they start \[ROBE18\].
pub(super) struct Throws([f64; 4]);

impl Throws {
    pub(super) fn new(dice: &mut Dice) -> Self {
        Self([0; 4].map(|_| dice.throw()))
    }

    /// A line through a box in a direction of a cell, and how much it counts, so that all lines are as likely.
    pub(super) fn line(&self, bounds: &Aabb, cell: usize, number: usize) -> (Ray, f64) {
        const STEPS: [f64; 4] = [
            0.856_674_883_854_502_9,
            0.733_891_856_627_126,
            0.628_706_721_037_808_7,
            0.538_597_257_223_610_1,
        ];
        let [u, v, mut along, across] =
            std::array::from_fn(|axis| (self.0[axis] + number as f64 * STEPS[axis]).fract());
        let direction = cover::direction_in(cell, [u, v]);
        let size = bounds.size();
        let areas = [size.y * size.z, size.z * size.x, size.x * size.y];
        let all = flux(bounds, direction);
        // The face where it comes in, by what is seen of it.
        let mut face = 0;
        loop {
            let share = direction[face].abs() * areas[face] / all;
            if along < share || face == 2 {
                along = (along / share).min(1.0);
                break;
            }
            along -= share;
            face += 1;
        }
        let mut origin = bounds.min;
        if direction[face] < 0.0 {
            origin[face] = bounds.max[face];
        }
        for (axis, share) in [(face + 1) % 3, (face + 2) % 3].into_iter().zip([along, across]) {
            origin[axis] += size[axis] * share;
        }
        // From outside, so that what touches the box is met. Directions are denser where the cube is farther away.
        let by_length = 1.0 / direction.length_squared();
        let ray = Ray { origin: origin - direction * size.length(), direction };
        (ray, all * by_length * by_length)
    }
}

/// The same line from its other end: it begins a diagonal before the box, and leaves it within another.
pub(super) fn backwards(line: &Ray, bounds: &Aabb) -> Ray {
    Ray { origin: line.at(3.0 * bounds.size().length()), direction: -line.direction }
}

/// A direction, all being as likely.
pub(super) fn on_sphere(dice: &mut Dice) -> DVec3 {
    loop {
        let point = DVec3::from_array([0; 3].map(|_| 2.0 * dice.throw() - 1.0));
        if (1e-6..1.0).contains(&point.length_squared()) {
            return point.normalize();
        }
    }
}
