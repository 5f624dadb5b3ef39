//! `pcsg bounds`: boxes, other volumes, comparisons and drawings.

use std::fs;

use serde_json::Value;

use crate::{path, run, run_in, scene};

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
    let excess = number(&sphere["excess"]);
    assert!(excess > 0.0 && excess <= 0.01 && aabb["excess"].is_null(), "{excess}");
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
