//! Random recursive solids that are hard to bound.
//!
//! A graph is one symbol or two that lead to each other. Each rule is a random solid with some copies of the next symbol
//! in it, moved, turned, sheared and scaled: to between 10⁻⁶ and 10⁶ of their size over all levels, of which there are up
//! to 200. Random solids are made with all primitives, transformations and operators, parts from 10⁻⁶ to 10⁶ and
//! offsets as large, thin and flat things, near-singular maps. Four parameters are live: the level, a phase that says how
//! much a branch is turned, a width that shrinks with every level, and a count for rows of solids within a
//! level. Some of what copies are moved and turned by is drawn anew at each level, with the level for a seed: so chance makes no
//! more states.

use csg_graph::{
    AttributeTerm, Binary, Expr, Function, Graph, GraphBuilder, NodeId, Operator, ParamId, PrimitiveKind,
    TransformKind,
};
use glam::{DMat3, DVec3};

use super::random::Random;

use TransformKind::{FlipXy, FlipXz, FlipYz, Matrix, Move, Rot, RotX, RotY, RotZ, Scale, Shear, UScale};

/// The most levels.
const DEEPEST: f64 = 200.0;

/// The most that a chain enlarges or reduces from the first level to the last.
const RATIO: f64 = 1e6;

/// A random graph. All of them are sound.
pub(crate) fn graph(random: &mut Random) -> Graph {
    let levels = random.magnitude(1.0, DEEPEST + 1.0).floor().min(DEEPEST);
    let mut builder = GraphBuilder::new();
    let n = builder.param("n", levels);
    let phase = builder.param("phase", 0.0);
    let width = builder.param("width", random.between(0.2, 1.0));
    let count = builder.param("count", 2.0);
    let factor = libm::pow(random.magnitude(1.0 / RATIO, RATIO), 1.0 / levels);
    let mut maker = Maker { builder, n, phase, width, count, factor, levels, sites: 0, random };
    let root = maker.symbols();
    maker.builder.finish(root).expect("the maker makes sound graphs")
}

struct Maker<'a> {
    builder: GraphBuilder,
    n: ParamId,
    phase: ParamId,
    width: ParamId,
    count: ParamId,
    /// By how much each level is larger than the one above.
    factor: f64,
    levels: f64,
    /// How many random numbers a level draws.
    sites: u32,
    random: &'a mut Random,
}

