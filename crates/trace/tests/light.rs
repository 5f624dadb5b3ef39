//! Light: what integrators find, against what can be worked out.

use csg_graph::Graph;
use csg_graph_bounds::{Limits, exact};
use csg_graph_trace::{
    Accelerated, Camera, Engine, Film, Integrator, Light, LightSource, Settings, Sky, Sun, View, World,
    render,
};
use glam::DVec3;

const DIRECT: Settings = Settings {
    width: 33,
    height: 33,
    samples: 1,
    noise: None,
    view: View::Shaded,
    integrator: Integrator::Direct,
    bounces: 64,
    exposure: 0.0,
};

const PATH: Settings = Settings { integrator: Integrator::Path, samples: 16, ..DIRECT };

fn graph(source: &str) -> Graph {
    let lowered = csg_graph_grammar::load(source, &[]).unwrap_or_else(|mistakes| panic!("{}", mistakes[0]));
    lowered.scene.graph
}

/// Whatever is outside of the solid, seen by a camera in (0, −9, 0) that looks at the origin.
struct Outside {
    background: Sky,
    lights: Vec<Light>,
    eye: DVec3,
}

impl Outside {
    fn of(background: Sky) -> Self {
        Self { background, lights: Vec::new(), eye: DVec3::new(0.0, -9.0, 0.0) }
    }

    fn lit(self, source: LightSource, shadow: bool) -> Self {
        Self { lights: vec![Light { source, colour: DVec3::new(1.0, 0.8, 0.5), shadow }], ..self }
    }

    fn world<'a>(&self, engine: Engine<'a>, fov: f64) -> World<'a> {
        let camera = Camera { eye: self.eye, target: DVec3::ZERO, up: DVec3::Z, fov };
        World { engine, camera, lights: self.lights.clone(), background: self.background }
    }

    fn picture(&self, source: &str, fov: f64, settings: &Settings) -> Film {
        let graph = graph(source);
        let boxes = exact(&graph, &Limits::default()).expect("few states");
        let compiled = Accelerated::new(&graph, &boxes, 1 << 16).expect("a sound graph");
        render(&self.world(Engine::Fast(&compiled), fov), settings, &|_| {}).expect("a picture").0
    }
}

fn black() -> Outside {
    Outside::of(Sky::uniform(DVec3::ZERO))
}

fn pixels(film: &Film) -> Vec<DVec3> {
    film.pixels().iter().map(|pixel| DVec3::from(pixel.map(f64::from))).collect()
}

fn middle(film: &Film) -> DVec3 {
    pixels(film)[film.pixels().len() / 2]
}

fn mean(film: &Film) -> DVec3 {
    pixels(film).iter().sum::<DVec3>() / film.pixels().len() as f64
}

#[test]
fn in_a_white_furnace_nothing_white_is_seen() {
    let furnace = Outside::of(Sky::uniform(DVec3::ONE));
    for material in [
        "diffuse = 1",
        "metal = 1",
        "glass = 1",
        "glass = 1, ior = 2.4",
        "metal = 0.5, glass = 0.5, diffuse = 1",
    ] {
        for solid in [
            "sphere",
            "rotx(-60) (sphere \\ move(0, 0, 0.5) sphere)",
            "rotx(30) torus(0.4) | uscale(0.5) cube",
        ] {
            let source = format!("{{}} material({material}) ({solid})");
            for (index, pixel) in pixels(&furnace.picture(&source, 20.0, &Settings { bounces: 1024, ..PATH }))
                .into_iter()
                .enumerate()
            {
                assert!((pixel - 1.0).abs().max_element() < 1e-4, "{source}: {pixel} in pixel {index}");
            }
        }
    }
}

