//! Prefixes, and the arguments in parentheses after names.

use csg_graph::{PrimitiveKind, TransformKind};

use super::Parser;
use crate::names::{self, guess, nearest};
use crate::syntax::{Assignment, Expr, ExprId, Prefix, PrefixKind};
use crate::token::Kind;
use crate::{Diagnostic, Span};

impl<'s> Parser<'s> {
    /// A name that stands before a factor, with its arguments.
    pub(super) fn prefix(&mut self, name: Span) -> Option<Prefix> {
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
    pub(super) fn args(&mut self) -> (Vec<ExprId>, Span) {
        let mut args = Vec::new();
        let Some(open) = (self.kind() == Kind::OpenParen && self.is_args()).then(|| self.advance()) else {
            if self.kind() == Kind::Number && names::is_prefix(self.text_at(self.at - 1)) {
                let name = self.text_at(self.at - 1);
                let help = match TransformKind::named(name) {
                    Some(kind) if kind.arity() == 1 => format!("write `{name}({})`", self.text()),
                    Some(kind) => format!("write `{}`", kind.signature()),
                    None => format!("write `{}`", names::COLOR_SIGNATURE),
                };
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
    pub(super) fn misspelt_prefix(&mut self, name: Span, known: bool) -> bool {
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
}
