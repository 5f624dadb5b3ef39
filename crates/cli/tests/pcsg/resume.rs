//! Long renders: stopped by Ctrl-C, gone on with, and stopped by themselves where there is no more noise.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::{files, json, pcsg, run_in, scene};

/// A picture that takes a second or two.
const PICTURE: [&str; 6] = ["--size", "96x72", "--samples", SAMPLES, "--set", "cnt=6"];
const SAMPLES: &str = "2000";

/// The exit code of `pcsg render`, and what is said to people.
fn render(folder: &Path, args: &[&str]) -> (i32, String) {
    let (code, out, err, _) = run_in(folder, &[&["render"], args].concat());
    assert!(out.is_empty());
    (code, err)
}

/// Renders and presses Ctrl-C in the middle; gives what is said. Where the middle is depends on the machine: it is
/// sought between delays that were too short, so that there was no ray yet, and too long, so that all was done.
fn interrupt(folder: &Path, args: &[&str]) -> String {
    let before = files(folder);
    let (mut too_short, mut too_long) = (Duration::ZERO, Duration::from_millis(600));
    for _ in 0..40 {
        let delay = (too_short + too_long) / 2;
        let child = pcsg(folder, &[&["render"], args].concat())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        sleep(delay);
        let pid = child.id().to_string();
        Command::new("kill").args(["-INT", &pid]).status().expect("there is a kill command");
        let output = child.wait_with_output().expect("it ends");
        match output.status.code() {
            Some(130) => return String::from_utf8(output.stderr).expect("the program speaks UTF-8"),
            // A machine has slow moments: neither end is believed for good.
            None => (too_short, too_long) = (delay, too_long.max(2 * delay)),
            Some(0) => (too_short, too_long) = (too_short / 2, delay),
            code => panic!("{code:?} after {delay:?}: {}", String::from_utf8_lossy(&output.stderr)),
        }
        for file in files(folder).iter().filter(|file| !before.contains(file)) {
            fs::remove_file(folder.join(file)).expect("a picture that was finished can be removed");
        }
    }
    panic!("no moment between the first ray and the last was met");
}

/// A copy of the scene, alone in a folder.
fn folder_with_scene() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::copy(scene("sympodial.pcsg"), folder.path().join("s.pcsg")).expect("the corpus has the scene");
    folder
}

#[test]
fn an_interrupted_picture_goes_on_to_the_same_bytes() {
    for (file, threads, further) in
        [("a.png", ["1", "2"], &[][..]), ("a.exr", ["2", "1"], &[]), ("a.png", ["2", "2"], &["--noise", "1"])]
    {
        let [folder, whole] = [folder_with_scene(), folder_with_scene()];
        let args = |threads| {
            [&["s.pcsg", "-o", file, "--stats", "a.json", "--threads", threads], &PICTURE[..], further]
                .concat()
        };
        let said = interrupt(folder.path(), &args(threads[0]));
        let part = format!("{file}.part");
        assert!(said.contains(&format!("interrupted: {file} has ")), "{said}");
        assert!(said.contains(&part), "{said}");
        let mut left = ["a.json", file, &part, "s.pcsg"];
        left.sort_unstable();
        assert_eq!(files(folder.path()), left);
        let so_far = fs::read(folder.path().join(file)).unwrap();
        let taken = |folder: &Path| json(&folder.join("a.json"))["samples_taken"].as_u64().unwrap();
        let taken_so_far = taken(folder.path());
        assert!(taken_so_far < 96 * 72 * SAMPLES.parse::<u64>().unwrap());

        let resumed = [&args(threads[1])[..], &["--resume"]].concat();
        assert_eq!(render(folder.path(), &resumed), (0, String::new()));
        assert!(!folder.path().join(&part).exists(), "it is of no more use");
        assert_eq!(render(whole.path(), &args("2")), (0, String::new()));
        let [picture, expected] = [&folder, &whole].map(|folder| fs::read(folder.path().join(file)).unwrap());
        assert!(picture == expected, "{file} differs");
        assert!(picture != so_far, "the picture of what there was is not the whole");
        assert!(taken(folder.path()) > taken_so_far);
        let [stats, expected] = [&folder, &whole].map(|folder| json(&folder.path().join("a.json")));
        for name in ["samples_taken", "rays", "shadow_rays", "box_tests", "primitive_tests"] {
            assert_eq!(stats[name], expected[name], "{name}");
        }
    }
}

