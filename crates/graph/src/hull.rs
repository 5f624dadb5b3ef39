//! Convex polytopes, by their points and by their faces.
//!
//! Every plane through three of the points that has all others on one side is a face. That is cubic in the points times
//! their number, obviously right, and cheap for the few points that a hull in a grammar has.

use glam::DVec3;

/// The most points that a hull may have: the search for faces takes a fraction of a second at this size.
pub const HULL_POINTS: usize = 100;

/// How far from a plane, relative to the size of the hull, a point may lie and still belong to that face.
const FLATNESS: f64 = 1e-9;

/// The convex hull of points, with its faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    points: Vec<DVec3>,
    faces: Vec<Face>,
}

/// A face plane: the hull is where `normal · p ≤ offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Outward, of length 1.
    pub normal: DVec3,
    /// The largest `normal · p` over the points of the hull, so that no face cuts a point off.
    pub offset: f64,
}

/// Why points have no hull.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// Fewer than four points.
    #[error("a hull needs at least 4 points, not {count}")]
    TooFew {
        /// How many there are.
        count: usize,
    },
    /// More than [`HULL_POINTS`].
    #[error(
        "a hull may have at most {HULL_POINTS} points, not {count}; build it as a union or an intersection"
    )]
    TooMany {
        /// How many there are.
        count: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("point {index} of the hull is not finite")]
    NotFinite {
        /// The position of the point, from 1.
        index: usize,
    },
    /// All points lie in a plane.
    #[error("all points of the hull lie in one plane")]
    Flat,
}

impl Hull {
    /// The hull of `points`.
    ///
    /// # Errors
    /// If they are too few, too many, not finite, or in a plane.
    pub fn new(points: Vec<DVec3>) -> Result<Self, HullError> {
        let count = points.len();
        if count < 4 {
            return Err(HullError::TooFew { count });
        }
        if count > HULL_POINTS {
            return Err(HullError::TooMany { count });
        }
        if let Some(at) = points.iter().position(|p| !p.is_finite()) {
            return Err(HullError::NotFinite { index: at + 1 });
        }
        let faces = faces(&points);
        // A flat set has its own plane as a face from both sides.
        let flat = faces.iter().any(|a| {
            faces.iter().any(|b| {
                a.normal.dot(b.normal) < -1.0 + FLATNESS && a.offset + b.offset <= FLATNESS * extent(&points)
            })
        });
        if faces.len() < 4 || flat {
            return Err(HullError::Flat);
        }
        Ok(Self { points, faces })
    }

    /// The points that were given; some may lie inside.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The faces, one a plane.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }
}

/// The largest distance from the first point.
fn extent(points: &[DVec3]) -> f64 {
    points.iter().map(|p| p.distance(points[0])).fold(0.0, f64::max)
}

fn faces(points: &[DVec3]) -> Vec<Face> {
    let tolerance = FLATNESS * extent(points);
    let mut faces: Vec<Face> = Vec::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                let (a, b) = (points[j] - points[i], points[k] - points[i]);
                let cross = a.cross(b);
                // Three points nearly on a line say nothing about a plane.
                if cross.length() <= FLATNESS * a.length() * b.length() {
                    continue;
                }
                for normal in [cross.normalize(), -cross.normalize()] {
                    let plane = normal.dot(points[i]);
                    let offset = points.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
                    let known = |face: &Face| face.normal.distance(normal) < 1e-6;
                    if offset <= plane + tolerance && !faces.iter().any(known) {
                        faces.push(Face { normal, offset });
                    }
                }
            }
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> Vec<DVec3> {
        (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))).collect()
    }

    #[test]
    fn a_box_has_six_faces_even_with_points_inside_it() {
        let mut points = corners();
        points.push(DVec3::splat(0.5));
        let hull = Hull::new(points).unwrap();
        assert_eq!(hull.faces().len(), 6);
        for point in hull.points() {
            assert!(hull.faces().iter().all(|face| face.normal.dot(*point) <= face.offset));
        }
    }

    #[test]
    fn what_spans_no_solid_is_refused() {
        let flat: Vec<_> = corners().into_iter().filter(|p| p.z == 0.0).collect();
        assert_eq!(Hull::new(flat), Err(HullError::Flat));
        assert_eq!(Hull::new(vec![DVec3::ZERO; 4]), Err(HullError::Flat));
        let line = (0..5).map(|i| DVec3::splat(f64::from(i))).collect();
        assert_eq!(Hull::new(line), Err(HullError::Flat));
        assert_eq!(Hull::new(corners()[..3].to_vec()), Err(HullError::TooFew { count: 3 }));
        let mut wild = corners();
        wild[2].y = f64::INFINITY;
        assert_eq!(Hull::new(wild), Err(HullError::NotFinite { index: 3 }));
    }
}
