//! One thread's tracer: questions about rays, alone and together, and how each begins and ends.

use std::sync::Arc;

use csg_graph::EvalError;
use fearless_simd::{Level, dispatch};

use super::PACKET;
use super::batch::Batch;
use super::blocks::Blocks;
use super::compiled::Compiled;
use super::detail::{Detail, Footprint};
use super::entry::Entries;
use super::face::Faces;
use super::held::Held;
use super::hits::{Hits, Place};
use super::inquiry::{Ask, Inquiry, Work};
use super::packet::Packet;
use super::resolve::Coat;
use super::single::Single;
use super::solid::Solids;
use super::together::Together;
use super::tree::Child;
use crate::{Counters, Hit, Ray};

/// Traces rays through a compiled graph.
///
/// Queries do not fail. Where one has come to what has no value, or to no end, [`Tracer::take_fault`] says so; until it is asked,
/// the queries that follow may find nothing.
#[derive(Debug)]
pub struct Tracer<'a> {
    pub(super) level: Level,
    detail: f64,
    pub(super) held: Held<'a>,
    pub(super) packet: Packet,
    single: Single,
    pub(super) hits: Hits,
    pub(super) solids: Solids,
    pub(super) faces: Faces,
    /// Where rays begin, and those of the last beam.
    root: Entries,
    entries: Entries,
    counters: Counters,
    /// Items on a way and the paints of items, with their blocks.
    pub(super) items: Vec<(u32, u32)>,
    pub(super) paints: Vec<(u32, u32)>,
    pub(super) together: Together,
    /// That of the last hit: neighbouring rays often hit the same item.
    pub(super) coat: Option<Coat>,
    /// What was named last.
    pub(super) last: Option<Place>,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(held: Held<'a>, level: Level, detail: f64) -> Self {
        let mut tracer = Self {
            level,
            detail,
            held,
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

    /// One for lines through a block on its own that look into nothing smaller than a `width`, and of which small parts stop
    /// as many as is found of these in so many rounds.
    pub(super) fn of_lines(source: &'a Blocks, block: Arc<Compiled>, rounds: u8, width: f64) -> Self {
        let mut tracer = Self::new(Held::alone(source, block, rounds), Level::new(), 1.0);
        tracer.set_footprint(Footprint { width, spread: 0.0 });
        tracer
    }

    /// Whether a line is stopped anywhere, or below a node of the first super-node, or by an item, in the frame of its own. What
    /// is wrong there stops it: how much of it would is not to be known.
    pub(super) fn is_stopped(&mut self, line: &Ray, child: Option<Child>) -> bool {
        self.trace_from(line, f64::INFINITY, Ask::Any, child);
        self.hits.found(0).is_some() || self.held.is_void()
    }
}

impl Tracer<'_> {
    /// Says how large a pixel is along the next rays. What is smaller than the share of it that the scene was given as
    /// [detail](super::Accelerated::with_detail) is not looked into: its box is met, and shows a primitive of the part that
    /// is drawn by chance. Below the right operand of \\ it is left out, so that nothing is cut off but what really is.
    ///
    /// Of rays that are traced together, one says for all what is small, so that a hit depends on which these are. A tracer
    /// begins with rays that are lines. In any case parts are not looked into that are smaller than
    /// [`Accelerated::FINEST`](super::Accelerated::FINEST) of the distance and of the whole, or 10⁻¹² of what is compiled
    /// on demand.
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
            self.hits.detail.get_or_insert_with(Detail::new).set_footprint(small, finest);
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
        let place = self.face(place, ray, self.hits.t.0[0])?;
        self.last = Some(place);
        self.hit(0, place, ray)
    }

    /// How far up to [`PACKET`] rays go: the parameters of their first hits, infinite for those that hit nothing. What is
    /// hit there is not asked, which takes about as long again.
    ///
    /// # Panics
    /// If there are more.
    pub fn reach_of<'r>(&mut self, batch: impl Into<Batch<'r>>) -> [f64; PACKET] {
        let batch = batch.into();
        self.counters.rays += batch.rays.len() as u64;
        if self.trace_packet(batch, [f64::INFINITY; PACKET], Ask::Nearest) {
            return self.hits.t.0;
        }
        let mut reach = [f64::INFINITY; PACKET];
        for (ray, reach) in batch.rays.iter().zip(&mut reach) {
            self.trace_one(ray, f64::INFINITY, Ask::Nearest);
            *reach = self.hits.t.0[0];
        }
        reach
    }

    /// The first hits of up to [`PACKET`] rays.
    ///
    /// # Panics
    /// If there are more, or not as many places for hits.
    pub fn nearest_of<'r>(&mut self, batch: impl Into<Batch<'r>>, found: &mut [Option<Hit>]) {
        let batch = batch.into();
        assert_eq!(batch.rays.len(), found.len(), "a place for each hit");
        self.counters.rays += batch.rays.len() as u64;
        if self.trace_packet(batch, [f64::INFINITY; PACKET], Ask::Nearest) {
            found.fill(None);
            return self.hits_of(batch.rays, found);
        }
        for (ray, found) in batch.rays.iter().zip(found) {
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
    /// If there are more, or not as many ends.
    pub fn occluded_of(&mut self, rays: &[Ray], ends: &[f64]) -> u32 {
        assert_eq!(rays.len(), ends.len(), "an end for each ray");
        self.counters.shadow_rays += rays.len() as u64;
        // Lanes without a ray repeat the last one.
        let end = |lane: usize| ends.get(lane).or(ends.last()).copied().unwrap_or(f64::INFINITY);
        let is_together = self.trace_packet(rays.into(), std::array::from_fn(end), Ask::Any);
        let mut is_met = |lane: usize| {
            if is_together {
                return self.hits.found(lane).is_some();
            }
            self.trace_one(&rays[lane], ends[lane], Ask::Any);
            self.hits.found(0).is_some()
        };
        (0..rays.len()).filter(|lane| is_met(*lane)).fold(0, |set, lane| set | 1 << lane)
    }

    /// Begins a question. What the last one has left may be of blocks that are let go of now.
    fn begin(&mut self) {
        if self.held.renew() {
            self.entries.forget();
        }
        self.coat = None;
    }

    fn trace_one(&mut self, ray: &Ray, end: f64, ask: Ask) {
        self.trace_from(ray, end, ask, None);
    }

    #[inline(always)]
    fn trace_from(&mut self, ray: &Ray, end: f64, ask: Ask, child: Option<Child>) {
        self.begin();
        let Self { level, held, single, hits, solids, .. } = self;
        hits.clear([end; PACKET]);
        let has_detail = hits.detail.is_some();
        let Some(start) = Single::start(held, ray, child) else { return };
        let work = Work::default();
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

    /// Traces rays together. If they come to more than is held at one time, or their lengths are too different, each has to go
    /// alone, and it says `false`.
    #[inline(never)]
    fn trace_packet(&mut self, batch: Batch<'_>, ends: [f64; PACKET], ask: Ask) -> bool {
        let Batch { rays, beam } = batch;
        assert!(rays.len() <= PACKET, "a packet has {PACKET} rays");
        if !batch.has_one_scale() {
            return false;
        }
        self.begin();
        let Self { level, held, packet, hits, solids, root, entries, .. } = self;
        let Some(last) = rays.len().checked_sub(1) else {
            hits.clear([f64::INFINITY; PACKET]);
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
        hits.clear(ends);
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

    /// The state of the last S-node on the way to what was hit last, by its place among all states.
    pub(crate) fn last_symbol(&self) -> Option<u32> {
        let place = self.last?;
        let symbol = |(block, item)| *self.held.block(block).symbols.get(item as usize)?;
        self.hits.upwards(place).find_map(symbol)
    }

    /// What was wrong with a state that a ray came to since this was asked last. Hits since then may be wrong. Where a graph
    /// is not compiled on demand, nothing can be, unless a ray comes to too many parts that lie in each other.
    pub fn take_fault(&mut self) -> Option<EvalError> {
        self.held.take_fault()
    }

    /// What was counted since the tracer was made or its counters were taken.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The counters, which start again from zero.
    pub fn take_counters(&mut self) -> Counters {
        std::mem::take(&mut self.counters)
    }
}
