//! Bounding boxes for scene graphs: trees, dags, and recursive procedures that are never unfolded.
//!
//! The box about a transformed box is larger than the box about the transformed solid. One such step hardly matters; a
//! scene graph takes one at every level, and where rotations or shears follow each other the boxes grow with each until
//! they are useless. This crate has three algorithms:
//!
//! | | how a transformation comes to its box | boxes | time | sympodial tree of order 12 |
//! |---|---|---|---|---|
//! | [`conventional`] | box of the transformed box below | grow with the depth | nodes of the unfolded tree | 0.1 s |
//! | [`chain`] | box of the shapes' transformed points | tight | shapes of it × transformations above each | 1.8 s |
//! | [`exact`] | supports of what is below, searched best first | exact, one a state | states × levels that a part takes to shrink to nothing | 0.3 ms |
//!
//! The first is everybody's; the second is \[TRAX95\]'s, which sends the points of each shape up *through the whole chain
//! of transformations*. Both walk the unfolded tree, which doubles with every level. The third does not: what is below
//! a node depends only on the node and on the values that are still read below it, its *state*. The tree of order 60 has
//! 1.8 · 10¹⁹ primitives and 774 states, and takes 5 ms. **Use [`exact`]**; the others are there to compare with.
//!
//! # A scene of one's own
//!
//! The algorithms know nothing of files, meshes or grammars. They ask a [`Scene`] for its root *state* and for what is
//! directly below a state: a shape, a transformed state, or a union, intersection or difference of states. A state is
//! whatever decides what is below: a reference to a node of a tree, or a few numbers of a recursive procedure.
//!
//! Here is a column of blocks, each smaller than the one below it and turned by 15°, as a procedure with one parameter:
//!
//! ```
//! use std::convert::Infallible;
//!
//! use csg_graph_bounds::{Aabb, Limits, Scene, Step, conventional, exact};
//! use glam::{DAffine3, DVec3};
//!
//! struct Column;
//!
//! /// The numbers say how many blocks are to come.
//! #[derive(Clone, PartialEq, Eq, Hash)]
//! enum State {
//!     Column(u32),
//!     Above(u32),
//!     Block,
//! }
//!
//! impl Scene for Column {
//!     type State = State;
//!     type Map = DAffine3;
//!     type Shape = Aabb;
//!     type Error = Infallible;
//!
//!     fn root(&self) -> State {
//!         State::Column(20)
//!     }
//!
//!     fn step(&self, state: &State) -> Result<Step<Self>, Infallible> {
//!         Ok(match *state {
//!             State::Column(0) => Step::Union(vec![]),
//!             State::Column(blocks) => Step::Union(vec![State::Block, State::Above(blocks - 1)]),
//!             State::Above(blocks) => {
//!                 let parent_from_column = DAffine3::from_translation(DVec3::Z)
//!                     * DAffine3::from_rotation_z(15_f64.to_radians())
//!                     * DAffine3::from_scale(DVec3::splat(0.9));
//!                 Step::Map(parent_from_column, State::Column(blocks))
//!             }
//!             State::Block => Step::Shape(Aabb::new(DVec3::new(-1.0, -1.0, 0.0), DVec3::ONE)),
//!         })
//!     }
//!
//!     // Three nodes get a box each.
//!     fn node(&self, state: &State) -> usize {
//!         match state {
//!             State::Column(_) => 0,
//!             State::Above(_) => 1,
//!             State::Block => 2,
//!         }
//!     }
//!
//!     fn node_count(&self) -> usize {
//!         3
//!     }
//! }
//!
//! let column = exact(&Column, &Limits::default())?;
//! assert!(column.root.size().x < 2.3);
//! assert!(column.gap < 1e-9);
//!
//! // Every state has a box.
//! let upper_half = column.of(&State::Column(10)).unwrap();
//! assert!(upper_half.aabb.size().z < column.root.size().z);
//!
//! let loose = conventional(&Column, &Limits::default())?;
//! assert!(loose.root.size().x > 12.0);
//! # Ok::<(), csg_graph_bounds::BoundsError<Infallible>>(())
//! ```
//!
//! - The transformations are [`glam`]'s here; any affine function of points is a [`Map`].
//! - An [`Aabb`] is a [`Shape`] itself, a cuboid. Other shapes say their box, their support, and, for [`chain`], their
//!   [`PointSet`], points whose hull *encloses* the shape. For polytopes and meshes those are the vertices; for balls,
//!   cylinders, cones and tori the point sets are here, with a proof of what they enclose and of how much they exceed
//!   it, at most [`EXCESS`].
//! - Equal states must be the same solid, and the fewer states there are the better: a state that carries a value that
//!   nothing below it reads is many states.
//! - A scene that can fail says how in its `Error`. It arrives as [`BoundsError::Scene`].
//!
//! # What comes out
//!
//! From all three the box of the root and, for every node, its *hyper box*: the union over all its places in the unfolded
//! tree, in the node's own frame; for a transformation that is the frame that it maps *into*. A ray tracer that maps rays
//! down the graph tests each ray in the frame where it is, and so meets the boxes of all levels.
//!
//! From [`exact`], as [`ExactBoxes`], also the box of every state, and supports in any direction, of which other volumes
//! are made: a [`Volume`] is a box, a sphere, slabs in 3 to 13 directions, or an oriented box, each from any function that
//! answers support queries. [`root_box`] is for those who need only the root's box.
//!
//! ```
//! # #[cfg(feature = "csg-graph")] fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # use csg_graph::{Expr, GraphBuilder, PrimitiveKind, TransformKind};
//! use csg_graph_bounds::{Limits, Obb, Slabs, Sphere, Volume, exact};
//!
//! // A needle that lies across the axes.
//! # let mut builder = GraphBuilder::new();
//! # let cylinder = builder.primitive(PrimitiveKind::Cylinder, []);
//! # let needle = builder.transform(TransformKind::Scale, [0.1, 0.1, 10.0].map(Expr::from), cylinder);
//! # let root = builder.transform(TransformKind::Rot, [1.0, -1.0, 0.3, 50.0].map(Expr::from), needle);
//! # let graph = builder.finish(root)?;
//! let boxes = exact(&graph, &Limits::default())?;
//! let state = graph.root_state();
//! let support = |direction| boxes.support(&state, direction).map_or(f64::INFINITY, |found| found.upper);
//!
//! let sphere = Sphere::from_support(support).surface_area();
//! let slabs = Slabs::<13>::from_support(support).surface_area();
//! let oriented = Obb::from_support(support).surface_area();
//! assert!(oriented < slabs && slabs < boxes.root.surface_area() && boxes.root.surface_area() < sphere);
//! # Ok(())
//! # }
//! # #[cfg(not(feature = "csg-graph"))] fn main() {}
//! ```
//!
//! **Boxes are conservative**, in floating point too: each is rounded outward by what the maps of its chain may have
//! rounded, some 10⁻¹⁵ of the magnitudes on the way. Infinite or overflowing coordinates give sides without end, never a
//! number that is none. A solid with no points has the canonical [`Aabb::EMPTY`]. To store boxes in single precision, use
//! [`Aabb::to_f32_outward`].
//!
//! **∩ and \\** follow the algebra of boxes: an intersection has what is in both boxes, a difference the box of its left
//! operand. An operand's own box is never clipped by the other. Unbounded shapes are fine wherever an operator bounds
//! them. [`exact`] leaves nothing of an intersection where it finds a plane between the operands.
//!
//! Two more ways start from exact boxes and go beyond that algebra:
//!
//! - [`ExactBoxes::s_bounds`] lets operands cut each other's boxes, up and down the graph (\[CAME89\]'s S-bounds): a few
//!   passes over the states. Besides the root's box it gives each state's *context*, the box outside of which the state
//!   cannot matter to the root. That is not the box of the state.
//! - [`ExactBoxes::solid`] and [`ExactBoxes::root_solid`] bound the solid itself, to a stated tolerance and with a certified
//!   gap: branch and bound cuts space into cells, and shapes [classify](Shape::classify) them. Milliseconds for a state.
//!
//! ```
//! # #[cfg(feature = "csg-graph")] fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # use csg_graph::{Expr, GraphBuilder, Operator, PrimitiveKind, TransformKind};
//! use csg_graph_bounds::{Limits, Refinement, exact};
//!
//! // A cube without a ball about the middle of a face, which leaves the corners of the other side; and of that, what is
//! // above z = -0.5.
//! # let mut builder = GraphBuilder::new();
//! # let cube = builder.primitive(PrimitiveKind::Cube, []);
//! # let ball = builder.primitive(PrimitiveKind::Sphere, []);
//! # let ball = builder.transform(TransformKind::UScale, [Expr::from(2.2)], ball);
//! # let ball = builder.transform(TransformKind::Move, [1.0, 0.0, 0.0].map(Expr::from), ball);
//! # let half_space = builder.primitive(PrimitiveKind::HalfSpace, []);
//! # let plane = builder.transform(TransformKind::Move, [0.0, 0.0, -0.5].map(Expr::from), half_space);
//! # let rest = builder.operator(Operator::Difference, cube, ball);
//! # let root = builder.operator(Operator::Difference, rest, plane);
//! # let graph = builder.finish(root)?;
//! let boxes = exact(&graph, &Limits::default())?;
//! let cut = boxes.s_bounds(&graph).root;
//! let solid = boxes.root_solid(&Refinement::default()).aabb();
//! assert!(solid.gap < 2.1e-3);
//! assert_eq!([boxes.root, cut, solid.aabb].map(|bounds| (10.0 * bounds.volume()).round()), [80.0, 60.0, 9.0]);
//! # Ok(())
//! # }
//! # #[cfg(not(feature = "csg-graph"))] fn main() {}
//! ```
//!
//! **Recursion need not end.** A state that leads back to itself is bounded by [`exact`] if it is smaller there: a column
//! whose next block is always another one has a top. Its solid is then the attractor of the maps on the way, with all shapes
//! that the recursion leaves behind, and [`ExactBoxes::endless`] says by how much it shrinks. What does not shrink is an
//! error that names the cycle. For the other two algorithms it is just another tree that is too deep.
//!
//! **Nor need states be few.** Where random numbers make every instance a state of its own, `Envelopes` bound the solid
//! below a state of a cyclic graph without a look at what is below it: a look-up for a tree whose branches turn by chance,
//! some ten microseconds a level for a terrain.
//!
//! **Work is limited.** [`Limits`] bound steps, states and memory, and an error says which limit was met. Nothing
//! recurses on the machine stack. Results depend on nothing but the scene and the limits.
//!
//! # Features
//!
//! - `csg-graph`, on by default: [`Scene`] for the cyclic graphs of the crate
//!   [`csg-graph`](https://docs.rs/csg-graph), and `Envelopes` for their states by chance.
//!
//! # Examples
//!
//! Three scenes of other people: `meshes`, a plain tree of transformed meshes; `assembly`, an instancing dag of shared
//! sub-assemblies; `procedure`, a recursive procedure with parameters. And `growth`, which prints the paper's Fig. 2.1 and
//! the same for its Fig. 1.1a; `tightness`, which compares all ways to bound ∩ and \\ with dense sampling; and `prove`,
//! which looks for points outside of their volumes.
//!
//! \[TRAX95\] C. Traxler, M. Gervautz, *Calculation of Tight Bounding Volumes for Cyclic CSG-Graphs*, Institute of
//! Computer Graphics, Technical University of Vienna, 1995.
//!
//! \[CAME89\] S. Cameron, *Efficient Intersection Tests for Objects Defined Constructively*, International Journal of
//! Robotics Research 8(1), 1989.

mod aabb;
mod best_first;
mod boolean;
mod chain;
mod conventional;
#[cfg(feature = "csg-graph")]
mod csg_graph;
#[cfg(feature = "csg-graph")]
mod envelope;
mod exact;
mod limits;
mod narrow;
mod point_set;
mod rounding;
mod scene;
mod volume;
mod walk;

pub use aabb::Aabb;
pub use boolean::{Cell, CellCounts, Refinement, SBounds, Side, SolidBox, SolidSearch};
pub use chain::chain;
pub use conventional::conventional;
#[cfg(feature = "csg-graph")]
pub use envelope::{Envelope, Envelopes};
pub use exact::{Counts, Endless, ExactBoxes, StateBox, Support, exact, root_box};
pub use limits::{BoundsError, Limits, Round};
pub use point_set::{EXCESS, PointSet};
pub use scene::{Map, Scene, Shape, Step};
pub use volume::{CertifiedSphere, Obb, Slabs, Sphere, Volume};
pub use walk::HyperBoxes;

/// The README's example is a test.
#[cfg(all(doctest, feature = "csg-graph"))]
#[doc = include_str!("../README.md")]
struct Readme;
