//! What the printer prints parses to the same tree, and printing it again changes nothing.

mod common;
mod outline;

use common::random_file;
use csg_graph_grammar::{parse, print};
use outline::outline;
use proptest::prelude::*;

fn check(source: &str) {
    let parsed = parse(source);
    let errors: Vec<_> = parsed.diagnostics.iter().filter(|report| report.is_error()).collect();
    assert!(errors.is_empty(), "{errors:?} in\n{source}");
    let printed = print(&parsed.tree);
    let again = parse(&printed);
    assert!(!again.has_errors(), "{source}\nwas printed as\n{printed}\n{:?}", again.diagnostics);
    assert_eq!(outline(&again.tree), outline(&parsed.tree), "\n{source}\nwas printed as\n{printed}");
    assert_eq!(
        print(&again.tree),
        printed,
        "printing twice differs from printing once; the source was\n{source}"
    );
    assert!(printed.lines().all(|line| !line.ends_with(' ')), "blanks at the end of a line:\n{printed}");
    assert!(printed.ends_with('\n') && !printed.ends_with("\n\n"), "{printed:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn round_trip(source in random_file()) {
        check(&source);
    }
}

fn printed(source: &str) -> String {
    check(source);
    print(&parse(source).tree)
}

#[test]
fn comments_stay_with_what_they_comment() {
    let source = "\
// The file.

{ n = 3; // levels
  // the width
  w = 1 // no semicolon here
  // the end of the parameters
} A // the axiom
// about A
A if(n > 0, 2, 1)


// the first rule
1: A -> sphere | // why
   cube // because
// the second
2: A -> hull((0,0,0), // origin
  (1,0,0), (0,1,0), // the floor
  (0,0,1)) | {n = n-1} A
// the end";
    assert_eq!(
        printed(source),
        "\
// The file.

{
  n = 3;  // levels
  // the width
  w = 1;  // no semicolon here
  // the end of the parameters
} A  // the axiom

// about A
A if(n > 0, 2, 1)

// the first rule
1: A -> sphere  // why
      | cube  // because
// the second
2: A -> hull((0, 0, 0),  // origin
             (1, 0, 0), (0, 1, 0),  // the floor
             (0, 0, 1))
      | {n = n - 1} A
// the end
"
    );
}

#[test]
fn long_terms_break_before_their_operators() {
    let source = "{} a
a = b|c&move(1,2,3)d&color(0.123456,0.123456,0.123456)rotx(45)scale(1.23456,1.23456,1.23456)e\\(b|c|d|e)
b=sphere";
    assert_eq!(
        printed(source),
        "\
{} a

a = b
  | c
    & move(1, 2, 3) d
    & color(0.123456, 0.123456, 0.123456) rotx(45) scale(1.23456, 1.23456, 1.23456) e
  \\ (b | c | d | e)
b = sphere
"
    );
}

#[test]
fn line_ends_of_other_systems_are_read_and_not_written() {
    let parsed = parse("\u{feff}{} max // a solid\r\n\r\nmax = sphere\r\n");
    assert_eq!(parsed.diagnostics, []);
    assert_eq!(print(&parsed.tree), "{} max  // a solid\n\nmax = sphere\n");
}
