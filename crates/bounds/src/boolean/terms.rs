//! Boolean terms, opened where a cell needs it and pruned where it does not.
//!
//! A term is a union or intersection of terms, or a *literal*: an instance of a state, or the complement of one. There
//! is no difference in it and no complement above an operator, for these go down by De Morgan's laws. To classify a cell
//! is to classify the literals: a union has the cell inside if one of its parts has it inside, and so on. What is mixed
//! remains, and it is all that smaller cells within this one have to look at: the term is *pruned* for each cell, as the
//! programs of implicit surfaces are in [KEET20].
//!
//! **Instances.** The first literal is the state itself. A literal that is not a shape is *opened* when a cell is mixed
//! in it that is not much larger than the instance; the instances below are new literals, each with the map from the
//! search's frame into its own. So recursion is unfolded only where cells become small: for a cell much larger, an
//! instance counts by its box, and its complement as all of space.
//!
//! **Rounding.** A cell is mapped into the frame of the instance and gets the slack that encloses its exact image: the
//! chain of maps is off by its [`Rounding`], which the inverse enlarges, and the inverse by its residual.

use std::ops::Range;

use glam::{DAffine3, DVec3};

use super::cell::{Cell, Side};
use super::enclosures::Enclosures;
use super::inverse::Inverse;
use crate::exact::Term;
use crate::narrow::index;
use crate::rounding::{EVALUATION, Rounding};
use crate::{Aabb, ExactBoxes, Scene, Shape};

/// An instance is opened for cells whose radius is at most so many times its own.
const LARGER: f64 = 1.0;

/// The diagonal of the unit cube, rounded up.
const DIAGONAL: f64 = 1.732_050_807_568_878;

/// What is known about a term in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Verdict {
    Outside,
    Inside,
    /// The term that decides within the cell, and how far it reaches in the direction of the search.
    Mixed(u32, f64),
}

/// All terms of one search.
pub(super) struct Terms<'a, S: Scene> {
    exact: &'a ExactBoxes<S>,
    enclosures: &'a Enclosures,
    direction: DVec3,
    instances: Vec<Instance>,
    terms: Vec<Node>,
    /// Of unions and intersections.
    operands: Vec<u32>,
    /// Operands found so far of the groups that are being pruned.
    kept: Vec<u32>,
    /// How many instances were opened, and how many may be.
    pub(super) opened: usize,
    pub(super) limit: usize,
}

#[derive(Clone, Copy)]
enum Node {
    /// An instance, or its complement.
    Literal { instance: u32, complement: bool },
    /// The union or the intersection of the operands from `start` to `end`.
    Group { any: bool, start: u32, end: u32 },
}

/// What looking at a literal says.
enum Literal {
    Known(Verdict),
    /// It was opened, and is this term.
    Opened(u32),
}

/// A state at a place.
struct Instance {
    state: u32,
    query_from_child: DAffine3,
    forward: Rounding,
    inverse: Inverse,
    /// No point of it is further in the direction of the search.
    reach: f64,
    /// A radius of its box, in the search's frame.
    radius: f64,
    /// The terms of the instance and of its complement, once it is opened.
    opened: Option<[u32; 2]>,
}

/// A union or intersection that is being pruned.
struct Group {
    any: bool,
    source: u32,
    rest: Range<u32>,
    kept: usize,
    reach: f64,
}

impl<'a, S: Scene> Terms<'a, S> {
    /// The term of a state, for a search in a direction of length 1.
    pub(super) fn new(
        exact: &'a ExactBoxes<S>,
        enclosures: &'a Enclosures,
        state: u32,
        direction: DVec3,
        limit: usize,
    ) -> (Self, u32) {
        let mut terms = Self {
            exact,
            enclosures,
            direction,
            instances: Vec::new(),
            terms: Vec::new(),
            operands: Vec::new(),
            kept: Vec::new(),
            opened: 0,
            limit,
        };
        let [root, _] = terms.literals(state, DAffine3::IDENTITY, Rounding::NONE);
        (terms, root)
    }

