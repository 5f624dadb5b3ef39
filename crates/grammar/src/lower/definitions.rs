//! What a file defines: symbols with their rules, and macros.

use std::collections::BTreeMap;

use crate::names;
use crate::syntax::{Header, Item, Macro, Rule, SyntaxTree, Term, TermId};
use crate::{Diagnostic, Span};

use super::expr::count;

/// A symbol, from its header and its rules, wherever in the file they are.
pub(super) struct Symbol<'t> {
    pub(super) name: &'t str,
    /// Its name in its header, or else in its first rule.
    pub(super) span: Span,
    pub(super) header: Option<&'t Header>,
    /// In the order of their numbers.
    pub(super) rules: Vec<&'t Rule>,
}

/// What a name of a solid stands for, by its position in [`Definitions`].
#[derive(Clone, Copy)]
pub(super) enum Defined {
    Symbol(usize),
    Macro(usize),
}

pub(super) struct Definitions<'t> {
    pub(super) symbols: Vec<Symbol<'t>>,
    pub(super) macros: Vec<&'t Macro>,
    by_name: BTreeMap<&'t str, Defined>,
}

impl<'t> Definitions<'t> {
    /// Gathers the definitions and checks each: names are not taken, rules are numbered from 1, there is a selection
    /// function where there is something to select.
    pub(super) fn collect(tree: &'t SyntaxTree, diagnostics: &mut Vec<Diagnostic>) -> Self {
        let mut found = Self { symbols: Vec::new(), macros: Vec::new(), by_name: BTreeMap::new() };
        for item in tree.items() {
            match item {
                Item::Header(header) => {
                    if let Some(symbol) = found.symbol(tree, header.name, diagnostics) {
                        match symbol.header {
                            None => (symbol.header, symbol.span) = (Some(header), header.name),
                            Some(first) => {
                                let message = format!("symbol `{}` has two headers", symbol.name);
                                let help =
                                    "if this belongs to the term before it, an operator is missing: `| …`";
                                diagnostics.push(
                                    Diagnostic::error(header.name, message)
                                        .label("the second")
                                        .also(first.name, "the first")
                                        .help(help),
                                );
                            }
                        }
                    }
                }
                Item::Rule(rule) => {
                    if let Some(symbol) = found.symbol(tree, rule.symbol, diagnostics) {
                        symbol.rules.push(rule);
                    }
                }
                Item::Macro(definition) => found.define_macro(tree, definition, diagnostics),
                Item::Scene(_) => {}
            }
        }
        for symbol in &mut found.symbols {
            symbol.check(tree, diagnostics);
        }
        found
    }

