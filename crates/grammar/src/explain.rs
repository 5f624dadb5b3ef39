//! Errors of the graph, told to the author of the file: recursions that do not end, states that are too many, solids that
//! are not bounded.

use std::collections::BTreeSet;

use csg_graph::{EvalError, GraphError, Node, NodeId, Number, StatesError, SymbolState};

use crate::faults::evaluation;
use crate::lower::sort;
use crate::names::SEED;
use crate::number::values;
use crate::{Diagnostic, Scene, SourceMap};

/// What to do about states that differ by chance.
const TOO_RANDOM: &str = "every reference changes `seed`, and each of its values makes states of their own; if the recursion \
                          ends, leave it few, as by `{seed = seed % 8}` before a reference, or raise the limit of states";

impl Scene {
    /// Tells where and why an evaluation failed.
    ///
    /// # Panics
    /// If the error is of another graph.
    pub fn explain_evaluation(&self, error: &EvalError) -> Diagnostic {
        evaluation(&self.sources, error)
    }

    /// Tells where and why the states cannot be listed: evaluations fail, each told for itself in the order of the text, or the
    /// recursion does not end.
    ///
    /// ```
    /// let scene = csg_graph_grammar::load("{ n = 3; } A\nA if(n > 0, 2, 1)\n1: A -> sphere\n2: A -> A", &[]);
    /// let scene = scene.unwrap().scene;
    /// let error = scene.graph.states(&Default::default()).unwrap_err();
    /// let told = scene.explain(&error);
    /// assert_eq!(told[0].help.as_deref().unwrap(), "rule 2 of `A` leads back to itself and no parameter changes; does `n` decrease?");
    /// ```
    ///
    /// # Panics
    /// If the error is of another graph.
    pub fn explain(&self, error: &StatesError) -> Vec<Diagnostic> {
        let diagnostic = match error {
            StatesError::Eval { errors } => {
                let mut diagnostics: Vec<_> =
                    errors.iter().map(|error| evaluation(&self.sources, error)).collect();
                sort(&mut diagnostics);
                return diagnostics;
            }
            StatesError::Endless { path } => self.endless(path),
            StatesError::TooMany { limit, path } => self.too_many(*limit, path),
            _ => Diagnostic::error(self.sources.node(self.graph.root()), error.to_string()),
        };
        vec![diagnostic]
    }

    fn endless(&self, path: &[SymbolState]) -> Diagnostic {
        let Some(first) = path.first() else {
            return Diagnostic::error(self.sources.node(self.graph.root()), "the recursion never ends");
        };
        let steps: Vec<_> =
            path.windows(2).map(|pair| (self.selected(&pair[0]), pair[1].name.as_str())).collect();
        let way = way(&steps);
        let control = path.iter().find_map(|state| self.control(state.node));
        let help = match (control, round_trip(path)) {
            (None, _) => format!(
                "{way}, and no selection function ever takes another rule; give `{}` a rule that ends it",
                first.name
            ),
            (Some(control), None) => format!("{way} and no parameter changes; does `{control}` decrease?"),
            (Some(_), Some((name, values))) => format!(
                "{way}, and `{name}` comes back to the value that it had: {values}; let a parameter go one way only, and \
                 the selection end the recursion when it arrives"
            ),
        };
        let label = match values(&first.values) {
            None => "comes back to itself".to_owned(),
            Some(values) => format!("comes back to itself {values}"),
        };
        let message = format!("the recursion of `{}` never ends", first.name);
        let mut report = Diagnostic::error(self.sources.node(first.node), message).label(label).help(help);
        if let Some((Some((_, number)), _)) = steps.first()
            && let Some(rule) = self.sources.rules(first.node).get(number - 1)
        {
            report = report.also(*rule, "by this rule");
        }
        report
    }

    fn too_many(&self, limit: usize, path: &[SymbolState]) -> Diagnostic {
        let root = self.graph.root();
        let Some(last) = path.last() else {
            return Diagnostic::error(self.sources.node(root), format!("more than {limit} states"));
        };
        let span = self.sources.node(last.node);
        let label = values(&last.values).unwrap_or_default();
        if let Some((name, from, to)) = self.descent(limit, path) {
            let message = format!("more than {limit} states: does the recursion of `{}` end?", last.name);
            return Diagnostic::error(span, message).label(label).help(format!(
                "`{name}` has gone from {} to {} without ending it; if the recursion is meant to be this deep, raise the \
                 limit of states",
                Number(from),
                Number(to)
            ));
        }
        let changing: Vec<_> =
            self.changing().filter(|name| last.values.iter().any(|(known, _)| known == name)).collect();
        let help = match changing.as_slice() {
            [] => "if so many are meant, raise the limit of states".to_owned(),
            names if names.contains(&SEED) => TOO_RANDOM.to_owned(),
            [name] => {
                format!("`{name}` takes very many values; if they are meant, raise the limit of states")
            }
            names => format!(
                "every combination of the values of {} is a state of its own; if so many are meant, raise the limit of \
                 states",
                names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
            ),
        };
        Diagnostic::error(span, format!("more than {limit} states")).label(label).help(help)
    }

