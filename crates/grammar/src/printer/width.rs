//! How wide each part of a tree is on a single line. A part with a comment inside fits no line.

use csg_graph::Binary;

use crate::Span;
use crate::names;
use crate::syntax::{Assignment, Block, Expr, ExprId, Prefix, PrefixKind, SyntaxTree, Term, TermId};

/// Wider than any line. No width exceeds it, so that a few can be added.
const UNBOUNDED: usize = usize::MAX / 4;

pub(super) struct Widths {
    terms: Vec<usize>,
    exprs: Vec<usize>,
    words: Vec<usize>,
    comments: Vec<usize>,
}

impl Widths {
    /// One pass over the arenas: parts come before what they are part of.
    pub(super) fn of(tree: &SyntaxTree) -> Self {
        let comments = tree.comments().iter().map(|comment| comment.start).collect();
        let mut widths = Self { terms: Vec::new(), exprs: Vec::new(), words: Vec::new(), comments };
        for node in &tree.exprs {
            let own = widths.of_expr(tree, &node.value, node.span);
            widths.exprs.push(widths.unless_commented(own, node.span));
        }
        for node in &tree.terms {
            let (own, word) = widths.of_term(tree, &node.value);
            widths.terms.push(widths.unless_commented(own, node.span));
            widths.words.push(word);
        }
        widths
    }

    pub(super) fn term(&self, id: TermId) -> usize {
        self.terms[id.index()]
    }

    pub(super) fn expr(&self, id: ExprId) -> usize {
        self.exprs[id.index()]
    }

    /// The part of a term before its first opportunity to break.
    pub(super) fn first_word(&self, id: TermId) -> usize {
        self.words[id.index()]
    }

    /// Whether a comment begins inside a span.
    pub(super) fn has_comment(&self, span: Span) -> bool {
        let next = self.comments.partition_point(|start| *start < span.start);
        self.comments.get(next).is_some_and(|start| *start < span.end)
    }

    pub(super) fn prefix(&self, tree: &SyntaxTree, prefix: &Prefix) -> usize {
        let own = match &prefix.kind {
            PrefixKind::Transform(kind, args) if args.is_empty() => kind.name().len(),
            PrefixKind::Transform(kind, args) => kind.name().len() + self.list(args),
            PrefixKind::Color(args) => names::COLOR.len() + self.list(args),
            PrefixKind::Material(args) => names::MATERIAL.len() + self.named(tree, args),
            PrefixKind::Calculation(assignments) => self.named(tree, assignments),
        };
        self.unless_commented(own, prefix.span)
    }

    pub(super) fn assignment(&self, assignment: &Assignment) -> usize {
        (assignment.name.end - assignment.name.start) + 3 + self.expr(assignment.value)
    }

    /// The assignments of a block.
    pub(super) fn block(&self, block: &Block) -> usize {
        sum(block.assignments.iter().map(|assignment| self.assignment(assignment) + 2))
    }

    fn of_expr(&self, tree: &SyntaxTree, expr: &Expr, span: Span) -> usize {
        match expr {
            Expr::Number(_) | Expr::Name => chars(tree, span),
            Expr::Unary(_, a) => 1 + self.expr(*a),
            Expr::Binary(operator, a, b) => {
                let spaces = if *operator == Binary::Power { 0 } else { 2 };
                self.expr(*a).saturating_add(self.expr(*b)) + operator.symbol().len() + spaces
            }
            Expr::Call { name, args } => chars(tree, *name) + self.list(args),
            Expr::Parenthesised(inside) => self.expr(*inside) + 2,
            Expr::Tuple(items) => self.list(items),
            Expr::Missing => 0,
        }
    }

    fn of_term(&self, tree: &SyntaxTree, term: &Term) -> (usize, usize) {
        match term {
            Term::Solid { name, args } => {
                let own = chars(tree, *name) + if args.is_empty() { 0 } else { self.list(args) };
                (own, own)
            }
            Term::Prefixed { prefix, body } => {
                let own = self.prefix(tree, prefix);
                (own + 1 + self.term(*body), own)
            }
            Term::Operator { left, right, .. } => {
                (self.term(*left) + 3 + self.term(*right), self.first_word(*left))
            }
            Term::Parenthesised(inside) => (self.term(*inside) + 2, self.first_word(*inside) + 2),
            Term::Missing => (0, 0),
        }
    }

    /// `(a, b, c)`
    fn list(&self, items: &[ExprId]) -> usize {
        sum(items.iter().map(|item| self.expr(*item) + 2))
    }

    /// `(a = 1, b = 2)` or `{a = 1; b = 2}`
    fn named(&self, tree: &SyntaxTree, assignments: &[Assignment]) -> usize {
        let widths = assignments
            .iter()
            .map(|assignment| chars(tree, assignment.name) + 3 + self.expr(assignment.value) + 2);
        sum(widths)
    }

    fn unless_commented(&self, width: usize, span: Span) -> usize {
        if self.has_comment(span) { UNBOUNDED } else { width.min(UNBOUNDED) }
    }
}

/// The sum of the widths of a list's items, each with its separator; of an empty list that of its parentheses.
fn sum(widths: impl Iterator<Item = usize>) -> usize {
    widths.fold(0, |sum, width| (sum + width).min(UNBOUNDED)).max(2)
}

fn chars(tree: &SyntaxTree, span: Span) -> usize {
    tree.text(span).chars().count()
}
