//! Graphs compiled on demand, and parts that are too small to be looked into.
#![expect(clippy::unwrap_used, reason = "a test that fails to build its scene fails")]

#[path = "common/agreement.rs"]
mod agreement;

use std::iter;

use csg_graph::Graph;
use csg_graph_bounds::{Aabb, Envelopes, Limits, exact, root_box};
use csg_graph_trace::{
    Accelerated, Camera, Engine, Footprint, Hit, Lens, Light, PACKET, Ray, RenderError, Settings,
    StateBounds, Tracer, World, brute, probe, render, zoom,
};
use glam::DVec3;

use agreement::{CLEARANCE, agree};

const SIDE: u32 = 96;

fn graph(source: &str) -> Graph {
    let lowered = csg_graph_grammar::load(source, &[]).unwrap_or_else(|mistakes| panic!("{}", mistakes[0]));
    lowered.scene.graph
}

fn whole(graph: &Graph) -> Accelerated {
    let boxes = exact(graph, &Limits::default()).unwrap();
    // Short lists, so that there are many.
    Accelerated::new(graph, &boxes, 1 << 12).unwrap()
}

fn enveloped(graph: &Graph, memory: usize) -> Accelerated {
    let envelopes = Envelopes::new(graph.clone(), &Limits::default());
    let bounds = StateBounds::Envelopes(Box::new(envelopes));
    Accelerated::on_demand(graph.clone(), bounds, memory).unwrap()
}

fn lens(bounds: &Aabb) -> Lens {
    Camera::framing(bounds, 40.0, 1.0).lens(SIDE, SIDE).unwrap()
}

/// The first hit of the ray through a point of the picture.
fn look(tracer: &mut Tracer<'_>, lens: &Lens, [x, y]: [f64; 2]) -> Option<Hit> {
    tracer.set_footprint(Footprint { width: 0.0, spread: lens.spread() });
    tracer.nearest(&lens.ray(x, y))
}

fn centres() -> impl Iterator<Item = [f64; 2]> {
    (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| [f64::from(x) + 0.5, f64::from(y) + 0.5]))
}

fn picture(scene: &Accelerated, bounds: &Aabb, samples: u32) -> Result<Vec<u8>, RenderError> {
    let camera = Camera::framing(bounds, 40.0, 1.0);
    let world = World {
        engine: Engine::Fast(scene),
        camera,
        lights: vec![Light::over_shoulder(&camera)],
        background: World::DEFAULT_BACKGROUND,
    };
    let settings = Settings { width: SIDE, height: SIDE, samples, ..Settings::default() };
    render(&world, &settings, &|_| {}).map(|(film, _)| film.to_srgb8())
}

/// A tree of order n whose branches are turned and shortened by chance.
fn tree(n: u32, seed: u32) -> String {
    format!(
        "{{ n = {n}; seed = {seed}; }} TREE
         TREE if(n > 0, 2, 1)
         1: TREE -> leaf
         2: TREE -> color(0.4, 0.2, 0.1) scale(0.1, 0.1, 1) cylinder | {{n = n - 1}} move(0, 0, 1)
            ( rotz(rand(0, 120)) rotx(rand(20, 45)) uscale(rand(0.65, 0.8)) TREE
            | rotz(rand(180, 300)) rotx(rand(20, 45)) uscale(rand(0.65, 0.8)) TREE )
         leaf = color(0.1, rand(0.3, 0.6), 0.1) scale(0.2, 0.05, 0.5) move(0, 0, 1) sphere"
    )
}

/// Cubes in four corners of four corners of a cube, and so on.
fn dust(n: u32) -> String {
    format!(
        "{{ n = {n}; }} DUST
         DUST if(n > 0, 2, 1)
         1: DUST -> cube
         2: DUST -> {{n = n - 1}} (corner | rotz(90) corner | rotx(180) corner | rotx(180) rotz(90) corner)
         corner = move(0.5, 0.5, 0.5) uscale(0.5) DUST"
    )
}

