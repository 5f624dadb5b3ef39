//! What holds for every graph, tried on random ones.
#![cfg(feature = "csg-graph")]
#![expect(clippy::unwrap_used, reason = "a test that fails to build its graph fails")]

mod common;

use common::{Recipe, polytope_recipes, recipes, transforms, unfold, union_recipes};
use csg_graph::{Graph, Primitive, PrimitiveKind, Transform};
use csg_graph_bounds::{
    Aabb, EXCESS, HyperBoxes, Limits, Map, PointSet, Shape, chain, conventional, exact, root_box,
};
use glam::DVec3;
use proptest::prelude::*;

/// What the tests' own arithmetic may err, relative to the coordinates in play.
const TOLERANCE: f64 = 1e-11;

/// What exact boxes are rounded outward by, at most, relative to the coordinates in play.
const MARGIN: f64 = 1e-9;

fn both(graph: &Graph) -> [HyperBoxes; 2] {
    let limits = Limits::default();
    [conventional(graph, &limits).unwrap(), chain(graph, &limits).unwrap()]
}

fn grown(bounds: Aabb, margin: f64) -> Aabb {
    if bounds.is_empty() { bounds } else { Aabb::new(bounds.min - margin, bounds.max + margin) }
}

/// The largest coordinate that a box of the graph has, as a measure for rounding errors.
fn scale(boxes: &HyperBoxes) -> f64 {
    boxes
        .nodes
        .iter()
        .filter(|b| !b.is_empty() && b.is_bounded())
        .fold(1.0, |scale, b| b.min.abs().max(b.max.abs()).max_element().max(scale))
}

fn enclosed(outer: &HyperBoxes, inner: &HyperBoxes, margin: f64) -> Result<(), TestCaseError> {
    prop_assert!(grown(outer.root, margin).encloses(inner.root));
    for (outer, inner) in outer.nodes.iter().zip(&inner.nodes) {
        prop_assert!(grown(*outer, margin).encloses(*inner), "{outer:?} {inner:?}");
    }
    Ok(())
}

