//! Random grammars: where seeds are derived, which calls draw different numbers, and what stays as it was without any.
#![expect(clippy::float_cmp, reason = "the same draw gives the same bits")]

use csg_graph::{Graph, Node, Step};
use csg_graph_grammar::{Override, Scene, load, parse, print};

fn scene(source: &str, overrides: &[&str]) -> Scene {
    let overrides: Vec<_> = overrides.iter().map(|set| Override::parse(set).unwrap()).collect();
    let told = |reports: Vec<csg_graph_grammar::Diagnostic>| reports[0].render("", source, false);
    let lowered = load(source, &overrides).unwrap_or_else(|reports| panic!("{}", told(reports)));
    assert_eq!(lowered.warnings, [], "{source}");
    lowered.scene
}

fn graph(source: &str) -> Graph {
    scene(source, &[]).graph
}

/// The assignments of all C-nodes, as the drawing shows them.
fn calculations(graph: &Graph) -> Vec<String> {
    let dot = graph.to_dot();
    dot.split("label = \"{").skip(1).filter_map(|rest| Some(rest.split_once("}\"")?.0.to_owned())).collect()
}

/// The sizes of the balls in the order of the text: each is a `uscale` that is drawn.
fn sizes(graph: &Graph) -> Vec<f64> {
    let mut sizes = Vec::new();
    let mut pending = vec![graph.root_state()];
    while let Some(state) = pending.pop() {
        let step = graph.step(&state).unwrap();
        if let Step::Transform(transform, _) = &step {
            sizes.push(transform.to_affine().matrix3.x_axis.x);
        }
        pending.extend(step.into_states().into_iter().flatten().rev());
    }
    sizes
}

fn assert_distinct(numbers: &[f64]) {
    for (index, number) in numbers.iter().enumerate() {
        assert!(!numbers[..index].contains(number), "{numbers:?}");
    }
}

const BALLS: &str = "{} BALL | BALL | PAIR\nPAIR -> BALL | BALL\nBALL -> uscale(rand(1, 2)) sphere";

#[test]
fn every_reference_hands_down_its_own_seed() {
    let graph = graph(BALLS);
    assert_eq!(
        calculations(&graph),
        [1, 2, 3, 1, 2].map(|position| format!("seed = derive(seed, {position})"))
    );
    let sizes = sizes(&graph);
    assert_eq!(sizes.len(), 4);
    assert_distinct(&sizes);
    assert!(sizes.iter().all(|size| (1.0..2.0).contains(size)));
}

#[test]
fn references_are_numbered_from_the_left_within_their_rule() {
    // Macros and symbols count, primitives do not; what draws nothing counts and gets no C-node.
    let source = "{} sure | sphere | (sphere | BALL) | move(3, 0, 0) ball
        sure = cube
        ball = BALL
        BALL -> uscale(rand(1, 2)) sphere";
    let [second, third, first] = [2, 3, 1].map(|position| format!("seed = derive(seed, {position})"));
    assert_eq!(calculations(&graph(source)), [second, third, first]);
}

#[test]
fn calls_are_independent_and_repeatable() {
    let source = "{} uscale(rand(1, 2)) sphere | uscale(rand(1, 2)) (uscale(rand(1, 2)) sphere)";
    let drawn = sizes(&graph(source));
    assert_distinct(&drawn);
    assert_eq!(drawn, sizes(&graph(source)));
    // Numbers belong to calls by their place from the left, whatever else is around them.
    let spread = source.replace("sphere |", "(sphere) |\n // a comment\n move(0, 0, 1 - 1)");
    assert!(sizes(&graph(&spread)).iter().filter(|size| drawn.contains(size)).count() == 3);
}

#[test]
fn nested_calls_are_numbered_where_they_begin() {
    let value = |expression: &str| {
        let graph = graph(&format!("{{ _a = {expression}; }} sphere"));
        let a = graph.params().find(|param| graph.param_name(*param) == "_a").unwrap();
        graph.initial().get(a).unwrap()
    };
    // The outer call is the first, and draws as it does alone: two thirds of the way to an end that is drawn.
    let share = value("rand(0, 1)");
    let inner = value("0 * rand(0, 1) + rand(1, 2)");
    assert!((value("rand(0, rand(1, 2))") - share * inner).abs() < 1e-12);
}

