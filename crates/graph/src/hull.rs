//! Convex polytopes, by their points and by their faces.
//!
//! Every plane through three of the points that has all others on one side is a face. That is obviously right and, since
//! most planes are dismissed after a few points, cheap enough for the few points that a hull in a grammar has.
//!
//! Rounding is judged in *normalised* coordinates, in which the box of the points is the unit cube: a hull that is a
//! million times wider than high has the same faces as one that is not. Two planes are one face if the same points lie on
//! them.

use glam::DVec3;

/// The most points that a hull may have: the search for faces takes a fraction of a second at this size.
pub const HULL_POINTS: usize = 100;

/// How far from a plane, in normalised coordinates, a point may lie and still belong to that face.
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
        let faces = faces(&points).ok_or(HullError::Flat)?;
        Ok(Self { points, faces })
    }

    /// The points that were given; some may lie inside.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The memory that it takes, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self) + size_of_val(&*self.points) + size_of_val(&*self.faces)
    }

    /// The faces, one a plane.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }
}

/// The faces of the hull, or `None` if the points lie in a plane.
fn faces(points: &[DVec3]) -> Option<Vec<Face>> {
    let (low, high) =
        points.iter().fold((points[0], points[0]), |(low, high), p| (low.min(*p), high.max(*p)));
    let size = high - low;
    if size.min_element() <= 0.0 {
        return None;
    }
    let normalised: Vec<DVec3> = points.iter().map(|p| (*p - low) / size).collect();
    let mut faces: Vec<Face> = Vec::new();
    // For each face, which points lie on it, as bits.
    let mut known: Vec<u128> = Vec::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                let Some((normal, on)) = supporting_plane(&normalised, [i, j, k]) else { continue };
                if known.contains(&on) {
                    continue;
                }
                if on.count_ones() as usize == points.len() {
                    return None;
                }
                known.push(on);
                // Normals map with the inverse transposed of what maps points.
                let normal = (normal / size).normalize();
                let offset = points.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
                faces.push(Face { normal, offset });
            }
        }
    }
    (faces.len() >= 4).then_some(faces)
}

/// The outward normal of the plane through three points, and which points lie on it, if no point is beyond it.
fn supporting_plane(points: &[DVec3], corners: [usize; 3]) -> Option<(DVec3, u128)> {
    let [origin, a, b] = corners.map(|corner| points[corner]);
    let (a, b) = (a - origin, b - origin);
    let cross = a.cross(b);
    // Three points nearly on a line say nothing about a plane.
    if cross.length() <= FLATNESS * a.length() * b.length() {
        return None;
    }
    let normal = cross.normalize();
    // On which side of the plane the points are: that of the first one that is not on it.
    let mut side = 0.0;
    let mut on = 0;
    for (index, point) in points.iter().enumerate() {
        let height = normal.dot(*point - origin);
        if height.abs() <= FLATNESS {
            on |= 1 << index;
        } else if side * height < 0.0 {
            return None;
        } else {
            side = height.signum();
        }
    }
    Some((-side * normal, on))
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
    fn a_hull_that_is_flat_but_solid_keeps_all_its_faces() {
        // A roof of a million times its height.
        let roof = |x: f64, y: f64, z: f64| DVec3::new(x * 1e6, y * 1e6, z);
        let points: Vec<_> = [
            (-1.0, -1.0, 0.0),
            (1.0, -1.0, 0.0),
            (-1.0, 1.0, 0.0),
            (1.0, 1.0, 0.0),
            (0.0, -1.0, 0.4),
            (0.0, 1.0, 0.4),
        ]
        .map(|(x, y, z)| roof(x, y, z))
        .to_vec();
        let hull = Hull::new(points).unwrap();
        assert_eq!(hull.faces().len(), 5);
        let contains = |p: DVec3| hull.faces().iter().all(|face| face.normal.dot(p) <= face.offset);
        assert!(
            contains(roof(0.0, 0.0, 0.39))
                && !contains(roof(0.0, 0.0, 0.41))
                && !contains(roof(0.5, 0.0, 0.3))
        );
    }

    #[test]
    fn many_points_on_a_sphere_are_all_corners() {
        let points: Vec<_> = (0..HULL_POINTS)
            .map(|i| {
                let (t, z) = (i as f64 * 2.399_963, 1.0 - (2.0 * i as f64 + 1.0) / HULL_POINTS as f64);
                DVec3::new(libm::cos(t), libm::sin(t), 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
            })
            .collect();
        let hull = Hull::new(points.clone()).unwrap();
        // Euler: a polytope of triangles has twice as many faces as corners, less four.
        assert_eq!(hull.faces().len(), 2 * HULL_POINTS - 4);
        assert!(points.iter().all(|p| hull.faces().iter().all(|face| face.normal.dot(*p) <= face.offset)));
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
