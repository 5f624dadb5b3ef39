//! `pcsg check`: mistakes, counts, and recursion without an end.

use std::fs;

use serde_json::Value;

use crate::{files, path, repository, run, run_in, scene};

#[test]
fn check_counts_exactly() {
    let sympodial = scene("sympodial.pcsg");
    let (code, out, err, _) = run(&["check", path(&sympodial), "--set", "cnt=60", "--format", "json"]);
    assert_eq!((code, err.as_str()), (0, ""));
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["primitives"], "18446744073709551617");
    assert_eq!(report["instances"], "139791732433580195842");
    assert_eq!((&report["states"], &report["distinct_states"]), (&"130".into(), &"67".into()));
    assert_eq!((&report["depth"], &report["terminates"]), (&66.into(), &true.into()));

    let (code, out, _, _) = run(&["check", path(&sympodial)]);
    assert_eq!(code, 0);
    assert!(out.contains("no mistakes") && out.contains("4,097"), "{out}");
}

#[test]
fn text_that_is_not_text_is_said_to_be_so() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("latin.pcsg"), b"{}\n// caf\xe9\nsphere").unwrap();
    let (code, _, err, _) = run_in(folder.path(), &["check", "latin.pcsg"]);
    assert_eq!(code, 1);
    assert!(err.contains("latin.pcsg:2:7") && err.contains("UTF-8"), "{err}");
}

#[test]
fn every_broken_file_ends_with_1_and_its_message() {
    let folder = repository("tests/broken");
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("the repository has broken files") {
        let file = entry.expect("the folder can be read").path();
        if file.extension().is_none_or(|extension| extension != "pcsg") {
            continue;
        }
        let bytes = fs::read(&file).expect("the file can be read");
        let expects_error = String::from_utf8_lossy(&bytes).lines().any(|line| line.starts_with("//! error"));
        let (code, _, err, _) = run(&["check", path(&file)]);
        assert_eq!(code, i32::from(expects_error), "{}: {err}", file.display());
        assert!(err.contains(path(&file)), "{}: {err}", file.display());
        count += 1;
    }
    assert!(count >= 40, "{count} broken files");
}

#[test]
fn a_recursion_without_an_end_has_a_counterexample() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("loop.pcsg"), "{ n = 2; } A\nA -> sphere | uscale(n) A").unwrap();
    let (code, out, err, _) = run_in(folder.path(), &["check", "loop.pcsg", "--format", "json"]);
    assert_eq!(code, 1);
    assert!(err.contains("the recursion of `A` never ends") && err.contains("grows by"), "{err}");
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["terminates"], false);
    assert_eq!(report["counterexample"][0]["symbol"], "A");
}

#[test]
fn what_is_subtracted_from_itself_has_to_shrink() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("loop.pcsg"), "{} A\nA -> sphere \\ rotz(30) A").unwrap();
    for args in [&["check"][..], &["render"], &["bounds"], &["bounds", "--compare"]] {
        let (code, _, err, _) = run_in(folder.path(), &[args, &["loop.pcsg"]].concat());
        assert_eq!(code, 1);
        assert!(err.contains("A → \\ → rotz leads back to itself and does not shrink"), "{err}");
    }
    assert_eq!(files(folder.path()), ["loop.pcsg"]);
}

