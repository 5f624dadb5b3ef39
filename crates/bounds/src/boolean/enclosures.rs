//! Boxes of states and of their complements, bottom-up: box algebra with De Morgan's laws.
//!
//! A \ B is A ∩ ¬B, and its box may be cut by the box of ¬B. That is all of space for anything with an end; but the
//! complement of a half-space is a half-space. So each state has two boxes, one for the solid and one for what is not in
//! it, and complements go down to the shapes before any rule for boxes is used:
//!
//! > ¬(A ∪ B) = ¬A ∩ ¬B, ¬(A ∩ B) = ¬A ∪ ¬B, ¬(A \ B) = ¬A ∪ B
//!
//! The box of a solid is also never more than the exact one, which unions and transformations of them attain.

use super::inverse::Inverse;
use crate::exact::Term;
use crate::{Aabb, ExactBoxes, Scene, Shape};

/// Two boxes for each state, by its number.
pub(super) struct Enclosures {
    /// About the solid.
    pub(super) inside: Vec<Aabb>,
    /// About everything else.
    pub(super) outside: Vec<Aabb>,
    /// Whether there are only unions below, so that the exact box is the least one.
    pub(super) united: Vec<bool>,
}

impl Enclosures {
    pub(super) fn new<S: Scene>(exact: &ExactBoxes<S>) -> Self {
        let states = exact.graph();
        let boxes = exact.boxes();
        let count = states.terms.len();
        // What is not known yet, in a recursion, is at most this.
        let mut inside: Vec<Aabb> = boxes.iter().map(|found| found.aabb).collect();
        let mut outside = vec![Aabb::ALL; count];
        let mut united = vec![false; count];
        for number in 0..count {
            let (within, without, unions) = match states.terms[number] {
                Term::Shape(shape) => {
                    (inside[number], exact.shapes()[shape as usize].complement_bounds(), true)
                }
                Term::Same(below) => {
                    let below = below as usize;
                    (inside[below], outside[below], united[below])
                }
                Term::Map(map, below) => {
                    let (map, below) = (&states.maps[map as usize], below as usize);
                    // Under a singular map everything outside of a plane is in the complement, whatever is below.
                    let invertible = Inverse::of(map).is_some();
                    let without = if invertible { outside[below].image(map) } else { Aabb::ALL };
                    (inside[below].image(map), without, united[below])
                }
                Term::Union(ref parts) => {
                    let parts = &states.parts[parts.start as usize..parts.end as usize];
                    let each = || parts.iter().map(|part| *part as usize);
                    (
                        each().fold(Aabb::EMPTY, |all, part| all.join(inside[part])),
                        each().fold(Aabb::ALL, |all, part| all.intersect(outside[part])),
                        each().all(|part| united[part]),
                    )
                }
                Term::Intersection([a, b]) => {
                    let [a, b] = [a, b].map(|operand| operand as usize);
                    (inside[a].intersect(inside[b]), outside[a].join(outside[b]), false)
                }
                Term::Difference([a, b]) => {
                    let [a, b] = [a, b].map(|operand| operand as usize);
                    (inside[a].intersect(outside[b]), outside[a].join(inside[b]), false)
                }
            };
            inside[number] = inside[number].intersect(within);
            outside[number] = without;
            united[number] = unions;
        }
        Self { inside, outside, united }
    }
}
