//! Parameters: initial values, values from outside, and those that only calculations set.

use std::collections::{BTreeMap, BTreeSet};

use csg_graph::{Expr, Number, ParamId};

use super::Lowering;
use super::chance::Sites;
use crate::names::{PI, SEED, nearest};
use crate::number::NOT_A_NUMBER;
use crate::syntax::{PrefixKind, Term};
use crate::{Diagnostic, Override, Span};

impl<'t> Lowering<'t> {
    /// Evaluates the initial values, once and in order.
    pub(super) fn initial_parameters(&mut self, overrides: &[Override]) {
        let tree = self.tree;
        let assignments = &tree.parameters().assignments;
        self.scope.note_later(assignments.iter().map(|assignment| tree.text(assignment.name)));
        self.refuse_unknown(overrides);
        let given = |name: &str| overrides.iter().rfind(|given| given.name() == name);
        let mut declared: BTreeMap<&str, Span> = BTreeMap::new();
        if self.is_seed_implied() {
            let value = match given(SEED) {
                Some(given) => self.value_from_outside(SEED, given),
                None => Some(0.0),
            };
            self.declare(SEED, value);
        }
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
            // The file's own value is checked also where another one takes its place.
            let own = self.scope.expr(tree, &self.chance.sites, assignment.value, &mut self.diagnostics);
            let value = match given(name) {
                Some(given) => self.value_from_outside(name, given),
                None => {
                    let mut reports = Vec::new();
                    let value = self.initial_value(name, own, tree.expr_span(assignment.value), &mut reports);
                    self.diagnostics.extend(reports);
                    value
                }
            };
            self.declare(name, value);
        }
    }

    /// Declares an initial parameter; without a value, which has been reported.
    fn declare(&mut self, name: &'t str, value: Option<f64>) {
        let param = match value {
            Some(value) => self.builder.param(name, value),
            None => self.builder.declare(name),
        };
        if value.is_none() {
            self.scope.poison(param);
        }
        self.scope.declare(name, param);
    }

    /// Whether the file has a seed without saying so.
    fn is_seed_implied(&self) -> bool {
        let assignments = &self.tree.parameters().assignments;
        self.chance.is_seeded && assignments.iter().all(|assignment| self.tree.text(assignment.name) != SEED)
    }

    fn value_from_outside(&mut self, name: &str, given: &Override) -> Option<f64> {
        let (tree, id) = (&given.tree, given.assignment.value);
        let sites = Sites::outside(tree, &mut self.chance.drawn);
        let mut reports = Vec::new();
        let expr = self.scope.expr(tree, &sites, id, &mut reports);
        let value = self.initial_value(name, expr, tree.expr_span(id), &mut reports);
        self.diagnostics.extend(reports.into_iter().map(|report| given.locate(report)));
        value
    }

    fn initial_value(
        &self,
        name: &str,
        expr: Option<Expr>,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<f64> {
        self.evaluate(&format!("the initial value of `{name}`"), &expr?, span, diagnostics)
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
                Diagnostic::error(span, format!("{what} is not a number")).label(label).help(NOT_A_NUMBER),
            );
        }
        None
    }

    fn refuse_unknown(&mut self, overrides: &[Override]) {
        let tree = self.tree;
        let implied = self.is_seed_implied().then_some(SEED);
        let known = || {
            let own = tree.parameters().assignments.iter().map(|assignment| tree.text(assignment.name));
            own.chain(implied)
        };
        for given in overrides {
            let name = given.name();
            if known().any(|known| known == name) {
                continue;
            }
            let help = match nearest(name, known()) {
                _ if name == SEED => {
                    "nothing in it is random: no `rand`, `normal` or `pick`, and nothing reads `seed`"
                        .to_owned()
                }
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
