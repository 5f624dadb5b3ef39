//! The slow twin of questions: every key is a visit of its own, found by hashing, and every envelope is whole.

#[expect(dead_code, reason = "other tests use the rest")]
#[path = "../../../benches/chance/mod.rs"]
mod chance;

use std::cmp::Reverse;
use std::collections::{BTreeMap, HashMap};

use csg_graph::{Expr, Function, Graph, Interval, Operator, PrimitiveKind, State, TransformKind};
use glam::DVec3;

use super::Question;
use super::plan::{KEYS, Plan};
use crate::envelope::Envelopes;
use crate::envelope::assemble::{Make, assemble};
use crate::envelope::body::Body;
use crate::envelope::general::Known;
use crate::{Aabb, Limits, Volume};
use chance::{Chance, terrain, thinning};

const ROUNDS: u32 = 64;

/// A key that is gone round to so many times; those that are visited first are the least.
type Place = (u32, Reverse<u32>);

#[derive(Clone, Copy)]
enum Source {
    General(u32),
    Visit(Place),
}

/// The envelope of all states with a key whose varying parameters are in these intervals.
fn envelope(Question { keys, general }: Question<'_>, key: u32, varying: Vec<Interval>) -> Known {
    let first = (0, Reverse(key));
    let mut queue = BTreeMap::from([(first, varying)]);
    let mut visits: BTreeMap<Place, (Make<'_>, Vec<Source>)> = BTreeMap::new();
    while let Some((place @ (round, Reverse(key)), varying)) = queue.pop_first() {
        let mut values = varying;
        let (make, parts) = keys.make(key, &mut values);
        let mut sources = Vec::new();
        for part in &keys.below(key)[parts] {
            let round = if *part >= key { round + 1 } else { round };
            if !keys.varies(*part) || round == ROUNDS {
                sources.push(Source::General(*part));
                continue;
            }
            let place = (round, Reverse(*part));
            let below = keys.varying(*part, &values);
            let known = queue.entry(place).or_insert_with(|| vec![Interval::EMPTY; values.len()]);
            known.iter_mut().zip(below).for_each(|(known, new)| *known = known.join(new));
            sources.push(Source::Visit(place));
        }
        visits.insert(place, (make, sources));
    }
    let look = |source: Source| match source {
        Source::General(_) => None,
        Source::Visit(place) => visits.get(&place).map(|(make, sources)| (make, &sources[..])),
    };
    let mut found: HashMap<Place, Known> = HashMap::new();
    for (place, (make, sources)) in visits.iter().rev() {
        let known = |source: Source| match source {
            Source::General(key) => general[key as usize].as_ref(),
            Source::Visit(place) => found[&place].as_ref(),
        };
        let made = assemble(make, sources, look, known);
        found.insert(*place, made);
    }
    match (found.remove(&first).expect("the visit that was asked for"), &general[key as usize]) {
        (Ok(found), Ok(general)) => Ok(found.intersect(*general)),
        (found, _) => found,
    }
}

/// Heights that are drawn and go further down, under all that a question distinguishes: C-nodes beside each other, turns by
/// chance and by right angles, chains that are too long for one, ∩ and \, and keys that several ways lead to.
fn mixture(levels: u32) -> Graph {
    let mut c = Chance::new(1);
    let [n, h] = [("n", f64::from(levels)), ("h", 0.5)].map(|(name, value)| c.b.param(name, value));
    let symbol = c.b.symbol("X");
    let ball = c.b.primitive(PrimitiveKind::Sphere, []);
    let point = |x: f64, y: f64, z: Expr| [x.into(), y.into(), z];
    let spike = [
        point(0.0, 0.0, h.into()),
        point(-1.0, -1.0, 0.0.into()),
        point(1.0, 0.0, 0.0.into()),
        point(0.0, 1.0, Expr::from(h) * -1.0),
    ];
    let spike = c.b.primitive(PrimitiveKind::Hull, spike.into_iter().flatten());
    let standing = c.map(TransformKind::Scale, [0.5.into(), Expr::from(h) + 1.0, 1.0.into()], ball);
    let cap = c.map(TransformKind::Move, [0.0.into(), 0.0.into(), h.into()], ball);
    let cap = c.b.operator(Operator::Intersection, standing, cap);
    let cut = c.b.operator(Operator::Difference, spike, ball);
    let step = |c: &mut Chance, by: f64| {
        let drawn = c.rand(-by, by);
        let again = c.refer(symbol, [(h, Expr::from(h) * 0.5 + drawn), (n, Expr::from(n) - 1.0)]);
        c.map(TransformKind::UScale, [0.6.into()], again)
    };
    let (a, b, d) = (step(&mut c, 0.1), step(&mut c, 0.2), step(&mut c, 0.3));
    let angle = c.rand(10.0, 30.0);
    let a = c.map(TransformKind::RotX, [angle + Expr::from(h)], a);
    let b = c.map(TransformKind::RotZ, [90.0.into()], b);
    let mut long = c.b.union([d, cut]);
    for turn in 1..7_u32 {
        long = c.map(TransformKind::RotY, [f64::from(7 * turn).into()], long);
        long = c.map(TransformKind::Move, [0.0.into(), Expr::from(h) * 0.1, 0.0.into()], long);
    }
    let twice = c.b.calculate([(h, Expr::from(h) + 0.1)], b);
    let all = c.b.union([cap, a, b, twice, long]);
    c.b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0)), [cut, all]);
    c.b.finish(symbol).expect("a graph")
}

