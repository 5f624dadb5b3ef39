//! From tokens to the syntax tree, past mistakes.
//!
//! Recursive descent without the recursion: terms and expressions keep explicit stacks of what is open, so that
//! parentheses may nest as deep as memory allows. Items do not nest.
//!
//! A mistake is reported where it is met, then the parser assumes what was most likely meant (a missing operator is a
//! union, a comma between assignments a semicolon) or skips to where it knows its way again: a closing parenthesis or
//! brace, a semicolon, the beginning of an item. One place is reported once.

mod block;
mod expr;
mod item;
mod prefix;
mod term;

use std::collections::BTreeSet;

use crate::syntax::{Assignment, SyntaxTree};
use crate::token::{self, Kind, Token};
use crate::{Diagnostic, Span};

/// What [`parse`] makes of a text.
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The tree; with gaps where there are errors.
    pub tree: SyntaxTree,
    /// The mistakes in the syntax, in the order of the text.
    pub diagnostics: Vec<Diagnostic>,
}

impl Parsed {
    /// Whether something is wrong with the syntax.
    pub fn has_errors(&self) -> bool {
        self.tree.is_damaged()
    }
}

/// Parses a file. Takes time in proportion to its length, and no machine stack.
///
/// ```
/// let parsed = csg_graph_grammar::parse("{} sphere | move(0, 0, 1) cube");
/// assert!(!parsed.has_errors());
/// ```
pub fn parse(source: &str) -> Parsed {
    let mut parser = Parser::new(source, "the end of the file");
    parser.file();
    parser.finish()
}

/// Parses one assignment, `name = expression`, for a parameter that is set from outside.
pub(crate) fn parse_assignment(source: &str) -> (Parsed, Option<Assignment>) {
    let mut parser = Parser::new(source, "the end");
    let assignment = parser.lone_assignment();
    (parser.finish(), assignment)
}

struct Parser<'s> {
    source: &'s str,
    /// What the end of the source is called in messages.
    end: &'static str,
    tokens: Vec<Token>,
    at: usize,
    tree: SyntaxTree,
    diagnostics: Vec<Diagnostic>,
    /// The token that was reported last.
    reported: Option<usize>,
    /// The names that stand before an arrow anywhere in the file.
    symbols: BTreeSet<&'s str>,
    /// The names that stand before `=` outside braces.
    macros: BTreeSet<&'s str>,
}

impl<'s> Parser<'s> {
    fn new(source: &'s str, end: &'static str) -> Self {
        let mut diagnostics = Vec::new();
        let token::Lexed { tokens, comments } = token::lex(source, &mut diagnostics);
        let unicode = tokens.iter().any(|token| {
            matches!(token.kind, Kind::Arrow | Kind::Union | Kind::Intersection)
                && !source[token.span.range()].is_ascii()
        });
        let tree = SyntaxTree { source: source.into(), comments, unicode, ..Default::default() };
        let mut parser = Self {
            source,
            end,
            tokens,
            at: 0,
            tree,
            diagnostics,
            reported: None,
            symbols: BTreeSet::new(),
            macros: BTreeSet::new(),
        };
        parser.find_definitions();
        parser
    }

    fn finish(mut self) -> Parsed {
        self.tree.damaged = self.diagnostics.iter().any(Diagnostic::is_error);
        self.diagnostics.sort_by_key(|diagnostic| diagnostic.primary.span.start);
        Parsed { tree: self.tree, diagnostics: self.diagnostics }
    }

    /// What the file defines, so that the parser can tell the header of a symbol from a solid whose operator is missing,
    /// and a misspelt transformation from a misspelt solid.
    fn find_definitions(&mut self) {
        let (mut open_braces, mut open_parentheses) = (0_u32, 0_u32);
        for at in 0..self.tokens.len() {
            match self.kind_at(at) {
                Kind::OpenBrace => open_braces += 1,
                Kind::CloseBrace => open_braces = open_braces.saturating_sub(1),
                Kind::OpenParen => open_parentheses += 1,
                Kind::CloseParen => open_parentheses = open_parentheses.saturating_sub(1),
                // Only rules have arrows: what is still open here was never closed.
                Kind::Arrow => (open_braces, open_parentheses) = (0, 0),
                Kind::Name
                    if self.kind_at(at + 1) == Kind::Arrow || self.arrow_after_parameters(at).is_some() =>
                {
                    self.symbols.insert(self.text_at(at));
                }
                Kind::Name
                    if self.kind_at(at + 1) == Kind::Assign
                        && open_braces == 0
                        && (open_parentheses == 0 || self.token_at(at).begins_line) =>
                {
                    self.macros.insert(self.text_at(at));
                }
                _ => {}
            }
        }
    }

    fn is_defined(&self, name: &str) -> bool {
        self.symbols.contains(name) || self.macros.contains(name)
    }

    fn token(&self) -> Token {
        self.token_at(self.at)
    }

    fn token_at(&self, at: usize) -> Token {
        self.tokens[at.min(self.tokens.len() - 1)]
    }

    fn kind(&self) -> Kind {
        self.token().kind
    }

    fn kind_at(&self, at: usize) -> Kind {
        self.token_at(at).kind
    }

    fn span(&self) -> Span {
        self.token().span
    }

    fn text(&self) -> &'s str {
        self.text_at(self.at)
    }

    fn text_at(&self, at: usize) -> &'s str {
        &self.source[self.token_at(at).span.range()]
    }

    /// The token before the current one; the beginning of the text if there is none.
    fn previous(&self) -> Span {
        self.at.checked_sub(1).map_or_else(Span::default, |at| self.tokens[at].span)
    }

    /// Goes past the current token, which is not the end, and gives its span.
    fn advance(&mut self) -> Span {
        let span = self.span();
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        span
    }

    fn eat(&mut self, kind: Kind) -> Option<Span> {
        (self.kind() == kind).then(|| self.advance())
    }

    /// The current token, as messages name it.
    fn found(&self) -> String {
        match self.kind() {
            Kind::End => self.end.to_owned(),
            kind => kind.describe(self.text()),
        }
    }

    /// An error at the current token. Nothing is said twice about one token, nor about one that follows characters that
    /// have been reported as strange.
    fn report(&mut self, diagnostic: Diagnostic) {
        let known = self.reported == Some(self.at) || self.token().after_garbage;
        self.reported = Some(self.at);
        if !known {
            self.diagnostics.push(diagnostic);
        }
    }

    /// "expected this, found that" at the current token.
    fn expected(&self, what: &str) -> Diagnostic {
        Diagnostic::error(self.span(), format!("expected {what}, found {}", self.found()))
            .label(format!("expected {what}"))
    }

    /// Something that was opened and not closed before the current token.
    fn unclosed(&self, open: Span, what: &str) -> Diagnostic {
        let opener = &self.source[open.range()];
        Diagnostic::error(open, format!("this `{opener}` is not closed"))
            .label("opened here")
            .also(self.span(), format!("expected {what}, found {}", self.found()))
    }
}
