//! Expressions: operator precedence with an explicit stack.
//!
//! From the loosest: `||`; `&&`; comparisons; `+ -`; `* / %`; the signs `-` and `!`; `^`, which groups to the right and
//! binds tighter than a sign on its left: −2^2 is −4.

use csg_graph::{Binary, Function, Unary};

use super::Parser;
use crate::syntax::{Expr, ExprId};
use crate::token::Kind;
use crate::{Diagnostic, Span};

/// What waits for the operand that is being parsed.
enum Open {
    Unary(Unary, Span),
    Binary(Binary, ExprId),
    Group { open: Span, items: Vec<ExprId> },
    Call { name: Span, open: Span, args: Vec<ExprId> },
}

/// Whether a parenthesis is open.
fn is_inside(stack: &[Open]) -> bool {
    stack.iter().any(|open| matches!(open, Open::Group { .. } | Open::Call { .. }))
}

impl Parser<'_> {
    /// Whether an expression can begin with the current token.
    pub(super) fn begins_expr(kind: Kind) -> bool {
        matches!(kind, Kind::Name | Kind::Number | Kind::OpenParen | Kind::Minus | Kind::Not)
    }

    /// The operator between operands that the current token is.
    fn binary(&self) -> Option<Binary> {
        Binary::of_symbol(self.text())
    }

    pub(super) fn expr(&mut self) -> ExprId {
        let mut stack: Vec<Open> = Vec::new();
        loop {
            let Some(operand) = self.operand(&mut stack) else { continue };
            if let Some(whole) = self.after_operand(&mut stack, operand) {
                return whole;
            }
        }
    }

    /// Where an operand is expected: an operand, or `None` after something that opens one.
    fn operand(&mut self, stack: &mut Vec<Open>) -> Option<ExprId> {
        match self.kind() {
            Kind::Number => {
                let value: f64 = self.text().parse().unwrap_or(f64::NAN);
                if !value.is_finite() {
                    let message = format!("`{}` is more than a number can hold", self.text());
                    self.report(Diagnostic::error(self.span(), message).label("at most about 1.8e308"));
                }
                let span = self.advance();
                Some(self.tree.push_expr(Expr::Number(value), span))
            }
            Kind::Name => {
                let name = self.advance();
                if self.kind() != Kind::OpenParen {
                    return Some(self.tree.push_expr(Expr::Name, name));
                }
                let open = self.advance();
                if let Some(close) = self.eat(Kind::CloseParen) {
                    return Some(self.tree.push_expr(Expr::Call { name, args: Vec::new() }, name.to(close)));
                }
                stack.push(Open::Call { name, open, args: Vec::new() });
                None
            }
            Kind::OpenParen => {
                let open = self.advance();
                stack.push(Open::Group { open, items: Vec::new() });
                None
            }
            Kind::Minus | Kind::Not => {
                let operator = Unary::of_symbol(self.text());
                let span = self.advance();
                stack.extend(operator.map(|operator| Open::Unary(operator, span)));
                None
            }
            kind => {
                let doubled = kind == Kind::Star && self.previous().end == self.span().start;
                let power = doubled && self.at > 0 && self.kind_at(self.at - 1) == Kind::Star;
                let help = power.then(|| "a power is written `a ^ b`".to_owned());
                self.report(self.expected("an expression").help_if(help));
                // A doubled operator is skipped; anything else may be what the surroundings wait for.
                if self.binary().is_some() {
                    self.advance();
                    if Self::begins_expr(self.kind()) {
                        return None;
                    }
                }
                Some(self.tree.push_expr(Expr::Missing, self.previous().after()))
            }
        }
    }

    /// After an operand: `None` if another one is expected now, else the whole expression.
    fn after_operand(&mut self, stack: &mut Vec<Open>, mut operand: ExprId) -> Option<ExprId> {
        loop {
            if let Some(operator) = self.binary() {
                // Only powers group to the right.
                let least = operator.strength() + u8::from(operator == Binary::Power);
                let left = self.reduce(stack, operand, least);
                self.advance();
                stack.push(Open::Binary(operator, left));
                return None;
            }
            match self.kind() {
                Kind::Assign if is_inside(stack) => {
                    self.report(
                        self.expected("an operator").help("`=` assigns; to compare two values, write `==`"),
                    );
                    operand = self.reduce(stack, operand, Binary::Equal.strength());
                    self.advance();
                    stack.push(Open::Binary(Binary::Equal, operand));
                    return None;
                }
                Kind::Union | Kind::Intersection if Self::begins_expr(self.kind_at(self.at + 1)) => {
                    let (logical, operator) = match self.kind() {
                        Kind::Union => ("||", Binary::Or),
                        _ => ("&&", Binary::And),
                    };
                    let help =
                        format!("`{}` joins solids; conditions are joined with `{logical}`", self.text());
                    self.report(self.expected("an operator between numbers").help(help));
                    operand = self.reduce(stack, operand, operator.strength());
                    self.advance();
                    stack.push(Open::Binary(operator, operand));
                    return None;
                }
                Kind::Question => {
                    let help = "a choice is written `if(condition, a, b)`";
                    self.report(self.expected("an operator").help(help));
                    self.skip_alternatives();
                }
                _ => {}
            }
            operand = self.reduce(stack, operand, 0);
            match stack.pop() {
                None => return Some(operand),
                Some(Open::Group { open, mut items }) => {
                    items.push(operand);
                    if self.eat(Kind::Comma).is_some() {
                        stack.push(Open::Group { open, items });
                        return None;
                    }
                    let close = self.close(open);
                    let value = match items[..] {
                        [only] => Expr::Parenthesised(only),
                        _ => Expr::Tuple(items),
                    };
                    operand = self.tree.push_expr(value, open.to(close));
                }
                Some(Open::Call { name, open, mut args }) => {
                    args.push(operand);
                    if self.eat(Kind::Comma).is_some() {
                        stack.push(Open::Call { name, open, args });
                        return None;
                    }
                    let close = self.close_args(open, &mut args);
                    operand = self.tree.push_expr(Expr::Call { name, args }, name.to(close));
                }
                Some(Open::Unary(..) | Open::Binary(..)) => unreachable!("`reduce` takes all operators"),
            }
        }
    }

    /// Skips what follows `?` up to the end of the expression.
    fn skip_alternatives(&mut self) {
        let mut depth = 0_u32;
        loop {
            self.advance();
            let kind = self.kind();
            match kind {
                Kind::OpenParen => depth += 1,
                Kind::CloseParen if depth > 0 => depth -= 1,
                Kind::End | Kind::Semicolon | Kind::OpenBrace | Kind::CloseBrace => return,
                Kind::CloseParen | Kind::Comma if depth == 0 => return,
                _ if self.token().begins_line && self.begins_item(self.at) => return,
                _ => {}
            }
        }
    }

    /// Gives the operators on the stack that bind at least this tightly their right operand.
    fn reduce(&mut self, stack: &mut Vec<Open>, mut operand: ExprId, least: u8) -> ExprId {
        loop {
            operand = match stack.last() {
                Some(Open::Unary(operator, sign)) if least <= operator.strength() => {
                    let span = sign.to(self.tree.expr_span(operand));
                    self.tree.push_expr(Expr::Unary(*operator, operand), span)
                }
                Some(Open::Binary(operator, left)) if least <= operator.strength() => {
                    let span = self.tree.expr_span(*left).to(self.tree.expr_span(operand));
                    self.warn_of_chain(*operator, *left, span);
                    self.tree.push_expr(Expr::Binary(*operator, *left, operand), span)
                }
                _ => return operand,
            };
            stack.pop();
        }
    }

    /// `0 < x < 1` compares the truth of `0 < x`, which is 0 or 1, with 1.
    fn warn_of_chain(&mut self, operator: Binary, left: ExprId, span: Span) {
        let compares = |operator: Binary| operator.strength() == Binary::Less.strength();
        let chained = matches!(self.tree.expr(left), Expr::Binary(first, ..) if compares(*first));
        if chained && compares(operator) {
            self.diagnostics.push(
                Diagnostic::warning(span, "comparisons do not chain")
                    .label("compares the truth of the first comparison, which is 0 or 1")
                    .help("write `a < b && b < c`, or parentheses if this is meant"),
            );
        }
    }

    /// The parenthesis that closes arguments, or where it should be. If it is not there, something is missing among the
    /// arguments, so that their number says nothing.
    pub(super) fn close_args(&mut self, open: Span, args: &mut Vec<ExprId>) -> Span {
        let closed = self.kind() == Kind::CloseParen;
        let close = self.close(open);
        if !closed {
            args.push(self.tree.push_expr(Expr::Missing, close.after()));
        }
        close
    }

    /// The parenthesis that closes `open`, or where it should be.
    pub(super) fn close(&mut self, open: Span) -> Span {
        if let Some(close) = self.eat(Kind::CloseParen) {
            return close;
        }
        let mut report = match self.kind() {
            Kind::Name | Kind::Number if !self.begins_item(self.at) && !self.begins_solid(self.at) => self
                .expected("`,` or `)`")
                .also(open, "in the parentheses that begin here")
                .help_if(self.missing_product())
                .help_if(self.missing_call()),
            Kind::Semicolon | Kind::End | Kind::CloseBrace | Kind::OpenBrace | Kind::Name | Kind::Number => {
                self.unclosed(open, "`)`")
            }
            _ => self.expected("`,` or `)`").also(open, "in the parentheses that begin here"),
        };
        report = match self.kind() {
            Kind::Colon => report.help("arguments are separated by commas"),
            Kind::Assign => report
                .help("arguments have no names, but those of `material`; parameters are set before a solid: `{n = 3} TREE`"),
            _ => report,
        };
        self.report(report);
        // What follows on the line up to the closing parenthesis is part of the mistake.
        let mut ahead = self.at;
        while !self.token_at(ahead).begins_line
            && !matches!(
                self.kind_at(ahead),
                Kind::CloseParen
                    | Kind::OpenParen
                    | Kind::Semicolon
                    | Kind::OpenBrace
                    | Kind::CloseBrace
                    | Kind::End
            )
            && !self.begins_item(ahead)
            && !self.begins_solid(ahead)
        {
            ahead += 1;
        }
        if self.kind_at(ahead) == Kind::CloseParen {
            self.at = ahead;
            return self.advance();
        }
        self.previous()
    }

    /// `sin 30`, as mathematicians write it.
    pub(super) fn missing_call(&self) -> Option<String> {
        let function = Function::named(self.text_at(self.at.checked_sub(1)?))?;
        let is_operand = matches!(self.kind(), Kind::Name | Kind::Number);
        is_operand.then(|| format!("`{}` is a function: write `{}`", function.name(), function.signature()))
    }

    /// `2 cnt`, as they do, too.
    pub(super) fn missing_product(&self) -> Option<String> {
        let number = self.at > 0 && self.kind_at(self.at - 1) == Kind::Number;
        (number && self.kind() == Kind::Name)
            .then(|| format!("to multiply, write `{} * {}`", self.text_at(self.at - 1), self.text()))
    }
}
