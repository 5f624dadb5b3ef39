//! Fig. 1.1a of the paper, in the paper's Unicode and in ASCII.

use csg_graph_grammar::{Override, load, parse, print};

const UNICODE: &str = include_str!("figures/sympodial.pcsg");

fn ascii() -> String {
    UNICODE.replace('∪', "|").replace('→', "->")
}

#[test]
fn unicode_and_ascii_give_the_same_graph() {
    let unicode = load(UNICODE, &[]).unwrap();
    let ascii = load(&ascii(), &[]).unwrap();
    assert_eq!(unicode.warnings, []);
    let nodes = |graph: &csg_graph::Graph| graph.nodes().map(|node| format!("{node:?}")).collect::<Vec<_>>();
    assert_eq!(nodes(&unicode.scene.graph), nodes(&ascii.scene.graph));
    assert_eq!(unicode.scene.graph.root(), ascii.scene.graph.root());
    assert_eq!(unicode.scene.graph.initial(), ascii.scene.graph.initial());
}

#[test]
fn the_tree_has_as_many_primitives_as_the_paper_s_grammar_makes() {
    for (cnt, primitives) in [("8", "4097"), ("12", "65537"), ("60", "18446744073709551617")] {
        let cnt = Override::parse(&format!("cnt = {cnt}")).unwrap();
        let scene = load(UNICODE, &[cnt]).unwrap().scene;
        let analysis = scene.graph.analyse(&Default::default()).unwrap();
        assert_eq!(analysis.primitives.to_string(), primitives);
    }
}

#[test]
fn overrides_are_seen_by_later_initial_values() {
    let scene = load(UNICODE, &[Override::parse("segments = 4*2").unwrap()]).unwrap().scene;
    let value = |name: &str| {
        let param = scene.graph.params().find(|param| scene.graph.param_name(*param) == name).unwrap();
        scene.graph.initial().get(param).unwrap()
    };
    assert_eq!((value("segments"), value("dSG")), (8.0, 0.125));
}

#[test]
fn the_printer_keeps_the_author_s_operators() {
    let unicode = print(&parse(UNICODE).tree);
    let ascii = print(&parse(&ascii()).tree);
    assert!(unicode.contains('∪') && unicode.contains('→'));
    assert!(ascii.is_ascii() && ascii.contains("TR -> SG"));
    assert_eq!(unicode.lines().count(), ascii.lines().count());
}

#[test]
fn the_printed_figure_looks_like_the_figure() {
    assert_eq!(print(&parse(UNICODE).tree), include_str!("figures/sympodial_printed.pcsg"));
}