    /// Classifies a cell, given in the frame of the search, and prunes the term for it.
    pub(super) fn classify(&mut self, cell: &Cell, term: u32) -> Verdict {
        let mut groups: Vec<Group> = Vec::new();
        let mut next = term;
        loop {
            let mut verdict = match self.terms[next as usize] {
                Node::Literal { instance, complement } => match self.look(cell, next, instance, complement) {
                    Literal::Known(verdict) => verdict,
                    Literal::Opened(term) => {
                        next = term;
                        continue;
                    }
                },
                Node::Group { any, start, end } => {
                    let reach = if any { f64::NEG_INFINITY } else { f64::INFINITY };
                    groups.push(Group { any, source: next, rest: start..end, kept: self.kept.len(), reach });
                    // What a group of no operands is decides nothing in a group.
                    if any { Verdict::Outside } else { Verdict::Inside }
                }
            };
            // Up, until a group has more operands to look at.
            loop {
                let Some(group) = groups.last_mut() else { return verdict };
                let decided = match verdict {
                    Verdict::Inside => group.any,
                    Verdict::Outside => !group.any,
                    Verdict::Mixed(term, reach) => {
                        self.kept.push(term);
                        group.reach = if group.any { group.reach.max(reach) } else { group.reach.min(reach) };
                        false
                    }
                };
                if !decided && let Some(at) = group.rest.next() {
                    next = self.operands[at as usize];
                    break;
                }
                let group = groups.pop().expect("it was the last");
                if !decided {
                    verdict = self.prune(&group);
                }
                self.kept.truncate(group.kept);
            }
        }
    }

    /// Whether the solid certainly contains a cell.
    pub(super) fn contains(&mut self, cell: &Cell, term: u32) -> bool {
        let (opened, terms, operands) = (self.opened, self.terms.len(), self.operands.len());
        let verdict = self.classify(cell, term);
        // Nothing refers to what was pruned on the way, unless something was opened in between.
        if self.opened == opened {
            self.terms.truncate(terms);
            self.operands.truncate(operands);
        }
        verdict == Verdict::Inside
    }

    /// A group of which only the kept operands are left.
    fn prune(&mut self, group: &Group) -> Verdict {
        let kept = &self.kept[group.kept..];
        match *kept {
            [] if group.any => Verdict::Outside,
            [] => Verdict::Inside,
            [term] => Verdict::Mixed(term, group.reach),
            _ => {
                let Node::Group { any, start, end } = self.terms[group.source as usize] else {
                    unreachable!("groups come from groups")
                };
                if self.operands[start as usize..end as usize] == *kept {
                    return Verdict::Mixed(group.source, group.reach);
                }
                let start = index(self.operands.len());
                self.operands.extend_from_slice(kept);
                let end = index(self.operands.len());
                Verdict::Mixed(self.push(Node::Group { any, start, end }), group.reach)
            }
        }
    }

    /// Classifies a cell in a literal, or opens it.
    fn look(&mut self, cell: &Cell, term: u32, at: u32, complement: bool) -> Literal {
        let instance = &self.instances[at as usize];
        let state = instance.state as usize;
        let shape = match self.exact.graph().terms[state] {
            Term::Shape(shape) => Some(&self.exact.shapes()[shape as usize]),
            _ => None,
        };
        let bounds = self.enclosures.inside[state];
        let mut side = Side::Mixed;
        if bounds.is_empty() {
            side = Side::Outside;
        } else if let Some(cell) = instance.cell(cell, &bounds) {
            if cell.misses(&bounds) {
                side = Side::Outside;
            } else if let Some(shape) = shape {
                side = shape.classify(&cell);
            }
        }
        let reach = if complement { f64::INFINITY } else { instance.reach };
        Literal::Known(match (side, complement) {
            (Side::Mixed, _) if shape.is_none() => {
                return match self.open(cell, at) {
                    Some(opened) => Literal::Opened(opened[usize::from(complement)]),
                    None => Literal::Known(Verdict::Mixed(term, reach)),
                };
            }
            (Side::Mixed, _) => Verdict::Mixed(term, reach),
            (Side::Outside, false) | (Side::Inside, true) => Verdict::Outside,
            (Side::Inside, false) | (Side::Outside, true) => Verdict::Inside,
        })
    }

    /// The terms of an instance and of its complement, unless they are not worth it for this cell.
    fn open(&mut self, cell: &Cell, at: u32) -> Option<[u32; 2]> {
        let instance = &self.instances[at as usize];
        if instance.opened.is_some() {
            return instance.opened;
        }
        let small = cell.radius() > LARGER * instance.radius;
        let states = self.exact.graph();
        let (state, query_from_child, forward) =
            (instance.state, instance.query_from_child, instance.forward);
        // Of flat images, only the box is known.
        let flat = matches!(states.terms[state as usize], Term::Map(..));
        if small || flat || self.opened >= self.limit {
            return None;
        }
        self.opened += 1;
        let mut below = |operand: u32| self.literals(operand, query_from_child, forward);
        let opened = match states.terms[state as usize] {
            Term::Union(ref parts) => {
                let parts = &states.parts[parts.start as usize..parts.end as usize];
                let parts: Vec<[u32; 2]> = parts.iter().map(|part| below(*part)).collect();
                let of = |side: usize| parts.iter().map(move |part| part[side]);
                [self.group(true, of(0)), self.group(false, of(1))]
            }
            // What is there twice is there once, and nothing is left of a solid without itself.
            Term::Intersection([a, b]) if a == b => below(a),
            Term::Difference([a, b]) if a == b => [self.group(true, []), self.group(false, [])],
            Term::Intersection([a, b]) => {
                let ([a, not_a], [b, not_b]) = (below(a), below(b));
                [self.group(false, [a, b]), self.group(true, [not_a, not_b])]
            }
            Term::Difference([a, b]) => {
                let ([a, not_a], [b, not_b]) = (below(a), below(b));
                [self.group(false, [a, not_b]), self.group(true, [not_a, b])]
            }
            Term::Shape(_) | Term::Same(_) | Term::Map(..) => unreachable!("only operators are opened"),
        };
        self.instances[at as usize].opened = Some(opened);
        Some(opened)
    }

