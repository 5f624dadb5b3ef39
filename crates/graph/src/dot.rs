//! The graph as a drawing, for Graphviz, in the manner of Fig. 1.1b of the paper: S-nodes with their selection functions
//! and numbered edges to the rules, C- and T-nodes in between, operators as circles, and the cycles back up.

use std::fmt::Write;

use rustc_hash::FxHashSet;

use crate::{Expr, Graph, Node, NodeId};

impl Graph {
    /// The graph in the DOT language, nodes below the root only.
    ///
    /// Render it with `dot -Tsvg`.
    pub fn to_dot(&self) -> String {
        let mut out = String::from(
            "digraph csg {\n    rankdir = TB;\n    nodesep = 0.25;\n    ranksep = 0.3;\n    \
             node [fontname = \"Helvetica\", fontsize = 11];\n    \
             edge [fontname = \"Helvetica\", fontsize = 10, arrowsize = 0.6];\n\n    \
             start [shape = point];\n",
        );
        let Reached { nodes, backward } = self.reached();
        for &id in &nodes {
            let label = self.dot_label(id).replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            let _ = writeln!(out, "    {id:?} [label = \"{label}\", {}];", style(self.node(id)));
        }
        let _ = writeln!(out, "\n    start -> {:?};", self.root());
        for &id in &nodes {
            let node = self.node(id);
            for (index, child) in node.children().iter().enumerate() {
                let numbered = matches!(node, Node::Symbol(symbol) if symbol.rules.len() > 1);
                let mut attributes = Vec::new();
                if numbered {
                    attributes.push(format!("label = \"{}\"", index + 1));
                }
                // An edge that closes a cycle must not pull its symbol down.
                if backward.contains(&(id, index)) {
                    attributes.push("constraint = false, style = dashed".to_owned());
                }
                let list = if attributes.is_empty() {
                    String::new()
                } else {
                    format!(" [{}]", attributes.join(", "))
                };
                let _ = writeln!(out, "    {id:?} -> {child:?}{list};");
            }
        }
        out.push_str("}\n");
        out
    }

    fn reached(&self) -> Reached {
        let mut reached = Reached::default();
        let mut seen = vec![false; self.node_count()];
        let mut on_path = vec![false; self.node_count()];
        let mut path = vec![(self.root(), 0)];
        while let Some((id, next)) = path.last_mut() {
            let (id, index) = (*id, *next);
            *next += 1;
            if !std::mem::replace(&mut seen[id.index()], true) {
                reached.nodes.push(id);
                on_path[id.index()] = true;
            }
            match self.node(id).children().get(index) {
                None => {
                    on_path[id.index()] = false;
                    path.pop();
                }
                Some(child) if on_path[child.index()] => {
                    reached.backward.insert((id, index));
                }
                Some(child) if seen[child.index()] => {}
                Some(child) => path.push((*child, 0)),
            }
        }
        reached
    }

    fn dot_label(&self, id: NodeId) -> String {
        let text = |expr: &Expr| expr.to_text(|param| self.param_name(param));
        let call = |name: &str, args: &[Expr]| {
            let list: Vec<_> = args.iter().map(text).collect();
            if list.is_empty() { name.to_owned() } else { format!("{name}({})", list.join(", ")) }
        };
        match self.node(id) {
            Node::Symbol(symbol) => match &symbol.selection {
                Some(selection) => format!("{}\n{}", symbol.name, text(selection)),
                None => symbol.name.clone(),
            },
            Node::Calculation(node) => {
                let assign =
                    |(param, expr): &(_, Expr)| format!("{} = {}", self.param_name(*param), text(expr));
                let list: Vec<_> = node.assignments.iter().map(assign).collect();
                format!("{{{}}}", list.join("; "))
            }
            Node::Transformation(node) => call(node.kind.name(), &node.args),
            Node::Primitive(node) => call(node.kind.name(), &node.args),
            Node::Attribute(node) => {
                let list: Vec<_> =
                    node.terms.iter().map(|(term, expr)| format!("{} {}", term.name(), text(expr))).collect();
                list.join("\n")
            }
            Node::Operator(node) => node.operator.sign().to_owned(),
        }
    }
}

/// What a depth-first search from the root finds.
#[derive(Default)]
struct Reached {
    /// The nodes below the root, each once, parents first.
    nodes: Vec<NodeId>,
    /// The edges back to a node on the way from the root: a node, and which of its children.
    backward: FxHashSet<(NodeId, usize)>,
}

fn style(node: &Node) -> &'static str {
    match node {
        Node::Symbol(_) => "shape = ellipse, style = filled, fillcolor = \"#ffe9a8\"",
        Node::Calculation(_) => "shape = box, style = \"rounded,filled\", fillcolor = \"#d9ead3\"",
        Node::Transformation(_) => "shape = box, style = filled, fillcolor = \"#cfe2f3\"",
        Node::Attribute(_) => "shape = note, style = filled, fillcolor = \"#f4cccc\"",
        Node::Operator(_) => "shape = circle, width = 0.3, fixedsize = true",
        Node::Primitive(_) => "shape = box, penwidth = 2",
    }
}
