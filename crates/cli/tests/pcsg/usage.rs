//! Help, and wrong usage: exit codes and messages.

use crate::{path, run, scene};

#[test]
fn completions_and_help_teach() {
    for shell in ["bash", "zsh", "fish"] {
        let (code, out, _, _) = run(&["completions", shell]);
        assert_eq!(code, 0);
        assert!(out.contains("render"), "{out}");
    }
    let (code, out, _, _) = run(&["--help"]);
    assert_eq!(code, 0);
    assert!(out.contains("Examples:"), "{out}");
    let (_, out, _, _) = run(&["render", "--help"]);
    for option in [
        "--set",
        "--size",
        "--samples",
        "--threads",
        "--view",
        "--engine",
        "--budget",
        "--resolution",
        "--boxes",
        "--stats",
        "plate",
        "chain",
    ] {
        assert!(out.contains(option), "{option} is missing in {out}");
    }
}

#[test]
fn wrong_usage_ends_with_2() {
    let tower = scene("cone_tower.pcsg");
    let tower = path(&tower);
    let wrong: &[&[&str]] = &[
        &[],
        &["draw", tower],
        &["render"],
        &["render", tower, "--size", "800"],
        &["render", tower, "--size", "0x10"],
        &["render", tower, "--size", "-1x10"],
        &["render", tower, "--size", "100000x100000"],
        &["render", tower, "--samples", "5000"],
        &["render", tower, "--samples", "0"],
        &["render", tower, "--threads", "0"],
        &["render", tower, "--noise", "0"],
        &["render", tower, "--noise", "-2"],
        &["render", tower, "--noise", "NaN"],
        &["render", tower, "--noise", "2", "--samples", "16"],
        &["render", tower, "--noise", "2", "--view", "depth"],
        &["render", tower, "--integrator", "path", "--view", "depth"],
        &["render", tower, "--bounces", "2", "--view", "normal"],
        &["render", tower, "--size", "65537x1"],
        &["render", tower, "--view", "pretty"],
        &["render", tower, "--integrator", "radiosity"],
        &["render", tower, "--bounces", "0"],
        &["render", tower, "--bounces", "1025"],
        &["render", tower, "--exposure", "33"],
        &["render", tower, "--exposure", "bright"],
        &["render", tower, "--exposure", "1", "--view", "normal"],
        &["render", tower, "-o", "picture.jpg"],
        &["render", tower, "--engine", "quick"],
        &["render", tower, "--engine", "fast", "--boxes", "exact"],
        &["render", tower, "--engine", "fast", "--max-steps", "10"],
        &["render", tower, "--engine", "fast", "--view", "plate"],
        &["render", tower, "--engine", "fast", "--view", "cost"],
        &["render", tower, "--engine", "reference", "--budget", "1M"],
        &["render", tower, "--view", "cost", "--budget", "1M"],
        &["render", tower, "--boxes", "chain", "--budget", "1M"],
        &["render", tower, "--engine", "grid", "--boxes", "exact"],
        &["render", tower, "--engine", "grid", "--resolution", "0"],
        &["render", tower, "--resolution", "64"],
        &["render", tower, "--budget", "much"],
        &["render", tower, "--budget", "-1"],
        &["bench"],
        &["bench", tower, "--reps", "0"],
        &["bench", tower, "--threads", "0"],
        &["bench", tower, "--view", "cost"],
        &["bench", tower, "--engine", "fast", "--boxes", "none"],
        &["render", tower, "--set", "n"],
        &["render", tower, "--seed", "-1"],
        &["render", tower, "--seed", "seven"],
        &["render", tower, "--max-states", "many"],
        &["render", tower, "--max-states", "0"],
        &["check", tower, "--seed", "9007199254740992"],
        &["bounds", tower, "--method", "magic"],
        &["bounds", tower, "--volume", "ball"],
        &["bounds", tower, "--volume", "obb", "--method", "chain"],
        &["bounds", tower, "--states", "--method", "conventional"],
        &["bounds", tower, "--tolerance", "1e-6", "--method", "chain"],
        &["bounds", tower, "--booleans", "search", "--method", "chain"],
        &["bounds", tower, "--booleans", "context", "--volume", "obb"],
        &["bounds", tower, "--tolerance", "-1"],
        &["bounds", tower, "--tolerance", "NaN"],
        &["bounds", tower, "--compare", "--volume", "obb"],
        &["bounds", tower, "--plot", "growth.png"],
        &["bounds", tower, "--plot", "growth.svg", "--compare"],
        &["bounds", tower, "--sweep", "n=1..3"],
        &["bounds", tower, "--plot", "growth.svg", "--sweep", "n"],
        &["bounds", tower, "--plot", "growth.svg", "--sweep", "n=3..1"],
        &["bounds", tower, "--plot", "growth.svg", "--sweep", "n=0..2.5"],
        &["check", tower, "--format", "xml"],
    ];
    for args in wrong {
        let (code, out, err, files) = run(args);
        assert_eq!((code, out.as_str(), files.len()), (2, "", 0), "{args:?}");
        assert!(!err.is_empty());
    }
}

