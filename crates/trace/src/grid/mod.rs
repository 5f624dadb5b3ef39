//! The grid of \[TRAX95\] §4: rays enter the graph at states further down.
//!
//! "Now a ray can entry the CSG graph to an advanced state, which prevents it to run through all the cycles that are
//! necessary to reach this state." A uniform grid lies over the solid; its voxels hold [entry states](fill). A ray goes
//! through [the voxels](lattice) from front to back, by 3DDDA \[FUJI86\], and in each asks the entry states that it has not
//! asked before. The first hit that lies before the end of its voxel is the nearest.
//!
//! An entry state is asked by the [reference walk](crate::Walk), as the paper has it, after the ray has met the box of the
//! state; the hyper boxes on the way down are those of all states of a node and therefore larger.

mod fill;
mod lattice;

use csg_graph::{EvalError, Graph, State};
use csg_graph_bounds::{ExactBoxes, HyperBoxes};

use self::fill::{EntryState, Voxels};
use crate::fast::lanes::transform;
use crate::{Counters, Hit, Ray, Surface, Walk, slab, walk};

/// A grid of entry states over a graph.
///
/// It finds the hits of the [`Walk`]: t and normal differ only by how the products of transformations are rounded.
///
/// ```
/// use csg_graph::{Expr, GraphBuilder, Operator, PrimitiveKind, TransformKind};
/// use csg_graph_bounds::{Limits, exact};
/// use csg_graph_trace::{Grid, Ray};
/// use glam::DVec3;
///
/// // T -> sphere | {n = n - 1} move(3, 0, 0) T, a thousand times
/// let mut builder = GraphBuilder::new();
/// let n = builder.param("n", 1000.0);
/// let symbol = builder.symbol("T");
/// let sphere = builder.primitive(PrimitiveKind::Sphere, []);
/// let moved = builder.transform(TransformKind::Move, [3.0.into(), 0.0.into(), 0.0.into()], symbol);
/// let rest = builder.calculate([(n, Expr::from(n) - 1.0)], moved);
/// let both = builder.operator(Operator::Union, sphere, rest);
/// builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(1.0), 1.0, 2.0)), [both, sphere]);
/// let graph = builder.finish(symbol)?;
///
/// let grid = Grid::new(&graph, exact(&graph, &Limits::default())?, Some(1000), Grid::DEFAULT_BUDGET)?;
/// let mut tracer = grid.tracer();
/// let hit = tracer.nearest(&Ray { origin: DVec3::new(2400.0, 0.0, 9.0), direction: -DVec3::Z });
/// assert_eq!(hit.expect("the 801st sphere is there").point, DVec3::new(2400.0, 0.0, 1.0));
/// // Instead of all spheres before, the walk met one.
/// assert!(tracer.take_counters().primitive_tests < 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Grid<'a> {
    graph: &'a Graph,
    boxes: HyperBoxes,
    voxels: Voxels,
}

impl<'a> Grid<'a> {
    /// Memory that a grid takes if nobody says how much it may take, in bytes.
    pub const DEFAULT_BUDGET: usize = 1 << 24;

    /// Fills a grid over a graph with the boxes that belong to it, with so many voxels along its longest side, or as many
    /// as suit the number of primitives.
    ///
    /// Takes `budget` bytes at most, but for a few hundred and the hyper boxes: with less memory, there are fewer voxels,
    /// and the graph is entered less far down.
    ///
    /// # Errors
    /// If an expression of the graph has no usable value.
    pub fn new(
        graph: &'a Graph,
        boxes: ExactBoxes<Graph>,
        resolution: Option<u32>,
        budget: usize,
    ) -> Result<Self, EvalError> {
        let voxels = Voxels::new(graph, &boxes, resolution, budget)?;
        Ok(Self { graph, boxes: boxes.into_hyper_boxes(), voxels })
    }

    /// The memory of the grid, in bytes.
    pub fn bytes(&self) -> usize {
        self.voxels.bytes()
    }

    /// How many voxels there are along the longest side.
    pub fn resolution(&self) -> usize {
        self.voxels.lattice.resolution()
    }

    /// How many entry states there are.
    pub fn entries(&self) -> usize {
        self.voxels.entries.len()
    }

    pub(crate) fn graph(&self) -> &'a Graph {
        self.graph
    }

    /// A tracer; each thread has its own.
    pub fn tracer(&self) -> GridTracer<'_> {
        GridTracer {
            voxels: &self.voxels,
            walk: Walk::new(self.graph, Some(&self.boxes)),
            asked: vec![0; self.voxels.entries.len()],
            ray_number: 0,
            limit: f64::INFINITY,
            best: None,
            last_symbol: None,
        }
    }
}

