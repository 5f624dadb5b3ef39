//! The syntax tree: what was written, with the places where it was written.
//!
//! Terms and expressions live in two arenas in *postfix order*: the parts of a node are directly before it. Whoever needs
//! them bottom-up runs over a slice; nothing has to recurse, and dropping a tree is flat however deep it is nested.
//! Parentheses are nodes, names and numbers are spans of the source, which the tree owns: nothing of what the author
//! wrote is lost but the spacing.

use csg_graph::{Binary, Operator, TransformKind, Unary};

use crate::Span;

/// A term of a [`SyntaxTree`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TermId(pub(crate) u32);

/// An expression of a [`SyntaxTree`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ExprId(pub(crate) u32);

impl TermId {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

impl ExprId {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// A CSG term: a solid, as written.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Term {
    /// A primitive, a symbol or a macro, with the arguments in its parentheses.
    Solid {
        /// The name.
        name: Span,
        /// The arguments.
        args: Vec<ExprId>,
    },
    /// A transformation, a calculation or an attribute before a factor.
    Prefixed {
        /// What is before it.
        prefix: Prefix,
        /// The factor.
        body: TermId,
    },
    /// A Boolean operator between two terms.
    Operator {
        /// Which.
        operator: Operator,
        /// Its left operand.
        left: TermId,
        /// Its right operand.
        right: TermId,
    },
    /// A term in parentheses.
    Parenthesised(TermId),
    /// A term is missing here; that has been reported.
    Missing,
}

/// What can stand before a factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Prefix {
    /// Which.
    pub kind: PrefixKind,
    /// From its name or `{` to its last parenthesis or `}`.
    pub span: Span,
}

/// The kinds of prefixes.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PrefixKind {
    /// `move(0, 0, 1)`
    Transform(TransformKind, Vec<ExprId>),
    /// `{n = n - 1}`
    Calculation(Vec<Assignment>),
    /// `color(1, 0, 0)`
    Color(Vec<ExprId>),
    /// `material(diffuse = 0.5)`
    Material(Vec<Assignment>),
}

/// An arithmetic expression, as written.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Expr {
    /// A number; its digits are its span.
    Number(f64),
    /// A parameter or a constant; the name is its span.
    Name,
    /// An operator before an operand.
    Unary(Unary, ExprId),
    /// An operator between operands.
    Binary(Binary, ExprId, ExprId),
    /// A function.
    Call {
        /// Its name.
        name: Span,
        /// Its arguments.
        args: Vec<ExprId>,
    },
    /// An expression in parentheses.
    Parenthesised(ExprId),
    /// `(x, y, z)`: a point, a colour or a row, where one is expected.
    Tuple(Vec<ExprId>),
    /// An expression is missing here; that has been reported.
    Missing,
}

/// `name = value`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Assignment {
    /// The name.
    pub name: Span,
    /// The value.
    pub value: ExprId,
}

/// `{ name = value; … }`
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Block {
    /// From `{` to `}`.
    pub span: Span,
    /// The assignments.
    pub assignments: Vec<Assignment>,
}

/// What follows the parameters and the axiom.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Item {
    /// `NAME selection`
    Header(Header),
    /// `1: NAME -> term`
    Rule(Rule),
    /// `name = term`
    Macro(Macro),
    /// `camera { … }`
    Scene(SceneBlock),
}

/// A symbol and its selection function.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// The symbol.
    pub name: Span,
    /// The selection function.
    pub selection: Option<ExprId>,
}

/// A rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Rule {
    /// Its number.
    pub number: Option<Span>,
    /// The symbol that it rewrites.
    pub symbol: Span,
    /// What into.
    pub body: TermId,
}

/// A named term.
#[derive(Clone, Debug, PartialEq)]
pub struct Macro {
    /// The name.
    pub name: Span,
    /// What it stands for.
    pub body: TermId,
}

/// A block that says how to look at the solid.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneBlock {
    /// `camera`, `light`, `sky`, `background` or `image`, or what was written in place of it.
    pub name: Span,
    /// Its fields.
    pub fields: Block,
}

