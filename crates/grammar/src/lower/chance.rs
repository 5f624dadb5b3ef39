//! Chance: what every random number is a function of.
//!
//! All of it comes from one parameter, [`SEED`], and from places in the text. A reference to a symbol or a macro hands down
//! a seed of its own, derived from the seed above it and from its *position*, its number within the rule; a call of a
//! random function draws from the seed where it is evaluated, at a *site* that says which call it is. Both are counted
//! here, from the left, before anything is translated.
//!
//! A reference changes the seed only where something below may read it. So a grammar without random numbers becomes the
//! same graph as if there were none in the language, and the sure parts of a random one keep their few states.

use csg_graph::{Function, NodeId, ParamId};

use super::Lowering;
use super::definitions::{Defined, Definitions};
use crate::Span;
use crate::names::SEED;
use crate::syntax::{Assignment, Expr, ExprId, Item, PrefixKind, SyntaxTree, Term, TermId};

/// What a call belongs to. From one seed, calls of different streams draw different numbers.
#[derive(Clone, Copy, PartialEq)]
enum Stream {
    /// A rule, a macro, or the axiom.
    Solid,
    /// A selection function, which draws from the same seed as the rule that it selects.
    Selection,
    /// The initial parameters.
    Initial,
    /// The scene blocks, all together.
    Blocks,
}

/// For each expression of a tree, its site if it is a call of a random function.
#[derive(Default)]
pub(super) struct Sites(Vec<u32>);

impl Sites {
    /// The sites of a value from outside the file, which continue those of the initial parameters. `drawn` is how many
    /// there were, and becomes how many there are.
    pub(super) fn outside(tree: &SyntaxTree, drawn: &mut u32) -> Self {
        let mut sites = Self(vec![0; tree.exprs.len()]);
        sites.number(&random_calls(tree), Stream::Initial, drawn);
        sites
    }

    pub(super) fn of(&self, call: ExprId) -> u32 {
        self.0[call.index()]
    }

    /// Numbers calls in the order of the text.
    fn number(&mut self, calls: &[(usize, ExprId)], stream: Stream, drawn: &mut u32) {
        for (_, call) in calls {
            *drawn += 1;
            self.0[call.index()] = *drawn * 4 + stream as u32;
        }
    }
}

/// The randomness of a file.
#[derive(Default)]
pub(super) struct Chance {
    pub(super) sites: Sites,
    /// How many random numbers the initial parameters draw.
    pub(super) drawn: u32,
    /// Something reads the hidden seed.
    pub(super) is_seeded: bool,
    /// For each term that refers to a symbol or a macro, its number within the rule, the macro or the axiom.
    positions: Vec<u32>,
    /// Whether something at or below a definition may read the hidden seed.
    symbols: Vec<bool>,
    macros: Vec<bool>,
}

impl Chance {
    pub(super) fn of(tree: &SyntaxTree, definitions: &Definitions<'_>) -> Self {
        let calls = random_calls(tree);
        let reads = reads_of_seed(tree);
        let mut chance = Self {
            sites: Sites(vec![0; tree.exprs.len()]),
            is_seeded: is_hidden(tree) && !(calls.is_empty() && reads.is_empty()),
            positions: vec![0; tree.terms.len()],
            ..Self::default()
        };
        chance.sites.number(within(&calls, tree.parameters().span), Stream::Initial, &mut chance.drawn);
        let mut in_blocks = 0;
        for item in tree.items() {
            match item {
                Item::Header(header) => {
                    let span = header.selection.map(|selection| tree.expr_span(selection));
                    let calls = span.map_or(&[][..], |span| within(&calls, span));
                    chance.sites.number(calls, Stream::Selection, &mut 0);
                }
                Item::Scene(block) => {
                    chance.sites.number(within(&calls, block.fields.span), Stream::Blocks, &mut in_blocks);
                }
                Item::Rule(_) | Item::Macro(_) => {}
            }
        }
        let references = references(tree, definitions);
        for body in bodies(tree) {
            let span = tree.term_span(body);
            chance.sites.number(within(&calls, span), Stream::Solid, &mut 0);
            for ((_, (term, _)), position) in within(&references, span).iter().zip(1..) {
                chance.positions[term.index()] = position;
            }
        }
        let drawn = |span| !(within(&calls, span).is_empty() && within(&reads, span).is_empty());
        chance.spread(tree, definitions, &references, drawn);
        chance
    }

