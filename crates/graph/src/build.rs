//! Making graphs in Rust: trees, dags and cyclic graphs, without any text.

use rustc_hash::FxHashMap;

use crate::liveness::Liveness;
use crate::node::{
    AttributeNode, AttributeTerm, Calculation, OperatorNode, PrimitiveNode, Symbol, Transformation,
};
use crate::validate::{self, GraphError};
use crate::{
    Env, Expr, Graph, Node, NodeId, Operator, ParamId, Primitive, PrimitiveKind, Transform, TransformKind,
};

/// Collects nodes and parameters, and [finishes](Self::finish) them into a [`Graph`].
///
/// Nodes are made from the leaves up. A node may be used more than once, which makes a dag; cycles go through symbols,
/// which are declared first and get their rules later.
///
/// ```
/// use csg_graph::{Expr, GraphBuilder, Operator, PrimitiveKind, TransformKind};
///
/// // CT if(n > 1, 2, 1)
/// // 1: CT -> cone
/// // 2: CT -> cone | {n = n-1} move(0, 0, 0.6) uscale(0.8) CT
/// let mut builder = GraphBuilder::new();
/// let n = builder.param("n", 20.0);
/// let tower = builder.symbol("CT");
/// let cone = builder.primitive(PrimitiveKind::Cone, []);
/// let smaller = builder.transform(TransformKind::UScale, [0.8.into()], tower);
/// let raised = builder.transform(TransformKind::Move, [0.0, 0.0, 0.6].map(Expr::from), smaller);
/// let rest = builder.calculate([(n, Expr::from(n) - 1.0)], raised);
/// let both = builder.operator(Operator::Union, cone, rest);
/// builder.rules(tower, Some(Expr::choose(Expr::from(n).gt(1.0), 2.0, 1.0)), [cone, both]);
/// let graph = builder.finish(tower)?;
///
/// assert_eq!(graph.analyse(&Default::default())?.primitives.to_string(), "20");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct GraphBuilder {
    nodes: Vec<Node>,
    params: Vec<String>,
    by_name: FxHashMap<String, ParamId>,
    initial: Env,
}

impl Default for GraphBuilder {
    fn default() -> Self {
        Self { nodes: Vec::new(), params: Vec::new(), by_name: FxHashMap::default(), initial: Env::unset(0) }
    }
}

impl GraphBuilder {
    /// No nodes, no parameters.
    pub fn new() -> Self {
        Self::default()
    }

    /// Declares a parameter with its initial value; not a number leaves it unset. A second declaration of a name sets
    /// the value again.
    pub fn param(&mut self, name: &str, value: f64) -> ParamId {
        let param = self.declare(name);
        self.initial.set(param, value);
        param
    }

    /// The parameter of that name, declared without a value if it is new.
    pub fn declare(&mut self, name: &str) -> ParamId {
        if let Some(param) = self.find_param(name) {
            return param;
        }
        let param = ParamId::from_index(self.params.len());
        self.params.push(name.to_owned());
        self.by_name.insert(name.to_owned(), param);
        self.initial.extend();
        param
    }

    /// The parameter of that name.
    pub fn find_param(&self, name: &str) -> Option<ParamId> {
        self.by_name.get(name).copied()
    }

    /// The initial values so far.
    pub fn initial(&self) -> &Env {
        &self.initial
    }

    /// Declares a symbol. Its [rules](Self::rules) follow.
    pub fn symbol(&mut self, name: &str) -> NodeId {
        self.push(Node::Symbol(Symbol { name: name.to_owned(), selection: None, rules: Vec::new() }))
    }

    /// Gives a symbol its selection function and its rules, numbered from 1.
    ///
    /// # Panics
    /// If `symbol` is no symbol of this builder.
    pub fn rules(
        &mut self,
        symbol: NodeId,
        selection: Option<Expr>,
        rules: impl IntoIterator<Item = NodeId>,
    ) {
        let Node::Symbol(node) = &mut self.nodes[symbol.index()] else { panic!("{symbol:?} is no symbol") };
        node.selection = selection;
        node.rules = rules.into_iter().collect();
    }

    /// A C-node.
    pub fn calculate(
        &mut self,
        assignments: impl IntoIterator<Item = (ParamId, Expr)>,
        body: NodeId,
    ) -> NodeId {
        self.push(Node::Calculation(Calculation { assignments: assignments.into_iter().collect(), body }))
    }

