//! Placeholder head.

mod angle;
mod build;
mod env;
mod eval;
mod expr;
mod graph;
mod hull;
mod id;
mod liveness;
pub mod node;
mod primitive;
mod transform;
mod validate;

pub use build::GraphBuilder;
pub use env::Env;
pub use eval::{EvalError, Fault, Place, State, Step};
pub use expr::{Binary, Expr, Function, Unary};
pub use graph::Graph;
pub use hull::{Face, HULL_POINTS, Hull, HullError};
pub use id::{NodeId, ParamId};
pub use node::{AttributeTerm, Node, Operator};
pub use primitive::{Primitive, PrimitiveError, PrimitiveKind};
pub use transform::{Axis, Transform, TransformKind};
pub use validate::GraphError;
