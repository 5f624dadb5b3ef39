//! Expressions: names become parameters, functions get their arguments.

use std::collections::{BTreeMap, BTreeSet};

use csg_graph::{Expr, Function, ParamId};

use super::chance::Sites;
use crate::names::{self, PI, SEED, guess, nearest};
use crate::syntax::{self, ExprId, SyntaxTree};
use crate::{Diagnostic, Span};

/// What the names in expressions mean.
#[derive(Default)]
pub(super) struct Scope<'t> {
    params: BTreeMap<&'t str, ParamId>,
    /// The names by the positions of the parameters, which are declared one after the other.
    param_names: Vec<&'t str>,
    /// Parameters that expressions have read.
    read: BTreeSet<ParamId>,
    /// Parameters whose initial value is a mistake that has been reported.
    poisoned: BTreeSet<ParamId>,
    /// Names that have been reported as unknown.
    reported: BTreeSet<String>,
    /// The parameter whose initial value is being translated.
    own: Option<&'t str>,
    /// And the one that a calculation gives a value: that it is read there is no use of it.
    assigned: Option<ParamId>,
    /// Parameters that have been read so.
    counted: BTreeSet<ParamId>,
    /// Parameters that will be known further down.
    later: BTreeSet<&'t str>,
    /// Symbols and macros: known names, but not of numbers.
    solids: BTreeSet<&'t str>,
}

impl<'t> Scope<'t> {
    pub(super) fn note_solids(&mut self, names: impl Iterator<Item = &'t str>) {
        self.solids.extend(names);
    }

    pub(super) fn note_later(&mut self, names: impl Iterator<Item = &'t str>) {
        self.later.extend(names);
    }

    /// The initial value of this parameter follows, and then its declaration.
    pub(super) fn begin(&mut self, name: &'t str) {
        self.own = Some(name);
    }

    pub(super) fn declare(&mut self, name: &'t str, param: ParamId) {
        self.own = None;
        self.later.remove(name);
        debug_assert_eq!(param.index(), self.param_names.len(), "every parameter is declared once");
        self.params.insert(name, param);
        self.param_names.push(name);
    }

