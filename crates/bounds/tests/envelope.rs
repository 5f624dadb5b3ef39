//! Envelopes: that nothing is outside of them, that they are pure, and how tight they are.
#![cfg(feature = "csg-graph")]
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

#[path = "../benches/chance/mod.rs"]
mod chance;
#[expect(dead_code, reason = "other tests use the rest")]
mod common;
#[path = "../examples/seeds/sweep/expansion.rs"]
#[expect(dead_code, reason = "whether parts are left is of no interest here")]
mod expansion;

use std::collections::HashMap;

use chance::{Chance, stochastic_sierpinski, terrain, thinning, tree, vine};
use common::{Recipe, Term, recipes, union_recipes};
use csg_graph::{
    Expr, Function, Graph, NodeId, Operator, ParamId, PrimitiveKind, State, Step, TransformKind,
};
use csg_graph_bounds::{Aabb, BoundsError, Envelope, Envelopes, Limits, Round, Slabs, exact};
use expansion::expand;
use glam::DVec3;
use proptest::prelude::*;

/// What the tests' own arithmetic may err.
const TOLERANCE: f64 = 1e-11;

fn envelopes(graph: &Graph) -> Envelopes {
    Envelopes::new(graph.clone(), &Limits::default())
}

/// Unfolds the graph and looks for points outside of the envelopes of the states that they are below.
fn assert_sound(graph: &Graph, envelopes: &Envelopes) {
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
fn states_that_differ_by_chance_have_the_same_typical_ones() {
    let typical = |seed| {
        let graph = tree(seed, 4);
        let envelopes = envelopes(&graph);
        let (mut state, mut found) = (graph.root_state(), Vec::new());
        loop {
            let typical = envelopes.typical(&state, 0.25);
            assert!(envelopes.class(&state).is_some());
            assert_eq!(envelopes.class(&state), envelopes.class(&typical));
            found.push((envelopes.class(&state), typical));
            state = match graph.step(&state).unwrap() {
                Step::Select(below) | Step::Calculate(below) | Step::Transform(_, below) => below,
                Step::Operator(_, [_, right]) => right,
                _ => return found,
            };
        }
    };
    assert_eq!(typical(1), typical(2));
}

#[test]
fn nothing_is_outside() {
    for seed in 0..8 {
        for graph in [tree(seed, 4), terrain(seed, 3, 0.3), stochastic_sierpinski(seed, 3), vine(seed)] {
            assert_sound(&graph, &envelopes(&graph));
        }
    }
    let graph = thinning(0);
    assert_sound(&graph, &envelopes(&graph));
}

/// A recursive solid all of whose measures are drawn from about those of the recipe, and which may end early.
fn by_chance(recipe: &Recipe, spread: f64, seed: u32) -> Graph {
    let mut c = Chance::new(seed);
    let n = c.b.param("n", recipe.n.into());
    // A value that is drawn at each level and goes further down.
    let sway = c.b.param("sway", 0.0);
    let symbol = c.b.symbol("X");
    let base = build(&mut c, &recipe.base, spread, sway, n, symbol);
    let step = build(&mut c, &recipe.step, spread, sway, n, symbol);
    let pick = c.draw(Function::Pick, [3.0, 1.0].map(Expr::from));
    let selection = Expr::choose(Expr::from(n).gt(0.0), pick, 2.0);
    c.b.rules(symbol, Some(selection), [step, base]);
    c.b.finish(symbol).unwrap()
}

fn build(c: &mut Chance, term: &Term, spread: f64, sway: ParamId, n: ParamId, symbol: NodeId) -> NodeId {
    match term {
        Term::Primitive(kind @ (PrimitiveKind::Frustum | PrimitiveKind::Torus), args) => {
            let measure = c.rand(0.5 * args[0], args[0]);
            c.b.primitive(*kind, [measure])
        }
        Term::Primitive(kind, _) => c.b.primitive(*kind, []),
        Term::Transform(kind, args, body) => {
            let body = build(c, body, spread, sway, n, symbol);
            let scales = matches!(kind, TransformKind::Scale | TransformKind::UScale);
            let args: Vec<Expr> = args
                .iter()
                .map(|arg| {
                    let by = if scales { 0.5 * spread * arg.abs() } else { spread * arg.abs().max(0.1) };
                    let drawn = c.rand(arg - by, arg + by);
                    if scales { drawn } else { drawn + sway }
                })
                .collect();
            c.b.transform(*kind, args, body)
        }
        Term::Operator(operator, left, right) => {
            let left = build(c, left, spread, sway, n, symbol);
            let right = build(c, right, spread, sway, n, symbol);
            c.b.operator(*operator, left, right)
        }
        Term::Cut(operator, [x, ..], body) => {
            let body = build(c, body, spread, sway, n, symbol);
            let half_space = c.b.primitive(PrimitiveKind::HalfSpace, []);
            let height = c.rand(-spread, 0.5);
            let moved = c.b.transform(TransformKind::Move, [0.0.into(), 0.0.into(), height], half_space);
            let turned = c.b.transform(TransformKind::RotX, [(90.0 * (x / 45.0).round()).into()], moved);
            c.b.operator(*operator, body, turned)
        }
        Term::Again => {
            let drawn = c.rand(-0.1, 0.1);
            c.refer(symbol, [(sway, Expr::from(sway) / 2.0 + drawn), (n, Expr::from(n) - 1.0)])
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_is_outside_of_random_solids(recipe in recipes(), spread in 0.0..0.9_f64, seed in 0..1000_u32) {
        for seed in seed..seed + 3 {
            let graph = by_chance(&recipe, spread, seed);
            assert_sound(&graph, &envelopes(&graph));
        }
    }

    /// Where levels are not counted, what is below is bounded for all levels at once.
    #[test]
    fn few_keys_do(recipe in recipes(), spread in 0.0..0.9_f64, seed in 0..1000_u32) {
        let graph = by_chance(&recipe, spread, seed);
        let envelopes = Envelopes::new(graph.clone(), &Limits::default().with_keys(1));
        if envelopes.of(&graph.root_state()).is_ok() {
            assert_sound(&graph, &envelopes);
        }
    }

    #[test]
    fn without_chance_exact_boxes_are_inside(recipe in union_recipes()) {
        let graph = recipe.graph();
        let envelopes = envelopes(&graph);
        let boxes = exact(&graph, &Limits::default()).unwrap();
        for (state, found) in boxes.states() {
            let envelope = envelopes.of(state).unwrap();
            let size = found.aabb.min.abs().max(found.aabb.max.abs()).max_element();
            let outer = envelope.aabb();
            let outer = Aabb::new(outer.min - 1e-9 * size, outer.max + 1e-9 * size);
            prop_assert!(outer.encloses(found.aabb), "{outer:?} {found:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_closer_look_sees_all_of_the_solid(recipe in union_recipes(), spread in 0.0..0.9_f64, seed in 0..1000_u32) {
        let graph = by_chance(&recipe, spread, seed);
        let (root, envelopes) = (graph.root_state(), envelopes(&graph));
        let least = exact(&graph, &Limits::default()).unwrap().root;
        let size = least.min.abs().max(least.max.abs()).max_element();
        let mut outer = envelopes.of(&root).unwrap().aabb();
        for steps in [0, 10, 100_000] {
            let closer = envelopes.refined_box(&root, steps).unwrap();
            let grown = Aabb::new(closer.min - 1e-9 * size, closer.max + 1e-9 * size);
            prop_assert!(outer.encloses(closer) && grown.encloses(least), "{outer:?} {closer:?} {least:?}");
            outer = closer;
        }
        // Nothing is left to look at.
        let off = (outer.min - least.min).abs().max((outer.max - least.max).abs()).max_element();
        prop_assert!(off <= 1e-9 * size, "{outer:?} {least:?}");
    }
}

/// A hundred times turned by chance: errors add up, and are not enlarged each time.
#[test]
fn a_closer_look_goes_deep() {
    let mut c = Chance::new(7);
    let n = c.b.param("n", 100.0);
    let symbol = c.b.symbol("X");
    let base = c.b.primitive(PrimitiveKind::Torus, [Expr::from(0.25)]);
    let next = c.refer(symbol, [(n, Expr::from(n) - 1.0)]);
    let turned = [TransformKind::RotX, TransformKind::RotY].into_iter().fold(next, |below, axis| {
        let angle = c.rand(0.0, 360.0);
        c.b.transform(axis, [angle], below)
    });
    c.b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 1.0, 2.0)), [turned, base]);
    let graph = c.b.finish(symbol).unwrap();
    let least = exact(&graph, &Limits::default()).unwrap().root;
    let closer = envelopes(&graph).refined_box(&graph.root_state(), 10_000).unwrap();
    let off = (closer.min - least.min).abs().max((closer.max - least.max).abs()).max_element();
    assert!(off < 1e-11, "{closer:?} {least:?}");
}

/// All states that a few steps from the root lead to.
fn states(graph: &Graph, count: usize) -> Vec<State> {
    let mut states = vec![graph.root_state()];
    let mut next = 0;
    while next < states.len() && states.len() < count {
        let below = graph.step(&states[next]).unwrap().into_states();
        states.extend(below.into_iter().flatten());
        next += 1;
    }
    states
}

#[test]
fn answers_depend_on_the_state_alone() {
    for graph in [tree(1, 8), terrain(1, 6, 0.3), vine(1), thinning(1)] {
        let states = states(&graph, 400);
        let expected: Vec<_> = states.iter().map(|state| envelopes(&graph).of(state).unwrap()).collect();
        let shared = envelopes(&graph);
        std::thread::scope(|scope| {
            for thread in 0..4 {
                let (states, expected, shared) = (&states, &expected, &shared);
                scope.spawn(move || {
                    for i in 0..states.len() {
                        let i = if thread % 2 == 0 { i } else { states.len() - 1 - i };
                        assert_eq!(shared.of(&states[i]).unwrap(), expected[i]);
                    }
                });
            }
        });
    }
}

#[test]
fn keys_are_few() {
    // Seeds tell no keys apart, nor do the places of a terrain.
    let count = |graph: &Graph| envelopes(graph).key_count();
    assert_eq!(count(&tree(1, 20)) - count(&tree(1, 10)), count(&tree(2, 30)) - count(&tree(2, 20)));
    assert!(count(&tree(1, 60)) < 1000);
    assert!(count(&terrain(1, 20, 0.3)) < 1000);
    assert!(count(&vine(1)) < 20);
}

/// The terrain's corners are displaced by 0.3, 0.15, 0.075, …, so that no height is beyond 0.6.
#[test]
fn geometric_series_are_recognised() {
    for levels in [5, 20, 60] {
        let graph = terrain(1, levels, 0.3);
        let bounds = envelopes(&graph).of(&graph.root_state()).unwrap().aabb();
        assert!(bounds.max.z <= 0.6 + 1e-9 && bounds.min.z >= -0.62 - 1e-9, "{bounds:?}");
        assert!(
            bounds.min.truncate().length() < 1e-9 && bounds.max.truncate().distance(glam::DVec2::ONE) < 1e-9
        );
    }
}

#[test]
fn what_does_not_shrink_is_an_error() {
    let mut c = Chance::new(1);
    let vine = c.b.symbol("VINE");
    let ball = c.b.primitive(PrimitiveKind::Sphere, []);
    let again = c.refer(vine, []);
    let factor = c.rand(0.9, 1.05);
    let grown = c.map(TransformKind::UScale, [factor], again);
    let moved = c.map(TransformKind::Move, [0.0, 0.0, 1.0].map(Expr::from), grown);
    let both = c.b.union([ball, moved]);
    let pick = c.draw(Function::Pick, [1.0, 1.0].map(Expr::from));
    c.b.rules(vine, Some(pick), [ball, both]);
    let graph = c.b.finish(vine).unwrap();
    let error = envelopes(&graph).of(&graph.root_state()).unwrap_err();
    let BoundsError::Endless { cycle, round: Round::Unbounded(factor) } = &error else { panic!("{error}") };
    assert_eq!(cycle, &["VINE"]);
    assert!((factor - 1.05).abs() < 1e-3, "{factor}");
    assert!(error.to_string().starts_with("the recursion never ends: VINE leads back to itself"), "{error}");
    // The ball has an envelope all the same.
    let ball = states(&graph, 100).pop().unwrap();
    assert!(envelopes(&graph).of(&ball).is_ok());
}

#[test]
fn recursion_without_end_has_an_attractor() {
    let mut c = Chance::new(1);
    let dust = c.b.symbol("DUST");
    let copies = [-1.0, 1.0].map(|x: f64| {
        let third = c.b.transform(TransformKind::UScale, [(1.0 / 3.0).into()], dust);
        let turned = c.b.transform(TransformKind::RotX, [30.0.into()], third);
        c.b.transform(TransformKind::Move, [x, 0.5, 0.0].map(Expr::from), turned)
    });
    let both = c.b.union(copies);
    c.b.rules(dust, None, [both]);
    let graph = c.b.finish(dust).unwrap();
    let exact = exact(&graph, &Limits::default()).unwrap().root;
    let found = envelopes(&graph).of(&graph.root_state()).unwrap().aabb();
    let grown = |bounds: Aabb, by: f64| Aabb::new(bounds.min - by, bounds.max + by);
    assert!(grown(found, 1e-9).encloses(exact) && grown(exact, 1e-6).encloses(found), "{found:?} {exact:?}");
}

#[test]
fn half_spaces_cut_where_they_lie_along_planes() {
    let mut c = Chance::new(1);
    let half_space = c.b.primitive(PrimitiveKind::HalfSpace, []);
    let height = c.rand(-0.5, 0.25);
    let moved = c.map(TransformKind::Move, [0.0.into(), 0.0.into(), height], half_space);
    let turned = c.map(TransformKind::RotX, [180.0.into()], moved);
    let ball = c.b.primitive(PrimitiveKind::Sphere, []);
    let cap = c.b.operator(Operator::Intersection, ball, turned);
    let root = c.refer(cap, []);
    let graph = c.b.finish(root).unwrap();
    let envelopes = envelopes(&graph);
    let bounds = envelopes.of(&graph.root_state()).unwrap().aabb();
    assert!((bounds.min - DVec3::new(-1.0, -1.0, -0.25)).abs().max_element() < 1e-9, "{bounds:?}");
    assert!((bounds.max - DVec3::ONE).abs().max_element() < 1e-9, "{bounds:?}");
    let [cap, _] = graph.step(&graph.root_state()).unwrap().into_states();
    let [_, cut] = graph.step(&cap.unwrap()).unwrap().into_states().map(Option::unwrap);
    let cut = envelopes.of(&cut).unwrap();
    assert!(cut.support(DVec3::Z).is_infinite());
    assert!((cut.support(DVec3::NEG_Z) - 0.25).abs() < 1e-9);
}

/// The median ratios of surface areas to those of exact boxes: directly, and after one expansion.
fn looseness(solid: impl Fn(u32) -> Graph) -> [f64; 2] {
    let mut ratios = [Vec::new(), Vec::new()];
    for seed in 0..15 {
        let graph = solid(seed);
        let envelopes = envelopes(&graph);
        let exact = exact(&graph, &Limits::default()).unwrap().root.surface_area();
        let direct = envelopes.of(&graph.root_state()).unwrap().aabb();
        ratios[0].push(direct.surface_area() / exact);
        let expansion = expand(&graph, &envelopes, &graph.root_state(), 100).unwrap();
        ratios[1].push(expansion.bounds.surface_area() / exact);
    }
    ratios.map(|mut ratios| {
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    })
}

/// The numbers are in `docs/bounds.md`.
#[test]
fn envelopes_are_tight_after_one_expansion() {
    type Solid = fn(u32) -> Graph;
    let solids: [(Solid, usize, [f64; 2]); 4] = [
        (|seed| tree(seed, 10), 153, [3.56, 1.16]),
        (|seed| terrain(seed, 6, 0.3), 128, [1.63, 1.07]),
        (|seed| stochastic_sierpinski(seed, 6), 134, [1.0, 1.0]),
        (thinning, 15, [4.62, 1.0]),
    ];
    for (solid, keys, expected) in solids {
        assert_eq!(envelopes(&solid(0)).key_count(), keys);
        let found = looseness(solid);
        assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 0.006), "{found:?} {expected:?}");
    }
}