    /// Finds the definitions at or below which the seed is read: where it is read itself, and, backwards along the
    /// references, all that lead there.
    fn spread(
        &mut self,
        tree: &SyntaxTree,
        definitions: &Definitions<'_>,
        references: &[(usize, (TermId, Defined))],
        reads: impl Fn(Span) -> bool,
    ) {
        let symbols = definitions.symbols.len();
        let index = |defined| match defined {
            Defined::Symbol(index) => index,
            Defined::Macro(index) => symbols + index,
        };
        let count = symbols + definitions.macros.len();
        let mut users = vec![Vec::new(); count];
        let mut random = vec![false; count];
        let mut pending = Vec::new();
        for user in 0..count {
            let spans: Vec<Span> = match definitions.symbols.get(user) {
                Some(symbol) => {
                    let selection = symbol.header.and_then(|header| header.selection);
                    let rules = symbol.rules.iter().map(|rule| tree.term_span(rule.body));
                    rules.chain(selection.map(|selection| tree.expr_span(selection))).collect()
                }
                None => vec![tree.term_span(definitions.macros[user - symbols].body)],
            };
            for span in spans {
                for (_, (_, used)) in within(references, span) {
                    users[index(*used)].push(user);
                }
                if self.is_seeded && reads(span) {
                    pending.push(user);
                }
            }
        }
        while let Some(reader) = pending.pop() {
            if !std::mem::replace(&mut random[reader], true) {
                pending.extend(&users[reader]);
            }
        }
        self.macros = random.split_off(symbols);
        self.symbols = random;
    }

    /// The position of a reference that hands down a seed.
    fn position(&self, term: TermId, to: Defined) -> Option<u32> {
        let random = match to {
            Defined::Symbol(index) => self.symbols[index],
            Defined::Macro(index) => self.macros[index],
        };
        random.then(|| self.positions[term.index()])
    }
}

impl Lowering<'_> {
    /// What a reference to a definition becomes: the definition's node, below a C-node that derives the seed if there is
    /// one to hand down.
    pub(super) fn reference(&mut self, term: TermId, to: Defined, node: NodeId) -> NodeId {
        let seed: Option<ParamId> = self.scope.get(SEED);
        let (Some(seed), Some(position)) = (seed, self.chance.position(term, to)) else { return node };
        let derived = self.builder.reseed(seed, position, node);
        self.sources.record(derived, self.tree.term_span(term), []);
        derived
    }
}

/// Whether `seed` is the hidden parameter, and not one of the file's own: random and hash functions are called, or it is read
/// and nothing sets it.
fn is_hidden(tree: &SyntaxTree) -> bool {
    let calls_chance = tree.exprs.iter().any(|node| match &node.value {
        Expr::Call { name, .. } => Function::named(tree.text(*name)).is_some_and(Function::is_erratic),
        _ => false,
    });
    let sets = |assignments: &[Assignment]| assignments.iter().any(|set| tree.text(set.name) == SEED);
    let is_set = || {
        sets(&tree.parameters().assignments)
            || tree.terms.iter().any(|node| match &node.value {
                Term::Prefixed { prefix, .. } => {
                    matches!(&prefix.kind, PrefixKind::Calculation(assignments) if sets(assignments))
                }
                _ => false,
            })
    };
    calls_chance || !is_set()
}

/// The calls of random functions, in the order of the text, each with its place.
fn random_calls(tree: &SyntaxTree) -> Vec<(usize, ExprId)> {
    in_order(tree.exprs.iter().zip(0..).filter_map(|(node, index)| {
        let Expr::Call { name, .. } = &node.value else { return None };
        let is_random = Function::named(tree.text(*name)).is_some_and(Function::is_random);
        is_random.then_some((name.start, ExprId(index)))
    }))
}

/// Where the seed is read by its name.
fn reads_of_seed(tree: &SyntaxTree) -> Vec<(usize, ())> {
    in_order(tree.exprs.iter().filter_map(|node| {
        let is_read = matches!(node.value, Expr::Name) && tree.text(node.span) == SEED;
        is_read.then_some((node.span.start, ()))
    }))
}

/// The references to symbols and macros.
fn references(tree: &SyntaxTree, definitions: &Definitions<'_>) -> Vec<(usize, (TermId, Defined))> {
    in_order(tree.terms.iter().zip(0..).filter_map(|(node, index)| {
        let Term::Solid { name, .. } = &node.value else { return None };
        Some((name.start, (TermId(index), definitions.get(tree.text(*name))?)))
    }))
}

fn in_order<T>(found: impl Iterator<Item = (usize, T)>) -> Vec<(usize, T)> {
    let mut found: Vec<_> = found.collect();
    found.sort_by_key(|(start, _)| *start);
    found
}

/// Of things in the order of the text, those that begin in a span.
fn within<T>(found: &[(usize, T)], span: Span) -> &[(usize, T)] {
    let first = found.partition_point(|(start, _)| *start < span.start);
    let end = found.partition_point(|(start, _)| *start < span.end);
    &found[first..end.max(first)]
}

/// The terms of the axiom, the rules and the macros.
fn bodies(tree: &SyntaxTree) -> impl Iterator<Item = TermId> + '_ {
    let items = tree.items().iter().filter_map(|item| match item {
        Item::Rule(rule) => Some(rule.body),
        Item::Macro(definition) => Some(definition.body),
        Item::Header(_) | Item::Scene(_) => None,
    });
    tree.axiom().into_iter().chain(items)
}
