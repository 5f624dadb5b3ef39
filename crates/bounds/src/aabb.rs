//! Axis-aligned boxes, with one canonical empty box and one for the whole space.

use glam::{DAffine3, DVec3};

use crate::rounding::{EVALUATION, LARGEST};
use crate::scene::Map;

/// A closed axis-aligned box: all points p with `min` ≤ p ≤ `max`.
///
/// The *empty* box has one form, [`EMPTY`](Self::EMPTY), so that it can be compared and joined like any other; every
/// operation here keeps that form. What has no finite box has the whole space, [`ALL`](Self::ALL).
///
/// ```
/// use csg_graph_bounds::Aabb;
/// use glam::DVec3;
///
/// let unit = Aabb::new(DVec3::ZERO, DVec3::ONE);
/// let far = Aabb::new(DVec3::splat(3.0), DVec3::splat(4.0));
/// assert_eq!(unit.join(far), Aabb::new(DVec3::ZERO, DVec3::splat(4.0)));
/// assert_eq!(unit.intersect(far), Aabb::EMPTY);
/// assert_eq!(unit.join(Aabb::EMPTY), unit);
/// assert_eq!(unit.intersect(Aabb::ALL), unit);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The least coordinates.
    pub min: DVec3,
    /// The greatest coordinates.
    pub max: DVec3,
}