/// Branches whose lengths are drawn, each of which goes on or not as it likes.
fn endless() -> Graph {
    let mut c = Chance::new(1);
    let h = c.b.param("h", 1.0);
    let symbol = c.b.symbol("X");
    let ball = c.b.primitive(PrimitiveKind::Sphere, []);
    let drawn = c.rand(0.5, 0.9);
    let again = c.refer(symbol, [(h, Expr::from(h) * drawn)]);
    let small = c.map(TransformKind::UScale, [0.7.into()], again);
    let moved = c.map(TransformKind::Move, [0.0.into(), 0.0.into(), h.into()], small);
    let both = c.b.union([ball, moved, moved]);
    let pick = c.draw(Function::Pick, [1.0, 4.0].map(Expr::from));
    c.b.rules(symbol, Some(pick), [ball, both]);
    c.b.finish(symbol).expect("a graph")
}

/// All states that a few steps from the root lead to.
fn states(graph: &Graph) -> Vec<State> {
    let mut states = vec![graph.root_state()];
    let mut next = 0;
    while next < states.len() && states.len() < 300 {
        let below = graph.step(&states[next]).expect("a step").into_states();
        states.extend(below.into_iter().flatten());
        next += 1;
    }
    states
}

/// By how much one envelope reaches further than another, relative to their size.
fn excess(one: &Body, other: &Body) -> f64 {
    let planes = one.slabs.max.iter().zip(&other.slabs.max).map(|(one, other)| one - other);
    let planes = planes.chain(one.slabs.min.iter().zip(&other.slabs.min).map(|(one, other)| other - one));
    planes.fold(one.radius - other.radius, f64::max) / other.radius
}

#[test]
fn questions_are_answered_as_plainly() {
    let graphs = [
        (terrain(1, 7, 0.3), true),
        (thinning(1), false),
        (mixture(1), false),
        (mixture(4), false),
        (endless(), true),
    ];
    for (graph, same) in graphs {
        let envelopes = Envelopes::new(graph.clone(), &Limits::default());
        let mut asked = 0;
        for state in states(&graph) {
            let key = envelopes.key(&state);
            if !envelopes.keys.varies(key) {
                continue;
            }
            asked += 1;
            let plain = envelope(envelopes.question(), key, envelopes.varying(&state).collect());
            let plain = plain.expect("an envelope");
            let found = envelopes.of(&state).expect("an envelope").0;
            // Chains of maps begin and end elsewhere: through unions, but not through keys that several ways lead to.
            let margin = if same { 1e-12 } else { 0.05 };
            let off = [excess(&found, &plain), excess(&plain, &found)];
            assert!(off[0] < margin && (!same || off[1] < margin), "{off:?} {found:?} {plain:?}");
            let (bounds, whole) = (envelopes.aabb(&state).expect("a box"), found.slabs.aabb());
            let off = (bounds.min - whole.min).abs().max((bounds.max - whole.max).abs());
            assert!(off.max_element() < 1e-12 * found.radius, "{bounds:?} {whole:?}");
        }
        assert!(asked > 3, "{asked}");
    }
}

/// More keys than a question visits, one below the other and none of them shared.
#[test]
fn what_is_too_much_is_known_in_general() {
    let mut c = Chance::new(1);
    let h = c.b.param("h", 0.0);
    let ball = c.b.primitive(PrimitiveKind::Sphere, []);
    let mut tower = c.map(TransformKind::Move, [0.0.into(), 0.0.into(), h.into()], ball);
    for _ in 0..3000 {
        tower = c.b.calculate([(h, Expr::from(h) * 0.5)], tower);
        tower = c.map(TransformKind::Move, [0.001, 0.0, 0.0].map(Expr::from), tower);
    }
    let drawn = c.rand(-1.0, 1.0);
    let root = c.refer(tower, []);
    let root = c.b.calculate([(h, drawn)], root);
    let envelopes = Envelopes::new(c.b.finish(root).expect("a graph"), &Limits::default());
    let found = envelopes.aabb(&envelopes.graph().root_state()).expect("a box");
    let expected = Aabb::new(DVec3::new(2.0, -1.0, -1.0), DVec3::new(4.0, 1.0, 1.0));
    assert!((found.min - expected.min).abs().max_element() < 1e-6, "{found:?}");
    assert!((found.max - expected.max).abs().max_element() < 1e-6, "{found:?}");
}

/// The same, where each is what it has in common with a ball.
#[test]
fn operands_of_intersections_are_counted() {
    let mut c = Chance::new(1);
    let h = c.b.param("h", 0.0);
    let ball = c.b.primitive(PrimitiveKind::Sphere, []);
    let mut tower = c.map(TransformKind::Move, [0.0.into(), 0.0.into(), h.into()], ball);
    for _ in 0..2 * KEYS {
        tower = c.b.operator(Operator::Intersection, tower, ball);
    }
    let drawn = c.rand(-1.0, 1.0);
    let root = c.refer(tower, []);
    let root = c.b.calculate([(h, drawn)], root);
    let envelopes = Envelopes::new(c.b.finish(root).expect("a graph"), &Limits::default());
    let state = envelopes.graph().root_state();
    let mut plan = Plan::default();
    plan.make(&envelopes.keys, envelopes.key(&state), envelopes.varying(&state));
    assert!((KEYS / 2..=KEYS).contains(&plan.made().len()), "{}", plan.made().len());
}
