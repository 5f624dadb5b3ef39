//! Pictures in the making: cut into any parts, kept and gone on with, they are the same; and noise ends where it is said to.

use std::sync::atomic::{AtomicU32, Ordering};

use csg_graph::{AttributeTerm, Expr, Graph, GraphBuilder, Operator, PrimitiveKind, TransformKind};
use csg_graph_bounds::{Limits, exact};
use csg_graph_trace::{
    Accelerated, Camera, Counters, Engine, FEWEST_SAMPLES, Film, Integrator, LatentImage, Light, LoadError,
    RenderError, Settings, View, World, render,
};

const SETTINGS: Settings = Settings {
    width: 45,
    height: 34,
    samples: 20,
    noise: None,
    view: View::Shaded,
    integrator: Integrator::Direct,
    bounces: 16,
    exposure: 0.0,
};

/// A shining tower of cones with bites, on the ground; each part is smaller than the one below.
fn tower() -> Graph {
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", 8.0);
    let symbol = builder.symbol("TOWER");
    let cone = builder.primitive(PrimitiveKind::Cone, []);
    let ball = builder.primitive(PrimitiveKind::Sphere, []);
    let bite = builder.transform(TransformKind::Move, [1.0, -0.8, 0.5].map(Expr::from), ball);
    let bitten = builder.operator(Operator::Difference, cone, bite);
    let look = [(AttributeTerm::Specular, 0.7.into()), (AttributeTerm::Shininess, 9.0.into())];
    let shining = builder.attribute(look, bitten);
    let smaller = builder.transform(TransformKind::UScale, [0.75.into()], symbol);
    let turned = builder.transform(TransformKind::Rot, [1.0, 0.5, 2.0, 33.0].map(Expr::from), smaller);
    let raised = builder.transform(TransformKind::Move, [0.0, 0.0, 0.6].map(Expr::from), turned);
    let rest = builder.calculate([(n, Expr::from(n) - 1.0)], raised);
    let both = builder.operator(Operator::Union, shining, rest);
    builder.rules(symbol, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [shining, both]);
    let cube = builder.primitive(PrimitiveKind::Cube, []);
    let flat = builder.transform(TransformKind::Scale, [2.0, 2.0, 0.1].map(Expr::from), cube);
    let ground = builder.transform(TransformKind::Move, [0.0, 0.0, -0.1].map(Expr::from), flat);
    let all = builder.operator(Operator::Union, ground, symbol);
    builder.finish(all).expect("a sound graph")
}

/// Does something with the world of the tower.
fn with_world<T>(is_fast: bool, work: impl FnOnce(&World<'_>) -> T) -> T {
    let graph = tower();
    let boxes = exact(&graph, &Limits::default()).expect("few states");
    let camera = Camera::framing(&boxes.root, Camera::DEFAULT_FOV, 4.0 / 3.0);
    let accelerated = Accelerated::new(&graph, &boxes, 1 << 14).expect("a sound graph");
    let boxes = boxes.into_hyper_boxes();
    let engine = if is_fast { Engine::Fast(&accelerated) } else { Engine::Reference(&graph, Some(&boxes)) };
    let lights = vec![Light::over_shoulder(&camera)];
    work(&World { engine, camera, lights, background: World::DEFAULT_BACKGROUND })
}

fn on_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads").install(work)
}

/// A picture made in parts, each of which ends when it was asked so many times whether it should. Between them it is a
/// file.
fn in_parts(world: &World<'_>, settings: &Settings, patience: u32) -> (LatentImage, u32) {
    let mut image = LatentImage::new(settings).expect("sound settings");
    let mut parts = 0;
    loop {
        let asked = AtomicU32::new(0);
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= patience;
        let is_complete = image.expose(world, &stop, &|_| {}).expect("a sound graph");
        parts += 1;
        if is_complete {
            return (image, parts);
        }
        let mut file = Vec::new();
        image.save(&mut file).expect("memory takes all");
        let loaded = LatentImage::load(settings, &mut file.as_slice()).expect("what was saved");
        assert_eq!(loaded, image);
        image = loaded;
    }
}

fn at_once(world: &World<'_>, settings: &Settings) -> (Film, Counters) {
    render(world, settings, &|_| {}).expect("a picture")
}

#[test]
fn parts_make_the_same_picture_on_any_number_of_threads() {
    for (view, is_fast) in [
        (View::Shaded, true),
        (View::Normal, true),
        (View::Depth, true),
        (View::Shaded, false),
        (View::Plate, false),
        (View::Cost, false),
    ] {
        with_world(is_fast, |world| {
            let settings = Settings { view, ..SETTINGS };
            let expected = on_threads(2, || at_once(world, &settings));
            for (threads, patience) in [(1, 100), (2, 333), (3, 57)] {
                let (image, parts) = on_threads(threads, || in_parts(world, &settings, patience));
                assert!(parts > 1, "{parts} parts");
                assert_eq!((image.develop(), *image.counters()), expected, "{view:?}");
                assert_eq!(image.to_srgb8(), expected.0.to_srgb8(), "{view:?}");
                assert!(image.samples().iter().all(|samples| *samples == 20));
            }
        });
    }
}

