//! Recursion that never ends: boxes of attractors, against known answers, chaos games and deep unfoldings.
#![expect(clippy::unwrap_used, reason = "a test that fails to build its scene fails")]

use std::convert::Infallible;

use csg_graph_bounds::{Aabb, BoundsError, ExactBoxes, Limits, Round, Scene, Step, exact, root_box};
use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;

/// Symbols, each the union of images of symbols and perhaps a cuboid.
#[derive(Clone, Debug)]
struct Ifs {
    symbols: Vec<Vec<(DAffine3, usize)>>,
    shapes: Vec<Option<Aabb>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Place {
    Symbol(usize),
    Image(usize, usize),
    Shape(usize),
}

impl Scene for Ifs {
    type State = Place;
    type Map = DAffine3;
    type Shape = Aabb;
    type Error = Infallible;

    fn root(&self) -> Place {
        Place::Symbol(0)
    }

    fn step(&self, place: &Place) -> Result<Step<Self>, Infallible> {
        Ok(match *place {
            Place::Symbol(symbol) => {
                let images = (0..self.symbols[symbol].len()).map(|image| Place::Image(symbol, image));
                Step::Union(images.chain(self.shapes[symbol].map(|_| Place::Shape(symbol))).collect())
            }
            Place::Image(symbol, image) => {
                let (map, below) = self.symbols[symbol][image];
                Step::Map(map, Place::Symbol(below))
            }
            Place::Shape(symbol) => Step::Shape(self.shapes[symbol].unwrap()),
        })
    }

    fn node(&self, place: &Place) -> usize {
        match *place {
            Place::Symbol(symbol) | Place::Image(symbol, _) | Place::Shape(symbol) => symbol,
        }
    }

    fn node_count(&self) -> usize {
        self.symbols.len()
    }

    fn label(&self, place: &Place) -> String {
        format!("{place:?}")
    }
}

impl Ifs {
    /// One symbol and no shape.
    fn pure(maps: impl IntoIterator<Item = DAffine3>) -> Self {
        Self { symbols: vec![maps.into_iter().map(|map| (map, 0)).collect()], shapes: vec![None] }
    }
}

fn boxes<S: Scene<Error: std::fmt::Debug>>(scene: &S) -> ExactBoxes<S> {
    exact(scene, &Limits::default()).unwrap()
}

fn off(a: Aabb, b: Aabb) -> f64 {
    if a == b { 0.0 } else { (a.min - b.min).abs().max((a.max - b.max).abs()).max_element() }
}

fn error_of(ifs: &Ifs) -> BoundsError<Infallible> {
    exact(ifs, &Limits::default()).map(|_| ()).unwrap_err()
}

fn similar(factor: f64, at: [f64; 3]) -> DAffine3 {
    DAffine3::from_translation(at.into()) * DAffine3::from_scale(DVec3::splat(factor))
}

fn sierpinski() -> Ifs {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    Ifs::pure(corners.map(|corner| similar(0.5, corner.map(|x| 0.5 * x))))
}

fn menger() -> Ifs {
    let cells = (0..27).map(|cell| [cell % 3, cell / 3 % 3, cell / 9]);
    let kept = cells.filter(|cell| cell.iter().filter(|at| **at == 1).count() < 2);
    Ifs::pure(kept.map(|cell| similar(1.0 / 3.0, cell.map(|at| f64::from(at - 1) * 2.0 / 3.0))))
}

fn dragon() -> Ifs {
    let half = |angle: f64, at: [f64; 3]| {
        DAffine3::from_translation(at.into())
            * DAffine3::from_rotation_z(angle.to_radians())
            * DAffine3::from_scale(DVec3::splat(0.5_f64.sqrt()))
    };
    Ifs::pure([half(45.0, [0.0; 3]), half(135.0, [1.0, 0.0, 0.0])])
}

#[test]
fn known_extents() {
    let cube = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
    for (name, ifs, known) in [
        ("sierpinski", sierpinski(), cube),
        ("menger", menger(), cube),
        (
            "dragon",
            dragon(),
            Aabb::new(DVec3::new(-1.0 / 3.0, -1.0 / 3.0, 0.0), DVec3::new(7.0 / 6.0, 2.0 / 3.0, 0.0)),
        ),
    ] {
        let found = boxes(&ifs);
        println!("{name}: {:?} {} {:?} {:?}", found.root, found.gap, found.counts, found.endless);
        assert!(found.root.encloses(known), "{name}: {:?}", found.root);
        assert!(off(found.root, known) < 1e-11, "{name}: {:?}", found.root);
        assert!(found.gap < 1e-11, "{name}: {}", found.gap);
        let root = root_box(&ifs, &Limits::default()).unwrap();
        assert!(root.aabb.encloses(known) && off(root.aabb, known) < 1e-11, "{name}: {root:?}");
    }
}

/// Ratios of what shrinks in the norms of the frames, though not in the Euclidean one.
#[derive(Clone, Debug)]
struct Recipe {
    ifs: Ifs,
    /// The unit balls of the norms, as images of the Euclidean one, and a radius that all symbols are within.
    balls: Vec<DMat3>,
    radius: f64,
}

fn vectors(size: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-size..size).prop_map(DVec3::from_array)
}

fn turns() -> impl Strategy<Value = DMat3> {
    (vectors(1.0), 0.0..6.3_f64)
        .prop_map(|(axis, angle)| DMat3::from_axis_angle(axis.try_normalize().unwrap_or(DVec3::Z), angle))
}