    pub(super) fn get(&self, name: &str) -> Option<Defined> {
        self.by_name.get(name).copied()
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &'t str> + '_ {
        self.by_name.keys().copied()
    }

    /// The symbol of that name, made if it is new; `None` if the name is not free.
    fn symbol(
        &mut self,
        tree: &'t SyntaxTree,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<&mut Symbol<'t>> {
        let name = tree.text(span);
        if refuse_built_in(name, span, diagnostics) {
            return None;
        }
        let index = match self.get(name) {
            Some(Defined::Symbol(index)) => index,
            Some(Defined::Macro(index)) => {
                let message = format!("`{name}` is a macro, and cannot be a symbol as well");
                diagnostics.push(
                    Diagnostic::error(span, message)
                        .label("a symbol here")
                        .also(self.macros[index].name, "a macro here"),
                );
                return None;
            }
            None => {
                self.by_name.insert(name, Defined::Symbol(self.symbols.len()));
                self.symbols.push(Symbol { name, span, header: None, rules: Vec::new() });
                self.symbols.len() - 1
            }
        };
        Some(&mut self.symbols[index])
    }

    fn define_macro(
        &mut self,
        tree: &'t SyntaxTree,
        definition: &'t Macro,
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        let (name, span) = (tree.text(definition.name), definition.name);
        if refuse_built_in(name, span, diagnostics) {
            return;
        }
        let (first, what) = match self.get(name) {
            None => {
                self.by_name.insert(name, Defined::Macro(self.macros.len()));
                self.macros.push(definition);
                return;
            }
            Some(Defined::Symbol(index)) => (self.symbols[index].span, "a symbol"),
            Some(Defined::Macro(index)) => (self.macros[index].name, "a macro"),
        };
        diagnostics.push(
            Diagnostic::error(span, format!("`{name}` is defined twice"))
                .label("a macro here")
                .also(first, format!("{what} here")),
        );
    }

    /// The macros, each after those that its term names, and a report of each circle.
    pub(super) fn macros_in_order(&self, tree: &SyntaxTree, diagnostics: &mut Vec<Diagnostic>) -> Vec<usize> {
        #[derive(Clone, Copy, PartialEq)]
        enum Mark {
            New,
            Open,
            Done,
        }
        let uses: Vec<Vec<(usize, Span)>> =
            self.macros.iter().map(|definition| self.macros_in(tree, definition.body)).collect();
        let mut marks = vec![Mark::New; uses.len()];
        let mut order = Vec::new();
        for start in 0..uses.len() {
            if marks[start] != Mark::New {
                continue;
            }
            marks[start] = Mark::Open;
            let mut path = vec![(start, 0)];
            while let Some((open, next)) = path.last_mut() {
                let Some(&(used, span)) = uses[*open].get(*next) else {
                    marks[*open] = Mark::Done;
                    order.push(*open);
                    path.pop();
                    continue;
                };
                *next += 1;
                match marks[used] {
                    Mark::New => {
                        marks[used] = Mark::Open;
                        path.push((used, 0));
                    }
                    Mark::Open => {
                        let from = path.iter().position(|(open, _)| *open == used).unwrap_or(0);
                        let circle: Vec<_> =
                            path[from..].iter().map(|(open, _)| *open).chain([used]).collect();
                        diagnostics.push(self.circle(tree, &circle, span));
                    }
                    Mark::Done => {}
                }
            }
        }
        order
    }

    fn macros_in(&self, tree: &SyntaxTree, body: TermId) -> Vec<(usize, Span)> {
        let named = tree.subterms(body).filter_map(|term| match tree.term(term) {
            Term::Solid { name, .. } => Some(*name),
            _ => None,
        });
        let macros = named.filter_map(|span| match self.get(tree.text(span)) {
            Some(Defined::Macro(index)) => Some((index, span)),
            _ => None,
        });
        macros.collect()
    }

    fn circle(&self, tree: &SyntaxTree, circle: &[usize], span: Span) -> Diagnostic {
        let name = |index: &usize| tree.text(self.macros[*index].name);
        let path: Vec<_> = circle.iter().map(name).collect();
        let message = format!("macro `{}` contains itself: {}", path[0], path.join(" → "));
        Diagnostic::error(span, message)
            .label("leads back")
            .also(self.macros[circle[0]].name, "from here")
            .help(format!(
                "a macro is a part list and cannot recurse; a symbol can: `{} -> …`, with a selection function that ends it",
                path[0]
            ))
    }
}

fn refuse_built_in(name: &str, span: Span, diagnostics: &mut Vec<Diagnostic>) -> bool {
    let taken = names::is_built_in(name);
    if taken {
        let message = format!("`{name}` is part of the language and cannot be defined");
        diagnostics.push(Diagnostic::error(span, message).label("choose another name"));
    }
    taken
}

impl Symbol<'_> {
    /// Puts the rules in the order of their numbers.
    fn check(&mut self, tree: &SyntaxTree, diagnostics: &mut Vec<Diagnostic>) {
        let name = self.name;
        if self.rules.is_empty() {
            diagnostics.push(
                Diagnostic::error(self.span, format!("symbol `{name}` has no rules"))
                    .label("only a header")
                    .help(format!("write at least `1: {name} -> term`")),
            );
            return;
        }
        let total = self.rules.len();
        let mut sound = true;
        let mut known: BTreeMap<usize, &Rule> = BTreeMap::new();
        let mut numbered: Vec<(usize, &Rule)> = Vec::new();
        for (position, rule) in self.rules.iter().enumerate() {
            let Some(span) = rule.number else {
                if total > 1 {
                    let message = format!("symbol `{name}` has {total} rules, and this one lacks its number");
                    let help = format!("write `{}: {name} -> …`", position + 1);
                    diagnostics.push(Diagnostic::error(rule.symbol, message).label("no number").help(help));
                    sound = false;
                }
                numbered.push((position + 1, rule));
                continue;
            };
            let Some(number) = tree.text(span).parse::<usize>().ok().filter(|number| *number > 0) else {
                let message = format!("`{}` is no rule number", tree.text(span));
                let report = Diagnostic::error(span, message).label("not a whole number from 1");
                diagnostics.push(report.help("rules are numbered 1, 2, 3, …"));
                sound = false;
                continue;
            };
            let first = *known.entry(number).or_insert(rule);
            if first.symbol != rule.symbol {
                diagnostics.push(
                    Diagnostic::error(span, format!("symbol `{name}` has two rules {number}"))
                        .label("the second")
                        .also(first.number.unwrap_or(first.symbol), "the first"),
                );
                sound = false;
                continue;
            }
            numbered.push((number, rule));
        }
        numbered.sort_by_key(|(number, _)| *number);
        if sound && let Some(gap) = (1..).zip(&numbered).find(|(expected, (number, _))| expected != number) {
            let (expected, (number, rule)) = gap;
            diagnostics.push(
                Diagnostic::error(
                    rule.number.unwrap_or(rule.symbol),
                    format!("symbol `{name}` has no rule {expected}"),
                )
                .label(format!("rule {number} of {}", count(total, "rule")))
                .help("rules are numbered from 1 without gaps, so that the selection function can name them"),
            );
        }
        self.rules = numbered.into_iter().map(|(_, rule)| rule).collect();
        if total > 1 && self.header.is_none_or(|header| header.selection.is_none()) {
            let numbers = if total == 2 { "2, 1" } else { "3, 1" };
            diagnostics.push(
                Diagnostic::error(
                    self.span,
                    format!("symbol `{name}` has {total} rules and no selection function"),
                )
                .label("which rule, and when?")
                .help(format!("say it on a line before the rules: `{name} if(n > 0, {numbers})`")),
            );
        }
    }
}
