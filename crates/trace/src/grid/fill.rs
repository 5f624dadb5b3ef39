//! Entry states: what is in the voxels \[TRAX95\] §4.
//!
//! "Non empty voxels represent a state of a CSG graph, which is defined by a transformation matrix, a set of parameter
//! values and a reference to a node of the graph." The state graph is descended from the root. A union that is larger
//! than a voxel is opened; what is no larger, or is no union, is an entry state of every voxel that its box touches. The
//! box is that of the state itself and not the hyper box of its node, and it counts as it lies in the world, turned.
//!
//! The paper does not say how far the graph is opened. Opening to primitives would unfold it; here no more is opened than
//! the voxels can tell apart, and no more than memory allows: where too much would be entered, only what is larger than
//! two voxels is opened, or than four, and so on. The root alone always fits.

use csg_graph::{EvalError, Graph, State};
use csg_graph_bounds::{Aabb, ExactBoxes};
use glam::DAffine3;

use super::lattice::Lattice;
use crate::Surface;
use crate::fast::Bounds;
use crate::fast::instance::Instance;
use crate::fast::states::{Kind, Resolved, States};
use crate::fast::unions::Unions;
use crate::narrow::index;

/// A place where rays enter the graph.
#[derive(Clone, Debug)]
pub(super) struct EntryState {
    /// An index into the states.
    pub(super) state: u32,
    /// S-nodes passed on the way from the root.
    pub(super) depth: u32,
    /// The state of the last of these, by its place among all states.
    pub(super) symbol: Option<u32>,
    pub(super) state_from_world: DAffine3,
    pub(super) surface: Surface,
}

/// Voxels with their entry states.
#[derive(Debug)]
pub(super) struct Voxels {
    pub(super) lattice: Lattice,
    /// In the order of the graph.
    pub(super) entries: Vec<EntryState>,
    /// States with their boxes, in their own frames.
    pub(super) states: Vec<(State, Aabb)>,
    /// Where in `references` those of each voxel start, and where the last ones end.
    starts: Vec<u32>,
    /// Indices of entry states, ascending in each voxel.
    references: Vec<u32>,
}

/// A resolved state, come to on some way from the root.
struct Arrival {
    /// Its index.
    target: u32,
    depth: u32,
    symbol: Option<u32>,
    world_from_state: DAffine3,
    state_from_world: DAffine3,
    surface: Surface,
    /// In the world; what it is a part of encloses it.
    bounds: Aabb,
}

/// How far the boxes of states are padded, relative to coordinates in their frames, for what is lost in the products of
/// transformations.
const PADDING: f64 = 1e-9;

/// What a voxel takes, if it is empty.
const VOXEL: usize = size_of::<u32>();

/// The most voxels along a side, whatever is asked for.
const FINEST: u32 = 1 << 16;

impl Voxels {
    /// Fills voxels, the longest side of the root's box cut into `resolution`, or into fewer if the voxels alone take more
    /// than half of the budget of bytes. Without a resolution, there are as many as are usual for so many primitives.
    pub(super) fn new(
        graph: &Graph,
        boxes: &ExactBoxes<Graph>,
        resolution: Option<u32>,
        budget: usize,
    ) -> Result<Self, EvalError> {
        let unions = Unions::new(graph);
        let (states, root) = States::all(graph, &unions, Bounds::Exact(boxes))?;
        let usual = resolution.map_or_else(|| usual_voxels(&states, &root), |_| usize::MAX);
        let most = usual.min(budget / (2 * VOXEL));
        let mut resolution = resolution.unwrap_or(FINEST).clamp(1, FINEST);
        let mut lattice = Lattice::new(&boxes.root, resolution);
        while resolution > 1 && lattice.len() > most {
            resolution -= resolution.div_ceil(16);
            lattice = Lattice::new(&boxes.root, resolution);
        }
        let affordable = budget.saturating_sub(lattice.len() * VOXEL);
        let extent = boxes.root.size().max_element();
        let mut finest = if boxes.root.is_bounded() { lattice.voxel_extent() } else { extent };
        loop {
            let affordable = if finest < extent { affordable } else { usize::MAX };
            if let Some(filling) =
                Filling::new(&states, Arrival::of_root(&root, boxes), &lattice, finest, affordable)
            {
                return Ok(filling.close(&states, lattice));
            }
            finest *= 2.0;
        }
    }

    /// The entry states of a voxel.
    pub(super) fn of(&self, voxel: usize) -> &[u32] {
        &self.references[self.starts[voxel] as usize..self.starts[voxel + 1] as usize]
    }

    /// The memory that they take, but for the values of the parameters of states.
    pub(super) fn bytes(&self) -> usize {
        let Self { lattice: _, entries, states, starts, references } = self;
        size_of_val(&**entries) + size_of_val(&**states) + size_of_val(&**starts) + size_of_val(&**references)
    }
}