#[test]
fn rules_selections_parameters_and_blocks_have_streams_of_their_own() {
    let source = "{ a = rand(1, 2); } uscale(a) sphere | uscale(rand(1, 2)) sphere
        camera { eye = (rand(1, 2), 0, 0); target = (rand(1, 2), 0, 0); }
        light { position = (rand(1, 2), 0, 0); }";
    let scene = scene(source, &[]);
    let mut drawn = sizes(&scene.graph);
    let position = scene.look.lights.iter().find_map(|light| match light.source {
        csg_graph_grammar::LightSource::Position(position) => Some(position.x),
        _ => None,
    });
    drawn.extend([scene.look.camera.eye.unwrap().x, scene.look.camera.target.unwrap().x]);
    drawn.extend(position);
    assert_eq!(drawn.len(), 5);
    assert_distinct(&drawn);

    // What a selection draws tells nothing about what its rule draws from the same seed.
    let source = "{ s = 0; } {seed = s} A\nA if(rand(0, 1) < 0.5, 1, 2)
        1: A -> uscale(rand(1, 2)) sphere\n2: A -> uscale(rand(1, 2)) sphere";
    let mut low = 0;
    for seed in 0..400 {
        let graph = self::scene(source, &[&format!("s = {seed}")]).graph;
        let mut state = graph.root_state();
        let mut first = true;
        while let Some(below) = graph.step(&state).unwrap().into_states()[0].clone() {
            if let Node::Symbol(symbol) = graph.node(state.node()) {
                first = symbol.rules[0] == below.node();
            }
            state = below;
        }
        low += u32::from(first && sizes(&graph)[0] < 1.5);
    }
    assert!((70..130).contains(&low), "{low} of 400, expected a quarter");
}

#[test]
fn the_seed_can_be_read_and_set() {
    let variants = "{ n = 200; } ROW\nROW if(n > 0, 2, 1)\n1: ROW -> sphere
        2: ROW -> {seed = seed % 8} BALL | {n = n - 1} move(1, 0, 0) ROW\nBALL -> uscale(rand(1, 2)) sphere";
    let mut eight: Vec<f64> = sizes(&graph(variants)).into_iter().filter(|size| *size != 1.0).collect();
    assert_eq!(eight.len(), 200);
    eight.sort_by(f64::total_cmp);
    eight.dedup();
    assert_eq!(eight.len(), 8);

    let frozen =
        sizes(&graph("{} {seed = 3} BALL | {seed = 3} (cube & BALL)\nBALL -> uscale(rand(1, 2)) sphere"));
    assert!(frozen[0] != frozen[1], "the positions differ");
    let shared = sizes(&graph(
        "{} {seed = 3} BALL\nBALL -> uscale(rand(1, 2)) sphere | {seed = hash(seed)} x\nx = sphere",
    ));
    assert_eq!(shared[0], sizes(&graph("{} {seed = 3} BALL\nBALL -> uscale(rand(1, 2)) sphere"))[0]);
}

#[test]
fn the_seed_comes_from_the_file_or_from_outside() {
    let sizes_with = |source: &str, overrides: &[&str]| sizes(&scene(source, overrides).graph);
    let own = BALLS.replacen("{}", "{ seed = 9; }", 1);
    assert_eq!(sizes_with(BALLS, &[]), sizes_with(BALLS, &["seed = 0"]));
    assert_eq!(sizes_with(BALLS, &["seed = 9"]), sizes_with(&own, &[]));
    assert_eq!(sizes_with(BALLS, &["seed = 4"]), sizes_with(&own, &["seed = 4"]));
    assert_ne!(sizes_with(BALLS, &["seed = 9"]), sizes_with(BALLS, &[]));
    // Draws from outside continue those of the file.
    let two =
        "{ a = 1; b = 1; } uscale(a) sphere | uscale(b) sphere | BALL\nBALL -> uscale(rand(1, 2)) sphere";
    assert_distinct(&sizes_with(two, &["a = rand(1, 2)", "b = rand(1, 2)"]));
}

