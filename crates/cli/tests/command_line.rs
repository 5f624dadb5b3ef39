//! The program as a stranger meets it: what it prints, where, and with which exit code.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)
}

fn pcsg(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pcsg"));
    command.current_dir(folder).args(args).output().expect("the program starts")
}

/// Runs the program in an empty folder; gives the exit code, both outputs, and the names of the files that it left.
fn run(args: &[&str]) -> (i32, String, String, Vec<String>) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_in(folder.path(), args)
}

fn run_in(folder: &Path, args: &[&str]) -> (i32, String, String, Vec<String>) {
    let output = pcsg(folder, args);
    let text = |bytes| String::from_utf8(bytes).expect("the program speaks UTF-8");
    let mut files: Vec<_> = fs::read_dir(folder)
        .expect("the folder is there")
        .map(|entry| entry.expect("it can be read").file_name().to_string_lossy().into_owned())
        .collect();
    files.sort();
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr), files)
}

fn path(path: &Path) -> &str {
    path.to_str().expect("the repository is in a folder with a plain name")
}

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
        let stats: Value = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
        assert_eq!((&stats["boxes"], &stats["rays"]), (&boxes.into(), &1200.into()));
        visited.push(stats["nodes_visited"].as_u64().unwrap());
    }
    assert!(pictures.iter().all(|picture| *picture == pictures[0]));
    assert!(visited[0] > visited[1] && visited[1] > visited[2], "{visited:?}");
    let image = image::open(folder.path().join("a.PNG")).unwrap();
    assert_eq!((image.width(), image.height()), (40, 30));
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
        let stats = fs::read(folder.path().join("a.json")).unwrap();
        (image::open(folder.path().join("a.png")).unwrap().to_rgb8(), serde_json::from_slice(&stats).unwrap())
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
        let stats = serde_json::from_slice(&fs::read(folder.path().join("a.json")).unwrap()).unwrap();
        (libm::pow((encoded + 0.055) / 1.055, 2.4), stats)
    };
    for (arguments, expected, integrator) in [
        (&[][..], 0.125 + 0.0625 + 0.03125, "path"),
        (&["--bounces", "1"], 0.125 + 0.0625, "path"),
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
fn an_exr_file_has_what_every_pixel_shows_in_layers() {
    use exr::prelude::*;

    let folder = tempfile::tempdir().unwrap();
    let bowl = "{ r = 0.5; } material(ambient = 1, diffuse = 0) (color(2, 0.5, 0.25) cube \\ move(0, 0, 1) uscale(r) ball)\n\
                ball = color(0.125, 0.5, 1) sphere\n\
                camera { eye = (0, 0, 5); target = (0, 0, 0); up = (0, 1, 0); fov = 60; }";
    fs::write(folder.path().join("bowl.pcsg"), bowl).unwrap();
    // The walk tests the boxes of the solid's parts; the fast engine has none to test in a single solid.
    let scene = ["render", "bowl.pcsg", "--set", "r=1/2", "--engine", "reference"];
    let args = [&scene[..], &["--size", "33x21", "--samples", "1", "-o", "a.exr"]].concat();
    let (code, out, err, files) = run_in(folder.path(), &args);
    assert_eq!((code, out.as_str(), err.as_str()), (0, "", ""));
    assert_eq!(files, ["a.exr", "bowl.pcsg"]);
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_file(folder.path().join("a.exr"))
        .unwrap();

    let names: Vec<String> = image
        .layer_data
        .iter()
        .map(|layer| layer.attributes.layer_name.clone().unwrap().to_string())
        .collect();
    assert_eq!(
        names,
        ["colour", "depth", "normal", "position", "recursion", "node", "state", "samples", "box_tests"]
    );
    for layer in &image.layer_data {
        let software = layer.attributes.software_name.clone().unwrap().to_string();
        assert_eq!(software, concat!("pcsg ", env!("CARGO_PKG_VERSION")));
        assert_eq!(layer.size, Vec2(33, 21));
        let attribute = |name: &str| layer.attributes.other[&Text::from(name)].to_text().unwrap().to_string();
        assert_eq!((attribute("scene"), attribute("parameters")), ("bowl.pcsg".into(), "r=1/2".into()));
    }
    let sample = |layer: &str, channel: &str, x: usize, y: usize| {
        let layer = &image.layer_data[names.iter().position(|name| name == layer).unwrap()];
        let channels = &layer.channel_data.list;
        let channel = channels.iter().find(|found| found.name == *channel).unwrap();
        channel.sample_data.value_by_flat_index(y * 33 + x)
    };
    let triple = |layer: &str, channels: [&str; 3], x, y| {
        channels.map(|channel| sample(layer, channel, x, y).to_f32())
    };

    // In the middle is the bottom of the bowl, beside it the rim, and in the corner nothing.
    let close = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(close(triple("colour", ["R", "G", "B"], 16, 10), [0.125, 0.5, 1.0]));
    assert!(close(triple("colour", ["R", "G", "B"], 21, 10), [2.0, 0.5, 0.25]), "brighter than a screen");
    assert!(close(triple("normal", ["X", "Y", "Z"], 16, 10), [0.0, 0.0, 1.0]));
    assert!(close(triple("position", ["X", "Y", "Z"], 16, 10), [0.0, 0.0, 0.5]));
    assert!((sample("depth", "Z", 16, 10).to_f32() - 4.5).abs() < 1e-5);
    assert!((sample("depth", "Z", 21, 10).to_f32() - 4.0).abs() < 1e-5);
    assert_eq!(sample("depth", "Z", 0, 0), Sample::F32(f32::INFINITY));
    assert!(close(triple("normal", ["X", "Y", "Z"], 0, 0), [0.0; 3]));
    assert_eq!(sample("recursion", "depth", 16, 10), Sample::U32(0));
    let nodes = [(16, 10), (21, 10), (0, 0)].map(|(x, y)| sample("node", "id", x, y).to_u32());
    assert!(nodes[0] != nodes[1] && nodes[1] < 20 && nodes[2] == u32::MAX, "{nodes:?}");
    assert_eq!(sample("state", "id", 16, 10), Sample::U32(u32::MAX), "there is no symbol");
    assert_eq!(sample("samples", "count", 16, 10), Sample::U32(1));
    assert!(sample("box_tests", "count", 16, 10).to_u32() > 0);
}

#[test]
fn a_bench_measures_setting_up_primary_rays_and_pictures() {
    let sympodial = scene("sympodial.pcsg");
    for engine in ["reference", "fast"] {
        let base = ["bench", path(&sympodial), "--set", "cnt=3", "--size", "40x30", "--reps", "2"];
        let args = [&base[..], &["--engine", engine, "--format", "json"]].concat();
        let (code, out, err, files) = run(&args);
        assert_eq!((code, err.as_str(), files.len()), (0, "", 0));
        let report: Value = serde_json::from_str(&out).unwrap();
        assert_eq!((&report["engine"], &report["threads"]), (&engine.into(), &1.into()));
        let number = |name: &str| report[name].as_f64().unwrap();
        for name in
            ["setup_s", "bytes", "primary_s", "image_s", "box_tests_per_ray", "primitive_tests_per_ray"]
        {
            assert!(number(name) > 0.0, "{name}: {out}");
        }
        assert!(number("hit_fraction") > 0.05 && number("hit_fraction") < 0.9, "{out}");
        let rate = 1200e-6 / number("primary_cpu_s");
        assert!((number("primary_mray_s") / rate - 1.0).abs() < 1e-9, "{out}");
        assert!(report["image_cpu_s"].is_number());
    }
    let (code, out, _, _) = run(&["bench", path(&sympodial), "--size", "16x16", "--reps", "1"]);
    assert_eq!(code, 0);
    assert!(out.contains("primary rays") && out.contains("4,097"), "{out}");
}

#[test]
fn a_bench_draws_sweeps_and_a_render_goes_closer() {
    let (cheese, tree) = (scene("peers/cheese.pcsg"), scene("sympodial.pcsg"));
    // One ball alone has no boxes: there is nothing to draw of them at n = 1.
    for sweep in ["n=1..2", "log2(side)=2..3", "log2(budget)=10..11"] {
        let size = ["--size", "8x8", "--reps", "1", "--plot", "cost.svg", "--sweep", sweep];
        let (code, _, err, files) = run(&[&["bench", path(&cheese)], &size[..]].concat());
        assert_eq!((code, files), (0, vec!["cost.svg".to_owned()]), "{err}");
    }
    for refused in ["log2(side)=1..40", "log2(budget)=-1..3", "no_such=1..2"] {
        let (code, _, err, files) =
            run(&["bench", path(&cheese), "--plot", "cost.svg", "--sweep", refused, "--size", "8x8"]);
        assert!(code > 0 && files.is_empty(), "{refused}: {err}");
    }
    let zoom = ["render", path(&tree), "--size", "8x8", "--zoom", "1e4"];
    assert_eq!(run(&zoom).0, 0);
    assert_eq!(run(&[&zoom[..5], &["0.5"]].concat()).0, 2);
}

#[test]
fn a_failed_render_leaves_the_old_picture_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("old.png"), "old").unwrap();
    fs::write(folder.path().join("bad.pcsg"), "{} spere").unwrap();
    let (code, out, err, files) = run_in(folder.path(), &["render", "bad.pcsg", "-o", "old.png"]);
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(err.contains("sphere") && err.contains("bad.pcsg:1:4"), "{err}");
    assert_eq!(files, ["bad.pcsg", "old.png"]);
    assert_eq!(fs::read(folder.path().join("old.png")).unwrap(), b"old");
}

