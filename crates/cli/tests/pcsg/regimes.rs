//! Scenes whose states cannot be listed.

use std::fs;

use serde_json::Value;

use crate::run_in;

/// 2⁴⁰ balls in a tree, no two alike.
const TREE: &str = "{ n = 40; } TREE
TREE if(n > 0, 2, 1)
1: TREE -> sphere
2: TREE -> {n = n - 1} move(0, 0, 2) uscale(0.6) (rotx(rand(20, 50)) TREE | rotx(rand(-50, -20)) TREE)
         | scale(0.2, 0.2, 2) cylinder
camera { eye = (9, 0, 2.5); target = (0, 0, 2.5); }
image { width = 24; height = 24; samples = 1; }
";

/// A cube at one half of its size on top of a cube, and so on.
const SPIRE: &str =
    "{} SPIRE\nSPIRE -> cube | move(0, 0, 1.5) uscale(0.5) SPIRE\nimage { width = 24; height = 24; }\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in [("tree.pcsg", TREE), ("spire.pcsg", SPIRE)] {
        fs::write(folder.path().join(name), text).expect("it can be written");
    }
    folder
}

#[test]
fn check_tells_the_regime() {
    let folder = folder();
    let regime = |args: &[&str]| {
        let (code, out, err, _) = run_in(folder.path(), &[&["check", "--format", "json"], args].concat());
        assert_eq!((code, err.as_str()), (0, ""));
        let report: Value = serde_json::from_str(&out).expect("JSON");
        (report["regime"].as_str().expect("a word").to_owned(), report)
    };
    assert_eq!(regime(&["tree.pcsg", "--set", "n=6"]).0, "finite");
    assert_eq!(regime(&["spire.pcsg"]).0, "endless");
    let (name, report) = regime(&["tree.pcsg", "--max-states", "5000"]);
    assert_eq!((name.as_str(), &report["more_states_than"]), ("vast", &Value::from(5000)));
    // No tree of this kind is higher than one whose limbs all stand upright.
    let height = report["max"][2].as_f64().expect("a number");
    assert!(height > 2.0 && height < 2.0 / (1.0 - 0.6) + 1.0, "{height}");
}

#[test]
fn a_count_that_goes_up_is_doubted() {
    let folder = folder();
    let scene = TREE.replace("n - 1", "n + 1").replace("rand(20, 50)", "20").replace("rand(-50, -20)", "-20");
    fs::write(folder.path().join("up.pcsg"), scene).expect("it can be written");
    let (code, out, err, _) = run_in(folder.path(), &["check", "up.pcsg", "--max-states", "5000"]);
    assert_eq!(code, 0);
    assert!(
        out.contains("vast") && err.contains("warning") && err.contains("does the recursion of `TREE` end?"),
        "{out}{err}"
    );
}

#[test]
fn pictures_do_not_depend_on_memory_or_threads() {
    let folder = folder();
    let render = |scene, args: &[&str]| {
        let all = [&["render", scene, "-o", "a.png", "--max-states", "5000"], args].concat();
        let (code, _, err, _) = run_in(folder.path(), &all);
        assert_eq!((code, err.as_str()), (0, ""), "{all:?}");
        fs::read(folder.path().join("a.png")).expect("a picture")
    };
    for scene in ["tree.pcsg", "spire.pcsg"] {
        let first = render(scene, &["--threads", "1"]);
        assert!(first == render(scene, &["--threads", "8", "--memory", "64K"]), "{scene}");
    }
    for other in [["--seed", "7"], ["--detail", "6"]] {
        assert!(render("tree.pcsg", &[]) != render("tree.pcsg", &other), "{other:?}");
    }
}

#[test]
fn engines_that_list_states_say_what_they_lack() {
    let folder = folder();
    for (args, expected) in [
        (["tree.pcsg", "--engine", "reference"], "only the fast engine can trace what cannot be listed"),
        (["spire.pcsg", "--engine", "grid"], "only the fast engine can trace what never ends"),
    ] {
        let (code, _, err, _) =
            run_in(folder.path(), &[&["render", "--max-states", "5000"], &args[..]].concat());
        assert!(code == 1 && err.contains(expected), "{err}");
    }
    let (code, _, err, _) =
        run_in(folder.path(), &["render", "tree.pcsg", "--engine", "grid", "--detail", "1"]);
    assert!(code == 2 && err.contains("--detail is about what the fast engine does not look into"), "{err}");
}

