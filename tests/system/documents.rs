//! Prose that could go stale: paths, crate arrows, citations, commands, and the README's example.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use csg_graph_tests::repository;

fn documents() -> Vec<(PathBuf, String)> {
    let root = repository();
    let mut paths: Vec<PathBuf> =
        ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].iter().map(|name| root.join(name)).collect();
    for folder in [root.join("docs"), root.join("tests/broken")] {
        paths.extend(files(&folder).into_iter().filter(|path| path.extension().is_some_and(|e| e == "md")));
    }
    paths
        .into_iter()
        .map(|path| (path.clone(), std::fs::read_to_string(&path).expect("a document")))
        .collect()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(folder) = pending.pop() {
        for entry in std::fs::read_dir(&folder).expect("the folder exists") {
            let path = entry.expect("the folder can be read").path();
            if path.is_dir() { pending.push(path) } else { found.push(path) }
        }
    }
    found.sort();
    found
}

/// The targets of Markdown links, and what stands in backquotes and looks like a path of the repository.
fn mentioned_paths(text: &str) -> Vec<&str> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let quoted = text.split('`').skip(1).step_by(2).filter(|word| {
        ["crates/", "docs/", "scenes/", "tests/", "xtask/", ".ci/"]
            .iter()
            .any(|start| word.starts_with(start))
            && !word.contains(char::is_whitespace)
            && !word.contains(['*', 'N'])
    });
    links.chain(quoted).filter(|path| !path.starts_with("http") && !path.starts_with('#')).collect()
}

#[test]
fn every_path_in_the_documents_exists() {
    for (document, text) in documents() {
        let folder = document.parent().unwrap();
        for path in mentioned_paths(&text) {
            let path = path.split('#').next().unwrap_or(path);
            let exists = folder.join(path).exists() || repository().join(path).exists();
            assert!(exists, "{} mentions {path}", document.display());
        }
    }
}

#[test]
fn every_citation_is_in_the_references() {
    let references = std::fs::read_to_string(repository().join("docs/references.md")).unwrap();
    let mut texts: Vec<PathBuf> = files(&repository().join("crates"));
    texts.extend(files(&repository().join("docs")));
    let known: BTreeSet<&str> = citations(&references).collect();
    let mut cited = BTreeSet::new();
    for path in texts.iter().filter(|path| path.extension().is_some_and(|e| e == "rs" || e == "md")) {
        let text = std::fs::read_to_string(path).unwrap();
        for tag in citations(&text) {
            assert!(known.contains(tag), "{} cites [{tag}], which docs/references.md lacks", path.display());
            cited.insert(tag.to_owned());
        }
    }
    assert!(cited.contains("TRAX95"));
}

/// `TRAX95` in `[TRAX95]` or `\[TRAX95\]`: four capitals and two digits.
fn citations(text: &str) -> impl Iterator<Item = &str> {
    text.split('[').skip(1).filter_map(|rest| {
        let tag = rest.get(..6)?;
        let closed = rest[6..].starts_with(']') || rest[6..].starts_with("\\]");
        let (letters, digits) = tag.split_at_checked(4)?;
        let fits =
            letters.chars().all(|c| c.is_ascii_uppercase()) && digits.chars().all(|c| c.is_ascii_digit());
        (closed && fits).then_some(tag)
    })
}

#[test]
fn crates_depend_on_each_other_as_the_architecture_says() {
    let metadata = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(repository())
        .output()
        .unwrap();
    let metadata: serde_json::Value = serde_json::from_slice(&metadata.stdout).unwrap();
    let mut arrows = BTreeSet::new();
    for package in metadata["packages"].as_array().unwrap() {
        let name = package["name"].as_str().unwrap();
        let dependencies = package["dependencies"].as_array().unwrap();
        let internal = dependencies.iter().filter(|d| d["path"].is_string() && d["kind"].is_null());
        arrows.extend(internal.map(|d| format!("{name} -> {}", d["name"].as_str().unwrap_or_default())));
    }
    let text = std::fs::read_to_string(repository().join("docs/architecture.md")).unwrap();
    let block = text.split("```arrows").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let drawn: BTreeSet<String> = block
        .lines()
        .filter_map(|line| line.split_once("->"))
        .flat_map(|(from, to)| to.split(',').map(move |to| format!("{} -> {}", from.trim(), to.trim())))
        .collect();
    assert_eq!(drawn, arrows);
}

#[test]
fn the_examples_of_the_readme_are_sound() {
    let text = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let example = text.split("```pcsg").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let lowered = csg_graph_grammar::load(example, &[]).unwrap();
    assert!(lowered.warnings.is_empty(), "{:?}", lowered.warnings);
    assert!(lowered.scene.graph.analyse(&Default::default()).is_ok());
}
