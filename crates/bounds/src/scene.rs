//! What the algorithms ask of a scene: a root, what is directly below a state, and the extents of shapes.
//!
//! A scene is a Boolean expression over transformed shapes that is never written out: a tree, a dag, or a recursion
//! whose parameters say when it ends. A *state* is one node of it together with everything that decides what is below,
//! so that two places with equal states are the same solid, each in its own frame.

use std::fmt;
use std::hash::Hash;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::{Aabb, Cell, PointSet, Side};

/// A scene graph, as seen by the algorithms of this crate.
///
/// The scene has *nodes*, finitely many and numbered, each of which gets one hyper box. At each place of the unfolded
/// tree a node is met in some *state*, and [`step`](Self::step) says what is below it there. The crate's documentation
/// shows a scene from beginning to end.
pub trait Scene {
    /// A node with all values that what is below it depends on. Cheap to clone: it is cloned for each visit.
    ///
    /// Equal states are the same solid; equality and hash serve algorithms that visit each state once.
    type State: Clone + Eq + Hash;
    /// A transformation.
    type Map: Map;
    /// A primitive solid.
    type Shape: Shape;
    /// Why a state cannot be expanded; [`Infallible`](std::convert::Infallible) if all can.
    type Error;

    /// The state where unfolding starts.
    fn root(&self) -> Self::State;

    /// What a state is, with the states directly below it.
    ///
    /// # Errors
    /// If it cannot be expanded. The algorithms stop there and pass the error on.
    fn step(&self, state: &Self::State) -> Result<Step<Self>, Self::Error>;

    /// The node of a state: a number below [`node_count`](Self::node_count). It says which hyper box the state's box
    /// is joined to.
    fn node(&self, state: &Self::State) -> usize;

    /// How many nodes there are.
    fn node_count(&self) -> usize;

    /// What a state is called in messages.
    fn label(&self, state: &Self::State) -> String {
        format!("node {}", self.node(state))
    }
}

/// What a state is, with the states directly below it.
pub enum Step<S: Scene + ?Sized> {
    /// A primitive solid, in the frame of the state.
    Shape(S::Shape),
    /// The same solid in the same frame: a node that selects, calculates or paints.
    Same(S::State),
    /// A T-node: the map from the frame below into the frame of this state, and what is below.
    Map(S::Map, S::State),
    /// The union of any number of solids; of none, it is empty.
    Union(Vec<S::State>),
    /// What is in both solids.
    Intersection([S::State; 2]),
    /// What is in the first solid and not in the second.
    Difference([S::State; 2]),
}

impl<S: Scene + ?Sized> fmt::Debug for Step<S>
where
    S::State: fmt::Debug,
    S::Map: fmt::Debug,
    S::Shape: fmt::Debug,
{
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape(shape) => f.debug_tuple("Shape").field(shape).finish(),
            Self::Same(below) => f.debug_tuple("Same").field(below).finish(),
            Self::Map(map, below) => f.debug_tuple("Map").field(map).field(below).finish(),
            Self::Union(operands) => f.debug_tuple("Union").field(operands).finish(),
            Self::Intersection(operands) => f.debug_tuple("Intersection").field(operands).finish(),
            Self::Difference(operands) => f.debug_tuple("Difference").field(operands).finish(),
        }
    }
}

/// An affine transformation, as a function of points and as a matrix.
///
/// The paper's section 3: a chain T₃·T₂·T₁ is applied to points as T₃(T₂(T₁(p))), so that a translation costs three
/// additions and not a matrix product. What goes down a chain instead of up, directions, goes by the matrix.
pub trait Map {
    /// The map x ↦ M x + t that this is, from the frame below into the frame above.
    ///
    /// Its numbers define the map: boxes enclose what exact arithmetic would make of them.
    fn affine(&self) -> DAffine3;

    /// The image of a point of the frame below, in the frame above.
    ///
    /// Must be, in every coordinate, within 4 ε (‖M‖ |x| + |t|) of the exact image, where ε is [`f64::EPSILON`], |·| is
    /// the largest coordinate and ‖M‖ the largest sum of absolute values in a row of M. Every straightforward
    /// evaluation is: a matrix product with a sum, or any part of one.
    fn point(&self, point: DVec3) -> DVec3 {
        self.affine().transform_point3(point)
    }

    /// Maps many points in place, with the same promise.
    ///
    /// The chain algorithm spends most of its time here. A transformation of several kinds should decide once for all
    /// points which kind it is.
    fn points(&self, points: &mut [DVec3]) {
        for point in points {
            *point = self.point(*point);
        }
    }
}

/// A primitive solid in its own frame.
///
/// A pointer to a shape is one, too, so that a scene need not copy a mesh for each state that is made of it, and may mix shapes
/// of different kinds:
///
/// ```
/// use std::sync::Arc;
///
/// use csg_graph_bounds::{Aabb, PointSet, Shape};
/// use glam::DVec3;
///
/// let tetrahedron = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let shapes: [Arc<dyn Shape>; 2] =
///     [Arc::new(PointSet::from(tetrahedron.to_vec())), Arc::new(Aabb::new(DVec3::ZERO, DVec3::ONE))];
/// assert_eq!(shapes.map(|shape| shape.support(DVec3::ONE)), [1.0, 3.0]);
/// ```
pub trait Shape {
    /// A box that encloses the shape: the least one, if boxes are to be as small as they can be.
    fn bounds(&self) -> Aabb;

