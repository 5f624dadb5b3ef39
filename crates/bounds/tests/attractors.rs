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

/// Barnsley's, upright, with a stem that is almost a line.
fn fern() -> Ifs {
    let flat = |[xx, xz, zx, zz]: [f64; 4], y: f64, z: f64| {
        DAffine3::from_cols(
            DVec3::new(xx, 0.0, zx),
            DVec3::new(0.0, y, 0.0),
            DVec3::new(xz, 0.0, zz),
            DVec3::new(0.0, 0.0, z),
        )
    };
    Ifs::pure([
        flat([0.02, 0.0, 0.0, 0.16], 0.02, 0.0),
        DAffine3::from_rotation_x(0.05) * flat([0.85, 0.04, -0.04, 0.85], 0.85, 1.6),
        flat([0.20, -0.26, 0.23, 0.22], 0.3, 1.6),
        flat([-0.15, 0.28, 0.26, 0.24], 0.3, 0.44),
    ])
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
        assert!(found.root.encloses(known), "{name}: {:?}", found.root);
        assert!(off(found.root, known) < 1e-11, "{name}: {:?}", found.root);
        assert!(found.gap < 1e-11, "{name}: {}", found.gap);
        let root = root_box(&ifs, &Limits::default()).unwrap();
        assert!(root.aabb.encloses(known) && off(root.aabb, known) < 1e-11, "{name}: {root:?}");
    }
}

fn nodes(symbols: Vec<Vec<(DAffine3, usize)>>) -> Ifs {
    let shapes = vec![None; symbols.len()];
    Ifs { symbols, shapes }
}

/// Not shrinking once, but in the long run: what the Euclidean norm of single maps cannot see.
#[test]
fn maps_that_shrink_in_the_long_run() {
    let shear = DAffine3::from_cols(DVec3::X, DVec3::new(50.0, 1.0, 0.0), DVec3::Z, DVec3::ZERO);
    let half = DAffine3::from_translation(DVec3::ONE) * DAffine3::from_scale(DVec3::splat(0.5)) * shear;
    let found = boxes(&Ifs::pure([half]));
    // One point, where half of it is it.
    let point = (DMat3::IDENTITY - half.matrix3).inverse() * DVec3::ONE;
    assert!(off(found.root, Aabb::new(point, point)) < 1e-6, "{:?} {point}", found.root);
    assert!(found.endless.unwrap().contraction < 1.0);

    // There by a hundred, and back by a thousandth.
    let found = boxes(&nodes(vec![vec![(similar(100.0, [1.0; 3]), 1)], vec![(similar(1e-3, [0.0; 3]), 0)]]));
    assert!(off(found.root, Aabb::new(DVec3::splat(1.0 / 0.9), DVec3::splat(1.0 / 0.9))) < 1e-9);
    assert!((found.endless.unwrap().contraction - 0.1).abs() < 1e-6, "{:?}", found.endless);

    // Wider by a step, higher by another, each of them shrinking only what the other enlarges.
    let wide = DAffine3::from_scale(DVec3::new(1.5, 0.2, 0.5));
    let high = DAffine3::from_scale(DVec3::new(0.2, 1.5, 0.5));
    let found = boxes(&nodes(vec![vec![(wide, 1)], vec![(high, 0)]]));
    assert!(off(found.root, Aabb::new(DVec3::ZERO, DVec3::ZERO)) < 1e-9);
}

