//! A recursive procedure that was never a grammar: a coral that branches, thins and bores itself hollow.
//!
//! ```text
//! cargo run --release -p csg-graph-bounds --example procedure
//! ```
//!
//! The procedure has two parameters, age and light; a twig in the light ages more slowly and branches, one in the shade
//! gives up a year and turns away. Its states are the pairs that it is called with, of which there are few, however many
//! twigs there are: both ways of coming to the same age and light are the same coral. The table shows it: twigs grow
//! like a power, states like a product, and time with the states.

#![expect(clippy::print_stdout, reason = "it prints a table")]

use std::collections::HashMap;
use std::convert::Infallible;
use std::time::Instant;

use csg_graph_bounds::{Aabb, Limits, Scene, Step, exact};
use glam::{DAffine3, DVec3};

/// A coral of some age.
struct Coral {
    age: u32,
}

/// Where the procedure is, with its parameters there.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum State {
    Twig { age: u32, light: u32 },
    Branch { age: u32, light: u32, left: bool },
    Stem,
    Solid,
    Bore,
}

/// The most light.
const LIGHT: u32 = 5;

impl Scene for Coral {
    type State = State;
    type Map = DAffine3;
    type Shape = Aabb;
    type Error = Infallible;

    fn root(&self) -> State {
        State::Twig { age: self.age, light: LIGHT }
    }

    fn step(&self, state: &State) -> Result<Step<Self>, Infallible> {
        Ok(match *state {
            State::Twig { age: 0, .. } => Step::Same(State::Stem),
            State::Twig { age, light } => {
                let branches = [false, true].map(|left| State::Branch { age, light, left });
                Step::Union([State::Stem].into_iter().chain(branches).collect())
            }
            State::Branch { age, light, left } => {
                let (angle, younger, light) = match (left, light) {
                    (true, light) => (0.6, 1, (light + 1).min(LIGHT)),
                    (false, 0) => (-1.4, 2, 1),
                    (false, light) => (-0.5, 1, light - 1),
                };
                let parent_from_twig = DAffine3::from_translation(DVec3::new(0.0, 0.0, 1.0))
                    * DAffine3::from_rotation_z(1.2 + 0.3 * f64::from(light))
                    * DAffine3::from_rotation_x(angle)
                    * DAffine3::from_scale(DVec3::splat(0.7));
                Step::Map(parent_from_twig, State::Twig { age: age.saturating_sub(younger), light })
            }
            State::Stem => Step::Difference([State::Solid, State::Bore]),
            State::Solid => Step::Shape(Aabb::new(DVec3::new(-0.1, -0.1, 0.0), DVec3::new(0.1, 0.1, 1.0))),
            State::Bore => Step::Shape(Aabb::new(DVec3::new(-0.05, -0.05, 0.0), DVec3::new(0.05, 0.05, 1.0))),
        })
    }

    fn node(&self, state: &State) -> usize {
        match state {
            State::Twig { .. } => 0,
            State::Branch { .. } => 1,
            State::Stem => 2,
            State::Solid => 3,
            State::Bore => 4,
        }
    }

    fn node_count(&self) -> usize {
        5
    }
}

/// The twigs of the unfolded coral, counted by its states, those below before those above.
fn twigs(coral: &Coral, states: impl Iterator<Item = State>) -> f64 {
    let mut counts: HashMap<State, f64> = HashMap::new();
    let mut last = 0.0;
    for state in states {
        let Ok(step) = coral.step(&state);
        let below = match step {
            Step::Union(parts) => parts.iter().map(|part| counts[part]).sum(),
            Step::Map(_, below) | Step::Same(below) | Step::Difference([below, _]) => counts[&below],
            Step::Shape(_) | Step::Intersection(_) => 1.0,
        };
        counts.insert(state, below);
        last = below;
    }
    last
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{:>5} {:>9} {:>7} {:>9} {:>8} {:>8}", "age", "twigs", "states", "seconds", "height", "gap");
    for age in [4, 16, 64, 256, 1024] {
        let coral = Coral { age };
        let start = Instant::now();
        let boxes = exact(&coral, &Limits::default())?;
        let seconds = start.elapsed().as_secs_f64();
        let twigs = twigs(&coral, boxes.states().map(|(state, _)| *state));
        let (states, height) = (boxes.counts.states, boxes.root.max.z);
        println!("{age:>5} {twigs:>9.1e} {states:>7} {seconds:>9.5} {height:>8.4} {:>8.0e}", boxes.gap);
    }
    Ok(())
}
