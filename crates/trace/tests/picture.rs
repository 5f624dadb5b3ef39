//! Pictures: light and shadow, views, and the same bytes whatever happens around them.

use std::sync::Mutex;

use csg_graph::{AttributeTerm, Expr, Graph, GraphBuilder, Operator, PrimitiveKind, TransformKind};
use csg_graph_bounds::{HyperBoxes, Limits, chain, conventional, exact};
use csg_graph_trace::{
    Accelerated, Camera, Engine, Film, Grid, Integrator, Light, LightSource, MAX_PIXELS, Probe, RenderError,
    Settings, View, Walk, World, primary, probe, render,
};
use glam::DVec3;

const SETTINGS: Settings = Settings {
    width: 64,
    height: 48,
    samples: 1,
    noise: None,
    view: View::Shaded,
    integrator: Integrator::Direct,
    bounces: 16,
    exposure: 0.0,
};

/// A tower of `levels` bitten cubes, each turned and 0.7 times as large as the one below.
fn tower(levels: f64) -> Graph {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", levels);
    let symbol = builder.symbol("TOWER");
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let ball = builder.primitive(PrimitiveKind::Sphere, []);
    let bite = builder.transform(TransformKind::Move, [1.0, -1.0, 0.5].map(Expr::from), ball);
    let bitten = builder.operator(Operator::Difference, cube, bite);
    let colour = [Expr::from(n) / levels, 0.5.into(), 0.2.into()];
    let painted = builder.attribute(AttributeTerm::COLOR.into_iter().zip(colour), bitten);
    let smaller = builder.transform(TransformKind::UScale, [0.7.into()], symbol);
    let turned = builder.transform(TransformKind::RotZ, [33.0.into()], smaller);
    let raised = builder.transform(TransformKind::Move, [0.0, 0.0, 1.7].map(Expr::from), turned);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], raised);
    let both = builder.operator(Operator::Union, painted, rest);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [painted, both]);
    builder.finish(symbol).expect("a sound graph")
}

fn world<'a>(graph: &'a Graph, boxes: &'a HyperBoxes) -> World<'a> {
    let camera = Camera::framing(&boxes.root, Camera::DEFAULT_FOV, 4.0 / 3.0);
    let lights = vec![Light::over_shoulder(&camera)];
    World {
        engine: Engine::Reference(graph, Some(boxes)),
        camera,
        lights,
        background: World::DEFAULT_BACKGROUND,
    }
}

fn picture(world: &World<'_>, settings: &Settings) -> Film {
    render(world, settings, &|_| {}).expect("a picture").0
}

fn pixel(film: &Film, x: usize, y: usize) -> DVec3 {
    DVec3::from(film.pixels()[y * film.width() as usize + x].map(f64::from))
}

