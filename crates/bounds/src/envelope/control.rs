//! Which parameters decide what is below a state, and how.
//!
//! A parameter *matters* at a node if a range below it depends on its value: the backward data flow of liveness, except
//! that colours do not matter, nor do arguments that only feed chance, such as the seed: whatever their value, the numbers
//! that are drawn are in the same range. Of those that matter,
//!
//! - *exact* ones take the same values in every instance: no random number has a part in them. A counter of levels is
//!   one. They are part of a key.
//! - *varying* ones are everything else, and known by intervals.

use std::collections::VecDeque;

use csg_graph::{Expr, Graph, Node, NodeId, ParamId};

/// The parts that the parameters of a graph have.
pub(super) struct Control {
    exact: Vec<ParamId>,
    varying: Vec<ParamId>,
    assigned: Vec<ParamId>,
    /// For each node, a row that says of each parameter whether it matters there.
    matters: Vec<bool>,
    params: usize,
}

impl Control {
    /// `inexact` parameters are not exact, even if they could be.
    pub(super) fn new(graph: &Graph, inexact: &[ParamId]) -> Self {
        let params = graph.params().len();
        let (matters, somewhere) = matters(graph);
        let erratic = erratic(graph, inexact);
        let mut control =
            Self { exact: Vec::new(), varying: Vec::new(), assigned: Vec::new(), matters, params };
        let is_assigned = assigned(graph);
        for param in graph.params().filter(|param| is_assigned[param.index()]) {
            control.assigned.push(param);
            if somewhere[param.index()] {
                let list = if erratic[param.index()] { &mut control.varying } else { &mut control.exact };
                list.push(param);
            }
        }
        control
    }

    pub(super) fn exact(&self) -> &[ParamId] {
        &self.exact
    }

    pub(super) fn is_exact(&self, param: ParamId) -> bool {
        self.exact.contains(&param)
    }

    /// The place of a parameter among those that vary, if it does.
    pub(super) fn place(&self, param: ParamId) -> Option<usize> {
        self.varying.iter().position(|varying| *varying == param)
    }

    pub(super) fn varying(&self) -> &[ParamId] {
        &self.varying
    }

    /// Parameters that some C-node changes.
    pub(super) fn assigned(&self) -> &[ParamId] {
        &self.assigned
    }

    pub(super) fn matters(&self, node: NodeId, param: ParamId) -> bool {
        self.matters[node.index() * self.params + param.index()]
    }

    /// Whether what is below a node depends on a varying parameter.
    pub(super) fn varies(&self, node: NodeId) -> bool {
        self.varying.iter().any(|param| self.matters(node, *param))
    }

    /// Whether the range of an expression depends on a varying parameter.
    pub(super) fn varies_in<'a>(&self, exprs: impl IntoIterator<Item = &'a Expr>) -> bool {
        exprs.into_iter().any(|expr| expr.range_params().iter().any(|param| self.varying.contains(param)))
    }
}

fn assignments(graph: &Graph) -> impl Iterator<Item = &(ParamId, Expr)> {
    graph.nodes().flat_map(|(_, node)| match node {
        Node::Calculation(node) => node.assignments.as_slice(),
        _ => &[],
    })
}

fn assigned(graph: &Graph) -> Vec<bool> {
    let mut assigned = vec![false; graph.params().len()];
    assignments(graph).for_each(|(param, _)| assigned[param.index()] = true);
    assigned
}

/// Parameters whose values no one foresees: chance has a part in them, or in what they are calculated from.
fn erratic(graph: &Graph, inexact: &[ParamId]) -> Vec<bool> {
    let mut erratic = vec![false; graph.params().len()];
    inexact.iter().for_each(|param| erratic[param.index()] = true);
    let mut changed = true;
    while changed {
        changed = false;
        for (param, expr) in assignments(graph) {
            let infects = expr.is_erratic() || expr.params().any(|read| erratic[read.index()]);
            changed |= infects && !std::mem::replace(&mut erratic[param.index()], true);
        }
    }
    erratic
}

/// For each node and parameter, whether a range there or below depends on it: iterated to the least fixed point. And for
/// each parameter, whether it matters anywhere, be it only between two assignments of a C-node.
fn matters(graph: &Graph) -> (Vec<bool>, Vec<bool>) {
    let params = graph.params().len();
    let read: Vec<Vec<Vec<ParamId>>> = graph
        .nodes()
        .map(|(_, node)| match node {
            Node::Attribute(_) => Vec::new(),
            node => node.exprs().into_iter().map(Expr::range_params).collect(),
        })
        .collect();
    let mut parents = vec![Vec::new(); graph.node_count()];
    for (id, node) in graph.nodes() {
        node.children().iter().for_each(|child| parents[child.index()].push(id));
    }
    let mut rows = vec![false; params * graph.node_count()];
    let mut somewhere = vec![false; params];
    let mut queued = vec![true; graph.node_count()];
    let mut queue: VecDeque<NodeId> = graph.nodes().map(|(id, _)| id).collect();
    while let Some(id) = queue.pop_front() {
        queued[id.index()] = false;
        let node = graph.node(id);
        let mut row = vec![false; params];
        for child in node.children() {
            let below = &rows[child.index() * params..][..params];
            row.iter_mut().zip(below).for_each(|(row, below)| *row |= below);
        }
        if let Node::Calculation(node) = node {
            // Backwards: an assignment to what does not matter reads nothing.
            for ((param, _), read) in node.assignments.iter().zip(&read[id.index()]).rev() {
                if std::mem::replace(&mut row[param.index()], false) {
                    somewhere[param.index()] = true;
                    read.iter().for_each(|read| row[read.index()] = true);
                }
            }
        } else {
            read[id.index()].iter().flatten().for_each(|read| row[read.index()] = true);
        }
        somewhere.iter_mut().zip(&row).for_each(|(somewhere, here)| *somewhere |= here);
        let old = &mut rows[id.index() * params..][..params];
        if old != row {
            old.copy_from_slice(&row);
            for parent in &parents[id.index()] {
                if !std::mem::replace(&mut queued[parent.index()], true) {
                    queue.push_back(*parent);
                }
            }
        }
    }
    (rows, somewhere)
}
