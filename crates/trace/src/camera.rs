//! The pinhole camera, and where to put it when nobody says.

use std::ops::Range;

use csg_graph_bounds::Aabb;
use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use crate::{Beam, Ray};

/// A pinhole camera in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The point that it looks from.
    pub eye: DVec3,
    /// A point that it looks at: the middle of the picture.
    pub target: DVec3,
    /// The direction that is up in the picture as far as perspective allows. Any other is taken if this is the viewing
    /// direction itself.
    pub up: DVec3,
    /// The horizontal field of view in degrees, between 0 and 180.
    pub fov: f64,
}

/// Why a camera shows nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A coordinate is infinite or not a number.
    #[error("the camera's position is not finite")]
    NotFinite,
    /// Eye and target are the same point.
    #[error("the camera's eye and its target are the same point")]
    NoDirection,
    /// The field of view is out of range.
    #[error("a field of view is between 0 and 180 degrees, not {fov}")]
    FieldOfView {
        /// The angle that was asked for.
        fov: f64,
    },
}

/// From where [`Camera::framing`] looks: in front, somewhat from the right, slightly from above.
const THREE_QUARTER: DVec3 = DVec3::new(0.55, -1.0, 0.5);

/// How far from the centre of the box [`Camera::framing`] stays, in half diagonals.
const CLOSEST: f64 = 1.25;

/// How much of the picture's half width and half height [`Camera::framing`] fills.
const FILL: f64 = 0.92;

impl Camera {
    /// The field of view of a camera that nobody asked for, in degrees.
    pub const DEFAULT_FOV: f64 = 40.0;

    /// A three-quarter view in which `bounds` just fits, with a small margin, z up. `aspect` is width over height.
    ///
    /// All corners of the box are in view, with equal margins left and right and above and below. A box that is empty,
    /// unbounded or a single point is taken as one of extent 2 about its centre. The field of view is across, in degrees between 0
    /// and 180, and the aspect is the width by the height.
    ///
    /// ```
    /// use csg_graph_bounds::Aabb;
    /// use csg_graph_trace::Camera;
    /// use glam::DVec3;
    ///
    /// let bounds = Aabb::new(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0));
    /// let camera = Camera::framing(&bounds, Camera::DEFAULT_FOV, 16.0 / 9.0);
    /// assert!(camera.eye.y < 0.0 && camera.eye.x > 1.0);
    /// ```
    pub fn framing(bounds: &Aabb, fov: f64, aspect: f64) -> Self {
        let centre = bounds.center();
        let spans_space = bounds.is_bounded() && bounds.size().max_element() > 0.0;
        let corners = if spans_space {
            bounds.corners()
        } else {
            Aabb::new(centre - DVec3::ONE, centre + DVec3::ONE).corners()
        };
        let forward = -THREE_QUARTER.normalize();
        let (right, up) = upright(forward, DVec3::Z);
        let half_width = half_width(fov) * FILL;
        let half_height = half_width / aspect;
        // In the plane of `forward` and a side axis, a camera at (shift, −distance) sees a corner at (s, f) if
        // |s − shift| ≤ half · (distance + f). The corners that bind on each side give the shift and the least distance.
        let fit = |axis: DVec3, half: f64| {
            let bound = |side: f64| {
                let reach = |corner: &DVec3| {
                    let from_centre = *corner - centre;
                    side * axis.dot(from_centre) - half * forward.dot(from_centre)
                };
                corners.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
            };
            let (positive, negative) = (bound(1.0), bound(-1.0));
            ((positive - negative) / 2.0, (positive + negative) / (2.0 * half))
        };
        let (shift_right, distance_across) = fit(right, half_width);
        let (shift_up, distance_upright) = fit(up, half_height);
        let target = centre + right * shift_right + up * shift_up;
        // A wide angle could bring the camera into a thin box.
        let distance = distance_across.max(distance_upright).max(CLOSEST * corners[0].distance(centre));
        Self { eye: target - forward * distance, target, up: DVec3::Z, fov }
    }

