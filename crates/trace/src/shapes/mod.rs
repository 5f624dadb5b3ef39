//! Where a line is inside of a primitive, in the primitive's object frame C₀.
//!
//! Every shape answers for the whole line, t from −∞ to +∞, because a Boolean operator needs all of it: what lies behind
//! the origin of a ray still decides what its first point is in. A convex shape has at most one span, a torus two.
//!
//! The numbers that come in are unpleasant. Deep in a recursion a ray starts at about its distance divided by scaleⁿ,
//! 10¹⁰ object units away being ordinary, and the textbook discriminant b² − 4ac loses all its digits there. So each
//! curved shape first moves the parameter to the ray's closest approach to the shape's centre or axis: that point has the
//! rounding error of the origin, which nothing can undo, but no more \[HAIN19\]. Planes need no such care, and keeping
//! `(offset − n·origin) / n·direction` as it is makes coincident faces of translated solids meet at equal t wherever the
//! sums are exact.
//!
//! Directions must be neither so short nor so long that their squares leave the range of `f64`, about 10^±150; beyond, a
//! shape is missed.

mod cone;
mod cube;
mod cylinder;
mod polytope;
mod sphere;
mod torus;

use std::ops::Deref;

use csg_graph::Primitive;
use glam::DVec3;

use crate::Ray;

/// One end of a [`Span`]: where the line crosses the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// The parameter of the line; infinite where an unbounded solid never ends.
    pub t: f64,
    /// The outward normal in the object frame, of any positive length.
    pub normal: DVec3,
}

/// A part of a line that is inside of a solid: `enter.t < exit.t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Where the line comes in.
    pub enter: End,
    /// Where it goes out.
    pub exit: End,
}

impl Span {
    /// The whole line.
    const LINE: Self = Self {
        enter: End { t: f64::NEG_INFINITY, normal: DVec3::ZERO },
        exit: End { t: f64::INFINITY, normal: DVec3::ZERO },
    };

    /// Cuts off what comes before `end`.
    fn clip_enter(&mut self, end: End) {
        if end.t > self.enter.t {
            self.enter = end;
        }
    }

    /// Cuts off what comes after `end`.
    fn clip_exit(&mut self, end: End) {
        if end.t < self.exit.t {
            self.exit = end;
        }
    }

    /// Keeps what is in `other`, too.
    fn clip(&mut self, other: Self) {
        self.clip_enter(other.enter);
        self.clip_exit(other.exit);
    }
}

/// The spans of a line in one primitive: in order, apart from each other, none empty.
#[derive(Clone, Copy, Debug)]
pub struct Spans {
    spans: [Span; 2],
    count: usize,
}

impl Spans {
    const NONE: Self = Self { spans: [Span::LINE; 2], count: 0 };

    /// Adds a span behind the others, or to the last one if they touch. One without length is no span: a line that only
    /// touches a solid misses it. Neither is one whose ends are no numbers.
    fn push(&mut self, span: Span) {
        if span.enter.t < span.exit.t {
            match self.spans[..self.count].last_mut() {
                Some(last) if last.exit.t >= span.enter.t => last.exit = span.exit,
                _ => {
                    self.spans[self.count] = span;
                    self.count += 1;
                }
            }
        }
    }

    fn from_convex(span: Span) -> Self {
        let mut spans = Self::NONE;
        spans.push(span);
        spans
    }
}

impl Deref for Spans {
    type Target = [Span];

    fn deref(&self) -> &[Span] {
        &self.spans[..self.count]
    }
}

/// Spans without their normals: from the first number to the second one, where that is greater.
pub(crate) type Extents = [[f64; 2]; 2];

/// Where the line of `ray` is in `primitive`, as in [`spans`].
#[inline(always)]
pub(crate) fn extents(primitive: &Primitive, ray: &Ray) -> Extents {
    // Of what is inlined here, the compiler leaves out the normals.
    let convex = |span: Option<Span>| {
        let extent = span.map_or(NOWHERE, |span| [span.enter.t, span.exit.t]);
        [extent, NOWHERE]
    };
    match primitive {
        Primitive::Sphere => convex(Some(sphere::span(ray))),
        Primitive::Cube => convex(cube::span(ray)),
        Primitive::Cylinder => convex(cylinder::span(ray)),
        _ => extents_of_others(primitive, ray),
    }
}

const NOWHERE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

#[inline(never)]
fn extents_of_others(primitive: &Primitive, ray: &Ray) -> Extents {
    let mut extents = [NOWHERE; 2];
    for (extent, span) in extents.iter_mut().zip(spans(primitive, ray).iter()) {
        *extent = [span.enter.t, span.exit.t];
    }
    extents
}

/// The first boundary of `primitive` on the line of `ray` that is not before `t`, as in [`spans`].
#[inline(always)]
pub(crate) fn boundary(primitive: &Primitive, ray: &Ray, t: f64) -> Option<End> {
    // Of what is inlined here, the compiler leaves out the end that is not asked for.
    let of = |span: &Span| if span.enter.t >= t { span.enter } else { span.exit };
    let span = match primitive {
        Primitive::Sphere => sphere::span(ray),
        Primitive::Cube => cube::span(ray)?,
        Primitive::Cylinder => cylinder::span(ray)?,
        _ => *spans(primitive, ray).iter().find(|span| span.exit.t >= t)?,
    };
    Some(of(&span)).filter(|end| end.t >= t)
}