#[test]
fn mistakes_in_the_input_end_with_1() {
    let scenes = ["cone_tower.pcsg", "sympodial.pcsg", "primitives.pcsg"].map(scene);
    let [tower, sympodial, primitives] = scenes.each_ref().map(|scene| path(scene));
    // (arguments, a part of the message)
    let wrong: &[(&[&str], &str)] = &[
        (&["check", "missing.pcsg"], "missing.pcsg: cannot read it"),
        (&["render", "."], "cannot read it"),
        (&["check", tower, "--set", "m=3"], "`m`"),
        (&["check", tower, "--set", "n=3+"], "error"),
        (&["check", tower, "--seed", "3"], "nothing in it is random"),
        (&["check", tower, "--seed", "3"], "--> --seed:1:1"),
        (&["check", tower, "--set", "m=3"], "--> --set:1:1"),
        (&["bench", tower, "--plot", "cost.svg", "--sweep", "m=1..3"], "--> --sweep:1:1"),
        (&["render", tower, "--size", "4000x4000", "--memory", "64M"], "raise --memory"),
        (
            &["render", tower, "--size", "4000x4000", "--memory", "64M", "--engine", "reference"],
            "takes 704000000 bytes, and --memory allows 67108864",
        ),
        (&["check", tower, "--set", "n=4"], "singular"),
        (&["render", tower, "--engine", "reference", "--max-states", "10"], "raise --max-states"),
        (&["bounds", tower, "--max-steps", "10"], "--max-steps allows 10"),
        (&["bounds", sympodial, "--set", "cnt=60"], "--max-steps allows"),
        (&["bounds", sympodial, "--plot", "missing/growth.svg"], "cannot write it"),
        (&["bounds", sympodial, "--plot", "growth.svg", "--sweep", "ctn=0..4"], "did you mean `cnt`"),
        (
            &["bounds", tower, "--plot", "growth.svg", "--sweep", "n=5..999", "--max-states", "99"],
            "--max-states",
        ),
        (&["bounds", primitives, "--plot", "growth.svg"], "--sweep NAME=A..B"),
        (&["render", sympodial, "--set", "cnt=60", "--boxes", "none"], "without boxes"),
        (&["bench", sympodial, "--set", "cnt=60", "--boxes", "chain"], "the chain algorithm"),
        (&["bench", sympodial, "--set", "ctn=6"], "did you mean `cnt`"),
        (&["render", sympodial, "--set", "cnt=60", "--boxes", "chain"], "the chain algorithm"),
    ];
    for (args, expected) in wrong {
        let (code, out, err, files) = run(args);
        assert_eq!((code, out.as_str(), files.len()), (1, "", 0), "{args:?}: {err}");
        assert!(err.contains(expected), "{args:?}: {err}");
    }
}

#[test]
fn two_seeds_are_one_too_many() {
    let bush = scene("bush.pcsg");
    let check = |options: &[&str]| run(&[&["check", path(&bush), "--seed", "5"], options].concat());
    for other in ["seed=6", " seed = 3 + 2"] {
        let (code, out, err, _) = check(&["--set", other]);
        assert_eq!((code, out.as_str()), (2, ""), "{err}");
        assert!(err.contains(&format!("--seed 5 and --set {other} give two seeds")), "{err}");
    }
    // The last assignment counts, and what is the same is no contradiction.
    for same in [&["--set", "seed=5"][..], &["--set", "seed=6", "--set", "seed = 5.0"]] {
        let (code, _, err, _) = check(same);
        assert_eq!((code, err.as_str()), (0, ""));
    }
}