/// What a solid has in common with another one.
fn meet(source: &str, other: &str) -> String {
    source.replacen("} DUST", &format!("}} (DUST & {other})"), 1)
}

/// What holds all of everything here.
const ALL: &str = "uscale(50) sphere";

/// What cuts through the dust.
const BLOCK: &str = "scale(0.9, 0.9, 0.7) cube";

#[test]
fn chance_is_the_same_on_demand() {
    for seed in 0..4 {
        let graph = graph(&tree(7, seed));
        let bounds = root_box(&graph, &Limits::default()).unwrap().aabb;
        let (lens, at_once, tree) = (lens(&bounds), whole(&graph), graph.unfold(100_000).unwrap());
        let mut expected = at_once.tracer();
        for memory in [0, 1 << 26] {
            let scene = enveloped(&graph, memory);
            let mut found = scene.tracer();
            let mut hits = 0;
            for place in centres().step_by(3) {
                let ray = lens.ray(place[0], place[1]);
                if brute::line(&tree, &ray).clearance < CLEARANCE {
                    continue;
                }
                let (expected, found) = (expected.nearest(&ray), found.nearest(&ray));
                assert!(agree(expected.as_ref(), found.as_ref()), "{expected:?}\n{found:?}");
                hits += usize::from(found.is_some());
            }
            assert!(hits > 100);
            assert!(scene.bytes() <= memory, "{} of {memory}", scene.bytes());
        }
    }
}

#[test]
fn memory_and_threads_change_no_byte() {
    // 2⁴⁰ leaves, no two alike.
    let graph = graph(&tree(40, 5));
    let bounds = Aabb::new([-2.0, -2.0, 0.0].into(), [2.0, 2.0, 4.0].into());
    let pictures = [(0, 1), (1 << 18, 3), (1 << 30, 2), (1 << 30, 8)].map(|(memory, threads)| {
        let scene = enveloped(&graph, memory).with_detail(2.0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| picture(&scene, &bounds, 1)).unwrap()
    });
    assert!(pictures.iter().all(|picture| *picture == pictures[0]));
    let colours = pictures[0].as_chunks::<3>().0;
    assert!(colours.iter().filter(|[r, g, b]| r > g && g > b).count() > 100, "there are branches");
}

#[test]
fn rays_that_come_to_much_answer_alone_and_together_alike() {
    // Each goes its own way through the crown, and together they come to more than a packet holds.
    let graph = graph(&tree(40, 5));
    let rays: Vec<Ray> = (0..16)
        .map(|number| {
            let number = f64::from(number);
            let from = DVec3::new(0.8 * number - 6.0, -6.0, 1.0 + 0.1 * number);
            let to = DVec3::new(0.5 - 0.06 * number, 0.0, 1.2 + 0.05 * number);
            Ray { origin: from, direction: to - from }
        })
        .collect();
    let hits = |memory: usize| {
        let scene = enveloped(&graph, memory).with_detail(1.0);
        let mut tracer = scene.tracer();
        tracer.set_footprint(Footprint { width: 0.002, spread: 0.0 });
        let mut together = vec![None; rays.len()];
        tracer.nearest_of(&rays, &mut together);
        let work = tracer.take_counters().tests();
        let alone: Vec<Option<Hit>> = rays.iter().map(|ray| tracer.nearest(ray)).collect();
        // What they did together before it was too much was in vain.
        assert!(work > tracer.counters().tests(), "they did not go alone");
        assert_eq!(together, alone);
        together
    };
    let found = hits(1 << 28);
    assert!(found.iter().any(Option::is_some));
    assert_eq!(found, hits(0));
}

#[test]
fn threads_change_no_byte_of_what_is_measured() {
    let graph = graph(&dust(10));
    let scene = whole(&graph).with_detail(4.0);
    let bounds = root_box(&graph, &Limits::default()).unwrap().aabb;
    let pictures = [1, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| picture(&scene, &bounds, 4)).unwrap()
    });
    assert_eq!(pictures[0], pictures[1]);
    let again = whole(&graph).with_detail(4.0);
    assert_eq!(pictures[0], picture(&again, &bounds, 4).unwrap());
}

