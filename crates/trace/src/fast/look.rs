//! What is seen of all that is below a node of a tree, measured ahead.
//!
//! Where a node is too small to be looked into, its box is met in place of what is in it. Of the rays through that box only
//! some would have been stopped, and what they would have seen is a matter of chance: so for each node lines are drawn
//! through its box, as likely from each side as it is large, and what they meet is remembered. A line that comes to another
//! super-node is not followed any further, but goes by what was measured there: super-nodes are measured from the leaves
//! upwards, each once, so that ever deeper recursion costs no more. How many lines a super-node stops as a whole is asked
//! of the engine, though, while that does not take too long: of boxes in boxes, errors would add up.
//!
//! Parts in a row stop as many rays as they cover together, and no more than all. For parts that are side by side, as the
//! bricks of a wall are, this is exact from all sides; a wall of parts which are independent would have holes.

use csg_graph::{AttributeTerm, NodeId};
use csg_graph_bounds::Aabb;
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;

use super::compile::{Compiled, Content, Item, index};
use super::detail::{self, Part};
use super::frame::narrow;
use super::hits::Place;
use super::lanes::transform;
use super::sample::{Dice, Sample};
use super::single;
use super::tree::{Child, WIDTH};
use crate::{Ray, shapes};

/// Lines through a box, unless there are too many boxes.
const LINES: usize = 32;

/// And all lines together, more or less.
const ALL_LINES: usize = 1 << 18;

/// Lines through the box of a super-node that are followed to their ends.
const FOLLOWED: usize = 64;

/// The most of what lines meet that is remembered.
const SEEN: usize = 8;

/// The most parts of a node that a line is tested against.
const PARTS: usize = 64;

/// What is seen of all nodes.
#[derive(Debug, Default)]
pub(super) struct Looks {
    pub(super) nodes: Vec<Look>,
    pub(super) paints: Vec<Vec<(AttributeTerm, f64)>>,
}

/// What is seen of what is below a node.
#[derive(Clone, Debug, Default)]
pub(super) struct Look {
    /// The part of the lines through the box that are stopped in it.
    pub(super) cover: f32,
    /// Where some of them are.
    seen: Vec<Seen>,
}

/// A face of a primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) normal: Vec3,
    pub(super) node: NodeId,
    /// S-nodes on the way to it.
    pub(super) depth: u32,
    /// What paints it: an index into the paints.
    pub(super) paint: u32,
    /// The part of the light to it that comes through what is around it.
    pub(super) open: f32,
}

impl Looks {
    pub(super) fn bytes(&self) -> usize {
        let seen = self.nodes.iter().map(|look| size_of_val(&*look.seen));
        size_of_val(&*self.nodes) + seen.sum::<usize>()
    }
}

impl Look {
    /// Draws one of the faces as a ray would meet them. Its normal is turned to the ray.
    pub(super) fn draw(&self, direction: DVec3, dice: &mut Dice) -> Option<Seen> {
        if self.seen.is_empty() {
            return None;
        }
        let direction = direction.as_vec3();
        let facing = |seen: &Seen| f64::from(-seen.normal.dot(direction)).max(0.0);
        let drawn = self.seen[dice.draw(self.seen.iter().map(facing))];
        let normal = if drawn.normal.dot(direction) > 0.0 { -drawn.normal } else { drawn.normal };
        Some(Seen { normal, ..drawn })
    }
}

impl Compiled {
    /// What is seen of an item or a node that is not looked into, if it was measured. It is in the frame of the item.
    pub(super) fn look(&self, place: Place) -> Option<&Look> {
        let at = place.item as usize;
        if place.is_node {
            self.looks.nodes.get(at)
        } else {
            self.look_of(&self.looks.nodes, &self.items[at])
        }
    }

