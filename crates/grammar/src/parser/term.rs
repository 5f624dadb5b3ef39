//! Terms: CSG expressions over solids, with an explicit stack.
//!
//! `∩` binds tighter than `∪` and `\`, which share a level and group to the left. Prefixes (transformations,
//! calculations, attributes) bind tightest and apply to the factor that follows; the leftmost is outermost.

use csg_graph::Operator;

use super::Parser;
use crate::names::{self, Idiom};
use crate::syntax::{Prefix, PrefixKind, Term, TermId, strength};
use crate::token::Kind;
use crate::{Diagnostic, Span};

/// What waits for the operand that is being parsed.
enum Open {
    Group(Span),
    Prefix(Prefix),
    Left(Operator, TermId),
}

fn operator(kind: Kind) -> Option<Operator> {
    match kind {
        Kind::Union => Some(Operator::Union),
        Kind::Intersection => Some(Operator::Intersection),
        Kind::Difference | Kind::Minus => Some(Operator::Difference),
        _ => None,
    }
}

impl Parser<'_> {
    pub(super) fn term(&mut self) -> TermId {
        let mut machine = TermMachine { parser: self, stack: Vec::new(), groups: 0 };
        loop {
            let Some(factor) = machine.factor() else { continue };
            if let Some(whole) = machine.after_factor(factor) {
                return whole;
            }
        }
    }

    pub(super) fn begins_factor(&self) -> bool {
        matches!(self.kind(), Kind::Name | Kind::OpenParen | Kind::OpenBrace)
    }

    /// Whether the name at a token is one that only solids and prefixes have.
    pub(super) fn begins_solid(&self, at: usize) -> bool {
        let name = self.text_at(at);
        self.kind_at(at) == Kind::Name && (names::is_built_in(name) || self.is_defined(name))
    }

    /// What was meant by something between solids that joins numbers, or solids elsewhere.
    fn meant(&self) -> Option<Operator> {
        match self.kind() {
            Kind::Or | Kind::Plus => Some(Operator::Union),
            Kind::And | Kind::Star | Kind::Caret => Some(Operator::Intersection),
            Kind::Slash => Some(Operator::Difference),
            Kind::Comma if matches!(self.kind_at(self.at + 1), Kind::Name | Kind::OpenParen) => {
                Some(Operator::Union)
            }
            Kind::Name => match self.idiom(self.at) {
                Some(Idiom::Operator(operator)) => Some(operator),
                _ => None,
            },
            _ => None,
        }
    }

    /// What the word at a token means elsewhere, if it means nothing here.
    pub(super) fn idiom(&self, at: usize) -> Option<Idiom> {
        let name = self.text_at(at);
        (self.kind_at(at) == Kind::Name && !self.is_defined(name)).then(|| Idiom::of(name)).flatten()
    }

    /// Whether `union { … }`, `difference() { … }` or `for (…)` begins here.
    fn begins_foreign_construct(&self) -> bool {
        self.idiom(self.at).is_some()
            && matches!(self.kind_at(self.at + 1), Kind::OpenParen | Kind::OpenBrace)
    }

    /// Goes past the word that begins it, and parentheses that hold no solids.
    fn foreign_construct(&mut self) {
        let idiom = self.idiom(self.at);
        self.report(self.expected("a solid").help_if(idiom.map(Idiom::here)));
        self.advance();
        let is_empty = self.kind_at(self.at + 1) == Kind::CloseParen;
        if self.kind() == Kind::OpenParen && (is_empty || idiom == Some(Idiom::Loop)) {
            self.skip_enclosed(Kind::OpenParen, Kind::CloseParen);
        }
    }

    /// Whether the brace here encloses something else than assignments, right or wrong.
    fn begins_foreign_block(&self) -> bool {
        let [first, second] = [1, 2].map(|ahead| self.kind_at(self.at + ahead));
        let is_assignment = match first {
            Kind::Name => matches!(
                second,
                Kind::Assign
                    | Kind::Equal
                    | Kind::Colon
                    | Kind::Plus
                    | Kind::Minus
                    | Kind::Star
                    | Kind::Slash
            ),
            Kind::Semicolon | Kind::CloseBrace | Kind::End => true,
            _ => false,
        };
        self.kind() == Kind::OpenBrace && !is_assignment
    }

    /// Goes past a block that holds no assignments.
    fn foreign_block(&mut self) {
        let report =
            Diagnostic::error(self.span(), "a block without assignments").label("no `name = value` here");
        self.report(report.help(
            "braces hold assignments, as in `{n = n - 1} TREE`; parentheses group solids, and what changes a solid stands \
             before it: `move(0, 0, 1) uscale(2) sphere`",
        ));
        self.skip_enclosed(Kind::OpenBrace, Kind::CloseBrace);
    }

    /// From something that opens to behind what closes it, or to the next rule: then it was never closed.
    pub(super) fn skip_enclosed(&mut self, open: Kind, close: Kind) {
        let mut depth = 0_u32;
        loop {
            match (self.kind(), self.kind_at(self.at + 1)) {
                (Kind::End, _) | (Kind::Name, Kind::Arrow) | (Kind::Number, Kind::Colon) => return,
                (kind, _) if kind == open => depth += 1,
                (kind, _) if kind == close => depth -= 1,
                _ => {}
            }
            self.advance();
            if depth == 0 {
                return;
            }
        }
    }

    /// Whether the brace here opens a block of parameters that has no solid after it, and so no place in a term.
    fn is_lost_block(&self) -> bool {
        if self.kind() != Kind::OpenBrace || !self.token().begins_line {
            return false;
        }
        let close = (self.at..self.tokens.len()).find(|at| self.kind_at(*at) == Kind::CloseBrace);
        close.is_some_and(|close| self.kind_at(close + 1) == Kind::End || self.begins_item(close + 1))
    }

    fn report_missing_operator(&mut self, before: TermId) {
        let before = self.tree.term_span(before);
        let last_word = &self.source[before.range()];
        let last_word = last_word.rsplit(|c: char| c.is_whitespace()).next().unwrap_or_default();
        let message = format!("an operator is missing between `{last_word}` and {}", self.found());
        let idiom = self.idiom(self.at).unwrap_or(Idiom::Operator(Operator::Union)).here();
        let help = if self.begins_header_text() {
            "if this is the header of a symbol, put it on a line of its own".to_owned()
        } else if self.kind() == Kind::OpenBrace {
            format!("{idiom}; a calculation stands before its solid: `{{n = n - 1}} TREE`")
        } else if names::is_prefix(self.text()) {
            format!("{idiom}; what changes a solid stands before it: `move(0, 0, 1) sphere`")
        } else {
            idiom
        };
        let report = Diagnostic::error(self.span(), message).label("expected `|`, `&` or `\\` before this");
        self.report(report.help(help));
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

/// A term that is being parsed.
struct TermMachine<'p, 's> {
    parser: &'p mut Parser<'s>,
    /// What is open, the innermost last.
    stack: Vec<Open>,
    /// How many groups are among it.
    groups: usize,
}

impl TermMachine<'_, '_> {
    /// Where a factor is expected: a solid, or `None` after something that must precede one.
    fn factor(&mut self) -> Option<TermId> {
        match self.parser.kind() {
            Kind::OpenParen => {
                self.stack.push(Open::Group(self.parser.advance()));
                self.groups += 1;
                None
            }
            Kind::OpenBrace if self.parser.begins_foreign_block() => {
                let place = self.parser.span();
                self.parser.foreign_block();
                Some(self.parser.tree.push_term(Term::Missing, place))
            }
            Kind::OpenBrace => {
                let block = self.parser.block();
                self.stack.push(Open::Prefix(Prefix {
                    kind: PrefixKind::Calculation(block.assignments),
                    span: block.span,
                }));
                None
            }
            Kind::Name if self.parser.begins_foreign_construct() => {
                self.parser.foreign_construct();
                None
            }
            Kind::Name if !self.parser.surely_begins_item(self.parser.at) => {
                let known = self.parser.reported == Some(self.parser.at);
                let name = self.parser.advance();
                if let Some(prefix) = self.parser.prefix(name) {
                    self.stack.push(Open::Prefix(prefix));
                    return None;
                }
                let (args, end) = self.parser.args();
                if self.parser.misspelt_prefix(name, known) {
                    return None;
                }
                Some(self.parser.tree.push_term(Term::Solid { name, args }, name.to(end)))
            }
            _ => {
                let expected = match self.stack.last() {
                    Some(Open::Prefix(prefix)) => {
                        let before = &self.parser.source[prefix.span.range()];
                        let what = if before.len() <= 40 { before } else { "this" };
                        self.parser
                            .expected(&format!("a solid after `{what}`"))
                            .label("expected a solid")
                            .help("what is before a solid applies to the solid that follows it")
                    }
                    _ => self.parser.expected("a solid"),
                };
                self.parser.report(expected);
                let place = self.parser.previous().after();
                Some(self.parser.tree.push_term(Term::Missing, place))
            }
        }
    }

    /// After a factor: `None` if another one is expected now, else the whole term.
    fn after_factor(&mut self, factor: TermId) -> Option<TermId> {
        let mut term = self.apply_prefixes(factor);
        loop {
            if let Some(operator) = operator(self.parser.kind()) {
                self.parser.advance();
                self.open_operator(operator, term);
                return None;
            }
            if self.parser.kind() == Kind::CloseParen && self.groups > 0 {
                let close = self.parser.advance();
                term = self.close_group(term, close);
                self.groups -= 1;
                continue;
            }
            if self.parser.kind() == Kind::End
                || self.parser.begins_item(self.parser.at)
                || self.groups == 0 && self.parser.is_lost_block()
            {
                break;
            }
            if let Some(operator) = self.parser.meant() {
                let help = Idiom::Operator(operator).here();
                self.parser.report(self.parser.expected("an operator between solids").help(help));
                self.parser.advance();
                self.open_operator(operator, term);
                return None;
            }
            if self.parser.begins_foreign_block() {
                self.parser.foreign_block();
                continue;
            }
            if self.parser.begins_factor() {
                self.parser.report_missing_operator(term);
                self.open_operator(Operator::Union, term);
                return None;
            }
            self.parser.report_stray();
            self.parser.skip_to_term_end();
        }
        // What is still open was never closed; the innermost tells where.
        let mut innermost = true;
        while self.groups > 0 {
            let close = self.parser.previous().after();
            if let (true, Some(open)) = (innermost, self.innermost_group()) {
                self.parser.report(self.parser.unclosed(open, "`)`"));
                innermost = false;
            }
            term = self.close_group(term, close);
            self.groups -= 1;
        }
        Some(self.join_operators(term, 0))
    }

    fn apply_prefixes(&mut self, mut term: TermId) -> TermId {
        while matches!(self.stack.last(), Some(Open::Prefix(_))) {
            let Some(Open::Prefix(prefix)) = self.stack.pop() else { break };
            let span = prefix.span.to(self.parser.tree.term_span(term));
            term = self.parser.tree.push_term(Term::Prefixed { prefix, body: term }, span);
        }
        term
    }

    fn open_operator(&mut self, operator: Operator, right: TermId) {
        let left = self.join_operators(right, strength(operator));
        self.stack.push(Open::Left(operator, left));
    }

    /// Gives the operators on the stack that bind at least this tightly their right operand.
    fn join_operators(&mut self, mut term: TermId, least: u8) -> TermId {
        while let Some(Open::Left(operator, left)) = self.stack.last() {
            if strength(*operator) < least {
                break;
            }
            let span = self.parser.tree.term_span(*left).to(self.parser.tree.term_span(term));
            let joined = Term::Operator { operator: *operator, left: *left, right: term };
            term = self.parser.tree.push_term(joined, span);
            self.stack.pop();
        }
        term
    }

    fn close_group(&mut self, term: TermId, close: Span) -> TermId {
        let inside = self.join_operators(term, 0);
        let Some(Open::Group(open)) = self.stack.pop() else { return inside };
        let group = self.parser.tree.push_term(Term::Parenthesised(inside), open.to(close));
        self.apply_prefixes(group)
    }

    fn innermost_group(&self) -> Option<Span> {
        self.stack.iter().rev().find_map(|open| match open {
            Open::Group(span) => Some(*span),
            _ => None,
        })
    }
}