/// By one map that leads back into its own frame, and along two that take turns.
#[test]
fn sheared_recursion_shrinks_as_fast_as_it_does() {
    let cube = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
    let sheared = |by: f64| DAffine3::from_cols(DVec3::X, DVec3::new(by, 1.0, 0.0), DVec3::Z, DVec3::ZERO);
    for (shrink, by) in [(0.9, 0.5), (0.7, 0.7), (0.5, 0.9), (0.97, 3.0)] {
        let map =
            DAffine3::from_translation(DVec3::X) * DAffine3::from_scale(DVec3::splat(shrink)) * sheared(by);
        let (mut known, mut place) = (cube, DAffine3::IDENTITY);
        for _ in 0..3000 {
            place = map * place;
            known =
                known.join(Aabb::from_points(cube.corners().map(|corner| place.transform_point3(corner))));
        }
        let size = known.size().max_element();
        let back = DAffine3::from_scale(DVec3::splat(0.2));
        for symbols in [vec![vec![(map, 0)]], vec![vec![(map * back.inverse(), 1)], vec![(back, 0)]]] {
            let shapes = [Some(cube), None][..symbols.len()].to_vec();
            let found = boxes(&Ifs { symbols, shapes });
            let grown = Aabb::new(found.root.min - 1e-12 * size, found.root.max + 1e-12 * size);
            assert!(grown.encloses(known), "{:?} {known:?}", found.root);
            assert!(off(found.root, known) < found.gap + 1e-8 * size, "{:?} {known:?}", found.root);
            assert!(found.endless.unwrap().contraction < 0.99, "{:?}", found.endless);
        }
    }
}

/// By a millionth each time round: more rounds than there is time for.
#[test]
fn what_shrinks_slowly() {
    let slow = 0.999_999;
    let cube = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
    let turned = |turn: DMat3| DAffine3::from_mat3(slow * turn);
    let about = |symbols: Vec<Vec<(DAffine3, usize)>>, known: Aabb, least: f64| {
        let mut shapes = vec![None; symbols.len()];
        shapes[0] = Some(cube);
        let found = boxes(&Ifs { symbols, shapes });
        assert!(found.root.encloses(known), "{:?}", found.root);
        let error = off(found.root, known);
        assert!(error <= least && error <= found.gap + 1e-7, "{:?} {}", found.root, found.gap);
    };
    let quarter = turned(DMat3::from_rotation_z(std::f64::consts::FRAC_PI_2));
    let flipped = turned(DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)));
    about(vec![vec![(turned(DMat3::IDENTITY), 0)]], cube, 1e-5);
    about(vec![vec![(quarter, 0), (flipped, 0)]], cube, 1e-5);
    // There by a hundred, and back.
    let back = DAffine3::from_scale(DVec3::splat(slow / 100.0));
    about(vec![vec![(similar(100.0, [0.0; 3]), 1)], vec![(back, 0)]], cube, 1e-5);
    // Far away at last, in one direction.
    let far = Aabb::new(DVec3::NEG_ONE, DVec3::new(1.0, 1.0, 1.0 / (1.0 - slow)));
    let moved = DAffine3::from_translation(DVec3::Z) * turned(DMat3::IDENTITY);
    let found = boxes(&Ifs { symbols: vec![vec![(moved, 0)]], shapes: vec![Some(cube)] }).root;
    assert!(found.encloses(far) && found.max.z < 1.1e6, "{found:?}");
    assert!(off(found, Aabb { max: DVec3::new(1.0, 1.0, found.max.z), ..far }) < 1e-1, "{found:?}");
    // Turned against the axes, it is a column: of the first corners, one comes close to each face.
    let turn = turned(DMat3::from_rotation_z(0.7));
    let reach = |n: i32| {
        libm::pow(slow, f64::from(n))
            * (libm::cos(0.7 * f64::from(n)).abs() + libm::sin(0.7 * f64::from(n)).abs())
    };
    let side = (0..10_000).map(reach).fold(0.0, f64::max) - 1e-9;
    let column = Aabb::new(DVec3::new(-side, -side, -1.0), DVec3::new(side, side, 1.0));
    about(vec![vec![(turn, 0)]], column, 1e-5);
}