#[test]
fn what_memory_does_not_hold_can_be_had_with_more() {
    let folder = folder();
    let tower = "{ n = 350000; } T
        T if(n > 0, 2, 1)
        1: T -> cone
        2: T -> cone | {n = n - 1} move(0, 0, 1) T";
    fs::write(folder.path().join("tower.pcsg"), tower).expect("it can be written");
    let (code, out, _, _) = run_in(folder.path(), &["check", "tower.pcsg"]);
    assert!(code == 0 && out.contains("by `render` with --memory 1368M"), "{out}");
    let (code, _, err, _) = run_in(folder.path(), &["render", "tower.pcsg"]);
    assert!(code == 1 && err.contains("raise --memory"), "{err}");
    let args = ["render", "tower.pcsg", "--max-states", "5000"];
    let (code, _, err, _) = run_in(folder.path(), &args);
    assert!(code == 1 && err.contains("raise --max-states"), "{err}");
    let (code, _, err, _) = run_in(folder.path(), &["render", "tower.pcsg", "--set", "n=600000"]);
    assert!(code == 1 && err.contains("raise --memory and --max-states, both of them"), "{err}");
}

#[test]
fn what_is_probably_meant_to_end_is_said_beside_its_picture() {
    let folder = folder();
    let scene = |rule: &str| {
        format!(
            "{{ n = 5; }} A\nA if(n > 0, 2, 1)\n1: A -> sphere\n2: A -> cube | {rule} move(0, 0, 1) uscale(0.9) A
             image {{ width = 16; height = 16; samples = 1; }}"
        )
    };
    for (rule, warning) in [
        ("{n = n + 1}", "warning: more than 5000 states: does the recursion of `A` end?"),
        ("{n = n}", "warning: the recursion of `A` never ends"),
    ] {
        fs::write(folder.path().join("a.pcsg"), scene(rule)).expect("it can be written");
        let (code, _, err, _) = run_in(folder.path(), &["render", "a.pcsg", "--max-states", "5000"]);
        assert!(code == 0 && err.contains(warning), "{err}");
    }
}

#[test]
fn parts_beyond_all_digits_are_not_unfolded() {
    let folder = folder();
    // 2²⁰⁰ spheres, of which one is 10⁻⁶⁰ as large as all.
    let deep = "{ n = 200; } T
        T if(n > 0, 2, 1)
        1: T -> sphere
        2: T -> {n = n - 1} uscale(0.5) ( move(0, 0, 1) T | move(0.9, 0, -0.5) T
                                        | move(-0.5, 0.8, -0.5) T | move(-0.5, -0.8, -0.5) T )
        image { width = 48; height = 48; samples = 1; }";
    fs::write(folder.path().join("deep.pcsg"), deep).expect("it can be written");
    let (code, _, err, _) = run_in(folder.path(), &["render", "deep.pcsg", "-o", "a.png"]);
    assert!(code == 0 && err.contains("note: deep.pcsg: it has parts of 1e-60 of its size"), "{err}");
    for engine in ["reference", "grid"] {
        let (code, _, err, _) = run_in(folder.path(), &["render", "deep.pcsg", "--engine", engine]);
        assert!(code == 1 && err.contains("too small for coordinates to tell them apart"), "{engine}: {err}");
    }
    let (code, _, err, _) = run_in(folder.path(), &["render", "deep.pcsg", "--set", "n=20", "-o", "b.png"]);
    assert_eq!((code, err.as_str()), (0, ""));
}

#[test]
fn recursion_that_hardly_shrinks_is_an_error() {
    let folder = folder();
    let path = folder.path().join("slow.pcsg");
    fs::write(path, "{} A\nA -> uscale(0.9999999999) A | sphere").expect("it can be written");
    for command in [&["render", "slow.pcsg", "-o", "a.png", "--size", "16x16"][..], &["bench", "slow.pcsg"]] {
        let (code, _, err, _) = run_in(folder.path(), command);
        assert!(code == 1 && err.contains("hardly gets smaller") && err.contains("slow.pcsg:2:6"), "{err}");
        assert!(
            err.contains("still not as small as a pixel") && !folder.path().join("a.png").exists(),
            "{err}"
        );
    }
}