#[test]
fn what_cannot_be_written_is_said_before_the_work() {
    let tower = scene("cone_tower.pcsg");
    for output in ["no/such/folder.png", "taken.png"] {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("taken.png")).unwrap();
        let (code, _, err, files) = run_in(folder.path(), &["render", path(&tower), "-o", output]);
        assert_eq!(code, 1);
        assert!(err.contains(output) && err.contains("cannot write it"), "{err}");
        assert_eq!(files, ["taken.png"]);
    }
}

#[test]
fn a_command_does_not_write_over_its_own_files() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.png"), "{} sphere").unwrap();
    for args in [&["render", "scene.png"][..], &["render", "scene.png", "-o", "a.png", "--stats", "a.png"]] {
        let (code, _, err, files) = run_in(folder.path(), args);
        assert_eq!(code, 1, "{err}");
        assert_eq!(files, ["scene.png"]);
        assert_eq!(fs::read_to_string(folder.path().join("scene.png")).unwrap(), "{} sphere");
    }
}

#[cfg(unix)]
#[test]
fn links_and_permissions_survive() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("real.pcsg");
    fs::write(&file, "{}sphere").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o600)).unwrap();
    symlink("real.pcsg", folder.path().join("link.pcsg")).unwrap();
    assert_eq!(run_in(folder.path(), &["fmt", "--write", "link.pcsg"]).0, 0);
    assert_eq!(fs::read_to_string(&file).unwrap(), "{} sphere\n");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    assert!(fs::symlink_metadata(folder.path().join("link.pcsg")).unwrap().is_symlink());

    let args = ["render", "real.pcsg", "--size", "4x4", "--samples", "1", "--stats", "/dev/stdout"];
    let (code, out, err, _) = run_in(folder.path(), &args);
    assert_eq!((code, err.as_str()), (0, ""));
    assert!(out.contains("\"rays\": 16"), "{out}");
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
        &["render", tower, "--view", "pretty"],
        &["render", tower, "--integrator", "radiosity"],
        &["render", tower, "--bounces", "0"],
        &["render", tower, "--bounces", "1025"],
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
fn text_that_is_not_text_is_said_to_be_so() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("latin.pcsg"), b"{}\n// caf\xe9\nsphere").unwrap();
    let (code, _, err, _) = run_in(folder.path(), &["check", "latin.pcsg"]);
    assert_eq!(code, 1);
    assert!(err.contains("latin.pcsg:2:7") && err.contains("UTF-8"), "{err}");
}

