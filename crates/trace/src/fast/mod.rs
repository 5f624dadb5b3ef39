//! The fast engine: the graph compiled into [super-nodes](compile), traced in [packets](packet).
//!
//! It finds the hits of the [reference walk](crate::Walk): t and normal differ only by how the products of transformations
//! are rounded. Where the walk asks one node after the other, evaluating its expressions each time, this one has
//! evaluated each state once, and goes down a few wide trees. It is in these parts:
//!
//! - [`states`], [`unions`], [`lists`], [`compile`]: states to super-nodes and solids, with the boxes of [`bounds`];
//! - [`blocks`]: all of the graph at once, or what rays come to;
//! - [`tree`], [`frame`], [`point`]: their boxes in single precision, and what is tested against them;
//! - [`entry`]: where the rays of a beam begin, past the way that all of them have in common;
//! - [`packet`], [`single`]: the first hit of rays together and alone; [`lanes`] and [`shapes`] are their arithmetic;
//! - [`solid`], [`cuts`], [`face`]: the first boundary of the results of ∩ and \\, alone and together, and whose face it is;
//! - [`hits`], [`together`]: what was hit, and the way to it; and its surface and normal for several rays;
//! - [`detail`], [`look`], [`cover`], [`survey`], [`sample`]: what is too small to be looked into, and what is seen of it.

pub(crate) mod blocks;
mod bounds;
mod compile;
mod cover;
mod cuts;
mod detail;
mod entry;
mod face;
mod frame;
mod hits;
pub(crate) mod lanes;
mod lists;
mod look;
mod packet;
mod point;
mod sample;
mod shapes;
mod single;
mod solid;
pub(crate) mod states;
mod survey;
#[cfg(test)]
mod tests;
mod together;
mod tree;
pub(crate) mod unions;

use std::sync::Arc;

use csg_graph::{EvalError, Graph};
use csg_graph_bounds::ExactBoxes;
use fearless_simd::{Level, Simd, dispatch};
use glam::DVec3;

use self::blocks::{Blocks, Held, OnDemand};
pub(crate) use self::bounds::Bounds;
pub use self::bounds::StateBounds;
use self::compile::{Compiled, Content};
use self::cover::Cover;
use self::detail::Detail;
pub use self::detail::Footprint;
pub use self::entry::Beam;
use self::entry::Entries;
use self::face::Faces;
use self::hits::{Hits, Place};
use self::lanes::transform;
use self::packet::Packet;
use self::sample::Dice;
use self::single::Single;
use self::solid::Solids;
use self::together::Together;
use self::tree::Child;
use crate::{Counters, Hit, Ray, Surface, walk};

/// Rays that are traced together.
pub const PACKET: usize = lanes::LANES;

/// The side of a square of as many pixels.
pub(crate) const SIDE: u32 = 4;

/// A graph compiled for tracing.
#[derive(Debug)]
pub struct Accelerated {
    blocks: Blocks,
    /// The share of a pixel below which nothing is looked into.
    detail: f64,
    level: Level,
}

/// What rays ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ask {
    /// The first hit.
    Nearest,
    /// Any hit.
    Any,
}

/// What rays cost.
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    boxes: u64,
    primitives: u64,
}

/// A question about the rays of a packet, and where answers go.
struct Inquiry<'t> {
    held: &'t Held<'t>,
    ask: Ask,
    hits: &'t mut Hits,
    solids: &'t mut Solids,
    work: Work,
}

