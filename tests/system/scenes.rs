//! The corpus: every scene is right, in the standard layout, and agrees with its unfolded tree, unless it never ends; and
//! what is too large to be listed is the same picture for any number of threads.

use std::path::{Path, PathBuf};

use csg_graph::{Limits, StatesError};
use csg_graph_bounds::{Aabb, Envelopes, chain, conventional, exact};
use csg_graph_tests::repository;
use csg_graph_trace::{
    Accelerated, Camera, Engine, Film, Light, Ray, Settings, StateBounds, Walk, World, brute, render,
};

use crate::scene;

/// Folders of scenes that end: those of `scenes/vast` too, but only with [`smaller`] numbers can they be listed.
pub(crate) const ENDING: [&str; 5] =
    ["scenes", "scenes/nature", "scenes/peers", "scenes/solids", "scenes/vast"];

/// The scenes of a folder, with their paths from `scenes` without an extension.
pub(crate) fn corpus(folder: &str) -> Vec<(String, PathBuf)> {
    let scenes = repository().join("scenes");
    let name = |path: &Path| {
        let name = path.strip_prefix(&scenes).expect("a folder of scenes").with_extension("");
        name.to_string_lossy().replace('\\', "/")
    };
    let mut scenes: Vec<_> = std::fs::read_dir(repository().join(folder))
        .expect("the repository has scenes")
        .map(|entry| entry.expect("the folder can be read").path())
        .filter(|path| path.is_file())
        .map(|path| (name(&path), path))
        .collect();
    scenes.sort();
    scenes
}

/// What unfolds into a tree that is quickly walked.
pub(crate) fn smaller(name: &str) -> Vec<String> {
    match name {
        "sympodial" | "peers/sympodial" => vec!["cnt = 2".to_owned()],
        "sierpinski" | "peers/sierpinski" | "peers/sierpinski_tet" => vec!["n = 3".to_owned()],
        "cheese" | "solids/plate" => vec!["n = 2".to_owned()],
        "city" => vec!["n = 1".to_owned()],
        "gasket" => vec!["n = 3".to_owned()],
        "nature/clouds" => vec!["n = 1".to_owned()],
        "nature/coral" => vec!["n = 3".to_owned()],
        "nature/fir" => vec!["n = 2".to_owned(), "m = 2".to_owned()],
        "nature/oak" => vec!["n = 3".to_owned()],
        "nature/shell" => vec!["n = 20".to_owned(), "inside = 4".to_owned()],
        // A place with trees.
        "vast/forest" => {
            let place = ["x = 22", "y = 33", "rough = 1", "h01 = 4", "h11 = 3"];
            let size = ["n = 1", "m = 2", "whorls = 2", "grass = 1"];
            place.into_iter().chain(size).map(str::to_owned).collect()
        }
        "vast/terrain" => vec!["n = 3".to_owned()],
        "daylight" => vec!["cnt = 2".to_owned(), "field = 2".to_owned()],
        "still_life" => vec!["n = 2".to_owned(), "cones = 4".to_owned()],
        "bush" => vec!["n = 1".to_owned(), "stems = 3".to_owned(), "petals = 9".to_owned()],
        "solids/thread" => vec!["n = 3".to_owned()],
        "solids/fractals" => vec!["n = 2".to_owned(), "m = 1".to_owned()],
        "solids/tower" => vec!["n = 2".to_owned(), "arches = 2".to_owned()],
        _ => vec![],
    }
}

#[test]
fn states_have_the_same_numbers_wherever_they_are_listed() {
    for (name, _) in ENDING.into_iter().flat_map(corpus) {
        let graph = scene(&name, &smaller(&name)).graph;
        let listed = graph.states(&Limits::default()).unwrap();
        let bounded = exact(&graph, &csg_graph_bounds::Limits::default()).unwrap();
        assert!(bounded.states().map(|(state, _)| state).eq(listed.states()), "{name}");
        let last = listed.len() - 1;
        assert_eq!(bounded.index_of(&graph.root_state()), Some(last), "{name}");
    }
}

