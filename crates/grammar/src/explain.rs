//! Errors of the graph, told to the author of the file: which place, with which values, and what probably causes it.

use csg_graph::{EvalError, Fault, GraphError, Node, NodeId, StatesError, SymbolState};

use crate::{Diagnostic, Scene, SourceMap};

impl Scene {
    /// Tells where and why an evaluation failed.
    ///
    /// # Panics
    /// If the error is of another graph.
    pub fn explain_evaluation(&self, error: &EvalError) -> Diagnostic {
        evaluation(&self.sources, error)
    }

    /// Tells where and why the states cannot be listed: an evaluation fails, or the recursion does not end.
    ///
    /// ```
    /// let scene = csg_graph_grammar::load("{ n = 3; } A\nA if(n > 0, 2, 1)\n1: A -> sphere\n2: A -> A", &[]);
    /// let scene = scene.unwrap().scene;
    /// let error = scene.graph.states(&Default::default()).unwrap_err();
    /// let told = scene.explain(&error);
    /// assert_eq!(told.help.unwrap(), "rule 2 of `A` leads back to itself and no parameter changes; does `n` decrease?");
    /// ```
    ///
    /// # Panics
    /// If the error is of another graph.
    pub fn explain(&self, error: &StatesError) -> Diagnostic {
        match error {
            StatesError::Eval(error) => evaluation(&self.sources, error),
            StatesError::Endless { path } => self.endless(path),
            StatesError::TooMany { limit, path } => self.too_many(*limit, path),
            _ => Diagnostic::error(self.sources.node(self.graph.root()), error.to_string()),
        }
    }

    fn endless(&self, path: &[SymbolState]) -> Diagnostic {
        let Some(first) = path.first() else {
            return Diagnostic::error(self.sources.node(self.graph.root()), "the recursion never ends");
        };
        let steps: Vec<_> =
            path[..path.len().saturating_sub(1)].iter().map(|state| self.selected(state)).collect();
        let leads = steps.iter().zip(1..).map(|(rule, next)| {
            let last = next == path.len() - 1;
            let to = match (last, steps.len()) {
                (true, 1) => "back to itself".to_owned(),
                (true, _) => format!("back to `{}`", path[next].name),
                (false, _) => format!("to `{}`", path[next].name),
            };
            match rule {
                Some((name, number)) => format!("rule {number} of `{name}` leads {to}"),
                None => format!("that leads {to}"),
            }
        });
        let way = leads.collect::<Vec<_>>().join(", ");
        let help = match path.iter().find_map(|state| self.control(state.node)) {
            Some(control) => format!("{way} and no parameter changes; does `{control}` decrease?"),
            None => format!(
                "{way}, and no selection function ever takes another rule; give `{}` a rule that ends it",
                first.name
            ),
        };
        let label = match values(&first.values) {
            None => "comes back to itself".to_owned(),
            Some(values) => format!("comes back to itself {values}"),
        };
        let mut report = Diagnostic::error(
            self.sources.node(first.node),
            format!("the recursion of `{}` never ends", first.name),
        )
        .label(label)
        .help(help);
        if let Some((_, number)) = steps.first().cloned().flatten()
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
        let message = format!("more than {limit} states: does the recursion of `{}` end?", last.name);
        let report = Diagnostic::error(self.sources.node(last.node), message)
            .label(values(&last.values).unwrap_or_default());
        let drifting = path.iter().rev().skip(1).find(|state| state.node == last.node).and_then(|before| {
            let pairs = before.values.iter().zip(&last.values);
            pairs.filter(|(a, b)| a.0 == b.0).find(|(a, b)| a.1.to_bits() != b.1.to_bits())
        });
        report.help(match drifting {
            Some(((name, before), (_, after))) => format!(
                "`{name}` goes on from {before} to {after} and never stops it; if the recursion is meant to be this \
                 deep, raise the limit of states"
            ),
            None => "if so many are meant, raise the limit of states".to_owned(),
        })
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

fn evaluation(sources: &SourceMap, error: &EvalError) -> Diagnostic {
    let span = sources.place(&error.at);
    let name = &error.at.label;
    let with_values = values(&error.values);
    let label = |alone: &str| with_values.clone().unwrap_or_else(|| alone.to_owned());
    match &error.fault {
        Fault::NoSuchRule { value, rules } => {
            let range = if *rules == 1 { "its only rule is 1".to_owned() } else { format!("its rules are 1 to {rules}") };
            let message = format!("the selection function of `{name}` gives {value}, and {range}");
            let help = if value.fract() != 0.0 {
                "a rule number is a whole number; `floor`, `ceil` and `round` make one".to_owned()
            } else if *value == 0.0 {
                "rules are counted from 1, and a condition that is false is 0; choose with `if(condition, 2, 1)`".to_owned()
            } else if *value < 0.0 {
                "rules are counted from 1; has a parameter passed its end? `clamp` keeps a value in range".to_owned()
            } else {
                format!("is rule {value} of `{name}` missing, or does the selection count from elsewhere?")
            };
            Diagnostic::error(span, message).label(label(&format!("always {value}"))).help(help)
        }
        Fault::Unset(param) => Diagnostic::error(span, format!("parameter `{param}` is read but was never set"))
            .label(format!("`{param}` has no value here"))
            .help(format!(
                "give it an initial value between the first braces, or set it on every way here: `{{{param} = …}}`"
            )),
        Fault::NotANumber => Diagnostic::error(span, format!("a value of `{name}` is not a number"))
            .label(label("not a number"))
            .help("0/0 is none, nor is the root or the logarithm of a negative number"),
        Fault::Infinite(_) => {
            let zero = error.values.iter().find(|(_, value)| *value == 0.0);
            let infinite = error.values.iter().find(|(_, value)| value.is_infinite());
            let help = match (zero, infinite) {
                (Some((zero, _)), _) => format!("was something divided by `{zero}`, which is 0 here?"),
                (_, Some((param, _))) => format!("`{param}` is infinite itself: was something divided by zero to get it?"),
                _ => "was something divided by zero?".to_owned(),
            };
            Diagnostic::error(span, format!("an argument of `{name}` is infinite")).label(label("divides by zero")).help(help)
        }
        Fault::Singular(call) => Diagnostic::error(span, format!("the transformation `{call}` is singular"))
            .label(label("flattens every solid"))
            .help("a factor of 0 (or rows that depend on each other) leaves no solid, and no ray finds its way back"),
        fault => Diagnostic::error(span, fault.to_string()).label(label("no such solid")),
    }
}

/// `where a = 1, b = 2`
fn values(values: &[(String, f64)]) -> Option<String> {
    const SHOWN: usize = 8;
    let shown: Vec<_> = values.iter().take(SHOWN).map(|(name, value)| format!("{name} = {value}")).collect();
    let more = if values.len() > SHOWN { ", …" } else { "" };
    (!shown.is_empty()).then(|| format!("where {}{more}", shown.join(", ")))
}
