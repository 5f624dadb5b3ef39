//! The numbers of keys, by their nodes and the values of the exact parameters that matter there.

use csg_graph::{Env, Graph, NodeId, ParamId};
use rustc_hash::FxHashMap;

use crate::envelope::control::Control;

/// The numbers of keys. Looking one up allocates nothing.
pub(super) struct Numbers {
    /// By the index of a node.
    nodes: Vec<Node>,
}

/// The keys of a node.
#[derive(Default)]
struct Node {
    /// What tells them apart.
    params: Vec<ParamId>,
    /// By the bits of the values.
    numbers: FxHashMap<Box<[u64]>, u32>,
}

impl Numbers {
    /// No keys yet.
    pub(super) fn new(graph: &Graph, control: &Control) -> Self {
        let params =
            |node| control.exact().iter().copied().filter(move |param| control.matters(node, *param));
        let node = |node| Node { params: params(node).collect(), numbers: FxHashMap::default() };
        Self { nodes: graph.nodes().map(|(id, _)| node(id)).collect() }
    }

    /// The number of the key of a node with these values, or `None` if there is no such key.
    pub(super) fn get(&self, node: NodeId, env: &Env) -> Option<u32> {
        const FEW: usize = 16;
        let Node { params, numbers } = &self.nodes[node.index()];
        let (mut few, mut many) = ([0; FEW], Vec::new());
        let values = if params.len() <= FEW {
            &mut few[..params.len()]
        } else {
            many.resize(params.len(), 0);
            &mut many[..]
        };
        for (value, param) in values.iter_mut().zip(params) {
            *value = bits(env, *param);
        }
        numbers.get(&*values).copied()
    }

    /// Gives a key a number, unless it has one: the one that it has then.
    pub(super) fn get_or_insert(&mut self, node: NodeId, env: &Env, fresh: u32) -> u32 {
        let Node { params, numbers } = &mut self.nodes[node.index()];
        let values = params.iter().map(|param| bits(env, *param)).collect();
        *numbers.entry(values).or_insert(fresh)
    }

    /// Gives all keys other numbers.
    pub(super) fn renumber(&mut self, new: &[u32]) {
        for node in &mut self.nodes {
            node.numbers.values_mut().for_each(|key| *key = new[*key as usize]);
        }
    }

    /// About how much memory this holds.
    pub(super) fn bytes(&self) -> usize {
        let entry = |node: &Node| size_of::<(Box<[u64]>, u32)>() * 2 + size_of_val(&*node.params) * 2;
        self.nodes.iter().map(|node| size_of_val(node) + node.numbers.len() * entry(node)).sum()
    }
}

/// The bits of a value; those of what is not a number, if there is none.
fn bits(env: &Env, param: ParamId) -> u64 {
    env.get(param).unwrap_or(f64::NAN).to_bits()
}
