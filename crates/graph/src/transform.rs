//! Affine transformations as functions (the paper's section 3), and the kinds that the language names.
//!
//! A [`Transform`] is what a T-node does at one place of the unfolded tree: it maps points of the frame below the node
//! into the frame above it. It is applied as a function: a translation costs three additions, not a matrix product.

use glam::{DAffine3, DMat3, DVec3};

use crate::angle;
use crate::vocabulary::vocabulary;

/// An invertible affine map, as a function of points.
///
/// ```
/// use csg_graph::{Transform, TransformKind};
/// use glam::DVec3;
///
/// let parent_from_child = TransformKind::RotZ.evaluate(&[90.0]).unwrap();
/// assert_eq!(parent_from_child.point(DVec3::X), DVec3::Y);
/// assert_eq!(parent_from_child.inverse_point(DVec3::Y), DVec3::X);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Transform {
    /// Adds an offset.
    Translate(DVec3),
    /// Multiplies each coordinate by a factor; a factor of −1 is a mirror.
    Scale(DVec3),
    /// Turns about a coordinate axis, right-handed.
    Rotate {
        /// The axis.
        axis: Axis,
        /// The sine of the angle.
        sin: f64,
        /// The cosine of the angle.
        cos: f64,
    },
    /// Anything else, with its inverse.
    Affine {
        /// The map itself.
        forward: DAffine3,
        /// Its inverse.
        inverse: DAffine3,
    },
}

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Axis {
    /// (1, 0, 0)
    X,
    /// (0, 1, 0)
    Y,
    /// (0, 0, 1)
    Z,
}

impl Axis {
    fn rotate(self, sin: f64, cos: f64, v: DVec3) -> DVec3 {
        match self {
            Self::X => DVec3::new(v.x, cos * v.y - sin * v.z, sin * v.y + cos * v.z),
            Self::Y => DVec3::new(cos * v.x + sin * v.z, v.y, cos * v.z - sin * v.x),
            Self::Z => DVec3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z),
        }
    }
}

impl Transform {
    /// Any affine map, or `None` if it is singular or not finite.
    pub fn affine(forward: DAffine3) -> Option<Self> {
        let inverse = forward.inverse();
        let sound = forward.is_finite() && inverse.is_finite() && forward.matrix3.determinant() != 0.0;
        sound.then_some(Self::Affine { forward, inverse })
    }

    /// Maps a point into the frame above.
    pub fn point(&self, p: DVec3) -> DVec3 {
        match *self {
            Self::Translate(offset) => p + offset,
            Self::Scale(factors) => p * factors,
            Self::Rotate { axis, sin, cos } => axis.rotate(sin, cos, p),
            Self::Affine { forward, .. } => forward.transform_point3(p),
        }
    }

    /// Maps a point of the frame above into the frame below.
    pub fn inverse_point(&self, p: DVec3) -> DVec3 {
        match *self {
            Self::Translate(offset) => p - offset,
            Self::Scale(factors) => p / factors,
            Self::Rotate { axis, sin, cos } => axis.rotate(-sin, cos, p),
            Self::Affine { inverse, .. } => inverse.transform_point3(p),
        }
    }

    /// Maps a direction of the frame above into the frame below.
    pub fn inverse_vector(&self, v: DVec3) -> DVec3 {
        match *self {
            Self::Translate(_) => v,
            Self::Scale(_) | Self::Rotate { .. } => self.inverse_point(v),
            Self::Affine { inverse, .. } => inverse.transform_vector3(v),
        }
    }

    /// Maps a surface normal into the frame above: the inverse transposed. The length is not kept; the side is, also
    /// under mirrors.
    pub fn normal(&self, n: DVec3) -> DVec3 {
        match *self {
            Self::Translate(_) => n,
            Self::Scale(factors) => n / factors,
            Self::Rotate { axis, sin, cos } => axis.rotate(sin, cos, n),
            Self::Affine { inverse, .. } => inverse.matrix3.transpose() * n,
        }
    }

    /// The map as a matrix and a translation.
    pub fn to_affine(&self) -> DAffine3 {
        match *self {
            Self::Translate(offset) => DAffine3::from_translation(offset),
            Self::Scale(factors) => DAffine3::from_scale(factors),
            Self::Rotate { axis, sin, cos } => {
                let column = |v| axis.rotate(sin, cos, v);
                DAffine3::from_mat3(DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z)))
            }
            Self::Affine { forward, .. } => forward,
        }
    }
}

