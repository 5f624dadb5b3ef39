//! `pcsg graph`.

use crate::{path, run, scene};

#[test]
fn the_graph_is_drawn() {
    let sympodial = scene("sympodial.pcsg");
    let (code, out, _, _) = run(&["graph", path(&sympodial)]);
    assert_eq!(code, 0);
    assert!(out.starts_with("digraph") && out.contains("TR"), "{out}");
}
