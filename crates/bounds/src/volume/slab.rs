//! Slab volumes: what is between pairs of parallel planes, in directions that are fixed once for all solids ([KAY86] §2;
//! also called k-DOPs, discrete oriented polytopes with k planes).
//!
//! The directions are small integer vectors and are *not* normalised. A plane is then d·x = m with m the support
//! itself, and no arithmetic stands between the supports and the volume: it is as exact as they are. The slabs of a
//! cube with integer corners are exactly the cube.
//!
//! ## Changes versus the paper
//! Kay and Kajiya use seven directions, the axes and the diagonals of the cube. Here the number of pairs is a constant
//! of the type, with the usual sets to choose from; the axes always come first.

use glam::DVec3;

use super::Volume;
use super::support::{ask, dot_down, dot_up};
use crate::Aabb;

/// The normals of the cube's faces, then the directions of its corners and of the middles of its edges, one of each
/// opposite pair.
const TABLE: [DVec3; 13] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, 1.0),
    DVec3::new(0.0, 1.0, 1.0),
    DVec3::new(1.0, 0.0, 1.0),
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(0.0, 1.0, -1.0),
    DVec3::new(-1.0, 0.0, 1.0),
    DVec3::new(1.0, -1.0, 0.0),
];

const FACES: usize = 3;
const CORNERS: usize = 4;

/// The set of `N` directions. Fails to compile for an N that has none.
const fn directions<const N: usize>() -> [DVec3; N] {
    let skipped = match N {
        3 | 7 | 13 => 0,
        9 => CORNERS,
        _ => panic!("slabs come in 3, 7, 9 or 13 directions"),
    };
    let mut set = [DVec3::ZERO; N];
    let mut i = 0;
    while i < N {
        set[i] = TABLE[if i < FACES { i } else { i + skipped }];
        i += 1;
    }
    set
}

/// What is between `N` pairs of parallel planes: all points p with `min[i]` ≤ dᵢ·p ≤ `max[i]` for the `N`
/// [`DIRECTIONS`](Self::DIRECTIONS) dᵢ.
///
/// | N | planes | directions |
/// |---|---|---|
/// | 3 | 6 | the axes: an axis-aligned box |
/// | 7 | 14 | and the diagonals of the cube |
/// | 9 | 18 | the axes and the diagonals of the cube's faces |
/// | 13 | 26 | all of these |
///
/// Made of 2 N supports. It lies in the axis-aligned box of the same supports; for N = 13 and a ball it has 1.14 times
/// the ball's volume, where the box has 1.91 times.
///
/// ```
/// use csg_graph_bounds::{PointSet, Slabs, Volume};
///
/// let corners = Slabs::<7>::from_point_set(&PointSet::cube());
/// assert_eq!(corners.max, [1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 3.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slabs<const N: usize> {
    /// The least dᵢ·p.
    pub min: [f64; N],
    /// The greatest dᵢ·p.
    pub max: [f64; N],
}

impl<const N: usize> Slabs<N> {
    /// The normals of the planes, not normalised. The first three are the axes.
    pub const DIRECTIONS: [DVec3; N] = directions();