#[test]
fn what_there_is_so_far_is_a_picture() {
    with_world(true, |world| {
        let mut image = LatentImage::new(&SETTINGS).unwrap();
        assert!(image.develop().pixels().iter().all(|pixel| pixel.map(f32::to_bits) == [0; 3]), "black");
        // One pass, in which all squares have their first sample, and some of the next.
        let asked = AtomicU32::new(0);
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= 120;
        assert!(!on_threads(1, || image.expose(world, &stop, &|_| {})).unwrap());
        let samples = image.samples();
        assert!(samples.contains(&1) && samples.contains(&2), "{samples:?}");
        assert_eq!(image.samples_taken(), samples.iter().copied().map(u64::from).sum());
        assert_eq!(image.to_srgb8(), image.develop().to_srgb8());
        let (film, _) = at_once(world, &SETTINGS);
        let difference = |(a, b): (&[f32; 3], &[f32; 3])| f64::from((a[1] - b[1]).abs());
        let sum: f64 = image.develop().pixels().iter().zip(film.pixels()).map(difference).sum();
        assert!(sum / f64::from(45 * 34) < 0.03, "{sum}");
    });
}

#[test]
fn the_cost_view_does_not_depend_on_the_number_of_samples() {
    with_world(false, |world| {
        let films =
            [1, 9].map(|samples| at_once(world, &Settings { samples, view: View::Cost, ..SETTINGS }).0);
        let brightest = |film: &Film| film.pixels().iter().map(|pixel| pixel[0]).fold(0.0, f32::max);
        let [one, nine] = films.each_ref().map(brightest);
        assert!(one > 0.9 && nine > 0.9, "{one} {nine}");
    });
}

#[test]
fn what_cannot_have_been_saved_is_refused() {
    let mut file = Vec::new();
    LatentImage::new(&SETTINGS).unwrap().save(&mut file).unwrap();
    for length in [0, 7, 68, file.len() - 1] {
        let error = LatentImage::load(&SETTINGS, &mut &file[..length]).unwrap_err();
        assert!(matches!(error, LoadError::Read(_)), "{error}");
    }
    // The goal of the first square, behind the counters and the square's samples.
    file[64] = 21;
    let error = LatentImage::load(&SETTINGS, &mut file.as_slice()).unwrap_err();
    assert!(matches!(error, LoadError::Count { taken: 0, goal: 21, samples: 20 }), "{error}");
    let settings = Settings { samples: 0, ..SETTINGS };
    let error = LatentImage::load(&settings, &mut file.as_slice()).unwrap_err();
    assert!(matches!(error, LoadError::Settings(RenderError::Samples { .. })), "{error}");
}

#[test]
fn noise_is_judged_the_same_on_any_number_of_threads_and_in_parts() {
    with_world(true, |world| {
        let settings = Settings { samples: 90, noise: Some(3.0), ..SETTINGS };
        let (expected, parts) = on_threads(2, || in_parts(world, &settings, u32::MAX));
        assert_eq!(parts, 1);
        let samples = expected.samples();
        let (least, most) = (samples.iter().min(), samples.iter().max());
        assert_eq!((least, most), (Some(&FEWEST_SAMPLES), Some(&90)));
        for (threads, patience) in [(1, 150), (2, 97), (3, 501)] {
            let (image, parts) = on_threads(threads, || in_parts(world, &settings, patience));
            assert!(parts > 1, "{parts} parts");
            assert_eq!(image, expected);
        }
    });
}

#[test]
fn noise_ends_where_it_is_said_to() {
    with_world(true, |world| {
        let settings = Settings { width: 64, height: 48, samples: 1000, ..SETTINGS };
        let (reference, _) = at_once(world, &settings);
        let mut taken_before = 0;
        for noise in [8.0, 4.0, 2.0] {
            let (image, _) =
                in_parts(world, &Settings { samples: 700, noise: Some(noise), ..settings }, u32::MAX);
            let taken: u32 = image.samples().iter().sum();
            assert!(taken > taken_before && taken < 64 * 48 * 350, "{taken} for {noise}");
            taken_before = taken;
            let film = image.develop();
            let bytes = film.to_srgb8().into_iter().zip(reference.to_srgb8());
            let off = bytes.filter(|(a, b)| f64::from(a.abs_diff(*b)) > noise).count();
            // The reference has an error, too, and bytes are rounded.
            assert!(off <= 3, "{off} channels are off by more than {noise}");
        }
    });
}

#[test]
fn noise_that_cannot_be_judged_is_refused() {
    for noise in [0.0, -1.0, f64::NAN] {
        let error = LatentImage::new(&Settings { noise: Some(noise), ..SETTINGS }).unwrap_err();
        assert!(matches!(error, RenderError::Noise { .. }), "{error}");
    }
    for view in [View::Depth, View::Plate, View::Cost] {
        let error = LatentImage::new(&Settings { noise: Some(2.0), view, ..SETTINGS }).unwrap_err();
        assert_eq!(error, RenderError::NoiseOf { view });
    }
}