#[test]
fn a_grammar_without_chance_is_as_it_was() {
    let source = "{ n = 3; seed = 2; } A\nA if(n > 0, 2, 1)\n1: A -> sphere
        2: A -> {n = n - 1; seed = seed * 2} uscale(1 / seed) A";
    assert_eq!(calculations(&graph(source)), ["n = n - 1; seed = seed * 2"]);
    assert_eq!(sizes(&graph(source)), [0.25, 0.125, 0.0625]);
    let calculated = "{} {seed = 2} A\nA -> uscale(seed) sphere";
    assert_eq!(calculations(&graph(calculated)), ["seed = 2"]);
    assert_eq!(sizes(&graph(calculated)), [2.0]);
    // `hash` and `noise` alone read no seed.
    let pure = graph("{ n = 2; } A\nA -> uscale(1 + hash(n)) sphere | uscale(2 + noise(n, 0.5, n)) sphere");
    assert_eq!((calculations(&pure).len(), pure.params().count()), (0, 1));
    // Names of functions are free for solids.
    let named = "{} hash | noise\nhash = sphere\nnoise -> cube";
    assert_eq!(graph(named).params().count(), 0);
}

#[test]
fn states_without_chance_stay_few() {
    // 127 places for a tree, each with a seed of its own; the sure leaf has one state.
    let source = "{ n = 6; } TREE\nTREE if(n > 0, 2, 1)\n1: TREE -> LEAF
        2: TREE -> {n = n - 1} (rotx(rand(0, 9)) TREE | move(1, 0, 0) TREE)\nLEAF -> sphere";
    let states = graph(source).states(&Default::default()).unwrap();
    let graph = graph(source);
    let of =
        |name: &str| states.states().iter().filter(|state| graph.node_name(state.node()) == name).count();
    assert_eq!((of("TREE"), of("LEAF")), (127, 1));
}

#[test]
fn positions_survive_printing() {
    let source = BALLS.replace("rand(1, 2)", "pick(1,2 , 3)*hash(seed,1)");
    let printed = print(&parse(&source).tree);
    assert!(printed.contains("pick(1, 2, 3) * hash(seed, 1)"), "{printed}");
    assert_eq!(sizes(&graph(&printed)), sizes(&graph(&source)));
}

fn told(source: &str, overrides: &[&str]) -> Vec<String> {
    let overrides: Vec<_> = overrides.iter().map(|set| Override::parse(set).unwrap()).collect();
    let reports = load(source, &overrides).expect_err("a mistake");
    reports
        .iter()
        .map(|report| format!("{}; {}", report.message, report.help.clone().unwrap_or_default()))
        .collect()
}

#[test]
fn mistakes_are_told() {
    for (source, overrides, expected) in [
        (
            "{ n = rand(1); } uscale(n) sphere",
            &[][..],
            "`rand` takes 2 arguments, not 1; `rand(low, high)` is a random number, uniform, at least `low` and less than `high`",
        ),
        (
            "{ n = pick(); } uscale(n) sphere",
            &[],
            "`pick` takes at least 1 argument, not 0; `pick(weight, …)` is the number of one of the weights, from 1, at random \
             in proportion to them",
        ),
        ("{ n = random(1, 2); } uscale(n) sphere", &[], "unknown function `random`; did you mean `rand`?"),
        (
            "{ n = rand(1, 2); seed = 3; } uscale(n) sphere",
            &[],
            "`rand` draws from `seed`, which is set further down; initial values are evaluated in order; set `seed` first",
        ),
        (
            "{ n = 1; } uscale(n) sphere",
            &["seed = 3"],
            "the file has no parameter `seed`; nothing in it is random: no `rand`, `normal` or `pick`, and nothing reads `seed`",
        ),
        (
            "{ n = rand(1, 2); } uscale(n) sphere",
            &["sed = 3"],
            "the file has no parameter `sed`; did you mean `seed`?",
        ),
    ] {
        assert_eq!(told(source, overrides), [expected], "{source}");
    }
}
