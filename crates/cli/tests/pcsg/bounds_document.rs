//! The counts in docs/bounds.md, and the remedy that it recommends.

use std::fs;

use crate::{path, pcsg, repository, scene};

/// What `check` prints of a command's states: those of symbols, and of all nodes.
fn states(command: &[&str]) -> [String; 2] {
    let output = pcsg(&repository("."), command).output().expect("the program starts");
    let printed = String::from_utf8(output.stdout).expect("the program speaks UTF-8");
    let line = printed.lines().find(|line| line.trim_start().starts_with("states"));
    let line = line.unwrap_or_else(|| panic!("{command:?} counts no states"));
    let is_number = |c: char| c.is_ascii_digit() || c == ',';
    let numbers: Vec<_> = line.split(|c| !is_number(c)).filter(|word| !word.is_empty()).collect();
    [numbers[0].to_owned(), numbers[numbers.len() - 1].to_owned()]
}

#[test]
fn the_states_in_the_document_are_those_of_its_commands() {
    let text = fs::read_to_string(repository("docs/bounds.md")).unwrap();
    let block = text.split("```states\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    for line in block.lines() {
        let (command, counts) = line.split_once('#').unwrap();
        let command: Vec<_> = command.split_whitespace().skip(1).collect();
        let [symbols, all] = states(&command);
        assert_eq!(counts.trim(), format!("{symbols} states, {all} of all nodes"), "{command:?}");
        assert!(text.matches(&all).count() > 1 || command.contains(&"cnt=16"), "the table lacks {all}");
    }
}

#[test]
fn counting_turns_leaves_as_few_states_as_there_are_turns() {
    let text = fs::read_to_string(repository("docs/bounds.md")).unwrap();
    let remedy = text.split("```pcsg\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let (rule, limb) = remedy.split_once("\n\n").unwrap();
    let scene = fs::read_to_string(scene("sympodial_width.pcsg")).unwrap();
    let replace = |text: &str, from: &str, to: &str, by: &str| {
        let (before, rest) = text.split_once(from).unwrap();
        let (_, after) = rest.split_once(to).unwrap();
        format!("{before}{by}{to}{after}")
    };
    let counted = replace(&scene, "3: TR", "\n\n", rule);
    let counted = replace(&counted, "limb =", "\nblossom", limb.trim_end());
    let counted = counted.replace("} TR\n", "  l = 0;\n  r = 0;\n} TR\n");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turns.pcsg");
    fs::write(&file, counted).unwrap();
    let [symbols, all] =
        states(&["check", path(&file), "--set", "cnt=20", "--set", "fW1=0.74", "--set", "fW2=0.87"]);
    assert_eq!(symbols, "232");
    assert!(text.contains(&all), "the table lacks {all}");
}