fn close(a: Aabb, b: Aabb, margin: f64) -> bool {
    grown(a, margin).encloses(b) && grown(b, margin).encloses(a)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_point_escapes(recipe in recipes()) {
        let graph = recipe.graph();
        let tree = unfold(&graph, &graph.root_state());
        for boxes in both(&graph) {
            let margin = TOLERANCE * scale(&boxes);
            let mut escaped = None;
            let points = tree.sample(&mut |state, p| {
                let found = boxes.nodes[state.node().index()];
                if !grown(found, margin).contains(p) {
                    escaped = Some((state.clone(), p, found));
                }
            });
            prop_assert_eq!(escaped, None);
            prop_assert!(points.iter().all(|p| grown(boxes.root, margin).contains(*p)));
        }
    }

    #[test]
    fn no_point_escapes_the_box_of_its_state(recipe in recipes()) {
        let graph = recipe.graph();
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let margin = TOLERANCE * scale(&conventional(&graph, &Limits::default()).unwrap());
        let mut escaped = None;
        let tree = unfold(&graph, &graph.root_state());
        tree.sample(&mut |state, p| {
            let found = boxes.of(state).unwrap().aabb;
            if !grown(found, margin).contains(p) {
                escaped = Some((state.clone(), p, found));
            }
        });
        prop_assert_eq!(escaped, None);
        let root = root_box(&graph, &Limits::default()).unwrap();
        prop_assert!(close(root.aabb, boxes.root, margin), "{:?} {:?}", root, boxes.root);
    }

    #[test]
    fn exact_boxes_of_unions_are_exact(recipe in union_recipes()) {
        let graph = recipe.graph();
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let [_, chain] = both(&graph);
        let margin = MARGIN * scale(&chain);
        let tree = unfold(&graph, &graph.root_state());
        let mut wrong = None;
        tree.visit(&mut |instance| {
            let (found, least) = (boxes.of(&instance.state).unwrap(), instance.exact_box());
            if !close(found.aabb, least, margin) {
                wrong = Some((instance.state.clone(), found, least));
            }
        });
        prop_assert_eq!(wrong, None);
        prop_assert!(boxes.gap <= margin);
        prop_assert!(grown(chain.root, margin).encloses(boxes.root));
        for (outer, inner) in chain.nodes.iter().zip(&boxes.nodes) {
            prop_assert!(grown(*outer, margin).encloses(*inner), "{outer:?} {inner:?}");
        }
    }

    #[test]
    fn exact_boxes_of_polytopes_are_those_of_chains(recipe in polytope_recipes()) {
        let graph = recipe.graph();
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let [_, chain] = both(&graph);
        let margin = MARGIN * scale(&chain);
        prop_assert!(close(chain.root, boxes.root, margin));
        for (chain, exact) in chain.nodes.iter().zip(&boxes.nodes) {
            prop_assert!(close(*chain, *exact, margin), "{chain:?} {exact:?}");
        }
    }

    #[test]
    fn conventional_boxes_enclose_those_of_chains_and_these_exact_ones(recipe in recipes()) {
        let graph = recipe.graph();
        let exact = exact(&graph, &Limits::default()).unwrap().into_hyper_boxes();
        let [conventional, chain] = both(&graph);
        let margin = TOLERANCE * scale(&conventional);
        enclosed(&conventional, &chain, margin)?;
        enclosed(&chain, &exact, margin)?;
        enclosed(&conventional, &exact, margin)?;
    }

    #[test]
    fn chain_boxes_of_unions_are_tight(recipe in union_recipes()) {
        let graph = recipe.graph();
        let [_, chain] = both(&graph);
        let margin = TOLERANCE * scale(&chain);
        let tree = unfold(&graph, &graph.root_state());
        let mut least = vec![Aabb::EMPTY; graph.node_count()];
        tree.visit(&mut |instance| {
            let node = instance.node();
            least[node] = least[node].join(instance.exact_box());
        });
        least.push(tree.exact_box());
        for (least, found) in least.iter().zip(chain.nodes.iter().chain([&chain.root])) {
            prop_assert!(grown(*found, margin).encloses(*least), "{found:?} {least:?}");
            if !least.is_empty() {
                let most = least.size() * (1.0 + EXCESS) + margin;
                prop_assert!(found.size().cmple(most).all(), "{found:?} {least:?}");
            }
        }
    }

    #[test]
    fn tree_dag_and_cyclic_graph_have_the_same_boxes(recipe in recipes()) {
        let cyclic = both(&recipe.graph());
        for shared in [true, false] {
            for (cyclic, acyclic) in cyclic.iter().zip(both(&recipe.acyclic(shared))) {
                prop_assert_eq!(cyclic.root, acyclic.root);
            }
        }
    }

    /// Only of unions: which of several bounds an exact box of an ∩ takes is a matter of what is asked first, and what is one
    /// state in a graph may be two in a tree. Each of those boxes holds its solid, and lies in the one of the chain.
    #[test]
    fn tree_dag_and_cyclic_graph_have_the_same_exact_boxes_of_unions(recipe in union_recipes()) {
        let root = |graph: &Graph| exact(graph, &Limits::default()).unwrap().root;
        let cyclic = recipe.graph();
        let margin = MARGIN * scale(&both(&cyclic)[0]);
        for shared in [true, false] {
            prop_assert!(close(root(&cyclic), root(&recipe.acyclic(shared)), margin));
        }
    }

    #[test]
    fn exact_boxes_of_trees_and_dags_hold_every_point(recipe in recipes()) {
        let cyclic = recipe.graph();
        let margin = TOLERANCE * scale(&both(&cyclic)[0]);
        let points = unfold(&cyclic, &cyclic.root_state()).sample(&mut |_, _| {});
        for shared in [true, false] {
            let acyclic = recipe.acyclic(shared);
            let found = exact(&acyclic, &Limits::default()).unwrap().root;
            prop_assert!(points.iter().all(|p| grown(found, margin).contains(*p)), "{:?}", found);
            prop_assert!(grown(chain(&acyclic, &Limits::default()).unwrap().root, margin).encloses(found));
        }
    }

    #[test]
    fn images_hold_the_primitive(
        kind in common::primitives(),
        maps in prop::collection::vec(transforms(), 0..12),
    ) {
        let common::Term::Primitive(kind, args) = kind else { unreachable!() };
        let primitive = kind.evaluate(&args).unwrap();
        let maps: Vec<Transform> = maps.iter().filter_map(|(kind, args)| kind.evaluate(args)).collect();
        let PointSet::Points(points) = primitive.point_set() else { unreachable!() };
        let image = |p: &DVec3| maps.iter().fold(*p, |p, map| Map::point(map, p));
        let bounds = Aabb::from_points(points.iter().map(image));
        let surface: Vec<_> = common::directions().map(|d| common::support_point(&primitive, d)).collect();
        for p in surface.iter().map(image) {
            let margin = TOLERANCE * (1.0 + bounds.size().max_element() + p.abs().max_element());
            prop_assert!(grown(bounds, margin).contains(p));
        }
    }

    #[test]
    fn many_points_are_mapped_like_one((kind, args) in transforms(), p in prop::array::uniform3(-9.0..9.0)) {
        let p = DVec3::from_array(p);
        if let Some(map) = kind.evaluate(&args) {
            let mut many = [p, 2.0 * p];
            Map::points(&map, &mut many);
            prop_assert!((many[0] - Map::point(&map, p)).abs().max_element() < 1e-13);
            prop_assert!((many[1] - Map::point(&map, 2.0 * p)).abs().max_element() < 1e-13);
        }
    }
}