/// So many pixels are not looked into.
const DETAIL: f64 = 2.0;

/// Whether rays close by, no farther than may not be looked into, answer like that.
fn is_near(fine: &mut Tracer<'_>, lens: &Lens, [x, y]: [f64; 2], is_hit: bool) -> bool {
    const STEPS: i32 = 24;
    let mut around = (-STEPS..=STEPS).flat_map(|i| (-STEPS..=STEPS).map(move |j| [i, j]));
    around.any(|step| {
        let [i, j] = step.map(|step| DETAIL * f64::from(step) / f64::from(STEPS));
        fine.nearest(&lens.ray(x + i, y + j)).is_some() == is_hit
    })
}

/// Compares rays that do not look into what is small with rays that do. Where one of them meets something and the other
/// one nothing, a silhouette is no farther than what is small.
fn compare_silhouettes(graph: &Graph, coarse: &Accelerated) {
    let lens = lens(&root_box(graph, &Limits::default()).unwrap().aabb);
    let fine = whole(graph);
    let (mut fine, mut coarse) = (fine.tracer(), coarse.tracer());
    let (mut hits, mut others) = (0, 0);
    for place in centres() {
        let expected = fine.nearest(&lens.ray(place[0], place[1]));
        let found = look(&mut coarse, &lens, place);
        match (&expected, &found) {
            (Some(_), Some(_)) => hits += 1,
            (None, None) => {}
            _ => {
                assert!(is_near(&mut fine, &lens, place, found.is_some()), "{place:?}: far off");
                others += 1;
            }
        }
    }
    assert!(hits > 1000 && others > 0, "{hits} {others}");
}

#[test]
fn silhouettes_are_off_by_less_than_they_may() {
    let graph = graph(&dust(8));
    compare_silhouettes(&graph, &whole(&graph).with_detail(DETAIL));
    compare_silhouettes(&graph, &enveloped(&graph, 1 << 24).with_detail(DETAIL));
}

/// What never ends.
fn listed(source: &str, memory: usize) -> Accelerated {
    let endless = graph(source);
    let boxes = exact(&endless, &Limits::default()).unwrap();
    assert!(boxes.endless.is_some());
    Accelerated::on_demand(endless, StateBounds::Exact(Box::new(boxes)), memory).unwrap()
}

/// Dust that never ends.
fn endless_dust() -> String {
    dust(1).replace("if(n > 0, 2, 1)", "if(n > 0, 2, 1 + (n < 0))").replace("n - 1", "n")
}

fn endless() -> Accelerated {
    listed(&endless_dust(), 1 << 20)
}

#[test]
fn what_never_ends_can_be_gone_close_to() {
    let scene = endless().with_detail(0.5);
    let camera = Camera::framing(&Aabb::new([-1.0; 3].into(), [1.0; 3].into()), 40.0, 1.0);
    let engine = Engine::Fast(&scene);
    let world = World { engine, camera, lights: vec![], background: World::DEFAULT_BACKGROUND };
    let closer = zoom(&world, 1.0, 1e6).unwrap();
    let [far, near] = [camera, closer].map(|camera| camera.eye.distance(camera.target));
    assert!(near < far * 1e-5 && near > far * 1e-8, "{near} of {far}");
    let seen = probe(&World { camera: closer, ..world }, 32, 32).unwrap();
    assert!(seen.iter().filter(|probe| probe.node.is_some()).count() > 100);
}

#[test]
fn what_never_ends_is_what_ends_far_below_a_pixel() {
    let scene = endless();
    compare_silhouettes(&graph(&dust(9)), &scene.with_detail(DETAIL));
}

