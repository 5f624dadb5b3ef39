//! States, and what a node is at a state: the evaluation of S-, C- and T-nodes.
//!
//! A [`State`] is a node with the values of the parameters that are still live there. The solid below a node, in the
//! node's own frame, depends on its state alone, not on the path: two occurrences with equal states are the same solid.

use std::borrow::Cow;
use std::fmt;

use crate::node::AttributeTerm;
use crate::{Env, Expr, Graph, Node, NodeId, Number, Operator, Primitive, PrimitiveError, Transform};

/// A node together with the values of the parameters that are live there; dead parameters are blanked.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct State {
    node: NodeId,
    env: Env,
}

impl State {
    /// The node.
    pub fn node(&self) -> NodeId {
        self.node
    }

    /// The memory that it takes, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self) + size_of_val(self.env.values())
    }

    /// The values of the parameters; those that are dead are unset.
    pub fn env(&self) -> &Env {
        &self.env
    }
}

/// What a node is at a state, with the states below it.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Step {
    /// An S-node: the rule that its selection function picks.
    Select(State),
    /// A C-node: what is below it, with the new values.
    Calculate(State),
    /// A T-node: the map into this frame, and what it maps.
    Transform(Transform, State),
    /// An attribute node: its terms, and what they paint.
    Attribute(Vec<(AttributeTerm, f64)>, State),
    /// An operator node with its operands.
    Operator(Operator, [State; 2]),
    /// A primitive node.
    Primitive(Primitive),
}

impl Step {
    /// The states below, in order.
    pub fn into_states(self) -> [Option<State>; 2] {
        match self {
            Self::Select(state)
            | Self::Calculate(state)
            | Self::Transform(_, state)
            | Self::Attribute(_, state) => [Some(state), None],
            Self::Operator(_, states) => states.map(Some),
            Self::Primitive(_) => [None, None],
        }
    }
}

/// An evaluation that has no result. It names the node, the expression, and the values that led there.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {fault}{}", at.label, ParamValues(.values))]
pub struct EvalError {
    /// The node that was evaluated, and which of its expressions.
    pub at: Place,
    /// What went wrong.
    pub fault: Fault,
    /// The parameters that the expressions read, with their values; unset ones are left out.
    pub values: Vec<(String, f64)>,
}

/// A place in a graph: an expression of a node, or the node as a whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The node.
    pub node: NodeId,
    /// The position of the expression among [`Node::exprs`], or `None` for the node as a whole.
    pub expr: Option<usize>,
    /// What the node is called.
    pub label: String,
}

/// What can go wrong in an evaluation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// The selection function named no rule.
    #[error("the selection function gives {}, and the rules are 1 to {rules}", Number(*.value))]
    NoSuchRule {
        /// What it gave.
        value: f64,
        /// How many rules there are.
        rules: usize,
    },
    /// A parameter was read that has no value.
    #[error("parameter `{0}` is read but was never set")]
    Unset(String),
    /// The result is not a number.
    #[error("the result is not a number")]
    NotANumber,
    /// The result is infinite where a finite number is needed.
    #[error("the result is {0}; was something divided by zero?")]
    Infinite(f64),
    /// A transformation maps space onto a plane, a line or a point, or beyond what numbers hold.
    #[error("the transformation {0} is singular: it cannot be undone")]
    Singular(String),
    /// A recursion leads on and on, and to no solid.
    #[error("the recursion leads on and on, and to no solid")]
    Nothing,
    /// A recursion never ends, and shrinks so slowly that following it to the size of a pixel takes too long.
    #[error("the recursion leads on and on here, and hardly gets smaller")]
    Slow,
    /// Operators have operators for operands, and these again, for longer than anything that shrinks would.
    #[error("what is subtracted or clipped here leads on and on, and does not get smaller")]
    Bottomless,
    /// So many parts of parts lie in each other that a ray cannot come to all of them.
    #[error("more parts of parts lie in each other here than a ray can come to")]
    Crowded,
    /// The solid reaches so far that lengths are beyond what numbers hold.
    #[error("the solid reaches {}, and may reach at most {most:.0e}", Distance(*reach))]
    TooLarge {
        /// Its largest coordinate, infinite if numbers do not go that far.
        reach: f64,
        /// What that may be.
        most: f64,
    },
    /// The solid is so small that lengths are beyond what numbers hold.
    #[error("the solid is {size:.1e} large, and has to be at least {least:.0e}")]
    TooSmall {
        /// Its longest side.
        size: f64,
        /// What that has to be.
        least: f64,
    },
    /// The solid is so far from the origin that coordinates do not tell its parts apart.
    #[error("the solid is {sizes:.1e} times its size from the origin, and may be at most {most:.0e} times")]
    TooFar {
        /// How many times its longest side.
        sizes: f64,
        /// What that may be.
        most: f64,
    },
    /// An attribute is not in its range.
    #[error("{} is {}, and it is {}", term.name(), Number(*.value), Allowed(*.term))]
    OutOfRange {
        /// The attribute.
        term: AttributeTerm,
        /// Its value.
        value: f64,
    },
    /// A primitive has no extent.
    #[error(transparent)]
    Primitive(#[from] PrimitiveError),
}

