//! The nodes of a cyclic CSG graph: the paper's S-, C- and T-nodes, operators, primitives, and attributes.

use std::ops::RangeInclusive;

use crate::{Expr, NodeId, ParamId, Primitive, PrimitiveKind, Transform, TransformKind};

/// A node of a graph.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Node {
    /// S-node.
    Symbol(Symbol),
    /// C-node.
    Calculation(Calculation),
    /// T-node.
    Transformation(Transformation),
    /// Colour or material of what is below.
    Attribute(AttributeNode),
    /// A Boolean operator.
    Operator(OperatorNode),
    /// A primitive solid.
    Primitive(PrimitiveNode),
}

/// S-node: joins the rules of one grammar symbol; its selection function picks one by its number.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// The symbol.
    pub name: String,
    /// The selection function: a 1-based rule number. `None` selects rule 1.
    pub selection: Option<Expr>,
    /// The right-hand sides, in the order of their numbers.
    pub rules: Vec<NodeId>,
}

/// C-node: changes parameters for what is below it.
#[derive(Clone, Debug)]
pub struct Calculation {
    /// The assignments, which run in order.
    pub assignments: Vec<(ParamId, Expr)>,
    /// What sees the new values.
    pub body: NodeId,
}

/// T-node: maps what is below it into the frame above it.
#[derive(Clone, Debug)]
pub struct Transformation {
    /// Which transformation.
    pub kind: TransformKind,
    /// Its arguments.
    pub args: Vec<Expr>,
    /// What it maps.
    pub body: NodeId,
    /// The transformation, where its arguments read no parameter that changes.
    pub(crate) constant: Option<Transform>,
}

/// Attribute node: paints what is below it, where nothing further below paints over it.
#[derive(Clone, Debug)]
pub struct AttributeNode {
    /// The terms that it sets.
    pub terms: Vec<(AttributeTerm, Expr)>,
    /// What it paints.
    pub body: NodeId,
}

/// One number of a surface's look. What it looks like is for a renderer to say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum AttributeTerm {
    /// Pigment, linear light, 0 to 1.
    Red,
    /// Pigment, linear light, 0 to 1.
    Green,
    /// Pigment, linear light, 0 to 1.
    Blue,
    /// The part of the pigment that needs no light.
    Ambient,
    /// The part of the pigment that a light facing the surface adds.
    Diffuse,
    /// The strength of the highlight.
    Specular,
    /// How narrow the highlight is: the exponent of its lobe.
    Shininess,
    /// The strength of the light that the surface gives of itself, in its pigment.
    Emission,
    /// The part of the surface that is metal, 0 to 1.
    Metal,
    /// How rough the metal is, 0 to 1.
    Roughness,
    /// The part of the surface that is glass, 0 to 1, of what is not metal.
    Glass,
    /// The index of refraction of the glass, at least 1.
    Ior,
    /// How fast the glass swallows light, in its pigment.
    Absorption,
}

impl AttributeTerm {
    /// The terms of `color(r, g, b)`, in that order.
    pub const COLOR: [Self; 3] = [Self::Red, Self::Green, Self::Blue];

    /// The terms of `material(name = value, …)`.
    pub const MATERIAL: [Self; 10] = [
        Self::Ambient,
        Self::Diffuse,
        Self::Specular,
        Self::Shininess,
        Self::Emission,
        Self::Metal,
        Self::Roughness,
        Self::Glass,
        Self::Ior,
        Self::Absorption,
    ];

    /// The name in the language.
    pub fn name(self) -> &'static str {
        match self {
            Self::Red => "red",
            Self::Green => "green",
            Self::Blue => "blue",
            Self::Ambient => "ambient",
            Self::Diffuse => "diffuse",
            Self::Specular => "specular",
            Self::Shininess => "shininess",
            Self::Emission => "emission",
            Self::Metal => "metal",
            Self::Roughness => "roughness",
            Self::Glass => "glass",
            Self::Ior => "ior",
            Self::Absorption => "absorption",
        }
    }

    /// The values that it may have: not negative, and for some terms less than that.
    pub fn range(self) -> RangeInclusive<f64> {
        match self {
            Self::Red | Self::Green | Self::Blue | Self::Metal | Self::Roughness | Self::Glass => 0.0..=1.0,
            Self::Ior => 1.0..=f64::INFINITY,
            _ => 0.0..=f64::INFINITY,
        }
    }
}

/// A Boolean operator on two solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operator {
    /// ∪
    Union,
    /// ∩
    Intersection,
    /// \
    Difference,
}

impl Operator {
    /// The sign that the paper uses.
    pub fn sign(self) -> &'static str {
        match self {
            Self::Union => "∪",
            Self::Intersection => "∩",
            Self::Difference => "\\",
        }
    }

    /// The same in ASCII.
    pub fn ascii_sign(self) -> &'static str {
        match self {
            Self::Union => "|",
            Self::Intersection => "&",
            Self::Difference => "\\",
        }
    }

    /// The English name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Union => "union",
            Self::Intersection => "intersection",
            Self::Difference => "difference",
        }
    }
}

/// Operator node.
#[derive(Clone, Debug)]
pub struct OperatorNode {
    /// Which operator.
    pub operator: Operator,
    /// The left and the right operand.
    pub operands: [NodeId; 2],
}

/// Primitive node.
#[derive(Clone, Debug)]
pub struct PrimitiveNode {
    /// Which primitive.
    pub kind: PrimitiveKind,
    /// Its measures.
    pub args: Vec<Expr>,
    /// The primitive, where its arguments read no parameter that changes.
    pub(crate) constant: Option<Primitive>,
}

impl Node {
    /// The nodes directly below, in order.
    pub fn children(&self) -> &[NodeId] {
        match self {
            Self::Symbol(symbol) => &symbol.rules,
            Self::Calculation(Calculation { body, .. })
            | Self::Transformation(Transformation { body, .. })
            | Self::Attribute(AttributeNode { body, .. }) => std::slice::from_ref(body),
            Self::Operator(node) => &node.operands,
            Self::Primitive(_) => &[],
        }
    }

    /// The expressions that it evaluates, in order.
    pub fn exprs(&self) -> Vec<&Expr> {
        match self {
            Self::Symbol(symbol) => symbol.selection.iter().collect(),
            Self::Calculation(node) => node.assignments.iter().map(|(_, expr)| expr).collect(),
            Self::Transformation(node) => node.args.iter().collect(),
            Self::Attribute(node) => node.terms.iter().map(|(_, expr)| expr).collect(),
            Self::Primitive(node) => node.args.iter().collect(),
            Self::Operator(_) => Vec::new(),
        }
    }

    /// The kind as the paper abbreviates it or as the language names it: `S`, `C`, `T`, `attribute`, `union`,
    /// `intersection`, `difference` or `primitive`.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Symbol(_) => "S",
            Self::Calculation(_) => "C",
            Self::Transformation(_) => "T",
            Self::Attribute(_) => "attribute",
            Self::Operator(node) => node.operator.name(),
            Self::Primitive(_) => "primitive",
        }
    }
}
