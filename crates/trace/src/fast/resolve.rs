//! What is where a ray has hit something: normal, surface and depth of recursion, found on the way up from there.

use fearless_simd::dispatch;
use glam::DVec3;

use super::Tracer;
use super::compiled::Content;
use super::hits::Place;
use super::lanes::transform;
use super::sample::Dice;
use crate::{Hit, Ray, Surface, shapes, walk};

/// What all that is painted on the way to a place makes of its surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coat {
    place: Place,
    pub(super) surface: Surface,
    pub(super) depth: u32,
}

impl Tracer<'_> {
    /// What a lane has hit at a place. Inlined, as hits are too large to be moved for nothing.
    #[inline(always)]
    pub(super) fn hit(&mut self, lane: usize, place: Place, world_ray: &Ray) -> Option<Hit> {
        let t = self.hits.t.0[lane];
        if place.is_small {
            return Some(self.small_hit(lane, place, world_ray, t));
        }
        let number = self.hits.block(place.way);
        let item = self.held.item(number, place.item);
        let node = item.node;
        let Content::Shape(shape) = item.content else {
            unreachable!("what is hit is a face of a primitive")
        };
        let ray = match self.hits.ray_at(lane, place) {
            Some(super_ray) => transform(super_ray, &item.item_from_super),
            None => self.descend(place, world_ray),
        };
        let shape = &self.held.block(number).shapes[shape as usize];
        let normal = shapes::normal_at(shape, &ray, t)?;
        let normal = if place.turned { -normal } else { normal };
        let (normal, surface, depth) = self.outwards(place, normal);
        let normal = walk::unit(normal).unwrap_or(-world_ray.direction);
        Some(Hit { t, point: world_ray.at(t), normal, surface, node, depth })
    }

    /// What a normal in the frame of an item is in the world, with what paints the item and its depth.
    #[inline(always)]
    fn outwards(&mut self, place: Place, mut normal: DVec3) -> (DVec3, Surface, u32) {
        for (block, item) in self.hits.upwards(place) {
            normal = self.held.item(block, item).item_from_super.matrix3.transpose() * normal;
        }
        let Coat { surface, depth, .. } = *self.coat(place);
        (normal, surface, depth)
    }

    /// What paints an item, and how deep it is.
    #[inline(always)]
    pub(super) fn coat(&mut self, place: Place) -> &Coat {
        if !self.coat.is_some_and(|coat| coat.place.is_one_with(place)) {
            self.coat = Some(self.coat_of(place));
        }
        self.coat.as_ref().expect("it has just been put there")
    }

    #[inline(never)]
    fn coat_of(&mut self, place: Place) -> Coat {
        let mut depth = 0;
        self.paints.clear();
        for (block, item) in self.hits.upwards(place) {
            let item = self.held.item(block, item);
            depth += item.depth;
            self.paints.extend(item.paint.map(|paint| (block, paint)));
        }
        let mut surface = Surface::default();
        for (block, paint) in self.paints.iter().rev() {
            let terms = &self.held.block(*block).paints[*paint as usize];
            terms.iter().for_each(|(term, value)| surface.set(*term, *value));
        }
        Coat { place, surface, depth }
    }

    /// What is seen of a part whose box a lane has hit.
    #[inline(never)]
    fn small_hit(&mut self, lane: usize, place: Place, world_ray: &Ray, t: f64) -> Hit {
        let number = self.hits.block(place.way);
        let block = self.held.block(number);
        let ray = match self.hits.ray_at(lane, place) {
            Some(super_ray) if place.is_node => *super_ray,
            Some(super_ray) => transform(super_ray, &block.items[place.item as usize].item_from_super),
            None => self.descend(place, world_ray),
        };
        let block = self.held.block(number);
        let seen = block.look(place).and_then(|look| look.draw(ray.direction, &mut Dice::of(world_ray)));
        let (normal, surface, below) = match seen {
            Some(seen) => {
                let (normal, mut surface, depth) = self.outwards(place, seen.normal.as_dvec3());
                let paint = &self.held.block(number).looks.paints[seen.paint as usize];
                paint.iter().for_each(|(term, value)| surface.set(*term, *value));
                // What is around it, too small to be met by shadow rays, takes away light.
                surface.diffuse *= f64::from(seen.open);
                surface.specular *= f64::from(seen.open);
                (normal, surface, (seen.node, depth + seen.depth))
            }
            None => {
                let sample = self.held.sample(number, place);
                let normal = sample.normal(&ray).unwrap_or(-ray.direction);
                let (normal, mut surface, depth) = self.outwards(place, normal);
                sample.paint.iter().for_each(|(term, value)| surface.set(*term, *value));
                (normal, surface, (sample.node, depth + sample.depth))
            }
        };
        let normal = walk::unit(normal).unwrap_or(-world_ray.direction);
        let (node, depth) = below;
        Hit { t, point: world_ray.at(t), normal, surface, node, depth }
    }

    /// The face of the solid at a place that a ray of the world meets at t; of anything else, itself. None where what was
    /// found is void.
    #[inline(always)]
    pub(super) fn face(&mut self, place: Place, world_ray: &Ray, t: f64) -> Option<Place> {
        if place.is_small {
            return Some(place);
        }
        let item = self.held.item(self.hits.block(place.way), place.item);
        let Content::Solid(solid) = item.content else { return Some(place) };
        let Self { level, held, hits, faces, .. } = self;
        let face = dispatch!(*level, simd => faces.find(simd, held, hits, place, world_ray, t));
        face.or_else(|| self.face_come_to(place, solid, world_ray, t))
    }

    /// The same if no operand has a face there. The box that stands for a small part in the frame of that juts out of the boxes
    /// around it, which touch what is in there: the point may be in the first of them and not in the others.
    #[inline(never)]
    fn face_come_to(&mut self, place: Place, solid: u32, world_ray: &Ray, t: f64) -> Option<Place> {
        if self.held.is_void() {
            return None;
        }
        let ray = self.descend(place, world_ray);
        let Self { level, held, hits, solids, .. } = self;
        assert!(hits.detail.is_some(), "a solid has a face where a ray meets it");
        let come_to = dispatch!(*level, simd => solids.first(simd, held, hits, (solid, place), &ray, t));
        // By rounding the ray may come to nothing now: it is seen all the same.
        Some(come_to.map_or(place.as_box(), |(_, face)| face))
    }

    /// A ray of the world in the frame of an item.
    fn descend(&mut self, place: Place, world_ray: &Ray) -> Ray {
        let Self { held, hits, items, .. } = self;
        hits.items(place, items);
        let into =
            |ray, (block, item): &(u32, u32)| transform(&ray, &held.item(*block, *item).item_from_super);
        items.iter().fold(*world_ray, into)
    }
}