#[test]
fn threads_and_boxes_change_no_byte() {
    let graph = tower(6.0);
    let boxes =
        [conventional(&graph, &Limits::default()).unwrap(), chain(&graph, &Limits::default()).unwrap()];
    let settings = Settings { width: 70, height: 37, samples: 3, ..SETTINGS };
    let boxes_of_camera = boxes[1].clone();
    let run = |threads: usize, boxes: Option<&HyperBoxes>, view: View| {
        let world = World { engine: Engine::Reference(&graph, boxes), ..world(&graph, &boxes_of_camera) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (film, counters) =
            pool.install(|| render(&world, &Settings { view, ..settings }, &|_| {})).unwrap();
        (film.to_srgb8(), counters)
    };
    let expected = run(1, Some(&boxes[1]), View::Shaded);
    assert_eq!(run(3, Some(&boxes[1]), View::Shaded), expected);
    let conventional = run(2, Some(&boxes[0]), View::Shaded);
    let none = run(2, None, View::Shaded);
    assert!(conventional.0 == expected.0 && none.0 == expected.0);
    assert!(expected.1.primitive_tests <= conventional.1.primitive_tests);
    assert!(conventional.1.primitive_tests < none.1.primitive_tests);
    assert_eq!(none.1.box_tests, 0);
    for view in [View::Plate, View::Normal, View::Depth, View::Cost] {
        assert_eq!(run(1, Some(&boxes[1]), view), run(3, Some(&boxes[1]), view), "{view:?}");
    }
}

#[test]
fn primary_rays_are_those_of_a_picture_with_one_sample() {
    let graph = tower(5.0);
    let boxes = chain(&graph, &Limits::default()).unwrap();
    let accelerated = Accelerated::new(&graph, &exact(&graph, &Limits::default()).unwrap(), 1 << 14).unwrap();
    let (width, height) = (45, 34);
    for engine in [Engine::Reference(&graph, Some(&boxes)), Engine::Fast(&accelerated)] {
        let world = World { engine, ..world(&graph, &boxes) };
        let counted = primary(&world, width, height).unwrap();
        let probes = probe(&world, width, height).unwrap();
        assert_eq!((counted.counters.rays, counted.counters.shadow_rays), (45 * 34, 0));
        assert_eq!(counted.hits, probes.iter().filter(|probe| probe.node.is_some()).count() as u64);
        assert!(counted.hits > 100);
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(one.install(|| probe(&world, width, height)).unwrap(), probes);

        let lens = world.camera.lens(width, height).unwrap();
        let mut walk = Walk::new(&graph, Some(&boxes));
        for (index, probe) in (0_u32..).zip(&probes) {
            let (x, y) = (index % width, index / width);
            let ray = lens.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let hit = walk.nearest(&ray).unwrap();
            assert_eq!(hit.map(|hit| hit.node), probe.node, "{x} {y}");
            let Some(hit) = hit else {
                assert_eq!((probe.depth, probe.normal, probe.recursion), (f32::INFINITY, [0.0; 3], 0));
                continue;
            };
            assert_eq!(hit.depth, probe.recursion, "{x} {y}");
            assert!((hit.t - f64::from(probe.depth)).abs() < 1e-6 * hit.t, "{x} {y}");
            for (expected, found) in [(hit.normal, probe.normal), (hit.point, probe.position)] {
                assert!(expected.distance(DVec3::from(found.map(f64::from))) < 1e-5, "{x} {y}");
            }
            assert!(probe.box_tests > 0, "{x} {y}");
        }
        assert!(matches!(primary(&world, 0, 5), Err(RenderError::Size { .. })));
        assert!(matches!(probe(&world, 5, 0), Err(RenderError::Size { .. })));
    }
}

#[test]
fn engines_know_the_state_that_they_hit() {
    let graph = tower(9.0);
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let hyper_boxes = chain(&graph, &Limits::default()).unwrap();
    // Lists of many and of few parts, and entries far down and near the root.
    let accelerated = [1 << 16, 0].map(|budget| Accelerated::new(&graph, &boxes, budget).unwrap());
    let grids = [40, 1].map(|resolution| {
        let boxes = exact(&graph, &Limits::default()).unwrap();
        Grid::new(&graph, boxes, Some(resolution), Grid::DEFAULT_BUDGET).unwrap()
    });
    let probe_of = |engine| probe(&World { engine, ..world(&graph, &hyper_boxes) }, 60, 45).unwrap();
    let walked = probe_of(Engine::Reference(&graph, Some(&hyper_boxes)));
    let states: Vec<_> = boxes.states().map(|(state, _)| state).collect();
    let mut met = std::collections::BTreeSet::new();
    for probe in walked.iter().filter(|probe| probe.node.is_some()) {
        // The level of the tower is the recursion depth, and the parameter counts down.
        let state = states[probe.state.unwrap() as usize];
        assert_eq!(graph.live_values(state), [("n".to_owned(), f64::from(10 - probe.recursion))]);
        met.insert(probe.state);
    }
    assert!(met.len() > 4, "{met:?}");
    for engine in [Engine::Fast(&accelerated[0]), Engine::Fast(&accelerated[1])]
        .into_iter()
        .chain(grids.iter().map(Engine::Grid))
    {
        let pairs = probe_of(engine).into_iter().zip(&walked);
        let differing = pairs.filter(|(a, b)| (a.node, a.state) != (b.node, b.state)).count();
        assert!(differing <= 1, "{differing} probes differ");
    }
    // Not in any symbol, there is none.
    let mut builder = GraphBuilder::new();
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let cube = builder.finish(cube).unwrap();
    let boxes = chain(&cube, &Limits::default()).unwrap();
    let probes = csg_graph_trace::probe(&world(&cube, &boxes), 20, 20).unwrap();
    assert!(probes.iter().any(|probe| probe.node.is_some()));
    assert!(probes.iter().all(|probe| probe.state.is_none()));
}

#[test]
fn progress_counts_all_pixels() {
    let graph = tower(2.0);
    let boxes = chain(&graph, &Limits::default()).unwrap();
    let calls = Mutex::new(Vec::new());
    render(&world(&graph, &boxes), &SETTINGS, &|done| calls.lock().unwrap().push(done)).unwrap();
    let mut calls = calls.into_inner().unwrap();
    calls.sort_unstable();
    assert_eq!(calls.len(), 12, "one a tile");
    assert_eq!(calls.last(), Some(&(64 * 48)));
}

/// A ball above a floor, seen from above, under one light.
fn ball_and_floor(source: LightSource, shadow: bool) -> Film {
    let mut builder = GraphBuilder::new();
    let ball = builder.primitive(PrimitiveKind::Sphere, []);
    let ball = builder.transform(TransformKind::Move, [0.0, 0.0, 3.0].map(Expr::from), ball);
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let floor = builder.transform(TransformKind::Scale, [10.0, 10.0, 1.0].map(Expr::from), cube);
    let floor = builder.transform(TransformKind::Move, [0.0, 0.0, -1.0].map(Expr::from), floor);
    let both = builder.operator(Operator::Union, floor, ball);
    let graph = builder.finish(both).expect("a sound graph");
    let boxes = chain(&graph, &Limits::default()).expect("few enough steps");
    let camera = Camera { eye: DVec3::new(0.0, -6.0, 9.0), target: DVec3::ZERO, up: DVec3::Z, fov: 90.0 };
    let lights = vec![Light { source, colour: DVec3::ONE, shadow }];
    let world = World { lights, camera, ..world(&graph, &boxes) };
    picture(&world, &Settings { width: 65, height: 65, ..SETTINGS })
}

#[test]
fn the_plain_form_of_shading() {
    let light = DVec3::new(4.0, 0.0, 8.0);
    for (source, shadow) in [
        (LightSource::Point(light), true),
        (LightSource::Point(light), false),
        (LightSource::Directional(DVec3::new(-1.0, 0.0, -2.0)), true),
    ] {
        let film = ball_and_floor(source, shadow);
        let camera = Camera { eye: DVec3::new(0.0, -6.0, 9.0), target: DVec3::ZERO, up: DVec3::Z, fov: 90.0 };
        let lens = camera.lens(65, 65).unwrap();
        let (mut dark, mut lit) = (0, 0);
        for (x, y) in (0..65).flat_map(|y| (0..65).map(move |x| (x, y))) {
            // The floor, where the ball does not hide it.
            let ray = lens.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let point = ray.at(-ray.origin.z / ray.direction.z);
            let off_ball = |origin: DVec3, direction: DVec3| {
                let to_ball = DVec3::new(0.0, 0.0, 3.0) - origin;
                let direction = direction.normalize();
                (to_ball - direction * to_ball.dot(direction)).length()
            };
            if ray.direction.z >= 0.0
                || point.abs().max_element() > 9.5
                || off_ball(ray.origin, ray.direction) < 1.0
            {
                continue;
            }
            let to_light = match source {
                LightSource::Point(position) => position - point,
                LightSource::Directional(direction) => -direction,
            };
            let distance_to_ball = off_ball(point, to_light);
            if (distance_to_ball - 1.0).abs() < 1e-6 {
                continue;
            }
            let visible = !shadow || distance_to_ball > 1.0;
            *(if visible { &mut lit } else { &mut dark }) += 1;
            let expected = 0.2 + if visible { 0.8 * to_light.normalize().z } else { 0.0 };
            let found = film.pixels()[(y * 65 + x) as usize];
            assert!((f64::from(found[0]) - expected).abs() < 1e-6, "{found:?} for {expected} at {point}");
        }
        assert!(lit > 500 && (dark > 20) == shadow, "{lit} lit, {dark} dark");
    }
}

#[test]
fn a_light_under_the_floor_lights_nothing() {
    let film = ball_and_floor(LightSource::Point(DVec3::new(0.0, 0.0, -50.0)), false);
    assert!((pixel(&film, 32, 64).x - 0.2).abs() < 1e-6);
}

#[test]
fn highlights_are_where_the_mirror_image_is() {
    let graph = |specular: f64| {
        let mut builder = GraphBuilder::new();
        let ball = builder.primitive(PrimitiveKind::Sphere, []);
        let terms = [(AttributeTerm::Specular, specular.into()), (AttributeTerm::Diffuse, 0.0.into())];
        let shiny = builder.attribute(terms, ball);
        builder.finish(shiny).unwrap()
    };
    let camera = Camera { eye: DVec3::new(0.0, -5.0, 0.0), target: DVec3::ZERO, up: DVec3::Z, fov: 40.0 };
    let light =
        Light { source: LightSource::Point(camera.eye), colour: DVec3::new(1.0, 0.5, 0.0), shadow: true };
    let [dull, shiny] = [0.0, 0.6].map(|specular| {
        let graph = graph(specular);
        let boxes = chain(&graph, &Limits::default()).unwrap();
        let world = World { camera, lights: vec![light], ..world(&graph, &boxes) };
        picture(&world, &Settings { width: 65, height: 65, ..SETTINGS })
    });
    let added = pixel(&shiny, 32, 32) - pixel(&dull, 32, 32);
    assert!(added.distance(DVec3::new(0.6, 0.3, 0.0)) < 1e-6, "{added}");
    let beside = pixel(&shiny, 48, 32) - pixel(&dull, 48, 32);
    assert!((0.0..0.1).contains(&beside.x), "{beside}");
}

#[test]
fn samples_soften_edges_and_leave_the_rest() {
    let film = |samples| {
        let graph = tower(1.0);
        let boxes = chain(&graph, &Limits::default()).unwrap();
        picture(&world(&graph, &boxes), &Settings { samples, view: View::Normal, ..SETTINGS })
    };
    let [sharp, soft] = [film(1), film(9)];
    let pairs = sharp.pixels().iter().zip(soft.pixels());
    let changed = pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-3)).count();
    assert!(changed > 30 && changed < sharp.pixels().len() / 3, "{changed} pixels changed");
}

