//! `pcsg render`: pictures and their statistics, by any engine and light.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;

use crate::{json, path, run, run_in, scene};

#[test]
fn a_picture_is_named_after_its_scene() {
    let sierpinski = scene("sierpinski.pcsg");
    let args = ["render", path(&sierpinski), "--size", "16x12", "--samples", "1", "--set", "n=1"];
    let (code, out, err, files) = run(&args);
    assert_eq!((code, out.as_str(), err.as_str()), (0, "", ""));
    assert_eq!(files, ["sierpinski.png"]);
}

#[test]
fn a_picture_and_its_statistics_go_where_they_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let sympodial = scene("sympodial.pcsg");
    let args = |boxes| {
        let base =
            ["render", path(&sympodial), "--set", "cnt=3", "--set", "noleaves = cnt", "--size", "40x30"];
        [&base[..], &["--samples", "1", "-o", "a.PNG", "--boxes", boxes, "--stats", "a.json"]].concat()
    };
    let mut pictures = Vec::new();
    let mut visited = Vec::new();
    for boxes in ["none", "conventional", "chain"] {
        let (code, _, err, files) = run_in(folder.path(), &args(boxes));
        assert_eq!((code, err.as_str()), (0, ""));
        assert_eq!(files, ["a.PNG", "a.json"]);
        pictures.push(fs::read(folder.path().join("a.PNG")).unwrap());
        let stats = json(&folder.path().join("a.json"));
        assert_eq!((&stats["boxes"], &stats["rays"]), (&boxes.into(), &1200.into()));
        visited.push(stats["nodes_visited"].as_u64().unwrap());
    }
    assert!(pictures.iter().all(|picture| *picture == pictures[0]));
    assert!(visited[0] > visited[1] && visited[1] > visited[2], "{visited:?}");
    let image = image::open(folder.path().join("a.PNG")).unwrap();
    assert_eq!((image.width(), image.height()), (40, 30));
}

#[test]
fn a_seed_makes_another_of_the_kind() {
    let folder = tempfile::tempdir().unwrap();
    let balls = "{} ROW | move(3, 0, 0) ROW\nROW -> uscale(rand(0.5, 1)) sphere";
    fs::write(folder.path().join("balls.pcsg"), balls).unwrap();
    let picture = |more: &[&str]| {
        let base = ["render", "balls.pcsg", "--size", "32x16", "--samples", "1", "-o", "balls.png"];
        let (code, _, err, _) = run_in(folder.path(), &[&base, more].concat());
        assert_eq!(code, 0, "{err}");
        fs::read(folder.path().join("balls.png")).unwrap()
    };
    let none = picture(&[]);
    assert_eq!(none, picture(&["--seed", "0"]));
    assert_ne!(none, picture(&["--seed", "7"]));
    assert_eq!(picture(&["--seed", "7"]), picture(&["--set", "seed=7", "--threads", "2"]));
}

#[test]
fn engines_make_the_same_picture_and_say_what_they_took() {
    let folder = tempfile::tempdir().unwrap();
    let sympodial = scene("sympodial.pcsg");
    let render = |arguments: &[&str]| -> (image::RgbImage, Value) {
        let base = ["render", path(&sympodial), "--set", "cnt=4", "--size", "48x48", "--samples", "2"];
        let args = [&base[..], &["-o", "a.png", "--stats", "a.json"], arguments].concat();
        let (code, _, err, _) = run_in(folder.path(), &args);
        assert_eq!((code, err.as_str()), (0, ""));
        let picture = image::open(folder.path().join("a.png")).unwrap().to_rgb8();
        (picture, json(&folder.path().join("a.json")))
    };
    let (reference, walked) = render(&["--engine", "reference"]);
    for arguments in [&[][..], &["--engine", "fast"], &["--budget", "4K"], &["--budget", "1m"]] {
        let (fast, stats) = render(arguments);
        let differing = reference.pixels().zip(fast.pixels()).filter(|(a, b)| a != b).count();
        assert!(differing <= 2, "{arguments:?}: {differing} pixels differ");
        assert_eq!((&stats["engine"], &stats["boxes"]), (&"fast".into(), &"exact".into()));
        assert!(stats["nodes_visited"].is_null(), "it visits no nodes");
        assert_eq!(stats["rays"], walked["rays"]);
        let seconds = |name: &str| stats[name].as_f64().unwrap();
        assert!(seconds("setup_seconds") >= seconds("bounding_seconds"));
    }
    assert_eq!((&walked["engine"], &walked["boxes"]), (&"reference".into(), &"chain".into()));
    assert!(walked["nodes_visited"].is_number());
    let bytes = |budget: &str| render(&["--budget", budget]).1["bytes"].as_u64().unwrap();
    assert!(bytes("0") < bytes("64K") && bytes("64K") <= 65_536);
    for arguments in [&[][..], &["--resolution", "5"], &["--budget", "4K"]] {
        let (grid, stats) = render(&[&["--engine", "grid"], arguments].concat());
        let differing = reference.pixels().zip(grid.pixels()).filter(|(a, b)| a != b).count();
        assert!(differing <= 2, "{arguments:?}: {differing} pixels differ");
        assert_eq!((&stats["engine"], &stats["boxes"]), (&"grid".into(), &"exact".into()));
    }
    // What only the reference walk can show, it shows.
    assert_eq!(render(&["--view", "cost"]).1["engine"], "reference");
    assert_eq!(render(&["--boxes", "exact"]).1["engine"], "reference");
}

