//! Terms become nodes.
//!
//! The terms of a tree are in postfix order, so that one pass over a rule's terms meets the parts of each before itself.

use std::collections::BTreeSet;

use csg_graph::{AttributeTerm, NodeId, PrimitiveKind};

use super::Lowering;
use super::definitions::{Defined, Definitions};
use crate::names::{self, COLOR_SIGNATURE, guess};
use crate::syntax::{ExprId, Prefix, PrefixKind, Term, TermId};
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
            let selection = selection_id
                .and_then(|id| self.scope.expr(tree, &self.chance.sites, id, &mut self.diagnostics));
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
            self.angles_in_radians();
        }
        root
    }

    /// The node of a term, with everything below it.
    fn term(&mut self, body: TermId, definitions: &Definitions<'_>, nodes: &mut Nodes) -> Option<NodeId> {
        for id in self.tree.subterms(body) {
            let span = self.tree.term_span(id);
            let node = match self.tree.term(id) {
                Term::Solid { name, args } => self.solid(id, *name, args, definitions, nodes),
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
        id: TermId,
        name: Span,
        args: &[ExprId],
        definitions: &Definitions<'_>,
        nodes: &mut Nodes,
    ) -> Option<NodeId> {
        let (text, span) = (self.tree.text(name), self.tree.term_span(id));
        if let Some(kind) = PrimitiveKind::named(text) {
            let (exprs, spans) = self.args(kind.signature(), kind.summary(), name, args)?;
            let node = self.builder.primitive(kind, exprs);
            self.sources.record(node, span, spans);
            return Some(node);
        }
        let Some(found) = definitions.get(text) else {
            if nodes.reported.insert(text.to_owned()) {
                let report = self.unknown_solid(text, name, definitions);
                self.diagnostics.push(report);
            }
            return None;
        };
        if !args.is_empty() {
            self.diagnostics.push(
                Diagnostic::error(span, format!("`{text}` takes no arguments"))
                    .label("arguments here")
                    .help("symbols and macros read parameters; set them before: `{n = n - 1} NAME`"),
            );
        }
        let node = match found {
            Defined::Symbol(index) => Some(nodes.symbols[index]),
            Defined::Macro(index) => nodes.macros[index],
        };
        node.map(|node| self.reference(id, found, node))
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
                (self.builder.transform(*kind, exprs, body?), spans)
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
                let (params, exprs, spans) = self.calculation(assignments)?;
                (self.builder.calculate(params.into_iter().zip(exprs), body?), spans)
            }
        };
        self.sources.record(node, prefix.span, spans);
        Some(node)
    }

    fn name_of(&self, prefix: &Prefix, name: &str) -> Span {
        Span { start: prefix.span.start, end: prefix.span.start + name.len() }
    }
}