/// How many rays meet one scene and not the other, and the other one, and all that meet the second.
fn count(fine: &Accelerated, coarse: &Accelerated, lens: &Lens) -> ([usize; 2], usize) {
    let (mut fine, mut coarse) = (fine.tracer(), coarse.tracer());
    let (mut only, mut all) = ([0; 2], 0);
    for place in centres() {
        let expected = fine.nearest(&lens.ray(place[0], place[1])).is_some();
        let found = look(&mut coarse, lens, place).is_some();
        only[0] += usize::from(expected && !found);
        only[1] += usize::from(found && !expected);
        all += usize::from(expected);
    }
    (only, all)
}

#[test]
fn what_never_ends_is_as_porous_as_what_ends_a_little_below() {
    // The box of a part of the eighth level is not half a pixel, and it is measured by the boxes of four levels more.
    let lens = lens(&Aabb::new([-1.0; 3].into(), [1.0; 3].into()));
    for endless in [endless(), listed(&meet(&endless_dust(), ALL), 1 << 20)] {
        let ([only_fine, only_endless], all) =
            count(&whole(&graph(&dust(12))), &endless.with_detail(0.5), &lens);
        let found = all + only_endless - only_fine;
        assert!(all > 500 && found.abs_diff(all) * 8 < all, "{found} for {all}");
    }
}

#[test]
fn small_parts_below_operators_are_lit_as_elsewhere() {
    let bounds = Aabb::new([-1.0; 3].into(), [1.0; 3].into());
    let light = |source: &str| {
        let picture = picture(&listed(source, 1 << 20).with_detail(1.0), &bounds, 4).unwrap();
        picture.iter().map(|byte| f64::from(*byte)).sum::<f64>()
    };
    let [expected, found] = [endless_dust(), meet(&endless_dust(), ALL)].map(|source| light(&source));
    assert!((found - expected).abs() < 0.005 * expected, "{found} for {expected}");
}

#[test]
fn small_parts_below_operators_are_the_same_alone_and_together() {
    let graph = graph(&meet(&dust(9), BLOCK));
    let lens = lens(&root_box(&graph, &Limits::default()).unwrap().aabb);
    for scene in [whole(&graph), enveloped(&graph, 1 << 24)] {
        let scene = scene.with_detail(4.0);
        let mut tracer = scene.tracer();
        let places: Vec<_> = centres().collect();
        let mut hits = 0;
        for places in places.chunks(PACKET) {
            tracer.set_footprint(Footprint { width: 0.0, spread: lens.spread() });
            let rays: Vec<Ray> = places.iter().map(|[x, y]| lens.ray(*x, *y)).collect();
            let mut together = vec![None; rays.len()];
            tracer.nearest_of(&rays, &mut together);
            for (ray, found) in rays.iter().zip(together) {
                assert_eq!(tracer.nearest(ray), found);
                hits += usize::from(found.is_some());
            }
        }
        assert!(hits > 500, "{hits}");
    }
}

/// Smaller copies of a solid, without end or n levels deep, down to a primitive.
fn copies(n: Option<u32>, primitive: &str, copies: &str) -> String {
    match n {
        None => format!("{{}} X\n X -> {copies}"),
        Some(n) => {
            format!(
                "{{ n = {n}; }} X\n X if(n > 0, 2, 1) 1: X -> {primitive} 2: X -> {{n = n - 1}} ({copies})"
            )
        }
    }
}

#[test]
fn what_never_ends_has_no_holes_but_its_own() {
    let cells = (0..27_i32).map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1]);
    let sponge: Vec<String> = cells
        .filter(|cell| cell.iter().filter(|x| **x == 0).count() < 2)
        .map(|[x, y, z]| format!("move({x} * 2 / 3, {y} * 2 / 3, {z} * 2 / 3) uscale(1 / 3) X"))
        .collect();
    // A sheet of two sheets that are turned, as a dragon; the boxes of no two levels are alike.
    let dragon = "rotz(45) uscale(sqrt(0.5)) X | move(1, 0, 0) rotz(135) uscale(sqrt(0.5)) X";
    let tile = "move(0.42, 0.16, 0) scale(0.35, 0.35, 1e-6) cube";
    let scenes = [
        ("cube", sponge.join(" | "), 5, [2.7, -4.2, 2.6], DVec3::ZERO),
        (tile, dragon.into(), 14, [0.42, -0.75, 1.9], DVec3::new(0.42, 0.16, 0.0)),
    ];
    for (primitive, parts, levels, eye, target) in scenes {
        let (ends, never_ends) = (copies(Some(levels), primitive, &parts), copies(None, primitive, &parts));
        let camera = Camera { eye: eye.into(), target, up: DVec3::Z, fov: 40.0 };
        let lens = camera.lens(SIDE, SIDE).unwrap();
        let ([holes, _], all) =
            count(&whole(&graph(&ends)), &listed(&never_ends, 1 << 20).with_detail(2.0), &lens);
        assert!(all > 500 && holes * 500 < all, "{primitive}: {holes} of {all}");
    }
}