    /// The literal of a state under a chain of maps, and that of its complement.
    fn literals(
        &mut self,
        mut state: u32,
        mut query_from_child: DAffine3,
        mut forward: Rounding,
    ) -> [u32; 2] {
        let states = self.exact.graph();
        let mut inverse = Inverse::of(&query_from_child).expect("only maps with an inverse are passed");
        loop {
            match states.terms[state as usize] {
                Term::Same(below) => state = below,
                Term::Map(map, below) => {
                    let map = &states.maps[map as usize];
                    let product = query_from_child * *map;
                    let rounding = Rounding::of_product(&product, forward, Rounding::of(map));
                    // A flat image stays closed: what is around it is no image of what is around the solid below.
                    let Some(known) = Inverse::of(map).and(Inverse::of(&product)) else { break };
                    (state, query_from_child, forward, inverse) = (below, product, rounding, known);
                }
                _ => break,
            }
        }
        let bounds = self.enclosures.inside[state as usize];
        let direction = query_from_child.matrix3.transpose() * self.direction;
        let support = match states.terms[state as usize] {
            Term::Shape(shape) => self.exact.shapes()[shape as usize].support(direction),
            _ => bounds.support(direction),
        };
        let magnitude = bounds.magnitude();
        let error = forward.error_above(magnitude, Rounding::ONE.error_above(magnitude, 0.0));
        let reach = support + query_from_child.translation.dot(self.direction) + error;
        let instance = Instance {
            state,
            query_from_child,
            forward,
            inverse,
            // What is no number is no bound.
            reach: if reach.is_nan() { f64::INFINITY } else { reach },
            radius: if bounds.is_bounded() {
                Cell::from(bounds).image(&query_from_child).radius()
            } else {
                f64::INFINITY
            },
            opened: None,
        };
        self.instances.push(instance);
        let instance = index(self.instances.len() - 1);
        [false, true].map(|complement| self.push(Node::Literal { instance, complement }))
    }

    fn group(&mut self, any: bool, operands: impl IntoIterator<Item = u32>) -> u32 {
        let start = index(self.operands.len());
        self.operands.extend(operands);
        let end = index(self.operands.len());
        self.push(Node::Group { any, start, end })
    }

    fn push(&mut self, node: Node) -> u32 {
        self.terms.push(node);
        index(self.terms.len() - 1)
    }
}

impl Instance {
    /// The cell in the frame of the instance, with the slack for what that rounds and for what classifying it in a
    /// shape with these bounds may round. `None` where nothing can be said.
    ///
    /// The slack for a point of the exact image grows linearly with its coordinates, which are within the slack of the
    /// computed ones. If it is at most half of some magnitude that is at least twice the computed ones, no exact one is
    /// above that.
    fn cell(&self, cell: &Cell, bounds: &Aabb) -> Option<Cell> {
        let mapped = cell.image(&self.inverse.child_from_parent);
        let evaluation = self.inverse.rounding.error_above(largest(cell), 0.0);
        let slack = |magnitude: f64| {
            let forward = self.inverse.rounding.gain() * self.forward.error_above(magnitude, 0.0);
            forward + DIAGONAL * self.inverse.error(magnitude) + evaluation
        };
        let magnitude = 4.0 * (largest(&mapped) + slack(0.0));
        let slack = slack(magnitude);
        let faces = [bounds.min, bounds.max].map(|face| face.abs().to_array()).into_iter().flatten();
        let shape = faces.filter(|face| face.is_finite()).fold(0.0, f64::max);
        let classifying = 2.0 * EVALUATION * (magnitude + shape);
        // What is not a number is not at most half of anything.
        let sound = slack <= 0.5 * magnitude && (mapped.slack + classifying).is_finite();
        sound.then(|| mapped.with_slack(mapped.slack + slack + classifying))
    }
}

/// No point of a cell has a larger coordinate.
fn largest(cell: &Cell) -> f64 {
    cell.bounds().magnitude()
}
