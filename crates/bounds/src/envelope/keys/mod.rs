//! Keys: the states of a graph without what varies, each once, and the edges between them.
//!
//! A key is a node with the values of the exact parameters that matter there. All states that have the same key in common
//! have the same keys below them, and differ in the intervals of varying parameters alone. There are few: of a random
//! tree, as many as of the same tree without chance. Where there are too many after all, the exact parameter with the most
//! values is declared to vary, and they are collected anew.
//!
//! Keys are numbered as a depth-first search leaves them: each has a higher number than those below it, unless they lead
//! back to it.

mod look;
mod numbers;

use std::ops::Range;

use csg_graph::{
    Env, Expr, Graph, Interval, Node, NodeId, Operator, ParamId, PrimitiveKind, Residual, State,
    TransformKind,
};
use rustc_hash::FxHashSet;

use super::body::Body;
use super::control::Control;
use super::primitive;
use super::transform::MapRange;
use crate::Scene;
use crate::narrow::index;
pub(super) use look::Look;
use look::rules;
use numbers::Numbers;

/// All keys below a root.
pub(super) struct Keys {
    control: Control,
    /// What an environment starts from: constants, and all numbers for whatever does not matter.
    values: Vec<Interval>,
    keys: Vec<(NodeId, Env)>,
    root: u32,
    numbers: Numbers,
    nodes: Vec<KeyNode>,
    /// The keys below all keys.
    below: Vec<u32>,
    solids: Vec<Body>,
    maps: Vec<MapRange>,
    /// What varying parameters make of each other, given in the order of [`Control::varying`].
    residuals: Vec<Residual>,
    /// The places of the parameters that these are assigned to, those of C-nodes.
    targets: Vec<usize>,
    /// By key, whether several ways lead to it, or one from below.
    shared: Vec<bool>,
}

/// A key's node, without what varies in it.
#[derive(Clone)]
struct KeyNode {
    kind: Kind,
    below: Range<u32>,
    /// Of its expressions that depend on what varies.
    residuals: Range<u32>,
}

#[derive(Clone, Copy)]
enum Kind {
    /// A union of any number.
    Join,
    Meet,
    Difference,
    /// The index of a known solid, or of known maps.
    Solid(u32),
    Map(u32),
    /// Those that depend on what varies: all rules of a symbol, the assignments of a C-node, maps, a primitive.
    Choose,
    Calculate,
    Transform(TransformKind),
    Primitive(PrimitiveKind),
}

/// The most keys that are passed at one time.
const PASSED: usize = 16;

impl Keys {
    /// The keys below the root of a graph, at most `limit` if any parameter is exact.
    pub(super) fn new(graph: &Graph, limit: usize) -> Self {
        let mut inexact = Vec::new();
        loop {
            match Self::explore(graph, Control::new(graph, &inexact), limit) {
                Ok(keys) => return keys,
                Err(most_values) => inexact.push(most_values),
            }
        }
    }

    /// The keys, or the exact parameter with the most values if there are too many.
    fn explore(graph: &Graph, control: Control, limit: usize) -> Result<Self, ParamId> {
        let mut values: Vec<Interval> = graph
            .params()
            .map(|param| graph.initial().get(param).map_or(Interval::EMPTY, Interval::point))
            .collect();
        control.assigned().iter().for_each(|param| values[param.index()] = Interval::ALL);
        let mut found = Self {
            numbers: Numbers::new(graph, &control),
            control,
            values,
            keys: Vec::new(),
            root: 0,
            nodes: Vec::new(),
            below: Vec::new(),
            solids: Vec::new(),
            maps: Vec::new(),
            residuals: Vec::new(),
            targets: Vec::new(),
            shared: Vec::new(),
        };
        let root = found.enter((graph.root(), graph.initial().clone()));
        let mut path = vec![(root, found.open(graph, root))];
        // Until all have numbers, they go by the order in which they were entered.
        let mut left = Vec::new();
        while let Some((key, edges)) = path.last_mut() {
            if let Some(edge) = edges.next() {
                let below = found.below[edge as usize];
                if !found.nodes[below as usize].opened() {
                    let edges = found.open(graph, below);
                    path.push((below, edges));
                }
            } else {
                left.push(*key);
                path.pop();
            }
            if found.keys.len() > limit
                && let Some(most_values) = found.most_values()
            {
                return Err(most_values);
            }
        }
        found.renumber(&left);
        Ok(found)
    }

    /// Registers a key, if it is new.
    fn enter(&mut self, state: (NodeId, Env)) -> u32 {
        let (node, mut env) = state;
        self.normalise(node, &mut env);
        let fresh = index(self.keys.len());
        let key = self.numbers.get_or_insert(node, &env, fresh);
        if key == fresh {
            self.keys.push((node, env));
            self.nodes.push(KeyNode::UNOPENED);
        }
        key
    }

