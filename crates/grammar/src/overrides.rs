//! Values for initial parameters from outside the file.

use crate::parser::parse_assignment;
use crate::syntax::{Assignment, SyntaxTree};
use crate::{Diagnostic, Excerpt};

/// An initial value from outside the file: `cnt = 12`, `dSG = 1/segments`.
///
/// The expression may read the parameters that are declared before its own.
///
/// ```
/// use csg_graph_grammar::{Override, load};
///
/// let source = "{ n = 3; half = n/2; } uscale(half) sphere";
/// let scene = load(source, &[Override::parse("n = 8").unwrap()]).unwrap().scene;
/// let half = scene.graph.params().nth(1).unwrap();
/// assert_eq!(scene.graph.initial().get(half), Some(4.0));
/// ```
#[derive(Clone, Debug)]
pub struct Override {
    /// What diagnostics call the text.
    origin: String,
    pub(crate) tree: SyntaxTree,
    pub(crate) assignment: Assignment,
}

impl Override {
    /// Reads `NAME = EXPRESSION`.
    ///
    /// # Errors
    /// If it is not that. The diagnostics point into `text`, which they carry.
    pub fn parse(text: &str) -> Result<Self, Vec<Diagnostic>> {
        Self::parse_from("override", text)
    }

    /// The same of a text from somewhere, which diagnostics name as they would a file.
    ///
    /// # Errors
    /// As for [`parse`](Self::parse).
    pub fn parse_from(origin: &str, text: &str) -> Result<Self, Vec<Diagnostic>> {
        let (parsed, assignment) = parse_assignment(text);
        match assignment {
            Some(assignment) if !parsed.has_errors() => {
                Ok(Self { origin: origin.to_owned(), tree: parsed.tree, assignment })
            }
            _ => Err(parsed.diagnostics.into_iter().map(|report| in_excerpt(report, origin, text)).collect()),
        }
    }

    /// The parameter that it sets.
    pub fn name(&self) -> &str {
        self.tree.text(self.assignment.name)
    }

    /// A diagnostic about this text.
    pub(crate) fn locate(&self, diagnostic: Diagnostic) -> Diagnostic {
        in_excerpt(diagnostic, &self.origin, self.tree.source())
    }
}

fn in_excerpt(diagnostic: Diagnostic, origin: &str, text: &str) -> Diagnostic {
    let excerpt = Excerpt { name: origin.to_owned(), text: text.to_owned() };
    Diagnostic { excerpt: Some(excerpt), ..diagnostic }
}
