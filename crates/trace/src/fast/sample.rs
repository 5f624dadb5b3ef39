//! What is seen of a part that is too small to be looked into: one of its primitives, drawn by chance.
//!
//! A crown of leaves is green from afar because most of what would be seen of it is. So a primitive is drawn from the
//! part and shows its paint, and the side that it turns to the ray. Over the many small parts of a picture this is about
//! what the mean of the primitives would be. The numbers that it is drawn by are a function of the place, so that the same
//! place always shows the same.

use csg_graph::{EvalError, Graph, NodeId, Operator, Primitive, State, Step};
use csg_graph_bounds::Shape;
use glam::{DAffine3, DVec3};

use super::compiled::{Compiled, Content, Gate};
use super::instance::{Paint, inverse, paint_over};
use super::tree::{self, Child, Target, WIDTH};
use super::unions::Unions;
use crate::{Ray, shapes};

/// Recursion that has shown no primitive after so many operators or S-nodes has hardly any to show.
const FAR: u32 = 2048;

/// A primitive of a part.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    /// The primitive; none where recursion has no primitives.
    pub(super) shape: Option<Primitive>,
    /// From the frame of the part.
    shape_from_part: DAffine3,
    pub(super) node: NodeId,
    /// S-nodes on the way to it.
    pub(super) depth: u32,
    /// What paints it.
    pub(super) paint: Paint,
}

/// Numbers by chance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dice(u64);

impl Dice {
    /// Of a place.
    pub(crate) fn at(place: DVec3) -> Self {
        let mut dice = Self(0);
        for coordinate in place.to_array() {
            dice.0 ^= coordinate.to_bits();
            dice.throw();
        }
        dice
    }

    /// Of a ray.
    pub(super) fn of(ray: &Ray) -> Self {
        let mut dice = Self::at(ray.direction);
        for coordinate in ray.origin.to_array() {
            dice.0 ^= coordinate.to_bits();
            dice.throw();
        }
        dice
    }

    /// Of a ray and an item of the super-node that it is in.
    pub(super) fn of_part(ray: &Ray, item: u32) -> Self {
        let mut dice = Self::of(ray);
        dice.0 ^= u64::from(item);
        dice.throw();
        dice
    }

    /// A number from 0 to 1 (Steele and others' splitmix \[STEE14\]).
    pub(crate) fn throw(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ bits >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ bits >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (bits >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Draws one of some weights.
    pub(super) fn draw(&mut self, weights: impl Iterator<Item = f64> + Clone) -> usize {
        let mut left = self.throw() * weights.clone().sum::<f64>();
        let drawn = weights.clone().position(|weight| {
            left -= weight;
            left < 0.0
        });
        drawn.unwrap_or(weights.count() - 1)
    }
}

impl Sample {
    fn none(node: NodeId) -> Self {
        Self { shape: None, shape_from_part: DAffine3::IDENTITY, node, depth: 0, paint: Paint::new() }
    }

    /// Draws from an item of a block, until there is a primitive, or a gate to draw from, which is given as well.
    pub(super) fn of_item<'b>(block: &'b Compiled, item: usize, dice: &mut Dice) -> (Self, Option<&'b Gate>) {
        Self::of_part(block, item, false, dice)
    }

    /// Draws from the items below a node of a block in the same way.
    pub(super) fn of_node<'b>(block: &'b Compiled, node: usize, dice: &mut Dice) -> (Self, Option<&'b Gate>) {
        Self::of_part(block, draw_item(block, &block.nodes[node], dice), true, dice)
    }