#[test]
fn the_plate_shows_levels_in_alternating_colours() {
    let graph = tower(8.0);
    let boxes = chain(&graph, &Limits::default()).unwrap();
    let film = picture(&world(&graph, &boxes), &Settings { view: View::Plate, ..SETTINGS });
    let shaded = picture(&world(&graph, &boxes), &SETTINGS);
    assert_eq!(pixel(&film, 0, 0), DVec3::ZERO, "a ray that misses the whole");
    let sky: Vec<f64> = World::DEFAULT_BACKGROUND.zenith.to_array().to_vec();
    let (mut reds, mut blues, mut brightest) = (0, 0, 0.0_f64);
    for (plate, shaded) in film.pixels().iter().zip(shaded.pixels()) {
        if shaded.iter().zip(&sky).any(|(a, b)| (f64::from(*a) - b).abs() > 1e-6) {
            assert_eq!(plate.map(f32::to_bits), shaded.map(f32::to_bits), "hits are shaded");
            continue;
        }
        reds += usize::from(plate[0] > plate[2]);
        blues += usize::from(plate[2] > plate[0]);
        brightest = brightest.max(f64::from(plate[0].max(plate[2])));
    }
    assert!(reds > 20 && blues > 20, "{reds} red, {blues} blue");
    assert!((brightest - 1.0).abs() < 1e-6);
}

