//! A closer box of one state: envelopes of what is below it, opened where they reach furthest.
//!
//! A face of the box is a support, and is searched best first, as for [exact boxes](crate::exact): what may reach furthest
//! is looked at next, until that is a primitive. With chance no state comes twice, and nothing is learned for the next
//! search but where to stop: after so many steps, the furthest that is left is the answer.

use std::collections::BinaryHeap;

use csg_graph::{EvalError, Operator, State, Step};
use glam::{DAffine3, DVec3};

use super::Envelopes;
use crate::best_first::best_first;
use crate::rounding::Rounding;
use crate::{Aabb, BoundsError, Shape};

/// What may reach furthest.
struct Open {
    /// No further than this.
    upper: f64,
    /// The direction in the frame of the state, and the support of the origin of that frame.
    direction: DVec3,
    offset: f64,
    /// How far these two may be off.
    tilt: f64,
    shift: f64,
    /// None for a primitive, whose support is known.
    state: Option<State>,
}

impl Envelopes {
    /// A box of the solid below a state, in the frame of the state, that is closer than that of its
    /// [envelope](Envelopes::of): envelopes are opened where they reach furthest, at most `steps` nodes for each face.
    ///
    /// # Cost
    /// A node takes what a question takes.
    ///
    /// # Errors
    /// As for `of`, and if an expression of a node has no usable value.
    ///
    /// # Panics
    /// As for `of`.
    pub fn refined_box(&self, state: &State, steps: usize) -> Result<Aabb, BoundsError<EvalError>> {
        let outer = self.of(state)?.aabb();
        if outer.is_empty() {
            return Ok(outer);
        }
        let mut refined = outer;
        for axis in 0..3 {
            refined.max[axis] = self.reach(state, DVec3::AXES[axis], steps)?.min(outer.max[axis]);
            refined.min[axis] = (-self.reach(state, -DVec3::AXES[axis], steps)?).max(outer.min[axis]);
        }
        // Opposite faces pass each other where nothing is left of an intersection.
        Ok(if refined.min.cmple(refined.max).all() { refined } else { Aabb::EMPTY })
    }

    /// How far a state reaches in a direction, at most.
    fn reach(&self, state: &State, direction: DVec3, steps: usize) -> Result<f64, BoundsError<EvalError>> {
        let upper = self.of(state)?.support(direction);
        let state = Some(state.clone());
        let mut open =
            BinaryHeap::from([Open { upper, direction, offset: 0.0, tilt: 0.0, shift: 0.0, state }]);
        for _ in 0..steps {
            let Some(furthest) = open.pop() else { return Ok(f64::NEG_INFINITY) };
            let Some(state) = &furthest.state else { return Ok(furthest.upper) };
            let below = match self.graph.step(state).map_err(BoundsError::Scene)? {
                Step::Select(below) | Step::Calculate(below) | Step::Attribute(_, below) => {
                    [Some(self.open(&furthest, below)?), None]
                }
                Step::Transform(map, below) => {
                    let frame = furthest.below(&map.to_affine());
                    [Some(self.open(&frame, below)?), None]
                }
                Step::Operator(Operator::Union, [left, right]) => {
                    [Some(self.open(&furthest, left)?), Some(self.open(&furthest, right)?)]
                }
                Step::Operator(Operator::Intersection, operands) => {
                    let [left, right] = operands.map(|operand| self.open(&furthest, operand));
                    let (left, right) = (left?, right?);
                    [Some(if left.upper <= right.upper { left } else { right }), None]
                }
                Step::Operator(_, [left, _]) => [Some(self.open(&furthest, left)?), None],
                Step::Primitive(primitive) => {
                    let bounds = primitive.bounds();
                    let radius = bounds.min.abs().max(bounds.max.abs()).length();
                    let upper = furthest.upper(primitive.support(furthest.direction), radius);
                    [Some(Open { upper, state: None, ..furthest }), None]
                }
                _ => return Ok(furthest.upper),
            };
            open.extend(below.into_iter().flatten());
        }
        Ok(open.pop().map_or(f64::NEG_INFINITY, |furthest| furthest.upper))
    }

    /// A state below, in the frame of what is above it.
    fn open(&self, above: &Open, state: State) -> Result<Open, BoundsError<EvalError>> {
        let envelope = self.of(&state)?;
        let upper = above.upper(envelope.support(above.direction), envelope.radius());
        Ok(Open { upper, state: Some(state), ..*above })
    }
}

impl Open {
    /// In the frame that a map is from. Its state is not known yet.
    fn below(&self, map: &DAffine3) -> Self {
        // Of a sum of four products.
        const ROUNDING: f64 = 4.0 * f64::EPSILON;
        let gain = Rounding::of(map).gain();
        let length = self.direction.length();
        let offset = self.offset + map.translation.dot(self.direction);
        let moved = map.translation.length();
        Self {
            upper: self.upper,
            direction: map.matrix3.transpose() * self.direction,
            offset,
            tilt: gain * (self.tilt + ROUNDING * length),
            shift: self.shift
                + moved * (self.tilt + ROUNDING * length)
                + ROUNDING * (self.offset.abs() + offset.abs()),
            state: None,
        }
    }

    /// How far something with that support in the direction reaches, within a ball about the origin.
    fn upper(&self, support: f64, radius: f64) -> f64 {
        let error = self.shift + self.tilt * radius;
        // Without an end there is no error that could be added.
        let reach = if support.is_finite() { self.offset + support + error } else { support };
        reach.next_up().min(self.upper)
    }
}

best_first!(Open: upper);