#[test]
fn what_does_not_shrink_is_an_error() {
    let round_of = |ifs: &Ifs| match error_of(ifs) {
        BoundsError::Endless { cycle, round } => (cycle, round),
        other => panic!("{other}"),
    };
    let place = |places: &[Place]| places.iter().map(|place| format!("{place:?}")).collect::<Vec<_>>();
    // The second image grows, and is named.
    let (cycle, round) = round_of(&Ifs::pure([similar(0.5, [0.0; 3]), similar(1.2, [0.0; 3])]));
    assert_eq!(cycle, place(&[Place::Symbol(0), Place::Image(0, 1)]));
    assert!(matches!(round, Round::Grows(factor) if (factor - 1.2).abs() < 1e-6), "{round:?}");
    // Of two cycles through two symbols, the one that grows.
    let (cycle, round) = round_of(&nodes(vec![
        vec![(similar(0.1, [0.0; 3]), 1), (similar(0.9, [0.0; 3]), 0)],
        vec![(similar(11.0, [0.0; 3]), 0)],
    ]));
    assert_eq!(cycle, place(&[Place::Symbol(0), Place::Image(0, 0), Place::Symbol(1), Place::Image(1, 0)]));
    assert!(matches!(round, Round::Grows(factor) if (factor - 1.1).abs() < 1e-6), "{round:?}");

    let turn = DAffine3::from_rotation_y(0.3);
    assert_eq!(round_of(&Ifs::pure([turn])).1, Round::Turns);
    let shear = DAffine3::from_cols(DVec3::X, DVec3::new(3.0, 1.0, 0.0), DVec3::Z, DVec3::ZERO);
    assert_eq!(round_of(&Ifs::pure([shear])).1, Round::Turns);
    assert_eq!(round_of(&Ifs::pure([DAffine3::from_translation(DVec3::X)])).1, Round::Turns);
    assert_eq!(round_of(&Ifs::pure([DAffine3::IDENTITY])).1, Round::Unchanged);
    let error = error_of(&Ifs::pure([turn])).to_string();
    assert_eq!(
        error,
        "the recursion never ends: Symbol(0) → Image(0, 0) leads back to itself and does not shrink on the way"
    );
    let broken = DAffine3::from_scale(DVec3::new(f64::NAN, 0.5, 0.5));
    assert!(exact(&Ifs::pure([broken]), &Limits::default()).is_err());
}

/// Solids that are parts of themselves through other operators than unions.
#[derive(Clone, Copy, Debug)]
enum Cut {
    /// A cube, and twice itself within a cube.
    GrowsInACube,
    /// Half of itself within a cube that has none of it.
    NothingIsLeft,
    /// A cube without half of itself.
    Eaten,
    /// Half of itself without a cube, and the cube.
    ShrinksAndIsEaten,
    /// Itself, and a cube.
    Itself,
}

impl Scene for Cut {
    type State = u8;
    type Map = DAffine3;
    type Shape = Aabb;
    type Error = Infallible;

    fn root(&self) -> u8 {
        0
    }

    fn step(&self, state: &u8) -> Result<Step<Self>, Infallible> {
        let cube = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
        Ok(match (self, state) {
            (_, 9) => Step::Shape(cube),
            (Self::GrowsInACube, 0) => Step::Intersection([1, 9]),
            (Self::GrowsInACube, 1) => Step::Map(similar(2.0, [0.3; 3]), 0),
            (Self::NothingIsLeft, 0) => Step::Union(vec![1]),
            (Self::NothingIsLeft, 1) => Step::Intersection([2, 9]),
            (Self::NothingIsLeft, 2) => Step::Map(similar(0.5, [5.0; 3]), 0),
            (Self::Eaten, 0) => Step::Difference([9, 1]),
            (Self::Eaten | Self::ShrinksAndIsEaten, 1) => Step::Map(similar(0.5, [1.0; 3]), 0),
            (Self::ShrinksAndIsEaten, 0) => Step::Union(vec![2, 9]),
            (Self::ShrinksAndIsEaten, 2) => Step::Difference([1, 9]),
            (Self::Itself, _) => Step::Union(vec![0, 9]),
            _ => unreachable!("{self:?} has no state {state}"),
        })
    }