/// How tightly an operator between solids binds.
pub(crate) fn strength(operator: Operator) -> u8 {
    match operator {
        Operator::Union | Operator::Difference => 1,
        Operator::Intersection => 2,
    }
}

/// A node of an arena.
#[derive(Clone, Debug)]
pub(crate) struct Node<T> {
    pub(crate) value: T,
    pub(crate) span: Span,
    /// Where the nodes of its subtree begin; the node itself is the last of them.
    pub(crate) first: u32,
}

/// A file, parsed.
#[derive(Clone, Debug, Default)]
pub struct SyntaxTree {
    pub(crate) source: Box<str>,
    pub(crate) terms: Vec<Node<Term>>,
    pub(crate) exprs: Vec<Node<Expr>>,
    pub(crate) parameters: Block,
    pub(crate) axiom: Option<TermId>,
    pub(crate) items: Vec<Item>,
    pub(crate) comments: Vec<Span>,
    pub(crate) unicode: bool,
    pub(crate) damaged: bool,
}

impl SyntaxTree {
    /// The text that was parsed.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// The text of a span.
    pub fn text(&self, span: Span) -> &str {
        &self.source[span.range()]
    }

    /// The initial parameters.
    pub fn parameters(&self) -> &Block {
        &self.parameters
    }

    /// The axiom, unless it is missing.
    pub fn axiom(&self) -> Option<TermId> {
        self.axiom
    }

    /// Headers, rules, macros and scene blocks, as they come.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// The comments, from `//` to the end of the line.
    pub fn comments(&self) -> &[Span] {
        &self.comments
    }

    /// Whether the operators were written as the paper prints them: `∪ ∩ →`.
    pub fn is_unicode(&self) -> bool {
        self.unicode
    }

    /// Whether the text has syntax errors, so that something is missing here.
    pub fn is_damaged(&self) -> bool {
        self.damaged
    }

    /// A term.
    pub fn term(&self, id: TermId) -> &Term {
        &self.terms[id.index()].value
    }

    /// Where a term is.
    pub fn term_span(&self, id: TermId) -> Span {
        self.terms[id.index()].span
    }

    /// An expression.
    pub fn expr(&self, id: ExprId) -> &Expr {
        &self.exprs[id.index()].value
    }

    /// Where an expression is.
    pub fn expr_span(&self, id: ExprId) -> Span {
        self.exprs[id.index()].span
    }

    /// A term and all its parts, each after its own parts.
    pub fn subterms(&self, id: TermId) -> impl DoubleEndedIterator<Item = TermId> + Clone + use<> {
        (self.terms[id.index()].first..=id.0).map(TermId)
    }

    /// An expression and all its parts, each after its own parts.
    pub fn subexprs(&self, id: ExprId) -> impl DoubleEndedIterator<Item = ExprId> + Clone + use<> {
        (self.exprs[id.index()].first..=id.0).map(ExprId)
    }

    pub(crate) fn push_term(&mut self, value: Term, span: Span) -> TermId {
        let id = TermId(u32::try_from(self.terms.len()).expect("fewer terms than bytes in 4 GiB of source"));
        let first = match &value {
            Term::Prefixed { body, .. } | Term::Parenthesised(body) => self.terms[body.index()].first,
            Term::Operator { left, .. } => self.terms[left.index()].first,
            Term::Solid { .. } | Term::Missing => id.0,
        };
        self.terms.push(Node { value, span, first });
        id
    }

    pub(crate) fn push_expr(&mut self, value: Expr, span: Span) -> ExprId {
        let id =
            ExprId(u32::try_from(self.exprs.len()).expect("fewer expressions than bytes in 4 GiB of source"));
        let child = match &value {
            Expr::Unary(_, first) | Expr::Binary(_, first, _) | Expr::Parenthesised(first) => Some(*first),
            Expr::Call { args, .. } | Expr::Tuple(args) => args.first().copied(),
            Expr::Number(_) | Expr::Name | Expr::Missing => None,
        };
        let first = child.map_or(id.0, |child| self.exprs[child.index()].first);
        self.exprs.push(Node { value, span, first });
        id
    }
}