    /// Blanks what is not exact or does not matter.
    fn normalise(&self, node: NodeId, env: &mut Env) {
        for param in self.control.assigned() {
            let kept = self.control.is_exact(*param) && self.control.matters(node, *param);
            if !kept && env.get(*param).is_some() {
                env.blank(*param);
            }
        }
    }

    /// Looks at the node of a key. Its edges are where the search goes on.
    fn open(&mut self, graph: &Graph, key: u32) -> Range<u32> {
        let (id, env) = self.keys[key as usize].clone();
        let mut values = self.fixed(&env);
        let start = index(self.residuals.len());
        let node = graph.node(id);
        let varies = self.control.varies_in(node.exprs());
        let ranges = || node.exprs().into_iter().map(|expr| expr.range(&values)).collect::<Vec<_>>();
        let children = node.children();
        let (kind, children) = match node {
            Node::Symbol(symbol) if symbol.selection.is_some() && varies => (Kind::Choose, children),
            Node::Symbol(symbol) => {
                let rules = ranges().first().map_or(0..1, |value| rules(*value, symbol.rules.len()));
                (Kind::Join, &children[rules])
            }
            Node::Calculation(node) => {
                let mut env = env.clone();
                let mut sound = true;
                for (param, expr) in &node.assignments {
                    if self.control.is_exact(*param) {
                        env.set(*param, expr.evaluate(&env));
                        sound &= env.get(*param).is_some() || !self.control.matters(node.body, *param);
                        // For the assignments that follow.
                        values[param.index()] = expr.range(&values);
                    } else if let Some(place) = self.control.place(*param) {
                        self.leave(expr, &values, place);
                    }
                }
                let changes = start < index(self.residuals.len());
                let kind = if changes { Kind::Calculate } else { Kind::Join };
                let below = sound.then(|| self.enter((node.body, env)));
                return self.opened(key, kind, below.as_slice(), start);
            }
            Node::Transformation(node) if varies => (Kind::Transform(node.kind), children),
            Node::Transformation(node) => match MapRange::new(node.kind, &ranges()) {
                Some(maps) => {
                    self.maps.push(maps);
                    (Kind::Map(index(self.maps.len() - 1)), children)
                }
                None => (Kind::Join, &[][..]),
            },
            Node::Primitive(node) if varies => (Kind::Primitive(node.kind), children),
            Node::Primitive(node) => {
                self.solids.push(primitive::body(node.kind, &ranges()));
                (Kind::Solid(index(self.solids.len() - 1)), children)
            }
            Node::Attribute(_) => (Kind::Join, children),
            Node::Operator(node) => match node.operator {
                Operator::Union => (Kind::Join, children),
                Operator::Intersection => (Kind::Meet, children),
                Operator::Difference => (Kind::Difference, children),
            },
            _ => unreachable!("the two crates know the same kinds of nodes"),
        };
        if matches!(kind, Kind::Choose | Kind::Transform(_) | Kind::Primitive(_)) {
            node.exprs().into_iter().for_each(|expr| self.leave(expr, &values, usize::MAX));
        }
        let below: Vec<u32> = children.iter().map(|child| self.enter((*child, env.clone()))).collect();
        self.opened(key, kind, &below, start)
    }

    /// The intervals of all parameters that do not vary.
    fn fixed(&self, env: &Env) -> Vec<Interval> {
        let mut values = self.values.clone();
        for param in self.control.exact() {
            if let Some(value) = env.get(*param) {
                values[param.index()] = Interval::point(value);
            }
        }
        values
    }

    /// Leaves of an expression what depends on varying parameters, and where the result belongs among these.
    fn leave(&mut self, expr: &Expr, values: &[Interval], target: usize) {
        self.residuals.push(expr.residual(values, |param| self.control.place(param)));
        self.targets.push(target);
    }

    /// The residuals are all from `start` on.
    fn opened(&mut self, key: u32, kind: Kind, below: &[u32], start: u32) -> Range<u32> {
        let residuals = start..index(self.residuals.len());
        let start = index(self.below.len());
        self.below.extend(below);
        let below = start..index(self.below.len());
        self.nodes[key as usize] = KeyNode { kind, below: below.clone(), residuals };
        below
    }

    /// The exact parameter with the most values; of several, the one declared last.
    fn most_values(&self) -> Option<ParamId> {
        let values = |param: ParamId| {
            let values = self.keys.iter().filter_map(|(_, env)| env.get(param));
            values.map(f64::to_bits).collect::<FxHashSet<_>>().len()
        };
        self.control.exact().iter().copied().max_by_key(|param| values(*param))
    }