impl Inquiry<'_> {
    /// Notes that a ray meets an item at t. `seen` gives the way that it is on, and the ray there.
    #[inline(always)]
    fn answer(&mut self, lane: usize, t: f64, place: Place, seen: impl FnOnce() -> (u32, Ray)) {
        match self.ask {
            Ask::Nearest => self.hits.offer(lane, t, place, seen),
            Ask::Any if t < self.hits.t.0[lane] => self.hits.stop(lane, place),
            Ask::Any => {}
        }
    }

    /// Whether a child of a super-node, whose box a ray meets at t, is too small to be looked into.
    #[inline(always)]
    fn is_small(&self, block: &Compiled, way: u32, child: Child, t: f64) -> bool {
        let Some(detail) = &self.hits.detail else { return false };
        match child.get() {
            Ok(item) => detail.hides_part(way, &block.parts[item], t),
            Err(node) => detail.hides(way, block.nodes[node].size, t),
        }
    }

    /// Lets a ray in a super-node meet the box of a child at t, if what is in there stops it.
    #[inline(never)]
    fn meet_small(&mut self, block: &Compiled, lane: usize, (way, child): (u32, Child), ray: &Ray, t: f64) {
        let Some(detail) = &mut self.hits.detail else { return };
        if detail.leaves(way, ray, t) {
            return;
        }
        let mut stops = |cover: &Cover| detail.stops(lane, ray, cover.along(ray.direction), cover.apart);
        if block.cover(child).is_none_or(&mut stops) {
            self.answer(lane, t, Place::box_of(way, child), || (way, *ray));
        }
    }

    /// Asks a solid, an item of a super-node, about a ray in the frame of that.
    #[inline(always)]
    fn ask_solid<S: Simd>(&mut self, simd: S, lane: usize, ray: &Ray, solid: u32, place: Place) {
        let end = self.hits.t.0[lane];
        let item = self.held.item(self.hits.block(place.way), place.item);
        let inside = transform(ray, &item.item_from_super);
        let first = self.solids.first(simd, self.held, self.hits, (solid, place), &inside, end);
        if let Some((t, face)) = first {
            self.answer(lane, t, face, || (place.way, *ray));
        }
    }
}

impl Accelerated {
    /// Memory that an engine takes if nobody says how much it may take, in bytes.
    pub const DEFAULT_BUDGET: usize = 1 << 18;

    /// Compiles a graph with the boxes that belong to it. Takes `budget` bytes, or more if the graph has too many states
    /// for that.
    ///
    /// # Errors
    /// If an expression of the graph has no usable value.
    pub fn new(graph: &Graph, boxes: &ExactBoxes<Graph>, budget: usize) -> Result<Self, EvalError> {
        let whole = Compiled::whole(graph, Bounds::Exact(boxes), budget)?;
        Ok(Self { blocks: Blocks::Whole(Arc::new(whole)), detail: 0.0, level: Level::new() })
    }

    /// Compiles what rays come to, when they come to it, and remembers as much of it as there is `memory` for, in bytes. The
    /// hits are the same for any memory, and for any order of rays and number of threads; with less of it, more is
    /// compiled again.
    ///
    /// # Errors
    /// If an expression at the root of the graph has no usable value. Of others, [`Tracer::take_fault`] tells.
    pub fn on_demand(graph: Graph, bounds: StateBounds, memory: usize) -> Result<Self, EvalError> {
        let blocks = OnDemand::new(graph, bounds, memory)?;
        Ok(Self { blocks: Blocks::OnDemand(Box::new(blocks)), detail: 0.0, level: Level::new() })
    }

    /// The same with all boxes open: each ray is tested against every primitive of the unfolded tree. It has the same hits,
    /// to the last bit; tests show by it that boxes change what a ray costs and nothing else.
    ///
    /// # Panics
    /// If the graph is compiled on demand: every ray would come to all of it.
    pub fn without_boxes(self) -> Self {
        let Blocks::Whole(whole) = self.blocks else { panic!("without boxes nothing is on demand") };
        let whole = Arc::into_inner(whole).expect("there is no tracer yet");
        Self { blocks: Blocks::Whole(Arc::new(whole.without_boxes())), ..self }
    }

