//! Laying out terms and expressions, with a list of jobs in place of recursion.

use std::borrow::Cow;

use csg_graph::{Binary, Operator};

use super::{Printer, WIDTH};
use crate::names;
use crate::syntax::{Assignment, Expr, ExprId, Prefix, PrefixKind, Term, TermId, strength};

/// Something to print.
pub(super) enum Job {
    Term {
        id: TermId,
        /// Two columns before it belong to what opened it, and its operators may stand there.
        hangs: bool,
    },
    Prefix(TermId),
    Expr(ExprId),
    /// Text between the tokens of the source.
    Word(Cow<'static, str>),
    /// A token and its place in the source.
    Token(Cow<'static, str>, usize),
    /// A new line at an indentation, before the place in the source of what comes next.
    Line(usize, usize),
    /// A blank, or a new line if what comes next is too wide; its place in the source.
    Soft {
        width: usize,
        at: usize,
    },
    Indent(usize),
    IndentHere,
}

fn word(text: &'static str) -> Job {
    Job::Word(Cow::Borrowed(text))
}

impl Printer<'_> {
    pub(super) fn lay_out(&mut self, first: Vec<Job>) {
        let mut stack = first;
        while let Some(job) = stack.pop() {
            let mut more = Vec::new();
            match job {
                Job::Term { id, hangs } => self.term(id, hangs, &mut more),
                Job::Prefix(id) => self.prefix(id, &mut more),
                Job::Expr(id) => self.expr(id, &mut more),
                Job::Word(text) => self.out.word(&text),
                Job::Token(text, at) => self.out.token(&text, at),
                Job::Line(indent, at) => self.out.line(at, indent, super::Space::None),
                Job::Soft { width, at } => {
                    let indent = self.out.indent();
                    self.out.comments_before(at, indent);
                    let fits = self.out.column() + 1 + width <= WIDTH;
                    // A line that could begin no further left would not help.
                    if fits || self.out.column() <= indent {
                        self.out.word(" ");
                    } else {
                        self.out.line(at, indent, super::Space::None);
                    }
                }
                Job::Indent(indent) => self.out.set_indent(indent),
                Job::IndentHere => self.out.set_indent(self.out.column()),
            }
            stack.extend(more.into_iter().rev());
        }
    }

    fn fits(&self, width: usize) -> bool {
        self.out.column() + width <= WIDTH
    }

    fn term(&mut self, id: TermId, hangs: bool, jobs: &mut Vec<Job>) {
        let span = self.tree.term_span(id);
        match self.tree.term(id) {
            Term::Solid { name, args } => {
                jobs.push(Job::Token(self.owned(self.tree.text(*name)), name.start));
                if !args.is_empty() {
                    self.list(args, span.end, jobs);
                }
            }
            Term::Prefixed { .. } => self.prefixed(id, jobs),
            Term::Operator { operator, .. } => self.chain(id, *operator, hangs, jobs),
            Term::Parenthesised(inside) => {
                let opens_chain = matches!(self.tree.term(*inside), Term::Operator { .. });
                let blank = if opens_chain && !self.fits(self.widths.term(id)) { " " } else { "" };
                jobs.push(Job::Token(Cow::Borrowed("("), span.start));
                jobs.push(word(blank));
                jobs.push(Job::Term { id: *inside, hangs: !blank.is_empty() });
                jobs.push(word(blank));
                jobs.push(Job::Token(Cow::Borrowed(")"), span.end.saturating_sub(1)));
            }
            Term::Missing => {}
        }
    }

    /// Operands of one level of operators, side by side or below each other.
    fn chain(&mut self, id: TermId, operator: Operator, hangs: bool, jobs: &mut Vec<Job>) {
        let same_level = |other: Operator| strength(other) == strength(operator);
        let mut rest = Vec::new();
        let mut first = id;
        while let Term::Operator { operator, left, right } = self.tree.term(first)
            && same_level(*operator)
        {
            rest.push((*operator, *right));
            first = *left;
        }
        rest.reverse();
        let flat = self.fits(self.widths.term(id));
        let (before, base) = (self.out.indent(), self.out.column());
        let below = if hangs { base.saturating_sub(2) } else { base };
        jobs.push(Job::Indent(below + 4));
        jobs.push(Job::Term { id: first, hangs: false });
        for (operator, operand) in rest {
            let sign = self.sign(operator);
            let at = self.tree.term_span(operand).start;
            if flat {
                jobs.push(word(" "));
            } else {
                jobs.push(Job::Line(below, at));
                jobs.push(Job::Indent(below + 4));
            }
            jobs.push(word(sign));
            jobs.push(word(" "));
            jobs.push(Job::Term { id: operand, hangs: false });
        }
        jobs.push(Job::Indent(before));
    }

    fn sign(&self, operator: Operator) -> &'static str {
        if self.tree.is_unicode() { operator.sign() } else { operator.ascii_sign() }
    }

    /// Prefixes and their factor, in as few lines as they need.
    fn prefixed(&mut self, id: TermId, jobs: &mut Vec<Job>) {
        let before = self.out.indent();
        let continued = self.out.column() + 2;
        jobs.push(Job::Indent(continued));
        let mut at = id;
        while let Term::Prefixed { body, .. } = self.tree.term(at) {
            jobs.push(Job::Prefix(at));
            jobs.push(Job::Indent(continued));
            let next = match self.tree.term(*body) {
                Term::Prefixed { prefix, .. } => self.widths.prefix(self.tree, prefix),
                _ => self.factor_width(*body),
            };
            jobs.push(Job::Soft { width: next, at: self.tree.term_span(*body).start });
            at = *body;
        }
        jobs.push(Job::Term { id: at, hangs: false });
        jobs.push(Job::Indent(before));
    }

