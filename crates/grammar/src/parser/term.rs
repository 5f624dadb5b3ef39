//! Terms: CSG expressions over solids, with an explicit stack.
//!
//! `∩` binds tighter than `∪` and `\`, which share a level and group to the left. Prefixes (transformations,
//! calculations, attributes) bind tightest and apply to the factor that follows; the leftmost is outermost.

use csg_graph::{Operator, PrimitiveKind, TransformKind};

use super::Parser;
use crate::names::{self, guess, nearest};
use crate::syntax::{Assignment, Expr, ExprId, Prefix, PrefixKind, Term, TermId};
use crate::token::Kind;
use crate::{Diagnostic, Span};

/// What waits for the operand that is being parsed.
enum Open {
    Group(Span),
    Prefix(Prefix),
    Left(Operator, TermId),
}

fn strength(operator: Operator) -> u8 {
    match operator {
        Operator::Union | Operator::Difference => 1,
        Operator::Intersection => 2,
    }
}

fn operator(kind: Kind) -> Option<Operator> {
    match kind {
        Kind::Union => Some(Operator::Union),
        Kind::Intersection => Some(Operator::Intersection),
        Kind::Difference | Kind::Minus => Some(Operator::Difference),
        _ => None,
    }
}

/// What was meant by an operator between solids that joins numbers.
fn meant(kind: Kind) -> Option<(Operator, &'static str)> {
    match kind {
        Kind::Or | Kind::Plus => Some((Operator::Union, "the union of solids is written `|` or `∪`")),
        Kind::And | Kind::Star | Kind::Caret => {
            Some((Operator::Intersection, "the intersection of solids is written `&` or `∩`"))
        }
        Kind::Slash => Some((Operator::Difference, "the difference of solids is written `\\` or `-`")),
        _ => None,
    }
}

impl<'s> Parser<'s> {
    pub(super) fn term(&mut self) -> TermId {
        let mut stack: Vec<Open> = Vec::new();
        // How many groups are open on the stack.
        let mut groups = 0;
        loop {
            let Some(factor) = self.factor(&mut stack, &mut groups) else { continue };
            if let Some(whole) = self.after_factor(&mut stack, &mut groups, factor) {
                return whole;
            }
        }
    }

    /// Where a factor is expected: a solid, or `None` after something that must precede one.
    fn factor(&mut self, stack: &mut Vec<Open>, groups: &mut usize) -> Option<TermId> {
        match self.kind() {
            Kind::OpenParen => {
                stack.push(Open::Group(self.advance()));
                *groups += 1;
                None
            }
            Kind::OpenBrace => {
                let block = self.block();
                stack.push(Open::Prefix(Prefix {
                    kind: PrefixKind::Calculation(block.assignments),
                    span: block.span,
                }));
                None
            }
            Kind::Name if !self.surely_begins_item(self.at) => {
                let known = self.reported == Some(self.at);
                let name = self.advance();
                if let Some(prefix) = self.prefix(name) {
                    stack.push(Open::Prefix(prefix));
                    return None;
                }
                let (args, end) = self.args();
                if self.misspelt_prefix(name, known) {
                    return None;
                }
                Some(self.tree.push_term(Term::Solid { name, args }, name.to(end)))
            }
            _ => {
                let expected = match stack.last() {
                    Some(Open::Prefix(prefix)) => {
                        let before = &self.source[prefix.span.range()];
                        let what = if before.len() <= 40 { before } else { "this" };
                        self.expected(&format!("a solid after `{what}`"))
                            .label("expected a solid")
                            .help("what is before a solid applies to the solid that follows it")
                    }
                    _ => self.expected("a solid"),
                };
                self.report(expected);
                let place = self.previous().after();
                Some(self.tree.push_term(Term::Missing, place))
            }
        }
    }

    /// A name that stands before a factor, with its arguments.
    fn prefix(&mut self, name: Span) -> Option<Prefix> {
        let text = &self.source[name.range()];
        let (kind, end) = if let Some(kind) = TransformKind::named(text) {
            let (args, end) = self.args();
            (PrefixKind::Transform(kind, args), end)
        } else if text == names::COLOR {
            let (args, end) = self.args();
            (PrefixKind::Color(args), end)
        } else if text == names::MATERIAL {
            let (args, end) = self.named_args();
            (PrefixKind::Material(args), end)
        } else {
            return None;
        };
        Some(Prefix { kind, span: name.to(end) })
    }