    pub(super) fn param_name(&self, param: ParamId) -> &'t str {
        self.param_names[param.index()]
    }

    pub(super) fn poison(&mut self, param: ParamId) {
        self.poisoned.insert(param);
    }

    pub(super) fn get(&self, name: &str) -> Option<ParamId> {
        self.params.get(name).copied()
    }

    /// What a calculation gives to this parameter follows, or its end.
    pub(super) fn assign(&mut self, param: Option<ParamId>) {
        self.assigned = param;
    }

    /// Whether a calculation has read the parameter that it gives a value.
    pub(super) fn is_counted(&self, param: ParamId) -> bool {
        self.counted.contains(&param)
    }

    pub(super) fn is_read(&self, param: ParamId) -> bool {
        self.read.contains(&param)
    }

    /// Whether the value of an expression depends on a mistake that has been reported.
    pub(super) fn is_poisoned(&self, expr: &Expr) -> bool {
        expr.params().any(|param| self.poisoned.contains(&param))
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &'t str> + '_ {
        self.params.keys().copied()
    }

    /// Translates an expression, or reports why that is impossible.
    ///
    /// The expression may be of another tree than the names; the sites are those of its tree.
    pub(super) fn expr(
        &mut self,
        tree: &SyntaxTree,
        sites: &Sites,
        id: ExprId,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Expr> {
        let all = tree.subexprs(id);
        let first = all.clone().next().map_or(0, ExprId::index);
        // The translations of the nodes that are still to become part of another one.
        let mut done: Vec<Option<Expr>> = Vec::with_capacity(id.index() - first + 1);
        for node in all {
            let mut take = |part: ExprId| done[part.index() - first].take();
            let span = tree.expr_span(node);
            let translated = match tree.expr(node) {
                syntax::Expr::Number(value) => Some(Expr::from(*value)),
                syntax::Expr::Name => self.name(tree.text(span), span, diagnostics),
                syntax::Expr::Unary(operator, a) => take(*a).map(|a| Expr::unary(*operator, a)),
                syntax::Expr::Binary(operator, a, b) => match (take(*a), take(*b)) {
                    (Some(a), Some(b)) => Some(Expr::binary(*operator, a, b)),
                    _ => None,
                },
                syntax::Expr::Call { name, args } => {
                    let values: Vec<_> = args.iter().map(|arg| take(*arg)).collect();
                    let complete = !args.iter().any(|arg| matches!(tree.expr(*arg), syntax::Expr::Missing));
                    let function = function(tree.text(*name), *name, diagnostics);
                    let args = function
                        .filter(|_| complete)
                        .and_then(|function| arguments(function, span, values, diagnostics));
                    match (function, args) {
                        (Some(function), Some(args)) if function.is_random() => self
                            .seed(function, *name, diagnostics)
                            .map(|seed| Expr::draw(function, seed, sites.of(node), args)),
                        (Some(function), Some(args)) => Some(Expr::call(function, args)),
                        _ => None,
                    }
                }
                syntax::Expr::Parenthesised(inside) => take(*inside),
                syntax::Expr::Tuple(items) => {
                    let message = format!("{} numbers in parentheses where one is expected", items.len());
                    diagnostics.push(Diagnostic::error(span, message).label("expected a number").help(
                        "points are arguments of `rot`, `matrix` and `hull`, and fields of scene blocks",
                    ));
                    None
                }
                syntax::Expr::Missing => None,
            };
            done.push(translated);
        }
        done.pop().flatten()
    }

    /// The parameter that a random function draws from.
    fn seed(&mut self, function: Function, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<ParamId> {
        let seed = self.get(SEED);
        match seed {
            Some(seed) => {
                self.read.insert(seed);
            }
            None => {
                let message = format!("`{}` draws from `seed`, which is set further down", function.name());
                let report = Diagnostic::error(span, message).label("no seed yet");
                diagnostics.push(report.help("initial values are evaluated in order; set `seed` first"));
            }
        }
        seed
    }

    fn name(&mut self, name: &str, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Expr> {
        if name == PI {
            return Some(Expr::from(std::f64::consts::PI));
        }
        if let Some(param) = self.get(name) {
            let reads = if self.assigned == Some(param) { &mut self.counted } else { &mut self.read };
            reads.insert(param);
            return Some(Expr::from(param));
        }
        if self.reported.insert(name.to_owned()) {
            let report = self.unknown(name, span, diagnostics);
            diagnostics.push(report);
        }
        None
    }

    fn unknown(&self, name: &str, span: Span, told: &[Diagnostic]) -> Diagnostic {
        if self.solids.contains(name) || names::is_built_in(name) {
            return Diagnostic::error(
                span,
                format!("`{name}` is a solid or belongs to one, and not a number"),
            )
            .label("expected a number");
        }
        if self.own == Some(name) {
            return Diagnostic::error(span, format!("`{name}` cannot be computed from itself"))
                .label("has no value yet")
                .help(
                    "an initial value may use the parameters before it; to count, calculate: `{n = n + 1}`",
                );
        }
        let help = if self.later.contains(name) {
            format!("`{name}` is set further down; initial values are evaluated in order")
        } else if let Some(function) = Function::named(name) {
            format!("`{name}` is a function: write `{}`", function.signature())
        } else if let Some(known) = guess(told, name, self.names().chain([PI])) {
            format!("did you mean `{known}`?")
        } else {
            format!("parameters are set between the first braces of the file: `{{ {name} = 1; }}`")
        };
        Diagnostic::error(span, format!("unknown parameter `{name}`")).label("unknown").help(help)
    }
}

fn function(name: &str, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Function> {
    let function = Function::named(name);
    if function.is_none() {
        let help = match nearest(name, names::functions()) {
            Some(known) => format!("did you mean `{known}`?"),
            None => format!("the functions are {}", names::functions().collect::<Vec<_>>().join(", ")),
        };
        let report = Diagnostic::error(span, format!("unknown function `{name}`"));
        diagnostics.push(report.label("unknown").help(help));
    }
    function
}

fn arguments(
    function: Function,
    span: Span,
    args: Vec<Option<Expr>>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Vec<Expr>> {
    let (least, most) = function.arity().into_inner();
    if !(least..=most).contains(&args.len()) {
        let open = if least == most { "" } else { "at least " };
        let takes = count(least, "argument");
        let message = format!("`{}` takes {open}{takes}, not {}", function.name(), args.len());
        let help = format!("`{}` is {}", function.signature(), function.summary());
        diagnostics.push(Diagnostic::error(span, message).label(format!("{} here", args.len())).help(help));
        return None;
    }
    args.into_iter().collect()
}

/// `1 argument`, `2 arguments`
pub(super) fn count(count: usize, noun: &str) -> String {
    match count {
        0 => format!("no {noun}s"),
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    }
}
