//! Envelopes: that nothing is outside of them, that they are pure, and how tight they are.
#![cfg(feature = "csg-graph")]
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

#[path = "common/chance.rs"]
mod chance;
mod common;

use std::collections::HashMap;

use chance::{stochastic_sierpinski, terrain, thinning, tree, vine};
use csg_graph::{Graph, State, Step};
use csg_graph_bounds::{Aabb, Envelope, Envelopes, Limits, Slabs, exact};
use glam::{DAffine3, DVec3};

/// What the tests' own arithmetic may err.
const TOLERANCE: f64 = 1e-11;

fn envelopes(graph: &Graph) -> Envelopes {
    Envelopes::new(graph.clone(), &Limits::default())
}

/// Unfolds the graph and looks for points outside of the envelopes of the states that they are below.
fn assert_sound(graph: &Graph) {
    let envelopes = envelopes(graph);
    let tree = common::unfold(graph, &graph.root_state());
    let mut known: HashMap<State, Envelope> = HashMap::new();
    let mut points = 0;
    tree.sample(&mut |state, point| {
        let envelope = known.entry(state.clone()).or_insert_with(|| envelopes.of(state).unwrap());
        let margin = TOLERANCE * (1.0 + point.length());
        let slabs = envelope.slabs();
        let between = Slabs::<13>::DIRECTIONS
            .into_iter()
            .enumerate()
            .all(|(i, d)| (slabs.min[i] - margin..=slabs.max[i] + margin).contains(&d.dot(point)));
        points += 1;
        // A direction of its own for each point.
        let d = DVec3::new(point.y, -point.z, point.x + 0.1 * f64::from(points % 100));
        assert!(
            between
                && d.dot(point) <= envelope.support(d) + margin * d.length()
                && point.length() <= envelope.radius() + margin,
            "{point} is outside of {envelope:?} of {} where {:?}",
            graph.node_name(state.node()),
            graph.live_values(state),
        );
    });
}

#[test]
fn nothing_is_outside() {
    for seed in 0..8 {
        assert_sound(&tree(seed, 4));
        assert_sound(&terrain(seed, 3, 0.3));
        assert_sound(&stochastic_sierpinski(seed, 3));
        assert_sound(&vine(seed));
    }
}

#[test]
fn thin_branches() {
    assert_sound(&thinning(0));
}

/// The box of a state after some expansions of the largest parts.
fn expanded(graph: &Graph, envelopes: &Envelopes, parts: usize) -> Aabb {
    let bounds = |world: &DAffine3, state: &State| {
        let envelope = envelopes.of(state).unwrap();
        let m = world.matrix3.transpose();
        let h = |d: DVec3| d.dot(world.translation) + envelope.support(m * d);
        let max = DVec3::from_array(DVec3::AXES.map(h));
        let min = -DVec3::from_array(DVec3::AXES.map(|d| h(-d)));
        Aabb::new(min, max)
    };
    let mut open =
        vec![(bounds(&DAffine3::IDENTITY, &graph.root_state()), DAffine3::IDENTITY, graph.root_state())];
    let mut done = Aabb::EMPTY;
    while open.len() < parts {
        let Some(largest) =
            (0..open.len()).max_by(|a, b| open[*a].0.surface_area().total_cmp(&open[*b].0.surface_area()))
        else {
            break;
        };
        let (_, mut world, mut state) = open.swap_remove(largest);
        loop {
            match graph.step(&state).unwrap() {
                Step::Select(below) | Step::Calculate(below) | Step::Attribute(_, below) => state = below,
                Step::Transform(map, below) => {
                    world = world * map.to_affine();
                    state = below;
                }
                Step::Operator(_, states) => {
                    for state in states {
                        open.push((bounds(&world, &state), world, state));
                    }
                    break;
                }
                _ => {
                    done = done.join(bounds(&world, &state));
                    break;
                }
            }
        }
    }
    open.into_iter().fold(done, |all, (bounds, ..)| all.join(bounds))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn sizes() {
    let makes: [(&str, fn(u32) -> Graph); 5] = [
        ("tree", |s| tree(s, 10)),
        ("terrain", |s| terrain(s, 7, 0.3)),
        ("sierpinski", |s| stochastic_sierpinski(s, 7)),
        ("vine", vine),
        ("thin", thinning),
    ];
    for (name, make) in makes {
        let (mut i, mut ii) = (vec![], vec![]);
        let graph = make(0);
        let at = std::time::Instant::now();
        let e = envelopes(&graph);
        let made = at.elapsed();
        let at = std::time::Instant::now();
        let found = e.of(&graph.root_state()).unwrap();
        let asked = at.elapsed();
        for seed in 0..8 {
            let graph = make(seed);
            let e = envelopes(&graph);
            let exact = exact(&graph, &Limits::default()).unwrap().root;
            i.push(e.of(&graph.root_state()).unwrap().aabb().surface_area() / exact.surface_area());
            ii.push(expanded(&graph, &e, 100).surface_area() / exact.surface_area());
        }
        eprintln!(
            "{name}: {} keys {made:?} {asked:?} {:?} r {} ratio {} {}",
            e.key_count(),
            found.aabb(),
            found.radius(),
            median(i),
            median(ii)
        );
    }
}
