//! The structure of a tree without its places, to compare trees by.

use csg_graph_grammar::syntax::{Assignment, Expr, ExprId, Item, PrefixKind, Term, TermId};
use csg_graph_grammar::{Span, SyntaxTree};

/// The structure of a tree, a word a node, without its places.
pub(crate) fn outline(tree: &SyntaxTree) -> Vec<String> {
    let mut out = Vec::new();
    assignments(tree, &tree.parameters().assignments, &mut out);
    tree.axiom().iter().for_each(|axiom| term(tree, *axiom, &mut out));
    for item in tree.items() {
        match item {
            Item::Header(header) => {
                out.push(format!("header {}", tree.text(header.name)));
                header.selection.iter().for_each(|selection| expr(tree, *selection, &mut out));
            }
            Item::Rule(rule) => {
                let number = rule.number.map(|span| tree.text(span));
                out.push(format!("rule {number:?} {}", tree.text(rule.symbol)));
                term(tree, rule.body, &mut out);
            }
            Item::Macro(named) => {
                out.push(format!("macro {}", tree.text(named.name)));
                term(tree, named.body, &mut out);
            }
            Item::Scene(block) => {
                out.push(format!("block {}", tree.text(block.name)));
                assignments(tree, &block.fields.assignments, &mut out);
            }
            _ => unreachable!(),
        }
    }
    out.extend(tree.comments().iter().map(|comment| tree.text(*comment).trim_end().to_owned()));
    out
}

fn term(tree: &SyntaxTree, root: TermId, out: &mut Vec<String>) {
    for id in tree.subterms(root) {
        match tree.term(id) {
            Term::Solid { name, args } => call(tree, tree.text(*name), args, out),
            Term::Prefixed { prefix, .. } => match &prefix.kind {
                PrefixKind::Transform(kind, args) => call(tree, kind.name(), args, out),
                PrefixKind::Color(args) => call(tree, "color", args, out),
                PrefixKind::Material(named) | PrefixKind::Calculation(named) => {
                    out.push(format!("{} named", named.len()));
                    assignments(tree, named, out);
                }
                _ => unreachable!(),
            },
            Term::Operator { operator, .. } => out.push(operator.sign().to_owned()),
            Term::Parenthesised(_) => out.push("()".to_owned()),
            _ => out.push("missing".to_owned()),
        }
    }
}

fn call(tree: &SyntaxTree, name: &str, args: &[ExprId], out: &mut Vec<String>) {
    out.push(format!("{name} of {}", args.len()));
    args.iter().for_each(|arg| expr(tree, *arg, out));
}

fn assignments(tree: &SyntaxTree, assignments: &[Assignment], out: &mut Vec<String>) {
    for assignment in assignments {
        out.push(format!("{} =", tree.text(assignment.name)));
        expr(tree, assignment.value, out);
    }
}

fn expr(tree: &SyntaxTree, root: ExprId, out: &mut Vec<String>) {
    for id in tree.subexprs(root) {
        let text = |span: Span| tree.text(span);
        out.push(match tree.expr(id) {
            Expr::Number(_) | Expr::Name => text(tree.expr_span(id)).to_owned(),
            Expr::Unary(operator, _) => format!("{operator:?}"),
            Expr::Binary(operator, ..) => format!("{operator:?}"),
            Expr::Call { name, args } => format!("{} of {}", text(*name), args.len()),
            Expr::Parenthesised(_) => "()".to_owned(),
            Expr::Tuple(items) => format!("tuple of {}", items.len()),
            _ => "missing".to_owned(),
        });
    }
}
