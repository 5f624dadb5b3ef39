//! The fast engine: the graph compiled into [super-nodes](compile), traced in [packets](packet).
//!
//! It finds the hits of the [reference walk](crate::Walk): t and normal differ only by how the products of transformations
//! are rounded. Where the walk asks one node after the other, evaluating its expressions each time, this one has
//! evaluated each state once, and goes down a few wide trees. It is in these parts:
//!
//! - [`compile`]: states to super-nodes and solids;
//! - [`tree`], [`frame`], [`point`]: their boxes in single precision, and what is tested against them;
//! - [`packet`], [`single`]: the first hit of rays together and alone; [`lanes`] and [`shapes`] are their arithmetic;
//! - [`solid`], [`face`]: the first boundary of the results of ∩ and \\, and whose face it is;
//! - [`hits`]: what was hit, and the way to it.

pub(crate) mod compile;
mod face;
mod frame;
mod hits;
pub(crate) mod lanes;
mod packet;
mod point;
mod shapes;
mod single;
mod solid;
mod tree;

use csg_graph::{EvalError, Graph};
use csg_graph_bounds::ExactBoxes;
use fearless_simd::{Level, Simd, dispatch};

use self::compile::{Compiled, Content};
use self::face::Faces;
use self::hits::{Hits, Place};
use self::lanes::transform;
use self::packet::Packet;
use self::single::Single;
use self::solid::Solids;
use crate::{Counters, Hit, Ray, Surface, walk};

/// Rays that are traced together.
pub const PACKET: usize = lanes::LANES;

/// The side of a square of as many pixels.
pub(crate) const SIDE: u32 = 4;

/// A graph compiled for tracing.
#[derive(Debug)]
pub struct Accelerated {
    compiled: Compiled,
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
    compiled: &'t Compiled,
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

    /// Asks a solid, an item of a super-node, about a ray in the frame of that.
    #[inline(always)]
    fn ask_solid<S: Simd>(&mut self, simd: S, lane: usize, ray: &Ray, solid: u32, place: Place) {
        let end = self.hits.t.0[lane];
        let inside = transform(ray, &self.compiled.items[place.item as usize].item_from_super);
        let first = self.solids.first(simd, self.compiled, self.hits, (solid, place), &inside, end);
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
        let compiled = Compiled::new(graph, boxes, budget)?;
        Ok(Self { compiled, level: Level::new() })
    }

    /// The same with all boxes open: each ray is tested against every primitive of the unfolded tree. It has the same hits,
    /// to the last bit; tests show by it that boxes change what a ray costs and nothing else.
    pub fn without_boxes(mut self) -> Self {
        for node in &mut self.compiled.nodes {
            let [lower, upper] = [f32::NEG_INFINITY, f32::INFINITY].map(|plane| [plane; tree::WIDTH]);
            node.planes = [lower, lower, lower, upper, upper, upper];
        }
        for ball in &mut self.compiled.supers {
            ball.reach = f64::INFINITY;
        }
        self
    }

    /// The memory of the acceleration structure, in bytes.
    pub fn bytes(&self) -> usize {
        self.compiled.bytes()
    }

    /// A tracer; each thread has its own.
    pub fn tracer(&self) -> Tracer<'_> {
        Tracer {
            scene: self,
            packet: Packet::default(),
            single: Single::default(),
            hits: Hits::new(),
            solids: Solids::default(),
            faces: Faces::default(),
            counters: Counters::default(),
            items: Vec::new(),
            paints: Vec::new(),
            last: None,
        }
    }
}

/// Traces rays through a compiled graph.
#[derive(Debug)]
pub struct Tracer<'a> {
    scene: &'a Accelerated,
    packet: Packet,
    single: Single,
    hits: Hits,
    solids: Solids,
    faces: Faces,
    counters: Counters,
    items: Vec<u32>,
    paints: Vec<u32>,
    /// What was named last.
    last: Option<Place>,
}