#[test]
fn an_interruption_before_the_first_ray_says_so() {
    let folder = folder_with_scene();
    // Boxes that take longer than anyone waits for.
    let endless = ["--set", "cnt=50", "--boxes", "chain", "--max-steps", "18446744073709551615"];
    let args = [&["render", "s.pcsg", "-o", "a.png"], &endless[..]].concat();
    let mut delay = Duration::from_millis(200);
    let said = loop {
        let child = pcsg(folder.path(), &args).stderr(Stdio::piped()).spawn().expect("the program starts");
        sleep(delay);
        let pid = child.id().to_string();
        Command::new("kill").args(["-INT", &pid]).status().expect("there is a kill command");
        let output = child.wait_with_output().expect("it ends");
        match output.status.code() {
            // It had not begun to listen.
            None => delay *= 2,
            code => {
                assert_eq!(code, Some(130));
                break String::from_utf8(output.stderr).expect("the program speaks UTF-8");
            }
        }
    };
    assert_eq!(said, "interrupted before the first ray; nothing was written\n");
    assert_eq!(files(folder.path()), ["s.pcsg"]);
}

#[test]
fn only_the_same_picture_goes_on() {
    let folder = folder_with_scene();
    let base = [&["s.pcsg", "-o", "a.png", "--threads", "2"], &PICTURE[..]].concat();
    interrupt(folder.path(), &base);
    let part = folder.path().join("a.png.part");
    let kept = fs::read(&part).unwrap();
    let refused = |args: &[&str], reason: &str| {
        let (code, said) = render(folder.path(), args);
        assert_eq!(code, 1, "{said}");
        assert!(said.contains("a.png.part") && said.contains(reason), "{said}");
    };

    refused(&base, "--resume goes on from there");
    for (further, reason) in [
        (&["--set", "cnt=5"][..], "set was cnt=6 and is cnt=6; cnt=5"),
        (&["--noise", "2"], "noise was none and is 2"),
        (&["--view", "normal"], "view was shaded and is normal"),
        (&["--engine", "reference"], "engine was fast and is reference"),
        (&["--budget", "64K"], "budget was 393216 and is 65536"),
        (&["--max-states", "10"], "regime was finite and is vast"),
    ] {
        refused(&[&base[..], &["--resume"], further].concat(), reason);
    }
    let other_size =
        ["s.pcsg", "-o", "a.png", "--size", "72x96", "--samples", "9", "--set", "cnt=6", "--resume"];
    refused(&other_size, &format!("size was 96x72 and is 72x96, samples was {SAMPLES} and is 9"));
    let scene = fs::read_to_string(folder.path().join("s.pcsg")).unwrap();
    fs::write(folder.path().join("s.pcsg"), format!("{scene}// changed\n")).unwrap();
    let resumed = [&base[..], &["--resume"]].concat();
    refused(&resumed, "the scene has changed since");
    fs::write(folder.path().join("s.pcsg"), &scene).unwrap();

    let damaged = |at: usize| {
        let mut bytes = kept.clone();
        bytes[at] ^= 4;
        bytes
    };
    let middle = kept.len() / 2;
    for (bytes, reason) in [
        (damaged(middle), "damaged or not complete"),
        (damaged(24), "damaged or not complete"),
        (damaged(kept.len() - 1), "damaged or not complete"),
        (kept[..middle].to_vec(), "damaged or not complete"),
        (kept[..18].to_vec(), "damaged or not complete"),
        (damaged(17), "version 1026"),
        (damaged(3), "no checkpoint"),
        (Vec::new(), "no checkpoint"),
        (b"someone else's half a download".to_vec(), "no checkpoint"),
    ] {
        fs::write(&part, &bytes).unwrap();
        refused(&resumed, reason);
        assert_eq!(fs::read(&part).unwrap(), bytes, "it is left alone");
    }
    // Without a checkpoint, the picture is begun.
    fs::remove_file(&part).unwrap();
    let quick = ["s.pcsg", "-o", "b.png", "--size", "8x8", "--samples", "1", "--resume"];
    assert_eq!(render(folder.path(), &quick), (0, String::new()));
    assert_eq!(files(folder.path()), ["a.png", "b.png", "s.pcsg"]);
}

