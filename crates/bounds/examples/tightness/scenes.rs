//! The documented set of solids.

use csg_graph::{Expr, Graph, GraphBuilder, NodeId, Operator, PrimitiveKind, TransformKind};

use Operator::{Difference, Intersection};
use PrimitiveKind::{Cube, Cylinder, HalfSpace, Sphere};
use TransformKind::{Move, RotX, RotY, Scale, UScale};

/// Name, graph, and whether it can be sampled.
pub(crate) fn all() -> Vec<(&'static str, Graph, bool)> {
    vec![
        ("lens of two spheres", build(lens), true),
        ("cube minus a slab that removes a face", build(shaved), true),
        ("cube minus a half-space", build(halved), true),
        ("the same, turned by 30°", build(halved_and_turned), true),
        ("bitten apple", build(bitten), true),
        ("drilled block", build(drilled), true),
        ("nested differences", build(nested), true),
        ("`cheese` n = 3 cut by a half-space", cheese(3), true),
        ("`cheese` n = 40 cut by a half-space", cheese(40), false),
    ]
}

fn build(solid: fn(&mut Scene) -> NodeId) -> Graph {
    let mut scene = Scene(GraphBuilder::new());
    let root = solid(&mut scene);
    scene.0.finish(root).expect("the scenes are sound")
}

struct Scene(GraphBuilder);

impl Scene {
    fn primitive(&mut self, kind: PrimitiveKind) -> NodeId {
        self.0.primitive(kind, [])
    }

    /// `T₁ T₂ … body`, the first transformation outermost.
    fn mapped<const N: usize>(&mut self, maps: [(TransformKind, &[f64]); N], body: NodeId) -> NodeId {
        let outward = maps.into_iter().rev();
        outward.fold(body, |body, (kind, args)| {
            self.0.transform(kind, args.iter().copied().map(Expr::from), body)
        })
    }

    fn ball(&mut self, center: [f64; 3], radius: f64) -> NodeId {
        let ball = self.primitive(Sphere);
        self.mapped([(Move, &center), (UScale, &[radius])], ball)
    }

    fn difference(&mut self, left: NodeId, right: NodeId) -> NodeId {
        self.0.operator(Difference, left, right)
    }

    /// What is below a plane that is turned and moved.
    fn half_space(&mut self, maps: &[(TransformKind, &[f64])]) -> NodeId {
        let half_space = self.primitive(HalfSpace);
        maps.iter().rev().fold(half_space, |body, map| self.mapped([*map], body))
    }
}

/// Two unit balls at a distance of 1.6.
fn lens(scene: &mut Scene) -> NodeId {
    let [low, high] = [-0.8, 0.8].map(|z| scene.ball([0.0, 0.0, z], 1.0));
    scene.0.operator(Intersection, low, high)
}

fn shaved(scene: &mut Scene) -> NodeId {
    let cube = scene.primitive(Cube);
    let slab = scene.mapped([(Move, &[0.0, 0.0, 1.0]), (Scale, &[2.0, 2.0, 0.7])], cube);
    scene.difference(cube, slab)
}

fn halved(scene: &mut Scene) -> NodeId {
    let cube = scene.primitive(Cube);
    let lower = scene.half_space(&[(Move, &[0.0, 0.0, 0.2])]);
    scene.difference(cube, lower)
}

fn halved_and_turned(scene: &mut Scene) -> NodeId {
    let halved = halved(scene);
    let cube = scene.primitive(Cube);
    let turned = scene.mapped([(RotY, &[30.0])], halved);
    scene.0.operator(Intersection, cube, turned)
}

fn bitten(scene: &mut Scene) -> NodeId {
    let apple = scene.ball([0.0; 3], 1.0);
    let bites = [[1.1, 0.0, 0.2], [0.1, 0.9, 0.7]].map(|at| scene.ball(at, 0.7));
    let bites = scene.0.union(bites);
    scene.difference(apple, bites)
}

fn drilled(scene: &mut Scene) -> NodeId {
    let cube = scene.primitive(Cube);
    let block = scene.mapped([(Scale, &[1.0, 0.7, 0.5])], cube);
    let cylinder = scene.primitive(Cylinder);
    let places: [[f64; 3]; 4] =
        [[-1.0, 0.0, -2.0], [-0.95, 0.55, -2.0], [-0.95, -0.55, -2.0], [0.5, 0.0, -2.0]];
    let holes = places.map(|at| scene.mapped([(Move, &at), (Scale, &[0.4, 0.4, 4.0])], cylinder));
    let holes = scene.0.union(holes);
    let drilled = scene.difference(block, holes);
    let across =
        scene.mapped([(RotX, &[90.0]), (Move, &[0.9, 0.0, -2.0]), (Scale, &[0.6, 0.6, 4.0])], cylinder);
    scene.difference(drilled, across)
}

/// A \ (B \ (C \ D)): balls along a line.
fn nested(scene: &mut Scene) -> NodeId {
    let mut solid = scene.ball([0.9, 0.3, 0.0], 0.5);
    for (x, radius) in [(0.8, 0.7), (0.7, 0.9), (0.0, 1.0)] {
        let ball = scene.ball([x, 0.0, 0.0], radius);
        solid = scene.difference(ball, solid);
    }
    solid
}

/// The scene of that name, of which a tilted half-space leaves less than half.
fn cheese(n: u32) -> Graph {
    let mut scene = Scene(GraphBuilder::new());
    let n = scene.0.param("n", n.into());
    let holes = scene.0.symbol("HO");
    let ball = scene.ball([0.0; 3], 1.07);
    let steps = [-2.0 / 3.0, 0.0, 2.0 / 3.0];
    let all = steps.into_iter().flat_map(|x| steps.into_iter().flat_map(move |y| steps.map(|z| [x, y, z])));
    let cells = all.filter(|at| at.iter().filter(|step| **step == 0.0).count() < 2);
    let cells =
        cells.map(|at| scene.mapped([(Move, &at), (UScale, &[1.0 / 3.0])], holes)).collect::<Vec<_>>();
    let cells = scene.0.union(cells);
    let smaller = scene.0.calculate([(n, Expr::from(n) - 1.0)], cells);
    let both = scene.0.operator(Operator::Union, ball, smaller);
    scene.0.rules(holes, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [ball, both]);
    let cube = scene.primitive(Cube);
    let cheese = scene.difference(cube, holes);
    let corner = scene.half_space(&[(Move, &[0.0, 0.0, -0.4]), (RotX, &[20.0])]);
    let cut = scene.0.operator(Intersection, cheese, corner);
    scene.0.finish(cut).expect("the scene is sound")
}