impl Tracer<'_> {
    /// The first hit of a ray, as [`Walk::nearest`](crate::Walk::nearest).
    pub fn nearest(&mut self, ray: &Ray) -> Option<Hit> {
        self.counters.rays += 1;
        self.trace_one(ray, f64::INFINITY, Ask::Nearest);
        self.hit(0, ray)
    }

    /// How far up to [`PACKET`] rays go: the parameters of their first hits, infinite for those that hit nothing. What is
    /// hit there is not asked, which takes about as long again.
    ///
    /// # Panics
    /// If there are more.
    pub fn reach_of(&mut self, rays: &[Ray]) -> [f64; PACKET] {
        self.counters.rays += rays.len() as u64;
        self.trace_packet(rays, |_| f64::INFINITY, Ask::Nearest);
        self.hits.t.0
    }

    /// The first hits of up to [`PACKET`] rays.
    ///
    /// # Panics
    /// If there are more.
    pub fn nearest_of(&mut self, rays: &[Ray], found: &mut [Option<Hit>]) {
        self.counters.rays += rays.len() as u64;
        self.trace_packet(rays, |_| f64::INFINITY, Ask::Nearest);
        for (lane, (ray, found)) in rays.iter().zip(found).enumerate() {
            *found = self.hit(lane, ray);
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
        self.trace_packet(rays, |lane| ends[lane], Ask::Any);
        (0..rays.len()).filter(|lane| self.hits.found(*lane).is_some()).fold(0, |set, lane| set | 1 << lane)
    }

    fn trace_one(&mut self, ray: &Ray, end: f64, ask: Ask) {
        let Self { scene, single, hits, solids, .. } = self;
        hits.clear([end; PACKET]);
        let Some(start) = Single::start(&scene.compiled, ray) else { return };
        let work = Work::default();
        let mut inquiry = Inquiry { compiled: &scene.compiled, ask, hits, solids, work };
        dispatch!(scene.level, simd => {
            single.trace(simd, &mut inquiry, 0, start);
        });
        let work = inquiry.work;
        self.note(work);
    }

    fn trace_packet(&mut self, rays: &[Ray], end: impl Fn(usize) -> f64, ask: Ask) {
        assert!(rays.len() <= PACKET, "a packet has {PACKET} rays");
        let Self { scene, packet, hits, solids, .. } = self;
        let Some(last) = rays.len().checked_sub(1) else { return hits.clear([0.0; PACKET]) };
        hits.clear(std::array::from_fn(|lane| end(lane.min(last))));
        for lane in 0..PACKET {
            packet.rays().set(lane, &rays[lane.min(last)]);
        }
        let lanes = u32::MAX >> (31 - last);
        let work = Work::default();
        let mut inquiry = Inquiry { compiled: &scene.compiled, ask, hits, solids, work };
        dispatch!(scene.level, simd => {
            packet.trace(simd, &mut inquiry, lanes);
        });
        let work = inquiry.work;
        self.note(work);
    }

    fn note(&mut self, work: Work) {
        let solids = std::mem::take(&mut self.solids.work);
        self.counters.box_tests += work.boxes + solids.boxes;
        self.counters.primitive_tests += work.primitives + solids.primitives;
    }

    /// What a lane has hit. Inlined, as hits are too large to be moved for nothing.
    #[inline(always)]
    fn hit(&mut self, lane: usize, world_ray: &Ray) -> Option<Hit> {
        let t = self.hits.t.0[lane];
        let place = self.hits.found(lane).map(|place| self.face(place, world_ray, t))?;
        self.last = Some(place);
        let compiled = &self.scene.compiled;
        let item = &compiled.items[place.item as usize];
        let Content::Shape(shape) = item.content else {
            unreachable!("what is hit is a face of a primitive")
        };
        let ray = match self.hits.ray_at(lane, place) {
            Some(super_ray) => transform(super_ray, &item.item_from_super),
            None => self.descend(place, world_ray),
        };
        // By the same arithmetic as before.
        let end = crate::shapes::boundary(&compiled.shapes[shape as usize], &ray, t)?;
        let mut normal = if place.turned { -end.normal } else { end.normal };
        let mut depth = 0;
        self.paints.clear();
        for item in self.hits.upwards(place) {
            let item = &compiled.items[item as usize];
            normal = item.item_from_super.matrix3.transpose() * normal;
            depth += item.depth;
            self.paints.extend(item.paint);
        }
        let mut surface = Surface::default();
        for paint in self.paints.iter().rev() {
            let terms = &compiled.paints[*paint as usize];
            terms.iter().for_each(|(term, value)| surface.set(*term, *value));
        }
        let normal = walk::unit(normal).unwrap_or(-world_ray.direction);
        Some(Hit { t, point: world_ray.at(t), normal, surface, node: item.node, depth })
    }

    /// The face of the solid at a place that a ray of the world meets at t; of anything else, itself.
    #[inline(always)]
    fn face(&mut self, place: Place, world_ray: &Ray, t: f64) -> Place {
        let Self { scene, hits, faces, .. } = self;
        let compiled = &scene.compiled;
        let Content::Solid(_) = compiled.items[place.item as usize].content else { return place };
        let face = dispatch!(scene.level, simd => faces.find(simd, compiled, hits, place, world_ray, t));
        face.expect("a solid has a face where a ray meets it")
    }

    /// A ray of the world in the frame of an item.
    fn descend(&mut self, place: Place, world_ray: &Ray) -> Ray {
        let Self { scene, hits, items, .. } = self;
        hits.items(place, items);
        let into =
            |ray: Ray, item: &u32| transform(&ray, &scene.compiled.items[*item as usize].item_from_super);
        items.iter().fold(*world_ray, into)
    }

    /// The state of the last S-node on the way to what was hit last, by its place among all states.
    pub(crate) fn last_symbol(&self) -> Option<u32> {
        let symbols = &self.scene.compiled.symbols;
        let place = self.last?;
        self.hits.upwards(place).find_map(|item| symbols[item as usize])
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

#[cfg(test)]
mod tests {
    use csg_graph::{Expr, GraphBuilder, PrimitiveKind, TransformKind};
    use csg_graph_bounds::{Limits, exact};
    use fearless_simd::Simd;
    use glam::DVec3;

    use super::*;

    /// A tower of one primitive in every orientation.
    fn tower(kind: PrimitiveKind) -> Graph {
        let mut builder = GraphBuilder::new();
        let n = builder.param("n", 12.0);
        let symbol = builder.symbol("X");
        let primitive = builder.primitive(kind, []);
        let smaller = builder.transform(TransformKind::Scale, [0.8, 0.7, -0.75].map(Expr::from), symbol);
        let turned = builder.transform(TransformKind::Rot, [1.0, 2.0, 3.0, 50.0].map(Expr::from), smaller);
        let moved = builder.transform(TransformKind::Move, [0.3, -0.4, 1.0].map(Expr::from), turned);
        let rest = builder.calculate([(n, Expr::from(n) - 1.0)], moved);
        let both = builder.operator(csg_graph::Operator::Union, primitive, rest);
        builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 1.0, 2.0)), [both, primitive]);
        builder.finish(symbol).unwrap()
    }

    #[test]
    fn all_levels_of_vector_instructions_have_the_same_hits() {
        let best = Level::new();
        let levels = [
            Some(best),
            best.as_avx2().map(|simd| simd.level()),
            best.as_sse4_2().map(|simd| simd.level()),
            best.as_sse2().map(|simd| simd.level()),
        ];
        for kind in [
            PrimitiveKind::Sphere,
            PrimitiveKind::Cylinder,
            PrimitiveKind::Cone,
            PrimitiveKind::Cube,
            PrimitiveKind::Dodecahedron,
        ] {
            let graph = tower(kind);
            let mut hits: Vec<Vec<Option<Hit>>> = Vec::new();
            for level in levels.into_iter().flatten() {
                let boxes = exact(&graph, &Limits::default()).unwrap();
                let scene = Accelerated { level, ..Accelerated::new(&graph, &boxes, 4096).unwrap() };
                let mut tracer = scene.tracer();
                let mut found = Vec::new();
                for row in 0..64 {
                    let rays: Vec<Ray> = (0..PACKET)
                        .map(|column| Ray {
                            origin: DVec3::new(9.0, 7.0, 3.0),
                            direction: DVec3::new(-9.0, column as f64 * 0.3 - 9.5, row as f64 * 0.1 - 5.0),
                        })
                        .collect();
                    let mut packet = vec![None; PACKET];
                    tracer.nearest_of(&rays, &mut packet);
                    for (ray, hit) in rays.iter().zip(&packet) {
                        assert_eq!(tracer.nearest(ray), *hit, "alone and in a packet");
                    }
                    found.extend(packet);
                }
                assert!(found.iter().flatten().count() > 100, "{kind:?}");
                hits.push(found);
            }
            assert!(hits.iter().all(|found| *found == hits[0]), "{kind:?}");
        }
    }
}