#[test]
fn memory_and_threads_change_no_byte_of_what_never_ends() {
    let source = copies(
        None,
        "",
        "scale(0.1, 0.1, 1) cylinder | move(0, 0, 1) uscale(0.6) (rotx(30) X | rotx(-30) X)",
    );
    let bounds = Aabb::new([-2.0, -2.0, 0.0].into(), [2.0, 2.0, 3.0].into());
    let pictures = [(0, 1), (1 << 24, 3), (1 << 24, 8)].map(|(memory, threads)| {
        let scene = listed(&source, memory).with_detail(2.0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| picture(&scene, &bounds, 1)).unwrap()
    });
    assert!(pictures.iter().all(|picture| *picture == pictures[0]));
}

#[test]
fn porous_parts_stop_as_many_rays_as_they_do() {
    // Dust of ever more levels is ever thinner, and looked at from so far that hardly anything of it is looked into.
    let sources = |n| [dust(n), meet(&dust(n), ALL), meet(&dust(n), BLOCK)].map(|source| (n, source));
    for (n, source) in [2, 6, 12].into_iter().flat_map(sources) {
        let graph = graph(&source);
        let lens = lens(&root_box(&graph, &Limits::default()).unwrap().aabb);
        // The last parts of 12 levels are too far below what is measured on demand, whose boxes are boxes of boxes.
        let on_demand = (n <= 6).then(|| enveloped(&graph, 1 << 24));
        for coarse in iter::once(whole(&graph)).chain(on_demand) {
            let ([only_fine, only_coarse], expected) =
                count(&whole(&graph), &coarse.with_detail(16.0), &lens);
            let found = expected + only_coarse - only_fine;
            assert!(found * 4 > expected * 3 && found * 3 < expected * 4, "{n}: {found} for {expected}");
        }
    }
}

#[test]
fn crowns_by_chance_stop_as_many_rays_as_they_do() {
    let graph = graph(&tree(9, 3));
    let lens = lens(&root_box(&graph, &Limits::default()).unwrap().aabb);
    let ([only_fine, only_coarse], expected) =
        count(&whole(&graph), &enveloped(&graph, 1 << 24).with_detail(4.0), &lens);
    let found = expected + only_coarse - only_fine;
    assert!(expected > 500 && found.abs_diff(expected) * 5 < expected, "{found} for {expected}");
}

#[test]
fn small_solids_stop_as_many_rays_as_they_do() {
    // Lenses that stand slantwise in their boxes.
    let lens_of_balls = "rotx(40) rotz(30) move(0, 0, 1) (move(0.8, 0, 0) sphere & move(-0.8, 0, 0) sphere)";
    let source = tree(9, 3).replace("scale(0.2, 0.05, 0.5) move(0, 0, 1) sphere", lens_of_balls);
    let graph = graph(&source);
    let lens = lens(&root_box(&graph, &Limits::default()).unwrap().aabb);
    let ([only_fine, only_coarse], expected) = count(&whole(&graph), &whole(&graph).with_detail(4.0), &lens);
    let found = expected + only_coarse - only_fine;
    assert!(expected > 500 && found.abs_diff(expected) * 10 < expected, "{found} for {expected}");
}