/// In a closed room of one emission and one albedo, the light is the same everywhere: e / (1 − ρ).
#[test]
fn a_closed_room_has_the_light_of_the_series() {
    let room =
        "{} color(0.5, 0.8, 0.2) material(emission = 1, diffuse = 1) (uscale(20) cube \\ uscale(12) sphere)";
    let settings = Settings { samples: 64, ..PATH };
    let found = mean(&black().picture(room, 90.0, &settings));
    let expected = DVec3::new(1.0, 4.0, 0.25);
    assert!(((found - expected) / expected).abs().max_element() < 0.01, "{found}");
    // With two bounces, three terms of the series, by no chance.
    for pixel in pixels(&black().picture(room, 90.0, &Settings { bounces: 2, ..PATH })) {
        assert!((pixel - DVec3::new(0.875, 1.952, 0.248)).abs().max_element() < 1e-5, "{pixel}");
    }
}

#[test]
fn one_bounce_of_a_path_is_direct_light() {
    let source = "{ n = 6; } material(ambient = 0) (T | move(0, 0, -1) scale(9, 9, 0.2) cube)
        T if(n > 0, 1, 2)
        1: T -> color(n / 6, 0.5, 0.2) (cube \\ move(1, -1, 0.5) sphere) | {n = n - 1} move(0, 0, 1.7) rotz(33) uscale(0.7) T
        2: T -> sphere";
    for (source_of_light, shadow) in [
        (LightSource::Point(DVec3::new(4.0, -5.0, 6.0)), true),
        (LightSource::Point(DVec3::new(4.0, -5.0, 6.0)), false),
        (LightSource::Directional(DVec3::new(1.0, 2.0, -2.0)), true),
    ] {
        let outside = black().lit(source_of_light, shadow);
        let one_bounce = Settings { bounces: 1, samples: 4, ..PATH };
        let direct =
            outside.picture(source, 30.0, &Settings { integrator: Integrator::Direct, ..one_bounce });
        let path = outside.picture(source, 30.0, &one_bounce);
        assert!(mean(&direct).x > 0.1);
        for (direct, path) in pixels(&direct).into_iter().zip(pixels(&path)) {
            assert!((direct - path).abs().max_element() < 1e-6, "{direct} {path}");
        }
    }
}

/// A wall that looks up under the dome: ∫ L cos / π = 0.2 horizon + 0.8 zenith.
#[test]
fn the_dome_lights_the_ground() {
    let mut sky = Sky::CLEAR;
    (sky.zenith, sky.horizon) = (DVec3::new(0.1, 0.5, 2.0), DVec3::new(1.0, 0.5, 0.0));
    let outside = Outside { eye: DVec3::new(0.0, 0.0, 9.0), ..Outside::of(sky) };
    let found =
        mean(&outside.picture("{} material(diffuse = 1) cube", 5.0, &Settings { samples: 64, ..PATH }));
    assert!(found.distance(DVec3::new(0.28, 0.5, 1.6)) < 2e-3, "{found}");
}

/// A sun that is aimed at, and a ball of the same size and brightness far away, which only chance finds.
#[test]
fn aiming_at_the_sun_finds_the_light_that_chance_finds() {
    let things = "(move(0, 0, -2) scale(8, 8, 1) cube | color(0.9, 0.6, 0.3) material(metal = 0.8, roughness = 0.45) sphere
        | move(1.4, -1, -0.5) uscale(0.5) cube)";
    let (direction, diameter) = (DVec3::new(0.3, -0.4, 0.866).normalize(), 25.0);
    let mut sky = Sky::uniform(DVec3::ZERO);
    let sun = Sun { direction, colour: DVec3::new(1.0, 0.9, 0.7), diameter };
    sky.sun = Some(sun);
    let settings = Settings { samples: 256, bounces: 4, ..PATH };
    let aimed = Outside::of(sky).picture(&format!("{{}} {things}"), 30.0, &settings);

    let (far, radius) = (1e5, 1e5 * libm::sin(f64::to_radians(diameter / 2.0)));
    let (at, radiance) = (direction * far, sun.radiance());
    let brightest = radiance.max_element();
    let pigment = radiance / brightest;
    let ball = format!(
        "move({}, {}, {}) color({}, {}, {}) material(emission = {brightest}, diffuse = 0) uscale({radius}) sphere",
        at.x, at.y, at.z, pigment.x, pigment.y, pigment.z
    );
    let found = black().picture(&format!("{{}} {things} | {ball}"), 30.0, &settings);

    let differences: Vec<DVec3> = pixels(&aimed).iter().zip(pixels(&found)).map(|(a, b)| *a - b).collect();
    let count = differences.len() as f64;
    let bias = differences.iter().sum::<DVec3>() / count;
    let variance = differences.iter().map(|d| (*d - bias) * (*d - bias)).sum::<DVec3>() / count;
    let error = (variance / count).map(f64::sqrt);
    assert!(mean(&aimed).min_element() > 0.1 && error.max_element() < 0.01, "{} ± {error}", mean(&aimed));
    assert!((bias / error).abs().max_element() < 4.0, "{bias} ± {error}");
}

