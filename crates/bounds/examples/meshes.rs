//! A scene tree of transformed meshes, as modellers and engines have it: a windmill.
//!
//! ```text
//! cargo run -p csg-graph-bounds --example meshes
//! ```
//!
//! Each node has a transformation, perhaps a mesh, and children. The tree is a [`Scene`] whose states are its nodes: no
//! node is met twice, and each gets its own box. The blades turn about a tilted shaft in a cap that faces the wind:
//! boxes of boxes have twice the volume.

#![expect(clippy::print_stdout, reason = "it prints a table")]

use std::convert::Infallible;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

use csg_graph_bounds::{Limits, PointSet, Scene, Step, conventional, exact};
use glam::{DAffine3, DVec3};

/// A node of the tree, in an arena.
struct Node {
    name: &'static str,
    parent_from_node: DAffine3,
    /// The vertices of its mesh, if it has one.
    vertices: Vec<DVec3>,
    children: Vec<usize>,
}

/// The tree; its root is the last node.
struct Tree {
    nodes: Vec<Node>,
}

/// A node in its parent's frame, what it holds in its own frame, or its mesh alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Place {
    Node(usize),
    Contents(usize),
    Mesh(usize),
}

/// The meshes are borrowed from the tree.
struct Model<'a>(&'a Tree);

impl<'a> Scene for Model<'a> {
    type State = Place;
    type Map = DAffine3;
    type Shape = PointSet<'a>;
    type Error = Infallible;

    fn root(&self) -> Place {
        Place::Node(self.0.nodes.len() - 1)
    }

    fn step(&self, place: &Place) -> Result<Step<Self>, Infallible> {
        Ok(match *place {
            Place::Node(i) => Step::Map(self.0.nodes[i].parent_from_node, Place::Contents(i)),
            Place::Contents(i) => {
                let children = self.0.nodes[i].children.iter().map(|child| Place::Node(*child));
                Step::Union(children.chain([Place::Mesh(i)]).collect())
            }
            Place::Mesh(i) => Step::Shape(PointSet::from(self.0.nodes[i].vertices.as_slice())),
        })
    }

    fn node(&self, place: &Place) -> usize {
        match *place {
            Place::Node(i) => 3 * i,
            Place::Contents(i) => 3 * i + 1,
            Place::Mesh(i) => 3 * i + 2,
        }
    }

    fn node_count(&self) -> usize {
        3 * self.0.nodes.len()
    }

    fn label(&self, place: &Place) -> String {
        self.0.nodes[self.node(place) / 3].name.to_owned()
    }
}

/// A ring of vertices about the z axis.
fn ring(radius: f64, z: f64) -> impl Iterator<Item = DVec3> {
    (0..12).map(move |i| {
        let (sin, cos) = libm::sincos(f64::from(i) * FRAC_PI_6);
        DVec3::new(radius * cos, radius * sin, z)
    })
}

fn windmill() -> Tree {
    let mut nodes = Vec::new();
    let mut add = |name, parent_from_node, vertices: Vec<DVec3>, children: Vec<usize>| {
        nodes.push(Node { name, parent_from_node, vertices, children });
        nodes.len() - 1
    };
    let blades = (0..4).map(|i| {
        let sail = [(-0.1, 0.3), (0.5, 0.3), (0.7, 6.0), (0.1, 6.0)].map(|(y, z)| DVec3::new(0.05, y, z));
        let pitched =
            DAffine3::from_rotation_x(f64::from(i) * FRAC_PI_2 + 0.3) * DAffine3::from_rotation_z(0.2);
        add("blade", pitched, sail.to_vec(), vec![])
    });
    let blades = blades.collect();
    let hub = ring(0.3, 0.0).chain(ring(0.3, 0.6)).collect();
    let hub_on_its_side = DAffine3::from_rotation_y(FRAC_PI_2);
    let hub = add("hub", hub_on_its_side, hub, vec![]);
    let shaft = DAffine3::from_translation(DVec3::new(2.2, 0.0, 0.8)) * DAffine3::from_rotation_y(-0.15);
    let rotor = add("rotor", shaft, vec![], vec![hub].into_iter().chain::<Vec<usize>>(blades).collect());
    let roof = ring(2.0, 0.0).chain([DVec3::new(0.0, 0.0, 2.0)]).collect();
    let facing_the_wind =
        DAffine3::from_translation(DVec3::new(0.0, 0.0, 9.0)) * DAffine3::from_rotation_z(0.7);
    let cap = add("cap", facing_the_wind, roof, vec![rotor]);
    let wall = ring(3.0, 0.0).chain(ring(2.0, 9.0)).collect();
    add("windmill", DAffine3::IDENTITY, wall, vec![cap]);
    Tree { nodes }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let tree = windmill();
    let model = Model(&tree);
    let boxes = exact(&model, &Limits::default())?;
    let loose = conventional(&model, &Limits::default())?;
    println!("{:<10} {:>8} {:>8} {:>8}   {:>8}", "node", "size x", "y", "z", "volume, boxes of boxes = 1");
    for (place, found) in boxes.states().filter(|(place, _)| matches!(place, Place::Node(_))) {
        let size = found.aabb.size();
        let ratio = found.aabb.volume() / loose.nodes[model.node(place)].volume();
        println!("{:<10} {:>8.3} {:>8.3} {:>8.3}   {ratio:>8.3}", model.label(place), size.x, size.y, size.z);
    }
    Ok(())
}
