//! Maps under which boxes stay boxes.
//!
//! Where each coordinate of an image depends on one coordinate alone, as under translations, scales, flips and turns by
//! right angles, the box of an image comes of the box of the solid: an interval times an interval plus an interval, three
//! times. Envelopes have 26 planes and a radius, and none of the others is asked for then. Of a terrain, where heights vary
//! and nothing turns, that is so all the way down.

use csg_graph::Interval;

use crate::Aabb;

/// The linear part of such maps: where each coordinate comes from, and by which factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Straight {
    from: [usize; 3],
    factors: [Interval; 3],
}

impl Straight {
    pub(super) const IDENTITY: Self = Self::scaled([Interval::point(1.0); 3]);

    /// Factors along the axes.
    pub(super) const fn scaled(factors: [Interval; 3]) -> Self {
        Self { from: [0, 1, 2], factors }
    }

    /// Matrices with entries in these intervals, by rows. `None` if a coordinate may come from more than one.
    pub(super) fn new(rows: [[Interval; 3]; 3]) -> Option<Self> {
        let mut straight = Self::IDENTITY;
        for (axis, row) in rows.iter().enumerate() {
            let mut entries = (0..3).filter(|column| row[*column].value() != Some(0.0));
            let from = entries.next().unwrap_or(axis);
            if entries.next().is_some() {
                return None;
            }
            straight.from[axis] = from;
            straight.factors[axis] = row[from];
        }
        Some(straight)
    }

    /// A box about the images of what is in another, moved by an offset.
    pub(super) fn image(&self, offset: &[Interval; 3], below: &Aabb) -> Aabb {
        if below.is_empty() {
            return Aabb::EMPTY;
        }
        let mut image = Aabb::ALL;
        for (axis, offset) in offset.iter().enumerate() {
            let from = self.from[axis];
            let [min, max] = scaled(self.factors[axis], [below.min[from], below.max[from]]);
            // What has no end on one side may be moved without end to the other.
            image.min[axis] = f64::NEG_INFINITY.max(lower(min + offset.min));
            image.max[axis] = -f64::NEG_INFINITY.max(lower(-max - offset.max));
        }
        image
    }
}

/// All products with numbers from `min` to `max`, and some ulps more.
fn scaled(factor: Interval, [min, max]: [f64; 2]) -> [f64; 2] {
    if factor == Interval::point(1.0) {
        return [min, max];
    }
    if factor.min > 0.0 && factor.min >= factor.max {
        return [lower(factor.min * min), -lower(-factor.min * max)];
    }
    // 0 times whatever has no end is 0.
    let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
    let [a, b] = [product(factor.min, min), product(factor.min, max)];
    let [c, d] = [product(factor.max, min), product(factor.max, max)];
    [lower(a.min(b).min(c.min(d))), -lower(-a.max(b).max(c.max(d)))]
}

/// Less than any number that is rounded to `x`.
fn lower(x: f64) -> f64 {
    x - (x.abs() * f64::EPSILON + f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use csg_graph::TransformKind;
    use glam::DVec3;
    use proptest::prelude::*;

    use super::super::body::Body;
    use super::super::transform::{Chain, MapRange};
    use super::*;
    use crate::Volume;

    fn interval() -> impl Strategy<Value = Interval> {
        let end = prop_oneof![Just(0.0), Just(1.0), -3.0..3.0];
        (end.clone(), end).prop_map(|(a, b): (f64, f64)| Interval::new(a.min(b), a.max(b)))
    }

    fn straight_map() -> impl Strategy<Value = MapRange> {
        let three = || [interval(), interval(), interval()];
        let flip = prop_oneof![Just(TransformKind::FlipXy), Just(TransformKind::FlipXz)];
        let right = |quarters| vec![Interval::point(f64::from(90 * quarters))];
        let turn =
            prop_oneof![Just(TransformKind::RotX), Just(TransformKind::RotY), Just(TransformKind::RotZ)];
        prop_oneof![
            three().prop_map(|args| (TransformKind::Move, args.to_vec())),
            three().prop_map(|args| (TransformKind::Scale, args.to_vec())),
            interval().prop_map(|factor| (TransformKind::UScale, vec![factor])),
            flip.prop_map(|kind| (kind, vec![])),
            (turn, -3..3_i32).prop_map(move |(kind, quarters)| (kind, right(quarters))),
        ]
        .prop_filter_map("singular", |(kind, args): (_, Vec<_>)| MapRange::new(kind, &args))
    }

    proptest! {
        /// The envelope's way to the same box: supports through the corners of polytopes.
        #[test]
        fn boxes_are_those_of_envelopes(
            map in straight_map(),
            min in prop::array::uniform3(-9.0..9.0),
            size in prop::array::uniform3(0.0..9.0),
        ) {
            let (min, size) = (DVec3::from_array(min), DVec3::from_array(size));
            let below = Aabb::new(min, min + size);
            let body = Body::new(|d| [below.support(d), below.support(-d)], f64::INFINITY);
            let mut chain = Chain::default();
            prop_assert!(chain.push(&map));
            let expected = chain.image(&body).slabs.aabb();
            let found = map.image_of_box(&body.slabs.aabb()).expect("a straight map");
            let off = (found.min - expected.min).abs().max((found.max - expected.max).abs()).max_element();
            prop_assert!(off < 1e-13, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn what_turns_is_not_straight() {
        let turned = MapRange::new(TransformKind::RotZ, &[Interval::point(30.0)]).expect("a turn");
        assert!(!turned.is_straight());
        let swayed = MapRange::new(TransformKind::RotZ, &[Interval::new(0.0, 1.0)]).expect("a turn");
        assert!(swayed.image_of_box(&Aabb::ALL).is_none());
    }

    #[test]
    fn what_has_no_end_has_none_in_images() {
        let flat = MapRange::new(TransformKind::Scale, &[0.0, 1.0, 1.0].map(|x| Interval::new(0.0, x)));
        let image = flat.and_then(|flat| flat.image_of_box(&Aabb::ALL)).expect("a straight map");
        assert!(image.min.x > -1e-300 && image.max.x < 1e-300, "{image:?}");
        assert!(image.min.y == f64::NEG_INFINITY && image.max.z == f64::INFINITY, "{image:?}");
        let anywhere = MapRange::new(TransformKind::Move, &[Interval::ALL; 3]).expect("a move");
        assert_eq!(anywhere.image_of_box(&Aabb::new(DVec3::ZERO, DVec3::ONE)), Some(Aabb::ALL));
        assert_eq!(anywhere.image_of_box(&Aabb::EMPTY), Some(Aabb::EMPTY));
    }
}