#[test]
fn primitives_have_their_least_boxes() {
    for kind in PrimitiveKind::ALL {
        let args: &[f64] = match kind {
            PrimitiveKind::Frustum => &[1.5],
            PrimitiveKind::Torus => &[0.3],
            PrimitiveKind::Hull => &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0],
            _ => &[],
        };
        let primitive = kind.evaluate(args).unwrap();
        if primitive == Primitive::HalfSpace {
            assert_eq!(primitive.bounds(), Aabb { max: DVec3::INFINITY.with_z(0.0), ..Aabb::ALL });
            assert_eq!(primitive.point_set(), PointSet::Unbounded);
            assert!(primitive.support(DVec3::Z).abs() < f64::MIN_POSITIVE);
            assert!(primitive.support(-DVec3::Z) > f64::MAX);
            continue;
        }
        let axes = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
        let exact = Aabb::from_points(axes.map(|d| d * common::support_point(&primitive, d).dot(d).abs()));
        let exact = Aabb::new(
            DVec3::from_array(DVec3::AXES.map(|axis| common::support_point(&primitive, -axis).dot(axis))),
            exact.max,
        );
        assert!(primitive.bounds().encloses(exact), "{kind:?}");
        assert!(close(primitive.bounds(), exact, 1e-15), "{kind:?} {:?} {exact:?}", primitive.bounds());
        for d in common::directions().chain(DVec3::AXES) {
            let exact = common::support_point(&primitive, d).dot(d);
            assert!((primitive.support(d) - exact).abs() < 1e-14, "{kind:?} {d}");
            // Directions of any length.
            for factor in [2.0, 1e-200, 1e-310, 1e200] {
                let found = primitive.support(factor * d);
                let error = 4.0 * f64::EPSILON * factor * primitive.bounds().size().length();
                assert!((found - factor * exact).abs() <= error + 1e-320, "{kind:?} {d} {factor}");
            }
        }
        // Along the axes, point sets exceed nothing.
        let PointSet::Points(points) = primitive.point_set() else { panic!("{kind:?} is bounded") };
        assert!(close(Aabb::from_points(points.iter().copied()), exact, 1e-14), "{kind:?}");
    }
}

#[test]
fn recipes_recurse() {
    let step = common::Term::Operator(
        csg_graph::Operator::Union,
        Box::new(common::Term::Primitive(PrimitiveKind::Cube, vec![])),
        Box::new(common::Term::Transform(
            csg_graph::TransformKind::Move,
            vec![3.0, 0.0, 0.0],
            Box::new(common::Term::Again),
        )),
    );
    let recipe = Recipe { n: 2, step, base: common::Term::Primitive(PrimitiveKind::Sphere, vec![]) };
    let [boxes, _] = both(&recipe.graph());
    assert!(close(boxes.root, Aabb::new(DVec3::NEG_ONE, DVec3::new(7.0, 1.0, 1.0)), 1e-12));
}