#[test]
fn every_broken_file_ends_with_1_and_its_message() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/broken");
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
fn bounds_are_the_ones_of_the_algorithms() {
    let cheese = scene("cheese.pcsg");
    for method in ["conventional", "chain"] {
        let args = ["bounds", path(&cheese), "--set", "n=2", "--method", method, "--format", "json"];
        let (code, out, _, _) = run(&args);
        assert_eq!(code, 0);
        let report: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(report["method"], method);
        for (side, expected) in [("min", -1.0), ("max", 1.0)] {
            for axis in 0..3 {
                let found = report["root"][side][axis].as_f64().unwrap();
                assert!((found - expected).abs() < 1e-9, "{method} {side}: {found}");
            }
        }
        let kinds: Vec<_> =
            report["nodes"].as_array().unwrap().iter().filter_map(|n| n["kind"].as_str()).collect();
        for kind in ["S", "C", "T", "union", "difference", "primitive", "attribute"] {
            assert!(kinds.contains(&kind), "{kinds:?} lacks {kind}");
        }
        assert!(report["seconds"].is_number());
    }
    let (code, out, _, _) = run(&["bounds", path(&cheese), "--set", "n=1"]);
    assert_eq!(code, 0);
    assert!(out.starts_with("chain boxes"), "{out}");
}