#[test]
fn every_scene_is_sound_and_in_the_standard_layout() {
    for folder in ENDING.into_iter().chain(["scenes/endless"]) {
        for (name, path) in corpus(folder) {
            let source = std::fs::read_to_string(&path).unwrap();
            let lowered = csg_graph_grammar::load(&source, &[])
                .unwrap_or_else(|mistakes| panic!("{name}: {mistakes:?}"));
            assert!(lowered.warnings.is_empty(), "{name}: {:?}", lowered.warnings);
            match lowered.scene.graph.analyse(&Limits::default()) {
                Ok(_) => assert!(ENDING.contains(&folder) && folder != "scenes/vast", "{name}"),
                Err(StatesError::Endless { .. }) => assert_eq!(folder, "scenes/endless", "{name}"),
                Err(StatesError::TooMany { .. }) => assert_eq!(folder, "scenes/vast", "{name}"),
                Err(error) => panic!("{name}: {error}"),
            }
            let printed = csg_graph_grammar::print(&csg_graph_grammar::parse(&source).tree);
            assert_eq!(printed, source, "{name}: run `cargo xtask fmt --write scenes/{name}.pcsg`");
        }
    }
}

#[test]
fn every_scene_has_the_hits_of_its_unfolded_tree() {
    for (name, _) in ENDING.into_iter().flat_map(corpus) {
        let scene = scene(&name, &smaller(&name));
        let tree = scene.graph.unfold(100_000).unwrap();
        let boxes = chain(&scene.graph, &csg_graph_bounds::Limits::default()).unwrap();
        let lens = Camera::framing(&boxes.root, 40.0, 1.0).lens(24, 24).unwrap();
        let mut walk = Walk::new(&scene.graph, Some(&boxes));
        let (mut hits, mut rays) = (0, 0);
        for (x, y) in (0..24).flat_map(|y| (0..24).map(move |x| (f64::from(x) + 0.37, f64::from(y) + 0.61))) {
            let ray: Ray = lens.ray(x, y);
            let line = brute::line(&tree, &ray);
            if line.clearance < 1e-6 {
                // Two boundaries as good as coincide; which one is first is rounding.
                continue;
            }
            rays += 1;
            let expected = line.crossings.iter().find(|crossing| crossing.t > 0.0);
            match (walk.nearest(&ray).unwrap(), expected) {
                (None, None) => {}
                (Some(hit), Some(crossing)) => {
                    hits += 1;
                    assert!((hit.t - crossing.t).abs() < 1e-9 * crossing.t, "{name} at {x} {y}");
                    assert!(hit.normal.distance(crossing.normal) < 1e-6, "{name} at {x} {y}");
                    assert_eq!(hit.node, crossing.node, "{name} at {x} {y}");
                }
                (found, expected) => panic!("{name} at {x} {y}: {found:?} instead of {expected:?}"),
            }
        }
        assert!(rays > 400 && hits > 20, "{name}: {hits} hits of {rays} rays");
    }
}

#[test]
fn conventional_boxes_of_scenes_enclose_those_of_chains_and_these_the_exact_ones() {
    let limits = csg_graph_bounds::Limits::default();
    for (name, _) in ENDING.into_iter().flat_map(corpus) {
        let graph = scene(&name, &smaller(&name)).graph;
        let conventional = conventional(&graph, &limits).unwrap();
        let chain = chain(&graph, &limits).unwrap();
        let exact = exact(&graph, &limits).unwrap().into_hyper_boxes();
        // Each is rounded outward by a little of its own.
        let margin = 1e-11 * conventional.root.size().max_element();
        for [outer, inner] in [[&conventional, &chain], [&chain, &exact]] {
            let nodes = outer.nodes.iter().zip(&inner.nodes);
            for (outer, inner) in nodes.chain([(&outer.root, &inner.root)]) {
                let grown = Aabb { min: outer.min - margin, max: outer.max + margin };
                assert!(grown.encloses(*inner), "{name}: {outer:?} {inner:?}");
            }
        }
        if name == "sierpinski" || name == "peers/sierpinski_tet" {
            // Of polytopes, the point sets are the corners.
            let grown = Aabb { min: exact.root.min - margin, max: exact.root.max + margin };
            assert!(grown.encloses(chain.root), "{chain:?}");
        }
    }
}

