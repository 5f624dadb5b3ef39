//! The printer: a syntax tree in its canonical spacing, with all its comments.
//!
//! What the author decided stays: parentheses, the digits of numbers, Unicode or ASCII operators, single blank lines, the
//! order of everything. What fits a line is put on one; otherwise a term breaks before its operators, which stand below
//! the `=`, the arrow or the parenthesis that the term began behind, as in Fig. 1.1a of the paper:
//!
//! ```text
//! 3: TR -> SG
//!        | move(0, 0, 1) rotz(gamma) ( {cnt = cnt - 1} rotx(alpha1) uscale(fBR1) TR
//!                                    | {cnt = cnt - 1} rotx(alpha2) uscale(fBR2) TR )
//! ```

mod output;
mod term;
mod width;

use crate::Span;
use crate::syntax::{Assignment, Block, Item, SyntaxTree};
use output::{Output, Space};
use term::Job;
use width::Widths;

/// The width of a line that nothing but a single long word exceeds.
const WIDTH: usize = 100;

/// Prints a tree so that it parses to the same tree again. Printing what was printed changes nothing.
///
/// What is missing in a [damaged](SyntaxTree::is_damaged) tree is missing in the text as well.
///
/// ```
/// use csg_graph_grammar::{parse, print};
///
/// let parsed = parse("{n=3;r=1/n}   uscale( r )(sphere|move(0,0,1)cube)// two");
/// assert_eq!(print(&parsed.tree), "{ n = 3; r = 1 / n; } uscale(r) (sphere | move(0, 0, 1) cube)  // two\n");
/// ```
pub fn print(tree: &SyntaxTree) -> String {
    let mut printer = Printer { tree, out: Output::new(tree), widths: Widths::of(tree) };
    printer.file();
    printer.out.finish()
}

struct Printer<'t> {
    tree: &'t SyntaxTree,
    out: Output<'t>,
    widths: Widths,
}

impl Printer<'_> {
    fn file(&mut self) {
        let tree = self.tree;
        let parameters = tree.parameters();
        self.out.line(parameters.span.start, 0, Space::Kept);
        self.block(parameters);
        if let Some(axiom) = tree.axiom() {
            let width = self.widths.term(axiom);
            if self.out.column() + 1 + width > WIDTH && width > self.widths.first_word(axiom) {
                self.out.line(tree.term_span(axiom).start, 2, Space::None);
            } else {
                self.out.word(" ");
            }
            self.lay_out(vec![Job::Term { id: axiom, hangs: true }]);
        }
        for (index, item) in tree.items().iter().enumerate() {
            let space = if index == 0 { Space::One } else { Space::Kept };
            self.out.line(item_span(item).start, 0, space);
            self.item(item);
        }
    }

    fn item(&mut self, item: &Item) {
        let tree = self.tree;
        match item {
            Item::Header(header) => {
                self.out.token(tree.text(header.name), header.name.start);
                if let Some(selection) = header.selection {
                    self.out.word(" ");
                    self.out.set_indent(4);
                    self.lay_out(vec![Job::Expr(selection)]);
                }
            }
            Item::Rule(rule) => {
                self.out.set_indent(4);
                if let Some(number) = rule.number {
                    self.out.token(tree.text(number), number.start);
                    self.out.word(": ");
                }
                self.out.token(tree.text(rule.symbol), rule.symbol.start);
                self.out.word(if tree.is_unicode() { " → " } else { " -> " });
                self.lay_out(vec![Job::Term { id: rule.body, hangs: true }]);
            }
            Item::Macro(named) => {
                self.out.set_indent(4);
                self.out.token(tree.text(named.name), named.name.start);
                self.out.word(" = ");
                self.lay_out(vec![Job::Term { id: named.body, hangs: true }]);
            }
            Item::Scene(block) => {
                self.out.set_indent(4);
                self.out.token(tree.text(block.name), block.name.start);
                self.out.word(" ");
                self.block(&block.fields);
            }
        }
    }

    /// `{ a = 1; b = 2; }`, or an assignment a line if that is too long, has comments, or was begun so.
    fn block(&mut self, block: &Block) {
        self.out.token("{", block.span.start);
        let close = block.span.end.saturating_sub(1);
        let begun_broken = block
            .assignments
            .first()
            .is_some_and(|first| self.tree.source()[block.span.start..first.name.start].contains('\n'));
        let width = self.widths.block(block);
        let commented = self.widths.has_comment(block.span);
        if block.assignments.is_empty() && !commented {
            self.out.word("}");
        } else if !begun_broken && !commented && self.out.column() + width + 2 <= WIDTH {
            for assignment in &block.assignments {
                self.out.word(" ");
                self.assignment(assignment);
                self.out.word(";");
            }
            self.out.word(" }");
        } else {
            self.out.align_comments(true);
            for (index, assignment) in block.assignments.iter().enumerate() {
                let space = if index == 0 { Space::None } else { Space::Kept };
                self.out.line(assignment.name.start, 2, space);
                self.out.set_indent(6);
                self.assignment(assignment);
                self.out.word(";");
            }
            self.out.comments_before(close, 2);
            self.out.line(close, 0, Space::None);
            self.out.align_comments(false);
            self.out.word("}");
        }
    }

    fn assignment(&mut self, assignment: &Assignment) {
        self.out.token(self.tree.text(assignment.name), assignment.name.start);
        self.out.word(" = ");
        self.lay_out(vec![Job::Expr(assignment.value)]);
    }
}

fn item_span(item: &Item) -> Span {
    match item {
        Item::Header(header) => header.name,
        Item::Rule(rule) => rule.number.unwrap_or(rule.symbol),
        Item::Macro(named) => named.name,
        Item::Scene(block) => block.name,
    }
}