impl Maker<'_> {
    /// One symbol or two, each with a rule that recurses and one that ends.
    fn symbols(&mut self) -> NodeId {
        let names = if self.random.chance(0.3) { vec!["X", "Y"] } else { vec!["X"] };
        let symbols: Vec<NodeId> = names.iter().map(|name| self.builder.symbol(name)).collect();
        for (i, symbol) in symbols.iter().enumerate() {
            let next = symbols[(i + 1) % symbols.len()];
            let step = self.step(next);
            let base = self.solid(2);
            let selection = Expr::choose(Expr::from(self.n).gt(0.0), 1.0, 2.0);
            self.builder.rules(*symbol, Some(selection), [step, base]);
        }
        let start = symbols[0];
        if self.random.chance(0.3) { self.transformed(start) } else { start }
    }

    /// Copies of the next level, and something else.
    fn step(&mut self, next: NodeId) -> NodeId {
        let copies = 1 + self.random.below(3);
        let mut parts: Vec<NodeId> = (0..copies).map(|_| self.copy(next)).collect();
        if self.random.chance(0.8) {
            let other = self.solid(3);
            let at = self.random.below(parts.len() + 1);
            parts.insert(at, other);
        }
        let all = self.builder.union(parts);
        match self.random.below(8) {
            0 => self.cut(all),
            1 => {
                let bite = self.solid(1);
                self.builder.operator(Operator::Difference, all, bite)
            }
            2 => {
                // Something about as large as what it cuts, so that something is left.
                let mould = self.primitive();
                let size = Expr::from(self.random.magnitude(1.0, 10.0));
                let mould = self.builder.transform(UScale, [size], mould);
                let operands = if self.random.chance(0.5) { [all, mould] } else { [mould, all] };
                self.builder.operator(Operator::Intersection, operands[0], operands[1])
            }
            _ => all,
        }
    }

    /// One copy of the next level in its place.
    fn copy(&mut self, next: NodeId) -> NodeId {
        let turn = Expr::from(self.random.between(-180.0, 180.0));
        let mut maps: Vec<(TransformKind, Vec<f64>)> = Vec::new();
        if self.random.chance(0.7) {
            let angle = self.random.between(-180.0, 180.0);
            maps.push((self.random.pick(&[RotX, RotY, RotZ]), vec![angle]));
        }
        if self.random.chance(0.3) {
            maps.push((self.random.pick(&[FlipXy, FlipXz, FlipYz]), vec![]));
        }
        if self.random.chance(0.3) {
            maps.push((Shear, (0..6).map(|_| self.random.between(-0.5, 0.5)).collect()));
        }
        if self.random.chance(0.2) {
            maps.push((Scale, (0..3).map(|_| self.random.magnitude(0.5, 2.0)).collect()));
        }
        // What these do over all levels is undone, but for the factor.
        let linear = maps.iter().fold(DMat3::IDENTITY, |product, (kind, args)| {
            let map = kind.evaluate(args).map_or(DMat3::IDENTITY, |map| map.to_affine().matrix3);
            product * map
        });
        maps.push((UScale, vec![self.factor / self.growth(linear)]));
        if self.random.chance(0.9) {
            maps.insert(0, (Move, (0..3).map(|_| self.random.between(-1.5, 1.5)).collect()));
        }
        let phase = Expr::from(self.phase);
        let mut node = if self.random.chance(0.3) {
            self.builder.transform(RotZ, [Expr::binary(Binary::Multiply, phase.clone(), turn)], next)
        } else {
            next
        };
        for (kind, args) in maps.into_iter().rev() {
            let is_drawn = matches!(kind, Move | RotX | RotY | RotZ) && self.random.chance(0.3);
            let args: Vec<Expr> =
                args.into_iter().map(|arg| if is_drawn { self.drawn(arg) } else { arg.into() }).collect();
            node = self.builder.transform(kind, args, node);
        }
        // Phases recombine: there are three of them, in whatever order the branches come.
        let shift = 1.0 + self.random.below(2) as f64;
        let phase = Expr::binary(Binary::Remainder, phase + shift, 3.0);
        let thinner = Expr::binary(Binary::Multiply, self.width, 0.98);
        let down = (self.n, Expr::from(self.n) - 1.0);
        self.builder.calculate([down, (self.phase, phase), (self.width, thinner)], node)
    }

    /// Somewhere about a number, at each level elsewhere.
    fn drawn(&mut self, about: f64) -> Expr {
        self.sites += 1;
        let spread = self.random.pick(&[0.0, 1e-12, 0.5]);
        let range = [about - spread, about + spread].map(Expr::from);
        Expr::draw(Function::Rand, self.n, self.sites, range)
    }

    /// How much a map enlarges at each of as many levels as there are.
    fn growth(&self, linear: DMat3) -> f64 {
        let (mut power, mut logarithm) = (DMat3::IDENTITY, 0.0);
        let mut left = self.levels;
        while left > 0.0 {
            power = linear * power;
            let size = power.to_cols_array().iter().fold(0.0, |size: f64, x| size.max(x.abs()));
            power *= size.recip();
            logarithm += libm::log(size);
            left -= 1.0;
        }
        libm::exp(logarithm / self.levels)
    }

    /// A solid without recursion, of up to 2^`depth` primitives.
    fn solid(&mut self, depth: usize) -> NodeId {
        if depth == 0 {
            let primitive = self.primitive();
            return if self.random.chance(0.7) { self.transformed(primitive) } else { primitive };
        }
        let solid = match self.random.below(10) {
            0 | 1 => self.solid(depth - 1),
            2..=5 => {
                let [left, right] = [0; 2].map(|_| self.solid(depth - 1));
                self.builder.union([left, right])
            }
            6 => {
                // A part in common with itself elsewhere, since two random solids seldom have anything.
                let left = self.solid(depth - 1);
                let right = self.nudged(left);
                self.builder.operator(Operator::Intersection, left, right)
            }
            7 => {
                let left = self.solid(depth - 1);
                let right = if self.random.chance(0.5) { self.nudged(left) } else { self.solid(depth - 1) };
                self.builder.operator(Operator::Difference, left, right)
            }
            8 => {
                let body = self.solid(depth - 1);
                self.cut(body)
            }
            _ => self.row(depth - 1),
        };
        if self.random.chance(0.5) { self.transformed(solid) } else { solid }
    }

    /// One solid again and again, each time moved and coloured: a recursion of its own, inside of the other.
    fn row(&mut self, depth: usize) -> NodeId {
        let symbol = self.builder.symbol("ROW");
        let last = self.solid(depth);
        let more = self.transformed(symbol);
        let fewer = self.builder.calculate([(self.count, Expr::from(self.count) - 1.0)], more);
        let both = self.builder.union([last, fewer]);
        let selection = Expr::choose(Expr::from(self.count).gt(0.0), 1.0, 2.0);
        self.builder.rules(symbol, Some(selection), [both, last]);
        let coloured = self.builder.attribute(AttributeTerm::COLOR.map(|term| (term, 0.5.into())), symbol);
        self.builder.calculate([(self.count, 3.0.into())], coloured)
    }

    /// What is in a half-space, or what is not.
    fn cut(&mut self, body: NodeId) -> NodeId {
        let half_space = self.builder.primitive(PrimitiveKind::HalfSpace, []);
        let up = Expr::from(self.random.between(-0.7, 0.7));
        let mut turned = self.builder.transform(Move, [0.0.into(), 0.0.into(), up], half_space);
        for kind in [RotX, RotY] {
            let angle = Expr::from(self.random.between(-180.0, 180.0));
            turned = self.builder.transform(kind, [angle], turned);
        }
        let operator = self.random.pick(&[Operator::Intersection, Operator::Difference]);
        self.builder.operator(operator, body, turned)
    }

    fn nudged(&mut self, body: NodeId) -> NodeId {
        let angle = Expr::from(self.random.between(-60.0, 60.0));
        let turned = self.builder.transform(RotX, [angle], body);
        let offset = [0; 3].map(|_| Expr::from(self.random.between(-0.4, 0.4)));
        self.builder.transform(Move, offset, turned)
    }

    /// Under one T-node or two, of any kind and any size.
    fn transformed(&mut self, body: NodeId) -> NodeId {
        let mut node = body;
        for _ in 0..=self.random.below(2) {
            let (kind, args) = self.map();
            // What happens to be singular is left out.
            if kind.evaluate(&args).is_some() {
                node = self.builder.transform(kind, args.into_iter().map(Expr::from), node);
            }
        }
        node
    }

    fn map(&mut self) -> (TransformKind, Vec<f64>) {
        let random = &mut *self.random;
        let extreme = random.chance(0.2);
        let [small, large] = if extreme { [1.0 / RATIO, RATIO] } else { [0.3, 3.0] };
        let number = |random: &mut Random| random.sign() * random.magnitude(small, large);
        match random.below(8) {
            0 | 1 => (Move, (0..3).map(|_| number(random)).collect()),
            2 => (Scale, (0..3).map(|_| number(random)).collect()),
            3 => (UScale, vec![number(random)]),
            4 => (random.pick(&[RotX, RotY, RotZ]), vec![random.between(-360.0, 360.0)]),
            5 => {
                let axis = [0; 3].map(|_| random.between(-1.0, 1.0));
                (Rot, axis.into_iter().chain([random.between(-360.0, 360.0)]).collect())
            }
            6 => (
                Shear,
                (0..6).map(|_| if extreme { number(random) } else { random.between(-1.0, 1.0) }).collect(),
            ),
            _ => {
                // Rows that are all but parallel, if extreme.
                let row = DVec3::from_array([0; 3].map(|_| number(random)));
                let spread = if extreme { random.magnitude(1e-6, 1.0) } else { 1.0 };
                let mut args = Vec::new();
                for _ in 0..3 {
                    let other = DVec3::from_array([0; 3].map(|_| random.between(-1.0, 1.0)));
                    let row = row + spread * row.length() * other;
                    args.extend(row.to_array());
                    args.push(number(random));
                }
                (Matrix, args)
            }
        }
    }

    fn primitive(&mut self) -> NodeId {
        let kind = self.random.pick(PrimitiveKind::ALL);
        let kind = if kind == PrimitiveKind::HalfSpace { PrimitiveKind::Torus } else { kind };
        let (width, count) = (Expr::from(self.width), Expr::from(self.count));
        let args: Vec<Expr> = match kind {
            PrimitiveKind::Frustum if self.random.chance(0.5) => {
                vec![Expr::binary(Binary::Multiply, width, count + 1.0)]
            }
            PrimitiveKind::Frustum => vec![self.random.magnitude(1e-6, 1e6).into()],
            PrimitiveKind::Torus if self.random.chance(0.5) => vec![width],
            PrimitiveKind::Torus => vec![self.random.magnitude(1e-6, 1.0).into()],
            PrimitiveKind::Hull => {
                let points = 4 + self.random.below(6);
                let flat = self.random.magnitude(1e-6, 1.0);
                let size = DVec3::new(1.0, self.random.magnitude(0.01, 1.0), flat);
                let point =
                    |random: &mut Random| DVec3::from_array([0; 3].map(|_| random.between(-1.0, 1.0))) * size;
                (0..points).flat_map(|_| point(self.random).to_array()).map(Expr::from).collect()
            }
            _ => vec![],
        };
        self.builder.primitive(kind, args)
    }
}
