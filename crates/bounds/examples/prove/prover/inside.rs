//! Whether a point is inside a solid, outside, or too near to a boundary to tell.
//!
//! Points on the surface of an operand of ∩ or \ belong to the result only where the other operand says so. That
//! question goes down the graph with the point, in plain `f64`, together with how far off the point may be. It need not
//! be answered always: a point that nobody is certain of is not counted.
//!
//! Boxes prune the way down, although they are what is to be proved: an operand whose box is too small makes points of
//! ∩ be forgotten. But the operand's own points are counted for its own box, whatever is above it.

use csg_graph::{Primitive, Transform};
use glam::{DMat3, DVec3};

use super::scene::{States, Term};

/// How many states may be visited for one point.
const VISITS: usize = 2_000;

/// What plain arithmetic may err, relative to the numbers in play, with much room.
const PRECISION: f64 = 256.0 * f64::EPSILON;

enum Task {
    Visit { state: usize, point: DVec3, error: f64 },
    Union(usize),
    Intersection,
    Difference,
}

/// Whether a point, given to within `error`, is in the solid of a state.
pub(crate) fn inside(states: &States, state: usize, point: DVec3, error: f64) -> Option<bool> {
    let mut tasks = vec![Task::Visit { state, point, error: error + PRECISION * point.abs().max_element() }];
    let mut known: Vec<Option<bool>> = Vec::new();
    let mut visits = 0;
    while let Some(task) = tasks.pop() {
        let mut take = || known.pop().expect("an operator comes after its operands");
        let found = match task {
            Task::Visit { state, point, error } => {
                visits += 1;
                if visits > VISITS || !error.is_finite() {
                    return None;
                }
                let state = &states.all[state];
                let visit = |state: usize| Task::Visit { state, point, error };
                let bounds = state.bounds;
                if (point + error).cmplt(bounds.min).any() || (point - error).cmpgt(bounds.max).any() {
                    Some(false)
                } else {
                    match &state.term {
                        Term::Shape(primitive) => in_primitive(primitive, point, error),
                        Term::Same(below) => {
                            tasks.push(visit(*below));
                            continue;
                        }
                        Term::Map(parent_from_child, below) => {
                            let (point, error) = lowered(parent_from_child, point, error);
                            tasks.push(Task::Visit { state: *below, point, error });
                            continue;
                        }
                        Term::Union(parts) => {
                            tasks.push(Task::Union(parts.len()));
                            tasks.extend(parts.iter().copied().map(visit));
                            continue;
                        }
                        Term::Intersection(operands) => {
                            tasks.push(Task::Intersection);
                            tasks.extend(operands.map(visit));
                            continue;
                        }
                        Term::Difference(operands) => {
                            tasks.push(Task::Difference);
                            tasks.extend(operands.map(visit));
                            continue;
                        }
                    }
                }
            }
            Task::Union(parts) => (0..parts).map(|_| take()).reduce(or).unwrap_or(Some(false)),
            Task::Intersection => not(or(not(take()), not(take()))),
            // The left operand is asked last, and so answers first.
            Task::Difference => not(or(not(take()), take())),
        };
        known.push(found);
    }
    known.pop().expect("every task leaves an answer")
}

fn or(a: Option<bool>, b: Option<bool>) -> Option<bool> {
    match (a, b) {
        (Some(true), _) | (_, Some(true)) => Some(true),
        (Some(false), Some(false)) => Some(false),
        _ => None,
    }
}

fn not(a: Option<bool>) -> Option<bool> {
    a.map(|a| !a)
}

/// A point of the frame above a T-node in the frame below, with how far off it may be there.
fn lowered(parent_from_child: &Transform, point: DVec3, error: f64) -> (DVec3, f64) {
    let norm = |m: DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    let (forward, offset, inverse) = match parent_from_child {
        Transform::Translate(offset) => (1.0, offset.abs().max_element(), 1.0),
        Transform::Scale(factors) => (factors.length(), 0.0, factors.recip().length()),
        Transform::Affine { forward, inverse } => {
            (norm(forward.matrix3), forward.translation.abs().max_element(), norm(inverse.matrix3))
        }
        _ => (1.0, 0.0, 1.0),
    };
    let below = parent_from_child.inverse_point(point);
    let reach = point.abs().max_element() + offset + forward * below.abs().max_element();
    // An inverse that was computed is off by as much as its condition says.
    (below, inverse * (error + PRECISION * (1.0 + forward * inverse) * reach))
}

/// By a function that is negative inside and grows no faster than `slope`.
fn in_primitive(primitive: &Primitive, p: DVec3, error: f64) -> Option<bool> {
    let rho = p.truncate().length();
    let (height, slope) = match primitive {
        Primitive::Sphere => (p.length() - 1.0, 1.0),
        Primitive::Cylinder => ((rho - 1.0).max(p.z - 1.0).max(-p.z), 1.0),
        Primitive::Cone => ((rho + p.z - 1.0).max(-p.z), 2.0),
        Primitive::Frustum { top } => {
            let side = rho - 1.0 - (top - 1.0) * p.z;
            (side.max(p.z - 1.0).max(-p.z), 2.0 + top)
        }
        Primitive::Cube => (p.abs().max_element() - 1.0, 1.0),
        Primitive::Torus { minor } => (libm::hypot(rho - 1.0, p.z) - minor, 1.0),
        Primitive::Hull(hull) => {
            let heights = hull.faces().iter().map(|face| face.normal.dot(p) - face.offset);
            // The normals of flat hulls are less certain than points.
            (heights.fold(f64::NEG_INFINITY, f64::max), 1e6)
        }
        Primitive::HalfSpace => (p.z, 1.0),
        _ => return None,
    };
    let margin = slope * (3.0 * error + PRECISION * (1.0 + p.abs().max_element()));
    if height > margin {
        Some(false)
    } else if height < -margin {
        Some(true)
    } else {
        None
    }
}
