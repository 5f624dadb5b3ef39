//! Maps turned round: from the frame above into the frame below, with what that rounds.
//!
//! Contexts and cells go down the graph, against the direction of its maps, and need inverses. A computed inverse W of a
//! matrix M is one only nearly. How nearly, it says itself: with the residual R = I − W M, every y with M y + t = z is
//!
//! > y = W (z − t) + R y
//!
//! so that |y| ≤ |W (z − t)| / (1 − |R|), and what is computed without the second term misses y by at most |R| |y|.
//! Where the residual is not small, the map has no inverse to speak of.

use glam::{DAffine3, DMat3, DVec3};

use crate::Aabb;
use crate::rounding::{EVALUATION, Rounding};

/// The inverse of a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inverse {
    pub(super) child_from_parent: DAffine3,
    pub(super) rounding: Rounding,
    /// A bound of |R|, as the largest sum of absolute values in a row, rounding included.
    residual: f64,
    /// How far the origin's image may be off in each coordinate.
    offset: f64,
}

impl Inverse {
    /// `None` if the map is singular, or so close to it that nothing is known about its inverse.
    pub(super) fn of(parent_from_child: &DAffine3) -> Option<Self> {
        let DAffine3 { matrix3: m, translation: t } = *parent_from_child;
        let w = m.inverse();
        let product = w * m;
        let magnitudes = absolute(&w) * absolute(&m);
        let residual = largest_row_sum(&(absolute(&(DMat3::IDENTITY - product)) + magnitudes * EVALUATION));
        let offset = EVALUATION * (absolute(&w) * t.abs()).max_element();
        let child_from_parent = DAffine3 { matrix3: w, translation: DVec3::ZERO - w * t };
        // What is not a number is not below either.
        let sound = residual < 0.5 && offset < f64::MAX && child_from_parent.is_finite();
        sound.then(|| Self {
            child_from_parent,
            rounding: Rounding::of(&child_from_parent),
            residual,
            offset,
        })
    }

    /// How far a computed point of the frame below may be off in each coordinate because the inverse is not exact, where
    /// no exact one has a coordinate above `magnitude`.
    pub(super) fn error(&self, magnitude: f64) -> f64 {
        self.residual * magnitude + self.offset
    }

    /// A box that encloses all points that the map takes into `bounds`. The whole space, if that does not end.
    pub(super) fn image(&self, bounds: Aabb) -> Aabb {
        let computed = bounds.image(&self.child_from_parent);
        // |R| is below 0.5.
        let magnitude = 2.0 * (computed.magnitude() + self.offset);
        if computed.is_empty() {
            computed
        } else {
            computed.grown(self.error(magnitude) * (1.0 + EVALUATION))
        }
    }
}

fn absolute(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs())
}

fn largest_row_sum(m: &DMat3) -> f64 {
    (m.x_axis + m.y_axis + m.z_axis).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back_encloses() {
        let maps = [
            DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7),
            DAffine3::from_scale(DVec3::new(1e-9, 1e9, -3.0)),
            DAffine3::from_cols(DVec3::X, DVec3::new(1.0, 1e-7, 0.0), DVec3::ONE, DVec3::splat(1e5)),
        ];
        let bounds = Aabb::new(DVec3::new(-1.0, 2.0, 0.1), DVec3::new(1.5, 2.5, 0.3));
        for map in maps {
            let image = Aabb::from_points(bounds.corners().map(|corner| map.transform_point3(corner)));
            let back = Inverse::of(&map).expect("the map has an inverse").image(image);
            assert!(back.encloses(bounds), "{map:?} {back:?}");
        }
    }

    #[test]
    fn singular_maps_have_none() {
        let flat = DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0));
        let turned = DAffine3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7);
        for map in [flat, turned * flat * turned, DAffine3::from_translation(DVec3::NAN)] {
            assert!(Inverse::of(&map).is_none(), "{map:?}");
        }
    }
}