    /// The camera with a picture of `width` by `height` pixels in front of it.
    ///
    /// # Errors
    /// If the camera shows nothing.
    pub fn lens(&self, width: u32, height: u32) -> Result<Lens, CameraError> {
        let Self { eye, target, up, fov } = *self;
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err(CameraError::FieldOfView { fov });
        }
        let forward = (target - eye).try_normalize().ok_or(CameraError::NoDirection)?;
        let (right, up) = upright(forward, up);
        let (width, height) = (f64::from(width), f64::from(height));
        let half_width = half_width(fov);
        Ok(Lens {
            eye,
            forward,
            right: right * half_width,
            up: up * (half_width * height / width),
            pixel: [2.0 / width, 2.0 / height],
        })
    }
}

/// Half the width of the picture plane at distance 1.
fn half_width(fov: f64) -> f64 {
    libm::tan(fov.to_radians() / 2.0)
}

/// The right and the up axis of a picture, both of length 1.
pub(crate) fn upright(forward: DVec3, up: DVec3) -> (DVec3, DVec3) {
    // Nearly parallel counts as parallel: what is left of the cross product would be rounding.
    let across = forward.cross(up.normalize_or_zero());
    let right = if across.length() > 1e-9 { across.normalize() } else { forward.any_orthonormal_vector() };
    (right, right.cross(forward))
}

/// A camera ready to give rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    eye: DVec3,
    /// To the picture plane, of length 1.
    forward: DVec3,
    /// From the middle of the picture to its right border.
    right: DVec3,
    /// From the middle of the picture to its upper border.
    up: DVec3,
    /// The size of a pixel, where that of the picture is 2 by 2.
    pixel: [f64; 2],
}

impl Lens {
    /// How large a pixel is at t = 1: the longer side.
    pub fn spread(&self) -> f64 {
        let [width, height] = self.pixel;
        (self.right.length() * width).max(self.up.length() * height)
    }

