//! Where the nodes of a graph were written.

use std::collections::BTreeMap;

use csg_graph::{NodeId, Place};

use crate::Span;

/// For each node of a graph and each of its expressions, the place in the file where it was written.
#[derive(Clone, Debug, Default)]
pub struct SourceMap {
    nodes: Vec<Source>,
    /// The rules of the S-nodes, which are the first nodes of a graph.
    rules: Vec<Vec<Span>>,
    /// What attribute nodes are called; the graph knows only their terms.
    attributes: BTreeMap<NodeId, &'static str>,
}

#[derive(Clone, Debug)]
struct Source {
    span: Span,
    exprs: Box<[Span]>,
}

impl SourceMap {
    /// A node: the name of a symbol where it is defined, a prefix without its factor, an operator with its operands.
    ///
    /// # Panics
    /// If the node is of another graph.
    pub fn node(&self, node: NodeId) -> Span {
        self.nodes[node.index()].span
    }

    /// The expression at that position of [`csg_graph::Node::exprs`], or the node if it has no such expression.
    ///
    /// # Panics
    /// If the node is of another graph.
    pub fn expr(&self, node: NodeId, index: usize) -> Span {
        let source = &self.nodes[node.index()];
        source.exprs.get(index).copied().unwrap_or(source.span)
    }

    /// The rules of an S-node in the order of their numbers, each from its number to its end. None for other nodes.
    pub fn rules(&self, symbol: NodeId) -> &[Span] {
        self.rules.get(symbol.index()).map_or(&[], Vec::as_slice)
    }

    /// The place that an error of an evaluation names.
    ///
    /// # Panics
    /// If the node is of another graph.
    pub fn place(&self, place: &Place) -> Span {
        place.expr.map_or_else(|| self.node(place.node), |index| self.expr(place.node, index))
    }

    /// What the node of a place is called in the language.
    pub(crate) fn name<'a>(&'a self, place: &'a Place) -> &'a str {
        self.attributes.get(&place.node).copied().unwrap_or(&place.label)
    }

    /// Gives an attribute node its name.
    pub(crate) fn record_attribute(&mut self, node: NodeId, name: &'static str) {
        self.attributes.insert(node, name);
    }

    /// Nodes are recorded in the order in which they are built.
    pub(crate) fn record(&mut self, node: NodeId, span: Span, exprs: impl IntoIterator<Item = Span>) {
        debug_assert_eq!(node.index(), self.nodes.len(), "every node is recorded when it is built");
        self.nodes.push(Source { span, exprs: exprs.into_iter().collect() });
    }

    /// Completes what is known of an S-node, when its rules are.
    pub(crate) fn record_rules(&mut self, symbol: NodeId, selection: Option<Span>, rules: Vec<Span>) {
        self.nodes[symbol.index()].exprs = selection.into_iter().collect();
        let index = symbol.index();
        if self.rules.len() <= index {
            self.rules.resize(index + 1, Vec::new());
        }
        self.rules[index] = rules;
    }
}
