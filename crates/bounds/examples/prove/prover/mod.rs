//! The proof by sampling that no bounding volume cuts off a point of its solid.
//!
//! A *trial* is one random graph ([`graphs`]). Points on the surfaces of its primitives ([`surface`]), at the end of
//! random paths down the graph ([`scene`]), are mapped up through all T-nodes in twice the usual precision ([`cloud`],
//! [`double`]) and checked in the frame of every state on the path ([`enclosure`]), where a volume passes only if the
//! point satisfies its inequalities *without any tolerance*. Nothing is unfolded, so the depth costs only the length
//! of paths.
//!
//! Under ∩ and \ the points that belong to the result go on ([`inside`]). Every point counts for the operand that it
//! comes from, whose box is not clipped by the other one. Points of a subtrahend go on as well, if they are on its
//! boundary: where they are in the left operand, they are on the boundary of the difference.

mod cloud;
mod double;
mod enclosure;
mod graphs;
mod inside;
mod random;
mod scene;
mod surface;
mod tally;

use csg_graph::Graph;
use csg_graph_bounds::{
    Aabb, Envelopes, ExactBoxes, Limits, Refinement, Shape, chain, conventional, exact, root_box,
};
use glam::DVec3;

use cloud::Cloud;
use inside::inside;
use random::Random;
use scene::{States, Term};

pub(crate) use enclosure::{Enclosure, Kind};
pub(crate) use tally::{Escape, Tally};

/// How many points go up one path together.
const POINTS: usize = 96;

/// Unfolded trees that take more steps have no hyper boxes by the chain and the conventional algorithm.
const STEPS: u64 = 20_000;

/// How many states get the box of the solid itself, and volumes other than boxes.
const CHOSEN: usize = 6;

/// How many cells the search for a face of that box may classify.
const CELLS: usize = 300;

/// How many nodes are looked at for a face of the refined box.
const STEPS_CLOSER: usize = 1000;

/// Why there is an answer for a state.
const REACHED: &str = "the root leads to all states";

/// Samples at least so many points of one random graph of a run. Each volume is `altered` before it is checked, which
/// shows that the prover can fail.
pub(crate) fn trial(seed: u64, graph: u64, points: u64, altered: fn(Enclosure) -> Enclosure) -> Tally {
    let mut random = Random::new(seed, graph);
    let scene = graphs::graph(&mut random);
    // Queries that may not go to their end leave larger gaps, which must be in the boxes.
    let expansions = random.pick(&[10, 100, 300]);
    let limits = Limits::default().with_expansions(expansions).with_gap(random.pick(&[1e-12, 1e-6]));
    let boxes =
        exact(&scene, &limits).unwrap_or_else(|error| panic!("graph {graph} of seed {seed}: {error}"));
    let states = States::new(&scene, &boxes);
    let volumes = volumes(&scene, &boxes, &states, &limits, &mut random);
    let volumes =
        volumes.into_iter().map(|of| of.into_iter().map(|(kind, found)| (kind, altered(found))).collect());
    let mut trial = Trial {
        seed,
        graph,
        states: &states,
        scene: &scene,
        volumes: volumes.collect(),
        tally: Tally::default(),
    };
    trial.tally.graphs = 1;
    trial.tally.states = states.all.len() as u64;
    trial.tally.height = states.all[states.root()].height;
    for (kind, _) in trial.volumes.iter().flatten() {
        trial.tally.volumes[kind.0] += 1;
    }
    let mut cloud = Cloud::default();
    while trial.tally.points < points {
        trial.climb(&states.path(&mut random), &mut cloud, &mut random);
    }
    trial.tally
}

