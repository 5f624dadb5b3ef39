//! `pcsg bench`: how fast a scene is traced.

mod sweep;

use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use csg_graph_trace::{PrimaryPass, Probe, Settings, primary, probe, render};
use rayon::ThreadPool;
use serde::Serialize;

use crate::args::{BenchArgs, Format, Plan, Size, ViewArg};
use crate::engine::Prepared;
use crate::load::{Loaded, load};
use crate::stage::Stage;
use crate::text::{grouped, json, seconds, short};
use crate::{Failure, print};

/// What `bench --format json` prints. Times are medians over the repetitions.
#[derive(Serialize)]
struct Report {
    scene: String,
    set: Vec<String>,
    zoom: Option<f64>,
    engine: String,
    width: u32,
    height: u32,
    threads: usize,
    reps: u32,
    primitives: String,
    /// Until the first ray can be traced, from the graph on: bounding and compiling.
    setup_s: f64,
    /// Of what was set up.
    bytes: usize,
    /// Primary rays alone, summed over the threads.
    primary_cpu_s: f64,
    primary_s: f64,
    /// Millions of primary rays in a second of `primary_cpu_s`.
    primary_mray_s: f64,
    /// The whole picture, summed over the threads.
    image_cpu_s: f64,
    image_s: f64,
    /// Of primary rays, as the following two.
    box_tests_per_ray: f64,
    primitive_tests_per_ray: f64,
    hit_fraction: f64,
    /// Of the hundredth of the primary rays with the most tests, each traced alone.
    slowest_box_tests_per_ray: f64,
    slowest_primitive_tests_per_ray: f64,
}

pub(crate) fn run(args: &BenchArgs) -> Result<(), Failure> {
    let plan = args.engine.plan(ViewArg::Shaded)?;
    let loaded = load(&args.scene)?;
    if let (Some(path), Some(sweep)) = (&args.plot, &args.sweep) {
        return sweep::run(args, &loaded, path, sweep);
    }
    let (width, height) = (args.size.width, args.size.height);
    let settings = Settings { width, height, samples: 1, ..Settings::default() };
    let mut stage = Stage::set(&loaded, plan, &settings, false, args.engine.memory)?;
    let pool = stage.threads(args.threads)?;
    if let Some(factor) = args.zoom {
        pool.install(|| stage.zoom(factor))?;
    }
    let mut setups = Vec::new();
    for _ in 0..args.reps {
        setups.push(Prepared::new(&loaded, &stage.regime, stage.plan)?.setup_time);
    }

    let world = stage.world();
    let (primary_times, pass) =
        repeat(args.reps, &pool, || primary(&world, width, height)).map_err(|error| stage.failure(error))?;
    let (image_times, _) = repeat(args.reps, &pool, || render(&world, &settings, &|_| {}))
        .map_err(|error| stage.failure(error))?;

    let probes = pool.install(|| probe(&world, width, height)).map_err(|error| stage.failure(error))?;
    let slowest = slowest(probes);

    let PrimaryPass { hits, counters, .. } = pass;
    let rays = counters.rays as f64;
    let primary_cpu_s = median(primary_times.iter().map(|time| time.cpu));
    let report = Report {
        scene: loaded.name.clone(),
        set: loaded.set().map(str::to_owned).collect(),
        zoom: args.zoom,
        engine: stage.prepared.kind().to_string(),
        width,
        height,
        threads: pool.current_num_threads(),
        reps: args.reps,
        primitives: stage.regime.primitives(),
        setup_s: median(setups),
        bytes: stage.prepared.bytes(),
        primary_cpu_s,
        primary_s: median(primary_times.iter().map(|time| time.wall)),
        primary_mray_s: rays / primary_cpu_s * 1e-6,
        image_cpu_s: median(image_times.iter().map(|time| time.cpu)),
        image_s: median(image_times.iter().map(|time| time.wall)),
        box_tests_per_ray: counters.box_tests as f64 / rays,
        primitive_tests_per_ray: counters.primitive_tests as f64 / rays,
        hit_fraction: hits as f64 / rays,
        slowest_box_tests_per_ray: mean(&slowest, |probe| probe.box_tests),
        slowest_primitive_tests_per_ray: mean(&slowest, |probe| probe.primitive_tests),
    };
    print(match args.format {
        Format::Table => table(&report),
        Format::Json => json(&report),
    })
}

/// The drawing that `bench --plot` would write, as an SVG file.
///
/// # Errors
/// If the scene has mistakes, which are reported, asks for what cannot be done, or there is no sweep.
pub fn drawing(args: &BenchArgs) -> Result<String, Failure> {
    let sweep = args.sweep.as_ref().ok_or_else(|| Failure::Usage("a drawing needs a sweep".to_owned()))?;
    sweep::drawing(args, &load(&args.scene)?, sweep)
}

