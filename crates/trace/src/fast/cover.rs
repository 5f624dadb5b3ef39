//! How many of the rays a part stops, by where they go, and how many several parts stop together.
//!
//! What is porous hides more from some sides than from others: a tetrahedron of tetrahedra lets most rays through, but none
//! along its axes. So a [`Cover`] is a table over directions, the cells of a cube whose opposite sides are one: along a
//! line, both ways, the same is stopped.
//!
//! Of two parts in a row, each with its cover, nobody knows from that how many rays they stop together. It is the most where
//! they are side by side, as the bricks of a wall: what the one lets through, the other stops. It is the least where they
//! are one behind the other, as the leaves of a book. Between is chance: each stops its share of what comes to it, as it is
//! with leaves of a tree. These are the bounds of Fréchet and independence, and what lies between is written as a mixture with
//! one parameter \[NELS06\] §2.5.

use glam::DVec3;

/// Cells along each edge of a face of the cube.
const SIDE: usize = 3;

/// Directions that are told apart.
pub(super) const CELLS: usize = 3 * SIDE * SIDE;

/// The share of the rays through a box that what is in it stops, by their direction in the frame of the box.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cover {
    pub(super) cells: [f32; CELLS],
    /// How it stops rays together with others: see [`behind`].
    pub(super) apart: f32,
}

impl Cover {
    /// What stops all rays.
    pub(super) const ALL: Self = Self { cells: [1.0; CELLS], apart: 0.0 };

    /// What stops none.
    pub(super) const NONE: Self = Self { cells: [0.0; CELLS], apart: 0.0 };

    /// That of rays which go in a direction of any length.
    #[inline(always)]
    pub(super) fn along(&self, direction: DVec3) -> f32 {
        self.cells[cell(direction)]
    }
}

/// The cell of a direction.
#[inline(always)]
pub(super) fn cell(direction: DVec3) -> usize {
    let size = direction.abs();
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
    // From −1 to 1 in three thirds.
    let third = size[axis] / 3.0;
    let sign = direction[axis].signum();
    let place = |axis: usize| {
        let along = direction[axis % 3] * sign;
        usize::from(along > -third) + usize::from(along > third)
    };
    (axis * SIDE + place(axis + 1)) * SIDE + place(axis + 2)
}

/// A direction in a cell, by two numbers from 0 to 1.
pub(super) fn direction_in(cell: usize, across: [f64; 2]) -> DVec3 {
    let axis = cell / (SIDE * SIDE);
    let places = [cell / SIDE % SIDE, cell % SIDE];
    let mut direction = DVec3::ZERO;
    direction[axis] = 1.0;
    for (other, (place, across)) in places.into_iter().zip(across).enumerate() {
        direction[(axis + 1 + other) % 3] = 2.0 * (place as f64 + across) / SIDE as f64 - 1.0;
    }
    direction
}

/// Some directions in a cell, evenly spread.
pub(super) fn directions_in(cell: usize) -> impl Iterator<Item = DVec3> {
    let halves = [0.25, 0.75];
    let across = halves.into_iter().flat_map(move |u| halves.map(|v| [u, v]));
    across.map(move |across| direction_in(cell, across))
}

/// The share of the rays that are left behind a part with some cover, of those that were left before it. `apart` is 1 if
/// the part is beside what has stopped the others, 0 if chance is between them, and −1 if it is behind.
#[inline(always)]
pub(super) fn behind(left: f32, cover: f32, apart: f32) -> f32 {
    let by_chance = left * (1.0 - cover);
    let bound = if apart > 0.0 { (left - cover).max(0.0) } else { left.min(1.0 - cover) };
    by_chance + apart.abs() * (bound - by_chance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_between_the_bounds() {
        let left = |apart| behind(0.7, 0.4, apart);
        assert!((left(1.0) - 0.3).abs() < 1e-6, "side by side");
        assert!((left(0.0) - 0.42).abs() < 1e-6, "by chance");
        assert!((left(-1.0) - 0.6).abs() < 1e-6, "one behind the other");
        assert!((left(0.5) - 0.36).abs() < 1e-6, "half by chance");
        assert!((behind(0.2, 0.4, 1.0)).abs() < 1e-6, "no more than all");
    }
}
