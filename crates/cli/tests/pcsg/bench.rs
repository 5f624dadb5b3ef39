//! `pcsg bench`: what is measured, and drawings of it.

use serde_json::Value;

use crate::{path, run, scene};

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
    let fern = scene("endless/fern.pcsg");
    let (code, out, _, _) = run(&["bench", path(&fern), "--size", "8x8", "--reps", "1"]);
    assert!(code == 0 && out.contains("primitives       endless"), "{out}");
}

#[test]
fn a_bench_draws_sweeps() {
    let cheese = scene("peers/cheese.pcsg");
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
}
