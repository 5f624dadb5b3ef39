//! Solids: states without the nodes that only name, select or move what is below them.
//!
//! A state is an affine image of a *solid*: a shape, or a union or an intersection of affine images of solids. Chains of
//! T-nodes become one matrix, S- and C-nodes disappear, a difference is its left operand, which encloses it, and small
//! unions are written out in the union above them. Support queries walk solids only, in fewer and cheaper steps.
//!
//! ## Rounding
//!
//! Each solid carries a bound on how far the supports that queries find in it differ from those in exact arithmetic. It
//! is the rule of [`rounding`](crate::rounding), for supports instead of points: a part with bounds of magnitude r and
//! error e, under a chain of enlargement σ, has error σ e + c (σ √3 r + |t|). The direction that is handed down,
//! Mᵀd, is at most σ |d| long, which enlarges e; that it is rounded changes the support by at most √3 r times as much.

use std::ops::Range;

use glam::{DAffine3, DVec3};

use crate::narrow::index;
use crate::rounding::Rounding;
use crate::{Aabb, Shape};

/// All solids, parts before what they are parts of.
pub(super) struct Solids<S> {
    pub(super) shapes: Vec<S>,
    /// Whether any is a part of itself.
    pub(super) endless: bool,
    solids: Vec<Solid>,
    parts: Vec<Part>,
    chains: Vec<Chain>,
}

/// A solid in its own frame.
pub(super) struct Solid {
    pub(super) kind: Kind,
    /// A box that encloses it.
    pub(super) bounds: Aabb,
    /// The middle of the box, and half its size.
    pub(super) center: DVec3,
    pub(super) half: DVec3,
    /// Each face of the box is at most so far from a point of the solid, or from the bound that a query would give.
    pub(super) gap: f64,
    /// Whether there is such a *point*: so wherever nothing below is an intersection, whose box is only what boxes have
    /// in common.
    pub(super) touched: bool,
    /// How far a support that a query finds is from that in exact arithmetic, at most, for a direction of length 1.
    pub(super) error: f64,
}

#[derive(Clone)]
pub(super) enum Kind {
    /// An index into the shapes.
    Shape(u32),
    /// A range of the parts.
    Union(Range<u32>),
    /// A range of the parts: those operands that are of use as bounds.
    Intersection(Range<u32>),
}

/// A solid as a part of another one.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub(super) chain: Chain,
    pub(super) solid: u32,
}

/// The product of the maps of a chain.
#[derive(Clone, Copy)]
pub(super) struct Chain {
    pub(super) parent_from_child: DAffine3,
    pub(super) rounding: Rounding,
}

/// A state as an image of a solid.
#[derive(Clone, Copy)]
pub(super) struct Image {
    /// An index into the chains.
    chain: u32,
    solid: u32,
}

impl Image {
    /// Of what is not known yet.
    pub(super) const NONE: Self = Self { chain: NO_CHAIN, solid: u32::MAX };

    pub(super) fn is_none(self) -> bool {
        self.solid == u32::MAX
    }

    pub(super) fn solid(self) -> u32 {
        self.solid
    }
}

/// The chain of no maps.
const NO_CHAIN: u32 = 0;

/// A union is written out in the one above it while that has no more parts than this.
const PARTS: usize = 4;

/// An operand of an intersection is of use if its rounding errors are at most this times those of the intersection:
/// cubes the size of the world are bounds too, but not to cut atoms with.
const OPERAND_ERROR: f64 = 1e3;

impl<S: Shape> Solids<S> {
    /// No solids yet, but the shapes that they may be.
    pub(super) fn new(shapes: Vec<S>) -> Self {
        let no_maps = Chain { parent_from_child: DAffine3::IDENTITY, rounding: Rounding::NONE };
        Self { shapes, endless: false, solids: Vec::new(), parts: Vec::new(), chains: vec![no_maps] }
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.solids.len()
    }

    pub(super) fn solid(&self, solid: u32) -> &Solid {
        &self.solids[solid as usize]
    }

    pub(super) fn parts(&self, range: &Range<u32>) -> &[Part] {
        &self.parts[range.start as usize..range.end as usize]
    }

    /// An image as a part of what is directly above it.
    pub(super) fn part(&self, image: Image) -> Part {
        Part { chain: self.chains[image.chain as usize], solid: image.solid }
    }

    /// How far a support that a query finds in a part is from that in exact arithmetic, as [`Solid::error`].
    pub(super) fn error(&self, part: &Part) -> f64 {
        let solid = self.solid(part.solid);
        part.chain.rounding.error_above(solid.bounds.magnitude(), solid.error)
    }

    /// A shape, given its box.
    pub(super) fn shape(&mut self, shape: u32, bounds: Aabb) -> Image {
        self.push(Kind::Shape(shape), bounds, 0.0, evaluation(bounds))
    }

    /// The image of an image under one more map.
    pub(super) fn map(&mut self, parent_from_child: DAffine3, child: Image) -> Image {
        let map = Chain { parent_from_child, rounding: Rounding::of(&parent_from_child) };
        self.chains.push(match child.chain {
            NO_CHAIN => map,
            inner => map.after(&self.chains[inner as usize]),
        });
        Image { chain: index(self.chains.len() - 1), solid: child.solid }
    }

