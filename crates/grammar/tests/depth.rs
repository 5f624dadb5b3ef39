//! Depth and size of the input cost time and memory in proportion, and no machine stack.

use csg_graph_grammar::{load, parse, print};

/// Runs on a stack that a few hundred frames would exhaust.
fn on_a_small_stack(test: impl FnOnce() + Send) {
    std::thread::scope(|scope| {
        let thread =
            std::thread::Builder::new().stack_size(128 << 10).spawn_scoped(scope, test).expect("a thread");
        thread.join().expect("no panic");
    });
}

fn check(source: &str) {
    on_a_small_stack(|| {
        let lowered = load(source, &[]).unwrap_or_else(|reports| panic!("{}", reports[0]));
        drop(lowered);
        let printed = print(&parse(source).tree);
        assert!(!parse(&printed).has_errors());
        assert!(printed.len() < source.len() * 70 + 1000, "{} bytes of {}", printed.len(), source.len());
    });
}

const DEPTH: usize = 20_000;

#[test]
fn parentheses_around_solids() {
    check(&format!("{{}} {}sphere{}", "(".repeat(DEPTH), ")".repeat(DEPTH)));
}

#[test]
fn unions_inside_unions() {
    check(&format!("{{}} {}sphere{}", "(cube | ".repeat(DEPTH), ")".repeat(DEPTH)));
    check(&format!("{{}} {}sphere{}", "(".repeat(DEPTH), " & cube)".repeat(DEPTH)));
}

#[test]
fn prefixes_before_prefixes() {
    check(&format!("{{ n = 1; }} {}sphere", "move(0, 0, 1) {n = n + 1} uscale(n) ".repeat(DEPTH)));
}

#[test]
fn parentheses_around_numbers() {
    check(&format!("{{ n = {}1{}; }} uscale(n) sphere", "(".repeat(DEPTH), ")".repeat(DEPTH)));
    check(&format!("{{ n = {}1{}; }} uscale(n) sphere", "-abs(".repeat(DEPTH), ")".repeat(DEPTH)));
    check(&format!("{{ n = {}1{}; }} uscale(n) sphere", "(1 + ".repeat(DEPTH / 2), ")".repeat(DEPTH / 2)));
}

#[test]
fn operators_without_end() {
    check(&format!("{{}} sphere{}", " | cube".repeat(100_000)));
    check(&format!("{{ n = 1{}; }} uscale(n) sphere", " + 1".repeat(100_000)));
    check(&format!("{{ n = {}1; }} uscale(n) sphere", "1 ^ ".repeat(DEPTH / 2)));
    check(&format!("{{ n = {}1; }} uscale(n) sphere", "- ! ".repeat(DEPTH)));
}

#[test]
fn macros_upon_macros() {
    let mut source = String::from("{} a0\n");
    for n in 0..DEPTH {
        source.push_str(&format!("a{n} = a{} | a{}\n", n + 1, n + 1));
    }
    source.push_str(&format!("a{DEPTH} = sphere"));
    check(&source);
}

#[test]
fn what_is_deep_and_wrong_is_reported() {
    for (open, close) in
        [("(", ""), ("(cube | ", ""), ("", ")"), ("move(0, 0, (", ""), ("{n = (", ""), ("sphere ", "")]
    {
        let source = format!("{{}} {}sphere{}", open.repeat(DEPTH), close.repeat(DEPTH));
        on_a_small_stack(|| {
            let reports = load(&source, &[]).unwrap_err();
            assert!(!reports[0].render("deep.pcsg", &source, true).is_empty());
        });
    }
}

/// Guesses at what was meant compare with all names; that must not make time grow with the square of the mistakes.
#[test]
fn many_mistakes() {
    const MANY: usize = 5_000;
    let list =
        |item: fn(usize) -> String, between: &str| (0..MANY).map(item).collect::<Vec<_>>().join(between);
    // What is read may have been meant.
    let unread = list(|n| format!("parameter{n} = 0;"), "\n");
    let unread = format!("{{ {unread} parameter = 1; }} uscale(parameter) sphere");
    let warnings = load(&unread, &[]).unwrap().warnings;
    assert_eq!(warnings.len(), MANY);
    assert_eq!(warnings[0].help.as_deref(), Some("did you mean `parameter`?"));
    assert_eq!(warnings[MANY - 1].help, None);
    let count = |source: String| load(&source, &[]).unwrap_err().len();
    assert_eq!(count(format!("{{}} {}", list(|n| format!("solid{n}"), "\n| "))), MANY);
    assert_eq!(count(format!("{{}} {}", list(|n| format!("turn{n}(1) cube"), "\n| "))), MANY);
    assert_eq!(count(format!("{{ {} }} cube", list(|n| format!("n{n} = m{n};"), "\n"))), MANY);
    assert_eq!(count(format!("{{}} A\n{}", list(|_| "1: A -> cube".to_owned(), "\n"))), MANY);
}
