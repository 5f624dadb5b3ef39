//! Cyclic CSG graphs: recursive solids in a few kilobytes, at any depth.
//!
//! A *CSG-PL-system* is a grammar whose words are CSG expressions. Traxler and Gervautz translate it directly into a
//! graph, instead of deriving and interpreting a word \[TRAX95\]: each rule becomes a CSG tree, and each occurrence of
//! a symbol on a right-hand side an edge back to that symbol. This crate is that graph. It knows no text and no picture.
//!
//! | node | what it does |
//! |---|---|
//! | S-node ([`node::Symbol`]) | joins the rules of a symbol; its *selection function* picks one |
//! | C-node ([`node::Calculation`]) | changes parameters for what is below it |
//! | T-node ([`node::Transformation`]) | maps what is below it into the frame above it |
//! | operator ([`node::OperatorNode`]) | ∪, ∩ or \ of two solids |
//! | primitive ([`node::PrimitiveNode`]) | a sphere, a cylinder, … |
//! | attribute ([`node::AttributeNode`]) | colour and material of what is below it |
//!
//! A [`GraphBuilder`] makes graphs, validated once when they are finished; see there for a small one. Every cycle passes
//! an S-node, so that the parameters decide where recursion ends.
//!
//! # States
//! What a node unfolds into depends on the node and on the values of the parameters that can still be read below it: its
//! [`State`]. [`Graph::step`] says what a state is and which states are below it, which is all that an algorithm needs to
//! know; [`Graph::states`] lists them, each once. There are few of them even where the unfolded tree is beyond counting
//! one by one, and so [`Graph::analyse`] counts it exactly:
//!
//! ```
//! use csg_graph::{Expr, GraphBuilder, PrimitiveKind, TransformKind};
//!
//! // Two copies of itself, sixty levels deep.
//! let mut builder = GraphBuilder::new();
//! let n = builder.param("n", 60.0);
//! let dust = builder.symbol("DUST");
//! let ball = builder.primitive(PrimitiveKind::Sphere, []);
//! let copies = [-1.0, 1.0].map(|x| {
//!     let small = builder.transform(TransformKind::UScale, [(1.0 / 3.0).into()], dust);
//!     builder.transform(TransformKind::Move, [x.into(), 0.0.into(), 0.0.into()], small)
//! });
//! let both = builder.union(copies);
//! let deeper = builder.calculate([(n, Expr::from(n) - 1.0)], both);
//! builder.rules(dust, Some(Expr::choose(n, 2.0, 1.0)), [ball, deeper]);
//! let graph = builder.finish(dust)?;
//!
//! let analysis = graph.analyse(&Default::default())?;
//! assert_eq!(analysis.states, 61);
//! assert_eq!(analysis.primitives.to_string(), "1152921504606846976");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Chance
//! Random numbers are functions of a *seed*, which is a parameter like any other: [`Expr::draw`] draws from it, and the
//! C-node of [`GraphBuilder::reseed`] gives what is below it another one. So every occurrence of a symbol can be different,
//! and equal states are equal solids all the same.
//!
//! What an expression may give while its parameters vary, and numbers are drawn, is its [range](Expr::range).
//!
//! # Frames
//! A T-node maps from the frame below it into the frame above it; points are columns, and a chain of T-nodes
//! T_k, …, T_1 from the root to a primitive maps a point p of the primitive's object frame C₀ to T_k(…(T_1(p))).
//! Coordinates are right-handed, angles are degrees.
//!
//! # Determinism
//! Evaluation uses no arithmetic that the platform decides (trigonometry and powers come from `libm`), so that states,
//! counts and everything built on them are the same on every machine.
//!
//! \[TRAX95\]: C. Traxler, M. Gervautz, *Calculation of Tight Bounding Volumes for Cyclic CSG-Graphs*, 1995.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod analysis;
mod angle;
mod arithmetic;
mod build;
mod dot;
mod env;
mod eval;
mod expr;
mod function;
mod graph;
mod hull;
mod id;
mod interval;
mod liveness;
pub mod node;
mod number;
mod primitive;
mod random;
mod residual;
mod states;
mod transform;
mod unfold;
mod validate;
mod vocabulary;

pub use analysis::Analysis;
pub use arithmetic::{Binary, Unary};
pub use build::GraphBuilder;
pub use env::Env;
pub use eval::{EvalError, Fault, Place, State, Step};
pub use expr::Expr;
pub use function::Function;
pub use graph::Graph;
pub use hull::{Face, HULL_POINTS, Hull, HullError};
pub use id::{NodeId, ParamId};
pub use interval::Interval;
pub use node::{AttributeTerm, Node, Operator};
pub use num_bigint::BigUint;
pub use number::Number;
pub use primitive::{Primitive, PrimitiveError, PrimitiveKind};
pub use random::NORMAL_REACH;
pub use residual::Residual;
pub use states::{Limits, StateGraph, StatesError, SymbolState};
pub use transform::{Axis, Transform, TransformKind};
pub use unfold::{UnfoldError, UnfoldedNode, UnfoldedTree};
pub use validate::GraphError;