/// A voxel for each primitive of the unfolded tree. More take more time to go through than they save below.
fn usual_voxels(states: &States<'_>, root: &Instance) -> usize {
    let mut primitives = vec![0_usize; states.states.len()];
    for number in &states.order {
        primitives[*number as usize] = match &states.states[*number as usize].kind {
            Kind::Union(parts) => {
                parts.iter().map(|part| primitives[part.target as usize]).fold(0, usize::saturating_add)
            }
            _ => 1,
        };
    }
    primitives[root.target as usize]
}

/// What is put into voxels, before it is sorted by them.
#[derive(Default)]
struct Filling {
    entries: Vec<EntryState>,
    /// Voxels and the entry states that touch them, in the order of these.
    touches: Vec<(u32, u32)>,
}

impl Filling {
    /// Opens what is larger than `finest`, or gives up if the rest takes more bytes than are affordable.
    fn new(
        states: &States<'_>,
        root: Arrival,
        lattice: &Lattice,
        finest: f64,
        affordable: usize,
    ) -> Option<Self> {
        let mut all = Self::default();
        let mut waiting = vec![root];
        while let Some(arrival) = waiting.pop() {
            let Resolved { kind, .. } = &states.states[arrival.target as usize];
            if arrival.bounds.is_empty() {
                continue;
            }
            if let Kind::Union(parts) = kind
                && arrival.bounds.size().max_element() > finest
            {
                // The first part on top, so that entry states are in the order of the graph.
                waiting.extend(parts.iter().rev().map(|part| arrival.then(part, states)));
                continue;
            }
            let entry = index(all.entries.len());
            let bounds = aabb(states, arrival.target);
            let touched = lattice.touched(&arrival.bounds);
            let inside = touched.filter(|(_, voxel)| touches(&bounds, &arrival.state_from_world, voxel));
            all.touches.extend(inside.map(|(voxel, _)| (index(voxel), entry)));
            let Arrival { target, depth, symbol, state_from_world, surface, .. } = arrival;
            all.entries.push(EntryState { state: target, depth, symbol, state_from_world, surface });
            if all.entries.len() * size_of::<EntryState>() + all.touches.len() * size_of::<u32>() > affordable
            {
                return None;
            }
        }
        Some(all)
    }

    /// Sorts by voxels, and keeps the states that are entered.
    fn close(mut self, states: &States<'_>, lattice: Lattice) -> Voxels {
        let mut starts = vec![0_u32; lattice.len() + 1];
        for (voxel, _) in &self.touches {
            starts[*voxel as usize + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        self.touches.sort_by_key(|(voxel, _)| *voxel);
        let references = self.touches.iter().map(|(_, entry)| *entry).collect();
        let mut numbers = vec![None; states.states.len()];
        let mut entered = Vec::new();
        for entry in &mut self.entries {
            let resolved = &states.states[entry.state as usize];
            entry.state = *numbers[entry.state as usize].get_or_insert_with(|| {
                entered.push((resolved.state.clone(), aabb(states, entry.state)));
                index(entered.len() - 1)
            });
        }
        Voxels { lattice, entries: self.entries, states: entered, starts, references }
    }
}

impl Arrival {
    fn of_root(root: &Instance, boxes: &ExactBoxes<Graph>) -> Self {
        let mut surface = Surface::default();
        root.paint.iter().for_each(|(term, value)| surface.set(*term, *value));
        Self {
            target: root.target,
            depth: root.depth,
            symbol: root.symbol,
            world_from_state: root.above_from_target,
            state_from_world: root.target_from_above,
            surface,
            bounds: boxes.root,
        }
    }

    /// A part of the state.
    fn then(&self, part: &Instance, states: &States<'_>) -> Self {
        let world_from_state = self.world_from_state * part.above_from_target;
        let mut surface = self.surface;
        part.paint.iter().for_each(|(term, value)| surface.set(*term, *value));
        Self {
            target: part.target,
            depth: self.depth + part.depth,
            symbol: part.symbol.or(self.symbol),
            world_from_state,
            state_from_world: part.target_from_above * self.state_from_world,
            surface,
            bounds: aabb(states, part.target).image(&world_from_state).intersect(self.bounds),
        }
    }
}

/// Whether the box of a state may touch that of a voxel, seen from the state: most of what lies askew in the world touches
/// fewer voxels than its box in the world.
fn touches(bounds: &Aabb, state_from_world: &DAffine3, voxel: &Aabb) -> bool {
    let seen = voxel.image(state_from_world);
    let padding = PADDING * state_from_world.translation.abs().max_element();
    let padded = Aabb { min: seen.min - padding, max: seen.max + padding };
    !padded.intersect(*bounds).is_empty()
}

/// The box of a state.
fn aabb(states: &States<'_>, state: u32) -> Aabb {
    states.aabb(state).expect("boxes that are at hand")
}