    /// Points whose convex hull encloses the shape.
    ///
    /// They must *circumscribe*: points on a curved surface give boxes that are too small. The less they stick out, the
    /// tighter are the boxes; the more there are, the longer they take.
    fn point_set(&self) -> PointSet<'_>;

    /// The support of the shape: the largest d·x over its points x, for any finite d, of whatever length.
    ///
    /// Must be within 4 ε |d| r of the exact one, where r is the largest distance of a point of [`bounds`](Self::bounds)
    /// from the origin, but may be larger: the support of anything that encloses the shape will do, if boxes need not
    /// be as small as they can be. Infinite where the shape has no end; −∞ if it is empty.
    fn support(&self, direction: DVec3) -> f64;

    /// A box that encloses everything outside of the shape: all of space, unless the shape has no end on any side but
    /// one. [`ExactBoxes::s_bounds`](crate::ExactBoxes::s_bounds) cuts what a half-space is subtracted from with it.
    fn complement_bounds(&self) -> Aabb {
        Aabb::ALL
    }

    /// Where a cell lies, for [`ExactBoxes::solid`](crate::ExactBoxes::solid).
    ///
    /// Whoever is not certain says [`Side::Mixed`], always for small cells about points of the surface; the more often
    /// somebody is certain, the fewer cells a search takes. The cell's [slack](Cell::slack) is large enough to cover the
    /// rounding of a straightforward answer: some operations on the coordinates of the cell and of
    /// [`bounds`](Self::bounds).
    ///
    /// This default sees only what is outside, by means of the support. Without the inside, searches prove no lower
    /// bounds, and subtracting the shape gains nothing.
    fn classify(&self, cell: &Cell) -> Side {
        if cell.misses(self) { Side::Outside } else { Side::Mixed }
    }
}

impl Map for DAffine3 {
    fn affine(&self) -> DAffine3 {
        *self
    }
}

/// A solid cuboid.
impl Shape for Aabb {
    fn bounds(&self) -> Aabb {
        *self
    }

    fn point_set(&self) -> PointSet<'_> {
        if self.is_empty() {
            PointSet::EMPTY
        } else if self.is_bounded() {
            PointSet::from(self.corners().to_vec())
        } else {
            PointSet::Unbounded
        }
    }

    fn support(&self, direction: DVec3) -> f64 {
        Self::support(self, direction)
    }

    fn complement_bounds(&self) -> Self {
        if self.is_empty() {
            return Self::ALL;
        }
        // Beyond one face only; of two, the least box about both sides has no end either.
        let below = [0, 1, 2].map(|axis| (axis, self.min[axis], false));
        let above = [0, 1, 2].map(|axis| (axis, self.max[axis], true));
        let mut faces = below.into_iter().chain(above).filter(|(_, face, _)| face.is_finite());
        match (faces.next(), faces.next()) {
            (None, _) => Self::EMPTY,
            (Some((axis, face, above)), None) => {
                let mut beyond = Self::ALL;
                let end = if above { &mut beyond.min } else { &mut beyond.max };
                end[axis] = face;
                beyond
            }
            _ => Self::ALL,
        }
    }

    fn classify(&self, cell: &Cell) -> Side {
        let bounds = cell.bounds();
        if self.intersect(bounds).is_empty() || cell.misses(self) {
            Side::Outside
        } else if self.encloses(bounds) {
            Side::Inside
        } else {
            Side::Mixed
        }
    }
}

macro_rules! shapes_behind {
    ($($pointer:ty),*) => {$(
        /// The shape that it points to.
        impl<S: Shape + ?Sized> Shape for $pointer {
            fn bounds(&self) -> Aabb {
                (**self).bounds()
            }

            fn point_set(&self) -> PointSet<'_> {
                (**self).point_set()
            }

            fn support(&self, direction: DVec3) -> f64 {
                (**self).support(direction)
            }

            fn complement_bounds(&self) -> Aabb {
                (**self).complement_bounds()
            }

            fn classify(&self, cell: &Cell) -> Side {
                (**self).classify(cell)
            }
        }
    )*};
}

shapes_behind!(&S, Box<S>, Rc<S>, Arc<S>);

/// The convex hull of finite points, such as the vertices of a mesh.
impl Shape for PointSet<'_> {
    fn bounds(&self) -> Aabb {
        match self {
            Self::Points(points) => Aabb::from_points(points.iter().copied()),
            Self::Unbounded => Aabb::ALL,
        }
    }

    fn point_set(&self) -> PointSet<'_> {
        match self {
            Self::Points(points) => PointSet::from(&**points),
            Self::Unbounded => Self::Unbounded,
        }
    }

    fn support(&self, direction: DVec3) -> f64 {
        match self {
            Self::Points(points) => {
                points.iter().map(|point| point.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
            }
            Self::Unbounded => f64::INFINITY,
        }
    }
}
