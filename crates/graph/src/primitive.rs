//! The primitive solids, in their object frame C₀.

use std::sync::Arc;

use glam::DVec3;

use crate::vocabulary::vocabulary;
use crate::{Hull, Number, hull::HullError};

/// A primitive solid with its measures.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Primitive {
    /// The unit ball at the origin.
    Sphere,
    /// Radius 1 about the z axis, z from 0 to 1.
    Cylinder,
    /// Base radius 1 at z = 0, apex at z = 1.
    Cone,
    /// Radius 1 at z = 0, radius `top` at z = 1.
    Frustum {
        /// The radius at z = 1: positive.
        top: f64,
    },
    /// \[−1, 1\]³
    Cube,
    /// Major radius 1 about the z axis.
    Torus {
        /// The minor radius: positive, at most 1.
        minor: f64,
    },
    /// A convex polytope.
    Hull(Arc<Hull>),
    /// z ≤ 0. Unbounded: a finished graph has it only where an intersection or a subtraction bounds it.
    HalfSpace,
}

vocabulary! {
    /// A primitive of the language, before its arguments have values.
    pub enum PrimitiveKind {
        Sphere: "sphere", "the unit ball at the origin";
        Cylinder: "cylinder", "radius 1 about the z axis, z from 0 to 1";
        Cone: "cone", "base radius 1 at z = 0, apex at z = 1";
        Frustum: "frustum(top)", "a cone cut off: radius 1 at z = 0, radius `top` > 0 at z = 1";
        Cube: "cube", "[−1, 1]³";
        Torus: "torus(r)", "major radius 1 about the z axis, minor radius r, 0 < r ≤ 1";
        Tetrahedron: "tetrahedron", "vertices (1, 1, 1), (1, −1, −1), (−1, 1, −1), (−1, −1, 1)";
        Octahedron: "octahedron", "vertices ±1 on the axes";
        Dodecahedron: "dodecahedron", "regular, vertices on the unit sphere, edges along the axes' planes";
        Icosahedron: "icosahedron", "regular, vertices on the unit sphere, edges along the axes' planes";
        Hull: "hull((x, y, z), …)", "the convex hull of four or more points, not all in a plane";
        HalfSpace: "halfspace", "z ≤ 0; unbounded, so legal only where ∩ or \\ bounds it";
    }
}

impl Primitive {
    /// The memory that it takes, in bytes, with the points and faces of a hull.
    pub fn bytes(&self) -> usize {
        let hull = if let Self::Hull(hull) = self { hull.bytes() } else { 0 };
        size_of_val(self) + hull
    }

    /// Numbers that are equal for equal primitives and for no others.
    pub(crate) fn words(&self) -> Vec<f64> {
        match self {
            Self::Sphere => vec![0.0],
            Self::Cylinder => vec![1.0],
            Self::Cone => vec![2.0],
            Self::Frustum { top } => vec![3.0, *top],
            Self::Cube => vec![4.0],
            Self::Torus { minor } => vec![5.0, *minor],
            Self::Hull(hull) => {
                std::iter::once(6.0).chain(hull.points().iter().flat_map(|p| p.to_array())).collect()
            }
            Self::HalfSpace => vec![7.0],
        }
    }
}

/// Why a primitive has no extent, or too much of it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrimitiveError {
    /// The minor radius of a torus is out of range.
    #[error("a torus needs a minor radius above 0 and at most 1, not {}", Number(*.minor))]
    Torus {
        /// The radius that was asked for.
        minor: f64,
    },
    /// The top radius of a frustum is out of range.
    #[error("a frustum needs a finite top radius above 0, not {}", Number(*.top))]
    Frustum {
        /// The radius that was asked for.
        top: f64,
    },
    /// The points of a hull span no solid.
    #[error(transparent)]
    Hull(#[from] HullError),
}

impl PrimitiveKind {
    /// How many numbers it takes, or `None` for a hull: three a point, as many points as one likes.
    pub fn arity(self) -> Option<usize> {
        match self {
            Self::Hull => None,
            Self::Torus | Self::Frustum => Some(1),
            _ => Some(0),
        }
    }

    /// The primitive for those arguments. Polyhedra become hulls.
    ///
    /// # Errors
    /// If the primitive would have no extent.
    ///
    /// # Panics
    /// If there are fewer arguments than [`arity`](Self::arity).
    pub fn evaluate(self, args: &[f64]) -> Result<Primitive, PrimitiveError> {
        let hull = |points: Vec<DVec3>| Ok(Primitive::Hull(Arc::new(Hull::new(points)?)));
        match self {
            Self::Sphere => Ok(Primitive::Sphere),
            Self::Cylinder => Ok(Primitive::Cylinder),
            Self::Cone => Ok(Primitive::Cone),
            Self::Cube => Ok(Primitive::Cube),
            Self::HalfSpace => Ok(Primitive::HalfSpace),
            Self::Frustum => {
                let top = args[0];
                let sound = top.is_finite() && top > 0.0;
                if sound { Ok(Primitive::Frustum { top }) } else { Err(PrimitiveError::Frustum { top }) }
            }
            Self::Torus => {
                let minor = args[0];
                let sound = minor > 0.0 && minor <= 1.0;
                if sound { Ok(Primitive::Torus { minor }) } else { Err(PrimitiveError::Torus { minor }) }
            }
            Self::Tetrahedron => hull(
                [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
                    .map(DVec3::from_array)
                    .to_vec(),
            ),
            Self::Octahedron => {
                hull([DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|v| [v, -v]).collect())
            }
            Self::Dodecahedron => hull(dodecahedron()),
            Self::Icosahedron => hull(icosahedron()),
            Self::Hull => hull(args.chunks_exact(3).map(DVec3::from_slice).collect()),
        }
    }
}

const GOLDEN: f64 = 1.618_033_988_749_895;

/// (0, ±1, ±φ) and its cyclic permutations, on the unit sphere.
fn icosahedron() -> Vec<DVec3> {
    golden_rectangles(1.0, GOLDEN)
}

/// The cube (±1, ±1, ±1) and (0, ±1/φ, ±φ) with its cyclic permutations, on the unit sphere.
fn dodecahedron() -> Vec<DVec3> {
    let signs = [-1.0, 1.0];
    let cube = signs.into_iter().flat_map(|x| {
        signs.into_iter().flat_map(move |y| signs.into_iter().map(move |z| DVec3::new(x, y, z).normalize()))
    });
    cube.chain(golden_rectangles(1.0 / GOLDEN, GOLDEN)).collect()
}

fn golden_rectangles(short: f64, long: f64) -> Vec<DVec3> {
    [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
        .into_iter()
        .map(|(a, b)| DVec3::new(0.0, a * short, b * long).normalize())
        .flat_map(|v| [v, DVec3::new(v.z, v.x, v.y), DVec3::new(v.y, v.z, v.x)])
        .collect()
}