/// The volumes of all states, by number.
fn volumes(
    graph: &Graph,
    boxes: &ExactBoxes<Graph>,
    states: &States,
    limits: &Limits,
    random: &mut Random,
) -> Vec<Vec<(Kind, Enclosure)>> {
    let mut volumes: Vec<Vec<(Kind, Enclosure)>> = Vec::with_capacity(states.all.len());
    let few = limits.with_steps(STEPS);
    // They fail where the tree is large, and then there are none.
    let chain = chain(graph, &few).ok().map(|found| (Kind::CHAIN, found.nodes));
    let conventional = conventional(graph, &few).ok().map(|found| (Kind::CONVENTIONAL, found.nodes));
    let hyper_boxes: Vec<(Kind, Vec<Aabb>)> =
        [Some((Kind::EXACT, boxes.nodes.clone())), chain, conventional].into_iter().flatten().collect();
    for state in &states.all {
        let hyper = hyper_boxes.iter().map(|(kind, nodes)| (*kind, Enclosure::Box(nodes[state.node])));
        volumes.push([(Kind::STATE, Enclosure::Box(state.bounds))].into_iter().chain(hyper).collect());
    }
    let root = root_box(graph, limits).expect("all boxes were found, so this one is").aabb;
    volumes[states.root()].push((Kind::ROOT, Enclosure::Box(root)));
    volumes[states.root()].push((Kind::S_BOUND, Enclosure::Box(boxes.s_bounds(graph).root)));
    let envelopes = Envelopes::new(graph.clone(), limits);
    let refined = envelopes.refined_box(&graph.root_state(), STEPS_CLOSER).expect("it has an envelope");
    volumes[states.root()].push((Kind::REFINED, Enclosure::Box(refined)));
    for i in 0..CHOSEN {
        let number = if i == 0 { states.root() } else { random.below(states.all.len()) };
        let state = &states.all[number].state;
        let mut solid = boxes.solid(state, &Refinement::default().with_cells(CELLS)).expect(REACHED);
        volumes[number].push((Kind::SOLID, Enclosure::Box(solid.aabb().aabb)));
        volumes[number].extend(Enclosure::of_envelope(&envelopes, state));
        let support = |direction: DVec3| boxes.support(state, direction).expect(REACHED).upper;
        let tolerance = random.pick(&[0.5, 0.1, 0.03]);
        volumes[number].extend(Enclosure::from_supports(support, tolerance));
    }
    let shapes = states.all.iter().enumerate().filter_map(|(number, state)| match &state.term {
        Term::Shape(primitive) => Some((number, primitive)),
        _ => None,
    });
    for (number, primitive) in shapes.take(2 * CHOSEN) {
        volumes[number].extend(Enclosure::from_points(&primitive.point_set()));
        volumes[number].extend(Enclosure::of_envelope(&envelopes, &states.all[number].state));
    }
    volumes
}

struct Trial<'a> {
    seed: u64,
    graph: u64,
    scene: &'a Graph,
    states: &'a States,
    volumes: Vec<Vec<(Kind, Enclosure)>>,
    tally: Tally,
}

impl Trial<'_> {
    /// Takes points of the primitive at the end of a path up to the root, as far as any belong to the solid.
    fn climb(&mut self, path: &[usize], cloud: &mut Cloud, random: &mut Random) {
        let states = self.states;
        let mut upwards = path.iter().rev();
        let Some(&leaf) = upwards.next() else { return };
        let Term::Shape(primitive) = &states.all[leaf].term else { return };
        let directions = states.directions(path, random);
        surface::sample(cloud, primitive, &directions, POINTS, random);
        self.tally.points += cloud.len() as u64;
        self.check(leaf, cloud);
        let mut below = leaf;
        // Whether the points are on the boundary of the state and not only in it, as in a union they may be.
        let mut on_boundary = true;
        for &state in upwards {
            match &states.all[state].term {
                Term::Map(parent_from_child, _) => cloud.map(parent_from_child),
                Term::Intersection([left, right]) => {
                    let other = if below == *left { *right } else { *left };
                    keep(cloud, |p, error| inside(states, other, p, error) == Some(true));
                }
                Term::Difference([left, right]) if below == *left => {
                    keep(cloud, |p, error| inside(states, *right, p, error) == Some(false));
                }
                Term::Difference([left, right]) => keep(cloud, |p, error| {
                    // Not all points that a hull was made of are on its surface.
                    on_boundary
                        && inside(states, *left, p, error) == Some(true)
                        && inside(states, *right, p, error) != Some(true)
                }),
                Term::Union(_) => on_boundary = false,
                Term::Shape(_) | Term::Same(_) => {}
            }
            self.check(state, cloud);
            below = state;
        }
    }

    /// Checks all points against all volumes of a state.
    fn check(&mut self, state: usize, cloud: &Cloud) {
        for (kind, enclosure) in &self.volumes[state] {
            self.tally.checks[kind.0] += cloud.len() as u64;
            if let Some((at, excess)) = enclosure.escape(cloud) {
                self.tally.escapes.push(Escape {
                    seed: self.seed,
                    graph: self.graph,
                    kind: *kind,
                    state: csg_graph_bounds::Scene::label(self.scene, &self.states.all[state].state),
                    point: cloud.rounded(at),
                    excess,
                    enclosure: enclosure.clone(),
                });
            }
        }
    }
}

/// Keeps the points of which that is certain, given with how far off they may be.
fn keep(cloud: &mut Cloud, certain: impl Fn(DVec3, f64) -> bool) {
    cloud.retain(|cloud, i| certain(cloud.rounded(i), cloud.error));
}