    /// Draws from an item that is the part, or below it.
    fn of_part<'b>(
        block: &'b Compiled,
        mut at: usize,
        mut is_below: bool,
        dice: &mut Dice,
    ) -> (Self, Option<&'b Gate>) {
        let mut sample = Self::none(block.items[at].node);
        for _ in 0..FAR {
            let item = &block.items[at];
            if is_below {
                sample.shape_from_part = item.item_from_super * sample.shape_from_part;
                sample.depth += item.depth;
                let paint = item.paint.into_iter().flat_map(|paint| &block.paints[paint as usize]);
                paint_over(&mut sample.paint, paint.copied());
            }
            sample.node = item.node;
            let below = match item.content {
                Content::Shape(shape) => {
                    sample.shape = Some(block.shapes[shape as usize].clone());
                    return (sample, None);
                }
                Content::Gate(gate) => return (sample, Some(&block.gates[gate as usize])),
                Content::Super(number) => number,
                Content::Solid(solid) => block.solids[solid as usize].operands[0],
            };
            at = match block.supers[below as usize].root.map(Child::target) {
                None => return (sample, None),
                Some(Target::Item(item)) => item,
                Some(Target::Node(node)) => draw_item(block, &block.nodes[node], dice),
            };
            is_below = true;
        }
        // An operand may lead back to its own solid for as long as one likes.
        (sample, None)
    }

    /// Draws from what is below a state, of the parts of a union in one rule each as likely.
    pub(super) fn of_state(
        graph: &Graph,
        unions: &Unions,
        state: &State,
        dice: &mut Dice,
    ) -> Result<Self, EvalError> {
        let mut sample = Self::none(state.node());
        let (mut state, mut operators) = (state.clone(), 0);
        loop {
            sample.node = state.node();
            state = match graph.step(&state)? {
                Step::Select(_) if sample.depth == FAR => return Ok(sample),
                Step::Select(below) => {
                    sample.depth += 1;
                    below
                }
                Step::Calculate(below) => below,
                Step::Attribute(terms, below) => {
                    paint_over(&mut sample.paint, terms);
                    below
                }
                Step::Transform(parent_from_child, below) => {
                    sample.shape_from_part = inverse(&parent_from_child) * sample.shape_from_part;
                    below
                }
                Step::Operator(..) if operators == FAR => return Ok(sample),
                Step::Operator(Operator::Union, operands) => {
                    operators += 1;
                    let drawn = dice.draw(operands.iter().map(|operand| unions.parts(operand.node()) as f64));
                    let [left, right] = operands;
                    if drawn == 0 { left } else { right }
                }
                Step::Operator(_, [left, _]) => {
                    operators += 1;
                    left
                }
                Step::Primitive(primitive) => {
                    sample.shape = Some(primitive);
                    return Ok(sample);
                }
                other => unreachable!("{other:?} is no kind of node that there is"),
            };
        }
    }

    /// With what is drawn from the part that this has come to.
    pub(super) fn then(mut self, inner: &Self) -> Self {
        paint_over(&mut self.paint, inner.paint.iter().copied());
        Self {
            shape: inner.shape.clone(),
            shape_from_part: inner.shape_from_part * self.shape_from_part,
            node: inner.node,
            depth: self.depth + inner.depth,
            paint: self.paint,
        }
    }

    /// The normal that it turns to a ray in the frame of the part, there.
    pub(super) fn normal(&self, ray: &Ray) -> Option<DVec3> {
        let shape = self.shape.as_ref()?;
        let direction = self.shape_from_part.transform_vector3(ray.direction).try_normalize()?;
        let bounds = shape.bounds();
        let normal = if bounds.is_bounded() {
            let origin = bounds.center() - direction * bounds.size().length();
            shapes::boundary(shape, &Ray { origin, direction }, 0.0)?.normal
        } else {
            DVec3::Z
        };
        Some(self.shape_from_part.matrix3.transpose() * normal)
    }
}

/// Draws an item below a node, a child of each node by the surface of its box.
fn draw_item<'b>(block: &'b Compiled, mut node: &'b tree::Node, dice: &mut Dice) -> usize {
    loop {
        let area = |slot: usize| node.bounds(slot).surface_area();
        let drawn = dice.draw(node.slots().map(area));
        match node.children[drawn % WIDTH].target() {
            Target::Item(item) => return item,
            Target::Node(below) => node = &block.nodes[below],
        }
    }
}