#[test]
fn depth_and_normals_are_linear_in_bytes() {
    let mut builder = GraphBuilder::new();
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let graph = builder.finish(cube).unwrap();
    let boxes = chain(&graph, &Limits::default()).unwrap();
    let camera = Camera { eye: DVec3::new(0.0, -5.0, 0.0), target: DVec3::ZERO, up: DVec3::Z, fov: 40.0 };
    let world = World { camera, ..world(&graph, &boxes) };
    let size = Settings { width: 33, height: 33, ..SETTINGS };
    let bytes = |view| picture(&world, &Settings { view, ..size }).to_srgb8();
    let middle = 3 * (16 * 33 + 16);
    assert_eq!(bytes(View::Normal)[middle..middle + 3], [128, 0, 128]);
    assert_eq!(bytes(View::Normal)[..3], [0, 0, 0]);
    // One face, all at one depth: all nearest.
    assert_eq!(bytes(View::Depth)[middle..middle + 3], [255, 255, 255]);
    assert_eq!(bytes(View::Depth)[..3], [0, 0, 0]);
    let cost = bytes(View::Cost);
    assert!(cost[middle] > cost[0], "a hit costs more than a miss");
}

#[test]
fn what_a_picture_of_costs_counts_is_what_its_rays_cost_alone() {
    let graph = tower(5.0);
    let boxes = chain(&graph, &Limits::default()).unwrap();
    let accelerated = Accelerated::new(&graph, &exact(&graph, &Limits::default()).unwrap(), 0).unwrap();
    let camera = world(&graph, &boxes).camera;
    let close = Camera { eye: camera.eye.lerp(camera.target, 0.8), ..camera };
    for engine in [Engine::Reference(&graph, Some(&boxes)), Engine::Fast(&accelerated)] {
        let world = World { engine, camera: close, lights: Vec::new(), ..world(&graph, &boxes) };
        let settings = Settings { view: View::Cost, ..SETTINGS };
        let (_, counted) = render(&world, &settings, &|_| {}).unwrap();
        let probes = probe(&world, settings.width, settings.height).unwrap();
        let tests = |probe: &Probe| u64::from(probe.box_tests) + u64::from(probe.primitive_tests);
        assert_eq!(counted.tests(), probes.iter().map(tests).sum::<u64>());
    }
}

