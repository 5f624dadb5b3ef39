//! Instances: where a state stands, and how it is painted there.
//!
//! What leads from one state that matters to the next is nothing but names, choices and transformations. All of it is
//! multiplied into one matrix, both ways, with what paints the state and how many S-nodes there were. One instance
//! [in](Instance::then) another is an instance again.

use std::hash::Hasher;

use csg_graph::{AttributeTerm, Transform};
use glam::{DAffine3, DMat3, DVec3};
use rustc_hash::FxHasher;
use smallvec::SmallVec;

/// A state under the transformations and attributes that lead to it.
#[derive(Clone)]
pub(crate) struct Instance {
    /// The number of the state.
    pub(crate) target: u32,
    pub(crate) above_from_target: DAffine3,
    pub(crate) target_from_above: DAffine3,
    /// S-nodes between.
    pub(crate) depth: u32,
    /// The state of the last of these, by its place among all states, if they are listed.
    pub(crate) symbol: Option<u32>,
    pub(crate) paint: Paint,
}

/// What paints something: each term once. A colour has three terms.
pub(crate) type Paint = SmallVec<[(AttributeTerm, f64); 3]>;

/// Paints what is inside of something painted. Of each term, the innermost value is seen.
pub(crate) fn paint_over(paint: &mut Paint, inner: impl IntoIterator<Item = (AttributeTerm, f64)>) {
    for (term, value) in inner {
        match paint.iter_mut().find(|(known, _)| *known == term) {
            Some((_, seen)) => *seen = value,
            None => paint.push((term, value)),
        }
    }
}

impl Instance {
    /// A state where it is.
    pub(crate) fn at(target: u32) -> Self {
        Self {
            target,
            above_from_target: DAffine3::IDENTITY,
            target_from_above: DAffine3::IDENTITY,
            depth: 0,
            symbol: None,
            paint: Paint::new(),
        }
    }

    /// The same for instances that coincide, and hardly for others.
    pub(super) fn fingerprint(&self) -> u64 {
        let mut hasher = FxHasher::default();
        hasher.write_u32(self.target);
        // Zero has two signs.
        let entries = self.target_from_above.to_cols_array();
        entries.into_iter().for_each(|entry| hasher.write_u64((entry + 0.0).to_bits()));
        hasher.finish()
    }

    /// Whether nobody can tell the instances from each other.
    pub(super) fn coincides(&self, other: &Self) -> bool {
        let Self { target, above_from_target: _, target_from_above, depth, symbol, paint } = self;
        (*target, *target_from_above, *depth, *symbol)
            == (other.target, other.target_from_above, other.depth, other.symbol)
            && *paint == other.paint
    }

    /// An instance in the frame of this one's target, seen from above this one.
    pub(crate) fn then(&self, below: &Self) -> Self {
        let mut paint = self.paint.clone();
        paint_over(&mut paint, below.paint.iter().copied());
        Self {
            target: below.target,
            above_from_target: self.above_from_target * below.above_from_target,
            target_from_above: below.target_from_above * self.target_from_above,
            depth: self.depth + below.depth,
            symbol: below.symbol.or(self.symbol),
            paint,
        }
    }
}

/// The map back, as rays take it.
pub(super) fn inverse(parent_from_child: &Transform) -> DAffine3 {
    let [x, y, z] = DVec3::AXES.map(|axis| parent_from_child.inverse_vector(axis));
    let translation = parent_from_child.inverse_point(DVec3::ZERO);
    DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation }
}
