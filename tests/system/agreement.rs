//! What must not change a picture, and what boxes are for.

use csg_graph_bounds::{HyperBoxes, chain, conventional};
use csg_graph_trace::{Camera, Counters, Engine, Film, Light, Settings, View, World, render};

use crate::scene;

/// The scene from where a camera frames it, and what it cost.
fn picture(name: &str, set: &[String], boxes: Choice, threads: usize) -> (Film, Counters) {
    let scene = scene(name, set);
    let limits = csg_graph_bounds::Limits::default();
    let tight = chain(&scene.graph, &limits).expect("the scene is small");
    let camera = Camera::framing(&tight.root, 40.0, 1.0);
    let boxes: Option<HyperBoxes> = match boxes {
        Choice::None => None,
        Choice::Conventional => Some(conventional(&scene.graph, &limits).expect("the scene is small")),
        Choice::Chain => Some(tight),
    };
    let world = World {
        engine: Engine::Reference(&scene.graph, boxes.as_ref()),
        camera,
        lights: vec![Light::over_shoulder(&camera)],
        background: World::DEFAULT_BACKGROUND,
    };
    let settings = Settings { width: 64, height: 64, samples: 2, view: View::Shaded };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
    pool.install(|| render(&world, &settings, &|_| {})).expect("the scene renders")
}

#[derive(Clone, Copy)]
enum Choice {
    None,
    Conventional,
    Chain,
}

#[test]
fn boxes_change_the_cost_and_not_the_picture() {
    for (name, set) in [
        ("sympodial", "cnt = 4"),
        ("sierpinski", "n = 3"),
        ("cheese", "n = 2"),
        ("puzzle_ball", "shells = 2"),
    ] {
        let set = [set.to_owned()];
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
    for name in ["sympodial", "puzzle_ball"] {
        let one = picture(name, &[], Choice::Chain, 1);
        for threads in [2, 3, 8] {
            assert_eq!(one, picture(name, &[], Choice::Chain, threads), "{name} on {threads} threads");
        }
    }
}