#[test]
fn what_cannot_be_rendered_is_refused() {
    let graph = tower(1.0);
    let boxes = chain(&graph, &Limits::default()).unwrap();
    let world = world(&graph, &boxes);
    let refused = |world: &World<'_>, settings: Settings| render(world, &settings, &|_| {}).unwrap_err();
    for [width, height] in [[0, 5], [5, 0], [u32::MAX, u32::MAX], [8193, 8192]] {
        let error = refused(&world, Settings { width, height, ..SETTINGS });
        assert_eq!(error, RenderError::Size { width, height });
        assert!(error.to_string().contains(&MAX_PIXELS.to_string()));
    }
    assert_eq!(refused(&world, Settings { samples: 0, ..SETTINGS }), RenderError::Samples { samples: 0 });
    assert_eq!(refused(&world, Settings { bounces: 0, ..SETTINGS }), RenderError::Bounces { bounces: 0 });
    for exposure in [f64::NAN, 32.5, f64::NEG_INFINITY] {
        let error = refused(&world, Settings { exposure, ..SETTINGS });
        assert!(matches!(error, RenderError::Exposure { .. }), "{error:?}");
    }
    let blind = World { camera: Camera { target: world.camera.eye, ..world.camera }, ..world };
    assert!(matches!(refused(&blind, SETTINGS), RenderError::Camera(_)));
}
