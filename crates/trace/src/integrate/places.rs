//! The places where the rays of a packet meet surfaces, side by side, and the ways from there to a light.
//!
//! What takes time in shading is to bring vectors to length 1. Arithmetic is that of [`Place`] and of
//! [`Light`], operation by operation, so that a hit is shaded alike in any company.

use fearless_simd::{Level, Select, Simd, SimdBase, SimdFloat, dispatch, f64x8, mask64x8};
use glam::DVec3;

use super::OFFSET;
#[cfg(doc)]
use super::Place;
use crate::fast::lanes::{HALF, Lanes, Mask, Vec3x8, Vectors, bits};
use crate::{Hit, Light, LightSource, Ray};

/// Places that rays leave on the side that they came from.
#[derive(Debug)]
pub(super) struct Places {
    level: Level,
    /// Those that there are.
    lanes: Mask,
    origins: Vectors,
    directions: Vectors,
    points: Vectors,
    /// On the side that the ray came from, of length 1.
    normals: Vectors,
    /// Back along the ray, of length 1.
    to_viewer: Vectors,
    /// Where rays start.
    starts: Vectors,
    to_light: Vectors,
    distances: Lanes,
    facing: Lanes,
}

/// The way from a place to a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Way {
    /// Where it starts and where it goes, at length 1.
    pub(super) ray: Ray,
    /// How far it is.
    pub(super) distance: f64,
    /// The cosine of the angle to the normal.
    pub(super) facing: f64,
}

impl Default for Places {
    fn default() -> Self {
        Self {
            level: Level::new(),
            lanes: 0,
            origins: Vectors::ZERO,
            directions: Vectors::ZERO,
            points: Vectors::ZERO,
            normals: Vectors::ZERO,
            to_viewer: Vectors::ZERO,
            starts: Vectors::ZERO,
            to_light: Vectors::ZERO,
            distances: Lanes::ZERO,
            facing: Lanes::ZERO,
        }
    }
}

impl Places {
    /// Takes the hits of as many rays as go together, and says which rays have one.
    pub(super) fn set(&mut self, rays: &[Ray], hits: &[Option<Hit>]) -> Mask {
        self.lanes = 0;
        for (lane, (ray, hit)) in rays.iter().zip(hits).enumerate() {
            let Some(hit) = hit else { continue };
            self.origins.set(lane, ray.origin);
            self.directions.set(lane, ray.direction);
            self.points.set(lane, hit.point);
            self.normals.set(lane, hit.normal);
            self.lanes |= 1 << lane;
        }
        if self.lanes != 0 {
            dispatch!(self.level, simd => self.settle(simd));
        }
        self.lanes
    }

    /// Finds the ways to a light, and says which places face it.
    pub(super) fn face(&mut self, light: &Light) -> Mask {
        let towards = match light.source {
            LightSource::Point(position) => Ok(position),
            LightSource::Directional(_) => match light.way_from(DVec3::ZERO) {
                Some((to_light, _)) => Err(to_light),
                None => return 0,
            },
        };
        dispatch!(self.level, simd => self.turn(simd, towards)) & self.lanes
    }

    /// The way from a place to the light that was faced last.
    #[inline(always)]
    pub(super) fn way(&self, lane: usize) -> Way {
        let ray = Ray { origin: self.starts.get(lane), direction: self.to_light.get(lane) };
        Way { ray, distance: self.distances.0[lane], facing: self.facing.0[lane] }
    }

    /// The normal and the way back to the viewer.
    #[inline(always)]
    pub(super) fn seen(&self, lane: usize) -> [DVec3; 2] {
        [self.normals.get(lane), self.to_viewer.get(lane)]
    }

    /// As [`Place::new`] and [`Place::before`].
    #[inline(always)]
    fn settle<S: Simd>(&mut self, simd: S) {
        let zero = f64x8::splat(simd, 0.0);
        for half in 0..2 {
            if self.lanes >> (half * HALF) & 0xff == 0 {
                continue;
            }
            let direction = self.directions.half(simd, half);
            let (unit, _, has_length) = unit(simd, direction);
            let to_viewer = Vec3x8 {
                x: -has_length.select(unit.x, zero),
                y: -has_length.select(unit.y, zero),
                z: -has_length.select(unit.z, zero),
            };
            let normal = self.normals.half(simd, half);
            let is_turned = normal.dot(to_viewer).simd_lt(zero);
            let normal = Vec3x8 {
                x: is_turned.select(-normal.x, normal.x),
                y: is_turned.select(-normal.y, normal.y),
                z: is_turned.select(-normal.z, normal.z),
            };
            let point = self.points.half(simd, half);
            let origin = self.origins.half(simd, half);
            let x = point.x.abs().max(origin.x.abs());
            let y = point.y.abs().max(origin.y.abs());
            let z = point.z.abs().max(origin.z.abs());
            let offset = x.max(y).max(z) * OFFSET;
            self.to_viewer.set_half(half, to_viewer);
            self.normals.set_half(half, normal);
            self.starts.set_half(half, point.at(normal, offset));
        }
    }