    /// Arguments in parentheses, if there are any, and the end of them.
    fn args(&mut self) -> (Vec<ExprId>, Span) {
        let mut args = Vec::new();
        let Some(open) = (self.kind() == Kind::OpenParen && self.is_args()).then(|| self.advance()) else {
            if self.kind() == Kind::Number && names::is_prefix(self.text_at(self.at - 1)) {
                let help = format!("write `{}({})`", self.text_at(self.at - 1), self.text());
                self.report(self.expected("`(`").help(help));
                self.expr();
                args.push(self.tree.push_expr(Expr::Missing, self.previous().after()));
            }
            return (args, self.previous());
        };
        if let Some(close) = self.eat(Kind::CloseParen) {
            return (args, close);
        }
        loop {
            args.push(self.expr());
            if self.eat(Kind::Comma).is_none() {
                let close = self.close_args(open, &mut args);
                return (args, close);
            }
        }
    }

    /// Whether the parenthesis here holds arguments, and not the factor after a flip, or a solid after a missing operator.
    fn is_args(&self) -> bool {
        let name = self.text_at(self.at - 1);
        let takes_some = match TransformKind::named(name) {
            Some(kind) => return kind.arity() > 0,
            None => {
                PrimitiveKind::named(name).is_some_and(|kind| kind.arity() != Some(0)) || name == names::COLOR
            }
        };
        let holds_solid = matches!(self.kind_at(self.at + 1), Kind::OpenBrace | Kind::OpenParen)
            || self.begins_solid(self.at + 1);
        takes_some || !holds_solid
    }

    fn named_args(&mut self) -> (Vec<Assignment>, Span) {
        let mut args = Vec::new();
        let Some(open) = self.eat(Kind::OpenParen) else {
            self.report(self.expected("`(` after `material`").help("write `material(diffuse = 0.8)`"));
            return (args, self.previous());
        };
        if let Some(close) = self.eat(Kind::CloseParen) {
            return (args, close);
        }
        loop {
            if self.kind() == Kind::Name && self.kind_at(self.at + 1) == Kind::Assign {
                let name = self.advance();
                self.advance();
                args.push(Assignment { name, value: self.expr() });
            } else {
                self.report(self.expected("a name and `=`").help(
                    "the arguments of `material` are named: `material(ambient = 0.3, specular = 0.5)`",
                ));
                if Self::begins_expr(self.kind()) {
                    self.expr();
                }
            }
            if self.kind() == Kind::Name && self.kind_at(self.at + 1) == Kind::Assign {
                self.report(self.expected("`,`").help("the arguments of `material` are separated by commas"));
            } else if self.eat(Kind::Comma).is_none() {
                return (args, self.close(open));
            }
        }
    }

    /// A name that nothing defines, directly before a solid: a transformation with a slip in it. It is reported here and
    /// taken for a transformation, so that the solid after it makes no second mistake.
    fn misspelt_prefix(&mut self, name: Span, known: bool) -> bool {
        let source: &'s str = self.source;
        let text = &source[name.range()];
        let unknown = !self.is_defined(text) && !names::is_built_in(text);
        let follows = !self.token().begins_line && self.begins_factor() && !self.begins_item(self.at);
        if !unknown || !follows {
            return false;
        }
        let solids = self.symbols.iter().chain(&self.macros).copied().chain(names::primitives());
        let help = match nearest(text, names::prefixes()) {
            Some(prefix) => format!("did you mean `{prefix}`?"),
            None if guess(&self.diagnostics, text, solids).is_some() => return false,
            None => format!(
                "the transformations are {}; if it is a solid, an operator is missing after it",
                TransformKind::ALL.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ")
            ),
        };
        if !known {
            let report = Diagnostic::error(name, format!("unknown transformation `{text}`"));
            self.diagnostics.push(report.label("unknown").help(help));
        }
        true
    }

    fn begins_factor(&self) -> bool {
        matches!(self.kind(), Kind::Name | Kind::OpenParen | Kind::OpenBrace)
    }

    /// Whether the name at a token is one that only solids and prefixes have.
    pub(super) fn begins_solid(&self, at: usize) -> bool {
        let name = self.text_at(at);
        self.kind_at(at) == Kind::Name && (names::is_built_in(name) || self.is_defined(name))
    }

