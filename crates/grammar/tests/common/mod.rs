//! What several tests share: the structure of a tree without its places, and random files.

use csg_graph_grammar::syntax::{Assignment, Expr, ExprId, Item, PrefixKind, Term, TermId};
use csg_graph_grammar::{Span, SyntaxTree};
use proptest::prelude::*;

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

/// A word of a random file, or one that may be left out.
type Words = Vec<String>;

fn words(text: &str) -> Words {
    text.split_whitespace().map(str::to_owned).collect()
}

fn joined(parts: impl IntoIterator<Item = Words>, separator: &str) -> Words {
    let mut out = Vec::new();
    for (index, part) in parts.into_iter().enumerate() {
        if index > 0 {
            out.push(separator.to_owned());
        }
        out.extend(part);
    }
    out
}

fn wrapped(open: &str, inside: Words, close: &str) -> Words {
    [words(open), inside, words(close)].concat()
}

fn random_expr() -> impl Strategy<Value = Words> {
    let leaf = prop_oneof![
        Just(words("n")),
        Just(words("width")),
        Just(words("pi")),
        Just(words("0.50")),
        Just(words("1e-3")),
        (0..1000_u32).prop_map(|n| vec![n.to_string()]),
    ];
    leaf.prop_recursive(6, 60, 3, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone(), 0..14_usize).prop_map(|(a, b, op)| {
                let ops = ["+", "-", "*", "/", "%", "^", "<", "<=", ">", ">=", "==", "!=", "&&", "||"];
                [a, words(ops[op]), b].concat()
            }),
            (inner.clone(), any::<bool>())
                .prop_map(|(a, not)| [words(if not { "!" } else { "-" }), a].concat()),
            inner.clone().prop_map(|a| wrapped("(", a, ")")),
            inner.clone().prop_map(|a| wrapped("sin (", a, ")")),
            proptest::collection::vec(inner, 3).prop_map(|args| wrapped("if (", joined(args, ","), ")")),
        ]
    })
}

fn random_assignments(separator: &'static str) -> impl Strategy<Value = Words> {
    let assignment = (0..3_usize, random_expr())
        .prop_map(|(name, value)| [words(["n =", "width =", "深 ="][name]), value].concat());
    proptest::collection::vec(assignment, 0..4).prop_map(move |list| joined(list, separator))
}

fn random_prefix() -> impl Strategy<Value = Words> {
    let triple = || proptest::collection::vec(random_expr(), 3).prop_map(|list| joined(list, ","));
    prop_oneof![
        triple().prop_map(|args| wrapped("move (", args, ")")),
        triple().prop_map(|args| wrapped("color (", args, ")")),
        (triple(), random_expr()).prop_map(|(axis, angle)| wrapped(
            "rot ( (",
            [axis, words(") ,"), angle].concat(),
            ")"
        )),
        random_expr().prop_map(|angle| wrapped("rotz (", angle, ")")),
        Just(words("flipxy")),
        random_assignments(";").prop_map(|list| wrapped("{", list, "}")),
        random_expr().prop_map(|value| wrapped("material ( specular =", value, ")")),
    ]
}

fn random_term() -> impl Strategy<Value = Words> {
    let leaf = prop_oneof![
        Just(words("sphere")),
        Just(words("cube")),
        Just(words("TREE")),
        Just(words("twig")),
        random_expr().prop_map(|r| wrapped("torus (", r, ")")),
    ];
    leaf.prop_recursive(8, 80, 4, |inner| {
        prop_oneof![
            (proptest::collection::vec(inner.clone(), 2..5), 0..5_usize)
                .prop_map(|(operands, sign)| { joined(operands, ["|", "&", "\\", "∪", "∩"][sign]) }),
            inner.clone().prop_map(|inside| wrapped("(", inside, ")")),
            (random_prefix(), inner).prop_map(|(prefix, body)| [prefix, body].concat()),
        ]
    })
}

fn random_items() -> impl Strategy<Value = Vec<Words>> {
    let item = prop_oneof![
        random_term().prop_map(|body| [words("TREE ->"), body].concat()),
        random_term().prop_map(|body| [words("12 : TREE →"), body].concat()),
        random_term().prop_map(|body| [words("twig ="), body].concat()),
        random_expr().prop_map(|choice| [words("TREE if ("), choice, words(", 1 , 2 )")].concat()),
        random_assignments(";").prop_map(|list| wrapped("camera {", list, "}")),
    ];
    proptest::collection::vec(item, 0..6)
}

/// A random file: right in its syntax, in random spacing and with comments anywhere.
pub(crate) fn random_file() -> impl Strategy<Value = String> {
    let spaces = proptest::collection::vec(0..40_u8, 64);
    (random_assignments(";"), random_term(), random_items(), spaces).prop_map(
        |(head, axiom, items, spaces)| {
            let mut out = String::new();
            let mut choices = spaces.iter().cycle();
            let mut comments = 0;
            let first = wrapped("{", head, "}");
            for (index, part) in [first, axiom].into_iter().chain(items).enumerate() {
                if index > 1 {
                    out.push('\n');
                }
                for word in part {
                    out.push_str(&word);
                    comments += 1;
                    match choices.next().copied().unwrap_or_default() {
                        0 => out.push_str(&format!(" // comment {comments}\n")),
                        1 => out.push_str(&format!("\n // own line {comments}  \n")),
                        2 => out.push_str(&format!("\n\n // paragraph {comments}\n\n")),
                        3 => out.push_str("\n\n\n"),
                        4 => out.push_str("\n   "),
                        _ => out.push(' '),
                    }
                }
            }
            out
        },
    )
}