#[test]
fn small_solids_of_what_never_ends_stop_as_many_rays_as_they_do() {
    // Splinters that stand slantwise in their boxes, and again beside them, ever smaller.
    let splinter = "rotx(40) rotz(30) scale(1, 0.2, 1.5) (move(0.8, 0, 0) sphere & move(-0.8, 0, 0) sphere)";
    let places = (-3..4).flat_map(|x| (-1..2).map(move |y| [x, y]));
    let row = places.map(|[x, y]| format!("move({x}, {y}, {}) uscale(0.6) ({splinter})", 2 * y));
    let row = row.collect::<Vec<_>>().join(" | ");
    let source = |n: &str, below: &str| {
        format!(
            "{{ n = {n}; }} ROW
             ROW if(n > 0, 2, 1 + (n < 0))
             1: ROW -> row
             2: ROW -> row | {{n = {below}}} move(0, 6, 0) uscale(0.6) ROW
             row = {row}"
        )
    };
    let fine = graph(&source("12", "n - 1"));
    let lens = lens(&root_box(&fine, &Limits::default()).unwrap().aabb);
    let ([only_fine, only_endless], all) =
        count(&whole(&fine), &listed(&source("1", "n"), 1 << 20).with_detail(6.0), &lens);
    let found = all + only_endless - only_fine;
    assert!(all > 200 && found.abs_diff(all) * 10 < all, "{found} for {all}");
}

#[test]
fn faces_that_coincide_below_operators_may_be_of_small_parts() {
    // The box of a leaf juts out of those around it. Where the two cubes coincide, all operands are asked for the face.
    let lens = lens(&root_box(&graph(&tree(9, 3)), &Limits::default()).unwrap().aabb);
    let graph = graph(&tree(9, 3).replacen("} TREE", "} (uscale(9) cube \\ (uscale(9) cube \\ TREE))", 1));
    for scene in [whole(&graph), enveloped(&graph, 1 << 24)] {
        let scene = scene.with_detail(8.0);
        let mut tracer = scene.tracer();
        let hits = centres().filter_map(|place| look(&mut tracer, &lens, place));
        let leaves = hits.filter(|hit| hit.surface.pigment.y > hit.surface.pigment.x).count();
        assert!(leaves > 100, "{leaves}");
    }
}

#[test]
fn small_parts_cut_nothing_off() {
    // Of the block, all is left that the dust leaves.
    let graph = graph(&dust(7).replacen("} DUST", &format!("}} ({BLOCK} \\ DUST)"), 1));
    let lens = lens(&root_box(&graph, &Limits::default()).unwrap().aabb);
    let fine = whole(&graph);
    for scene in [whole(&graph), enveloped(&graph, 1 << 24)] {
        let scene = scene.with_detail(8.0);
        let (mut fine, mut coarse) = (fine.tracer(), scene.tracer());
        let mut earlier = 0;
        for place in centres() {
            let Some(expected) = fine.nearest(&lens.ray(place[0], place[1])) else { continue };
            let found = look(&mut coarse, &lens, place).expect("what is there is seen");
            assert!(found.t <= expected.t * (1.0 + 1e-9), "{place:?}");
            earlier += usize::from(found.t < expected.t * (1.0 - 1e-6));
        }
        assert!(earlier > 10, "{earlier}");
    }
}

#[test]
fn what_is_wrong_far_below_is_an_error() {
    let graph = graph(&tree(30, 1).replace("scale(0.2, 0.05, 0.5)", "scale(0.2, 0.05, 0.5 / n)"));
    let bounds = Aabb::new([-2.0, -2.0, 0.0].into(), [2.0, 2.0, 4.0].into());
    let error = picture(&enveloped(&graph, 1 << 20), &bounds, 1).unwrap_err();
    assert!(matches!(error, RenderError::Eval(_)), "{error}");
    // To each ray that comes there, and not only to the first one.
    let (scene, lens) = (enveloped(&graph, 1 << 20), lens(&bounds));
    let mut tracer = scene.tracer();
    let mut has_fault = |centre| {
        look(&mut tracer, &lens, centre);
        tracer.take_fault().is_some()
    };
    let found = centres().find(|centre| has_fault(*centre)).unwrap();
    assert!(has_fault(found));
}