/// ` where a = 1, b = 2`, or nothing.
pub(crate) struct ParamValues<'a>(pub(crate) &'a [(String, f64)]);

impl fmt::Display for ParamValues<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (name, value)) in self.0.iter().enumerate() {
            let before = if index == 0 { " where " } else { ", " };
            write!(f, "{before}{name} = {}", Number(*value))?;
        }
        Ok(())
    }
}

/// `1.6e150 far`, or what there is to say where numbers end.
struct Distance(f64);

impl fmt::Display for Distance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_finite() { write!(f, "{:.1e} far", self.0) } else { f.write_str("further than numbers") }
    }
}

/// `at least 1`, or `from 0 to 1`.
struct Allowed(AttributeTerm);

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (least, most) = self.0.range().into_inner();
        if most.is_finite() { write!(f, "from {least} to {most}") } else { write!(f, "at least {least}") }
    }
}

impl Graph {
    /// The state of the root.
    pub fn root_state(&self) -> State {
        self.state(self.root(), self.initial().clone())
    }

    /// The state of `node` under `env`: dead parameters are blanked.
    ///
    /// # Panics
    /// If either is of another graph, one with more nodes or fewer parameters.
    pub fn state(&self, node: NodeId, mut env: Env) -> State {
        for param in self.liveness.dead(node) {
            if env.get(param).is_some() {
                env.blank(param);
            }
        }
        State { node, env }
    }

    /// The live parameters of a state that have values, in the order of their declaration.
    ///
    /// # Panics
    /// If the state is of another graph, one with more nodes or fewer parameters.
    pub fn live_values(&self, state: &State) -> Vec<(String, f64)> {
        let live = self.live_params(state.node());
        live.filter_map(|param| Some((self.param_name(param).to_owned(), state.env().get(param)?))).collect()
    }

    /// What the node of `state` is there, with the states below it.
    ///
    /// # Errors
    /// If an expression of the node has no usable value.
    ///
    /// # Panics
    /// If the state is of another graph, one with more nodes or fewer parameters.
    pub fn step(&self, state: &State) -> Result<Step, EvalError> {
        let State { node: id, env } = state;
        let below = |child: NodeId| self.state(child, env.clone());
        Ok(match self.node(*id) {
            Node::Symbol(_) => Step::Select(below(self.select(*id, env)?)),
            Node::Calculation(node) => {
                let mut env = env.clone();
                self.calculate(*id, &mut env)?;
                Step::Calculate(self.state(node.body, env))
            }
            Node::Transformation(node) => Step::Transform(self.transform(*id, env)?, below(node.body)),
            Node::Attribute(node) => Step::Attribute(self.attributes(*id, env)?, below(node.body)),
            Node::Operator(node) => Step::Operator(node.operator, node.operands.map(below)),
            Node::Primitive(_) => Step::Primitive(self.primitive(*id, env)?.into_owned()),
        })
    }

    /// The rule that the S-node `id` selects under `env`.
    ///
    /// # Errors
    /// If the selection has no value or names no rule.
    ///
    /// # Panics
    /// If `id` is no S-node.
    #[expect(clippy::float_cmp, reason = "a rule number is exact or it is no rule number")]
    pub fn select(&self, id: NodeId, env: &Env) -> Result<NodeId, EvalError> {
        let Node::Symbol(symbol) = self.node(id) else { panic!("{id:?} is no S-node") };
        let Some(selection) = &symbol.selection else { return Ok(symbol.rules[0]) };
        let value = self.number(id, 0, selection, env)?;
        let rule = (1_u32..).zip(&symbol.rules).find(|(number, _)| f64::from(*number) == value);
        rule.map(|(_, rule)| *rule).ok_or_else(|| {
            self.error(id, Some(0), Fault::NoSuchRule { value, rules: symbol.rules.len() }, &[selection], env)
        })
    }

