//! Every file in `tests/broken` is told what is written in it, and nothing else. The README there says how it is written.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use csg_graph_grammar::{Diagnostic, decode, load};

/// A diagnostic that a file asks for.
struct Expected {
    severity: String,
    position: (usize, usize),
    message: String,
    help: Option<String>,
}

/// Reads the first lines of a file.
fn expected(text: &str) -> Option<Vec<Expected>> {
    let mut all: Vec<Expected> = Vec::new();
    for line in text.lines().map_while(|line| line.strip_prefix("//! ")) {
        let (word, rest) = line.split_once(' ')?;
        if word == "help" {
            all.last_mut()?.help = Some(rest.to_owned());
            continue;
        }
        let (position, message) = rest.split_once(' ')?;
        let (line, column) = position.split_once(':')?;
        let position = (line.parse().ok()?, column.parse().ok()?);
        all.push(Expected { severity: word.to_owned(), position, message: message.to_owned(), help: None });
    }
    (!all.is_empty()).then_some(all)
}

/// What is told about a file, phase by phase, until one finds errors.
fn told(name: &str, bytes: &[u8]) -> Vec<Diagnostic> {
    let text = match decode(name, bytes) {
        Ok(text) => text,
        Err(report) => return vec![*report],
    };
    match load(text, &[]) {
        Err(reports) => reports,
        Ok(lowered) => {
            let error = lowered.scene.graph.analyse(&Default::default()).err();
            let errors = error.map(|error| lowered.scene.explain(&error));
            lowered.warnings.into_iter().chain(errors.into_iter().flatten()).collect()
        }
    }
}

fn agrees(expected: &Expected, told: &Diagnostic, text: &str) -> bool {
    let severity = if told.is_error() { "error" } else { "warning" };
    severity == expected.severity
        && told.position(text) == expected.position
        && told.message.contains(&expected.message)
        && expected
            .help
            .as_ref()
            .is_none_or(|help| told.help.as_ref().is_some_and(|told| told.contains(help)))
}

/// What is wrong with what is told about a file.
fn complaint(path: &Path) -> Option<String> {
    let bytes = fs::read(path).expect("a file of the folder");
    let text = String::from_utf8_lossy(&bytes);
    let Some(expected) = expected(&text) else { return Some(format!("{}: expects nothing", path.display())) };
    let told = told(&path.display().to_string(), &bytes);
    let right = told.len() == expected.len()
        && told.iter().any(Diagnostic::is_error)
        && expected.iter().zip(&told).all(|(expected, told)| agrees(expected, told, &text));
    (!right).then(|| {
        let mut complaint = format!("{}: told\n", path.display());
        for report in told {
            let (line, column) = report.position(&text);
            let severity = if report.is_error() { "error" } else { "warning" };
            let _ = writeln!(complaint, "//! {severity} {line}:{column} {}", report.message);
            report.help.iter().for_each(|help| complaint.push_str(&format!("//! help {help}\n")));
        }
        complaint
    })
}

#[test]
fn broken_files_are_told_what_is_wrong() {
    let folder = csg_graph_tests::repository().join("tests/broken");
    let entries = fs::read_dir(folder).expect("the folder of broken files");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "pcsg"));
    files.sort();
    assert!(files.len() > 100, "{} files", files.len());
    let complaints: Vec<_> = files.iter().filter_map(|path| complaint(path)).collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}
