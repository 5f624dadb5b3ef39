//! The short run of the seeds in `examples/seeds`: no envelope cuts anything off; and if one did, it would tell.
#![cfg(feature = "csg-graph")]
#![expect(clippy::unwrap_used, reason = "a test that fails to read its scene fails")]

#[path = "../examples/seeds/sweep/mod.rs"]
mod sweep;

use std::path::Path;

use sweep::{OWN, Subject, check, looseness};

/// The scenes of the long run's own, and a bush.
fn subjects() -> Vec<Subject> {
    let bush = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/bush.pcsg");
    let mut scenes = OWN.map(|(name, source)| (name, source.to_owned())).to_vec();
    // The package is without it.
    scenes.extend(std::fs::read_to_string(bush).ok().map(|source| ("bush", source)));
    scenes.into_iter().map(|(name, source)| Subject::new(name, source).unwrap().unwrap()).collect()
}

#[test]
fn envelopes_enclose_exact_boxes() {
    for subject in subjects() {
        let scene = subject.reduced(150).unwrap().unwrap();
        let found = check(&scene, 0..50, 0.0).unwrap();
        assert_eq!(found.violations, 0, "{}: {:#?}", subject.name(), found.told);
        assert_eq!((found.seeds, found.unlisted, found.skipped), (50, 0, 0), "{}", subject.name());
        assert!(found.states > 50 * 20, "{}: {} states", subject.name(), found.states);
    }
}

#[test]
fn envelopes_that_are_too_small_are_found_out() {
    for subject in subjects() {
        let scene = subject.reduced(150).unwrap().unwrap();
        let found = check(&scene, 0..3, 1e-6).unwrap();
        assert!(found.violations > 0 && !found.told.is_empty(), "{}", subject.name());
    }
}

#[test]
fn an_expansion_makes_them_tight() {
    for subject in subjects() {
        let scene = subject.reduced(2_000).unwrap().unwrap();
        if let [Some(direct), Some(expanded)] = looseness(&scene, 0..3).unwrap() {
            assert!(1.0 <= expanded && expanded <= direct && expanded <= 1.5, "{direct} {expanded}");
        }
    }
}

#[test]
fn a_scene_without_chance_is_none_of_them() {
    let source =
        "{ n = 3; } T\nT if(n > 0, 2, 1)\n1: T -> sphere\n2: T -> sphere | {n = n - 1} move(0, 0, 2) T";
    assert!(Subject::new("tower", source.to_owned()).unwrap().is_none());
}

#[test]
fn a_scene_without_a_seed_is_compared_once() {
    let source = "{ n = 9; } T\nT if(n > 0, 2, 1)\n1: T -> sphere\n\
                  2: T -> sphere | {n = n - 1} move(0, hash(n), 2) uscale(0.9) T";
    let subject = Subject::new("tower", source.to_owned()).unwrap().unwrap();
    let scene = subject.reduced(20).unwrap().unwrap();
    assert!(scene.to_string().starts_with("n="), "{scene}");
    assert_eq!(check(&scene, 0..50, 0.0).unwrap().seeds, 1);
}
