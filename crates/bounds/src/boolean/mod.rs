//! Booleans beyond the algebra of boxes: S-bounds, and branch and bound on the solid itself.
//!
//! The box of a lens, which is the intersection of two balls, is smaller than what the boxes of the balls have in
//! common; a cube without its upper half is half a cube. Two ways lead there from the exact boxes of all states:
//!
//! - [`enclosures`], [`sweeps`]: S-bounds, as \[CAME89\] has them, in a few passes over the states. Boxes cut boxes.
//! - [`terms`], [`search`]: branch and bound, which cuts space into cells and classifies them by the Boolean term, to
//!   a tolerance that is stated and a gap that is certified.
//!
//! The second asks shapes where a [`cell`] lies; [`primitive`] answers for those of `csg-graph`.

pub(crate) mod cell;
mod enclosures;
mod inverse;
#[cfg(feature = "csg-graph")]
pub(crate) mod primitive;
mod search;
mod sweeps;
mod terms;

pub use cell::{Cell, Side};
pub use search::{CellCounts, SolidBox, SolidSearch};
pub use sweeps::SBounds;

use crate::{ExactBoxes, Scene};

/// How hard branch and bound tries.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Refinement {
    /// The gap at which a direction is done, relative to the largest extent of the state's S-bound.
    ///
    /// By default 10⁻³.
    pub tolerance: f64,
    /// The most cells to classify and states to open for one direction, before what is uncertain is added to the bound.
    ///
    /// By default 100,000, which is some tenths of a second.
    pub cells: usize,
}

impl Default for Refinement {
    fn default() -> Self {
        Self { tolerance: 1e-3, cells: 100_000 }
    }
}

impl Refinement {
    /// The same with another [`tolerance`](Self::tolerance).
    #[must_use]
    pub fn with_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// The same with another number of [`cells`](Self::cells).
    #[must_use]
    pub fn with_cells(self, cells: usize) -> Self {
        Self { cells, ..self }
    }
}

impl<S: Scene> ExactBoxes<S> {
    /// S-bounds: boxes cut by boxes, up and down the graph, until nothing more is gained.
    ///
    /// The root's box is never larger than the exact one, which follows the algebra of boxes. A difference is cut by the
    /// complement of its right operand, which is of use if that is a half-space: `cube \ halfspace` has half the cube.
    ///
    /// # Cost
    /// A few passes over all states, each some tens of nanoseconds a state.
    ///
    /// # Panics
    /// If the scene is not the one of these boxes.
    pub fn s_bounds(&self, scene: &S) -> SBounds<'_, S> {
        sweeps::s_bounds(self, scene)
    }

    /// Branch and bound on the solid below a state. `None` if the root does not lead to the state.
    ///
    /// # Cost
    /// Sweeps over all states, then some hundred to some ten thousand cells for each direction, each of which takes about
    /// as long as it takes to classify what is mixed in it: milliseconds for solids of some ten primitives. Recursion is
    /// opened where it decides something, so that its depth matters little.
    pub fn solid(&self, state: &S::State, refinement: &Refinement) -> Option<SolidSearch<'_, S>> {
        let number = self.graph().number(state)?;
        Some(SolidSearch::new(self, number, *refinement))
    }

    /// Branch and bound on the solid of the root.
    ///
    /// ```
    /// # #[cfg(feature = "csg-graph")] fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// use csg_graph::{Expr, GraphBuilder, Operator, PrimitiveKind, TransformKind};
    /// use csg_graph_bounds::{Limits, Refinement, exact};
    ///
    /// // Two balls of radius 1, with a distance of 1.6 between their centers, have a lens in common.
    /// let mut builder = GraphBuilder::new();
    /// let ball = builder.primitive(PrimitiveKind::Sphere, []);
    /// let [low, high] = [-0.8, 0.8].map(|z| {
    ///     builder.transform(TransformKind::Move, [0.0, 0.0, z].map(Expr::from), ball)
    /// });
    /// let lens = builder.operator(Operator::Intersection, low, high);
    /// let graph = builder.finish(lens)?;
    ///
    /// let boxes = exact(&graph, &Limits::default())?;
    /// assert!((boxes.root.max.x - 1.0).abs() < 1e-12);
    /// let found = boxes.root_solid(&Refinement::default()).aabb();
    /// assert!(0.6 <= found.aabb.max.x && found.aabb.max.x < 0.602);
    /// # Ok(())
    /// # }
    /// # #[cfg(not(feature = "csg-graph"))] fn main() {}
    /// ```
    pub fn root_solid(&self, refinement: &Refinement) -> SolidSearch<'_, S> {
        SolidSearch::new(self, self.graph().terms.len() - 1, *refinement)
    }
}
