//! A file: parameters, axiom, and items.

use csg_graph::Function;

use super::Parser;
use crate::names::{self, BLOCKS, nearest};
use crate::syntax::{Header, Item, Macro, Rule, SceneBlock};
use crate::token::Kind;
use crate::{Diagnostic, Span};

impl Parser<'_> {
    pub(super) fn file(&mut self) {
        if self.kind() == Kind::End {
            self.report(
                Diagnostic::error(self.span(), "the file is empty")
                    .label("expected the parameters and the axiom")
                    .help("the smallest file is `{} sphere`"),
            );
            return;
        }
        self.head();
        while self.kind() != Kind::End {
            let before = self.at;
            self.item();
            debug_assert!(self.at > before || self.kind() == Kind::End, "an item takes a token");
        }
    }

    fn head(&mut self) {
        if self.kind() == Kind::OpenBrace {
            self.tree.parameters = self.block();
        } else {
            self.report(self.expected("the parameters").help(
                "a file begins with the initial parameters between braces, `{}` if there are none, and the axiom",
            ));
            self.parameters_without_braces();
        }
        if self.lacks_axiom() {
            let place = self.previous().after();
            self.report(
                Diagnostic::error(place, "the axiom is missing").label("expected a solid").help(
                    "after the parameters comes the solid to build, usually a symbol: `{ n = 3; } TREE`",
                ),
            );
            return;
        }
        let axiom = self.term();
        self.tree.axiom = Some(axiom);
    }

    /// `n = 8;` before anything else.
    fn parameters_without_braces(&mut self) {
        while self.kind() == Kind::Name && self.kind_at(self.at + 1) == Kind::Assign {
            let ends = (self.at + 1..self.tokens.len())
                .find(|at| self.kind_at(*at) == Kind::Semicolon || self.token_at(*at).begins_line);
            if ends.is_none_or(|end| self.kind_at(end) != Kind::Semicolon) {
                return;
            }
            let assignment = self.assignment();
            self.tree.parameters.assignments.extend(assignment);
            self.eat(Kind::Semicolon);
        }
    }

    /// Whether an item begins where the axiom belongs. A name on a line alone is the axiom and no header.
    fn lacks_axiom(&self) -> bool {
        match self.kind() {
            Kind::End => true,
            Kind::Name if self.symbols.contains(self.text()) && self.kind_at(self.at + 1) == Kind::Name => {
                Function::named(self.text_at(self.at + 1)).is_some()
                    && self.kind_at(self.at + 2) == Kind::OpenParen
            }
            Kind::Name => {
                let next = self.kind_at(self.at + 1);
                matches!(next, Kind::Arrow | Kind::Assign)
                    || next == Kind::OpenBrace && BLOCKS.contains(&self.text())
            }
            _ => self.begins_item(self.at),
        }
    }

    /// Whether an item begins at a token after a term. The term ends there, however many parentheses are open.
    pub(super) fn begins_item(&self, at: usize) -> bool {
        self.surely_begins_item(at) || self.begins_header(at)
    }

    /// Whether an item begins at a token even where a solid is expected: what is here cannot be one.
    pub(super) fn surely_begins_item(&self, at: usize) -> bool {
        let (next, after_next) = (self.kind_at(at + 1), self.kind_at(at + 2));
        match self.kind_at(at) {
            Kind::Number => next == Kind::Colon || next == Kind::Name && after_next == Kind::Arrow,
            Kind::Name if matches!(next, Kind::Arrow | Kind::Assign) => true,
            Kind::Name if next == Kind::OpenParen && self.token_at(at).begins_line => {
                self.begins_block_in_parentheses(at) || self.arrow_after_parameters(at).is_some()
            }
            Kind::Name if next == Kind::OpenBrace => {
                let name = self.text_at(at);
                let unknown = !self.is_defined(name) && !names::is_built_in(name) && self.idiom(at).is_none();
                BLOCKS.contains(&name) || unknown && self.token_at(at).begins_line
            }
            // `NAME if(…)` is a header, even if all rules of the symbol are misspelt.
            Kind::Name if next == Kind::Name && after_next == Kind::OpenParen => {
                self.token_at(at).begins_line
                    && !names::is_built_in(self.text_at(at))
                    && Function::named(self.text_at(at + 1)).is_some()
            }
            _ => false,
        }
    }

    /// `camera(` in place of `camera {`.
    fn begins_block_in_parentheses(&self, at: usize) -> bool {
        let name = self.text_at(at);
        self.kind_at(at + 1) == Kind::OpenParen && BLOCKS.contains(&name) && !self.is_defined(name)
    }

    /// Where the arrow of `TREE(n, size) -> …` is, from the name of the symbol.
    pub(super) fn arrow_after_parameters(&self, at: usize) -> Option<usize> {
        if self.kind_at(at + 1) != Kind::OpenParen {
            return None;
        }
        let close =
            (at + 2..self.tokens.len()).find(|at| !matches!(self.kind_at(*at), Kind::Name | Kind::Comma))?;
        let is_rule = self.kind_at(close) == Kind::CloseParen && self.kind_at(close + 1) == Kind::Arrow;
        is_rule.then_some(close + 1)
    }

    /// Whether a name is the header of a symbol, and not a solid that lacks its operator. A header begins a line; without
    /// a selection function, which makes it an ornament, a rule of its symbol must follow.
    fn begins_header(&self, at: usize) -> bool {
        let name = self.text_at(at);
        let name_begins_line = self.kind_at(at) == Kind::Name && self.token_at(at).begins_line;
        if !name_begins_line || !self.symbols.contains(name) {
            return false;
        }
        match (self.kind_at(at + 1), self.kind_at(at + 2)) {
            (Kind::Number, Kind::Colon) => self.text_at(at + 3) == name,
            (Kind::Name, Kind::Arrow) => self.text_at(at + 1) == name,
            (Kind::Name, _) => !names::is_built_in(self.text_at(at + 1)),
            (next, _) => Self::begins_expr(next),
        }
    }

    /// Whether the current token would be a header if it began a line.
    pub(super) fn begins_header_text(&self) -> bool {
        self.kind() == Kind::Name
            && self.symbols.contains(self.text())
            && matches!(self.kind_at(self.at + 1), Kind::Name | Kind::Number)
    }

    fn item(&mut self) {
        let next = self.kind_at(self.at + 1);
        match self.kind() {
            Kind::Number => self.numbered_rule(),
            Kind::Name if next == Kind::Arrow => self.rule(None),
            Kind::Name if next == Kind::Assign => {
                let name = self.advance();
                self.advance();
                let body = self.term();
                self.tree.items.push(Item::Macro(Macro { name, body }));
            }
            Kind::Name if next == Kind::OpenBrace || self.begins_block_in_parentheses(self.at) => {
                self.scene_block();
            }
            Kind::Name if self.arrow_after_parameters(self.at).is_some() => self.rule(None),
            Kind::Name => self.header(),
            Kind::OpenBrace => {
                self.report(
                    Diagnostic::error(self.span(), "a block of parameters in the middle of the file")
                        .label("belongs before the axiom")
                        .help("all initial parameters are between the first braces of the file"),
                );
                self.block();
                if !self.begins_item(self.at) && self.kind() != Kind::End {
                    self.term();
                }
            }
            _ => {
                self.report(self.expected("a rule, a symbol, a macro or a scene block"));
                self.skip_to_item();
            }
        }
    }

    fn header(&mut self) {
        let name = self.advance();
        let bare = self.begins_item(self.at) || !Self::begins_expr(self.kind());
        let selection = if bare { None } else { Some(self.expr()) };
        self.tree.items.push(Item::Header(Header { name, selection }));
        let may_be_header = self.kind() == Kind::Name && self.token().begins_line;
        if self.kind() != Kind::End && !self.begins_item(self.at) && !may_be_header {
            self.report(self.expected("a rule").help_if(self.misplaced_arrow()).help_if(self.missing_call()));
            self.skip_to_item();
        }
    }

    fn misplaced_arrow(&self) -> Option<String> {
        (self.kind() == Kind::Arrow).then(|| "a rule is written `1: NAME -> term`".to_owned())
    }

    fn numbered_rule(&mut self) {
        let number = self.advance();
        if self.eat(Kind::Colon).is_none() {
            self.report(self.expected("`:` after the number of the rule"));
        }
        if self.kind() == Kind::Name {
            self.rule(Some(number));
        } else {
            self.report(self.expected("the symbol of the rule").help("a rule is written `1: NAME -> term`"));
            self.skip_to_item();
        }
    }

    fn rule(&mut self, number: Option<Span>) {
        let arrow = self.arrow_after_parameters(self.at);
        let symbol = self.advance();
        if let Some(arrow) = arrow {
            self.report(
                Diagnostic::error(self.span(), "a symbol has no parameters of its own").label("not here").help(
                    "parameters get their first values between the first braces of the file, and others before a symbol: \
                     `{n = n - 1} TREE`",
                ),
            );
            self.at = arrow;
        }
        if self.eat(Kind::Arrow).is_none() {
            self.report(self.expected("`->`").help("a rule is written `1: NAME -> term`"));
            // `=`, `=>` or `:` in its place.
            let wrong =
                [Kind::Assign, Kind::Equal, Kind::Greater, Kind::GreaterEqual, Kind::Minus, Kind::Colon];
            while wrong.contains(&self.kind()) {
                self.advance();
            }
        }
        let body = self.term();
        self.tree.items.push(Item::Rule(Rule { number, symbol, body }));
    }

    fn scene_block(&mut self) {
        let (name, text) = (self.span(), self.text());
        if !BLOCKS.contains(&text) {
            let help = match nearest(text, BLOCKS) {
                Some(block) => format!("did you mean `{block}`?"),
                None => format!("the blocks are {}", BLOCKS.join(", ")),
            };
            let report =
                Diagnostic::error(name, format!("unknown block `{text}`")).label("unknown").help(help);
            self.report(report);
        }
        self.advance();
        if self.kind() != Kind::OpenBrace {
            let help = format!("the fields of a block are between braces: `{text} {{ … }}`");
            self.report(self.expected("`{`").help(help));
            self.skip_enclosed(Kind::OpenParen, Kind::CloseParen);
            return;
        }
        let fields = self.block();
        self.tree.items.push(Item::Scene(SceneBlock { name, fields }));
    }

    fn skip_to_item(&mut self) {
        if self.kind() == Kind::End {
            return;
        }
        self.advance();
        while self.kind() != Kind::End && !self.begins_item(self.at) {
            self.advance();
        }
    }
}
