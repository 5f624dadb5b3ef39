//! The text under way, and the comments that wait for their place in it.
//!
//! A comment behind something on its line goes to the end of the line that this something is printed on; a comment on a
//! line of its own goes on a line of its own before whatever comes next.

use crate::Span;
use crate::syntax::SyntaxTree;

/// Beyond this, lines are not indented further, so that deep nesting does not make long lines of blanks.
const DEEPEST: usize = 60;

/// Blank lines between lines.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Space {
    None,
    /// One where the author has some.
    Kept,
    /// One.
    One,
}

/// Where a comment begins that is lined up with those of its paragraph.
struct LineEnd {
    paragraph: usize,
    column: usize,
    offset: usize,
}

pub(super) struct Output<'t> {
    tree: &'t SyntaxTree,
    text: String,
    column: usize,
    /// Where lines go on that break inside something.
    indent: usize,
    /// The comments that are not printed yet.
    comments: &'t [Span],
    /// The line ends with a comment.
    commented: bool,
    /// The line has nothing but its indentation.
    begins_line: bool,
    /// The place in the source of what was printed last.
    cursor: usize,
    /// The comments at the ends of lines in blocks.
    ends: Vec<LineEnd>,
    paragraph: usize,
    aligning: bool,
}

impl<'t> Output<'t> {
    pub(super) fn new(tree: &'t SyntaxTree) -> Self {
        Self {
            tree,
            text: String::new(),
            column: 0,
            indent: 0,
            comments: tree.comments(),
            commented: false,
            begins_line: true,
            cursor: 0,
            ends: Vec::new(),
            paragraph: 0,
            aligning: false,
        }
    }

    pub(super) fn column(&self) -> usize {
        self.column
    }

    pub(super) fn indent(&self) -> usize {
        self.indent
    }

    pub(super) fn set_indent(&mut self, indent: usize) {
        self.indent = indent.min(DEEPEST);
    }

    /// Whether comments at the ends of lines are lined up, up to the next blank line.
    pub(super) fn align_comments(&mut self, aligning: bool) {
        self.aligning = aligning;
        self.paragraph += 1;
    }

    /// Text that has no comments of its own.
    pub(super) fn word(&mut self, text: &str) {
        if self.commented {
            self.break_line(self.indent, false);
        }
        self.push(if self.begins_line { text.trim_start() } else { text });
    }

    /// Text at a place of the source, after the comments before that place.
    pub(super) fn token(&mut self, text: &str, at: usize) {
        self.comments_before(at, self.indent);
        self.word(text);
        self.cursor = at;
    }

    /// Ends the line, after the comments before a place of the source, which comes next.
    pub(super) fn line(&mut self, at: usize, indent: usize, mut space: Space) {
        let keeps = space != Space::None;
        while let Some(comment) = self.next_before(at) {
            if self.is_trailing(comment) && self.column > 0 && !self.commented {
                self.push_comment(comment, true);
                continue;
            }
            let blank = space == Space::One || keeps && self.is_blank_before(comment.start);
            self.break_line(indent, blank);
            self.push_comment(comment, false);
            space = if keeps { Space::Kept } else { Space::None };
        }
        let blank = space == Space::One || keeps && self.is_blank_before(at);
        self.break_line(indent, blank);
        self.indent = indent.min(DEEPEST);
    }

    /// The comments before a place of the source.
    pub(super) fn comments_before(&mut self, at: usize, indent: usize) {
        while let Some(comment) = self.next_before(at) {
            let trails = self.is_trailing(comment) && self.column > 0 && !self.commented;
            if !trails {
                let blank = self.is_blank_before(comment.start) && self.aligning;
                self.break_line(indent, blank);
            }
            self.push_comment(comment, trails);
        }
    }

    pub(super) fn finish(mut self) -> String {
        self.indent = 0;
        let end = self.tree.source().len();
        while let Some(comment) = self.next_before(end) {
            let trails = self.is_trailing(comment) && self.column > 0 && !self.commented;
            if !trails {
                self.break_line(0, self.is_blank_before(comment.start));
            }
            self.push_comment(comment, trails);
        }
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        self.aligned()
    }

    /// The text with the comments of a paragraph below each other.
    fn aligned(self) -> String {
        let mut out = String::with_capacity(self.text.len());
        let mut copied = 0;
        for paragraph in self.ends.chunk_by(|a, b| a.paragraph == b.paragraph) {
            let column = paragraph.iter().map(|end| end.column).max().unwrap_or(0);
            for end in paragraph {
                out.push_str(&self.text[copied..end.offset]);
                out.extend(std::iter::repeat_n(' ', column - end.column));
                copied = end.offset;
            }
        }
        out.push_str(&self.text[copied..]);
        out
    }

    fn next_before(&mut self, at: usize) -> Option<Span> {
        let (first, rest) = self.comments.split_first()?;
        (first.start < at).then(|| {
            self.comments = rest;
            *first
        })
    }

    /// Whether something stands before a comment on its line.
    fn is_trailing(&self, comment: Span) -> bool {
        let before = &self.tree.source()[..comment.start];
        let line = before.rfind('\n').map_or(before, |newline| &before[newline + 1..]);
        !line.trim_start_matches('\u{feff}').trim().is_empty()
    }

    fn is_blank_before(&self, at: usize) -> bool {
        let between = self.tree.source().get(self.cursor..at).unwrap_or_default();
        between
            .rsplit_once('\n')
            .is_some_and(|(before, _)| before.trim_end_matches([' ', '\t', '\r']).ends_with('\n'))
    }

    fn push_comment(&mut self, comment: Span, trails: bool) {
        if trails {
            self.push("  ");
            if self.aligning {
                let (paragraph, column) = (self.paragraph, self.column);
                self.ends.push(LineEnd { paragraph, column, offset: self.text.len() });
            }
        }
        self.push(self.tree.text(comment).trim_end());
        self.commented = true;
        self.cursor = comment.end;
    }

    fn break_line(&mut self, indent: usize, blank: bool) {
        let indent = indent.min(DEEPEST);
        self.text.truncate(self.text.trim_end_matches(' ').len());
        if !self.text.is_empty() {
            self.text.push('\n');
            if blank {
                self.text.push('\n');
                self.paragraph += 1;
            }
        }
        self.text.extend(std::iter::repeat_n(' ', indent));
        self.column = indent;
        (self.commented, self.begins_line) = (false, true);
    }

    fn push(&mut self, text: &str) {
        self.begins_line &= text.is_empty();
        self.text.push_str(text);
        self.column += text.chars().count();
    }
}