#[test]
fn any_number_of_threads_draws_the_same_paths() {
    let source = "{ n = 4; } material(metal = 0.3, roughness = 0.3, glass = 0.4) T | move(0, 0, -2) cube
        T if(n > 0, 1, 2)
        1: T -> sphere | {n = n - 1} move(1.2, 0, 0.4) rotz(50) uscale(0.8) T
        2: T -> move(0, 0, 1) material(emission = 3) sphere";
    let graph = graph(source);
    let boxes = exact(&graph, &Limits::default()).unwrap();
    let compiled = Accelerated::new(&graph, &boxes, 1 << 16).unwrap();
    let hyper_boxes = boxes.into_hyper_boxes();
    let mut sky = Sky::CLEAR;
    sky.sun = Some(Sun { direction: DVec3::Z, colour: DVec3::ONE, diameter: 3.0 });
    let outside = Outside::of(sky).lit(LightSource::Point(DVec3::new(5.0, -5.0, 5.0)), true);
    let run = |threads: usize, engine| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            render(&outside.world(engine, 40.0), &Settings { samples: 3, ..PATH }, &|_| {}).unwrap()
        })
    };
    for engine in [Engine::Fast(&compiled), Engine::Reference(&graph, Some(&hyper_boxes))] {
        let one = run(1, engine);
        assert!(one.1.rays > 3 * 33 * 33 + 1000, "paths go on");
        for threads in [2, 3] {
            assert_eq!(run(threads, engine), one, "{threads} threads");
        }
    }
    // Paths that begin alike part where engines round differently, but not in the mean.
    let [fast, walked] = [Engine::Fast(&compiled), Engine::Reference(&graph, Some(&hyper_boxes))]
        .map(|engine| mean(&run(2, engine).0));
    assert!(fast.distance(walked) < 0.01 * walked.length(), "{fast} {walked}");
    let boxless = run(2, Engine::Reference(&graph, None)).0;
    assert_eq!(boxless, run(1, Engine::Reference(&graph, Some(&hyper_boxes))).0);
}

/// Rays that come in parallel to the axis of a ball cross it at n / (2 (n − 1)) radii behind the middle.
#[test]
fn a_ball_of_glass_focuses() {
    let lamp_at = |y: f64| {
        let source = format!(
            "{{}} material(glass = 1) sphere | move(0, {y}, 0) color(0, 1, 0) material(emission = 1, diffuse = 0, ambient = 0) uscale(0.05) sphere"
        );
        // From so far away that rays are as good as parallel; the picture is as wide as half the ball.
        let outside = Outside { eye: DVec3::new(0.0, -1e4, 0.0), ..black() };
        pixels(&outside.picture(&source, f64::to_degrees(0.6 / 1e4), &DIRECT))
    };
    let through = 0.96 * 0.96;
    let focused = lamp_at(1.5);
    assert!(focused.iter().all(|pixel| (pixel.y - through).abs() < 0.02), "{focused:?}");
    let behind = lamp_at(2.2);
    let lit = behind.iter().filter(|pixel| pixel.y > 0.5).count();
    assert!(lit > 10 && lit < 33 * 33 / 3, "{lit} pixels see the lamp");
    assert!((behind[33 * 33 / 2].y - through).abs() < 0.02, "straight ahead, nothing bends");
}

