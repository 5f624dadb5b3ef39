//! Tests of the whole system.

mod agreement;
mod broken;
mod documents;
mod scenes;
mod witness;

use csg_graph_grammar::{Override, Scene, load};
use csg_graph_tests::repository;

/// A scene of the corpus with parameters set.
fn scene(name: &str, set: &[String]) -> Scene {
    let path = repository().join("scenes").join(name).with_extension("pcsg");
    let source = std::fs::read_to_string(&path).expect("the corpus has the scene");
    let overrides: Vec<_> =
        set.iter().map(|set| Override::parse(set).expect("the assignment is sound")).collect();
    load(&source, &overrides).expect("the scene has no mistakes").scene
}