    /// Gives the keys, which went by the order in which they were entered, the order in which they were left.
    fn renumber(&mut self, left: &[u32]) {
        let mut numbers = vec![0; left.len()];
        for (number, entered) in left.iter().enumerate() {
            numbers[*entered as usize] = index(number);
        }
        self.keys = left.iter().map(|entered| self.keys[*entered as usize].clone()).collect();
        self.nodes = left.iter().map(|entered| self.nodes[*entered as usize].clone()).collect();
        self.below.iter_mut().for_each(|key| *key = numbers[*key as usize]);
        self.root = numbers[0];
        self.numbers.renumber(&numbers);
        // Whatever leads to a key that is nothing but another one leads to that.
        let ends: Vec<u32> = (0..index(left.len())).map(|key| self.end(key)).collect();
        self.root = ends[self.root as usize];
        self.below.iter_mut().for_each(|key| *key = ends[*key as usize]);
        self.numbers.renumber(&ends);
        self.shared = self.shared();
    }

    /// Whether several ways lead to a key, or one from below.
    fn shared(&self) -> Vec<bool> {
        let (mut reached, mut shared) = (vec![false; self.len()], vec![false; self.len()]);
        for key in 0..index(self.len()) {
            for below in self.parts(key) {
                let again = std::mem::replace(&mut reached[*below as usize], true);
                shared[*below as usize] |= again || *below >= key;
            }
        }
        shared
    }

    /// Where a key leads that is nothing but another one, or a few steps on the way there.
    fn end(&self, mut key: u32) -> u32 {
        for _ in 0..PASSED {
            let KeyNode { kind, below, .. } = &self.nodes[key as usize];
            if !matches!(kind, Kind::Join) || below.len() != 1 {
                break;
            }
            key = self.below[below.start as usize];
        }
        key
    }

    pub(super) fn root(&self) -> u32 {
        self.root
    }

    pub(super) fn len(&self) -> usize {
        self.keys.len()
    }

    /// About how much memory this holds.
    pub(super) fn bytes(&self) -> usize {
        let key = size_of::<(NodeId, Env)>() + self.values.len() * size_of::<f64>() + 2 * size_of::<usize>();
        self.keys.len() * (key + size_of::<KeyNode>())
            + self.numbers.bytes()
            + self.below.len() * size_of::<u32>()
            + self.solids.len() * size_of::<Body>()
            + self.maps.len() * size_of::<MapRange>()
            + self.residuals.iter().map(|residual| residual.bytes() + size_of::<usize>()).sum::<usize>()
    }

    pub(super) fn control(&self) -> &Control {
        &self.control
    }

    /// What keys are called in messages, of symbols alone.
    pub(super) fn labels(&self, graph: &Graph, keys: &[u32]) -> Vec<String> {
        let states = keys.iter().map(|key| &self.keys[*key as usize]);
        let symbols = states.filter(|(node, _)| matches!(graph.node(*node), Node::Symbol(_)));
        symbols.map(|(node, env)| graph.label(&graph.state(*node, env.clone()))).collect()
    }

    /// The key of a state, or `None` if the root does not lead to it.
    pub(super) fn number(&self, state: &State) -> Option<u32> {
        self.numbers.get(state.node(), state.env())
    }

    pub(super) fn node(&self, key: u32) -> NodeId {
        self.keys[key as usize].0
    }

    /// Whether what is below depends on the values of varying parameters.
    pub(super) fn varies(&self, key: u32) -> bool {
        self.control.varies(self.node(key))
    }

    /// The keys that the solid of a key is made of, whatever varies. What is subtracted is not one of them.
    pub(super) fn parts(&self, key: u32) -> &[u32] {
        let node = &self.nodes[key as usize];
        let below = &self.below[node.below.start as usize..node.below.end as usize];
        if matches!(node.kind, Kind::Difference) { &below[..1] } else { below }
    }

    /// All keys below a key.
    pub(super) fn below(&self, key: u32) -> &[u32] {
        let Range { start, end } = self.nodes[key as usize].below;
        &self.below[start as usize..end as usize]
    }

    /// What matters at a key of the intervals of the varying parameters.
    pub(super) fn varying<'a>(
        &'a self,
        key: u32,
        varying: &'a [Interval],
    ) -> impl Iterator<Item = Interval> + 'a {
        let node = self.node(key);
        self.control.varying().iter().zip(varying).map(move |(param, interval)| {
            if self.control.matters(node, *param) { *interval } else { Interval::ALL }
        })
    }

    /// Whether several ways lead to a key, or one from below.
    pub(super) fn is_shared(&self, key: u32) -> bool {
        self.shared[key as usize]
    }

    pub(super) fn solid(&self, number: u32) -> &Body {
        &self.solids[number as usize]
    }

    pub(super) fn map(&self, number: u32) -> &MapRange {
        &self.maps[number as usize]
    }

    /// Whether what is below a key sees other values than the key itself.
    pub(super) fn changes(&self, key: u32) -> bool {
        matches!(self.nodes[key as usize].kind, Kind::Calculate)
    }
}

impl KeyNode {
    const UNOPENED: Self =
        Self { kind: Kind::Join, below: Range { start: u32::MAX, end: 0 }, residuals: 0..0 };

    fn opened(&self) -> bool {
        self.below.start <= self.below.end
    }
}