    /// Looks into nothing that is smaller than so many pixels: its box stands for it, and stops as many of the rays as what
    /// is in it would. A silhouette is then off by no more than that. 0 is to look into everything, which recursion that
    /// never ends does not allow. What is compiled at once is measured for that, which takes about as much time and
    /// memory again; the box of what is compiled on demand stops all rays.
    pub fn with_detail(self, pixels: f64) -> Self {
        let blocks = match self.blocks {
            Blocks::Whole(whole) if pixels > 0.0 => {
                let whole = Arc::into_inner(whole).expect("there is no tracer yet").with_parts();
                let found = whole.survey(self.level);
                Blocks::Whole(Arc::new(whole.with_looks(found)))
            }
            Blocks::OnDemand(source) => Blocks::OnDemand(Box::new(source.for_rays(pixels <= 0.0))),
            blocks @ Blocks::Whole(_) => blocks,
        };
        Self { blocks, detail: pixels, ..self }
    }

    /// The memory of the acceleration structure, in bytes: where it is made on demand, of what is remembered now.
    pub fn bytes(&self) -> usize {
        match &self.blocks {
            Blocks::Whole(whole) => whole.bytes(),
            Blocks::OnDemand(source) => source.bytes(),
        }
    }

    /// A tracer; each thread has its own.
    pub fn tracer(&self) -> Tracer<'_> {
        let mut tracer = Tracer {
            level: self.level,
            detail: self.detail,
            held: Held::new(&self.blocks),
            packet: Packet::default(),
            single: Single::default(),
            hits: Hits::new(),
            solids: Solids::default(),
            faces: Faces::default(),
            root: Entries::default(),
            entries: Entries::default(),
            counters: Counters::default(),
            items: Vec::new(),
            paints: Vec::new(),
            together: Together::default(),
            coat: None,
            last: None,
        };
        tracer.root.root(&tracer.held);
        tracer.set_footprint(Footprint::LINE);
        tracer
    }
}

/// Traces rays through a compiled graph.
#[derive(Debug)]
pub struct Tracer<'a> {
    level: Level,
    detail: f64,
    held: Held<'a>,
    packet: Packet,
    single: Single,
    hits: Hits,
    solids: Solids,
    faces: Faces,
    /// Where rays begin, and those of the last beam.
    root: Entries,
    entries: Entries,
    counters: Counters,
    /// Items on a way and the paints of items, with their blocks.
    items: Vec<(u32, u32)>,
    paints: Vec<(u32, u32)>,
    together: Together,
    /// That of the last hit: neighbouring rays often hit the same item.
    coat: Option<Coat>,
    /// What was named last.
    last: Option<Place>,
}

/// What all that is painted on the way to a place makes of its surface.
#[derive(Clone, Copy, Debug)]
struct Coat {
    place: Place,
    surface: Surface,
    depth: u32,
}