    /// What is seen of a super-node that an item leads to: what is seen of the first node of its tree.
    fn look_of<'l>(&self, looks: &'l [Look], item: &Item) -> Option<&'l Look> {
        let Content::Super(number) = item.content else { return None };
        looks.get(self.supers[number as usize].root?.get().err()?)
    }

    /// Measures what is seen of all nodes. `stops` says whether a super-node stops a ray in its frame, or nothing if that
    /// takes too long.
    pub(super) fn survey(&self, stops: &mut dyn FnMut(u32, &Ray) -> Option<bool>) -> Surveyed {
        let order = self.upwards();
        let lines = (ALL_LINES / self.nodes.len().max(1)).clamp(2, LINES);
        let mut survey = Survey {
            block: self,
            stops,
            lines,
            found: Surveyed {
                bounds: vec![Aabb::ALL; self.nodes.len()],
                looks: vec![Look::default(); self.nodes.len()],
                covers: vec![Some(1.0); self.items.len()],
                paints: Vec::new(),
            },
            numbers: FxHashMap::default(),
        };
        order.into_iter().for_each(|number| survey.measure(number));
        survey.found
    }

    /// Keeps what was measured.
    pub(super) fn with_looks(mut self, found: Surveyed) -> Self {
        let Surveyed { bounds, looks, covers, paints } = found;
        for (part, cover) in self.parts.iter_mut().zip(covers) {
            match cover {
                Some(cover) => part.cover = cover,
                None => part.size = f32::INFINITY,
            }
        }
        for (node, (bounds, look)) in self.nodes.iter_mut().zip(bounds.iter().zip(&looks)) {
            // What no line has met is looked into.
            if !look.seen.is_empty() {
                node.size = narrow(bounds.size().length());
            }
        }
        self.looks = Looks { nodes: looks, paints };
        self
    }

    /// The super-nodes, each behind those that its items lead to.
    fn upwards(&self) -> Vec<u32> {
        let mut is_open = vec![false; self.supers.len()];
        let mut order = Vec::new();
        let mut open = vec![(0, self.leads_to(0))];
        while let Some((number, below)) = open.last_mut() {
            match below.pop() {
                Some(next) if is_open[next as usize] => {}
                Some(next) => {
                    is_open[next as usize] = true;
                    open.push((next, self.leads_to(next)));
                }
                None => {
                    order.push(*number);
                    open.pop();
                }
            }
        }
        order
    }

    fn leads_to(&self, number: u32) -> Vec<u32> {
        let mut found: Vec<u32> = self
            .items_of(number)
            .filter_map(|item| match self.items[item].content {
                Content::Super(number) => Some(number),
                _ => None,
            })
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The nodes of the tree of a super-node, each before those below it.
    fn nodes_of(&self, number: u32) -> Vec<usize> {
        let mut nodes: Vec<usize> =
            self.supers[number as usize].root.and_then(|root| root.get().err()).into_iter().collect();
        let mut next = 0;
        while let Some(at) = nodes.get(next) {
            nodes.extend(self.children(*at).filter_map(|child| child.get().err()));
            next += 1;
        }
        nodes
    }

    fn items_of(&self, number: u32) -> impl Iterator<Item = usize> {
        let alone = self.supers[number as usize].root.and_then(|root| root.get().ok());
        let nodes = self.nodes_of(number);
        let below =
            nodes.into_iter().flat_map(|node| self.children(node).filter_map(|child| child.get().ok()));
        alone.into_iter().chain(below)
    }

    fn children(&self, node: usize) -> impl Iterator<Item = Child> + use<> {
        let node = &self.nodes[node];
        node.children.into_iter().take(WIDTH.min(node.count as usize))
    }
}

/// What was measured.
pub(super) struct Surveyed {
    /// The boxes of nodes in the frames of their super-nodes.
    bounds: Vec<Aabb>,
    looks: Vec<Look>,
    /// Of items; none of what is always looked into.
    covers: Vec<Option<f32>>,
    paints: Vec<Vec<(AttributeTerm, f64)>>,
}

/// Measures one super-node after the other.
struct Survey<'b> {
    block: &'b Compiled,
    stops: &'b mut dyn FnMut(u32, &Ray) -> Option<bool>,
    lines: usize,
    /// What is known so far.
    found: Surveyed,
    numbers: FxHashMap<Vec<(AttributeTerm, u64)>, u32>,
}

/// Where a line comes to some part of a node.
#[derive(Clone, Copy)]
struct Meeting {
    t: f64,
    cover: f32,
    part: Child,
}