/// Up to three symbols of up to three images each.
fn contractions() -> impl Strategy<Value = Recipe> {
    let ball = (turns(), prop::array::uniform3(-1.2..1.2_f64))
        .prop_map(|(turn, sizes)| turn * DMat3::from_diagonal(DVec3::from_array(sizes.map(libm::exp))));
    let factors = prop::array::uniform3(prop_oneof![0.2..0.8_f64, -0.8..-0.2_f64]);
    let shrinking = (turns(), factors, turns())
        .prop_map(|(after, factors, before)| after * DMat3::from_diagonal(factors.into()) * before);
    let shape =
        prop::option::of((vectors(2.0), vectors(2.0)).prop_map(|(a, b)| Aabb::new(a.min(b), a.max(b))));
    let image = (shrinking, vectors(2.0), 0..3_usize);
    let symbol = (prop::collection::vec(image, 1..=3), shape, ball);
    prop::collection::vec(symbol, 1..=3).prop_map(|symbols| {
        let balls: Vec<DMat3> = symbols.iter().map(|(.., ball)| *ball).collect();
        let count = symbols.len();
        let (mut images, mut shapes, mut radius) = (Vec::new(), Vec::new(), 0.01_f64);
        for (above, (parts, shape, ball)) in symbols.into_iter().enumerate() {
            let unit = ball.inverse();
            if let Some(shape) = shape {
                let corners = shape.corners().map(|corner| (unit * corner).length());
                radius = corners.into_iter().fold(radius, f64::max);
            }
            images.push(Vec::new());
            for (shrinking, at, below) in parts {
                let below = below % count;
                let matrix3 = ball * shrinking * balls[below].inverse();
                radius = radius.max((unit * at).length() / (1.0 - 0.8));
                images[above].push((DAffine3 { matrix3, translation: at }, below));
            }
            shapes.push(shape);
        }
        Recipe { ifs: Ifs { symbols: images, shapes }, balls, radius }
    })
}

impl Recipe {
    /// The support of a symbol, between two bounds: the obvious search with the balls that the recipe was made from.
    fn support(&self, symbol: usize, direction: DVec3) -> [f64; 2] {
        let reach = |symbol: usize, d: DVec3| self.radius * (self.balls[symbol].transpose() * d).length();
        let mut open = vec![(symbol, direction, 0.0)];
        let mut lower = f64::NEG_INFINITY;
        let mut closed = f64::NEG_INFINITY;
        let mut expanded = 0;
        while let Some((symbol, d, offset)) = open.pop() {
            let upper = offset + reach(symbol, d);
            if upper <= lower {
                continue;
            }
            lower = lower.max(offset - reach(symbol, d));
            expanded += 1;
            if reach(symbol, d) < 1e-7 || expanded > 20_000 {
                closed = closed.max(upper);
                continue;
            }
            if let Some(shape) = self.ifs.shapes[symbol] {
                lower = lower.max(offset + shape.support(d));
            }
            let images = self.ifs.symbols[symbol].iter();
            open.extend(
                images.map(|(map, below)| {
                    (*below, map.matrix3.transpose() * d, offset + map.translation.dot(d))
                }),
            );
            // The furthest last, to be next.
            open.sort_by(|a, b| (a.2 + reach(a.0, a.1)).total_cmp(&(b.2 + reach(b.0, b.1))));
        }
        [lower, closed.max(lower)]
    }

    /// Points of a symbol, but for 0.8³⁰⁰ of its extent.
    fn chaos_game(&self, symbol: usize, seed: u64) -> DVec3 {
        let mut seed = seed;
        let mut symbol = symbol;
        let mut path = Vec::new();
        for _ in 0..300 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let images = &self.ifs.symbols[symbol];
            let (map, below) = images[usize::try_from(seed >> 33).unwrap() % images.len()];
            path.push(map);
            symbol = below;
        }
        path.iter().rfold(DVec3::ZERO, |point, map| map.transform_point3(point))
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn boxes_are_those_of_random_attractors(recipe in contractions(), seed in 0_u64..1 << 40) {
        let found = boxes(&recipe.ifs);
        prop_assert!(found.endless.unwrap().contraction < 1.0);
        for symbol in 0..recipe.balls.len() {
            let Some(state_box) = found.of(&Place::Symbol(symbol)) else { continue };
            let size = recipe.radius;
            prop_assert!(state_box.gap <= 1e-8 * size, "{state_box:?} {:?}", found.counts);
            let outer = Aabb::new(state_box.aabb.min - 1e-12 * size, state_box.aabb.max + 1e-12 * size);
            for game in 0..100 {
                let point = recipe.chaos_game(symbol, seed ^ game << 50);
                prop_assert!(outer.contains(point), "{point} {state_box:?}");
            }
            for axis in 0..3 {
                for sign in [-1.0, 1.0] {
                    let direction = sign * DVec3::AXES[axis];
                    let face = state_box.aabb.support(direction);
                    let [lower, upper] = recipe.support(symbol, direction);
                    prop_assert!(face >= lower - 1e-12 * size, "{face} {lower} {upper}");
                    prop_assert!(face <= upper + state_box.gap + 1e-9 * size, "{face} {lower} {upper}");
                }
            }
        }
    }
}
