//! Terms become nodes.
//!
//! The terms of a tree are in postfix order, so that one pass over a rule's terms meets the parts of each before itself.

use std::collections::BTreeSet;

use csg_graph::{AttributeTerm, Expr, NodeId, PrimitiveKind, TransformKind};

use super::Lowering;
use super::definitions::{Defined, Definitions};
use super::expr::count;
use crate::names::{self, COLOR_SIGNATURE, guess, nearest};
use crate::syntax::{self, Assignment, ExprId, Prefix, PrefixKind, Term, TermId};
use crate::{Diagnostic, Span};

/// The nodes that names and terms have become. What is a mistake has none.
struct Nodes {
    symbols: Vec<NodeId>,
    macros: Vec<Option<NodeId>>,
    terms: Vec<Option<NodeId>>,
    /// Names that have been reported as unknown.
    reported: BTreeSet<String>,
}

impl Lowering<'_> {
    /// Builds the graph and gives its root, if the axiom makes one.
    pub(super) fn graph_of(&mut self, definitions: &Definitions<'_>) -> Option<NodeId> {
        let tree = self.tree;
        let mut nodes = Nodes {
            symbols: Vec::new(),
            macros: vec![None; definitions.macros.len()],
            terms: vec![None; tree.terms.len()],
            reported: BTreeSet::new(),
        };
        for symbol in &definitions.symbols {
            let node = self.builder.symbol(symbol.name);
            self.sources.record(node, symbol.span, []);
            nodes.symbols.push(node);
        }
        for index in definitions.macros_in_order(tree, &mut self.diagnostics) {
            nodes.macros[index] = self.term(definitions.macros[index].body, definitions, &mut nodes);
        }
        for (symbol, node) in definitions.symbols.iter().zip(nodes.symbols.clone()) {
            let selection_id = symbol.header.and_then(|header| header.selection);
            let selection = selection_id.and_then(|id| self.scope.expr(tree, id, &mut self.diagnostics));
            let bodies: Vec<_> = symbol
                .rules
                .iter()
                .filter_map(|rule| self.term(rule.body, definitions, &mut nodes))
                .collect();
            self.builder.rules(node, selection, bodies);
            let spans = symbol
                .rules
                .iter()
                .map(|rule| rule.number.unwrap_or(rule.symbol).to(tree.term_span(rule.body)));
            self.sources.record_rules(node, selection_id.map(|id| tree.expr_span(id)), spans.collect());
        }
        let axiom = tree.axiom()?;
        let root = self.term(axiom, definitions, &mut nodes);
        if self.is_sound() {
            self.unused_solids(axiom, definitions);
            self.unused_parameters();
        }
        root
    }

    /// The node of a term, with everything below it.
    fn term(&mut self, body: TermId, definitions: &Definitions<'_>, nodes: &mut Nodes) -> Option<NodeId> {
        for id in self.tree.subterms(body) {
            let span = self.tree.term_span(id);
            let node = match self.tree.term(id) {
                Term::Solid { name, args } => self.solid(*name, args, span, definitions, nodes),
                Term::Prefixed { prefix, body } => {
                    let body = nodes.terms[body.index()];
                    self.prefix(prefix, body)
                }
                Term::Operator { operator, left, right } => {
                    let operands = nodes.terms[left.index()].zip(nodes.terms[right.index()]);
                    operands.map(|(left, right)| {
                        let node = self.builder.operator(*operator, left, right);
                        self.sources.record(node, span, []);
                        node
                    })
                }
                Term::Parenthesised(inside) => nodes.terms[inside.index()],
                Term::Missing => None,
            };
            nodes.terms[id.index()] = node;
        }
        nodes.terms[body.index()]
    }

    fn solid(
        &mut self,
        name: Span,
        args: &[ExprId],
        span: Span,
        definitions: &Definitions<'_>,
        nodes: &mut Nodes,
    ) -> Option<NodeId> {
        let text = self.tree.text(name);
        let found = definitions.get(text);
        if let Some(kind) = PrimitiveKind::named(text) {
            let (exprs, spans) = self.args(kind.signature(), kind.summary(), name, args)?;
            let node = self.builder.primitive(kind, exprs);
            self.sources.record(node, span, spans);
            return Some(node);
        }
        if found.is_none() {
            if nodes.reported.insert(text.to_owned()) {
                let report = self.unknown_solid(text, name, definitions);
                self.diagnostics.push(report);
            }
            return None;
        }
        if !args.is_empty() {
            self.diagnostics.push(
                Diagnostic::error(span, format!("`{text}` takes no arguments"))
                    .label("arguments here")
                    .help("symbols and macros read parameters; set them before: `{n = n - 1} NAME`"),
            );
        }
        match found? {
            Defined::Symbol(index) => Some(nodes.symbols[index]),
            Defined::Macro(index) => nodes.macros[index],
        }
    }

    fn unknown_solid(&self, name: &str, span: Span, definitions: &Definitions<'_>) -> Diagnostic {
        let solids = definitions.names().chain(names::primitives());
        let told = &self.diagnostics;
        let help = match guess(told, name, solids).or_else(|| guess(told, name, names::prefixes())) {
            Some(known) => format!("did you mean `{known}`? If not, define it: `{name} = …`"),
            None if self.scope.get(name).is_some() => {
                format!("`{name}` is a parameter, a number; to set it, write `{{{name} = …}}`")
            }
            None => format!("define it, as a macro `{name} = …` or as a symbol `{name} -> …`"),
        };
        Diagnostic::error(span, format!("unknown solid `{name}`")).label("unknown").help(help)
    }

    /// The node of a prefix above its body. The prefix is checked even where the body is a mistake.
    fn prefix(&mut self, prefix: &Prefix, body: Option<NodeId>) -> Option<NodeId> {
        let (node, spans) = match &prefix.kind {
            PrefixKind::Transform(kind, args) => {
                let name = self.name_of(prefix, kind.name());
                let (exprs, spans) = self.args(kind.signature(), kind.summary(), name, args)?;
                (self.builder.transform(TransformKind::clone(kind), exprs, body?), spans)
            }
            PrefixKind::Color(args) => {
                let name = self.name_of(prefix, names::COLOR);
                let (exprs, spans) = self.args(COLOR_SIGNATURE, "the pigment, linear, 0 to 1", name, args)?;
                let node = self.builder.attribute(AttributeTerm::COLOR.into_iter().zip(exprs), body?);
                self.sources.record_attribute(node, names::COLOR);
                (node, spans)
            }
            PrefixKind::Material(args) => {
                let (terms, exprs, spans) = self.material(args)?;
                let node = self.builder.attribute(terms.into_iter().zip(exprs), body?);
                self.sources.record_attribute(node, names::MATERIAL);
                (node, spans)
            }
            PrefixKind::Calculation(assignments) if assignments.is_empty() => return body,
            PrefixKind::Calculation(assignments) => {
                let (exprs, spans) = self.exprs(assignments.iter().map(|assignment| assignment.value))?;
                let params =
                    assignments.iter().map(|assignment| self.scope.get(self.tree.text(assignment.name)));
                let params: Option<Vec<_>> = params.collect();
                (self.builder.calculate(params?.into_iter().zip(exprs), body?), spans)
            }
        };
        self.sources.record(node, prefix.span, spans);
        Some(node)
    }

    fn name_of(&self, prefix: &Prefix, name: &str) -> Span {
        Span { start: prefix.span.start, end: prefix.span.start + name.len() }
    }

    fn material(&mut self, args: &[Assignment]) -> Option<(Vec<AttributeTerm>, Vec<Expr>, Vec<Span>)> {
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

    fn exprs(&mut self, ids: impl Iterator<Item = ExprId>) -> Option<(Vec<Expr>, Vec<Span>)> {
        let mut sound = true;
        let mut exprs = Vec::new();
        let mut spans = Vec::new();
        for id in ids {
            spans.push(self.tree.expr_span(id));
            match self.scope.expr(self.tree, id, &mut self.diagnostics) {
                Some(expr) => exprs.push(expr),
                None => sound = false,
            }
        }
        sound.then_some((exprs, spans))
    }

    /// Arguments for a signature, those of tuples one by one.
    fn args(
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
        let help = || match shape.widths.len() {
            0 => format!("`{signature}`: {summary}; transformations before it give it size and place"),
            _ => format!("`{signature}`: {summary}"),
        };
        if !shape.takes(given.len()) {
            let message = match shape.widths.len() {
                0 => format!("`{text}` takes no arguments"),
                _ if shape.open => format!("`{text}` takes points, and there are none"),
                expected => format!("`{text}` takes {}, not {}", count(expected, "argument"), given.len()),
            };
            let span = args.last().map_or(name, |last| name.to(tree.expr_span(*last)));
            self.diagnostics.push(Diagnostic::error(span, message).label("wrong arguments").help(help()));
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
                self.diagnostics.push(report.label(format!("expected {expected}")).help(help()));
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
