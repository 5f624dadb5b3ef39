//! Which parameters can still be read at or below a node.
//!
//! The classic backward data-flow problem of compilers, on a graph that may be cyclic: live(node) is what the node reads
//! together with live(child) less what the node assigns, iterated to the least fixed point. Parameters that no C-node
//! assigns have one value everywhere; they never tell states apart and count as dead.

use crate::node::Calculation;
use crate::{Node, NodeId, ParamId};

/// For each node, a set of parameters as a row of bits.
#[derive(Clone, Debug)]
pub(crate) struct Liveness {
    words: usize,
    rows: Vec<u64>,
    /// One more row: the parameters that some C-node assigns.
    assigned: Vec<u64>,
    /// For each C-node, whether its assignments are read, by a later one that is or below.
    needed: Vec<Box<[bool]>>,
}

impl Liveness {
    pub(crate) fn new(nodes: &[Node], params: usize) -> Self {
        let words = params.div_ceil(64);
        let mut assigned = vec![0; words];
        for node in nodes {
            if let Node::Calculation(calculation) = node {
                calculation.assignments.iter().for_each(|(param, _)| insert(&mut assigned, *param));
            }
        }
        let rows = vec![0; words * nodes.len()];
        let mut liveness = Self { words, rows, assigned, needed: vec![Box::default(); nodes.len()] };
        if words > 0 {
            liveness.iterate(nodes);
        }
        for (index, node) in nodes.iter().enumerate() {
            if let Node::Calculation(calculation) = node {
                let mut live = liveness.row(calculation.body.index()).to_vec();
                liveness.needed[index] = calculation.read_backwards(&mut live);
            }
        }
        liveness
    }

    pub(crate) fn is_live(&self, node: NodeId, param: ParamId) -> bool {
        self.row(node.index())[param.index() / 64] >> (param.index() % 64) & 1 != 0
    }

    /// Whether anything reads what a C-node assigns, of several assignments with this index.
    pub(crate) fn is_needed(&self, calculation: NodeId, index: usize) -> bool {
        self.needed[calculation.index()][index]
    }

    /// The parameters that some C-node assigns and that no state of the node has a value for.
    pub(crate) fn dead(&self, node: NodeId) -> impl Iterator<Item = ParamId> {
        let words = self.assigned.iter().zip(self.row(node.index())).map(|(assigned, live)| assigned & !live);
        words.enumerate().flat_map(|(word, dead)| {
            // Each time without the lowest bit.
            let left = std::iter::successors(Some(dead), |left| Some(left & left.wrapping_sub(1)));
            let bits = left.take_while(|left| *left != 0).map(|left| left.trailing_zeros() as usize);
            bits.map(move |bit| ParamId::from_index(64 * word + bit))
        })
    }

    /// Whether some C-node assigns the parameter.
    pub(crate) fn is_assigned(&self, param: ParamId) -> bool {
        self.assigned[param.index() / 64] >> (param.index() % 64) & 1 != 0
    }

    fn row(&self, node: usize) -> &[u64] {
        &self.rows[node * self.words..(node + 1) * self.words]
    }

    /// A worklist: when a row grows, the rows of its parents are computed again.
    fn iterate(&mut self, nodes: &[Node]) {
        let mut parents = vec![Vec::new(); nodes.len()];
        for (index, node) in nodes.iter().enumerate() {
            for child in node.children() {
                parents[child.index()].push(index);
            }
        }
        let mut queued = vec![true; nodes.len()];
        // Builders make children before parents, so that most rows settle at once in this order.
        let mut queue: std::collections::VecDeque<usize> = (0..nodes.len()).collect();
        while let Some(index) = queue.pop_front() {
            queued[index] = false;
            let row = self.compute(&nodes[index]);
            if row != self.row(index) {
                self.rows[index * self.words..(index + 1) * self.words].copy_from_slice(&row);
                for &parent in &parents[index] {
                    if !std::mem::replace(&mut queued[parent], true) {
                        queue.push_back(parent);
                    }
                }
            }
        }
    }

    fn compute(&self, node: &Node) -> Vec<u64> {
        let mut live = vec![0; self.words];
        for child in node.children() {
            live.iter_mut().zip(self.row(child.index())).for_each(|(live, below)| *live |= below);
        }
        if let Node::Calculation(calculation) = node {
            calculation.read_backwards(&mut live);
        } else {
            node.exprs().into_iter().flat_map(|expr| expr.params()).for_each(|read| insert(&mut live, read));
        }
        live.iter_mut().zip(&self.assigned).for_each(|(live, assigned)| *live &= assigned);
        live
    }
}

impl Calculation {
    /// From what is live below to what is live here, and which assignments are needed for that: one to a dead parameter
    /// reads nothing.
    fn read_backwards(&self, live: &mut [u64]) -> Box<[bool]> {
        let mut needed = vec![false; self.assignments.len()];
        for (is_needed, (param, expr)) in needed.iter_mut().zip(&self.assignments).rev() {
            let (word, bit) = (param.index() / 64, 1 << (param.index() % 64));
            *is_needed = live[word] & bit != 0;
            if *is_needed {
                live[word] &= !bit;
                expr.params().for_each(|read| insert(live, read));
            }
        }
        needed.into()
    }
}

fn insert(row: &mut [u64], param: ParamId) {
    row[param.index() / 64] |= 1 << (param.index() % 64);
}
