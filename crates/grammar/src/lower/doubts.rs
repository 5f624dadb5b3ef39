//! What is defined and not used: no mistake, but perhaps a slip in a name.

use std::collections::BTreeSet;

use csg_graph::{Binary, Function};

use super::Lowering;
use super::definitions::{Defined, Definitions};
use crate::Diagnostic;
use crate::names::{PI, guess};
use crate::syntax::{Expr, ExprId, Prefix, PrefixKind, Term, TermId};

impl Lowering<'_> {
    /// Doubts about symbols and macros that the axiom does not lead to.
    pub(super) fn unused_solids(&mut self, axiom: TermId, definitions: &Definitions<'_>) {
        let tree = self.tree;
        let mut symbols = vec![false; definitions.symbols.len()];
        let mut macros = vec![false; definitions.macros.len()];
        let mut pending = vec![axiom];
        while let Some(body) = pending.pop() {
            for id in tree.subterms(body) {
                let Term::Solid { name, .. } = tree.term(id) else { continue };
                match definitions.get(tree.text(*name)) {
                    Some(Defined::Symbol(index)) if !symbols[index] => {
                        symbols[index] = true;
                        pending.extend(definitions.symbols[index].rules.iter().map(|rule| rule.body));
                    }
                    Some(Defined::Macro(index)) if !macros[index] => {
                        macros[index] = true;
                        pending.push(definitions.macros[index].body);
                    }
                    _ => {}
                }
            }
        }
        let unused_symbols =
            definitions.symbols.iter().zip(symbols).map(|(symbol, used)| (symbol.span, used));
        let unused_macros = definitions.macros.iter().zip(macros).map(|(named, used)| (named.name, used));
        for (span, _) in unused_symbols.chain(unused_macros).filter(|(_, used)| !used) {
            let name = tree.text(span);
            if !name.starts_with('_') {
                let message = format!("the axiom does not lead to `{name}`");
                self.diagnostics.push(Diagnostic::warning(span, message).label("never used"));
            }
        }
    }

    /// Doubts about angles that are made with `pi`, as if they were in radians. What is divided by it may be one that is turned
    /// into degrees.
    pub(super) fn angles_in_radians(&mut self) {
        let tree = self.tree;
        let of_prefix = |prefix: &Prefix| match &prefix.kind {
            PrefixKind::Transform(kind, args) => angle(kind.signature(), args),
            _ => None,
        };
        let turned = tree.terms.iter().filter_map(|node| match &node.value {
            Term::Prefixed { prefix, .. } => of_prefix(prefix),
            _ => None,
        });
        let called = tree.exprs.iter().filter_map(|node| match &node.value {
            Expr::Call { name, args } => angle(Function::named(tree.text(*name))?.signature(), args),
            _ => None,
        });
        let mut pending: Vec<ExprId> = turned.chain(called).collect();
        while let Some(id) = pending.pop() {
            match tree.expr(id) {
                Expr::Name if tree.text(tree.expr_span(id)) == PI => self.diagnostics.push(
                    Diagnostic::warning(tree.expr_span(id), "an angle is made with `pi`")
                        .label("3.14159 degrees")
                        .help("angles are in degrees, also those of functions: half a turn is 180"),
                ),
                Expr::Unary(_, a) | Expr::Parenthesised(a) | Expr::Binary(Binary::Divide, a, _) => {
                    pending.push(*a)
                }
                Expr::Binary(_, a, b) => pending.extend([*a, *b]),
                // What a function makes of a number is no longer that number.
                _ => {}
            }
        }
    }

    /// Doubts about parameters that are set and never read, or by what sets them alone.
    pub(super) fn unused_parameters(&mut self) {
        let tree = self.tree;
        let initial = tree.parameters().assignments.iter();
        let calculated = tree.terms.iter().filter_map(|node| match &node.value {
            Term::Prefixed { prefix, .. } => match &prefix.kind {
                PrefixKind::Calculation(assignments) => Some(assignments),
                _ => None,
            },
            _ => None,
        });
        let mut seen: BTreeSet<&str> = BTreeSet::new();
        for span in initial.chain(calculated.flatten()).map(|assignment| assignment.name) {
            let name = tree.text(span);
            let Some(param) = self.scope.get(name) else { continue };
            if self.scope.is_read(param) || name.starts_with('_') || !seen.insert(name) {
                continue;
            }
            let is_read = |other: &&str| self.scope.get(other).is_some_and(|param| self.scope.is_read(param));
            let others = self.scope.names().filter(is_read);
            let help = match guess(&self.diagnostics, name, others) {
                Some(other) => Some(format!("did you mean `{other}`?")),
                None if self.scope.is_counted(param) => Some(format!(
                    "a recursion ends where a selection function reads what it counts, as in `TREE if({name} > 0, 2, 1)`"
                )),
                None => None,
            };
            self.diagnostics.push(
                Diagnostic::warning(span, format!("parameter `{name}` is set and never read"))
                    .label("never read")
                    .help_if(help),
            );
        }
    }
}

/// The argument that a signature calls an angle, which is the last.
fn angle(signature: &str, args: &[ExprId]) -> Option<ExprId> {
    args.last().copied().filter(|_| signature.ends_with("angle)"))
}