/// A beam sees farther ahead than its rays come.
#[test]
fn what_is_wrong_behind_a_wall_is_no_matter() {
    let broken = tree(30, 1).replace("scale(0.2, 0.05, 0.5)", "scale(0.2, 0.05, 0.5 / n)");
    let (params, rest) = broken.split_once("} TREE").unwrap();
    let graph = graph(&format!("{params}}} move(0, -8, 0) scale(20, 0.1, 20) cube | TREE{rest}"));
    let scene = enveloped(&graph, 1 << 20);
    for fov in [20.0, 2.0, 0.2] {
        let camera = Camera { eye: DVec3::new(0.0, -9.0, 1.5), target: DVec3::Z * 1.5, up: DVec3::Z, fov };
        let lens = camera.lens(SIDE, SIDE).unwrap();
        let mut tracer = scene.tracer();
        tracer.set_footprint(Footprint { width: 0.0, spread: lens.spread() });
        for corner in (0..SIDE).step_by(16) {
            let side = corner..corner + 16;
            let beam = lens.beam(&side, &side);
            let rays: Vec<_> = side.map(|at| lens.ray(f64::from(at) + 0.5, f64::from(at) + 0.5)).collect();
            let mut hits = vec![None; rays.len()];
            tracer.nearest_of(beam.batch(&rays), &mut hits);
            assert!(hits.iter().all(Option::is_some));
            assert_eq!(tracer.take_fault(), None, "at {fov}");
        }
    }
}

/// Two crowns that are the same state, each of too many balls for one block.
#[test]
fn what_is_seen_of_two_that_are_alike_is_no_matter_of_which_was_seen_first() {
    let balls: Vec<String> =
        (0..20).map(|n| format!("move(0, 0, {n} / 20) color({n} / 20, 0, 0) sphere")).collect();
    let graph = graph(&format!(
        "{{ n = 1; }} PAIR
         PAIR -> move(-9, 0, 0) CROWN | move(9, 0, 0) CROWN
         CROWN -> {}",
        balls.join(" | ")
    ));
    let rays = [-9.0, 9.0].map(|x| Ray { origin: DVec3::new(x, -50.0, 0.5), direction: DVec3::Y });
    let seen = |order: [usize; 2]| {
        let scene = enveloped(&graph, 1 << 20).with_detail(1.0);
        let mut tracer = scene.tracer();
        tracer.set_footprint(Footprint { width: 10.0, spread: 0.0 });
        let mut nodes = [None; 2];
        order.into_iter().for_each(|at| nodes[at] = tracer.nearest(&rays[at]).map(|hit| hit.node));
        nodes
    };
    let found = seen([0, 1]);
    assert!(found.iter().all(Option::is_some));
    assert_eq!(found, seen([1, 0]));
}