#[test]
fn a_solid_beyond_numbers_is_refused_where_it_gets_there() {
    let folder = tempfile::tempdir().unwrap();
    let recursion = |factor: &str| {
        format!(
            "{{ n = 2000; }} A\nA if(n > 0, 2, 1)\n1: A -> sphere\n2: A -> uscale({factor}) {{n = n - 1}} A"
        )
    };
    let half = "A -> sphere | move(1, 0, 0) uscale(0.5) A";
    let cases = [
        // 2⁴⁹⁸ < 10¹⁵⁰ < 2⁴⁹⁹
        (
            recursion("2"),
            "4:9",
            "the solid reaches further than numbers, and may reach at most 1e150",
            "where n = 499",
        ),
        (recursion("0.5"), "4:9", "at least 1e-150", "where n = 500"),
        ("{} move(1e14, 0, 0) cube | uscale(1e200) cube".to_owned(), "1:28", "at most 1e150", "uscale"),
        ("{} move(1e15, 0, 0) (cube | sphere)".to_owned(), "1:4", "times its size", "too far away"),
        (format!("{{}} uscale(1e160) A\n{half}"), "1:4", "reaches 2.0e160 far", "uscale"),
        ("{} A\nA -> uscale(0.5) A | uscale(1e151) sphere".to_owned(), "2:22", "at most 1e150", "uscale"),
        // Neither operand alone decides on the size of what they have in common.
        ("{} uscale(1e160) (halfspace & cube)".to_owned(), "1:4", "reaches 1.0e160 far", "uscale"),
    ];
    for (source, place, message, cause) in cases {
        fs::write(folder.path().join("vast.pcsg"), &source).unwrap();
        for command in ["check", "render"] {
            let (code, _, err, _) = run_in(folder.path(), &[command, "vast.pcsg"]);
            assert_eq!(code, 1, "{source}");
            for part in [&format!("vast.pcsg:{place}\n"), message, cause] {
                assert!(err.contains(part), "{source}: no {part} in {err}");
            }
        }
    }
    assert_eq!(files(folder.path()), ["vast.pcsg"]);
}

#[test]
fn a_recursion_without_an_end_that_shrinks_is_a_solid() {
    let folder = tempfile::tempdir().unwrap();
    // Spheres of radius 1, 1/2, 1/4, … that touch each other, up to a height of 3.
    let scene = "{} A\nA -> sphere | move(0, 0, 1.5) uscale(1/2) A";
    fs::write(folder.path().join("spire.pcsg"), scene).unwrap();
    let run = |args: &[&str]| run_in(folder.path(), args);
    let top = |report: &Value| report["max"][2].as_f64().unwrap();

    let (code, out, err, _) = run(&["check", "spire.pcsg", "--format", "json"]);
    assert_eq!((code, err.as_str()), (0, ""));
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["terminates"], false);
    assert!((report["contraction"].as_f64().unwrap() - 0.5).abs() < 1e-6, "{out}");
    assert!((top(&report) - 3.0).abs() < 1e-9, "{out}");
    let (_, out, _, _) = run(&["check", "spire.pcsg"]);
    assert!(out.contains("no mistakes; an endless recursion"), "{out}");

    // One that was meant to end, and has no end by mistake.
    let scene = "{ n = 3; } A\nA if(n > 0, 2, 1)\n1: A -> sphere\n2: A -> sphere | uscale(1/2) A";
    fs::write(folder.path().join("forgotten.pcsg"), scene).unwrap();
    let (code, out, err, _) = run(&["check", "forgotten.pcsg"]);
    assert_eq!(code, 0);
    assert!(
        out.contains("endless") && err.contains("warning") && err.contains("does `n` decrease?"),
        "{err}"
    );

    let (code, out, err, _) = run(&["bounds", "spire.pcsg", "--format", "json"]);
    assert_eq!((code, err.as_str()), (0, ""));
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["method"], "exact");
    assert!((top(&report["root"]) - 3.0).abs() < 1e-9, "{out}");
    for method in ["conventional", "chain"] {
        let (code, out, err, _) = run(&["bounds", "spire.pcsg", "--method", method]);
        assert_eq!((code, out.as_str()), (1, ""));
        assert!(err.contains("never ends") && err.contains("--method exact"), "{err}");
    }
    let (code, out, err, _) = run(&["bounds", "spire.pcsg", "--compare"]);
    assert_eq!((code, err.as_str()), (0, ""));
    assert!(out.contains("not run: the recursion never ends"), "{out}");
}

#[test]
fn a_tower_of_100_000_cones_is_counted_and_bounded() {
    let tower = scene("cone_tower.pcsg");
    let (code, out, err, _) = run(&["check", path(&tower), "--set", "n=100000"]);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("100,000"), "{out}");
    let args = ["bounds", path(&tower), "--set", "n=100000", "--method", "conventional"];
    let (code, _, err, _) = run(&args);
    assert_eq!(code, 0, "{err}");
}