    /// As [`Light::way_from`], towards a position or in a direction.
    #[inline(always)]
    fn turn<S: Simd>(&mut self, simd: S, towards: Result<DVec3, DVec3>) -> Mask {
        let splat = |value| f64x8::splat(simd, value);
        let mut lit = 0;
        for half in 0..2 {
            if self.lanes >> (half * HALF) & 0xff == 0 {
                continue;
            }
            let start = self.starts.half(simd, half);
            let (to_light, distance, has_way) = match towards {
                Ok(position) => {
                    let x = splat(position.x) - start.x;
                    let y = splat(position.y) - start.y;
                    let z = splat(position.z) - start.z;
                    unit(simd, Vec3x8 { x, y, z })
                }
                Err(direction) => {
                    let [x, y, z] = direction.to_array().map(splat);
                    let infinity = splat(f64::INFINITY);
                    (Vec3x8 { x, y, z }, infinity, infinity.simd_gt(splat(0.0)))
                }
            };
            let facing = self.normals.half(simd, half).dot(to_light);
            self.to_light.set_half(half, to_light);
            self.distances.set_half(half, distance);
            self.facing.set_half(half, facing);
            lit |= bits(facing.simd_gt(splat(0.0)) & has_way) << (half * HALF);
        }
        lit
    }
}

/// Vectors at length 1, their lengths, and which of them have such a thing: as glam's `normalize_and_length`.
#[inline(always)]
fn unit<S: Simd>(simd: S, vector: Vec3x8<S>) -> (Vec3x8<S>, f64x8<S>, mask64x8<S>) {
    let length = vector.dot(vector).sqrt();
    let inverse = f64x8::splat(simd, 1.0) / length;
    let is_finite = inverse.simd_lt(f64x8::splat(simd, f64::INFINITY));
    let has_direction = is_finite & inverse.simd_gt(f64x8::splat(simd, 0.0));
    (vector.scale(inverse), length, has_direction)
}

#[cfg(test)]
mod tests {
    use csg_graph::{GraphBuilder, PrimitiveKind};

    use super::*;
    use crate::Surface;
    use crate::fast::lanes::LANES;
    use crate::fast::sample::Dice;
    use crate::integrate::Place;

    #[test]
    fn places_are_those_of_single_hits() {
        let mut builder = GraphBuilder::new();
        let node = builder.primitive(PrimitiveKind::Sphere, []);
        let mut dice = Dice::at(DVec3::ONE);
        let mut number = || 2.0 * dice.throw() - 1.0;
        let mut places = Places::default();
        let mut lit = 0;
        for size in [1e-9, 1.0, 3e7] {
            let mut vector = || DVec3::new(number(), number(), number());
            let lights = [
                LightSource::Point(vector() * size * 9.0),
                LightSource::Point(DVec3::ZERO),
                LightSource::Directional(vector() * size),
                LightSource::Directional(DVec3::ZERO),
            ];
            let lights = lights.map(|source| Light { source, colour: DVec3::ONE, shadow: true });
            for _ in 0..40 {
                let rays: [Ray; LANES] = std::array::from_fn(|lane| Ray {
                    origin: vector() * size,
                    direction: if lane == 3 { DVec3::ZERO } else { vector() * size },
                });
                let hits: [Option<Hit>; LANES] = std::array::from_fn(|lane| {
                    let point = if lane == 5 { DVec3::ZERO } else { vector() * size };
                    let normal = vector().normalize();
                    let hit = Hit { t: 1.0, point, normal, surface: Surface::default(), node, depth: 0 };
                    (lane % 4 != 1).then_some(hit)
                });
                let set = places.set(&rays, &hits);
                for light in &lights {
                    let facing = places.face(light);
                    for (lane, (ray, hit)) in rays.iter().zip(&hits).enumerate() {
                        assert_eq!(set >> lane & 1 == 1, hit.is_some());
                        let Some(hit) = hit else { continue };
                        let place = Place::new(ray, hit);
                        assert_eq!(places.seen(lane), [place.normal, place.to_viewer]);
                        let origin = place.before();
                        let way = light.way_from(origin).map(|(direction, distance)| Way {
                            ray: Ray { origin, direction },
                            distance,
                            facing: place.normal.dot(direction),
                        });
                        let way = way.filter(|way| way.facing > 0.0);
                        assert_eq!((facing >> lane & 1 == 1).then(|| places.way(lane)), way);
                        lit += usize::from(way.is_some());
                    }
                }
            }
        }
        assert!(lit > 1000, "{lit}");
    }
}