    /// The ray through a point of the picture, in pixels from the upper left corner: (0.5, 0.5) is the centre of the first
    /// pixel. At t = 1 it is in the picture plane, at distance 1 from the eye, so that t is the depth.
    #[inline]
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let [width, height] = self.pixel;
        let direction = self.forward + self.right * (x * width - 1.0) + self.up * (1.0 - y * height);
        Ray { origin: self.eye, direction }
    }

    /// The rays through one place in each of some columns and rows of pixels, row by row, as [`ray`](Self::ray) gives them one by
    /// one.
    pub(crate) fn rays(&self, columns: &Range<u32>, rows: &Range<u32>, place: DVec2, rays: &mut Vec<Ray>) {
        let [width, height] = self.pixel;
        let across = |x: u32| self.forward + self.right * ((f64::from(x) + place.x) * width - 1.0);
        let across: SmallVec<[DVec3; 4]> = columns.clone().map(across).collect();
        rays.clear();
        for y in rows.clone() {
            let down = self.up * (1.0 - (f64::from(y) + place.y) * height);
            rays.extend(across.iter().map(|across| Ray { origin: self.eye, direction: *across + down }));
        }
    }

    /// The rays through some columns and rows of pixels, at least one each, counted from the upper left corner.
    pub fn beam(&self, columns: &Range<u32>, rows: &Range<u32>) -> Beam {
        let [x, y] = [columns.start, rows.start].map(f64::from);
        let corner = self.ray(x, y).direction;
        let [next, other] = [[f64::from(columns.end), y], [x, f64::from(rows.end)]];
        let [across, down] = [next, other].map(|[x, y]| self.ray(x, y).direction - corner);
        Beam { origin: self.eye, corner, across, down }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(eye: [f64; 3], target: [f64; 3], up: DVec3) -> Camera {
        Camera { eye: eye.into(), target: target.into(), up, fov: 90.0 }
    }

    #[test]
    fn corners_of_the_picture() {
        let lens = camera([0.0, -3.0, 0.0], [0.0, 5.0, 0.0], DVec3::Z).lens(200, 100).unwrap();
        let close = |ray: Ray, direction: [f64; 3]| ray.direction.distance(direction.into()) < 1e-12;
        assert!(close(lens.ray(100.0, 50.0), [0.0, 1.0, 0.0]));
        assert!(close(lens.ray(0.0, 0.0), [-1.0, 1.0, 0.5]));
        assert!(close(lens.ray(200.0, 100.0), [1.0, 1.0, -0.5]));
    }

    #[test]
    fn rays_are_the_same_together_and_one_by_one() {
        let lens = camera([0.3, -3.0, 7.0], [0.1, 5.0, 0.0], DVec3::Z).lens(37, 23).unwrap();
        let place = DVec2::new(0.1, 0.7);
        let mut rays = Vec::new();
        lens.rays(&(31..37), &(4..9), place, &mut rays);
        let pixels = (4..9).flat_map(|y| (31..37).map(move |x| DVec2::new(x.into(), y.into()) + place));
        assert!(rays.into_iter().eq(pixels.map(|at| lens.ray(at.x, at.y))));
    }

    #[test]
    fn looking_straight_up_has_some_upright() {
        for up in [DVec3::Z, -DVec3::Z, DVec3::ZERO, DVec3::new(0.0, 1e-12, 1.0)] {
            let lens = camera([0.0; 3], [0.0, 0.0, 1.0], up).lens(10, 10).unwrap();
            assert_eq!(lens.forward, DVec3::Z);
            assert!(lens.right.dot(lens.up).abs() < 1e-12);
            assert!(lens.right.cross(lens.forward).distance(lens.up) < 1e-12);
        }
    }

    #[test]
    fn what_shows_nothing_is_refused() {
        let good = camera([0.0; 3], [1.0, 0.0, 0.0], DVec3::Z);
        assert!(good.lens(1, 1).is_ok());
        assert_eq!(Camera { target: good.eye, ..good }.lens(1, 1), Err(CameraError::NoDirection));
        assert_eq!(Camera { eye: DVec3::NAN, ..good }.lens(1, 1), Err(CameraError::NotFinite));
        for fov in [0.0, 180.0, -1.0] {
            assert_eq!(Camera { fov, ..good }.lens(1, 1), Err(CameraError::FieldOfView { fov }));
        }
    }

    #[test]
    fn framing_shows_all_corners_and_leaves_little_room() {
        let boxes = [
            Aabb::new(DVec3::splat(-1.0), DVec3::ONE),
            Aabb::new(DVec3::new(3.0, -2.0, 1.0), DVec3::new(4.0, 50.0, 2.0)),
            Aabb::new(DVec3::ZERO, DVec3::new(0.0, 0.0, 1e-6)),
            Aabb::new(DVec3::new(-1e6, 0.0, 0.0), DVec3::new(1e6, 1.0, 30.0)),
        ];
        for (bounds, [width, height], fov) in boxes.iter().flat_map(|bounds| {
            [[100, 100], [300, 100], [100, 300]]
                .into_iter()
                .flat_map(move |size| [20.0, 40.0, 100.0].map(|fov| (bounds, size, fov)))
        }) {
            let camera = Camera::framing(bounds, fov, f64::from(width) / f64::from(height));
            let lens = camera.lens(width, height).unwrap();
            let mut extreme = 0.0_f64;
            for corner in bounds.corners() {
                let seen = corner - camera.eye;
                let depth = seen.dot(lens.forward);
                assert!(depth > 0.0, "{bounds:?} is behind the camera");
                for axis in [lens.right, lens.up] {
                    extreme = extreme.max((seen.dot(axis) / axis.length_squared() / depth).abs());
                }
            }
            assert!(extreme < FILL + 1e-6, "{bounds:?} fills {extreme} of the picture");
            let wide = fov > 50.0 || height > width;
            assert!(extreme > FILL - 1e-6 || wide, "{bounds:?} fills only {extreme} of the picture");
        }
    }

    #[test]
    fn framing_nothing_or_everything() {
        for bounds in [Aabb::EMPTY, Aabb::ALL, Aabb::new(DVec3::ONE, DVec3::ONE)] {
            let camera = Camera::framing(&bounds, 40.0, 1.0);
            assert!(camera.lens(10, 10).is_ok(), "{bounds:?}");
        }
    }
}
