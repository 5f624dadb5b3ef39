//! On which side of the primitives of [`csg_graph`] a cell lies.
//!
//! Convex primitives contain a cell if they contain its corners, each with the slack about it. A cell is outside if a
//! plane separates the two; the planes tried are those that the primitive's form suggests, which for rectangular cells
//! in the primitive's frame are all that matter. The torus, which is not convex, is asked about in the plane of the
//! distances ρ from its axis and z along it, where it is a disc.

use csg_graph::{Hull, Primitive};
use glam::{DVec2, DVec3};

use super::cell::{Cell, Side};
use crate::Shape;

/// Faces of a hull are found to this precision, relative to its size; points so close to one may belong to either side.
const FLATNESS: f64 = 1e-8;

/// Where the cell lies.
pub(crate) fn classify(primitive: &Primitive, cell: &Cell) -> Side {
    let corners = |contains: &dyn Fn(DVec3) -> bool| cell.corners().into_iter().all(contains);
    match primitive {
        Primitive::Sphere => {
            let near = cell.near(DVec3::ZERO);
            decide(
                || cell.least(near) > near.length(),
                || corners(&|corner| corner.length() + cell.slack <= 1.0),
            )
        }
        Primitive::Cylinder => revolved(cell, 1.0),
        Primitive::Cone => revolved(cell, 0.0),
        Primitive::Frustum { top } => revolved(cell, *top),
        Primitive::Cube => {
            let extents = DVec3::from_array(DVec3::AXES.map(|axis| cell.extent(axis)));
            let center = cell.center.abs();
            decide(
                || (center - extents).max_element() > 1.0 || cell.misses(primitive),
                || (center + extents).max_element() <= 1.0,
            )
        }
        Primitive::Torus { minor } => torus(cell, *minor),
        Primitive::Hull(hull) => polytope(hull, primitive, cell),
        Primitive::HalfSpace => decide(|| cell.least(DVec3::Z) > 0.0, || cell.most(DVec3::Z) <= 0.0),
        // Any primitive that this version does not know.
        _ => Side::Mixed,
    }
}

fn decide(outside: impl FnOnce() -> bool, inside: impl FnOnce() -> bool) -> Side {
    if outside() {
        Side::Outside
    } else if inside() {
        Side::Inside
    } else {
        Side::Mixed
    }
}

/// The body of revolution about z of radius 1 at z = 0 and `top` at z = 1: ρ ≤ 1 + (top − 1) z.
fn revolved(cell: &Cell, top: f64) -> Side {
    let slope = top - 1.0;
    let steepness = (1.0 + slope * slope).sqrt();
    let beyond_side = |radial: DVec2| cell.least(radial.extend(-slope)) > 1.0;
    decide(
        || {
            cell.least(DVec3::Z) > 1.0
                || cell.most(DVec3::Z) < 0.0
                || radials(cell).into_iter().any(beyond_side)
        },
        || {
            cell.corners().into_iter().all(|corner| {
                corner.z >= cell.slack
                    && corner.z + cell.slack <= 1.0
                    && corner.truncate().length() + cell.slack * steepness <= 1.0 + slope * corner.z
            })
        },
    )
}

/// Distances from the axis of revolution are at least those along any direction across it; these are good ones.
fn radials(cell: &Cell) -> [DVec2; 2] {
    let near = cell.near(DVec3::Z * cell.center.z);
    [near, cell.center].map(|point| point.truncate().normalize_or_zero())
}

fn torus(cell: &Cell, minor: f64) -> Side {
    let inner = radials(cell).map(|radial| cell.least(radial.extend(0.0))).into_iter().fold(0.0, f64::max);
    let outer = cell.corners().iter().fold(0.0, |most: f64, corner| most.max(corner.truncate().length()));
    let outer = outer + cell.slack;
    let [low, high] = [cell.least(DVec3::Z), cell.most(DVec3::Z)];
    let nearest = DVec2::new((inner - 1.0).max(1.0 - outer).max(0.0), low.max(-high).max(0.0));
    let furthest = DVec2::new((outer - 1.0).max(1.0 - inner), high.max(-low));
    // The ring is convex from outside: what is left of a cell that is not along the axes.
    decide(
        || nearest.length() > minor || cell.misses(&Primitive::Torus { minor }),
        || furthest.length() <= minor,
    )
}

fn polytope(hull: &Hull, primitive: &Primitive, cell: &Cell) -> Side {
    let faces = hull.faces();
    decide(
        || faces.iter().any(|face| cell.least(face.normal) > face.offset) || cell.misses(primitive),
        || {
            let uncertain = FLATNESS * primitive.bounds().size().max_element();
            faces.iter().all(|face| cell.most(face.normal) + uncertain <= face.offset)
        },
    )
}