vocabulary! {
    /// A transformation of the language, before its arguments have values.
    pub enum TransformKind {
        Move: "move(x, y, z)", "adds (x, y, z)";
        Scale: "scale(x, y, z)", "multiplies each coordinate by a factor, none of which is 0";
        UScale: "uscale(factor)", "multiplies all coordinates by one factor, not 0";
        RotX: "rotx(angle)", "turns about the x axis, right-handed: y towards z";
        RotY: "roty(angle)", "turns about the y axis, right-handed: z towards x";
        RotZ: "rotz(angle)", "turns about the z axis, right-handed: x towards y";
        Rot: "rot((x, y, z), angle)", "turns about an axis through the origin, right-handed";
        FlipXy: "flipxy", "mirrors through the xy plane: z → −z";
        FlipXz: "flipxz", "mirrors through the xz plane: y → −y";
        FlipYz: "flipyz", "mirrors through the yz plane: x → −x";
        Shear: "shear(xy, xz, yx, yz, zx, zy)", "x + xy·y + xz·z, y + yx·x + yz·z, z + zx·x + zy·y";
        Matrix: "matrix((xx, xy, xz, x), (yx, yy, yz, y), (zx, zy, zz, z))", "xx·x + xy·y + xz·z + x, and so on: the rows of an invertible affine matrix";
    }
}

impl TransformKind {
    /// How many numbers it takes; those of a tuple count one by one.
    pub fn arity(self) -> usize {
        let signature = self.signature();
        if signature.contains('(') { signature.matches(',').count() + 1 } else { 0 }
    }

    /// The transformation for those arguments, or `None` if it is singular or not finite.
    ///
    /// # Panics
    /// If there are fewer arguments than [`arity`](Self::arity).
    pub fn evaluate(self, args: &[f64]) -> Option<Transform> {
        let vector = |at: usize| DVec3::new(args[at], args[at + 1], args[at + 2]);
        let rotation = |axis| {
            let (sin, cos) = angle::sin_cos(args[0]);
            Transform::Rotate { axis, sin, cos }
        };
        let transform = match self {
            Self::Move => Transform::Translate(vector(0)),
            Self::Scale => Transform::Scale(vector(0)),
            Self::UScale => Transform::Scale(DVec3::splat(args[0])),
            Self::RotX => rotation(Axis::X),
            Self::RotY => rotation(Axis::Y),
            Self::RotZ => rotation(Axis::Z),
            Self::FlipXy => Transform::Scale(DVec3::new(1.0, 1.0, -1.0)),
            Self::FlipXz => Transform::Scale(DVec3::new(1.0, -1.0, 1.0)),
            Self::FlipYz => Transform::Scale(DVec3::new(-1.0, 1.0, 1.0)),
            Self::Rot => {
                // Scaled first, since the square of a long axis leaves the range of numbers.
                let axis = vector(0);
                let axis = (axis / axis.abs().max_element()).try_normalize()?;
                let (sin, cos) = angle::sin_cos(args[3]);
                // Rodrigues: v cos + (axis × v) sin + axis (axis·v)(1 − cos)
                let column = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
                let turn = DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z));
                return Transform::affine(DAffine3::from_mat3(turn));
            }
            Self::Shear => {
                let [xy, xz, yx, yz, zx, zy] = [0, 1, 2, 3, 4, 5].map(|i| args[i]);
                let shear = DMat3::from_cols(
                    DVec3::new(1.0, yx, zx),
                    DVec3::new(xy, 1.0, zy),
                    DVec3::new(xz, yz, 1.0),
                );
                return Transform::affine(DAffine3::from_mat3(shear));
            }
            Self::Matrix => {
                let column = |at: usize| DVec3::new(args[at], args[at + 4], args[at + 8]);
                let forward = DAffine3::from_cols(column(0), column(1), column(2), column(3));
                return Transform::affine(forward);
            }
        };
        let sound = match transform {
            Transform::Translate(offset) => offset.is_finite(),
            Transform::Scale(factors) => factors.is_finite() && factors.recip().is_finite(),
            Transform::Rotate { sin, cos, .. } => sin.is_finite() && cos.is_finite(),
            Transform::Affine { .. } => true,
        };
        sound.then_some(transform)
    }
}