    /// The room that a factor needs to begin where it is: all of it, or the widest line of a group that breaks anyway.
    fn factor_width(&self, id: TermId) -> usize {
        let whole = self.widths.term(id);
        let Term::Parenthesised(inside) = self.tree.term(id) else { return whole };
        if whole + 2 + self.out.indent() <= WIDTH / 2 {
            return whole;
        }
        let mut widest = 0;
        let mut first = *inside;
        while let Term::Operator { left, right, .. } = self.tree.term(first) {
            widest = widest.max(self.widths.term(*right));
            first = *left;
        }
        widest.max(self.widths.term(first)).saturating_add(4).min(whole)
    }

    fn prefix(&mut self, id: TermId, jobs: &mut Vec<Job>) {
        let Term::Prefixed { prefix: Prefix { kind, span }, .. } = self.tree.term(id) else { return };
        match kind {
            PrefixKind::Transform(kind, args) => {
                jobs.push(Job::Token(Cow::Borrowed(kind.name()), span.start));
                if !args.is_empty() {
                    self.list(args, span.end, jobs);
                }
            }
            PrefixKind::Color(args) => {
                jobs.push(Job::Token(Cow::Borrowed(names::COLOR), span.start));
                self.list(args, span.end, jobs);
            }
            PrefixKind::Material(args) => {
                jobs.push(Job::Token(Cow::Borrowed(names::MATERIAL), span.start));
                jobs.push(word("("));
                self.named(args, ",", jobs);
                jobs.push(Job::Token(Cow::Borrowed(")"), span.end.saturating_sub(1)));
            }
            PrefixKind::Calculation(assignments) => {
                jobs.push(Job::Token(Cow::Borrowed("{"), span.start));
                self.named(assignments, ";", jobs);
                jobs.push(Job::Token(Cow::Borrowed("}"), span.end.saturating_sub(1)));
            }
        }
    }

    /// `(a, b, c)`, ending at a place of the source.
    fn list(&mut self, items: &[ExprId], end: usize, jobs: &mut Vec<Job>) {
        let before = self.out.indent();
        jobs.push(word("("));
        jobs.push(Job::IndentHere);
        for (index, item) in items.iter().enumerate() {
            if index > 0 {
                jobs.push(word(","));
                jobs.push(Job::Soft {
                    width: self.widths.expr(*item) + 1,
                    at: self.tree.expr_span(*item).start,
                });
            }
            jobs.push(Job::Expr(*item));
        }
        jobs.push(Job::Token(Cow::Borrowed(")"), end.saturating_sub(1)));
        jobs.push(Job::Indent(before));
    }

    /// `a = 1; b = 2`
    fn named(&mut self, assignments: &[Assignment], separator: &'static str, jobs: &mut Vec<Job>) {
        for (index, assignment) in assignments.iter().enumerate() {
            if index > 0 {
                jobs.push(word(separator));
                jobs.push(Job::Soft {
                    width: self.widths.assignment(assignment) + 1,
                    at: assignment.name.start,
                });
            }
            jobs.push(Job::Token(self.owned(self.tree.text(assignment.name)), assignment.name.start));
            jobs.push(word(" = "));
            jobs.push(Job::Expr(assignment.value));
        }
    }

    fn expr(&mut self, id: ExprId, jobs: &mut Vec<Job>) {
        let span = self.tree.expr_span(id);
        match self.tree.expr(id) {
            Expr::Number(_) | Expr::Name => {
                jobs.push(Job::Token(self.owned(self.tree.text(span)), span.start));
            }
            Expr::Unary(operator, a) => {
                jobs.push(Job::Token(Cow::Borrowed(operator.symbol()), span.start));
                jobs.push(Job::Expr(*a));
            }
            Expr::Binary(Binary::Power, a, b) => {
                jobs.extend([Job::Expr(*a), word(Binary::Power.symbol()), Job::Expr(*b)]);
            }
            Expr::Binary(operator, a, b) => {
                let width = operator.symbol().len() + 1 + self.widths.expr(*b);
                let at = self.tree.expr_span(*b).start;
                jobs.push(Job::Expr(*a));
                jobs.push(Job::Soft { width, at });
                jobs.extend([word(operator.symbol()), word(" "), Job::Expr(*b)]);
            }
            Expr::Call { name, args } => {
                jobs.push(Job::Token(self.owned(self.tree.text(*name)), name.start));
                self.list(args, span.end, jobs);
            }
            Expr::Parenthesised(inside) => {
                jobs.push(Job::Token(Cow::Borrowed("("), span.start));
                jobs.push(Job::Expr(*inside));
                jobs.push(Job::Token(Cow::Borrowed(")"), span.end.saturating_sub(1)));
            }
            Expr::Tuple(items) => {
                // The parenthesis is a token of the source, the list's own is not.
                jobs.push(Job::Token(Cow::Borrowed(""), span.start));
                self.list(items, span.end, jobs);
            }
            Expr::Missing => {}
        }
    }

    fn owned(&self, text: &str) -> Cow<'static, str> {
        Cow::Owned(text.to_owned())
    }
}
