//! The `.pcsg` language: CSG-PL-systems as text.
//!
//! A *CSG-PL-system* is a parametric grammar whose words are CSG expressions. Traxler and Gervautz translate it directly
//! into a cyclic graph, without deriving a word \[TRAX95\]. This crate reads the notation of their Fig. 1.1a, with the
//! operators in Unicode (`∪ ∩ \ →`) or in ASCII (`| & \ ->`), and gives a [`csg_graph::Graph`]:
//!
//! ```
//! let source = "
//! { n = 8; } TREE                  // parameters, and the axiom
//!
//! TREE if(n > 0, 2, 1)             // a symbol and its selection function
//! 1: TREE -> twig                  // its rules
//! 2: TREE -> twig | {n = n - 1} move(0, 0, 1) (rotx(40) uscale(0.7) TREE | rotx(-30) uscale(0.8) TREE)
//!
//! twig = scale(0.1, 0.1, 1) cylinder
//! ";
//! let scene = csg_graph_grammar::load(source, &[]).unwrap().scene;
//! let analysis = scene.graph.analyse(&Default::default())?;
//! assert_eq!(analysis.states, 9);
//! assert_eq!(analysis.primitives.to_string(), "511");
//! # Ok::<(), csg_graph::StatesError>(())
//! ```
//!
//! The phases, which can be used one by one:
//!
//! | phase | from | to |
//! |---|---|---|
//! | [`decode`] | bytes | text |
//! | [`parse`] | text | [`SyntaxTree`], whatever is wrong with the text |
//! | [`print()`] | [`SyntaxTree`] | text in its canonical spacing, with all comments |
//! | [`lower`] | [`SyntaxTree`] and [`Override`]s | [`Scene`]: graph, [`SourceMap`], [`Look`] |
//! | [`load`] | text | the same, with the mistakes of all phases |
//! | [`Scene::explain`] | an error of the graph | a [`Diagnostic`] |
//!
//! # Mistakes
//! One run reports all independent mistakes. Each is a [`Diagnostic`]: a place, a sentence, and mostly a guess at what was
//! meant, which [`Diagnostic::render`] shows with the lines of the source:
//!
//! ```
//! let source = "{} TRE\nTREE -> twig | spheer\ntwig = uscale(0.1) cylinder";
//! let mistakes = csg_graph_grammar::load(source, &[]).unwrap_err();
//! let told = mistakes.iter().find(|mistake| mistake.message.contains("spheer")).unwrap();
//! assert_eq!(told.render("tree.pcsg", source, false), "\
//! error: unknown solid `spheer`
//!  --> tree.pcsg:2:16
//!   |
//! 2 | TREE -> twig | spheer
//!   |                ^^^^^^ unknown
//!   |
//!   = help: did you mean `sphere`? If not, define it: `spheer = …`");
//! ```
//!
//! # Cost
//! All phases take time in proportion to the text, and use no machine stack in proportion to it: parentheses may nest as
//! deep as memory allows. (An arithmetic expression is copied once a level of nesting on the right.)
//!
//! \[TRAX95\]: C. Traxler, M. Gervautz, *Calculation of Tight Bounding Volumes for Cyclic CSG-Graphs*, 1995.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod decode;
mod diagnostic;
mod explain;
mod faults;
mod look;
mod lower;
mod names;
mod number;
mod overrides;
mod parser;
mod printer;
mod source_map;
mod span;
pub mod syntax;
mod token;

pub use decode::decode;
pub use diagnostic::{Diagnostic, Excerpt, Label, Severity};
pub use look::{Camera, Image, Integrator, Light, LightSource, Look, Sky};
pub use lower::{Lowered, Scene, load, lower};
pub use overrides::Override;
pub use parser::{Parsed, parse};
pub use printer::print;
pub use source_map::SourceMap;
pub use span::{Span, line_column};
pub use syntax::SyntaxTree;
