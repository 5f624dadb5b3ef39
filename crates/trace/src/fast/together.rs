//! What the rays of a packet have hit: points and normals side by side.
//!
//! Neighbouring rays often hit the same item. What is painted on the way to it is the same for all of them then, and the
//! arithmetic is done in vectors, operation by operation that of a ray alone.

use fearless_simd::{Simd, SimdBase, SimdFloat, dispatch, f64x8};
use glam::DVec3;

use super::compiled::Content;
use super::hits::Place;
use super::lanes::{HALF, LANES, Lanes, Mask, Rays, Vectors, bits, each};
use super::resolve::Coat;
use super::{Tracer, shapes};
use crate::{Hit, Ray, walk};

/// Fewer rays than this are faster one after the other.
const FEW: u32 = 3;

/// Where rays have hit an item.
#[derive(Debug)]
pub(super) struct Together {
    /// The way there, with blocks.
    items: Vec<(u32, u32)>,
    /// One for the outer side of what is hit, and minus one for the inner one.
    sides: Lanes,
    points: Vectors,
    /// Of length 1.
    normals: Vectors,
}

impl Default for Together {
    fn default() -> Self {
        let (points, normals) = (Vectors::ZERO, Vectors::ZERO);
        Self { items: Vec::new(), sides: Lanes::ZERO, points, normals }
    }
}

impl Tracer<'_> {
    /// The hits of the packet that was traced last. None of them is noted yet.
    pub(super) fn hits_of(&mut self, rays: &[Ray], found: &mut [Option<Hit>]) {
        let mut places = [Place::NONE; LANES];
        let mut left: Mask = 0;
        for (lane, ray) in rays.iter().enumerate() {
            if let Some(place) = self.hits.found(lane)
                && let Some(place) = self.face(place, ray, self.hits.t.0[lane])
            {
                places[lane] = place;
                self.last = Some(place);
                left |= 1 << lane;
            }
        }
        while left != 0 {
            let lead = places[left.trailing_zeros() as usize % LANES];
            let mut same = 0;
            each(left, |lane| same |= u32::from(lead.is_one_with(places[lane])) << lane);
            left &= !same;
            let are_together = same.count_ones() >= FEW && self.hit_together(&places, lead, same, found);
            if !are_together {
                each(same, |lane| found[lane] = self.hit(lane, places[lane], &rays[lane]));
            }
        }
    }

    /// The hits of lanes that have hit the same item, unless its kind is not one for this.
    fn hit_together(
        &mut self,
        places: &[Place; LANES],
        place: Place,
        lanes: Mask,
        found: &mut [Option<Hit>],
    ) -> bool {
        each(lanes, |lane| self.together.sides.0[lane] = if places[lane].turned { -1.0 } else { 1.0 });
        let level = self.level;
        let Some(ordinary) = dispatch!(level, simd => self.set_normals(simd, place, lanes)) else {
            return false;
        };
        let Coat { surface, depth, .. } = *self.coat(place);
        let node = self.held.item(self.hits.block(place.way), place.item).node;
        let Self { together, hits, .. } = self;
        each(lanes, |lane| {
            let (point, normal) = (together.points.get(lane), together.normals.get(lane));
            found[lane] = Some(Hit { t: hits.t.0[lane], point, normal, surface, node, depth });
        });
        ordinary & lanes == lanes
    }

    /// Computes points and normals, and says which normals are so.
    #[inline(always)]
    fn set_normals<S: Simd>(&mut self, simd: S, place: Place, lanes: Mask) -> Option<Mask> {
        let Self { held, hits, packet, together, .. } = self;
        let Content::Shape(shape) = held.item(hits.block(place.way), place.item).content else {
            return None;
        };
        if place.is_small {
            return None;
        }
        let shape = &held.block(hits.block(place.way)).shapes[shape as usize];
        hits.items(place, &mut together.items);
        let world: &Rays = packet.rays();
        let mut ordinary = 0;
        for half in 0..2 {
            if lanes >> (half * HALF) & 0xff == 0 {
                continue;
            }
            let [mut origin, mut direction] = world.half(simd, half);
            let t = hits.t.half(simd, half);
            together.points.set_half(half, origin.at(direction, t));
            for (block, item) in &together.items {
                let map = &held.item(*block, *item).item_from_super;
                origin = origin.transform_point(map);
                direction = direction.transform_vector(map);
            }
            let normal = shapes::normals_at(simd, shape, [origin, direction], t)?;
            let mut normal = normal.scale(together.sides.half(simd, half));
            for (block, item) in together.items.iter().rev() {
                normal = normal.transform_normal(&held.item(*block, *item).item_from_super);
            }
            let squared_length = normal.dot(normal);
            let is_ordinary = squared_length.simd_ge(f64x8::splat(simd, walk::ORDINARY.start))
                & squared_length.simd_lt(f64x8::splat(simd, walk::ORDINARY.end));
            ordinary |= bits(is_ordinary) << (half * HALF);
            // With positive zeros, as `walk::unit` has them.
            together.normals.set_half(half, normal.divide(squared_length.sqrt()).offset(DVec3::ZERO));
        }
        Some(ordinary)
    }
}