#[test]
fn exact_boxes_are_found_at_any_depth() {
    let sympodial = scene("sympodial.pcsg");
    let args = ["bounds", path(&sympodial), "--set", "cnt=60", "--method", "exact", "--format", "json"];
    let (code, out, err, _) = run(&args);
    assert_eq!((code, err.as_str()), (0, ""));
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["states"].as_array().unwrap().len(), 130);
    assert!(report["gap"].as_f64().unwrap() < 1e-9);
    let tops: Vec<f64> = report["states"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|state| state["symbol"] == "TR" && state["params"]["trunk"] == 2.0)
        .map(|state| state["max"][2].as_f64().unwrap())
        .collect();
    assert_eq!(tops.len(), 1, "the trunk stands once");
    assert_eq!(Some(tops[0]), report["root"]["max"][2].as_f64());
}

#[test]
fn every_kind_of_volume_has_its_numbers_and_its_size() {
    let sympodial = scene("sympodial.pcsg");
    let report = |volume: &str| -> Value {
        let args = [
            "bounds",
            path(&sympodial),
            "--set",
            "cnt=3",
            "--method",
            "exact",
            "--volume",
            volume,
            "--format",
            "json",
        ];
        let (code, out, err, _) = run(&args);
        assert_eq!((code, err.as_str()), (0, ""));
        serde_json::from_str(&out).unwrap()
    };
    let number = |value: &Value| value.as_f64().unwrap();
    let aabb = report("aabb");
    for (volume, planes) in [("slab6", 6), ("slab", 14), ("slab18", 18), ("slab26", 26)] {
        let slab = report(volume);
        assert_eq!(slab["directions"].as_array().unwrap().len(), planes / 2);
        for axis in 0..3 {
            let [found, expected] = [&slab, &aabb].map(|report| number(&report["root"]["max"][axis]));
            assert!((found - expected).abs() < 1e-9, "{volume}: {found} instead of {expected}");
        }
        assert!(number(&slab["root"]["volume"]) <= number(&aabb["root"]["volume"]) * (1.0 + 1e-9));
    }
    let sphere = report("sphere");
    assert_eq!(sphere["volume"], "sphere");
    let radius = number(&sphere["root"]["radius"]);
    assert!(
        (number(&sphere["root"]["surface_area"]) / (4.0 * std::f64::consts::PI) - radius * radius).abs()
            < 1e-9
    );
    let obb = report("obb");
    assert_eq!(obb["root"]["axes"].as_array().unwrap().len(), 3);
    assert!(number(&obb["root"]["surface_area"]) <= number(&aabb["root"]["surface_area"]));
    for report in [aabb, sphere, obb] {
        assert!(report["gap"].is_number() && report["counts"]["states"].is_number());
        let states = report["states"].as_array().unwrap();
        assert!(states.iter().all(|state| state["params"].is_object() && state["volume"].is_number()));
    }
}