/// Endless recursion has the box of what it would be if it went on for long enough.
#[test]
fn every_endless_scene_has_the_box_of_its_attractor() {
    let known = |name: &str| match name {
        "endless/koch" => Some(([-3.0; 3], [3.0; 3])),
        "endless/sierpinski" | "endless/menger" => Some(([-1.0; 3], [1.0; 3])),
        "endless/dragon" => Some(([-1.0 / 3.0, -1.0 / 3.0, 0.0], [7.0 / 6.0, 2.0 / 3.0, 0.0])),
        "endless/fern" => None,
        _ => panic!("{name} has no known box"),
    };
    let scenes = corpus("scenes/endless");
    assert_eq!(scenes.len(), 5);
    for (name, _) in scenes {
        let graph = scene(&name, &[]).graph;
        let found = exact(&graph, &csg_graph_bounds::Limits::default()).unwrap();
        assert!(found.endless.unwrap().contraction < 0.86, "{name}: {:?}", found.endless);
        assert!(found.gap < 1e-10, "{name}: {}", found.gap);
        if let Some((min, max)) = known(&name) {
            let known = Aabb::new(min.into(), max.into());
            assert!(found.root.encloses(known), "{name}: {:?}", found.root);
            let off = (found.root.min - known.min).abs().max((found.root.max - known.max).abs());
            assert!(off.max_element() < 1e-11, "{name}: {:?}", found.root);
        }
    }
}

/// A small picture of a scene as it is, compiled as rays come to it.
fn on_demand(scene: &csg_graph_grammar::Scene, threads: usize) -> Film {
    let envelopes = Envelopes::new(scene.graph.clone(), &csg_graph_bounds::Limits::default());
    let engine =
        Accelerated::on_demand(scene.graph.clone(), StateBounds::Envelopes(Box::new(envelopes)), 64 << 20)
            .expect("the root can be evaluated")
            .with_detail(0.5);
    let asked = scene.look.camera;
    let camera = Camera {
        eye: asked.eye.expect("the boxes of such scenes are too large to frame them"),
        target: asked.target.expect("the boxes of such scenes are too large to frame them"),
        up: glam::DVec3::Z,
        fov: Camera::DEFAULT_FOV,
    };
    let world = World {
        engine: Engine::Fast(&engine),
        camera,
        lights: vec![Light::over_shoulder(&camera)],
        background: World::DEFAULT_BACKGROUND,
    };
    let settings = Settings { width: 12, height: 8, samples: 1, ..Settings::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
    pool.install(|| render(&world, &settings, &|_| {})).expect("the scene renders").0
}

#[test]
fn any_number_of_threads_makes_the_same_picture_of_a_vast_scene() {
    for (name, _) in corpus("scenes/vast") {
        let set = match name.as_str() {
            "vast/forest" => vec!["m = 2".to_owned(), "whorls = 5".to_owned()],
            "vast/terrain" => vec!["n = 9".to_owned()],
            _ => vec![],
        };
        let scene = scene(&name, &set);
        let one = on_demand(&scene, 1);
        let bytes = one.to_srgb8();
        assert!(bytes.chunks(3).any(|pixel| pixel != &bytes[..3]), "{name} is not seen");
        for threads in [2, 8] {
            assert!(one == on_demand(&scene, threads), "{name}: {threads} threads");
        }
    }
}