    /// A parameter that counts in equal steps, so far that its count makes most of the states, with its first and its last
    /// value. The path has only the first states and the last.
    fn descent<'p>(&self, limit: usize, path: &'p [SymbolState]) -> Option<(&'p str, f64, f64)> {
        let last = path.last()?;
        let mut same = path.iter().filter(|state| state.node == last.node);
        let (first, before) = (same.next()?, same.rev().nth(1)?);
        let mut counters = last.values.iter().filter(|(name, _)| name != SEED);
        counters.find_map(|(name, to)| {
            let (from, before) = (value(first, name)?, value(before, name)?);
            let levels = ((to - from) / (to - before)).abs();
            let nodes = self.graph.nodes().count();
            let deep = levels.is_finite() && levels * nodes as f64 >= limit as f64;
            deep.then_some((name.as_str(), from, *to))
        })
    }

    /// The parameters that calculations set, in the order of their declaration.
    fn changing(&self) -> impl Iterator<Item = &str> {
        let set: BTreeSet<_> = self
            .graph
            .nodes()
            .filter_map(
                |(_, node)| if let Node::Calculation(node) = node { Some(&node.assignments) } else { None },
            )
            .flatten()
            .map(|(param, _)| *param)
            .collect();
        set.into_iter().map(|param| self.graph.param_name(param))
    }

    /// The symbol's name and the number of the rule that it selects with these values.
    fn selected(&self, state: &SymbolState) -> Option<(String, usize)> {
        let Node::Symbol(symbol) = self.graph.node(state.node) else { return None };
        let mut env = self.graph.initial().clone();
        for param in self.graph.params() {
            let value = state.values.iter().find(|(name, _)| name == self.graph.param_name(param));
            if let Some((_, value)) = value {
                env.set(param, *value);
            }
        }
        let value = symbol.selection.as_ref().map_or(1.0, |selection| selection.evaluate(&env));
        let is_it = |number: &u32| f64::from(*number).total_cmp(&value).is_eq();
        let number = (1_u32..).take(symbol.rules.len()).find(is_it)?;
        Some((state.name.clone(), usize::try_from(number).ok()?))
    }

    /// The first parameter that the selection function of a symbol reads.
    fn control(&self, symbol: NodeId) -> Option<&str> {
        let Node::Symbol(symbol) = self.graph.node(symbol) else { return None };
        let param = symbol.selection.as_ref()?.params().next()?;
        Some(self.graph.param_name(param))
    }
}

/// `rule 1 of `A` leads to `B`, rule 2 of `B` leads back to `A``
fn way(steps: &[(Option<(String, usize)>, &str)]) -> String {
    const SHOWN: usize = 4;
    let leads = steps.iter().zip(1..).map(|((rule, name), number)| {
        let to = match (number == steps.len(), number) {
            (true, 1) => "back to itself".to_owned(),
            (true, _) => format!("back to `{name}`"),
            (false, _) => format!("to `{name}`"),
        };
        match rule {
            Some((name, number)) => format!("rule {number} of `{name}` leads {to}"),
            None => format!("that leads {to}"),
        }
    });
    abbreviated(leads.collect(), SHOWN, ", ")
}

/// A parameter that changes on the way from a state to itself, with its values.
fn round_trip(path: &[SymbolState]) -> Option<(&str, String)> {
    const SHOWN: usize = 6;
    let first = path.first()?;
    first.values.iter().find_map(|(name, start)| {
        let met: Vec<f64> = path.iter().filter_map(|state| value(state, name)).collect();
        let changes = met.iter().any(|met| met.to_bits() != start.to_bits());
        let shown = || met.iter().map(|value| Number(*value).to_string()).collect();
        changes.then(|| (name.as_str(), abbreviated(shown(), SHOWN, " → ")))
    })
}

fn value(state: &SymbolState, name: &str) -> Option<f64> {
    state.values.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
}

/// A list, with `…` before the last where it is long.
fn abbreviated(mut list: Vec<String>, shown: usize, between: &str) -> String {
    if list.len() > shown {
        list.splice(shown - 1..list.len() - 1, ["…".to_owned()]);
    }
    list.join(between)
}

/// Tells where and why a graph is not sound.
pub(crate) fn graph_error(sources: &SourceMap, error: &GraphError) -> Vec<Diagnostic> {
    let diagnostic = match error {
        GraphError::Constants { errors } => {
            return errors.iter().map(|error| evaluation(sources, error)).collect();
        }
        GraphError::Unbounded { node } => {
            Diagnostic::error(sources.node(*node), "the half-space is not bounded")
                .label("reaches from the axiom to infinity")
                .help("intersect it with a bounded solid (`cube & halfspace`), or subtract it from one")
        }
        GraphError::Dangling { node } | GraphError::NoRules { node, .. } | GraphError::Cycle { node, .. } => {
            Diagnostic::error(sources.node(*node), error.to_string())
        }
        _ => Diagnostic::error(Default::default(), error.to_string()),
    };
    vec![diagnostic]
}
