//! From characters to tokens and comments.

use logos::Logos;

use crate::{Diagnostic, Span};

/// What a token is. Its text is in the source.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq)]
#[logos(skip r"[ \t\r\n\f\u{feff}\u{a0}]+")]
pub(crate) enum Kind {
    #[regex(r"//[^\n]*", allow_greedy = true)]
    Comment,
    /// A comment of another language.
    #[regex(r"#[^\n]*", allow_greedy = true)]
    #[regex(r"/\*([^*]|\*+[^*/])*\*+/")]
    ForeignComment,
    #[regex(r"[\p{XID_Start}_]\p{XID_Continue}*")]
    Name,
    #[regex(r"([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")]
    Number,
    #[token("{")]
    OpenBrace,
    #[token("}")]
    CloseBrace,
    #[token("(")]
    OpenParen,
    #[token(")")]
    CloseParen,
    #[token(",")]
    Comma,
    #[token(";")]
    Semicolon,
    #[token(":")]
    Colon,
    #[token("=")]
    Assign,
    #[token("->")]
    #[token("→")]
    Arrow,
    #[token("|")]
    #[token("∪")]
    Union,
    #[token("&")]
    #[token("∩")]
    Intersection,
    #[token("\\")]
    Difference,
    #[token("+")]
    Plus,
    #[token("-")]
    Minus,
    #[token("*")]
    Star,
    #[token("/")]
    Slash,
    #[token("%")]
    Percent,
    #[token("^")]
    Caret,
    #[token("<")]
    Less,
    #[token("<=")]
    LessEqual,
    #[token(">")]
    Greater,
    #[token(">=")]
    GreaterEqual,
    #[token("==")]
    Equal,
    #[token("!=")]
    NotEqual,
    #[token("&&")]
    And,
    #[token("||")]
    Or,
    #[token("!")]
    Not,
    /// A choice as other languages write it.
    #[token("?")]
    Question,
    /// Behind the last token.
    End,
}

/// A token.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Token {
    pub(crate) kind: Kind,
    pub(crate) span: Span,
    /// Nothing but space is before it on its line.
    pub(crate) begins_line: bool,
    /// Something that is no token is before it. That has been reported; what it makes of the syntax need not be.
    pub(crate) after_garbage: bool,
}

/// The tokens of a text, the last of which is [`Kind::End`], and its comments, in order.
pub(crate) struct Lexed {
    pub(crate) tokens: Vec<Token>,
    pub(crate) comments: Vec<Span>,
}

pub(crate) fn lex(source: &str, diagnostics: &mut Vec<Diagnostic>) -> Lexed {
    let mut lexed = Lexed { tokens: Vec::new(), comments: Vec::new() };
    let mut end_of_last = 0;
    let mut garbage: Option<Span> = None;
    let mut after_garbage = false;
    let end = (Ok(Kind::End), source.len()..source.len());
    for (kind, range) in Kind::lexer(source).spanned().chain([end]) {
        let mut span = Span::from(range);
        let Ok(kind) = kind else {
            // One report for a run of strange characters.
            match &mut garbage {
                Some(run) if run.end == span.start => run.end = span.end,
                _ => {
                    diagnostics.extend(garbage.map(|span| strange(source, span)));
                    garbage = Some(span);
                }
            }
            after_garbage = true;
            continue;
        };
        diagnostics.extend(garbage.take().map(|span| strange(source, span)));
        if kind == Kind::ForeignComment {
            let width = if source[span.start..].starts_with('#') { 1 } else { 2 };
            diagnostics.push(strange(source, Span { start: span.start, end: span.start + width }));
            after_garbage = is_colour(source, span.start);
            continue;
        }
        if kind == Kind::Comment {
            lexed.comments.push(span);
            continue;
        }
        if kind == Kind::End {
            // What is missing at the end is missing after the last token, not after the comments.
            span = Span { start: end_of_last, end: end_of_last };
        }
        let begins_line = lexed.tokens.is_empty() || source[end_of_last..span.start].contains('\n');
        lexed.tokens.push(Token { kind, span, begins_line, after_garbage });
        (after_garbage, end_of_last) = (false, span.end);
    }
    lexed
}

/// Characters that people type, or that programs put, in place of those of the language.
const LOOKALIKES: [(&str, &str); 13] = [
    ("−–—", "-"),
    ("×·⋅", "*"),
    ("÷", "/"),
    ("≤", "<="),
    ("≥", ">="),
    ("≠", "!="),
    ("∧", "&&"),
    ("∨", "||"),
    ("¬", "!"),
    ("∖", "\\"),
    ("⟶⇒", "->"),
    ("[", "("),
    ("]", ")"),
];

/// Whether a colour is there as other languages write it: `#ff8000`.
fn is_colour(source: &str, at: usize) -> bool {
    let digits = source[at..]
        .strip_prefix('#')
        .map_or("", |rest| rest.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default());
    [3, 4, 6, 8].contains(&digits.len()) && digits.chars().all(|c| c.is_ascii_hexdigit())
}

fn strange(source: &str, span: Span) -> Diagnostic {
    let text = &source[span.range()];
    let first = text.chars().next().unwrap_or_default();
    let meant = LOOKALIKES.iter().find(|(strange, _)| strange.contains(first)).map(|(_, meant)| *meant);
    let help = match (meant, first) {
        (Some(meant), _) => Some(format!("write `{meant}`")),
        _ if is_colour(source, span.start) => {
            Some("a colour is three numbers, red, green and blue, from 0 to 1: `(1, 0.5, 0)`".to_owned())
        }
        (None, '°') => Some("angles are in degrees without a sign".to_owned()),
        (None, '#' | '/') => Some("a comment begins with `//` and ends with the line".to_owned()),
        (None, _) => None,
    };
    let shown = text.chars().next().filter(|c| c.is_control()).map_or_else(
        || format!("`{text}`"),
        |control| format!("the control character U+{:04X}", u32::from(control)),
    );
    Diagnostic::error(span, format!("{shown} means nothing here")).label("unknown").help_if(help)
}

impl Kind {
    /// As it is named in messages, where the text itself does not tell.
    pub(crate) fn describe(self, text: &str) -> String {
        match self {
            Self::End => "the end of the file".to_owned(),
            _ => format!("`{text}`"),
        }
    }
}