/// Traces rays through a grid.
#[derive(Debug)]
pub struct GridTracer<'a> {
    voxels: &'a Voxels,
    walk: Walk<'a>,
    /// The number of the last ray that asked each entry state.
    asked: Vec<u64>,
    ray_number: u64,
    /// Where the first hit so far is, or the ray ends.
    limit: f64,
    /// That hit in the frame of its entry state, which has the number.
    best: Option<(u32, Hit)>,
    /// The state of the last S-node on the path to it.
    last_symbol: Option<u32>,
}

impl<'a> GridTracer<'a> {
    /// The first hit of a ray, as [`Walk::nearest`].
    pub fn nearest(&mut self, ray: &Ray) -> Option<Hit> {
        self.walk.counters_mut().rays += 1;
        self.trace(ray, f64::INFINITY, Self::asks_nearest);
        let (entry, hit) = self.best.take()?;
        let entry = &self.voxels.entries[entry as usize];
        let normal = entry.state_from_world.matrix3.transpose() * hit.normal;
        let normal = walk::unit(normal).unwrap_or(-ray.direction);
        Some(Hit { point: ray.at(hit.t), normal, depth: entry.depth + hit.depth, ..hit })
    }

    /// Whether a ray meets the solid at 0 < t < `end`.
    pub fn occluded(&mut self, ray: &Ray, end: f64) -> bool {
        self.walk.counters_mut().shadow_rays += 1;
        self.trace(ray, end, Self::meets)
    }

    /// The walks that answer.
    pub(crate) fn walk_mut(&mut self) -> &mut Walk<'a> {
        &mut self.walk
    }

    /// The state of the last S-node on the path to the last hit, if there is one and the walk numbers states.
    pub(crate) fn last_symbol(&self) -> Option<u32> {
        self.last_symbol
    }

    /// What was counted since the tracer was made or its counters were taken. Recursion is counted from entry states on.
    pub fn counters(&self) -> &Counters {
        self.walk.counters()
    }

    /// The counters, which start again from zero.
    pub fn take_counters(&mut self) -> Counters {
        self.walk.take_counters()
    }

    /// Asks entry states from front to back, each once, until one says that this is enough, which is the answer, or what
    /// follows is behind the limit.
    fn trace(&mut self, ray: &Ray, end: f64, ask: impl Fn(&mut Self, &Ray, u32) -> bool) -> bool {
        let voxels = self.voxels;
        (self.limit, self.best) = (end, None);
        self.ray_number += 1;
        if !voxels.lattice.sees(ray) {
            return (0_u32..).zip(&voxels.entries).any(|(entry, _)| ask(self, ray, entry));
        }
        for (voxel, leaves) in voxels.lattice.march(ray) {
            for entry in voxels.of(voxel) {
                // Mailboxing: an entry state may be in many voxels on the way.
                let asked = &mut self.asked[*entry as usize];
                if std::mem::replace(asked, self.ray_number) != self.ray_number && ask(self, ray, *entry) {
                    return true;
                }
            }
            if self.limit <= leaves {
                break;
            }
        }
        false
    }

    /// Takes the first hit in an entry state if it is before the best one. There may be a better one elsewhere.
    #[expect(clippy::float_cmp, reason = "what differs by an ulp is not at the same t")]
    fn asks_nearest(&mut self, ray: &Ray, entry: u32) -> bool {
        if let Some((state, ray, surface)) = self.enter(ray, entry) {
            let hit = self.walk.nearest_below(state, &ray, self.limit.next_up(), surface).expect(EVALUATED);
            // Of two at the same t, the left one in the graph counts, which voxels need not meet first.
            let is_left = self.best.is_some_and(|(best, _)| entry < best);
            if let Some(hit) = hit
                && (hit.t < self.limit || hit.t == self.limit && is_left)
            {
                self.limit = hit.t;
                self.best = Some((entry, hit));
                self.last_symbol = self.walk.last_symbol().or(self.voxels.entries[entry as usize].symbol);
            }
        }
        false
    }

    /// Whether anything in an entry state is before the limit.
    fn meets(&mut self, ray: &Ray, entry: u32) -> bool {
        self.enter(ray, entry).is_some_and(|(state, ray, _)| {
            self.walk.occluded_below(state, &ray, self.limit).expect(EVALUATED)
        })
    }

    /// An entry state, the ray in its frame and the surface there, if the ray meets its box before the limit.
    fn enter(&mut self, ray: &Ray, entry: u32) -> Option<(&'a State, Ray, Surface)> {
        let EntryState { state, state_from_world, surface, .. } = &self.voxels.entries[entry as usize];
        let (state, bounds) = &self.voxels.states[*state as usize];
        let ray = transform(ray, state_from_world);
        let met = slab::interval(bounds, &ray).is_some_and(|(near, far)| far >= 0.0 && near <= self.limit);
        let counters = self.walk.counters_mut();
        counters.box_tests += 1;
        counters.boxes_missed += u64::from(!met);
        met.then_some((state, ray, *surface))
    }
}

/// Why the walk has no errors here.
const EVALUATED: &str = "all states were evaluated when they were bounded";