#[test]
fn the_volume_of_a_node_encloses_those_of_its_states() {
    let sympodial = scene("sympodial.pcsg");
    let args = ["bounds", path(&sympodial), "--set", "cnt=3", "--volume", "slab26", "--format", "json"];
    let (_, out, _, _) = run(&args);
    let report: Value = serde_json::from_str(&out).unwrap();
    let planes = |entry: &Value, side: &str| -> Vec<f64> {
        entry[side].as_array().unwrap().iter().map(|plane| plane.as_f64().unwrap()).collect()
    };
    let of_symbol = |list: &str, key: &str, symbol: &str| -> Vec<Value> {
        let all = report[list].as_array().unwrap().iter();
        all.filter(|entry| entry[key] == symbol && entry["kind"] != "C").cloned().collect()
    };
    for symbol in ["TR", "SG"] {
        let [node] = &of_symbol("nodes", "name", symbol)[..] else { panic!("{symbol} is one node") };
        let states = of_symbol("states", "symbol", symbol);
        for (plane, node) in planes(node, "max").into_iter().enumerate() {
            let most = states.iter().map(|state| planes(state, "max")[plane]).fold(f64::MIN, f64::max);
            assert!((node - most).abs() < 1e-9, "{symbol}, plane {plane}: {node} instead of {most}");
        }
    }
}

#[test]
fn booleans_are_bounded_by_algebra_context_or_search() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "{} move(-0.5, 0, 0) sphere & move(0.5, 0, 0) sphere";
    fs::write(folder.path().join("lens.pcsg"), scene).unwrap();
    let report = |arguments: &[&str]| -> Value {
        let arguments = [&["bounds", "lens.pcsg", "--format", "json", "--booleans"], arguments].concat();
        let (code, out, err, _) = run_in(folder.path(), &arguments);
        assert_eq!((code, err.as_str()), (0, ""));
        serde_json::from_str(&out).unwrap()
    };
    let height = |report: &Value| report["root"]["max"][2].as_f64().unwrap();
    assert!((height(&report(&["algebra", "--method", "exact"])) - 1.0).abs() < 1e-9);
    let found = report(&["search", "--tolerance", "1e-6"]);
    assert!((height(&found) - 0.75_f64.sqrt()).abs() < 2e-6, "{found}");
    assert!(found["search"]["gap"].as_f64().unwrap() < 2e-6 && found["search"]["cells"].is_number());

    // Of each sphere only what is in the other's box can matter.
    let context = report(&["context"]);
    let spheres: Vec<f64> = context["nodes"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|node| node["kind"] == "T")
        .flat_map(|node| [node["min"][0].as_f64().unwrap(), node["max"][0].as_f64().unwrap()])
        .collect();
    assert!(spheres.iter().all(|x| x.abs() < 0.5 + 1e-9), "{spheres:?}");
}

#[test]
fn states_are_listed_for_people_too() {
    let sympodial = scene("sympodial.pcsg");
    let (code, out, err, _) = run(&["bounds", path(&sympodial), "--set", "cnt=2", "--states"]);
    assert_eq!((code, err.as_str()), (0, ""));
    assert!(out.starts_with("exact boxes") && out.contains("cnt = 2, trunk = 2"), "{out}");
    // Of all states, listed or not, the root's is the last.
    let root = out.lines().last().unwrap();
    assert!(root.trim_start().starts_with("81  TR"), "{root}");
}

#[test]
fn methods_and_volumes_are_compared() {
    let sympodial = scene("sympodial.pcsg");
    let compare = |cnt: &str| -> Vec<Value> {
        let (code, out, err, _) =
            run(&["bounds", path(&sympodial), "--set", cnt, "--compare", "--format", "json"]);
        assert_eq!((code, err.as_str()), (0, ""));
        let report: Value = serde_json::from_str(&out).unwrap();
        report["rows"].as_array().unwrap().clone()
    };
    let row = |rows: &[Value], method: &str, volume: &str| {
        rows.iter().find(|row| row["method"] == method && row["volume"] == volume).unwrap().clone()
    };
    let rows = compare("cnt=4");
    let conventional = row(&rows, "conventional", "aabb");
    assert_eq!(conventional["boxes"], "1942");
    assert!(conventional["root_volume_ratio"].as_f64().unwrap() > 2.9);
    assert_eq!(row(&rows, "exact", "aabb")["nodes_area_ratio"], 1.0);
    assert!(row(&rows, "exact", "slab26")["root_area_ratio"].as_f64().unwrap() < 0.7);

    let rows = compare("cnt=60");
    let chain = row(&rows, "chain", "aabb");
    assert_eq!(chain["boxes"], "4582574750436065017864");
    assert!(chain["seconds"].is_null() && chain["not_run"].as_str().unwrap().contains("--max-steps"));
}

