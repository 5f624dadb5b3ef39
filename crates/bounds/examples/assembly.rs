//! An instancing dag, as CAD systems have it: bolts in flanges, flanges on pipes, pipes in racks, racks in a plant.
//!
//! ```text
//! cargo run --release -p csg-graph-bounds --example assembly
//! ```
//!
//! A sub-assembly is stored once and placed many times. Its box is found once, and the boxes above it look inside as far as
//! they need: the fifteen definitions below stand for three million parts.

#![expect(clippy::print_stdout, reason = "it prints a table")]

use std::convert::Infallible;
use std::time::Instant;

use csg_graph_bounds::{Aabb, Limits, PointSet, Scene, Shape, Step, exact};
use glam::{DAffine3, DVec3};

/// A definition: a part, or other definitions in their places.
enum Definition {
    Part(Solid),
    Assembly(Vec<(DAffine3, usize)>),
}

/// The parts that this plant is made of: a cylinder about z or a block.
#[derive(Clone)]
enum Solid {
    Cylinder { radius: f64, height: f64 },
    Block(Aabb),
}

impl Shape for Solid {
    fn bounds(&self) -> Aabb {
        match *self {
            Self::Cylinder { radius, height } => {
                Aabb::new(DVec3::new(-radius, -radius, 0.0), DVec3::new(radius, radius, height))
            }
            Self::Block(block) => block,
        }
    }

    fn point_set(&self) -> PointSet<'_> {
        match self {
            Self::Cylinder { radius, height } => {
                let PointSet::Points(unit) = PointSet::cylinder() else { return PointSet::Unbounded };
                let size = DVec3::new(*radius, *radius, *height);
                PointSet::from(unit.iter().map(|point| size * *point).collect::<Vec<_>>())
            }
            Self::Block(block) => Shape::point_set(block),
        }
    }

    fn support(&self, d: DVec3) -> f64 {
        match self {
            Self::Cylinder { radius, height } => radius * libm::hypot(d.x, d.y) + height * d.z.max(0.0),
            Self::Block(block) => block.support(d),
        }
    }
}

/// All definitions, by name; each comes after those that it places.
#[derive(Default)]
struct Plant {
    definitions: Vec<(&'static str, Definition)>,
}

/// A definition, or one place in one.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum State {
    Definition(usize),
    Instance { within: usize, at: usize },
}

impl Scene for Plant {
    type State = State;
    type Map = DAffine3;
    type Shape = Solid;
    type Error = Infallible;

    fn root(&self) -> State {
        State::Definition(self.definitions.len() - 1)
    }

    fn step(&self, state: &State) -> Result<Step<Self>, Infallible> {
        let (within, at) = match *state {
            State::Definition(within) => (within, None),
            State::Instance { within, at } => (within, Some(at)),
        };
        Ok(match (&self.definitions[within].1, at) {
            (Definition::Part(solid), _) => Step::Shape(solid.clone()),
            (Definition::Assembly(places), None) => {
                Step::Union((0..places.len()).map(|at| State::Instance { within, at }).collect())
            }
            (Definition::Assembly(places), Some(at)) => {
                Step::Map(places[at].0, State::Definition(places[at].1))
            }
        })
    }

    fn node(&self, state: &State) -> usize {
        match *state {
            State::Definition(within) | State::Instance { within, .. } => within,
        }
    }

    fn node_count(&self) -> usize {
        self.definitions.len()
    }
}

impl Plant {
    fn part(&mut self, name: &'static str, solid: Solid) -> usize {
        self.definitions.push((name, Definition::Part(solid)));
        self.definitions.len() - 1
    }

    fn assembly(&mut self, name: &'static str, places: impl IntoIterator<Item = (DAffine3, usize)>) -> usize {
        self.definitions.push((name, Definition::Assembly(places.into_iter().collect())));
        self.definitions.len() - 1
    }

    /// How many parts each definition stands for.
    fn part_counts(&self) -> Vec<u64> {
        let mut counts = Vec::new();
        for (_, definition) in &self.definitions {
            counts.push(match definition {
                Definition::Part(_) => 1,
                Definition::Assembly(places) => places.iter().map(|(_, placed)| counts[*placed]).sum(),
            });
        }
        counts
    }
}

fn moved(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

fn plant() -> Plant {
    let mut plant = Plant::default();
    let turned = |angle: f64| DAffine3::from_rotation_z(angle.to_radians());
    let shank = plant.part("shank", Solid::Cylinder { radius: 0.01, height: 0.08 });
    let head = plant
        .part("head", Solid::Block(Aabb::new(DVec3::new(-0.02, -0.02, -0.01), DVec3::new(0.02, 0.02, 0.0))));
    let bolt = plant.assembly("bolt", [(DAffine3::IDENTITY, shank), (turned(30.0), head)]);
    let disc = plant.part("disc", Solid::Cylinder { radius: 0.2, height: 0.04 });
    let bolts = (0..12).map(|i| (turned(30.0 * f64::from(i)) * moved(0.17, 0.0, -0.02), bolt));
    let flange = plant.assembly("flange", bolts.chain([(DAffine3::IDENTITY, disc)]));
    let tube = plant.part("tube", Solid::Cylinder { radius: 0.1, height: 3.0 });
    let upside_down = DAffine3::from_rotation_x(std::f64::consts::PI);
    let pipe = plant.assembly(
        "pipe",
        [
            (DAffine3::IDENTITY, tube),
            (DAffine3::IDENTITY, flange),
            (moved(0.0, 0.0, 3.0) * upside_down, flange),
        ],
    );
    // Each row is a pair of the one before, leaning on each other; pipes never stand quite straight.
    let mut row = pipe;
    for (i, name) in (0..).zip(["pair", "rack", "bay", "row", "block", "hall", "site", "plant"]) {
        let apart = 0.25 * f64::from(1 << (i / 2));
        let [dx, dy] = if i % 2 == 0 { [apart, 0.0] } else { [0.0, apart] };
        let lean = |angle: f64| DAffine3::from_axis_angle(DVec3::new(0.6, 0.8, 0.0), angle);
        let places = (0..4).map(|k| {
            let k = f64::from(k);
            (moved(k * dx, k * dy, 0.0) * lean(0.02 * k - 0.03) * turned(7.0 * k), row)
        });
        let places: Vec<_> = places.collect();
        row = plant.assembly(name, places);
    }
    plant
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let plant = plant();
    let start = Instant::now();
    let boxes = exact(&plant, &Limits::default())?;
    let seconds = start.elapsed().as_secs_f64();
    println!("{:<8} {:>10} {:>9} {:>9} {:>9}", "", "parts", "size x", "y", "z");
    for (i, ((name, _), parts)) in plant.definitions.iter().zip(plant.part_counts()).enumerate() {
        if let Some(found) = boxes.of(&State::Definition(i)) {
            let size = found.aabb.size();
            println!("{name:<8} {parts:>10} {:>9.4} {:>9.4} {:>9.4}", size.x, size.y, size.z);
        }
    }
    println!("{} states, largest gap {:.0e}, {:.1} ms", boxes.counts.states, boxes.gap, 1e3 * seconds);
    Ok(())
}