#[test]
fn statistics_tell_what_the_process_took() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ball.pcsg"), "{} sphere").unwrap();
    let stats = |size: &str| {
        let args = ["render", "ball.pcsg", "--size", size, "--samples", "1", "--stats", "a.json"];
        let (code, _, err, _) = run_in(folder.path(), &args);
        assert_eq!((code, err.as_str()), (0, ""));
        json(&folder.path().join("a.json"))
    };
    let [small, large] = ["8x8", "512x512"].map(stats);
    assert!(small["cpu_seconds"].as_f64().unwrap() > 0.0);
    let peak = |stats: &Value| stats["peak_memory"].as_u64();
    assert_eq!(peak(&small).is_some(), cfg!(target_os = "linux"));
    // Sums in double precision, of three channels.
    let own_size = (512 * 512 - 8 * 8) * 3 * 8;
    assert!(peak(&large) >= peak(&small).map(|small| small + own_size / 2), "{small} {large}");
}

#[test]
fn light_is_computed_as_the_scene_or_the_command_line_says() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "{} material(emission = 0.25, diffuse = 1) color(0.5, 1, 0) (cube \\ uscale(0.9) sphere)
                 camera { eye = (0, 0, 0); target = (0, 1, 0); }
                 image { integrator = path; bounces = 2; samples = 16; width = 8; height = 8; }";
    fs::write(folder.path().join("room.pcsg"), scene).unwrap();
    // Emission and what comes of it by so many bounces off an albedo of 1/2: light everywhere, and no noise.
    let render = |arguments: &[&str]| -> (f64, Value) {
        let args = [&["render", "room.pcsg", "-o", "a.png", "--stats", "a.json"][..], arguments].concat();
        let (code, _, err, _) = run_in(folder.path(), &args);
        assert_eq!((code, err.as_str()), (0, ""));
        let picture = image::open(folder.path().join("a.png")).unwrap().to_rgb8();
        assert!(picture.pixels().all(|pixel| pixel == picture.get_pixel(0, 0)), "{arguments:?}");
        let encoded = f64::from(picture.get_pixel(0, 0)[0]) / 255.0;
        (libm::pow((encoded + 0.055) / 1.055, 2.4), json(&folder.path().join("a.json")))
    };
    for (arguments, expected, integrator) in [
        (&[][..], 0.125 + 0.0625 + 0.03125, "path"),
        (&["--bounces", "1"], 0.125 + 0.0625, "path"),
        (&["--exposure", "1.5"], 0.21875 * libm::exp2(1.5), "path"),
        (&["--exposure", "-2"], 0.21875 / 4.0, "path"),
        (&["--engine", "reference"], 0.21875, "path"),
        (&["--engine", "grid"], 0.21875, "path"),
        (&["--integrator", "direct"], 0.125 + 0.5 * 0.2, "direct"),
    ] {
        let (found, stats) = render(arguments);
        assert!((found - expected).abs() < 2e-3, "{arguments:?}: {found} for {expected}");
        assert_eq!(stats["integrator"], integrator);
    }
    assert_eq!(render(&["--bounces", "1"]).1["bounces"], 1);
}

#[test]
fn what_glows_puts_no_lamp_out() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "{} sphere | move(1.5, 0, 0) material(emission = 1) uscale(0.1) sphere";
    fs::write(folder.path().join("balls.pcsg"), scene).unwrap();
    assert_eq!(run_in(folder.path(), &["render", "balls.pcsg", "--size", "32x32", "--samples", "1"]).0, 0);
    let picture = image::open(folder.path().join("balls.png")).unwrap().to_rgb8();
    // The light of the small one is not followed, and without any other the large one would be a disc.
    let shades: BTreeSet<u8> = picture.pixels().map(|pixel| pixel[0]).collect();
    assert!(shades.len() > 30, "{shades:?}");
}

#[test]
fn a_tree_of_10_to_the_19_primitives_is_rendered() {
    let sympodial = scene("sympodial.pcsg");
    let args = ["render", path(&sympodial), "--set", "cnt=60", "--size", "24x24", "--samples", "1"];
    let (code, _, err, files) = run(&args);
    assert_eq!((code, err.as_str()), (0, ""));
    assert_eq!(files, ["sympodial.png"]);
}

#[test]
fn a_picture_can_be_of_something_closer() {
    let sympodial = scene("sympodial.pcsg");
    let zoom = ["render", path(&sympodial), "--size", "8x8", "--zoom", "1e4"];
    assert_eq!(run(&zoom).0, 0);
    assert_eq!(run(&[&zoom[..5], &["0.5"]].concat()).0, 2);
}

#[test]
fn a_picture_of_nothing_is_doubted() {
    let folder = tempfile::tempdir().unwrap();
    let behind = "{} move(0, 0, 3) sphere\ncamera { eye = (0, -9, 3); target = (0, -20, 3); }";
    fs::write(folder.path().join("behind.pcsg"), behind).unwrap();
    for further in [&[][..], &["--view", "plate"], &["--view", "depth"], &["--engine", "grid"]] {
        let args = [&["render", "behind.pcsg", "--size", "16x16"], further].concat();
        let (code, _, err, files) = run_in(folder.path(), &args);
        assert_eq!((code, files.as_slice()), (0, &["behind.pcsg".to_owned(), "behind.png".to_owned()][..]));
        assert!(err.starts_with("warning: behind.pcsg: no ray hit anything"), "{err}");
        assert!(
            err.contains("2.0000] .. [") && err.contains("to [   0.0000,  -20.0000,    3.0000]"),
            "{err}"
        );
    }
    let tower = scene("cone_tower.pcsg");
    let (code, _, err, _) = run_in(folder.path(), &["render", path(&tower), "--size", "16x16"]);
    assert_eq!((code, err.as_str()), (0, ""));
}