impl Tracer<'_> {
    /// Says how large a pixel is along the next rays. What is smaller than the share of it that the scene was given as
    /// [detail](Accelerated::with_detail) is not looked into: its box is met, and shows a primitive of the part that is drawn
    /// by chance. Below the right operand of \\ it is left out, so that nothing is cut off but what really is.
    ///
    /// A tracer begins with rays that are lines. Of what is compiled on demand, parts are not looked into that are smaller
    /// than 10⁻¹² of the distance and of the whole.
    pub fn set_footprint(&mut self, pixel: Footprint) {
        let finest = self.held.finest();
        // What no ray has met has no size.
        let share = |size: f64| if self.detail > 0.0 { self.detail * size } else { 0.0 };
        let small = Footprint {
            width: share(pixel.width).max(finest.width),
            spread: share(pixel.spread).max(finest.spread),
        };
        if small == Footprint::LINE {
            self.hits.detail = None;
        } else {
            self.hits.detail.get_or_insert_with(Detail::new).set_footprint(small);
        }
    }

    /// The first hit of a ray, as [`Walk::nearest`](crate::Walk::nearest).
    pub fn nearest(&mut self, ray: &Ray) -> Option<Hit> {
        self.counters.rays += 1;
        self.nearest_alone(ray)
    }

    fn nearest_alone(&mut self, ray: &Ray) -> Option<Hit> {
        self.trace_one(ray, f64::INFINITY, Ask::Nearest);
        let place = self.hits.found(0)?;
        let place = self.face(place, ray, self.hits.t.0[0]);
        self.last = Some(place);
        self.hit(0, place, ray)
    }

    /// How far up to [`PACKET`] rays go: the parameters of their first hits, infinite for those that hit nothing. What is
    /// hit there is not asked, which takes about as long again.
    ///
    /// # Panics
    /// If there are more.
    pub fn reach_of(&mut self, rays: &[Ray]) -> [f64; PACKET] {
        self.counters.rays += rays.len() as u64;
        self.reach_from(None, rays)
    }

    /// The same for rays of a beam, as [`nearest_within`](Self::nearest_within).
    ///
    /// # Panics
    /// If there are more.
    pub fn reach_within(&mut self, beam: &Beam, rays: &[Ray]) -> [f64; PACKET] {
        self.reach_from(Some(beam), rays)
    }

    fn reach_from(&mut self, beam: Option<&Beam>, rays: &[Ray]) -> [f64; PACKET] {
        self.counters.rays += rays.len() as u64;
        if self.trace_packet(beam, rays, |_| f64::INFINITY, Ask::Nearest) {
            return self.hits.t.0;
        }
        let mut reach = [f64::INFINITY; PACKET];
        for (ray, reach) in rays.iter().zip(&mut reach) {
            self.trace_one(ray, f64::INFINITY, Ask::Nearest);
            *reach = self.hits.t.0[0];
        }
        reach
    }

    /// The first hits of up to [`PACKET`] rays.
    ///
    /// # Panics
    /// If there are more.
    pub fn nearest_of(&mut self, rays: &[Ray], found: &mut [Option<Hit>]) {
        self.nearest_from(None, rays, found);
    }

    /// The same for rays of a beam; others may miss what they would meet. The way that all rays of the beam have in common
    /// is gone once for all calls with the same beam that follow each other, and is no part of what is counted.
    ///
    /// # Panics
    /// If there are more.
    pub fn nearest_within(&mut self, beam: &Beam, rays: &[Ray], found: &mut [Option<Hit>]) {
        self.nearest_from(Some(beam), rays, found);
    }

    fn nearest_from(&mut self, beam: Option<&Beam>, rays: &[Ray], found: &mut [Option<Hit>]) {
        self.counters.rays += rays.len() as u64;
        if self.trace_packet(beam, rays, |_| f64::INFINITY, Ask::Nearest) {
            found.fill(None);
            return self.hits_of(rays, found);
        }
        for (ray, found) in rays.iter().zip(found) {
            *found = self.nearest_alone(ray);
        }
    }

    /// Whether a ray meets the solid at 0 < t < `end`.
    pub fn occluded(&mut self, ray: &Ray, end: f64) -> bool {
        self.counters.shadow_rays += 1;
        self.trace_one(ray, end, Ask::Any);
        self.hits.found(0).is_some()
    }

    /// Which of up to [`PACKET`] rays meet the solid before their ends, as a set of bits.
    ///
    /// # Panics
    /// If there are more.
    pub fn occluded_of(&mut self, rays: &[Ray], ends: &[f64]) -> u32 {
        self.counters.shadow_rays += rays.len() as u64;
        let is_together = self.trace_packet(None, rays, |lane| ends[lane], Ask::Any);
        let mut is_met = |lane: usize| {
            if is_together {
                return self.hits.found(lane).is_some();
            }
            self.trace_one(&rays[lane], ends[lane], Ask::Any);
            self.hits.found(0).is_some()
        };
        (0..rays.len()).filter(|lane| is_met(*lane)).fold(0, |set, lane| set | 1 << lane)
    }

    fn trace_one(&mut self, ray: &Ray, end: f64, ask: Ask) {
        let Self { level, held, single, hits, solids, entries, coat, .. } = self;
        if held.renew() {
            entries.forget();
        }
        *coat = None;
        hits.clear([end; PACKET]);
        let Some(start) = Single::start(held, ray) else { return };
        let work = Work::default();
        let has_detail = hits.detail.is_some();
        let mut inquiry = Inquiry { held, ask, hits, solids, work };
        dispatch!(*level, simd => {
            if has_detail {
                single.trace::<_, true>(simd, &mut inquiry, 0, start);
            } else {
                single.trace::<_, false>(simd, &mut inquiry, 0, start);
            }
        });
        let work = inquiry.work;
        self.note(work);
    }

    /// Traces rays together. If they come to more than is held at one time, each has to go alone, and it says `false`.
    fn trace_packet(
        &mut self,
        beam: Option<&Beam>,
        rays: &[Ray],
        end: impl Fn(usize) -> f64,
        ask: Ask,
    ) -> bool {
        assert!(rays.len() <= PACKET, "a packet has {PACKET} rays");
        let Self { level, held, packet, hits, solids, root, entries, coat, .. } = self;
        if held.renew() {
            entries.forget();
        }
        *coat = None;
        let Some(last) = rays.len().checked_sub(1) else {
            hits.clear([0.0; PACKET]);
            return true;
        };
        let entries = match beam {
            Some(beam) => {
                entries.aim(held, hits, beam);
                &*entries
            }
            None => &*root,
        };
        held.go_together();
        hits.clear(std::array::from_fn(|lane| end(lane.min(last))));
        hits.follow(&entries.trail);
        for lane in 0..PACKET {
            packet.rays().set(lane, &rays[lane.min(last)]);
        }
        let has_detail = hits.detail.is_some();
        let lanes = u32::MAX >> (31 - last);
        let work = Work::default();
        let mut inquiry = Inquiry { held, ask, hits, solids, work };
        dispatch!(*level, simd => {
            if has_detail {
                packet.trace::<_, true>(simd, &mut inquiry, lanes, entries);
            } else {
                packet.trace::<_, false>(simd, &mut inquiry, lanes, entries);
            }
        });
        let work = inquiry.work;
        let is_together = !held.is_too_much();
        self.note(work);
        is_together
    }

    fn note(&mut self, work: Work) {
        let solids = std::mem::take(&mut self.solids.work);
        self.counters.box_tests += work.boxes + solids.boxes;
        self.counters.primitive_tests += work.primitives + solids.primitives;
    }

    /// What a lane has hit at a place. Inlined, as hits are too large to be moved for nothing.
    #[inline(always)]
    fn hit(&mut self, lane: usize, place: Place, world_ray: &Ray) -> Option<Hit> {
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
        let normal = crate::shapes::normal_at(shape, &ray, t)?;
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
    fn coat(&mut self, place: Place) -> &Coat {
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

    /// The face of the solid at a place that a ray of the world meets at t; of anything else, itself.
    #[inline(always)]
    fn face(&mut self, place: Place, world_ray: &Ray, t: f64) -> Place {
        let Self { level, held, hits, faces, .. } = self;
        if place.is_small {
            return place;
        }
        let item = held.item(hits.block(place.way), place.item);
        let Content::Solid(_) = item.content else { return place };
        let face = dispatch!(*level, simd => faces.find(simd, held, hits, place, world_ray, t));
        face.expect("a solid has a face where a ray meets it")
    }

    /// A ray of the world in the frame of an item.
    fn descend(&mut self, place: Place, world_ray: &Ray) -> Ray {
        let Self { held, hits, items, .. } = self;
        hits.items(place, items);
        let into =
            |ray, (block, item): &(u32, u32)| transform(&ray, &held.item(*block, *item).item_from_super);
        items.iter().fold(*world_ray, into)
    }

    /// The state of the last S-node on the way to what was hit last, by its place among all states.
    pub(crate) fn last_symbol(&self) -> Option<u32> {
        let place = self.last?;
        let symbol = |(block, item)| *self.held.block(block).symbols.get(item as usize)?;
        self.hits.upwards(place).find_map(symbol)
    }

    /// What was wrong with a state that a ray came to since this was asked last. Hits since then may be wrong. Where a graph
    /// is not compiled on demand, nothing can be.
    pub fn take_fault(&mut self) -> Option<EvalError> {
        self.held.take_fault()
    }

    /// What was counted since the tracer was made or its counters were taken.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// What was counted since the tracer was made or its counters were taken.
    pub fn take_counters(&mut self) -> Counters {
        std::mem::take(&mut self.counters)
    }
}