/// The boxes of what never ends are those of what is not subtracted, and of one operand of ∩; rays go through all operands.
#[test]
fn recursion_through_any_operand_comes_to_an_end_if_it_shrinks() {
    for (rule, is_seen) in [
        (r"sphere & uscale(0.9) A", false),
        (r"cube & move(0.1, 0, 0) uscale(0.9) A", false),
        (r"sphere \ uscale(0.5) A", true),
        (r"cube \ move(0.3, 0, 0) uscale(0.9) A", true),
        (r"sphere & (cube \ uscale(0.8) A)", true),
        (r"cube \ (sphere | move(1, 1, 1) uscale(0.6) A)", true),
        (r"(cube | move(1, 0, 0) rotz(45) uscale(0.7) A) & uscale(1.2) sphere", true),
        // Without a primitive on the left, however far one looks for what is seen there.
        (r"(uscale(0.5) A | move(0.5, 0, 0) uscale(0.5) A) & cube", false),
    ] {
        let graph = graph(&format!("{{}} A\nA -> {rule}"));
        let boxes = exact(&graph, &Limits::default()).unwrap();
        assert!(boxes.shrinks(&graph).unwrap() < 1.0, "{rule}");
        let root = boxes.root;
        let scene = Accelerated::on_demand(graph, StateBounds::Exact(Box::new(boxes)), 1 << 20).unwrap();
        let scene = scene.with_detail(1.0);
        let (mut tracer, lens) = (scene.tracer(), lens(&root));
        let hits = centres().filter(|centre| look(&mut tracer, &lens, *centre).is_some()).count();
        assert!(!is_seen || hits > 500, "{rule}: {hits} hits");
        assert!(tracer.take_fault().is_none(), "{rule}");
    }
    for rule in [r"sphere \ A", r"sphere \ rotz(30) A", "sphere & A", "sphere & uscale(1.1) A"] {
        let graph = graph(&format!("{{}} A\nA -> {rule}"));
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let refused = boxes.shrinks(&graph).unwrap_err().to_string();
        assert!(refused.contains("the recursion never ends: A → "), "{rule}: {refused}");
    }
}

/// It would take some 10¹⁰ levels to the size of a pixel, and memory for each.
#[test]
fn recursion_that_hardly_shrinks_is_an_error() {
    for rule in ["uscale(0.9999999999) A | sphere", "cube | uscale(0.9999999999) rotx(10) A"] {
        let graph = graph(&format!("{{}} A\nA -> {rule}"));
        let boxes = exact(&graph, &Limits::default()).unwrap();
        let root = boxes.root;
        let scene = Accelerated::on_demand(graph, StateBounds::Exact(Box::new(boxes)), 1 << 20).unwrap();
        let error = picture(&scene.with_detail(1.0), &root, 1).unwrap_err();
        assert!(error.to_string().contains("hardly gets smaller"), "{error}");
    }
}

/// Where chance decides, nobody has shown beforehand that what is subtracted shrinks.
#[test]
fn too_many_parts_that_lie_in_each_other_are_an_error() {
    let copies =
        "move(0.3, 0.2, 0.1) uscale(0.95) A | rotz(50) move(-0.3, 0, 0) uscale(0.95) A | uscale(0.1) cube";
    let below_operator = "uscale(2) sphere \\ A";
    let levels = format!("A if(n > 0, 2, 1) 1: A -> cube 2: A -> {{n = n - 1}} ({copies})");
    let finite = graph(&format!("{{ n = 60; }} {below_operator}\n{levels}"));
    let bounds = root_box(&finite, &Limits::default()).unwrap().aabb;
    let scenes = [
        whole(&finite),
        listed(&format!("{{}} {below_operator}\nA -> {copies}"), 1 << 20).with_detail(8.0),
        listed(&format!("{{}} A\nA -> {}", copies.replace("0.95", "0.9999")), 1 << 20).with_detail(0.1),
    ];
    for scene in scenes {
        let error = picture(&scene, &bounds, 1).unwrap_err();
        assert!(error.to_string().contains("lie in each other"), "{error}");
    }
    // A solid that was met before is none any more: of which operand its face is cannot be asked.
    let plate = "rotx(15.6) scale(3.2, 3.2, 0.01) (cube & cube)";
    let scene = whole(&graph(&format!("{{ n = 60; }} ({plate} | ({below_operator}))\n{levels}")));
    let mut tracer = scene.tracer();
    let ray = Ray { origin: DVec3::new(0.1, -50.0, 0.5), direction: DVec3::Y };
    assert!(tracer.nearest(&ray).is_none());
    assert!(tracer.take_fault().is_some());
}

#[test]
fn operators_that_lead_on_and_on_by_chance_are_an_error() {
    let graph = graph("{} A\nA -> sphere \\ rotz(rand(0, 90)) A");
    let bounds = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
    let error = picture(&enveloped(&graph, 1 << 20), &bounds, 1).unwrap_err();
    assert!(error.to_string().contains("does not get smaller"), "{error}");
}