    /// Slabs that enclose both: the least ones, if the two are made from the exact supports of their solids.
    #[must_use]
    pub fn join(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|i| self.min[i].min(other.min[i])),
            max: std::array::from_fn(|i| self.max[i].max(other.max[i])),
        }
    }

    /// What is in both.
    ///
    /// It is [`EMPTY`](Volume::EMPTY) if a pair of planes shows that nothing is. What no single pair shows is not found
    /// out; planes may also be left without touching what is between the others.
    #[must_use]
    pub fn intersect(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|i| self.min[i].max(other.min[i])),
            max: std::array::from_fn(|i| self.max[i].min(other.max[i])),
        }
        .canonical()
    }

    /// The empty volume in its one form, if a pair of planes says that it is empty.
    fn canonical(self) -> Self {
        let nowhere = |min: f64, max: f64| min > max || min == f64::INFINITY || max == f64::NEG_INFINITY;
        let empty = self.min.iter().zip(&self.max).any(|(min, max)| nowhere(*min, *max));
        if empty { Self::EMPTY } else { self }
    }

    /// The areas of the two faces between each pair of planes, together, in the order of the
    /// [`DIRECTIONS`](Self::DIRECTIONS), calculated in O(N²). If an axis has no end, those of the [box](Volume::aabb).
    ///
    /// Half of their sum, each by the cosine of the angle at which it is seen, is what the volume covers of a plane behind
    /// it: seen from far away along a unit vector u, ½ Σ areaᵢ · |dᵢ·u| / |dᵢ|.
    ///
    /// ```
    /// use csg_graph_bounds::Slabs;
    ///
    /// // All corners of the cube are cut off at once, where a diagonal is 1 instead of 3 on both sides.
    /// let octahedron = Slabs::<7> { min: [-1.0; 7], max: [1.0; 7] };
    /// let [x, .., last] = octahedron.face_areas();
    /// assert_eq!(x, 0.0);
    /// assert!((last - 3.0_f64.sqrt()).abs() < 1e-12);
    /// ```
    pub fn face_areas(&self) -> [f64; N] {
        let mut areas = [0.0; N];
        if let Some((unit, faces)) = self.faces() {
            faces.iter().for_each(|face| areas[face.pair] += face.area * unit * unit);
        } else if !self.is_empty() {
            let size = self.aabb().size();
            let of_box = [size.y * size.z, size.z * size.x, size.x * size.y];
            areas.iter_mut().zip(of_box).for_each(|(area, of_box)| *area = 2.0 * of_box);
        }
        areas
    }

    /// Surface area and volume, which is that of the pyramids over the faces.
    fn measures(&self) -> [f64; 2] {
        let bounds = self.aabb();
        let Some((unit, faces)) = self.faces() else { return [bounds.surface_area(), bounds.volume()] };
        let area: f64 = faces.iter().map(|face| face.area).sum();
        let volume: f64 = faces.iter().map(|face| face.area * face.offset / 3.0).sum();
        [area * unit * unit, (volume * unit * unit * unit).clamp(0.0, bounds.volume())]
    }

    /// A unit of length, and all faces in it: each is a square cut to size by all other planes. None where an axis has no end,
    /// or there is nothing beyond a point: then the axis-aligned box says it all.
    ///
    /// Calculated about the middle of that box and in halves of its largest extent, so that nothing overflows or cancels that
    /// need not.
    fn faces(&self) -> Option<(f64, Vec<Face>)> {
        let bounds = self.aabb();
        let unit = bounds.size().max_element() * 0.5;
        if bounds.is_empty() || !unit.is_finite() || unit == 0.0 {
            return None;
        }
        let center = bounds.center();
        let planes =
            (0..N).flat_map(|i| [(i, 1.0, self.max[i]), (i, -1.0, -self.min[i])]).map(|(i, sign, m)| {
                let direction = sign * Self::DIRECTIONS[i];
                let length = direction.length();
                (i, direction / length, (m - direction.dot(center)) / (length * unit))
            });
        let planes: Vec<(usize, DVec3, f64)> = planes.filter(|(.., offset)| offset.is_finite()).collect();
        let face = |&(pair, normal, offset): &(usize, DVec3, f64)| {
            // The box reaches no further than √3 from its middle, so neither does the face from the plane's nearest
            // point to it.
            let (u, v) = normal.any_orthonormal_pair();
            let foot = offset * normal;
            let mut face: Vec<DVec3> = [u + v, v - u, -u - v, u - v].map(|corner| foot + 2.0 * corner).into();
            for &(_, normal, offset) in planes.iter().filter(|(j, ..)| *j != pair) {
                face = clip(&face, normal, offset);
            }
            let doubled: DVec3 = face.windows(2).map(|edge| (edge[0] - foot).cross(edge[1] - foot)).sum();
            let closing = match (face.last(), face.first()) {
                (Some(last), Some(first)) => (*last - foot).cross(*first - foot),
                _ => DVec3::ZERO,
            };
            Face { pair, offset, area: 0.5 * (doubled + closing).dot(normal).abs() }
        };
        Some((unit, planes.iter().map(face).collect()))
    }
}

/// What of a plane bounds the volume.
struct Face {
    /// The index of its direction.
    pair: usize,
    /// How far the plane is from the middle, outwards.
    offset: f64,
    area: f64,
}

/// The part of a convex polygon with normal·x ≤ offset.
fn clip(polygon: &[DVec3], normal: DVec3, offset: f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &end) in polygon.iter().enumerate() {
        let start = polygon[if i == 0 { polygon.len() - 1 } else { i - 1 }];
        let [before, after] = [start, end].map(|point| normal.dot(point) - offset);
        if (before > 0.0) != (after > 0.0) {
            kept.push(start.lerp(end, before / (before - after)));
        }
        if after <= 0.0 {
            kept.push(end);
        }
    }
    kept
}

impl<const N: usize> Volume for Slabs<N> {
    const EMPTY: Self = Self { min: [f64::INFINITY; N], max: [f64::NEG_INFINITY; N] };
    const ALL: Self = Self { min: [f64::NEG_INFINITY; N], max: [f64::INFINITY; N] };

    /// 2 N queries. Each pair of planes may be without end on either side.
    fn from_support(mut support: impl FnMut(DVec3) -> f64) -> Self {
        let max = Self::DIRECTIONS.map(|direction| ask(&mut support, direction));
        let min = Self::DIRECTIONS.map(|direction| -ask(&mut support, -direction));
        // A solid with a point has a support of at least −h(−d) in direction d, so planes out of order enclose nothing.
        Self { min, max }.canonical()
    }

    fn contains(&self, point: DVec3) -> bool {
        (0..N).all(|i| {
            let direction = Self::DIRECTIONS[i];
            self.min[i] <= dot_up(direction, point) && dot_down(direction, point) <= self.max[i]
        }) && point.is_finite()
    }

    fn is_empty(&self) -> bool {
        self.min[0] > self.max[0]
    }

    /// The planes of the axes.
    fn aabb(&self) -> Aabb {
        let [x, y, z] = [0, 1, 2];
        Aabb {
            min: DVec3::new(self.min[x], self.min[y], self.min[z]),
            max: DVec3::new(self.max[x], self.max[y], self.max[z]),
        }
    }

    /// That of the polytope, calculated in O(N²). If an axis has no end, that of the [box](Self::aabb).
    fn volume(&self) -> f64 {
        self.measures()[1]
    }

    /// That of the polytope, calculated in O(N²). If an axis has no end, that of the [box](Self::aabb).
    fn surface_area(&self) -> f64 {
        self.measures()[0]
    }
}
