//! Random files, for several tests.

use proptest::prelude::*;

/// The words of a part of a random file.
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
            (inner.clone(), inner.clone()).prop_map(|(a, b)| wrapped("pick (", joined([a, b], ","), ")")),
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