    fn node(&self, _: &u8) -> usize {
        0
    }

    fn node_count(&self) -> usize {
        1
    }
}

#[test]
fn intersections_and_differences_in_cycles() {
    let cube = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
    let found = boxes(&Cut::GrowsInACube);
    assert!(off(found.root, cube) < 1e-12, "{:?}", found.root);
    let found = boxes(&Cut::NothingIsLeft);
    assert_eq!((found.root, found.gap), (Aabb::EMPTY, 0.0));
    let found = boxes(&Cut::Eaten);
    assert_eq!(found.root, cube);
    assert_eq!(found.endless, None);
    // The furthest copies are about the fixed point.
    let found = boxes(&Cut::ShrinksAndIsEaten);
    assert!(off(found.root, Aabb::new(DVec3::NEG_ONE, DVec3::splat(2.0))) < 1e-11, "{:?}", found.root);
    let error = exact(&Cut::Itself, &Limits::default()).map(|_| ()).unwrap_err();
    assert!(matches!(error, BoundsError::Endless { round: Round::Unchanged, .. }), "{error}");
}

#[test]
fn work_on_attractors_is_limited_and_the_gap_certified() {
    let full = boxes(&dragon());
    for expansions in [0, 1, 10] {
        let found = exact(&dragon(), &Limits::default().with_expansions(expansions)).unwrap();
        assert!(found.root.encloses(full.root), "{:?}", found.root);
        assert!(off(found.root, full.root) <= found.gap + 1e-11, "{:?} {}", found.root, found.gap);
    }
    let loose = exact(&dragon(), &Limits::default().with_gap(1e-3)).unwrap();
    assert!(loose.root.encloses(full.root) && off(loose.root, full.root) <= loose.gap + 1e-11);
    assert!(loose.gap < 1e-2 && loose.counts.expansions < full.counts.expansions);
}

/// Images that shrink in norms of the frames, though perhaps not in the Euclidean one.
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
            if reach(symbol, d) < 1e-7 || expanded > 1_000 {
                closed = closed.max(upper);
                continue;
            }
            if let Some(shape) = self.ifs.shapes[symbol] {
                lower = lower.max(offset + shape.support(d));
            }
            for (map, below) in &self.ifs.symbols[symbol] {
                let (d, offset) = (map.matrix3.transpose() * d, offset + map.translation.dot(d));
                // The furthest last, to be next.
                let before = |other: &(usize, DVec3, f64)| {
                    other.2 + reach(other.0, other.1) <= offset + reach(*below, d)
                };
                let at = open.partition_point(before);
                open.insert(at, (*below, d, offset));
            }
        }
        [lower, closed.max(lower)]
    }

    /// Holds boxes to the chaos game and to the obvious search.
    fn check(&self, found: &ExactBoxes<Ifs>, seed: u64) {
        for symbol in 0..self.balls.len() {
            let Some(state_box) = found.of(&Place::Symbol(symbol)) else { continue };
            let size = self.radius;
            // Needles across the axes meet the limit of expansions; hardly anything else does.
            assert!(state_box.gap <= 1e-4 * size, "{state_box:?} {:?}", found.counts);
            let outer = Aabb::new(state_box.aabb.min - 1e-12 * size, state_box.aabb.max + 1e-12 * size);
            for game in 0..100 {
                let point = self.chaos_game(symbol, seed ^ game << 50);
                assert!(outer.contains(point), "{point} {state_box:?}");
            }
            for direction in DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]) {
                let face = state_box.aabb.support(direction);
                let [lower, upper] = self.support(symbol, direction);
                assert!(face >= lower - 1e-12 * size, "{face} {lower} {upper}");
                assert!(face <= upper + state_box.gap + 1e-9 * size, "{face} {lower} {upper}");
            }
        }
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

