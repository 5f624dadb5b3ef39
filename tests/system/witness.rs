//! Counts and boxes against `witness.json`, which a program of other authors and another language computed: NumPy, from its
//! own description of the scenes, by unfolding them.

use csg_graph::Limits;
use csg_graph_bounds::{Aabb, chain, conventional};
use csg_graph_tests::repository;
use glam::DVec3;
use serde_json::Value;

use crate::scene;

/// The chain algorithm is walked for trees up to this many primitives; the larger ones have their counts checked.
const WALKED: u64 = 20_000;

fn corner(row: &Value, name: &str) -> Option<DVec3> {
    let numbers: Vec<f64> = row[name].as_array()?.iter().filter_map(Value::as_f64).collect();
    Some(DVec3::from_slice(&numbers))
}

#[test]
fn counts_and_boxes_agree_with_an_independent_program() {
    let text = std::fs::read_to_string(repository().join("tests/witness.json")).unwrap();
    let rows: Vec<Value> = serde_json::from_str(&text).unwrap();
    assert!(rows.len() > 20);
    for row in &rows {
        let name = row["scene"].as_str().unwrap();
        let set = row["set"].as_object().unwrap();
        let set: Vec<_> = set.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        let graph = scene(name, &set).graph;
        let analysis = graph.analyse(&Limits::default()).unwrap();
        let what = format!("{name} {set:?}");
        assert_eq!(row["primitives"], analysis.primitives.to_string(), "primitives of {what}");
        assert_eq!(row["instances"], analysis.instances.to_string(), "instances of {what}");
        assert_eq!(row["states"], analysis.states, "states of {what}");
        assert_eq!(row["depth"], analysis.depth, "depth of {what}");

        let (Some(min), Some(max)) = (corner(row, "min"), corner(row, "max")) else { continue };
        let exact = Aabb::new(min, max);
        let limits = csg_graph_bounds::Limits::default();
        let least = csg_graph_bounds::exact(&graph, &limits).unwrap().root;
        let off = (least.min - min).abs().max((least.max - max).abs()).max_element();
        assert!(off < 1e-9, "{what}: {least:?} is not {exact:?}");
        if analysis.primitives > WALKED.into() {
            continue;
        }
        let tight = chain(&graph, &limits).unwrap().root;
        let loose = conventional(&graph, &limits).unwrap().root;
        let slack = DVec3::splat(1e-9);
        let grown = |aabb: Aabb| Aabb::new(aabb.min - slack, aabb.max + slack);
        assert!(grown(tight).encloses(exact), "{what}: {tight:?} cuts {exact:?}");
        assert!(grown(loose).encloses(tight), "{what}: {loose:?} cuts {tight:?}");
        assert!(grown(tight).encloses(least), "{what}: {tight:?} cuts {least:?}");
        let excess = (tight.size() / exact.size()).max_element() - 1.0;
        assert!(excess < csg_graph_bounds::EXCESS, "{what}: the chain box is {excess} too large");
    }
}

#[test]
fn the_conventional_box_of_the_sympodial_tree_is_several_times_too_large() {
    let graph = scene("sympodial", &[]).graph;
    let limits = csg_graph_bounds::Limits::default();
    let ratio =
        conventional(&graph, &limits).unwrap().root.volume() / chain(&graph, &limits).unwrap().root.volume();
    assert!(ratio > 5.0, "{ratio}");
}

#[test]
fn contractive_copies_do_not_grow() {
    for n in 0..8 {
        let graph = scene("sierpinski", &[format!("n = {n}")]).graph;
        let unit = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
        let limits = csg_graph_bounds::Limits::default();
        for found in [conventional(&graph, &limits).unwrap().root, chain(&graph, &limits).unwrap().root] {
            let off = (found.min - unit.min).abs().max((found.max - unit.max).abs()).max_element();
            assert!(off < 1e-12, "depth {n}: {found:?}");
        }
    }
}
