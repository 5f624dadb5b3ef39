//! Solids with random numbers in them, that several tests and benchmarks bound.

use csg_graph::{
    Expr, Function, Graph, GraphBuilder, NodeId, Operator, ParamId, PrimitiveKind, TransformKind,
};

use TransformKind::{Move, RotX, RotY, RotZ, Scale, UScale};

/// A builder that counts sites and positions.
pub(crate) struct Chance {
    pub(crate) b: GraphBuilder,
    pub(crate) seed: ParamId,
    count: u32,
}

impl Chance {
    pub(crate) fn new(seed: u32) -> Self {
        let mut b = GraphBuilder::new();
        let seed = b.param("seed", seed.into());
        Self { b, seed, count: 0 }
    }

    pub(crate) fn draw<const N: usize>(&mut self, function: Function, args: [Expr; N]) -> Expr {
        self.count += 1;
        Expr::draw(function, self.seed, self.count, args)
    }

    pub(crate) fn rand(&mut self, low: impl Into<Expr>, high: impl Into<Expr>) -> Expr {
        self.draw(Function::Rand, [low.into(), high.into()])
    }

    /// A reference to a symbol: with a seed of its own, and some parameters changed.
    pub(crate) fn refer(
        &mut self,
        symbol: NodeId,
        changes: impl IntoIterator<Item = (ParamId, Expr)>,
    ) -> NodeId {
        self.count += 1;
        let reseeded = self.b.reseed(self.seed, self.count, symbol);
        let changes: Vec<_> = changes.into_iter().collect();
        if changes.is_empty() { reseeded } else { self.b.calculate(changes, reseeded) }
    }

    pub(crate) fn map<const N: usize>(
        &mut self,
        kind: TransformKind,
        args: [Expr; N],
        body: NodeId,
    ) -> NodeId {
        self.b.transform(kind, args, body)
    }
}

fn one_less(n: ParamId) -> (ParamId, Expr) {
    (n, Expr::from(n) - 1.0)
}

fn positive(n: ParamId) -> Option<Expr> {
    Some(Expr::choose(Expr::from(n).gt(0.0), 2.0, 1.0))
}

/// A binary tree whose branches turn by chance.
pub(crate) fn tree(seed: u32, levels: u32) -> Graph {
    let mut c = Chance::new(seed);
    let n = c.b.param("n", levels.into());
    let tree = c.b.symbol("TREE");
    let cylinder = c.b.primitive(PrimitiveKind::Cylinder, []);
    let trunk = c.map(Scale, [0.06, 0.06, 1.0].map(Expr::from), cylinder);
    let branches = [30.0, -40.0].map(|mean: f64| {
        let again = c.refer(tree, [one_less(n)]);
        let factor = c.rand(0.6, 0.75);
        let small = c.map(UScale, [factor], again);
        let angle = c.rand(mean - 20.0, mean + 20.0);
        let bent = c.map(RotX, [angle], small);
        let angle = c.rand(40.0, 80.0);
        let turned = c.map(RotZ, [angle], bent);
        c.map(Move, [0.0, 0.0, 1.0].map(Expr::from), turned)
    });
    let both = c.b.union([trunk, branches[0], branches[1]]);
    c.b.rules(tree, positive(n), [trunk, both]);
    c.b.finish(tree).unwrap()
}

/// A terrain by midpoint displacement: four corners with heights, and middles of edges that are displaced by what their
/// own coordinates are hashed to, so that neighbours agree.
pub(crate) fn terrain(seed: u32, levels: u32, roughness: f64) -> Graph {
    let mut c = Chance::new(seed);
    let n = c.b.param("n", levels.into());
    let [x, y] = ["x", "y"].map(|name| c.b.param(name, 0.0));
    let corners = ["h00", "h10", "h01", "h11"].map(|name| c.b.param(name, 0.0));
    let [west, east, south, north, middle] = ["hw", "he", "hs", "hn", "hm"].map(|name| c.b.param(name, 0.0));
    let amplitude = c.b.param("a", roughness);
    let world = c.b.param("world", 11.0);
    let patch = c.b.symbol("PATCH");

    let [h00, h10, h01, h11] = corners.map(Expr::from);
    let base = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let heights = [h00.clone(), h10.clone(), h01.clone(), h11.clone()];
    let mut points: Vec<Expr> = Vec::new();
    for ([x, y], height) in base.into_iter().zip(&heights) {
        points.extend([x.into(), y.into(), height.clone()]);
        points.extend([x.into(), y.into(), height.clone() - 0.02]);
    }
    let leaf = c.b.primitive(PrimitiveKind::Hull, points);

    // A point of the finer grid is displaced by ±a.
    let displaced = |mean: Expr, dx: f64, dy: f64| {
        let place = [Expr::from(x) * 2.0 + dx, Expr::from(y) * 2.0 + dy, Expr::from(n), world.into()];
        mean + Expr::from(amplitude) * (Expr::call(Function::Hash, place) * 2.0 - 1.0)
    };
    let mean = |a: &Expr, b: &Expr| (a.clone() + b.clone()) / 2.0;
    let middles = [
        (west, displaced(mean(&h00, &h01), 0.0, 1.0)),
        (east, displaced(mean(&h10, &h11), 2.0, 1.0)),
        (south, displaced(mean(&h00, &h10), 1.0, 0.0)),
        (north, displaced(mean(&h01, &h11), 1.0, 2.0)),
        (middle, displaced(mean(&mean(&h00, &h10), &mean(&h01, &h11)), 1.0, 1.0)),
    ];
    let quarters = [
        ([0.0, 0.0], [h00, south.into(), west.into(), middle.into()]),
        ([1.0, 0.0], [south.into(), h10, middle.into(), east.into()]),
        ([0.0, 1.0], [west.into(), middle.into(), h01, north.into()]),
        ([1.0, 1.0], [middle.into(), east.into(), north.into(), h11]),
    ];
    let quarters = quarters.map(|([dx, dy], heights): ([f64; 2], [Expr; 4])| {
        // Heights are exchanged through other names, since assignments run in order.
        let copies = ["k00", "k10", "k01", "k11"].map(|name| c.b.param(name, 0.0));
        let mut changes: Vec<_> = copies.into_iter().zip(heights).collect();
        changes.extend(corners.into_iter().zip(copies.map(Expr::from)));
        changes.extend([(x, Expr::from(x) * 2.0 + dx), (y, Expr::from(y) * 2.0 + dy), one_less(n)]);
        changes.push((amplitude, Expr::from(amplitude) * 0.5));
        let again = c.refer(patch, changes);
        let small = c.map(Scale, [0.5, 0.5, 1.0].map(Expr::from), again);
        c.map(Move, [0.5 * dx, 0.5 * dy, 0.0].map(Expr::from), small)
    });
    let all = c.b.union(quarters);
    let step = c.b.calculate(middles, all);
    c.b.rules(patch, positive(n), [leaf, step]);
    c.b.finish(patch).unwrap()
}

