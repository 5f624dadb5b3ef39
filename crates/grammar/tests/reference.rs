//! `docs/language.md` says what the code does. Published crates do not carry it; then there is nothing to test.

use std::fs;
use std::path::Path;

use csg_graph::{Function, NORMAL_REACH, PrimitiveKind, TransformKind};
use csg_graph_grammar::{load, parse, print};

fn reference() -> Option<String> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(package.join("../../docs/language.md"));
    // Cargo puts that file into what it publishes.
    text.map(Some).unwrap_or_else(|error| {
        assert!(package.join("Cargo.toml.orig").exists(), "docs/language.md: {error}");
        None
    })
}

/// The rows of the table that follows a heading, as `signature` and summary.
fn table(text: &str, heading: &str) -> Vec<(String, String)> {
    let section = text.split(&format!("\n## {heading}\n")).nth(1).expect("the heading");
    let rows = section.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
    let rows = rows.take_while(|line| line.starts_with('|')).filter_map(|row| {
        let (name, summary) = row.strip_prefix("| `")?.split_once("` | ")?;
        Some((name.to_owned(), summary.strip_suffix(" |")?.to_owned()))
    });
    rows.collect()
}

fn rows(entries: impl Iterator<Item = (&'static str, &'static str)>) -> Vec<(String, String)> {
    entries.map(|(signature, summary)| (signature.to_owned(), summary.to_owned())).collect()
}

#[test]
fn the_tables_are_those_of_the_graph() {
    let Some(text) = reference() else { return };
    let primitives = PrimitiveKind::ALL.iter().map(|kind| (kind.signature(), kind.summary()));
    assert_eq!(table(&text, "Primitives"), rows(primitives));
    let transforms = TransformKind::ALL.iter().map(|kind| (kind.signature(), kind.summary()));
    assert_eq!(table(&text, "Transformations"), rows(transforms));
    let functions = Function::ALL.iter().map(|function| (function.signature(), function.summary()));
    assert_eq!(table(&text, "Functions"), rows(functions));
    assert!(text.contains(&format!("{NORMAL_REACH} deviations")));
}

#[test]
fn the_examples_are_sound_and_survive_printing() {
    let Some(text) = reference() else { return };
    let examples: Vec<_> = text
        .split("```pcsg\n")
        .skip(1)
        .map(|rest| rest.split("```").next().expect("the end of the example"))
        .collect();
    assert!(examples.len() > 5);
    for example in examples {
        let lowered =
            load(example, &[]).unwrap_or_else(|reports| panic!("{}", reports[0].render("", example, false)));
        assert_eq!(lowered.warnings, [], "{example}");
        let analysis = lowered.scene.graph.analyse(&Default::default());
        analysis.unwrap_or_else(|error| {
            panic!("{}", lowered.scene.explain(&error)[0].render("", example, false));
        });
        let printed = print(&parse(example).tree);
        assert!(load(&printed, &[]).is_ok(), "{printed}");
    }
}

#[test]
fn precedence_is_as_written() {
    for (expression, value) in [
        ("-2^2", -4.0),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("2^-1*3", 1.5),
        ("-1 % 8", 7.0),
        ("1 + 2 * 3 - 4 / 2", 5.0),
        ("10 - 3 - 2", 5.0),
        ("1 < 2 && 2 < 1 || 3 == 3", 1.0),
        ("!0 + 1", 2.0),
        ("!1 == 0", 1.0),
        ("--1", 1.0),
        ("if(0, 1/0, 7)", 7.0),
        (".5 + 1.e1 + 2E-1", 10.7),
        ("round(sin(90) * pi)", 3.0),
    ] {
        let scene = load(&format!("{{ _x = {expression}; }} sphere"), &[]).unwrap().scene;
        let x = scene.graph.params().next().unwrap();
        assert_eq!(scene.graph.initial().get(x), Some(value), "{expression}");
    }
}

#[test]
fn terms_group_as_written() {
    let shape = |term: &str| {
        let source = format!("{{}} {term}");
        let scene = load(&source, &[]).unwrap_or_else(|reports| panic!("{}", reports[0])).scene;
        let tree = scene.graph.unfold(1000).unwrap();
        let mut stack: Vec<String> = Vec::new();
        for node in tree.nodes() {
            let text = match node {
                csg_graph::UnfoldedNode::Primitive { node, .. } => scene.graph.node_name(*node),
                csg_graph::UnfoldedNode::Operator { operator, operands } => {
                    format!("({}{}{})", stack[operands[0]], operator.sign(), stack[operands[1]])
                }
            };
            stack.push(text);
        }
        stack.pop().unwrap()
    };
    assert_eq!(shape("sphere | cube & cone"), "(sphere∪(cube∩cone))");
    assert_eq!(shape("sphere & cube | cone & sphere"), "((sphere∩cube)∪(cone∩sphere))");
    assert_eq!(shape("sphere \\ cube | cone"), "((sphere\\cube)∪cone)");
    assert_eq!(shape("sphere - cube - cone"), "((sphere\\cube)\\cone)");
    assert_eq!(shape("sphere | (cube | cone)"), "(sphere∪(cube∪cone))");
    assert_eq!(shape("flipxy(sphere ∪ cube) ∩ cone"), "((sphere∪cube)∩cone)");
}