#[test]
fn attractors_of_the_literature() {
    for ifs in [sierpinski(), menger(), dragon(), fern()] {
        let offsets = ifs.symbols[0].iter().map(|(map, _)| map.translation.length());
        let radius = offsets.fold(0.0, f64::max) / (1.0 - 0.86);
        let found = boxes(&ifs);
        assert!(found.endless.unwrap().contraction < 0.86, "{:?}", found.endless);
        let recipe = Recipe { ifs, balls: vec![DMat3::IDENTITY], radius };
        recipe.check(&found, 7);
    }
}

#[test]
fn a_single_way_without_an_end_leads_nowhere() {
    assert_eq!(boxes(&sierpinski()).leads_nowhere(), None, "an attractor needs no shape");
    let cube = Aabb { min: -DVec3::ONE, max: DVec3::ONE };
    let half = |symbol| (similar(0.5, [1.0, 0.0, 0.0]), symbol);
    // The first symbol leads to the second, and that to itself.
    let ifs = |shapes| Ifs { symbols: vec![vec![half(0), half(1)], vec![half(1)]], shapes };
    assert_eq!(boxes(&ifs(vec![Some(cube), None])).leads_nowhere(), Some(&Place::Symbol(1)));
    assert_eq!(boxes(&ifs(vec![None, Some(cube)])).leads_nowhere(), None);
    let ends = Ifs { symbols: vec![vec![half(1)], vec![]], shapes: vec![None, Some(cube)] };
    assert_eq!(boxes(&ends).leads_nowhere(), None);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn boxes_are_those_of_random_attractors(recipe in contractions(), seed in 0_u64..1 << 40) {
        let found = boxes(&recipe.ifs);
        prop_assert!(found.endless.unwrap().contraction < 1.0);
        recipe.check(&found, seed);
    }

    /// With so few expansions the boxes are guessed, and must hold whatever the way leads to.
    #[test]
    fn guessed_boxes_hold_what_shrinks_slowly(
        maps in prop::collection::vec((0..3_usize, turns(), 2..7_i32, vectors(1.0), -5..2_i32, 0..2_usize), 2..=4),
        expansions in 1..200_usize,
        seed in 0_u64..1 << 40,
    ) {
        let cube = Aabb::new(DVec3::NEG_ONE, DVec3::ONE);
        let mut symbols = vec![Vec::new(), Vec::new()];
        for (at, (kind, turn, slowness, offset, size, below)) in maps.into_iter().enumerate() {
            let turn = match kind {
                0 => DMat3::IDENTITY,
                1 => DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z),
                _ => turn,
            };
            let power = |exponent: i32| libm::pow(10.0, f64::from(exponent));
            let matrix3 = turn * (1.0 - power(-slowness));
            symbols[at % 2].push((DAffine3 { matrix3, translation: offset * power(size - 3) }, below));
        }
        let ifs = Ifs { symbols, shapes: vec![Some(cube), None] };
        let found = exact(&ifs, &Limits::default().with_expansions(expansions)).unwrap().root;
        let mut seed = seed;
        for length in (0..50).map(|n| 2 * n * n) {
            // Up from a corner of the cube to the root.
            let (mut symbol, mut path) = (0, Vec::new());
            for _ in 0..length {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let images = &ifs.symbols[symbol];
                let (map, below) = images[usize::try_from(seed >> 33).unwrap() % images.len()];
                path.push(map);
                symbol = below;
            }
            if symbol == 0 {
                for corner in cube.corners() {
                    let point = path.iter().rfold(corner, |point, map| map.transform_point3(point));
                    let margin = 1e-9 * found.max.max(-found.min).max_element();
                    let outer = Aabb { min: found.min - margin, max: found.max + margin };
                    prop_assert!(outer.contains(point), "{point} {found:?}");
                }
            }
        }
    }
}
