//! Ray tracing of cyclic CSG graphs: a graph in, a picture out, and nothing unfolded on the way.
//!
//! \[TRAX95\] traces rays directly through the graph that a grammar is. This crate has that walk, the shapes and Boolean
//! operators that it ends in, and what a picture needs around it: camera, lights, shading, film, and the paper's colour
//! plate as one of several [views](View). It knows no text and no files.
//!
//! # One ray
//!
//! ```
//! use csg_graph::{GraphBuilder, Operator, PrimitiveKind, TransformKind};
//! use csg_graph_trace::{Ray, Walk};
//! use glam::DVec3;
//!
//! // cube \ move(0, 0, 1) sphere
//! let mut builder = GraphBuilder::new();
//! let cube = builder.primitive(PrimitiveKind::Cube, []);
//! let sphere = builder.primitive(PrimitiveKind::Sphere, []);
//! let raised = builder.transform(TransformKind::Move, [0.0.into(), 0.0.into(), 1.0.into()], sphere);
//! let bowl = builder.operator(Operator::Difference, cube, raised);
//! let graph = builder.finish(bowl)?;
//!
//! let mut walk = Walk::new(&graph, None);
//! let ray = Ray { origin: DVec3::new(0.0, 0.0, 5.0), direction: DVec3::new(0.0, 0.0, -1.0) };
//! let hit = walk.nearest(&ray)?.expect("the ray falls into the bowl");
//! assert_eq!(hit.point, DVec3::ZERO);
//! assert_eq!(hit.normal, DVec3::Z);
//! assert_eq!(hit.node, sphere);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! With the hyper boxes of `csg-graph-bounds` the same ray visits fewer nodes and has the same hit, to the last bit.
//! [`render`] does this for all pixels.
//!
//! # Engines
//!
//! The [`Walk`] asks one node after the other, as the paper does. It is small and obviously right, and what a faster
//! engine is compared with: [`Accelerated`] is the graph compiled for rays. Every state is evaluated once, states are
//! opened into lists of some hundred parts with a tree of exact boxes each, and [`PACKET`] rays go through them together,
//! by vector instructions where the machine has them. It takes some hundred kilobytes for any depth of recursion, and
//! its hits are those of the walk, up to the rounding of products of transformations. What is below ∩ and \\ is compiled
//! as well, and followed from boundary to boundary, no further than to the first that is seen. [`Grid`] is the paper's own
//! acceleration of its walk, to be compared with.
//!
//! ```
//! use csg_graph::{GraphBuilder, PrimitiveKind};
//! use csg_graph_bounds::{Limits, exact};
//! use csg_graph_trace::{Accelerated, Ray};
//! use glam::DVec3;
//!
//! let mut builder = GraphBuilder::new();
//! let ball = builder.primitive(PrimitiveKind::Sphere, []);
//! let graph = builder.finish(ball)?;
//!
//! let boxes = exact(&graph, &Limits::default())?;
//! let scene = Accelerated::new(&graph, &boxes, Accelerated::DEFAULT_BUDGET)?;
//! let mut tracer = scene.tracer();
//! let rays = [0.0, 0.5, 1.5].map(|x| Ray { origin: DVec3::new(x, 0.0, 5.0), direction: -DVec3::Z });
//! let mut hits = [None; 3];
//! tracer.nearest_of(&rays, &mut hits);
//! assert_eq!(hits.map(|hit| hit.map(|hit| (hit.t * 100.0).round())), [Some(400.0), Some(413.0), None]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Where there are more states than memory, or recursion never ends, [`Accelerated::on_demand`] compiles what rays come to,
//! when they come to it; and [`Accelerated::with_detail`] does not look into what is too small to be seen.
//!
//! # Light
//!
//! The [`Integrator`] of the [`Settings`] makes light of hits: direct light with mirror images and refraction \[WHIT80\],
//! or global illumination by paths drawn by chance \[KAJI86\], with the [`Sky`] and its sun, and surfaces that are matt,
//! metal, glass, or shine themselves.
//!
//! # Where things are
//!
//! The graph stays as it is; a [`Walk`] is what a thread needs to ask it. Colours are linear light. The world is
//! right-handed, z up where nobody says otherwise. Nothing recurses on the machine stack, and the same input gives the same
//! bytes on every machine and any number of threads.
//!
//! \[TRAX95\]: C. Traxler, M. Gervautz, *Calculation of Tight Bounding Volumes for Cyclic CSG-Graphs*, 1995.
//! \[KAY86\]: T. L. Kay, J. T. Kajiya, *Ray tracing complex scenes*, 1986.
//! \[FUJI86\]: A. Fujimoto, T. Tanaka, K. Iwata, *ARTS: Accelerated Ray-Tracing System*, 1986.
//! \[WHIT80\]: T. Whitted, *An Improved Illumination Model for Shaded Display*, 1980.
//! \[KAJI86\]: J. T. Kajiya, *The Rendering Equation*, 1986.
//! \[HAIN19\]: E. Haines, J. Günther, T. Akenine-Möller, *Precision Improvements for Ray/Sphere Intersection*, 2019.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod boolean;
pub mod brute;
mod camera;
mod checkpoint;
mod counters;
mod engine;
mod fast;
mod film;
mod grid;
mod integrate;
mod latent;
mod light;
mod narrow;
mod noise;
mod primary;
mod ray;
mod render;
mod sampling;
pub mod shapes;
mod sky;
mod slab;
mod srgb;
mod surface;
mod tiles;
mod view;
mod walk;
mod zoom;

pub use camera::{Camera, CameraError, Lens};
pub use checkpoint::LoadError;
pub use counters::Counters;
pub use engine::Engine;
pub use fast::{Accelerated, Batch, Beam, Footprint, PACKET, StateBounds, Tracer};
pub use film::Film;
pub use grid::{Grid, GridTracer};
pub use integrate::Integrator;
pub use latent::LatentImage;
pub use light::{Light, LightSource};
pub use noise::FEWEST as FEWEST_SAMPLES;
pub use primary::{PrimaryPass, Probe, primary, probe};
pub use ray::Ray;
pub use render::{MAX_BOUNCES, MAX_EXPOSURE, MAX_PIXELS, MAX_SAMPLES, RenderError, Settings, World, render};
pub use sky::{Sky, Sun};
pub use surface::{Hit, Surface};
pub use view::View;
pub use walk::Walk;
pub use zoom::zoom;
