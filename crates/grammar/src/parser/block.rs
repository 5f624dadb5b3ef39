//! Blocks of assignments: the initial parameters, calculations, and the fields of scene blocks.

use super::Parser;
use crate::syntax::{Assignment, Block};
use crate::token::Kind;
use crate::{Diagnostic, Span};

impl Parser<'_> {
    /// `{ name = value; … }`, from the brace. The last semicolon may be left out.
    pub(super) fn block(&mut self) -> Block {
        let open = self.advance();
        let mut assignments = Vec::new();
        let close = loop {
            match self.kind() {
                Kind::CloseBrace => break self.advance(),
                Kind::Semicolon => {
                    self.report(self.expected("an assignment or `}`").help("one semicolon is enough"));
                    self.advance();
                    continue;
                }
                Kind::Name if matches!(self.kind_at(self.at + 1), Kind::Assign | Kind::Equal) => {}
                _ if self.leaves_block() => {
                    self.report(self.unclosed(open, "an assignment or `}`"));
                    break self.previous().after();
                }
                _ => {
                    self.report_no_assignment();
                    self.skip_assignment();
                    continue;
                }
            }
            assignments.extend(self.assignment());
            if let Some(close) = self.after_assignment(open) {
                break close;
            }
        };
        Block { span: open.to(close), assignments }
    }

    /// After an assignment: goes past the semicolon, or gives the end of the block.
    fn after_assignment(&mut self, open: Span) -> Option<Span> {
        match self.kind() {
            Kind::Semicolon => {
                self.advance();
                None
            }
            Kind::CloseBrace => Some(self.advance()),
            Kind::Comma => {
                self.report(
                    self.expected("`;`").help("assignments are separated by semicolons: `{a = 1; b = 2}`"),
                );
                self.advance();
                None
            }
            Kind::Name if matches!(self.kind_at(self.at + 1), Kind::Assign | Kind::Equal) => {
                // The caret belongs where the semicolon does.
                let place = self.previous().after();
                let message = format!("expected `;` before {}", self.found());
                let report = Diagnostic::error(place, message)
                    .label("expected `;`")
                    .help("assignments are separated by semicolons");
                self.report(report);
                None
            }
            _ if self.leaves_block() => {
                self.report(self.unclosed(open, "`;` or `}`"));
                Some(self.previous().after())
            }
            _ => {
                let report = self.expected("`;` or `}`");
                self.report(report.help_if(self.missing_product()).help_if(self.missing_call()));
                self.skip_assignment();
                None
            }
        }
    }

    /// `name = value`, from the name.
    pub(super) fn assignment(&mut self) -> Option<Assignment> {
        let name = self.advance();
        if self.kind() == Kind::Equal {
            self.report(self.expected("`=`").help("`==` compares; to assign, write `=`"));
        }
        self.advance();
        Some(Assignment { name, value: self.expr() })
    }

    fn report_no_assignment(&mut self) {
        let follows = self.kind_at(self.at + 1);
        let report = match self.kind() {
            Kind::Name if matches!(follows, Kind::Colon) => {
                let name = self.text();
                Diagnostic::error(
                    self.token_at(self.at + 1).span,
                    format!("expected `=` after `{name}`, found `:`"),
                )
                .label("expected `=`")
                .help(format!("write `{name} = …;`"))
            }
            Kind::Name => {
                let name = self.text();
                let found = follows.describe(self.text_at(self.at + 1));
                // `n -= 1` or `n--`
                let counts = matches!(follows, Kind::Plus | Kind::Minus | Kind::Star | Kind::Slash);
                let sign = self.text_at(self.at + 1);
                Diagnostic::error(self.span(), format!("expected `=` after `{name}`, found {found}"))
                    .label("expected an assignment")
                    .help_if(counts.then(|| format!("write `{name} = {name} {sign} …`")))
            }
            _ => self.expected("an assignment or `}`"),
        };
        self.report(report);
    }

    /// Whether what is here can only come after the block: the `}` was forgotten.
    fn leaves_block(&self) -> bool {
        let followed_by = self.kind_at(self.at + 1);
        match self.kind() {
            Kind::End | Kind::OpenBrace => true,
            Kind::Number => followed_by == Kind::Colon,
            Kind::Name => {
                followed_by == Kind::Arrow || self.begins_solid(self.at) || followed_by == Kind::OpenBrace
            }
            _ => false,
        }
    }

    /// Skips to the next assignment, or to the end of the block.
    fn skip_assignment(&mut self) {
        loop {
            match self.kind() {
                Kind::Semicolon => {
                    self.advance();
                    return;
                }
                Kind::CloseBrace | Kind::End => return,
                Kind::Name if self.kind_at(self.at + 1) == Kind::Assign => return,
                _ if self.leaves_block() => return,
                _ => self.advance(),
            };
        }
    }

    /// `name = value` and nothing else.
    pub(super) fn lone_assignment(&mut self) -> Option<Assignment> {
        if self.kind() != Kind::Name || !matches!(self.kind_at(self.at + 1), Kind::Assign | Kind::Equal) {
            self.report(self.expected("`NAME = EXPRESSION`"));
            return None;
        }
        let assignment = self.assignment();
        if self.kind() != Kind::End {
            self.report(self.expected("the end of the expression").help_if(self.missing_product()));
        } else if self.reported == Some(self.at)
            && let Some(report) = self.diagnostics.pop()
        {
            self.diagnostics.push(report.help("the expression ends too early"));
        }
        assignment
    }
}