/// Sierpinski's tetrahedron, of which at each step one part of four may be left out.
pub(crate) fn stochastic_sierpinski(seed: u32, levels: u32) -> Graph {
    let mut c = Chance::new(seed);
    let n = c.b.param("n", levels.into());
    let symbol = c.b.symbol("ST");
    let tetrahedron = c.b.primitive(PrimitiveKind::Tetrahedron, []);
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let copies = corners.map(|corner| {
        let again = c.refer(symbol, [one_less(n)]);
        let half = c.map(UScale, [0.5.into()], again);
        c.map(Move, corner.map(|x| (0.5 * x).into()), half)
    });
    let all = c.b.union(copies);
    let three = c.b.union([copies[0], copies[1], copies[3]]);
    let pick = c.draw(Function::Pick, [0.0, 1.0, 1.0].map(Expr::from));
    c.b.rules(symbol, Some(Expr::choose(Expr::from(n).gt(0.0), pick, 1.0)), [tetrahedron, all, three]);
    c.b.finish(symbol).unwrap()
}

/// A vine of balls and notches, which ends by chance after ever so many.
pub(crate) fn vine(seed: u32) -> Graph {
    let mut c = Chance::new(seed);
    let vine = c.b.symbol("VINE");
    let ball = c.b.primitive(PrimitiveKind::Sphere, []);
    let again = c.refer(vine, []);
    let factor = c.rand(0.7, 0.9);
    let small = c.map(UScale, [factor], again);
    let angle = c.draw(Function::Normal, [0.0.into(), 3.0.into()]);
    let bent = c.map(RotY, [angle], small);
    let turned = c.rand(0.0, 360.0);
    let turned = c.map(RotZ, [turned], bent);
    let height = c.rand(1.0, 1.5);
    let moved = c.map(Move, [0.0.into(), 0.0.into(), height], turned);
    let cube = c.b.primitive(PrimitiveKind::Cube, []);
    let cube = c.map(Move, [1.2, 0.0, 0.0].map(Expr::from), cube);
    let notched = c.b.operator(Operator::Difference, ball, cube);
    let both = c.b.union([notched, moved]);
    let pick = c.draw(Function::Pick, [1.0, 4.0].map(Expr::from));
    c.b.rules(vine, Some(pick), [notched, both]);
    c.b.finish(vine).unwrap()
}

/// A branch that ends when it has become thin: lengths and radii are parameters, and no transformation scales what follows.
pub(crate) fn thinning(seed: u32) -> Graph {
    let mut c = Chance::new(seed);
    let [radius, length] = [("r", 0.3), ("l", 1.0)].map(|(name, value)| c.b.param(name, value));
    let branch = c.b.symbol("BRANCH");
    let cylinder = c.b.primitive(PrimitiveKind::Cylinder, []);
    let wood = c.map(Scale, [radius.into(), radius.into(), length.into()], cylinder);
    let next = [25.0, -35.0].map(|mean: f64| {
        let thinner = c.rand(0.6, 0.8);
        let shorter = c.rand(0.7, 0.85);
        let changes = [(radius, Expr::from(radius) * thinner), (length, Expr::from(length) * shorter)];
        let again = c.refer(branch, []);
        let again = c.b.calculate(changes, again);
        let angle = c.rand(mean - 10.0, mean + 10.0);
        let bent = c.map(RotX, [angle], again);
        let turned = c.map(RotZ, [70.0.into()], bent);
        c.map(Move, [0.0.into(), 0.0.into(), length.into()], turned)
    });
    let all = c.b.union([wood, next[0], next[1]]);
    c.b.rules(branch, Some(Expr::choose(Expr::from(radius).gt(0.05), 2.0, 1.0)), [wood, all]);
    c.b.finish(branch).unwrap()
}
