//! From the syntax tree to the graph: the paper's direct translation of a CSG-PL-system ([TRAX95] §1).
//!
//! A symbol becomes an S-node with its rules below it, an occurrence of a symbol an edge to that node. A macro becomes
//! the nodes of its term, made once and shared by all that name it. Prefixes become C-, T- and attribute nodes. Where there
//! are random numbers, a reference gets a C-node that derives the seed. All mistakes in names, counts of arguments and
//! numbers of rules are collected before giving up.

mod args;
mod chance;
mod definitions;
mod doubts;
mod expr;
mod parameters;
mod scene_blocks;
mod term;

use csg_graph::{Graph, GraphBuilder};

use crate::explain;
use crate::syntax::SyntaxTree;
use crate::{Diagnostic, Look, Override, Parsed, SourceMap, parse};
use chance::Chance;
use definitions::Definitions;
use expr::Scope;

/// A file with a meaning: what to build, where each part of it was written, and how to look at it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What to build.
    pub graph: Graph,
    /// Where its nodes were written.
    pub sources: SourceMap,
    /// How to look at it.
    pub look: Look,
}

/// A scene, and what is doubtful about the file.
#[derive(Clone, Debug)]
pub struct Lowered {
    /// The scene.
    pub scene: Scene,
    /// The doubts, in the order of the text. None of them is an error.
    pub warnings: Vec<Diagnostic>,
}

/// Parses a file and translates it: [`parse`] and [`lower`].
///
/// ```
/// let source = "{ n = 60; } DUST
/// DUST if(n > 0, 2, 1)
/// 1: DUST -> sphere
/// 2: DUST -> {n = n-1} (move(-1,0,0) uscale(1/3) DUST | move(1,0,0) uscale(1/3) DUST)";
/// let scene = csg_graph_grammar::load(source, &[]).unwrap().scene;
/// let analysis = scene.graph.analyse(&Default::default())?;
/// assert_eq!(analysis.primitives.to_string(), "1152921504606846976");
/// # Ok::<(), csg_graph::StatesError>(())
/// ```
///
/// # Errors
/// Everything that is wrong with the file, in the order of the text.
pub fn load(source: &str, overrides: &[Override]) -> Result<Lowered, Vec<Diagnostic>> {
    let Parsed { tree, diagnostics } = parse(source);
    let all = |more: Vec<Diagnostic>| {
        let mut all = diagnostics;
        all.extend(more);
        sort(&mut all);
        all
    };
    match lower(&tree, overrides) {
        Ok(Lowered { scene, warnings }) => Ok(Lowered { scene, warnings: all(warnings) }),
        Err(errors) => Err(all(errors)),
    }
}

/// Translates a tree into a graph. Each override takes the place of the initial value of its parameter.
///
/// # Errors
/// If a name means nothing, arguments do not fit, rules are not numbered from 1, the graph is not sound, and so on: all
/// that could be found, in the order of the text, together with the doubts. A [damaged](SyntaxTree::is_damaged) tree is an
/// error by itself, though what [`parse`] said of it is not said again.
pub fn lower(tree: &SyntaxTree, overrides: &[Override]) -> Result<Lowered, Vec<Diagnostic>> {
    let mut lowering = Lowering {
        tree,
        builder: GraphBuilder::new(),
        scope: Scope::default(),
        sources: SourceMap::default(),
        chance: Chance::default(),
        diagnostics: Vec::new(),
    };
    let definitions = Definitions::collect(tree, &mut lowering.diagnostics);
    lowering.chance = Chance::of(tree, &definitions);
    lowering.scope.note_solids(definitions.names());
    lowering.initial_parameters(overrides);
    let look = lowering.scene_blocks();
    lowering.calculated_parameters();
    let root = lowering.graph_of(&definitions);
    let sound = lowering.is_sound();

    let Lowering { builder, sources, mut diagnostics, .. } = lowering;
    let graph = match root {
        Some(root) if sound => builder
            .finish(root)
            .map_err(|error| diagnostics.extend(explain::graph_error(&sources, &error)))
            .ok(),
        _ => None,
    };
    sort(&mut diagnostics);
    match graph {
        Some(graph) => Ok(Lowered { scene: Scene { graph, sources, look }, warnings: diagnostics }),
        None => Err(diagnostics),
    }
}

/// Diagnostics about the file in its order, then those about values from outside.
pub(crate) fn sort(diagnostics: &mut [Diagnostic]) {
    diagnostics.sort_by_key(|diagnostic| (diagnostic.excerpt.is_some(), diagnostic.primary.span.start));
}

/// A translation under way.
struct Lowering<'t> {
    tree: &'t SyntaxTree,
    builder: GraphBuilder,
    scope: Scope<'t>,
    sources: SourceMap,
    chance: Chance,
    diagnostics: Vec<Diagnostic>,
}

impl Lowering<'_> {
    /// Whether nothing is known to be wrong. Until then, what seems unused may be used in what is wrong.
    fn is_sound(&self) -> bool {
        !self.tree.is_damaged() && !self.diagnostics.iter().any(Diagnostic::is_error)
    }
}