    /// The C-node `{seed = derive(seed, position)}`: what is below it draws other random numbers than what is above it, and
    /// others than what is below such a node with another position.
    ///
    /// ```
    /// use csg_graph::{Expr, Function, GraphBuilder, PrimitiveKind, TransformKind};
    ///
    /// // {} BALL | move(3, 0, 0) BALL
    /// // BALL -> uscale(rand(0.5, 1)) sphere
    /// let mut builder = GraphBuilder::new();
    /// let seed = builder.param("seed", 0.0);
    /// let ball = builder.symbol("BALL");
    /// let sphere = builder.primitive(PrimitiveKind::Sphere, []);
    /// let radius = Expr::draw(Function::Rand, seed, 1, [0.5.into(), 1.0.into()]);
    /// let rule = builder.transform(TransformKind::UScale, [radius], sphere);
    /// builder.rules(ball, None, [rule]);
    /// let first = builder.reseed(seed, 1, ball);
    /// let second = builder.reseed(seed, 2, ball);
    /// let aside = builder.transform(TransformKind::Move, [3.0, 0.0, 0.0].map(Expr::from), second);
    /// let both = builder.union([first, aside]);
    /// let graph = builder.finish(both)?;
    ///
    /// assert_eq!(graph.analyse(&Default::default())?.states, 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn reseed(&mut self, seed: ParamId, position: u32, body: NodeId) -> NodeId {
        self.calculate([(seed, Expr::derive(seed, position))], body)
    }

    /// A T-node.
    ///
    /// # Panics
    /// If there are more or fewer arguments than the transformation takes.
    pub fn transform(
        &mut self,
        kind: TransformKind,
        args: impl IntoIterator<Item = Expr>,
        body: NodeId,
    ) -> NodeId {
        let args: Vec<_> = args.into_iter().collect();
        assert_eq!(args.len(), kind.arity(), "arguments of {}", kind.signature());
        self.push(Node::Transformation(Transformation { kind, args, body, constant: None }))
    }

    /// An attribute node.
    pub fn attribute(
        &mut self,
        terms: impl IntoIterator<Item = (AttributeTerm, Expr)>,
        body: NodeId,
    ) -> NodeId {
        self.push(Node::Attribute(AttributeNode { terms: terms.into_iter().collect(), body }))
    }

    /// An operator node.
    pub fn operator(&mut self, operator: Operator, left: NodeId, right: NodeId) -> NodeId {
        self.push(Node::Operator(OperatorNode { operator, operands: [left, right] }))
    }

    /// The union of one or more nodes, as operator nodes nested to the left.
    ///
    /// # Panics
    /// If there is no node.
    pub fn union(&mut self, operands: impl IntoIterator<Item = NodeId>) -> NodeId {
        let union = operands.into_iter().reduce(|left, right| self.operator(Operator::Union, left, right));
        union.expect("a union of at least one node")
    }

    /// A primitive node.
    ///
    /// # Panics
    /// If there are more or fewer arguments than the primitive takes.
    pub fn primitive(&mut self, kind: PrimitiveKind, args: impl IntoIterator<Item = Expr>) -> NodeId {
        let args: Vec<_> = args.into_iter().collect();
        let fits = kind.arity().map_or(args.len() % 3 == 0, |arity| args.len() == arity);
        assert!(fits, "{} arguments of {}", args.len(), kind.signature());
        self.push(Node::Primitive(PrimitiveNode { kind, args, constant: None }))
    }

    /// Validates the graph below `root`, once and for all.
    ///
    /// # Errors
    /// If a handle dangles, a symbol has no rules, a cycle passes no symbol, a constant transformation is singular, a
    /// constant primitive has no extent, a constant attribute is out of range, or a half-space is not bounded.
    pub fn finish(self, root: NodeId) -> Result<Graph, GraphError> {
        let Self { nodes, params, initial, by_name: _ } = self;
        validate::handles(&nodes, params.len(), root)?;
        let liveness = Liveness::new(&nodes, params.len());
        let mut graph = Graph { nodes, params, initial, root, liveness };
        validate::cycles(&graph)?;
        graph.fold_constants()?;
        validate::extents(&graph)?;
        Ok(graph)
    }

    fn push(&mut self, node: Node) -> NodeId {
        self.nodes.push(node);
        NodeId::from_index(self.nodes.len() - 1)
    }
}

impl Graph {
    /// Evaluates the transformations and primitives whose arguments never change, so that no later evaluation repeats
    /// them. One that fails and reads no parameter is a mistake wherever it stands, as are attributes; one that reads
    /// parameters may be in a rule that these values never select, and fails when it is reached.
    fn fold_constants(&mut self) -> Result<(), GraphError> {
        let mut errors = Vec::new();
        for index in 0..self.nodes.len() {
            let id = NodeId::from_index(index);
            let read: Vec<_> = self.nodes[index].exprs().into_iter().flat_map(|expr| expr.params()).collect();
            if read.iter().any(|param| self.liveness.is_assigned(*param)) {
                continue;
            }
            let folded = match &self.nodes[index] {
                Node::Attribute(_) if read.is_empty() => {
                    errors.extend(self.attributes(id, &self.initial).err());
                    continue;
                }
                Node::Transformation(_) => self.transform(id, &self.initial).map(Constant::Transform),
                Node::Primitive(_) => self
                    .primitive(id, &self.initial)
                    .map(|primitive| Constant::Primitive(primitive.into_owned())),
                _ => continue,
            };
            match (folded, &mut self.nodes[index]) {
                (Ok(Constant::Transform(value)), Node::Transformation(node)) => node.constant = Some(value),
                (Ok(Constant::Primitive(value)), Node::Primitive(node)) => node.constant = Some(value),
                (Err(error), _) if read.is_empty() => errors.push(error),
                _ => {}
            }
        }
        if errors.is_empty() { Ok(()) } else { Err(GraphError::Constants { errors }) }
    }
}

/// What a node is wherever it is met.
enum Constant {
    Transform(Transform),
    Primitive(Primitive),
}