/// What a ray costs: tests of a primary ray, and nanoseconds of a pixel.
struct Measured {
    box_tests: f64,
    primitive_tests: f64,
    /// Primary rays alone.
    primary_ns: f64,
    /// With shading.
    unshadowed_ns: f64,
    /// With shadows.
    image_ns: f64,
}

fn measure(loaded: &Loaded, plan: Plan, size: Size, args: &BenchArgs) -> Result<Measured, Failure> {
    let Size { width, height } = size;
    let settings = Settings { width, height, samples: 1, ..Settings::default() };
    let stage = Stage::set(loaded, plan, &settings, false, args.engine.memory)?;
    let pool = stage.threads(args.threads)?;
    let world = stage.world();
    let mut unshadowed = stage.world();
    unshadowed.lights.iter_mut().for_each(|light| light.shadow = false);
    let failure = |error| stage.failure(error);
    let (primary_times, pass) =
        repeat(args.reps, &pool, || primary(&world, width, height)).map_err(failure)?;
    let picture = |world| {
        let (times, _) = repeat(args.reps, &pool, || render(world, &settings, &|_| {})).map_err(failure)?;
        Ok::<_, Failure>(times)
    };
    let pixels = f64::from(width) * f64::from(height);
    let nanoseconds = |times: Vec<Time>| 1e9 * median(times.iter().map(|time| time.cpu)) / pixels;
    Ok(Measured {
        box_tests: pass.counters.box_tests as f64 / pixels,
        primitive_tests: pass.counters.primitive_tests as f64 / pixels,
        primary_ns: nanoseconds(primary_times),
        unshadowed_ns: nanoseconds(picture(&unshadowed)?),
        image_ns: nanoseconds(picture(&world)?),
    })
}

/// What a repetition took.
struct Time {
    /// By the clock.
    wall: Duration,
    /// The time that the threads of the pool were running, summed over them.
    cpu: Duration,
}

/// Does something once, and then so many times again, which are measured; gives also the last result.
fn repeat<T: Send, E: Send>(
    reps: u32,
    pool: &ThreadPool,
    work: impl Fn() -> Result<T, E> + Sync,
) -> Result<(Vec<Time>, T), E> {
    let cpu_time = || -> Duration { pool.broadcast(|_| ThreadTime::now().as_duration()).into_iter().sum() };
    let mut result = pool.install(&work)?;
    let mut times = Vec::new();
    for _ in 0..reps {
        let (start, cpu_start) = (Instant::now(), cpu_time());
        result = pool.install(&work)?;
        times.push(Time { cpu: cpu_time().saturating_sub(cpu_start), wall: start.elapsed() });
    }
    Ok((times, result))
}

/// The hundredth of the rays, and at least one, that were tested against the most boxes and primitives.
fn slowest(mut probes: Vec<Probe>) -> Vec<Probe> {
    let count = probes.len().div_ceil(100);
    probes.sort_by_key(|probe| {
        std::cmp::Reverse(u64::from(probe.box_tests) + u64::from(probe.primitive_tests))
    });
    probes.truncate(count);
    probes
}

fn mean(probes: &[Probe], count: impl Fn(&Probe) -> u32) -> f64 {
    probes.iter().map(|probe| f64::from(count(probe))).sum::<f64>() / probes.len() as f64
}

/// The middle one, in seconds; of an even number the larger of the two in the middle.
fn median(times: impl IntoIterator<Item = Duration>) -> f64 {
    let mut times: Vec<Duration> = times.into_iter().collect();
    times.sort();
    times[times.len() / 2].as_secs_f64()
}

fn table(report: &Report) -> String {
    let per_ray =
        |count: f64, slowest: f64| format!("{count:.2} a primary ray, {slowest:.2} of the slowest hundredth");
    let both = |cpu: f64, wall: f64| format!("{} CPU, {} by the clock", seconds(cpu), seconds(wall));
    let rows = [
        ("primitives", short(&report.primitives)),
        ("engine", format!("{}, {} bytes", report.engine, grouped(report.bytes))),
        ("set up in", seconds(report.setup_s)),
        (
            "primary rays",
            format!(
                "{:.2} million a second, {}",
                report.primary_mray_s,
                both(report.primary_cpu_s, report.primary_s)
            ),
        ),
        ("picture", both(report.image_cpu_s, report.image_s)),
        ("box tests", per_ray(report.box_tests_per_ray, report.slowest_box_tests_per_ray)),
        ("primitive tests", per_ray(report.primitive_tests_per_ray, report.slowest_primitive_tests_per_ray)),
        ("rays that hit", format!("{:.1} %", 100.0 * report.hit_fraction)),
    ];
    let Report { scene, width, height, threads, reps, .. } = report;
    let threads = if *threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") };
    let mut text = format!("{scene}: {width} × {height} pixels, {threads}, median of {reps}\n");
    for (name, value) in rows {
        text.push_str(&format!("  {name:<16} {value}\n"));
    }
    text
}