impl Survey<'_> {
    /// Measures the nodes and items of a super-node. Those that it leads to have been measured.
    fn measure(&mut self, number: u32) {
        let block = self.block;
        let ball = &block.supers[number as usize];
        for at in block.nodes_of(number).into_iter().rev() {
            let node = &block.nodes[at];
            let unit = (0..WIDTH.min(node.count as usize)).map(|slot| node.bounds(slot));
            self.found.bounds[at] = ball.bounds(unit.fold(Aabb::EMPTY, Aabb::join));
            self.found.looks[at] = self.look_at(self.found.bounds[at], &self.parts(at));
        }
        if let Some(root) = ball.root.and_then(|root| root.get().err())
            && !self.found.looks[root].seen.is_empty()
            && let Some(cover) = self.follow(number, self.found.bounds[root])
        {
            self.found.looks[root].cover = cover;
            if cover <= 0.0 {
                self.found.looks[root].seen.clear();
            }
        }
        for at in block.items_of(number) {
            let Part { bounds, .. } = &block.parts[at];
            let is_seen =
                block.look_of(&self.found.looks, &block.items[at]).map(|look| !look.seen.is_empty());
            self.found.covers[at] = match block.items[at].content {
                Content::Super(_) if is_seen == Some(true) => {
                    Some(self.look_at(*bounds, &[Child::item(at)]).cover)
                }
                Content::Super(_) | Content::Shape(_) => None,
                Content::Solid(_) | Content::Gate(_) => Some(1.0),
            };
        }
    }

    /// The part of the lines through the box of a super-node that it stops, if they can be followed to their ends.
    fn follow(&mut self, number: u32, bounds: Aabb) -> Option<f32> {
        let mut dice = Dice::at(bounds.max);
        let mut stopped = 0_u16;
        for _ in 0..FOLLOWED {
            stopped += u16::from((self.stops)(number, &line_through(&bounds, &mut dice))?);
        }
        Some(f32::from(stopped) / narrow(FOLLOWED as f64))
    }

    /// What a node consists of: items, or nodes that are measured already, where it has too many items.
    fn parts(&self, node: usize) -> Vec<Child> {
        let mut parts: Vec<Child> = self.block.children(node).collect();
        let mut next = 0;
        while next < parts.len() && parts.len() < PARTS {
            match parts[next].get() {
                Ok(_) => next += 1,
                Err(below) => {
                    parts.swap_remove(next);
                    parts.extend(self.block.children(below));
                }
            }
        }
        parts
    }

    /// Draws lines through a box and looks at where they are stopped.
    fn look_at(&mut self, bounds: Aabb, parts: &[Child]) -> Look {
        let mut look = Look::default();
        if !bounds.is_bounded() || bounds.surface_area() <= 0.0 {
            return look;
        }
        let mut dice = Dice::at(bounds.min);
        let mut met = Vec::new();
        let mut stopped = 0.0;
        for _ in 0..self.lines {
            let line = line_through(&bounds, &mut dice);
            met.clear();
            met.extend(parts.iter().filter_map(|part| self.meet(*part, &line)));
            met.sort_unstable_by(|one: &Meeting, other| one.t.total_cmp(&other.t));
            stopped += met.iter().map(|meeting| meeting.cover).sum::<f32>().min(1.0);
            let mut patience = narrow(dice.throw());
            let first = met.iter().find(|meeting| {
                patience -= meeting.cover;
                patience < 0.0
            });
            if let Some(first) = first
                && look.seen.len() < SEEN
            {
                let seen = self.see(*first, &line, &mut dice);
                look.seen.extend(seen.map(|seen| {
                    let open = seen.open * self.open(parts, *first, &line, &seen, &mut dice);
                    Seen { open, ..seen }
                }));
            }
        }
        look.cover = stopped / narrow(self.lines as f64);
        look
    }

    /// Where a line comes to a part, and what of it stops lines.
    fn meet(&self, part: Child, line: &Ray) -> Option<Meeting> {
        let block = self.block;
        let (extents, cover) = match part.get() {
            Err(node) => (detail::extents(&self.found.bounds[node], line), self.found.looks[node].cover),
            Ok(at) => {
                let item = &block.items[at];
                let outer = detail::extents(&block.parts[at].bounds, line);
                single::first(&outer)?;
                let inside = transform(line, &item.item_from_super);
                match item.content {
                    Content::Shape(shape) => (shapes::extents(&block.shapes[shape as usize], &inside), 1.0),
                    Content::Super(number) => {
                        match block.supers[number as usize].root.and_then(|root| root.get().err()) {
                            Some(root) => (
                                detail::extents(&self.found.bounds[root], &inside),
                                self.found.looks[root].cover,
                            ),
                            None => (outer, 1.0),
                        }
                    }
                    Content::Solid(_) | Content::Gate(_) => (outer, 1.0),
                }
            }
        };
        single::first(&extents).map(|t| Meeting { t, cover, part })
    }

    /// The part of the light to a face that parts do not stop, other than the one where it is: of what comes from one
    /// side, by chance.
    fn open(&self, parts: &[Child], at: Meeting, line: &Ray, seen: &Seen, dice: &mut Dice) -> f32 {
        let direction = seen.normal.as_dvec3() + on_sphere(dice);
        let ray = Ray { origin: line.at(at.t), direction };
        let others = parts.iter().filter(|part| **part != at.part);
        let stopped: f32 =
            others.filter_map(|part| self.meet(*part, &ray)).map(|meeting| meeting.cover).sum();
        (1.0 - stopped).max(0.0)
    }

    /// What a line sees of a part that stops it.
    fn see(&mut self, Meeting { t, part, .. }: Meeting, line: &Ray, dice: &mut Dice) -> Option<Seen> {
        let block = self.block;
        let at = match part.get() {
            Err(node) => return self.found.looks[node].draw(line.direction, dice),
            Ok(at) => at,
        };
        let item = &block.items[at];
        let inside = transform(line, &item.item_from_super);
        let outer = item.paint.map_or(&[][..], |paint| &block.paints[paint as usize]);
        let (normal, node, depth, paint, open) = match item.content {
            Content::Shape(shape) => {
                let end = shapes::boundary(&block.shapes[shape as usize], &inside, t)?;
                (end.normal, item.node, 0, self.paint(outer, &[]), 1.0)
            }
            Content::Super(_) => {
                let seen = block.look_of(&self.found.looks, item)?.draw(inside.direction, dice)?;
                let inner = self.found.paints[seen.paint as usize].clone();
                (seen.normal.as_dvec3(), seen.node, seen.depth, self.paint(outer, &inner), seen.open)
            }
            Content::Solid(_) | Content::Gate(_) => {
                let (sample, _) = Sample::of_item(block, at, dice);
                let normal = sample.normal(&inside).unwrap_or(-inside.direction);
                (normal, sample.node, sample.depth, self.paint(outer, &sample.paint), 1.0)
            }
        };
        let normal = (item.item_from_super.matrix3.transpose() * normal).try_normalize()?.as_vec3();
        let normal = if normal.dot(line.direction.as_vec3()) > 0.0 { -normal } else { normal };
        Some(Seen { normal, node, depth: item.depth + depth, paint, open })
    }

    /// The index of what is painted from the outside and then from the inside.
    fn paint(&mut self, outer: &[(AttributeTerm, f64)], inner: &[(AttributeTerm, f64)]) -> u32 {
        let mut terms: Vec<(AttributeTerm, f64)> = Vec::new();
        for (term, value) in outer.iter().chain(inner) {
            match terms.iter_mut().find(|(known, _)| known == term) {
                Some((_, known)) => *known = *value,
                None => terms.push((*term, *value)),
            }
        }
        terms.sort_unstable_by_key(|(term, _)| *term);
        let key = terms.iter().map(|(term, value)| (*term, value.to_bits())).collect();
        *self.numbers.entry(key).or_insert_with(|| {
            self.found.paints.push(terms);
            index(self.found.paints.len() - 1)
        })
    }
}

/// A line through a box, all such being as likely: from a point of its surface, as the cosine of the angle there.
fn line_through(bounds: &Aabb, dice: &mut Dice) -> Ray {
    let size = bounds.size();
    let axis = dice.draw([size.y * size.z, size.z * size.x, size.x * size.y].into_iter());
    let mut origin = bounds.min + size * DVec3::from_array([0; 3].map(|_| dice.throw()));
    let side = if dice.throw() < 0.5 { 1.0 } else { -1.0 };
    origin[axis] = if side > 0.0 { bounds.min[axis] } else { bounds.max[axis] };
    let mut direction = on_sphere(dice);
    direction[axis] += side;
    // From outside, so that what touches the box is met.
    Ray { origin: origin - direction * size.length(), direction }
}

/// A direction, all being as likely.
fn on_sphere(dice: &mut Dice) -> DVec3 {
    loop {
        let point = DVec3::from_array([0; 3].map(|_| 2.0 * dice.throw() - 1.0));
        if (1e-6..1.0).contains(&point.length_squared()) {
            return point.normalize();
        }
    }
}