    /// After a factor: `None` if another one is expected now, else the whole term.
    fn after_factor(&mut self, stack: &mut Vec<Open>, groups: &mut usize, factor: TermId) -> Option<TermId> {
        let mut term = self.apply_prefixes(stack, factor);
        loop {
            if let Some(operator) = operator(self.kind()) {
                self.advance();
                self.open_operator(stack, operator, term);
                return None;
            }
            if self.kind() == Kind::CloseParen && *groups > 0 {
                let close = self.advance();
                term = self.close_group(stack, term, close);
                *groups -= 1;
                continue;
            }
            if self.kind() == Kind::End || self.begins_item(self.at) || *groups == 0 && self.is_lost_block() {
                break;
            }
            if let Some((operator, help)) = meant(self.kind()) {
                self.report(self.expected("an operator between solids").help(help));
                self.advance();
                self.open_operator(stack, operator, term);
                return None;
            }
            if self.begins_factor() {
                self.report_missing_operator(term);
                self.open_operator(stack, Operator::Union, term);
                return None;
            }
            self.report_stray();
            self.skip_to_term_end();
        }
        // What is still open was never closed; the innermost tells where.
        let mut innermost = true;
        while *groups > 0 {
            let close = self.previous().after();
            if let (true, Some(open)) = (innermost, innermost_group(stack)) {
                self.report(self.unclosed(open, "`)`"));
                innermost = false;
            }
            term = self.close_group(stack, term, close);
            *groups -= 1;
        }
        Some(self.join_operators(stack, term, 0))
    }

    /// Whether the brace here opens a block of parameters that has no solid after it, and so no place in a term.
    fn is_lost_block(&self) -> bool {
        if self.kind() != Kind::OpenBrace || !self.token().begins_line {
            return false;
        }
        let close = (self.at..self.tokens.len()).find(|at| self.kind_at(*at) == Kind::CloseBrace);
        close.is_some_and(|close| self.kind_at(close + 1) == Kind::End || self.begins_item(close + 1))
    }

    fn apply_prefixes(&mut self, stack: &mut Vec<Open>, mut term: TermId) -> TermId {
        while matches!(stack.last(), Some(Open::Prefix(_))) {
            let Some(Open::Prefix(prefix)) = stack.pop() else { break };
            let span = prefix.span.to(self.tree.term_span(term));
            term = self.tree.push_term(Term::Prefixed { prefix, body: term }, span);
        }
        term
    }

    fn open_operator(&mut self, stack: &mut Vec<Open>, operator: Operator, right: TermId) {
        let left = self.join_operators(stack, right, strength(operator));
        stack.push(Open::Left(operator, left));
    }

    /// Gives the operators on the stack that bind at least this tightly their right operand.
    fn join_operators(&mut self, stack: &mut Vec<Open>, mut term: TermId, least: u8) -> TermId {
        while let Some(Open::Left(operator, left)) = stack.last() {
            if strength(*operator) < least {
                break;
            }
            let span = self.tree.term_span(*left).to(self.tree.term_span(term));
            let joined = Term::Operator { operator: *operator, left: *left, right: term };
            term = self.tree.push_term(joined, span);
            stack.pop();
        }
        term
    }

    fn close_group(&mut self, stack: &mut Vec<Open>, term: TermId, close: Span) -> TermId {
        let inside = self.join_operators(stack, term, 0);
        let Some(Open::Group(open)) = stack.pop() else { return inside };
        let group = self.tree.push_term(Term::Parenthesised(inside), open.to(close));
        self.apply_prefixes(stack, group)
    }

    fn report_missing_operator(&mut self, before: TermId) {
        let before = self.tree.term_span(before);
        let last_word = &self.source[before.range()];
        let last_word = last_word.rsplit(|c: char| c.is_whitespace()).next().unwrap_or_default();
        let message = format!("an operator is missing between `{last_word}` and {}", self.found());
        let mut report =
            Diagnostic::error(self.span(), message).label("expected `|`, `&` or `\\` before this");
        if self.begins_header_text() {
            report = report.help("if this is the header of a symbol, put it on a line of its own");
        } else {
            report = report.help("a union of solids is written `a | b`");
        }
        self.report(report);
    }

    /// Something that has no place in a term.
    fn report_stray(&mut self) {
        let report = match self.kind() {
            Kind::CloseParen => {
                Diagnostic::error(self.span(), "this `)` closes nothing").label("no `(` is open")
            }
            Kind::CloseBrace => {
                Diagnostic::error(self.span(), "this `}` closes nothing").label("no `{` is open")
            }
            Kind::Semicolon => self
                .expected("an operator or the end of the term")
                .help("a term ends without a semicolon; they are for the assignments between braces"),
            _ => self.expected("an operator or the end of the term"),
        };
        self.report(report);
    }

    fn skip_to_term_end(&mut self) {
        self.advance();
        while !matches!(
            self.kind(),
            Kind::End | Kind::CloseParen | Kind::Union | Kind::Intersection | Kind::Difference
        ) && !self.begins_item(self.at)
        {
            self.advance();
        }
    }
}

fn innermost_group(stack: &[Open]) -> Option<Span> {
    stack.iter().rev().find_map(|open| match open {
        Open::Group(span) => Some(*span),
        _ => None,
    })
}
