//! Measures what is seen of all small parts, before the first ray.
//!
//! Lines are drawn through the box of each node, some for each direction that is told apart. A line is followed through a
//! super-node and those that it leads to. Of what is further below it goes by what was measured there: super-nodes are
//! measured from the leaves upwards, each once, so that ever deeper recursion costs no more.
//!
//! How the children of a node stop lines together cannot be known from each alone. But it is known what their parts do, from
//! the same lines, and what the covers of the children would have it be if these were side by side, by chance, or one behind
//! the other. One number is fitted to that for each super-node.

pub(super) mod demand;
mod estimate;
mod faces;
mod lines;
pub(super) mod outline;
mod solids;
#[cfg(test)]
mod tests;

use csg_graph::AttributeTerm;
use csg_graph_bounds::Aabb;
use fearless_simd::{Level, Simd, dispatch};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use self::estimate::{Arrangement, Tally, shares};
use self::lines::{Round, Thrown, backwards};
use self::outline::flux;
use self::solids::Tracing;
use super::blocks::Blocks;
use super::compiled::{Compiled, Content, Item};
use super::cover::{self, CELLS, Cover, behind};
use super::frame::Narrow;
use super::hits::{ROOT, START};
use super::lanes::transform;
use super::look::Look;
use super::sample::Dice;
use super::single;
use super::tree::{Child, Target, WIDTH};
use crate::narrow::narrow;
use crate::{Ray, shapes};

/// Lines through the box of a super-node in each direction, unless there are too many boxes. What is above goes by what they
/// tell, where an error may come again at each level.
const LINES: usize = 192;

/// And through the box of another node.
const LINES_BELOW: usize = 8;

/// With fewer, directions are not told apart.
const FEW_LINES: usize = 4;

/// All lines through roots together, more or less, and all through other nodes.
const ALL_LINES: usize = 1 << 18;

/// Lines that are traced like rays come down to parts of that share of the size of what is measured, or less.
const SHARE: f64 = 0.1;

/// The most super-nodes that a line is followed through. Of others it goes by what was measured.
const ENTERED: usize = 64;

/// The most faces that are remembered of those that lines meet below the root of a super-node. What is above draws from them:
/// the fewer there are, the sooner all descend from one.
const SEEN: usize = 32;

/// And of those below another node.
const SEEN_BELOW: usize = 8;

/// What was measured.
pub(super) struct Surveyed {
    /// The boxes of nodes in the frames of their super-nodes.
    pub(super) bounds: Vec<Aabb>,
    pub(super) looks: Vec<Look>,
    /// The covers of nodes.
    pub(super) nodes: Vec<Cover>,
    /// Those of items; none of a primitive, also if it is alone in a super-node.
    pub(super) items: Vec<Option<Cover>>,
    pub(super) paints: Vec<Vec<(AttributeTerm, f64)>>,
}

/// Where a line comes to a child of a node, and what of it stops lines.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    t: f64,
    cover: f32,
    apart: f32,
    child: Child,
}

impl Meeting {
    #[inline(always)]
    fn new(t: f64, cover: &Cover, ray: &Ray, child: Child) -> Self {
        Self { t, cover: cover.along(ray.direction), apart: cover.apart, child }
    }
}

type Meetings = SmallVec<[Meeting; WIDTH]>;

/// Measures one super-node after the other.
struct Survey<'b> {
    block: &'b Compiled,
    level: Level,
    /// The most lines through the box of a super-node, of another node, and of a solid.
    lines: [usize; 3],
    /// Traces those through solids.
    tracing: Tracing<'b>,
    /// What is known so far.
    found: Surveyed,
    numbers: FxHashMap<Vec<(AttributeTerm, u64)>, u32>,
    /// Of a line that is followed: what is left to do, and the ray in the super-nodes that it is in.
    open: Vec<(usize, Child)>,
    frames: Vec<Narrow>,
    /// And the items of the first super-node that it has met.
    parts: Meetings,
}

impl Blocks {
    /// Measures what is seen of all nodes and items of a graph that is compiled as a whole.
    pub(super) fn survey(&self, level: Level) -> Surveyed {
        let Self::Whole { block, .. } = self else {
            unreachable!("nobody can list what is compiled on demand")
        };
        let most = |boxes: usize| (ALL_LINES / boxes.max(1)).max(2);
        let is_solid = |item: &&Item| matches!(item.content, Content::Solid(_));
        let mut survey = Survey {
            block,
            level,
            tracing: Tracing::new(self, level),
            // What is above a super-node goes by what was measured of it, however many nodes there are below.
            lines: [
                most(block.supers.len()).min(CELLS * LINES),
                most(block.nodes.len()).min(CELLS * LINES_BELOW),
                most(block.items.iter().filter(is_solid).count()).min(CELLS * solids::LINES),
            ],
            found: Surveyed {
                bounds: vec![Aabb::ALL; block.nodes.len()],
                looks: vec![Look::default(); block.nodes.len()],
                nodes: vec![Cover::ALL; block.nodes.len()],
                items: vec![Some(Cover::ALL); block.items.len()],
                paints: Vec::new(),
            },
            numbers: FxHashMap::default(),
            open: Vec::new(),
            frames: Vec::new(),
            parts: Meetings::new(),
        };
        block.upwards().into_iter().for_each(|number| survey.measure(number));
        survey.leave_to_slabs();
        survey.found
    }
}

