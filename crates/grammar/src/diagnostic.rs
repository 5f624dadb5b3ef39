//! What is told to the author of a file: where a mistake is, what it is, and what was probably meant.

use std::fmt;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

use crate::{Span, line_column};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// The file has no meaning.
    Error,
    /// The file has a meaning, perhaps not the intended one.
    Warning,
}

/// A span with what is to be said about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What; may be empty.
    pub text: String,
}

/// A text other than the file, which the spans of a diagnostic refer to: the value of a parameter from outside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// What it is called, in place of a file name.
    pub name: String,
    /// The text.
    pub text: String,
}

/// A mistake in a file, or a doubt about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, in one sentence without a full stop.
    pub message: String,
    /// Where.
    pub primary: Label,
    /// Other places that have to do with it.
    pub secondary: Vec<Label>,
    /// What was probably meant, or how to mend it.
    pub help: Option<String>,
    /// The text that the spans refer to, if it is not the file.
    pub excerpt: Option<Excerpt>,
}

impl Diagnostic {
    /// An error at a place.
    pub fn error(span: Span, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, span, message.into())
    }

    /// A warning at a place.
    pub fn warning(span: Span, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, span, message.into())
    }

    fn new(severity: Severity, span: Span, message: String) -> Self {
        let primary = Label { span, text: String::new() };
        Self { severity, message, primary, secondary: Vec::new(), help: None, excerpt: None }
    }

    /// Says something at the caret.
    #[must_use]
    pub fn label(mut self, text: impl Into<String>) -> Self {
        self.primary.text = text.into();
        self
    }

    /// Points at another place.
    #[must_use]
    pub fn also(mut self, span: Span, text: impl Into<String>) -> Self {
        self.secondary.push(Label { span, text: text.into() });
        self
    }

    /// Guesses what was meant.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    pub(crate) fn help_if(mut self, help: Option<String>) -> Self {
        self.help = self.help.or(help);
        self
    }

    /// Whether it is an error.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// The line and the column where it points, from 1, in `source` or in its own excerpt.
    pub fn position(&self, source: &str) -> (usize, usize) {
        let text = self.excerpt.as_ref().map_or(source, |excerpt| &excerpt.text);
        line_column(text, self.primary.span.start)
    }

    /// As text for people, with the lines of the source and carets, in the style of rustc.
    ///
    /// `source` is the text that was parsed, `colour` asks for the escape codes of terminals. Ends without a newline.
    pub fn render(&self, file_name: &str, source: &str, colour: bool) -> String {
        let (name, text) = match &self.excerpt {
            Some(excerpt) => (excerpt.name.as_str(), excerpt.text.as_str()),
            None => (file_name, source),
        };
        let (window, first_line) = Window::around(text, self);
        let mut snippet = Snippet::source(window.text).path(name).line_start(first_line);
        snippet = snippet.annotation(window.annotation(AnnotationKind::Primary, &self.primary));
        for label in &self.secondary {
            snippet = snippet.annotation(window.annotation(AnnotationKind::Context, label));
        }
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let mut group = level.primary_title(self.message.as_str()).element(snippet);
        if let Some(help) = &self.help {
            group = group.element(Level::HELP.message(help.as_str()));
        }
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        renderer.render(&[group])
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        };
        write!(f, "{severity}: {}", self.message)
    }
}

/// The lines of a text that the labels of a diagnostic touch, so that rendering costs nothing for the rest of a large
/// file.
struct Window<'a> {
    text: &'a str,
    start: usize,
}

impl<'a> Window<'a> {
    fn around(text: &'a str, diagnostic: &Diagnostic) -> (Self, usize) {
        let spans = || diagnostic.secondary.iter().chain([&diagnostic.primary]).map(|label| label.span);
        let first = spans().map(|span| span.start).min().unwrap_or(0).min(text.len());
        let last = spans().map(|span| span.end).max().unwrap_or(0).min(text.len());
        let start = text[..first].rfind('\n').map_or(0, |newline| newline + 1);
        let end = text[last..].find('\n').map_or(text.len(), |newline| last + newline);
        (Self { text: &text[start..end], start }, line_column(text, first).0)
    }

    fn annotation<'l>(&self, kind: AnnotationKind, label: &'l Label) -> annotate_snippets::Annotation<'l> {
        let clip = |offset: usize| offset.saturating_sub(self.start).min(self.text.len());
        let annotation = kind.span(clip(label.span.start)..clip(label.span.end));
        if label.text.is_empty() { annotation } else { annotation.label(label.text.as_str()) }
    }
}
