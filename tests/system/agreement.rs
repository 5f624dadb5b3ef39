//! What must not change a picture or a hit, and what boxes are for.

#[path = "../../crates/trace/examples/agree/comparison/mod.rs"]
mod comparison;

use csg_graph_bounds::{HyperBoxes, chain, conventional, exact};
use csg_graph_trace::{Accelerated, Camera, Counters, Engine, Film, Light, Settings, World, render, zoom};

use comparison::{Comparison, Other};

use crate::scene;
use crate::scenes::{ENDING, corpus, smaller};

/// The scene from where a camera frames it, and what it cost.
fn picture(name: &str, set: &[String], choice: Choice, threads: usize) -> (Film, Counters) {
    let scene = scene(name, set);
    let limits = csg_graph_bounds::Limits::default();
    let tight = chain(&scene.graph, &limits).expect("the scene is small");
    let camera = Camera::framing(&tight.root, 40.0, 1.0);
    let boxes: Option<HyperBoxes> = match choice {
        Choice::None | Choice::Compiled => None,
        Choice::Conventional => Some(conventional(&scene.graph, &limits).expect("the scene is small")),
        Choice::Chain => Some(tight),
    };
    let compiled = (choice == Choice::Compiled).then(|| {
        let boxes = exact(&scene.graph, &limits.with_gap(1e-2)).expect("the scene is small");
        Accelerated::new(&scene.graph, &boxes, Accelerated::DEFAULT_BUDGET).expect("the scene is sound")
    });
    let walked = Engine::Reference(&scene.graph, boxes.as_ref());
    let world = World {
        engine: compiled.as_ref().map_or(walked, Engine::Fast),
        camera,
        lights: vec![Light::over_shoulder(&camera)],
        background: World::DEFAULT_BACKGROUND,
    };
    let settings = Settings { width: 64, height: 64, samples: 2, ..Settings::default() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
    pool.install(|| render(&world, &settings, &|_| {})).expect("the scene renders")
}

/// The boxes of the reference walk, or the fast engine.
#[derive(Clone, Copy, PartialEq)]
enum Choice {
    None,
    Conventional,
    Chain,
    Compiled,
}

/// They round differently, and so may a sample at a silhouette or at the edge of a shadow; no more than that.
#[test]
fn the_fast_engine_makes_the_pictures_of_the_reference_walk() {
    for folder in ENDING {
        for (name, _) in corpus(folder) {
            let set = smaller(&name);
            let (reference, walked) = picture(&name, &set, Choice::Chain, 2);
            let (fast, compiled) = picture(&name, &set, Choice::Compiled, 2);
            let differs =
                |(a, b): &(&[f32; 3], &[f32; 3])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-5);
            let differing = reference.pixels().iter().zip(fast.pixels()).filter(differs).count();
            assert!(differing <= 2, "{name}: {differing} of {} pixels differ", fast.pixels().len());
            assert_eq!(walked.rays, compiled.rays, "{name}");
            assert!(
                walked.shadow_rays.abs_diff(compiled.shadow_rays) <= 2,
                "{name}: {walked:?} {compiled:?}"
            );
        }
    }
}

/// The short run of `cargo xtask agree`: the fast engine alone, in packets and with its boxes open, the grid and the
/// unfolded tree have the hits of the reference walk.
#[test]
fn all_engines_have_the_same_hits() {
    for (name, _) in ENDING.into_iter().flat_map(corpus) {
        let comparison = Comparison::new(&name, &smaller(&name), &Other::ALL).expect("the scene is sound");
        let found = comparison.run(2_000).expect("the scene can be evaluated");
        assert!(found.hits > 300, "{name}: {} hits", found.hits);
        for (other, tally) in &found.tallies {
            assert!(tally.rays >= 2_000, "{name}, {other}: {} rays", tally.rays);
            assert_eq!(tally.disagreements, 0, "{name}, {other}: {:#?}", tally.told);
            assert!(tally.silhouettes <= 1, "{name}, {other}: {} at silhouettes", tally.silhouettes);
        }
    }
}