impl Aabb {
    /// No point at all.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The whole space.
    pub const ALL: Self = Self { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

    /// The box from `min` to `max`, or [`EMPTY`](Self::EMPTY) where they are not in order.
    pub fn new(min: DVec3, max: DVec3) -> Self {
        if min.cmple(max).all() { Self { min, max } } else { Self::EMPTY }
    }

    /// The least box that holds `points`, all of them finite.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| Self {
            min: bounds.min.min(point),
            max: bounds.max.max(point),
        })
    }

    /// Whether no point is in it.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Whether it ends in all directions. The empty box does.
    pub fn is_bounded(&self) -> bool {
        self.is_empty() || self.min.is_finite() && self.max.is_finite()
    }

    /// Whether `point` is in it.
    pub fn contains(&self, point: DVec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// Whether all of `other` is in it. The empty box is in every box.
    pub fn encloses(&self, other: Self) -> bool {
        other.is_empty() || self.contains(other.min) && self.contains(other.max)
    }

    /// The least box that encloses both.
    #[must_use]
    pub fn join(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// What is in both.
    #[must_use]
    pub fn intersect(self, other: Self) -> Self {
        Self::new(self.min.max(other.min), self.max.min(other.max))
    }

    /// The extent along each axis: zero if it is empty, infinite where it does not end.
    pub fn size(&self) -> DVec3 {
        if self.is_empty() { DVec3::ZERO } else { self.max - self.min }
    }

    /// The point in the middle, or the origin if there is none because the box is empty or does not end.
    pub fn center(&self) -> DVec3 {
        let bounded = self.is_bounded() && !self.is_empty();
        if bounded { self.min * 0.5 + self.max * 0.5 } else { DVec3::ZERO }
    }

    /// The volume. A flat box has none, also where it does not end.
    pub fn volume(&self) -> f64 {
        let size = self.size();
        if size.min_element() > 0.0 { size.element_product() } else { 0.0 }
    }

    /// The area of its surface; a flat box has two sides.
    pub fn surface_area(&self) -> f64 {
        let size = self.size();
        // 0 · ∞ is the area of a segment or line, which is nothing.
        let face = |a: f64, b: f64| if a > 0.0 && b > 0.0 { a * b } else { 0.0 };
        2.0 * (face(size.x, size.y) + face(size.y, size.z) + face(size.z, size.x))
    }

    /// The support: the largest d·x over its points x, infinite where it does not end, and −∞ if it is empty.
    pub fn support(&self, direction: DVec3) -> f64 {
        if self.is_empty() { f64::NEG_INFINITY } else { self.furthest(direction).dot(direction) }
    }

    /// A corner in a direction, with 0 for coordinates across it: 0 · ∞ is no extent at all.
    fn furthest(&self, direction: DVec3) -> DVec3 {
        let along = |d: f64, min: f64, max: f64| {
            if d > 0.0 {
                max
            } else if d < 0.0 {
                min
            } else {
                0.0
            }
        };
        let (d, Self { min, max }) = (direction, self);
        DVec3::new(along(d.x, min.x, max.x), along(d.y, min.y, max.y), along(d.z, min.z, max.z))
    }

    /// The box in numbers of single precision, rounded outward, so that it encloses this one: `[min, max]`.
    ///
    /// What is beyond their range is infinite; the empty box stays empty.
    ///
    /// ```
    /// use csg_graph_bounds::Aabb;
    /// use glam::DVec3;
    ///
    /// let [min, max] = Aabb::new(DVec3::splat(0.1), DVec3::splat(0.5)).to_f32_outward();
    /// assert!(f64::from(min[0]) < 0.1 && f64::from(min[0].next_up()) > 0.1);
    /// assert_eq!(max, [0.5; 3]);
    /// ```
    pub fn to_f32_outward(self) -> [[f32; 3]; 2] {
        if self.is_empty() {
            return [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        }
        [self.min.to_array().map(|coordinate| -round_up(-coordinate)), self.max.to_array().map(round_up)]
    }

    /// Its corners.
    pub fn corners(&self) -> [DVec3; 8] {
        let pick = |upper: bool, min: f64, max: f64| if upper { max } else { min };
        std::array::from_fn(|corner| {
            DVec3::new(
                pick(corner & 1 != 0, self.min.x, self.max.x),
                pick(corner & 2 != 0, self.min.y, self.max.y),
                pick(corner & 4 != 0, self.min.z, self.max.z),
            )
        })
    }

    /// A box that encloses the image of this one, and is the least one up to rounding, which goes outward by what
    /// evaluating the map may err. The image of the empty box is empty. Where coordinates may overflow, or the box has
    /// no end, neither has the image.
    #[must_use]
    pub fn image<M: Map>(&self, map: &M) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let DAffine3 { matrix3, translation: t } = map.affine();
        let rows = matrix3.transpose();
        let faces = |sign: f64| {
            let face = |row: DVec3, offset: f64| self.support_above(sign * row, sign * offset);
            DVec3::new(face(rows.x_axis, t.x), face(rows.y_axis, t.y), face(rows.z_axis, t.z))
        };
        Self { min: DVec3::ZERO - faces(-1.0), max: faces(1.0) }
    }

    /// The largest d·x + offset over the points x of the box, rounded up. Infinite if coordinates may overflow.
    pub(crate) fn support_above(&self, direction: DVec3, offset: f64) -> f64 {
        let corner = self.furthest(direction);
        let terms = corner * direction;
        let magnitude = terms.abs().element_sum() + offset.abs();
        if magnitude < LARGEST {
            let lost = terms.abs().cmplt(DVec3::splat(f64::MIN_POSITIVE)) & corner.cmpne(DVec3::ZERO);
            let underflow = if lost.any() { f64::MIN_POSITIVE } else { 0.0 };
            terms.element_sum() + offset + EVALUATION * magnitude + underflow
        } else {
            f64::INFINITY
        }
    }

    /// The largest coordinate in absolute value; 0 if it is empty.
    pub(crate) fn magnitude(&self) -> f64 {
        if self.is_empty() { 0.0 } else { self.min.abs().max(self.max.abs()).max_element() }
    }

    /// The box with `margin` added on every side; the whole space if the margin is not finite.
    pub(crate) fn grown(self, margin: f64) -> Self {
        if !margin.is_finite() {
            return Self::ALL;
        }
        Self { min: self.min - margin, max: self.max + margin }
    }
}

/// The least number of single precision that is not below.
#[expect(clippy::cast_possible_truncation, reason = "what the rounding takes away is given back")]
fn round_up(number: f64) -> f32 {
    let nearest = number as f32;
    if f64::from(nearest) < number { nearest.next_up() } else { nearest }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "the numbers are small integers")]
mod tests {
    use glam::DAffine3;
    use proptest::prelude::*;

    use super::*;