    /// The union of images, given its box and the gap of that.
    pub(super) fn union(&mut self, images: &[Image], bounds: Aabb, gap: f64) -> Image {
        let (start, mut left) = (self.parts.len(), images.len());
        for image in images {
            left -= 1;
            match self.solid(image.solid).kind.clone() {
                Kind::Union(inner) if self.parts.len() - start + inner.len() + left <= PARTS => {
                    for at in inner {
                        let part = self.parts[at as usize];
                        let chain = match image.chain {
                            NO_CHAIN => part.chain,
                            outer => self.chains[outer as usize].after(&part.chain),
                        };
                        self.parts.push(Part { chain, ..part });
                    }
                }
                _ if self.solid(image.solid).bounds.is_empty() => {}
                _ => self.parts.push(self.part(*image)),
            }
        }
        let error = self.parts[start..].iter().map(|part| self.error(part)).fold(0.0, f64::max);
        self.push(Kind::Union(index(start)..index(self.parts.len())), bounds, gap, error)
    }

    /// The intersection of images, given its box and the gap of that.
    pub(super) fn intersection(&mut self, images: [Image; 2], bounds: Aabb, gap: f64) -> Image {
        let start = self.parts.len();
        let mut error = evaluation(bounds);
        let most = OPERAND_ERROR * error;
        for part in images.map(|image| self.part(image)) {
            let own = self.error(&part);
            if own <= most {
                error = error.max(own);
                self.parts.push(part);
            }
        }
        self.push(Kind::Intersection(index(start)..index(self.parts.len())), bounds, gap, error)
    }

    /// A solid without points.
    pub(super) fn nothing(&mut self) -> Image {
        let parts = index(self.parts.len());
        self.push(Kind::Union(parts..parts), Aabb::EMPTY, 0.0, 0.0)
    }

    /// A solid of which nothing is known yet, because it is a part of itself.
    pub(super) fn declare(&mut self) -> Image {
        self.endless = true;
        self.push(Kind::Union(0..0), Aabb::ALL, f64::INFINITY, f64::INFINITY)
    }

    /// The parts of a declared solid.
    pub(super) fn define(&mut self, solid: u32, intersection: bool, images: impl Iterator<Item = Image>) {
        let start = self.parts.len();
        for image in images {
            self.parts.push(self.part(image));
        }
        let parts = index(start)..index(self.parts.len());
        let solid = &mut self.solids[solid as usize];
        solid.kind = if intersection { Kind::Intersection(parts) } else { Kind::Union(parts) };
        solid.touched = !intersection;
    }

    /// A better box of a declared solid, with its gap.
    pub(super) fn confine(&mut self, solid: u32, bounds: Aabb, gap: f64) {
        let solid = &mut self.solids[solid as usize];
        (solid.bounds, solid.center, solid.half, solid.gap) =
            (bounds, bounds.center(), 0.5 * bounds.size(), gap);
    }

    /// Drops the parts of a union that are empty. Returns how many are left.
    pub(super) fn keep_parts_with_points(&mut self, solid: u32) -> usize {
        let Kind::Union(parts) = self.solids[solid as usize].kind.clone() else {
            unreachable!("it is asked for unions")
        };
        let mut end = parts.start;
        for at in parts.clone() {
            let part = self.parts[at as usize];
            if !self.solid(part.solid).bounds.is_empty() {
                self.parts[end as usize] = part;
                end += 1;
            }
        }
        self.solids[solid as usize].kind = Kind::Union(parts.start..end);
        (end - parts.start) as usize
    }

    /// The error of a declared solid.
    pub(super) fn set_error(&mut self, solid: u32, error: f64) {
        self.solids[solid as usize].error = error;
    }

    /// A solid as a part of what is in its own frame.
    pub(super) fn itself(&self, solid: u32) -> Part {
        Part { chain: self.chains[NO_CHAIN as usize], solid }
    }

    fn push(&mut self, kind: Kind, bounds: Aabb, gap: f64, error: f64) -> Image {
        let (center, half) = (bounds.center(), 0.5 * bounds.size());
        let touched = match &kind {
            Kind::Shape(_) => true,
            Kind::Union(parts) => self.parts(parts).iter().all(|part| self.solid(part.solid).touched),
            Kind::Intersection(_) => false,
        };
        self.solids.push(Solid { kind, bounds, center, half, gap, touched, error });
        Image { chain: NO_CHAIN, solid: index(self.solids.len() - 1) }
    }
}

impl Chain {
    fn after(&self, inner: &Self) -> Self {
        let parent_from_child = self.parent_from_child * inner.parent_from_child;
        let rounding = Rounding::of_product(&parent_from_child, self.rounding, inner.rounding);
        Self { parent_from_child, rounding }
    }
}

impl Kind {
    /// Whether a query can go below it.
    pub(super) fn is_open(&self) -> bool {
        match self {
            Self::Shape(_) => false,
            Self::Union(parts) | Self::Intersection(parts) => !parts.is_empty(),
        }
    }
}

/// What evaluating the support of a box or a shape in it may err, for a direction of length 1.
fn evaluation(bounds: Aabb) -> f64 {
    Rounding::ONE.error_above(bounds.magnitude(), 0.0)
}