/// From where a leaf of the tree with 1.8·10¹⁹ primitives fills the picture, and on the way there.
#[test]
fn a_zoom_onto_a_leaf_has_the_hits_of_the_walk() {
    let set = ["cnt = 60".to_owned()];
    let others = [Other::Single, Other::Packets];
    let mut comparison = Comparison::new("peers/sympodial", &set, &others).expect("the scene is sound");
    let whole = comparison.camera;
    for factor in [1e3, 1e6, 1e9] {
        let camera = whole;
        let (lights, background) = (Vec::new(), World::DEFAULT_BACKGROUND);
        let world = World { engine: Engine::Fast(&comparison.fast), camera, lights, background };
        comparison.camera = zoom(&world, 1.0, factor).expect("the camera sees the tree");
        assert!(comparison.camera.eye.distance(comparison.camera.target) < 10.0 / factor);
        let found = comparison.run(400).expect("the scene can be evaluated");
        for (other, tally) in &found.tallies {
            assert_eq!(tally.disagreements, 0, "{other} at {factor}: {:#?}", tally.told);
            // A pixel of the closest picture is 10⁻¹¹.
            assert!(tally.largest < 1e-13 && tally.silhouettes <= 1, "{other} at {factor}: {tally:?}");
        }
    }
}

/// What differs by more than a silhouette is told: the same tree with one parameter a little different.
#[test]
fn engines_of_another_scene_are_found_out() {
    let set = |value: &str| [format!("fTR = {value}"), "cnt = 2".to_owned()];
    let comparison = |value: &str| Comparison::new("sympodial", &set(value), &[Other::Single]);
    let mut mixed = comparison("0.96").expect("the scene is sound");
    mixed.fast = comparison("0.9601").expect("the scene is sound").fast;
    let found = mixed.run(2_000).expect("the scene can be evaluated");
    let (_, tally) = &found.tallies[0];
    assert!(tally.disagreements > 100, "{} of {} rays", tally.disagreements, tally.rays);
}

/// What the chain algorithm is quick with: random parts leave it little to share.
fn moderate(name: &str) -> Vec<String> {
    if name == "bush" { vec!["n = 3".to_owned()] } else { Vec::new() }
}

#[test]
fn any_number_of_threads_compiles_and_traces_the_same() {
    for name in ["sympodial", "puzzle_ball", "bush"] {
        let set = moderate(name);
        let one = picture(name, &set, Choice::Compiled, 1);
        for threads in [2, 3] {
            assert_eq!(one, picture(name, &set, Choice::Compiled, threads), "{name} on {threads} threads");
        }
    }
}

/// And all scenes, those with random numbers in them among them, if they are small.
#[test]
fn eight_threads_make_the_pictures_of_one() {
    for (name, _) in ENDING.into_iter().flat_map(corpus) {
        let set = smaller(&name);
        let [one, eight] = [1, 8].map(|threads| picture(&name, &set, Choice::Compiled, threads));
        assert!(one == eight, "{name}");
    }
}

#[test]
fn boxes_change_the_cost_and_not_the_picture() {
    for (name, _) in ENDING.into_iter().flat_map(corpus) {
        let (name, set) = (name.as_str(), smaller(&name));
        let (reference, none) = picture(name, &set, Choice::None, 2);
        let (loose_film, loose) = picture(name, &set, Choice::Conventional, 2);
        let (tight_film, tight) = picture(name, &set, Choice::Chain, 2);
        assert_eq!(reference.pixels(), loose_film.pixels(), "{name}");
        assert_eq!(reference.pixels(), tight_film.pixels(), "{name}");
        assert!(
            none.nodes_visited > loose.nodes_visited && loose.nodes_visited >= tight.nodes_visited,
            "{name}"
        );
        assert!(
            none.primitive_tests > loose.primitive_tests && loose.primitive_tests >= tight.primitive_tests
        );
    }
}

#[test]
fn tight_boxes_pay_on_the_sympodial_tree() {
    let (_, loose) = picture("sympodial", &[], Choice::Conventional, 2);
    let (_, tight) = picture("sympodial", &[], Choice::Chain, 2);
    assert!(loose.box_tests > 2 * tight.box_tests, "{loose:?} {tight:?}");
    assert!(loose.nodes_visited > 2 * tight.nodes_visited, "{loose:?} {tight:?}");
    assert!(loose.primitive_tests >= tight.primitive_tests, "{loose:?} {tight:?}");
}

#[test]
fn any_number_of_threads_gives_the_same_picture() {
    for name in ["sympodial", "puzzle_ball", "bush"] {
        let set = moderate(name);
        let one = picture(name, &set, Choice::Chain, 1);
        for threads in [2, 3, 8] {
            assert_eq!(one, picture(name, &set, Choice::Chain, threads), "{name} on {threads} threads");
        }
    }
}