/// The outward normal of `primitive` where the line of `ray` has a boundary at `t`, one of its [`extents`]: of any positive
/// length, and up to rounding as in [`spans`].
#[inline(always)]
pub(crate) fn normal_at(primitive: &Primitive, ray: &Ray, t: f64) -> Option<DVec3> {
    match primitive {
        Primitive::Sphere => Some(ray.at(t)),
        Primitive::Cube => Some(cube::normal_at(ray, t)),
        Primitive::Cylinder => Some(cylinder::normal_at(ray, t)),
        Primitive::Cone => Some(cone::normal_at(ray, t, 0.0)),
        Primitive::Frustum { top } => Some(cone::normal_at(ray, t, *top)),
        _ => boundary(primitive, ray, t).map(|end| end.normal),
    }
}

/// The spans of the line of `ray` in `primitive`, both in the object frame.
///
/// A line that lies in a flat face counts as inside where the face is a minimum of its coordinate and as outside where it
/// is a maximum, so that of two cubes stacked on each other exactly one has it. Faces of hulls have no such order; there
/// it is outside.
///
/// # Panics
/// If `csg-graph` has gained a primitive that this crate does not know.
pub fn spans(primitive: &Primitive, ray: &Ray) -> Spans {
    match primitive {
        Primitive::Sphere => Spans::from_convex(sphere::span(ray)),
        Primitive::Cylinder => cylinder::span(ray).map_or(Spans::NONE, Spans::from_convex),
        Primitive::Cone => cone::spans(ray, 0.0),
        Primitive::Frustum { top } => cone::spans(ray, *top),
        Primitive::Cube => cube::span(ray).map_or(Spans::NONE, Spans::from_convex),
        Primitive::Torus { minor } => torus::spans(ray, *minor),
        Primitive::Hull(hull) => polytope::hull_spans(ray, hull),
        Primitive::HalfSpace => polytope::half_space_spans(ray),
        other => unreachable!("{other:?} has no module here"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fast::sample::Dice;

    #[test]
    fn normals_at_boundaries_are_those_of_spans() {
        let mut dice = Dice::at(DVec3::ONE);
        let mut number = || 2.0 * dice.throw() - 1.0;
        let primitives = [
            Primitive::Sphere,
            Primitive::Cube,
            Primitive::Cylinder,
            Primitive::Cone,
            Primitive::Frustum { top: 0.3 },
            Primitive::Frustum { top: 1.7 },
            Primitive::Torus { minor: 0.4 },
            Primitive::HalfSpace,
        ];
        for primitive in &primitives {
            let mut seen = 0;
            for _ in 0..4000 {
                let mut vector = || DVec3::new(number(), number(), number());
                let (origin, target) = (vector() * 3.0, vector());
                let ray = Ray { origin, direction: target - origin };
                let inner = extents(primitive, &ray).into_iter().flatten().filter(|t| t.is_finite());
                let ends: Vec<End> =
                    spans(primitive, &ray).iter().flat_map(|span| [span.enter, span.exit]).collect();
                let ends: Vec<End> = ends.into_iter().filter(|end| end.t.is_finite()).collect();
                for (t, end) in inner.zip(&ends) {
                    let normal = normal_at(primitive, &ray, t).unwrap().normalize();
                    let apart = normal.distance(end.normal.normalize());
                    assert!(apart < 1e-9, "{primitive:?} {ray:?} at {t}: {normal} is {apart} off");
                    seen += 1;
                }
            }
            assert!(seen > 500, "{primitive:?}");
        }
    }

    #[test]
    fn edges_and_lines_along_faces_have_the_normals_of_spans() {
        let coordinates = [-2.0, -1.0, 0.0, 0.5, 1.0];
        let steps = [-1.0, 0.0, 0.5, 1.0];
        let vectors = |of: &[f64]| {
            let all = of.iter().flat_map(|x| of.iter().map(move |y| (*x, *y)));
            all.flat_map(|(x, y)| of.iter().map(move |z| DVec3::new(x, y, *z))).collect::<Vec<_>>()
        };
        for primitive in [Primitive::Cube, Primitive::Cylinder, Primitive::Cone] {
            for origin in vectors(&coordinates) {
                for direction in vectors(&steps).into_iter().filter(|step| *step != DVec3::ZERO) {
                    let ray = Ray { origin, direction };
                    for end in spans(&primitive, &ray).iter().flat_map(|span| [span.enter, span.exit]) {
                        let normal = normal_at(&primitive, &ray, end.t).unwrap();
                        let apart = normal.normalize().distance(end.normal.normalize());
                        assert!(apart < 1e-9, "{primitive:?} {ray:?} at {}: {normal}", end.t);
                    }
                }
            }
        }
    }
}
