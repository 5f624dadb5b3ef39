//! Arguments of solids and prefixes: as many as a signature asks for, of the shape that it asks for.

use csg_graph::{AttributeTerm, Expr, ParamId, TransformKind};

use super::Lowering;
use super::expr::count;
use crate::names::nearest;
use crate::syntax::{self, Assignment, ExprId};
use crate::{Diagnostic, Span};

impl Lowering<'_> {
    /// The terms that a `material` sets, with their expressions and where those are.
    pub(super) fn material(
        &mut self,
        args: &[Assignment],
    ) -> Option<(Vec<AttributeTerm>, Vec<Expr>, Vec<Span>)> {
        let tree = self.tree;
        let mut seen: Vec<(AttributeTerm, Span)> = Vec::new();
        let mut sound = true;
        for arg in args {
            let name = tree.text(arg.name);
            let known = AttributeTerm::MATERIAL.into_iter().find(|term| term.name() == name);
            let Some(term) = known else {
                let all: Vec<_> = AttributeTerm::MATERIAL.iter().map(|term| term.name()).collect();
                let help = match nearest(name, all.iter().copied()) {
                    Some(known) => format!("did you mean `{known}`?"),
                    None => format!("a material has {}", all.join(", ")),
                };
                let report = Diagnostic::error(arg.name, format!("a material has no `{name}`"));
                self.diagnostics.push(report.label("unknown").help(help));
                sound = false;
                continue;
            };
            if let Some((_, first)) = seen.iter().find(|(known, _)| *known == term) {
                let report = Diagnostic::error(arg.name, format!("`{name}` is given twice"));
                self.diagnostics.push(report.label("the second").also(*first, "the first"));
                sound = false;
            }
            seen.push((term, arg.name));
        }
        let (exprs, spans) = self.exprs(args.iter().map(|arg| arg.value))?;
        let terms = seen.into_iter().map(|(term, _)| term).collect();
        sound.then_some((terms, exprs, spans))
    }

    /// The parameters of a calculation, with their expressions and where those are.
    pub(super) fn calculation(
        &mut self,
        assignments: &[Assignment],
    ) -> Option<(Vec<ParamId>, Vec<Expr>, Vec<Span>)> {
        let tree = self.tree;
        let (mut params, mut exprs) = (Vec::new(), Vec::new());
        for Assignment { name, value } in assignments {
            let param = self.scope.get(tree.text(*name));
            self.scope.assign(param);
            params.push(param);
            exprs.push(self.scope.expr(tree, &self.chance.sites, *value, &mut self.diagnostics));
        }
        self.scope.assign(None);
        let params = params.into_iter().collect::<Option<_>>()?;
        let exprs = exprs.into_iter().collect::<Option<_>>()?;
        Some((params, exprs, assignments.iter().map(|assignment| tree.expr_span(assignment.value)).collect()))
    }

    /// Expressions, with the places where they are.
    pub(super) fn exprs(&mut self, ids: impl Iterator<Item = ExprId>) -> Option<(Vec<Expr>, Vec<Span>)> {
        let mut sound = true;
        let mut exprs = Vec::new();
        let mut spans = Vec::new();
        for id in ids {
            spans.push(self.tree.expr_span(id));
            match self.scope.expr(self.tree, &self.chance.sites, id, &mut self.diagnostics) {
                Some(expr) => exprs.push(expr),
                None => sound = false,
            }
        }
        sound.then_some((exprs, spans))
    }

    /// Arguments for a signature, those of tuples one by one.
    pub(super) fn args(
        &mut self,
        signature: &str,
        summary: &str,
        name: Span,
        args: &[ExprId],
    ) -> Option<(Vec<Expr>, Vec<Span>)> {
        let tree = self.tree;
        if args.iter().any(|arg| matches!(tree.expr(*arg), syntax::Expr::Missing)) {
            return None;
        }
        let shape = Shape::of(signature);
        let given: Vec<_> = args
            .iter()
            .map(|arg| match tree.expr(*arg) {
                syntax::Expr::Tuple(items) => items.len(),
                _ => 1,
            })
            .collect();
        let text = tree.text(name);
        let help = || {
            let slip = match shape.widths.len() {
                0 => "; transformations before it give it size and place",
                arity if arity > 1 && given == [arity] => "; the numbers stand in one pair of parentheses",
                3 if given == [1] && text == TransformKind::Scale.name() => {
                    "; one factor for all is `uscale(factor)`"
                }
                1 if self.is_decimal_comma(args) => "; if this is one number, write it with a point: `0.5`",
                _ => "",
            };
            format!("`{signature}`: {summary}{slip}")
        };
        if !shape.takes(given.len()) {
            let message = match shape.widths.len() {
                0 => format!("`{text}` takes no arguments"),
                _ if shape.open => format!("`{text}` takes points, and there are none"),
                expected => format!("`{text}` takes {}, not {}", count(expected, "argument"), given.len()),
            };
            let span = args.last().map_or(name, |last| name.to(tree.expr_span(*last)));
            let report = Diagnostic::error(span, message).label("wrong arguments").help(help());
            self.diagnostics.push(report);
            return None;
        }
        for (index, (arg, width)) in args.iter().zip(&given).enumerate() {
            let expected = shape.width(index);
            if *width != expected {
                let expected = match expected {
                    1 => "a number".to_owned(),
                    _ => format!("{expected} numbers in parentheses"),
                };
                let message = format!("argument {} of `{text}` is {expected}, not {width}", index + 1);
                let report = Diagnostic::error(tree.expr_span(*arg), message);
                let report = report.label(format!("expected {expected}")).help(help());
                self.diagnostics.push(report);
                return None;
            }
        }
        let flat: Vec<ExprId> = args
            .iter()
            .flat_map(|arg| match tree.expr(*arg) {
                syntax::Expr::Tuple(items) => items.clone(),
                _ => vec![*arg],
            })
            .collect();
        self.exprs(flat.into_iter())
    }

    /// `0,5`, which is one number in many countries.
    fn is_decimal_comma(&self, args: &[ExprId]) -> bool {
        let is_number = |arg: &ExprId| matches!(self.tree.expr(*arg), syntax::Expr::Number(_));
        args.len() == 2 && args.iter().all(is_number)
    }
}

