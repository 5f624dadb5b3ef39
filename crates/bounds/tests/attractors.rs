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