#[test]
fn too_many_parts_that_lie_in_each_other_are_an_error() {
    let folder = folder();
    let path = folder.path().join("heap.pcsg");
    let copies =
        "move(0.3, 0.2, 0.1) uscale(0.95) A | rotz(50) move(-0.3, 0, 0) uscale(0.95) A | uscale(0.1) cube";
    fs::write(path, format!("{{}} uscale(2) sphere \\ A\nA -> {copies}")).expect("it can be written");
    let (code, _, err, _) = run_in(folder.path(), &["render", "heap.pcsg", "-o", "a.png", "--size", "16x16"]);
    assert!(code == 1 && err.contains("lie in each other") && err.contains("heap.pcsg:2:6"), "{err}");
    assert!(err.contains("one of the parts") && !folder.path().join("a.png").exists(), "{err}");
}

#[test]
fn recursion_to_nothing_is_an_error() {
    let folder = folder();
    // (rules, the line of the symbol that leads to nothing)
    for (rules, line) in [
        ("A -> uscale(0.5) A", 2),
        ("A -> uscale(0.5) A \\ sphere", 2),
        ("A -> sphere | B\nB -> move(1, 0, 0) uscale(0.5) C\nC -> uscale(0.5) B", 3),
        ("A -> sphere \\ B\nB -> uscale(0.5) B", 3),
    ] {
        fs::write(folder.path().join("nothing.pcsg"), format!("{{}} A\n{rules}\n"))
            .expect("it can be written");
        for command in ["check", "render", "bounds", "bench"] {
            let (code, out, err, _) = run_in(folder.path(), &[command, "nothing.pcsg"]);
            assert!(err.contains("leads on and on, and to no solid"), "{command} {rules}: {out}{err}");
            assert!(err.contains(&format!("--> nothing.pcsg:{line}:1")), "{command} {rules}: {err}");
            assert_eq!((code, out.as_str()), (1, ""), "{command} {rules}");
        }
    }
    fs::write(folder.path().join("point.pcsg"), "{} A\nA -> uscale(0.5) A | uscale(0.4) A")
        .expect("it can be written");
    for command in ["check", "render"] {
        let (code, _, err, _) = run_in(folder.path(), &[command, "point.pcsg"]);
        assert!(code == 1 && err.contains("and to no solid") && err.contains("point.pcsg:2:1"), "{err}");
    }
    for rules in [
        // By chance, by numbers that count on and on, in what is subtracted, and past a choice by chance.
        "{} A\nA -> rotz(rand(0, 90)) uscale(0.5) A",
        "{ n = 0; } A\nA -> {n = n + 1} move(0, 0, 1 / n) uscale(0.5) A",
        "{} B\nA -> rotz(rand(0, 90)) uscale(0.5) A\nB -> sphere \\ A",
        "{} C\nA -> rotz(rand(0, 90)) uscale(0.5) A\nB pick(1, 1)\n1: B -> sphere\n2: B -> A\nC -> B | B | B | B | B\n",
    ] {
        fs::write(folder.path().join("vast.pcsg"), rules).expect("it can be written");
        for command in ["check", "render", "bounds", "bench"] {
            let options = [command, "vast.pcsg", "--max-states", "1000"];
            let (code, out, err, _) = run_in(folder.path(), &options);
            assert!(err.contains("leads on and on, and to no solid"), "{command} {rules}: {out}{err}");
            assert!(err.contains("--> vast.pcsg:2:1"), "{command} {rules}: {err}");
            assert_eq!((code, out.as_str()), (1, ""), "{command} {rules}");
        }
    }
    // There are ways that no number takes.
    let never = "{ n = 20; } B\nA -> rotz(rand(0, 90)) uscale(0.5) A
        B if(n > 0, if(rand(0, 1) < 2, 1, 2), 3)\n1: B -> {n = n - 1} uscale(0.5) (B | rotz(90) B)\n2: B -> A\n3: B -> sphere
        image { width = 8; height = 8; samples = 1; }";
    fs::write(folder.path().join("never.pcsg"), never).expect("it can be written");
    let (code, _, err, _) = run_in(folder.path(), &["check", "never.pcsg", "--max-states", "1000"]);
    assert_eq!((code, err.as_str()), (0, ""));
    let clipped = "{} A\nA -> uscale(0.5) A & sphere\nimage { width = 8; height = 8; }\n";
    fs::write(folder.path().join("clipped.pcsg"), clipped).expect("it can be written");
    for command in ["check", "render"] {
        assert_eq!(run_in(folder.path(), &[command, "clipped.pcsg"]).0, 0);
    }
}
