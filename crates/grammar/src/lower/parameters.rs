//! Parameters: initial values, values from outside, and those that only calculations set.

use std::collections::{BTreeMap, BTreeSet};

use csg_graph::{Expr, ParamId};

use super::Lowering;
use crate::names::{PI, nearest};
use crate::number::Number;
use crate::syntax::{Assignment, PrefixKind, Term};
use crate::{Diagnostic, Override, Span};

impl Lowering<'_> {
    /// Evaluates the initial values, once and in order.
    pub(super) fn initial_parameters(&mut self, overrides: &[Override]) {
        let tree = self.tree;
        let assignments = &tree.parameters().assignments;
        self.scope.note_later(assignments.iter().map(|assignment| tree.text(assignment.name)));
        self.refuse_unknown(overrides);
        let mut declared: BTreeMap<&str, Span> = BTreeMap::new();
        for assignment in assignments {
            let name = tree.text(assignment.name);
            if self.refuse_constant(assignment.name) {
                continue;
            }
            if let Some(first) = declared.get(name) {
                self.diagnostics.push(
                    Diagnostic::error(assignment.name, format!("parameter `{name}` has two initial values"))
                        .label("the second")
                        .also(*first, "the first"),
                );
                continue;
            }
            declared.insert(name, assignment.name);
            self.scope.begin(name);
            let given = overrides.iter().rfind(|given| given.name() == name);
            let value = self.initial_value(name, assignment, given);
            let param = match value {
                Some(value) => self.builder.param(name, value),
                None => self.builder.declare(name),
            };
            if value.is_none() {
                self.scope.poison(param);
            }
            self.scope.declare(name, param);
        }
    }

    fn initial_value(&mut self, name: &str, own: &Assignment, given: Option<&Override>) -> Option<f64> {
        // The file's own value is checked also where another one takes its place.
        let own_expr = self.scope.expr(self.tree, own.value, &mut self.diagnostics);
        let mut reports = Vec::new();
        let (expr, span) = match given {
            None => (own_expr, self.tree.expr_span(own.value)),
            Some(given) => {
                let value = given.assignment.value;
                (self.scope.expr(&given.tree, value, &mut reports), given.tree.expr_span(value))
            }
        };
        let value = expr.and_then(|expr| {
            self.evaluate(&format!("the initial value of `{name}`"), &expr, span, &mut reports)
        });
        let located = reports.into_iter().map(|report| match given {
            Some(given) => given.locate(report),
            None => report,
        });
        self.diagnostics.extend(located);
        value
    }

    /// The value of an expression over the initial parameters, or a report that there is none.
    pub(super) fn evaluate(
        &self,
        what: &str,
        expr: &Expr,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<f64> {
        let env = self.builder.initial();
        let value = expr.evaluate(env);
        if !value.is_nan() {
            return Some(value);
        }
        if !self.scope.is_poisoned(expr) {
            let mut seen: BTreeSet<ParamId> = BTreeSet::new();
            let params = expr.params().filter(|param| seen.insert(*param));
            let values: Vec<_> = params
                .filter_map(|param| {
                    Some(format!("{} = {}", self.scope.param_name(param), Number(env.get(param)?)))
                })
                .collect();
            let label =
                if values.is_empty() { String::new() } else { format!("where {}", values.join(", ")) };
            diagnostics.push(
                Diagnostic::error(span, format!("{what} is not a number"))
                    .label(label)
                    .help("0/0 is none, nor is the root or the logarithm of a negative number"),
            );
        }
        None
    }

    fn refuse_unknown(&mut self, overrides: &[Override]) {
        let tree = self.tree;
        let known = || tree.parameters().assignments.iter().map(|assignment| tree.text(assignment.name));
        for given in overrides {
            let name = given.name();
            if known().any(|known| known == name) {
                continue;
            }
            let help = match nearest(name, known()) {
                Some(known) => format!("did you mean `{known}`?"),
                None if known().next().is_none() => "the file has no parameters".to_owned(),
                None => format!("the parameters are {}", known().collect::<Vec<_>>().join(", ")),
            };
            let report =
                Diagnostic::error(given.assignment.name, format!("the file has no parameter `{name}`"));
            self.diagnostics.push(given.locate(report.label("unknown").help(help)));
        }
    }

    /// Declares the parameters that no initial value but some calculation sets.
    pub(super) fn calculated_parameters(&mut self) {
        let tree = self.tree;
        for node in &tree.terms {
            let Term::Prefixed { prefix, .. } = &node.value else { continue };
            let PrefixKind::Calculation(assignments) = &prefix.kind else { continue };
            for assignment in assignments {
                let name = tree.text(assignment.name);
                if self.scope.get(name).is_none() && !self.refuse_constant(assignment.name) {
                    self.scope.declare(name, self.builder.declare(name));
                }
            }
        }
    }

    fn refuse_constant(&mut self, name: Span) -> bool {
        let constant = self.tree.text(name) == PI;
        if constant {
            self.diagnostics.push(Diagnostic::error(name, "`pi` is a constant").label("cannot be set"));
        }
        constant
    }
}
