//! How small the smallest parts are.
//!
//! A branch of order 120 is 10⁻²¹ times as large as its tree, and coordinates have sixteen digits. From the outside, a ray
//! comes to such a branch with none of them right: it meets the boxes of both of its parts or neither, as rounding has it, and
//! where it meets both, again and again, it is unfolding the tree. Who follows rays has to know that before.

use super::ExactBoxes;
use super::states::Term;
use crate::Scene;
use crate::narrow::index;

impl<S: Scene> ExactBoxes<S> {
    /// How large the smallest part is that has parts in it, as a share of the whole: the diagonals of the boxes of unions,
    /// intersections and differences, times what all maps above do to lengths, by the cube root of what they do to volumes:
    /// a map that flattens counts as one that shrinks. 0 where recursion never ends, and infinite if no part has parts.
    ///
    /// # Cost
    /// One pass over all states.
    pub fn finest(&self) -> f64 {
        let states = &self.found.states;
        if states.cyclic {
            return 0.0;
        }
        let mut finest: Vec<f64> = Vec::with_capacity(states.terms.len());
        for (number, term) in states.terms.iter().enumerate() {
            let below = states.operands(index(number)).iter();
            let below = below.map(|below| finest[*below as usize]).fold(f64::INFINITY, f64::min);
            finest.push(match term {
                Term::Shape(_) | Term::Same(_) => below,
                Term::Map(map, _) => {
                    below * libm::cbrt(states.maps[*map as usize].matrix3.determinant().abs())
                }
                Term::Union(_) | Term::Intersection(_) | Term::Difference(_) => {
                    let aabb = self.found.boxes[number].aabb;
                    if aabb.is_empty() { below } else { below.min(aabb.size().length()) }
                }
            });
        }
        finest.last().map_or(f64::INFINITY, |finest| finest / self.root.size().length())
    }
}