/// The arguments that a signature asks for: how many numbers each has, a tuple more than one.
struct Shape {
    widths: Vec<usize>,
    /// The last may be repeated.
    open: bool,
}

impl Shape {
    /// Reads `rot((x, y, z), angle)` as 3, 1.
    fn of(signature: &str) -> Self {
        let inside = signature.split_once('(').map_or("", |(_, rest)| rest.strip_suffix(')').unwrap_or(rest));
        let mut shape = Self { widths: Vec::new(), open: false };
        let mut rest = inside;
        while !rest.is_empty() {
            let (arg, after) = match rest.strip_prefix('(') {
                Some(tuple) => tuple.split_once(')').unwrap_or((tuple, "")),
                None => rest.split_once(',').unwrap_or((rest, "")),
            };
            match arg.trim() {
                "…" => shape.open = true,
                arg => shape.widths.push(arg.matches(',').count() + 1),
            }
            rest = after.trim_start_matches([',', ' ']);
        }
        shape
    }

    fn takes(&self, args: usize) -> bool {
        if self.open { args >= self.widths.len() } else { args == self.widths.len() }
    }

    fn width(&self, index: usize) -> usize {
        self.widths.get(index).or(self.widths.last()).copied().unwrap_or(1)
    }
}

#[cfg(test)]
mod tests {
    use csg_graph::{PrimitiveKind, TransformKind};

    use super::*;

    #[test]
    fn shapes_agree_with_the_arities_of_the_graph() {
        for kind in TransformKind::ALL {
            assert_eq!(Shape::of(kind.signature()).widths.iter().sum::<usize>(), kind.arity(), "{kind:?}");
        }
        for kind in PrimitiveKind::ALL {
            let shape = Shape::of(kind.signature());
            assert_eq!(shape.open, kind.arity().is_none(), "{kind:?}");
            assert_eq!(shape.widths.iter().sum::<usize>(), kind.arity().unwrap_or(3), "{kind:?}");
        }
        assert_eq!(Shape::of("rot((x, y, z), angle)").widths, [3, 1]);
    }
}