    /// Runs the assignments of the C-node `id` on `env`.
    ///
    /// # Errors
    /// If a value is not a number.
    ///
    /// # Panics
    /// If `id` is no C-node.
    pub fn calculate(&self, id: NodeId, env: &mut Env) -> Result<(), EvalError> {
        let Node::Calculation(node) = self.node(id) else { panic!("{id:?} is no C-node") };
        for (index, (param, expr)) in node.assignments.iter().enumerate() {
            // What nothing reads needs no value, and states need not have what it would be computed from.
            if self.liveness.is_needed(id, index) {
                let value = self.number(id, index, expr, env)?;
                env.set(*param, value);
            }
        }
        Ok(())
    }

    /// The transformation of the T-node `id` under `env`.
    ///
    /// # Errors
    /// If an argument has no finite value or the transformation is singular.
    ///
    /// # Panics
    /// If `id` is no T-node.
    pub fn transform(&self, id: NodeId, env: &Env) -> Result<Transform, EvalError> {
        let Node::Transformation(node) = self.node(id) else { panic!("{id:?} is no T-node") };
        if let Some(transform) = node.constant {
            return Ok(transform);
        }
        let args = self.finite_numbers(id, node.args.iter(), env)?;
        node.kind.evaluate(&args).ok_or_else(|| {
            let list: Vec<_> = args.iter().map(|value| Number(*value).to_string()).collect();
            let call = if list.is_empty() { String::new() } else { format!("({})", list.join(", ")) };
            let fault = Fault::Singular(format!("{}{call}", node.kind.name()));
            self.error(id, None, fault, &node.args.iter().collect::<Vec<_>>(), env)
        })
    }

    /// The primitive of the primitive node `id` under `env`.
    ///
    /// # Errors
    /// If an argument has no finite value or the primitive no extent.
    ///
    /// # Panics
    /// If `id` is no primitive node.
    pub fn primitive(&self, id: NodeId, env: &Env) -> Result<Cow<'_, Primitive>, EvalError> {
        let Node::Primitive(node) = self.node(id) else { panic!("{id:?} is no primitive node") };
        if let Some(primitive) = &node.constant {
            return Ok(Cow::Borrowed(primitive));
        }
        let args = self.finite_numbers(id, node.args.iter(), env)?;
        let primitive = node
            .kind
            .evaluate(&args)
            .map_err(|fault| self.error(id, None, fault.into(), &node.args.iter().collect::<Vec<_>>(), env));
        primitive.map(Cow::Owned)
    }

    /// The values of the attribute node `id` under `env`.
    ///
    /// # Errors
    /// If a value is not finite, or not in the range of its term.
    ///
    /// # Panics
    /// If `id` is no attribute node.
    pub fn attributes(&self, id: NodeId, env: &Env) -> Result<Vec<(AttributeTerm, f64)>, EvalError> {
        let Node::Attribute(node) = self.node(id) else { panic!("{id:?} is no attribute node") };
        let values = self.finite_numbers(id, node.terms.iter().map(|(_, expr)| expr), env)?;
        for (index, ((term, expr), value)) in node.terms.iter().zip(&values).enumerate() {
            if !term.range().contains(value) {
                let fault = Fault::OutOfRange { term: *term, value: *value };
                return Err(self.error(id, Some(index), fault, &[expr], env));
            }
        }
        Ok(node.terms.iter().map(|(term, _)| *term).zip(values).collect())
    }

    fn finite_numbers<'a>(
        &self,
        id: NodeId,
        exprs: impl Iterator<Item = &'a Expr>,
        env: &Env,
    ) -> Result<Vec<f64>, EvalError> {
        exprs
            .enumerate()
            .map(|(index, expr)| {
                let value = self.number(id, index, expr, env)?;
                let finite = value.is_finite().then_some(value);
                finite.ok_or_else(|| self.error(id, Some(index), Fault::Infinite(value), &[expr], env))
            })
            .collect()
    }

    fn number(&self, id: NodeId, index: usize, expr: &Expr, env: &Env) -> Result<f64, EvalError> {
        let value = expr.evaluate(env);
        if !value.is_nan() {
            return Ok(value);
        }
        let unset = expr.params().find(|param| env.get(*param).is_none());
        let fault = unset.map_or(Fault::NotANumber, |param| Fault::Unset(self.param_name(param).to_owned()));
        Err(self.error(id, Some(index), fault, &[expr], env))
    }

    fn error(&self, node: NodeId, expr: Option<usize>, fault: Fault, read: &[&Expr], env: &Env) -> EvalError {
        let mut params: Vec<_> = read.iter().flat_map(|expr| expr.params()).collect();
        params.sort_unstable();
        params.dedup();
        let values = params
            .into_iter()
            .filter_map(|param| Some((self.param_name(param).to_owned(), env.get(param)?)))
            .collect();
        EvalError { at: Place { node, expr, label: self.node_name(node) }, fault, values }
    }
}