    fn boxes() -> impl Strategy<Value = Aabb> {
        let coordinate = || -4_i32..=4;
        let point = move || {
            (coordinate(), coordinate(), coordinate())
                .prop_map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into()))
        };
        prop_oneof![
            1 => Just(Aabb::EMPTY),
            1 => Just(Aabb::ALL),
            8 => (point(), point()).prop_map(|(a, b)| Aabb::new(a.min(b), a.max(b))),
        ]
    }

    proptest! {
        #[test]
        fn join_and_intersect_are_a_lattice(a in boxes(), b in boxes(), c in boxes()) {
            prop_assert_eq!(a.join(b), b.join(a));
            prop_assert_eq!(a.intersect(b), b.intersect(a));
            prop_assert_eq!(a.join(b).join(c), a.join(b.join(c)));
            prop_assert_eq!(a.intersect(b).intersect(c), a.intersect(b.intersect(c)));
            prop_assert_eq!(a.join(a.intersect(b)), a);
            prop_assert_eq!(a.intersect(a.join(b)), a);
            prop_assert!(a.join(b).encloses(a));
            prop_assert!(a.encloses(a.intersect(b)));
            prop_assert_eq!(a.encloses(b), a.join(b) == a);
        }

        #[test]
        fn the_empty_box_has_one_form(a in boxes(), b in boxes()) {
            for found in [a.join(b), a.intersect(b), a.image(&DAffine3::IDENTITY)] {
                prop_assert_eq!(found.is_empty(), found == Aabb::EMPTY);
            }
        }

        #[test]
        fn measures_are_numbers(a in boxes()) {
            for number in [a.volume(), a.surface_area(), a.center().length(), a.size().length()] {
                prop_assert!(number >= 0.0);
            }
        }
    }

    #[test]
    fn measures() {
        let slab = Aabb::new(DVec3::ZERO, DVec3::new(2.0, 3.0, 4.0));
        assert_eq!(slab.volume(), 24.0);
        assert_eq!(slab.surface_area(), 52.0);
        assert_eq!(slab.center(), DVec3::new(1.0, 1.5, 2.0));
        assert_eq!(Aabb::EMPTY.volume(), 0.0);
        assert_eq!(Aabb::EMPTY.surface_area(), 0.0);
        assert_eq!(Aabb::EMPTY.size(), DVec3::ZERO);
        assert_eq!(Aabb::ALL.volume(), f64::INFINITY);
        assert_eq!(Aabb::ALL.surface_area(), f64::INFINITY);
        let flat = Aabb::new(DVec3::new(f64::NEG_INFINITY, 0.0, 0.0), DVec3::new(f64::INFINITY, 0.0, 1.0));
        assert_eq!(flat.volume(), 0.0);
        assert_eq!(flat.surface_area(), f64::INFINITY);
    }

    #[test]
    fn images_of_what_has_no_finite_box() {
        let shear = DAffine3::from_cols(DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Z, DVec3::ONE);
        assert_eq!(Aabb::EMPTY.image(&shear), Aabb::EMPTY);
        assert_eq!(Aabb::ALL.image(&shear), Aabb::ALL);
        let half = Aabb::new(DVec3::NEG_INFINITY, DVec3::ZERO);
        let below = half.image(&shear);
        assert_eq!(below.min, DVec3::NEG_INFINITY);
        assert!((below.max - DVec3::ONE).abs().max_element() < 1e-14);
        let beyond = DAffine3::from_scale(DVec3::splat(1e200));
        let large = Aabb::new(DVec3::splat(-1e200), DVec3::splat(1e200));
        assert_eq!(large.image(&beyond), Aabb::ALL);
        let broken = DAffine3::from_translation(DVec3::NAN);
        assert_eq!(large.image(&broken), Aabb::ALL);
    }

    #[test]
    fn supports() {
        let slab = Aabb::new(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 3.0, 4.0));
        assert_eq!(slab.support(DVec3::new(2.0, -1.0, -0.5)), 2.0 - 1.0);
        assert_eq!(slab.support(DVec3::ZERO), 0.0);
        let half = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY.with_z(0.5) };
        assert_eq!(half.support(2.0 * DVec3::Z), 1.0);
        assert_eq!(half.support(DVec3::NEG_Z), f64::INFINITY);
        assert_eq!(half.support(DVec3::new(1e-9, 0.0, 1.0)), f64::INFINITY);
        assert_eq!(Aabb::EMPTY.support(DVec3::ONE), f64::NEG_INFINITY);
    }

    #[test]
    fn single_precision_is_rounded_outward() {
        let numbers = [0.1, -0.1, 1e-60, -1e-60, 1e60, -1e60, 16_777_217.0, 0.5];
        for min in numbers {
            for max in numbers.into_iter().filter(|max| *max >= min) {
                let [lower, upper] = Aabb::new(DVec3::splat(min), DVec3::splat(max)).to_f32_outward();
                assert!(f64::from(lower[0]) <= min && f64::from(upper[2]) >= max, "{lower:?} {upper:?}");
                assert!(f64::from(lower[0].next_up()) > min && f64::from(upper[2].next_down()) < max);
            }
        }
        assert_eq!(Aabb::EMPTY.to_f32_outward(), [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]]);
        assert_eq!(Aabb::ALL.to_f32_outward(), [[f32::NEG_INFINITY; 3], [f32::INFINITY; 3]]);
    }

    #[test]
    fn out_of_order_or_not_a_number_is_empty() {
        assert_eq!(Aabb::new(DVec3::ONE, DVec3::ZERO), Aabb::EMPTY);
        assert_eq!(Aabb::new(DVec3::NAN, DVec3::ZERO), Aabb::EMPTY);
        assert_eq!(Aabb::from_points([]), Aabb::EMPTY);
    }
}
