//! What every volume here is made from: supports of the solid, and products that are rounded to the safe side.
//!
//! The *support* of a solid in direction d is the largest d·x over its points x. Whatever is at least that, for some
//! directions, says in which half-spaces the solid is; a volume is made of such half-spaces and of nothing else, so one
//! function from directions to numbers is all that the volumes ask for.
//!
//! **Directed rounding.** A product d·x loses something in each of its three products and two sums. Each loss is itself
//! a number: of a product by fused multiplication, of a sum by Knuth's two-sum. If all are zero, the product is exact
//! and is returned as it is, so that small integers give volumes without any padding. Otherwise the losses are added
//! back, with a margin for the rounding of *their* sum (at most 5 half ulps of the sum of their sizes, for which we take
//! 8 ε), and the result goes to the next number up.

use glam::DVec3;

use crate::PointSet;

/// Products below this lose digits to underflow, which fused multiplication does not see.
const UNDERFLOWING: f64 = 1e-290;

/// a·b, rounded up: the exact value if `f64` holds it, and never less. Infinite if it overflows or is not a number.
pub(super) fn dot_up(a: DVec3, b: DVec3) -> f64 {
    let (mut sum, mut lost, mut size_of_lost) = (0.0, 0.0, 0.0);
    for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
        let product = a * b;
        let (next, carry) = two_sum(sum, product);
        for loss in [libm::fma(a, b, -product), carry] {
            lost += loss;
            size_of_lost += loss.abs();
        }
        if product.abs() < UNDERFLOWING && a != 0.0 && b != 0.0 {
            size_of_lost += f64::MIN_POSITIVE;
        }
        sum = next;
    }
    if size_of_lost == 0.0 {
        return sum;
    }
    let above = (sum + (lost + 8.0 * f64::EPSILON * size_of_lost)).next_up();
    if sum.is_finite() && !above.is_nan() { above } else { f64::INFINITY }
}

/// a·b, rounded down: the exact value if `f64` holds it, and never more. −∞ if it overflows or is not a number.
pub(super) fn dot_down(a: DVec3, b: DVec3) -> f64 {
    -dot_up(-a, b)
}

/// The rounded sum, and what it lost.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_in_sum = sum - a;
    (sum, (a - (sum - b_in_sum)) + (b - b_in_sum))
}

/// Asks for a support. What is not a number is no bound.
pub(super) fn ask(support: &mut impl FnMut(DVec3) -> f64, direction: DVec3) -> f64 {
    let found = support(direction);
    if found.is_nan() { f64::INFINITY } else { found }
}

impl PointSet<'_> {
    /// The support of the hull of the points, rounded up: at least the largest d·x over the points x, and equal to it
    /// where `f64` holds it. Infinite if the set is unbounded or has a point that is not finite; −∞ if it has no points.
    ///
    /// ```
    /// use csg_graph_bounds::PointSet;
    /// use glam::DVec3;
    ///
    /// assert_eq!(PointSet::cube().support(DVec3::new(1.0, -1.0, 1.0)), 3.0);
    /// ```
    pub fn support(&self, direction: DVec3) -> f64 {
        let Self::Points(points) = self else { return f64::INFINITY };
        let (most, size) = points.iter().fold((f64::NEG_INFINITY, 0.0_f64), |(most, size), point| {
            (most.max(direction.dot(*point)), size.max(direction.abs().dot(point.abs())))
        });
        // Only points that may be the farthest are worth the careful product, and points that are no numbers.
        let beaten = most - (8.0 * f64::EPSILON * size + f64::MIN_POSITIVE);
        let candidates = points.iter().filter(|point| {
            let found = direction.dot(**point);
            found.is_nan() || found >= beaten || beaten.is_nan()
        });
        candidates.map(|point| dot_up(direction, *point)).fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exactness is the point")]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vectors(sizes: std::ops::Range<i32>) -> impl Strategy<Value = DVec3> {
        let coordinate = (-1.0..1.0, sizes).prop_map(|(mantissa, exponent)| libm::ldexp(mantissa, exponent));
        [coordinate.clone(), coordinate.clone(), coordinate].prop_map(DVec3::from_array)
    }

    /// v·2¹⁰⁶, for multiples of 2⁻¹⁰⁶ below 2²⁰.
    fn scaled(v: f64) -> i128 {
        let scaled = libm::ldexp(v, 106);
        assert_eq!(scaled, libm::floor(scaled));
        #[expect(clippy::cast_possible_truncation, reason = "below 2¹²⁶")]
        let integer = scaled as i128;
        integer
    }

    proptest! {
        #[test]
        fn rounding_goes_to_its_side(a in vectors(0..1), b in vectors(-3..3)) {
            // Multiples of 2⁻⁵³, so that products are multiples of 2⁻¹⁰⁶.
            let grid = |v: f64| libm::ldexp(libm::round(libm::ldexp(v, 53)), -53);
            let [a, b] = [a, b].map(|v| DVec3::from_array(v.to_array().map(grid)));
            let product: i128 = (0..3).map(|i| (scaled(a[i]) >> 53) * (scaled(b[i]) >> 53)).sum();
            let (down, up) = (dot_down(a, b), dot_up(a, b));
            let below = libm::floor(libm::ldexp(down, 106));
            let above = libm::ceil(libm::ldexp(up, 106));
            prop_assert!(scaled(libm::ldexp(below, -106)) <= product);
            prop_assert!(scaled(libm::ldexp(above, -106)) >= product);
            prop_assert!(up - down <= 2.0 * f64::EPSILON * (up.abs() + f64::EPSILON));
        }

        #[test]
        fn integers_are_exact(a in prop::array::uniform3(-9_i32..9), b in prop::array::uniform3(-999_i32..999)) {
            let vector = |v: [i32; 3]| DVec3::from_array(v.map(f64::from));
            let product: i32 = (0..3).map(|i| a[i] * b[i]).sum();
            prop_assert_eq!(dot_up(vector(a), vector(b)), f64::from(product));
            prop_assert_eq!(dot_down(vector(a), vector(b)), f64::from(product));
        }

        #[test]
        fn any_size_is_ordered(a in vectors(-1074..1024), b in vectors(-1074..1024)) {
            prop_assert!(dot_down(a, b) <= dot_up(a, b));
        }
    }

    #[test]
    fn extremes() {
        assert!(dot_up(DVec3::splat(1e-200), DVec3::splat(1e-200)) > 0.0);
        assert!(dot_down(DVec3::splat(1e-200), DVec3::splat(1e-200)) <= 0.0);
        assert_eq!(dot_up(DVec3::splat(1e200), DVec3::splat(1e200)), f64::INFINITY);
        assert_eq!(dot_up(DVec3::splat(1e200), DVec3::splat(-1e200)), f64::INFINITY);
        assert_eq!(dot_up(DVec3::NAN, DVec3::ONE), f64::INFINITY);
        assert_eq!(dot_up(DVec3::INFINITY, DVec3::X), f64::INFINITY);
    }

    #[test]
    fn supports_of_points() {
        assert_eq!(PointSet::EMPTY.support(DVec3::X), f64::NEG_INFINITY);
        assert_eq!(PointSet::Unbounded.support(DVec3::X), f64::INFINITY);
        for broken in [DVec3::NAN, DVec3::new(0.0, f64::INFINITY, 0.0), DVec3::new(f64::NAN, 0.0, 0.0)] {
            let set = PointSet::from(vec![DVec3::ONE, broken]);
            assert_eq!(set.support(DVec3::ONE), f64::INFINITY);
        }
    }
}