impl Survey<'_> {
    /// Measures the items and nodes of a super-node. Those that it leads to have been measured.
    fn measure(&mut self, number: u32) {
        let block = self.block;
        let items: Vec<usize> = block.items_of(number).collect();
        let nodes = block.nodes_of(number);
        for item in &items {
            self.found.items[*item] = self.cover_of_item(*item);
        }
        let mut arrangement = Arrangement::default();
        for node in nodes.iter().rev() {
            self.look_at(number, *node, &mut arrangement);
        }
        let apart = arrangement.apart();
        for item in items {
            self.found.items[item].iter_mut().for_each(|cover| cover.apart = apart);
        }
        for node in nodes {
            self.found.nodes[node].apart = apart;
        }
    }

    /// The cover of an item, unless it is a primitive: what is seen of the root of its super-node is the same through
    /// another box. How it stops lines together with its siblings is not known yet; as recursion is alike from level to
    /// level, what its own parts do is a guess at it.
    fn cover_of_item(&mut self, at: usize) -> Option<Cover> {
        let block = self.block;
        let item = &block.items[at];
        let number = match item.content {
            Content::Super(number) => number,
            Content::Shape(_) => return None,
            Content::Solid(_) => return self.tracing.cover(block, at, self.lines[2]),
            Content::Gate(_) => unreachable!("all of the graph is there"),
        };
        let Some(root) = block.supers[number as usize].root else { return Some(Cover::NONE) };
        let (inner, root) = self.measured(root);
        let (outer, root) = (&block.parts[at].bounds, root?);
        let by_volume = 1.0 / item.item_from_super.matrix3.determinant().abs();
        let cells = std::array::from_fn(|cell| {
            let mut sum = [0.0; 2];
            for direction in cover::directions_in(cell) {
                let inside = item.item_from_super.matrix3 * direction;
                sum[0] += f64::from(root.along(inside)) * flux(inner, inside) * by_volume;
                sum[1] += flux(outer, direction);
            }
            narrow((sum[0] / sum[1]).clamp(0.0, 1.0))
        });
        Some(Cover { cells, apart: root.apart })
    }

    /// Lines were drawn through boxes, but rays have met slabs when they ask for a cover, where there are some.
    fn leave_to_slabs(&mut self) {
        for (child, outline) in self.block.outlines() {
            match child.target() {
                Target::Node(node) => outline.narrow(&self.found.bounds[node], &mut self.found.nodes[node]),
                Target::Item(item) => {
                    let bounds = &self.block.parts[item].bounds;
                    self.found.items[item].iter_mut().for_each(|cover| outline.narrow(bounds, cover));
                }
            }
        }
    }

    /// The box and the cover of a child of a node; no cover of a primitive.
    fn measured(&self, child: Child) -> (&Aabb, Option<&Cover>) {
        match child.target() {
            Target::Node(node) => (&self.found.bounds[node], Some(&self.found.nodes[node])),
            Target::Item(item) => (&self.block.parts[item].bounds, self.found.items[item].as_ref()),
        }
    }

    /// Draws lines through the box of a node and looks at where they are stopped.
    fn look_at(&mut self, number: u32, node: usize, arrangement: &mut Arrangement) {
        let block = self.block;
        let ball = &block.supers[number as usize];
        let bounds = block.node_bounds(number, node);
        self.found.bounds[node] = bounds;
        if !bounds.is_bounded() || bounds.surface_area() <= 0.0 {
            return;
        }
        let mut dice = Dice::at(bounds.min);
        let is_root = block.root_node(number) == Some(node);
        let is_super = |item: usize| matches!(block.items[item].content, Content::Super(_));
        let are_primitives = is_root && !block.items_of(number).any(is_super);
        let lines = self.lines[usize::from(!is_root)];
        let round = Round::new(&mut dice);
        let mut tallies = [Tally::default(); CELLS];
        let most_seen = if is_root { SEEN } else { SEEN_BELOW };
        let mut seen = Vec::new();
        for (throw, Thrown { line, weight, cell, .. }) in round.lines(&bounds, lines).enumerate() {
            // Covers are the same both ways, but not what is seen.
            let line = if throw % 2 == 0 { line } else { backwards(&line, &bounds) };
            let Some(inside) = Narrow::new(line, ball, ROOT, START, false) else { continue };
            let left = dispatch!(self.level, simd => self.follow(simd, node, inside, is_root));
            tallies[cell].add(weight, 1.0 - f64::from(left));
            if !is_root && seen.len() == most_seen {
                continue;
            }
            let mut met = dispatch!(self.level, simd => self.meet(simd, node, &inside));
            // Of primitives it is known how they stop lines: what is not are the nodes above them.
            let parts = if are_primitives { &met } else { &self.parts };
            if is_root && parts.len() > 1 {
                arrangement.add(parts, left);
            }
            if seen.len() < most_seen && !met.is_empty() {
                met.sort_unstable_by(|one, other| one.t.total_cmp(&other.t));
                seen.extend(self.see_first(ball, node, &met, &line, &mut dice));
            }
        }
        let cells = shares(&tallies, lines, || self.depths(node, &bounds));
        self.found.nodes[node] = Cover { cells, apart: 0.0 };
        self.found.looks[node] = Look::new(seen);
    }

    /// How much the children of a node cover in each direction, together and all over its box, if nothing of them were behind
    /// another one.
    fn depths(&self, node: usize, bounds: &Aabb) -> [f64; CELLS] {
        std::array::from_fn(|cell| {
            let direction = cover::direction_in(cell, [0.5; 2]);
            let covered = self.block.children(node).map(|child| {
                let (bounds, cover) = self.measured(child);
                flux(bounds, direction) * cover.map_or(1.0, |cover| f64::from(cover.cells[cell]))
            });
            covered.sum::<f64>() / flux(bounds, direction)
        })
    }

    /// The share of rays that is left of one that goes through a node, and from the root of a super-node through those that
    /// it leads to.
    #[inline(always)]
    fn follow<S: Simd>(&mut self, simd: S, node: usize, start: Narrow, is_root: bool) -> f32 {
        let block = self.block;
        let mut left = 1.0;
        self.frames.clear();
        self.frames.push(start);
        self.open.clear();
        self.open.push((0, Child::node(node)));
        self.parts.clear();
        // A frame that is not the first is one below it.
        while let Some((frame, child)) = self.open.pop() {
            let ray = &self.frames[frame];
            let at = match child.target() {
                Target::Node(node) => {
                    let node = &block.nodes[node];
                    let (_, mut met) = single::met(simd, node, &ray.line, ray.start, f32::MAX);
                    while met != 0 {
                        self.open.push((frame, node.children[met.trailing_zeros() as usize % WIDTH]));
                        met &= met - 1;
                    }
                    continue;
                }
                Target::Item(at) => at,
            };
            let item = &block.items[at];
            match (&self.found.items[at], item.content) {
                (Some(cover), Content::Super(number))
                    if is_root && frame == 0 && self.frames.len() < ENTERED =>
                {
                    self.parts.push(Meeting::new(0.0, cover, &ray.ray, child));
                    let below = &block.supers[number as usize];
                    let inside = transform(&ray.ray, &item.item_from_super);
                    if let (Some(inside), Some(root)) =
                        (Narrow::new(inside, below, ROOT, START, false), below.root)
                    {
                        self.frames.push(inside);
                        self.open.push((self.frames.len() - 1, root));
                    }
                }
                (Some(cover), _) => {
                    let met = Meeting::new(0.0, cover, &ray.ray, child);
                    left = behind(left, met.cover, met.apart);
                    if frame == 0 {
                        self.parts.push(met);
                    }
                }
                (None, _) => {
                    if self.meet_primitive(&ray.ray, at).is_some() {
                        left = 0.0;
                        if frame == 0 {
                            self.parts.push(Meeting { t: 0.0, cover: 1.0, apart: 0.0, child });
                        }
                    }
                }
            }
        }
        left
    }

    /// Where a ray in a super-node meets an item of it that is a primitive, also if it is alone in super-nodes of its own.
    fn meet_primitive(&self, super_ray: &Ray, mut at: usize) -> Option<f64> {
        let block = self.block;
        let mut ray = *super_ray;
        loop {
            let item = &block.items[at];
            ray = transform(&ray, &item.item_from_super);
            match item.content {
                Content::Shape(shape) => {
                    return single::first(&shapes::extents(&block.shapes[shape as usize], &ray));
                }
                Content::Super(number) => at = block.supers[number as usize].root?.as_item()?,
                Content::Solid(_) | Content::Gate(_) => return None,
            }
        }
    }

    /// What a ray meets of the children of a node.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, node: usize, narrow: &Narrow) -> Meetings {
        let block = self.block;
        let mut meetings = Meetings::new();
        let (near, mut met) = single::met(simd, &block.nodes[node], &narrow.line, narrow.start, f32::MAX);
        while met != 0 {
            let slot = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            let child = block.nodes[node].children[slot];
            let t = narrow.t(near[slot]);
            let met = match (self.measured(child), child.target()) {
                ((_, Some(cover)), _) => Meeting::new(t, cover, &narrow.ray, child),
                ((_, None), Target::Item(at)) => {
                    let Some(first) = self.meet_primitive(&narrow.ray, at) else { continue };
                    Meeting { t: first.max(t), cover: 1.0, apart: 0.0, child }
                }
                ((_, None), Target::Node(_)) => unreachable!("all nodes have covers"),
            };
            if met.cover > 0.0 {
                meetings.push(met);
            }
        }
        meetings
    }
}