#[test]
fn noise_is_the_same_on_any_number_of_threads_and_leaves_its_samples_in_a_layer() {
    use exr::prelude::*;

    let folder = folder_with_scene();
    let noisy = |threads: &str, engine: &str, file: &str| {
        let args = [
            &["s.pcsg", "-o", file, "--stats", "a.json", "--threads", threads, "--engine", engine][..],
            &["--size", "64x48", "--set", "cnt=3", "--noise", "4", "--samples", "100"],
        ];
        assert_eq!(render(folder.path(), &args.concat()), (0, String::new()));
        (fs::read(folder.path().join(file)).unwrap(), json(&folder.path().join("a.json")))
    };
    let (picture, stats) = noisy("1", "fast", "a.exr");
    let (again, stats_again) = noisy("2", "fast", "b.exr");
    assert!(picture == again && stats["samples_taken"] == stats_again["samples_taken"]);
    assert_eq!((&stats["samples"], &stats["noise"]), (&100.into(), &4.0.into()));
    assert_eq!(stats["samples_taken"], stats["rays"]);
    let taken = stats["samples_taken"].as_u64().unwrap();
    assert!(taken > 64 * 48 * 16 && taken < 64 * 48 * 90, "{taken}");

    let layer = |file: &str, name: &str| {
        let path = folder.path().join(file);
        let image =
            read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        let image = image.from_file(path).unwrap();
        let is_meant = |layer: &&Layer<AnyChannels<FlatSamples>>| {
            layer.attributes.layer_name.as_ref().is_some_and(|found| *found == *name)
        };
        let layer = image.layer_data.iter().find(is_meant).unwrap();
        match &layer.channel_data.list[0].sample_data {
            FlatSamples::U32(samples) => samples.clone(),
            other => panic!("{name} has whole numbers, not {other:?}"),
        }
    };
    let counts = layer("a.exr", "samples");
    assert_eq!(counts.iter().copied().map(u64::from).sum::<u64>(), taken);
    assert!(counts.contains(&16) && counts.contains(&100));

    // States have the numbers that `bounds` lists, whatever the engine.
    let states = layer("a.exr", "state");
    for engine in ["reference", "grid"] {
        noisy("2", engine, "c.exr");
        let pairs = states.iter().zip(layer("c.exr", "state"));
        assert!(pairs.filter(|(a, b)| *a != b).count() <= 1, "{engine}");
    }
    let bounds = ["bounds", "s.pcsg", "--set", "cnt=3", "--method", "exact", "--format", "json"];
    let listed: Value = serde_json::from_str(&run_in(folder.path(), &bounds).1).unwrap();
    let listed = listed["states"].as_array().unwrap();
    let symbol = |id: u32| {
        let state = listed.iter().find(|state| state["id"] == id);
        state.unwrap_or_else(|| panic!("state {id} is not listed"))["symbol"].as_str().unwrap()
    };
    let met: Vec<u32> = states.into_iter().filter(|state| *state < 1 << 24).collect();
    assert!(met.len() > 100 && met.iter().all(|id| ["TR", "SG"].contains(&symbol(*id))));
}