#[test]
fn growth_is_drawn_the_same_each_time() {
    let sympodial = scene("sympodial.pcsg");
    let folder = tempfile::tempdir().unwrap();
    let draw = || {
        let args = ["bounds", path(&sympodial), "--set", "cnt=5", "--plot", "growth.svg"];
        let (code, out, err, files) = run_in(folder.path(), &args);
        assert_eq!((code, err.as_str()), (0, ""));
        assert_eq!(files, ["growth.svg"]);
        assert!(out.starts_with("cnt from 0 to 5, which counts the recursion down"), "{out}");
        fs::read_to_string(folder.path().join("growth.svg")).unwrap()
    };
    let drawing = draw();
    assert!(drawing.starts_with("<svg") && drawing.trim_end().ends_with("</svg>"));
    for text in ["sympodial.pcsg", "conventional", "chain", "exact", "--sweep cnt=0..5"] {
        assert!(drawing.contains(text), "{text} is missing");
    }
    assert_eq!(drawing, draw());
}

#[test]
fn a_sweep_leaves_out_what_is_mistaken_and_stops_where_work_is_beyond_reach() {
    let (tower, sympodial) = (scene("cone_tower.pcsg"), scene("sympodial.pcsg"));
    // For n = 4 the cones have no size.
    let args = ["bounds", path(&tower), "--plot", "growth.svg", "--sweep", "n=3..5", "--format", "json"];
    let (code, out, err, _) = run(&args);
    assert_eq!(code, 0);
    assert!(err.contains("left out n = 4") && err.contains("--set n=4"), "{err}");
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["left_out"], serde_json::json!([4]));
    assert_eq!(report["samples"].as_array().unwrap().len(), 2);

    let args =
        ["bounds", path(&sympodial), "--plot", "growth.svg", "--sweep", "cnt=2..3", "--max-steps", "1000"];
    let (code, out, _, _) = run(&[&args[..], &["--format", "json"]].concat());
    assert_eq!(code, 0);
    let report: Value = serde_json::from_str(&out).unwrap();
    let last = &report["samples"][1];
    assert_eq!((&last["value"], &last["chain"]["boxes"]), (&3.into(), &"2622".into()));
    assert!(last["chain"]["seconds"].is_null() && last["conventional"]["seconds"].is_number());
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
fn the_graph_is_drawn() {
    let sympodial = scene("sympodial.pcsg");
    let (code, out, _, _) = run(&["graph", path(&sympodial)]);
    assert_eq!(code, 0);
    assert!(out.starts_with("digraph") && out.contains("TR"), "{out}");
}

#[test]
fn files_are_printed_checked_and_rewritten_in_the_standard_layout() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.pcsg");
    fs::write(&file, "{n=1;}A // axiom\nA->sphere|move(n,0,0)cube").unwrap();
    let (code, printed, _, _) = run_in(folder.path(), &["fmt", "a.pcsg"]);
    assert_eq!(code, 0);
    assert!(
        printed.contains("A -> sphere | move(n, 0, 0) cube") && printed.contains("// axiom"),
        "{printed}"
    );
    assert_eq!(run_in(folder.path(), &["fmt", "--check", "a.pcsg"]).0, 1);
    assert_eq!(run_in(folder.path(), &["fmt", "--write", "a.pcsg"]).0, 0);
    assert_eq!(fs::read_to_string(&file).unwrap(), printed);
    let (code, out, err, files) = run_in(folder.path(), &["fmt", "--check", "a.pcsg"]);
    assert_eq!((code, out.as_str(), err.as_str()), (0, "", ""));
    assert_eq!(files, ["a.pcsg"]);
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