#[test]
fn glass_reflects_and_swallows_as_computed() {
    let bright = Outside::of(Sky::uniform(DVec3::ONE));
    // R + (1 − R)² a / (1 − R a), where a = pigment ^ (absorption · thickness) is left after one passage.
    let source = "{} color(0.5, 1, 0) material(glass = 1, absorption = 0.5) cube";
    let seen = |a: f64| 0.04 + 0.96 * 0.96 * a / (1.0 - 0.04 * a);
    let expected = DVec3::new(seen(0.5), seen(1.0), seen(0.0));
    let direct = middle(&bright.picture(source, 1.0, &DIRECT));
    assert!((direct - expected).abs().max_element() < 2e-3, "{direct} for {expected}");
    let path = mean(&bright.picture(source, 0.5, &Settings { samples: 64, ..PATH }));
    assert!((path - expected).abs().max_element() < 5e-3, "{path} for {expected}");
}

#[test]
fn walls_inside_of_glass_are_not_seen() {
    let sky = Outside::of(Sky::CLEAR);
    let picture = |solid: &str| {
        sky.picture(&format!("{{}} color(0.6, 0.9, 0.8) material(glass = 1) ({solid})"), 20.0, &DIRECT)
    };
    let whole = picture("sphere");
    for parts in ["sphere | uscale(0.5) cube", "uscale(0.5) (sphere | move(0.5, 0, 0) sphere) | sphere"] {
        for (whole, parts) in pixels(&whole).into_iter().zip(pixels(&picture(parts))) {
            assert!((whole - parts).abs().max_element() < 2e-3, "{whole} {parts}");
        }
    }
    // Another glass inside is seen.
    assert_ne!(pixels(&picture("sphere | material(ior = 1.8) uscale(0.5) cube")), pixels(&whole));
}

#[test]
fn glass_may_stand_on_the_floor() {
    // Exactly, or sunk into it by a millionth: whether it is that or rounding is not to be seen.
    let scene = |sunk: &str| {
        format!(
            "{{}} color(0.5, 0.5, 0.5) move(0, 0, -1.1) scale(12, 12, 0.1) cube
             | move(0, 0, -{sunk}) material(glass = 1) color(0.3, 0.4, 1) (cube & uscale(1.3) sphere)"
        )
    };
    let sun = LightSource::Directional(DVec3::new(0.3, 1.0, -1.0));
    let outside =
        Outside { eye: DVec3::new(3.0, -12.0, 5.0), ..Outside::of(Sky::uniform(DVec3::ONE)).lit(sun, true) };
    for settings in [DIRECT, PATH] {
        let [stands, is_sunk] =
            ["0", "0.000001"].map(|sunk| pixels(&outside.picture(&scene(sunk), 15.0, &settings)));
        let differ = stands.iter().zip(&is_sunk).filter(|(a, b)| a.distance(**b) > 0.02).count();
        assert!(differ < 10, "{differ} of {}", stands.len());
    }
}

#[test]
fn metal_shows_the_sky_in_its_pigment() {
    let mut sky = Sky::uniform(DVec3::new(0.3, 0.5, 0.7));
    sky.sun = Some(Sun { direction: -DVec3::Y, colour: DVec3::ONE, diameter: 60.0 });
    let tinted = "{} color(0.9, 0.5, 0.1) material(metal = 1) cube";
    let expected = DVec3::new(0.9, 0.5, 0.1) * (sky.radiance(-DVec3::Y) + sky.sun.unwrap().radiance());
    for settings in [DIRECT, PATH] {
        let found = middle(&Outside::of(sky).picture(tinted, 1.0, &settings));
        assert!((found - expected).abs().max_element() < 1e-3, "{found} for {expected}");
    }
}
