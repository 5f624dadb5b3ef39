//! Wide trees over the boxes of items: what a ray descends inside of a super-node.
//!
//! Built top-down by the surface area heuristic in bins \[WALD07\], two children at a time, and then collapsed to
//! [`WIDTH`] by opening the largest. Each leaf is one item: items are transformations with a tree or a curved surface
//! behind them, so that a box test more costs less than an item too many.
//!
//! Boxes are single precision, in a frame where the super-node is a unit ball about the origin, and padded by
//! [`PADDING`]; see [`frame`](super::frame) for what the padding covers.

use std::ops::Range;

use csg_graph_bounds::Aabb;
use glam::DVec3;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// How far boxes are padded, in units of the super-node's radius.
pub(super) const PADDING: f64 = 1.0 / (1 << 20) as f64;

/// Bins of the surface area heuristic.
const BINS: usize = 16;

/// A [`Target`] in four bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

/// Where a tree goes on: the index of a node or of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Target {
    Node(usize),
    Item(usize),
}

/// The boxes of up to [`WIDTH`] children, side by side.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Three lower and three upper faces: `planes[axis]`, `planes[axis + 3]`.
    pub(super) planes: [[f32; WIDTH]; 6],
    pub(super) children: [Child; WIDTH],
    pub(super) count: u32,
    /// The diagonal of all of it in the frame of the super-node, if rays may see how large it is.
    pub(super) size: f32,
    /// The slabs of its children: their place among all, if there are any.
    pub(super) slabs: u32,
    /// How many of the rays through it are stopped: its place among the covers, if that was measured.
    pub(super) cover: u32,
}

impl Child {
    const ITEM: u32 = 1 << 31;

    pub(super) fn node(index: usize) -> Self {
        Self(Self::number(index))
    }

    pub(super) fn item(index: usize) -> Self {
        Self(Self::number(index) | Self::ITEM)
    }

    fn number(index: usize) -> u32 {
        let number = u32::try_from(index).ok().filter(|number| number & Self::ITEM == 0);
        number.expect("2³¹ nodes or items outgrow memory")
    }

    #[inline(always)]
    pub(super) fn target(self) -> Target {
        let index = (self.0 & !Self::ITEM) as usize;
        if self.0 & Self::ITEM == 0 { Target::Node(index) } else { Target::Item(index) }
    }

    #[inline(always)]
    pub(super) fn as_node(self) -> Option<usize> {
        let Target::Node(node) = self.target() else { return None };
        Some(node)
    }

    #[inline(always)]
    pub(super) fn as_item(self) -> Option<usize> {
        let Target::Item(item) = self.target() else { return None };
        Some(item)
    }
}

/// Adds the tree over `boxes` to `nodes`. Box i belongs to the item `first + i`.
///
/// # Panics
/// If there are no boxes.
pub(super) fn build(boxes: &[Aabb], first: usize, nodes: &mut Vec<Node>) -> Child {
    assert!(!boxes.is_empty(), "a tree of nothing");
    if (2..=WIDTH).contains(&boxes.len()) {
        let mut node = Node::EMPTY;
        boxes.iter().enumerate().for_each(|(at, bounds)| node.put(at, Child::item(first + at), *bounds));
        if nodes.is_empty() {
            // Often the only one, in one of very many blocks.
            nodes.reserve_exact(1);
        }
        nodes.push(node);
        return Child::node(nodes.len() - 1);
    }
    let mut halving = Halving::new(boxes);
    collapse(&mut halving, first, nodes)
}

/// A part of the order of items.
#[derive(Clone, Copy)]
struct Piece {
    bounds: Aabb,
    start: usize,
    end: usize,
}

/// Items in an order that is found as they are taken apart.
struct Halving<'a> {
    boxes: &'a [Aabb],
    centers: Vec<DVec3>,
    order: Vec<usize>,
    /// For what has to be moved.
    moved: Vec<usize>,
}

impl<'a> Halving<'a> {
    fn new(boxes: &'a [Aabb]) -> Self {
        let centers = boxes.iter().map(Aabb::center).collect();
        Self { boxes, centers, order: (0..boxes.len()).collect(), moved: Vec::new() }
    }

    fn piece(&self, start: usize, end: usize) -> Piece {
        let items = &self.order[start..end];
        let bounds = items.iter().fold(Aabb::EMPTY, |all, item| all.join(self.boxes[*item]));
        Piece { bounds, start, end }
    }

    /// Takes a piece of two items or more apart.
    fn halves(&mut self, Piece { start, end, .. }: Piece) -> [Piece; 2] {
        let middle = start + self.split(start, end);
        [self.piece(start, middle), self.piece(middle, end)]
    }

    /// Partitions the items of a piece in two and says how many come first: where the surface area heuristic is least, or in
    /// the middle if all are in one place. Unbounded ones are apart from the others.
    fn split(&mut self, start: usize, end: usize) -> usize {
        let Self { boxes, centers, order, moved } = self;
        let items = &mut order[start..end];
        // Unbounded boxes have no area to compare.
        if items.iter().any(|item| !boxes[*item].is_bounded()) {
            let unbounded = partition(items, moved, |item| !boxes[item].is_bounded());
            return if unbounded == items.len() { unbounded / 2 } else { unbounded };
        }
        let spread = Aabb::from_points(items.iter().map(|item| centers[*item]));
        let mut best = (f64::INFINITY, 0, 0);
        for axis in 0..3 {
            let Some(bin) = binning(&spread, axis) else { continue };
            let mut bins = [(Aabb::EMPTY, 0_usize); BINS];
            for item in items.iter() {
                let (bounds, count) = &mut bins[bin(centers[*item])];
                *bounds = bounds.join(boxes[*item]);
                *count += 1;
            }
            // Areas times counts of all that is in or before each bin, and then of all that is behind it.
            let mut before = [0.0; BINS];
            let mut sum = (Aabb::EMPTY, 0);
            for (cost, bin) in before.iter_mut().zip(&bins) {
                sum = (sum.0.join(bin.0), sum.1 + bin.1);
                *cost = sum.0.surface_area() * sum.1 as f64;
            }
            sum = (Aabb::EMPTY, 0);
            for last in (0..BINS - 1).rev() {
                sum = (sum.0.join(bins[last + 1].0), sum.1 + bins[last + 1].1);
                let cost = before[last] + sum.0.surface_area() * sum.1 as f64;
                if cost < best.0 {
                    best = (cost, axis, last);
                }
            }
        }
        let (cost, axis, last) = best;
        let bin = binning(&spread, axis).filter(|_| cost.is_finite());
        let count = bin.map_or(0, |bin| partition(items, moved, |item| bin(centers[item]) <= last));
        if count == 0 || count == items.len() { items.len() / 2 } else { count }
    }
}

/// The bin of a centre along an axis, unless all have the same coordinate.
fn binning(spread: &Aabb, axis: usize) -> Option<impl Fn(DVec3) -> usize> {
    let (low, size) = (spread.min[axis], spread.size()[axis]);
    let scale = BINS as f64 / size;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a bin below BINS")]
    let bin = move |center: DVec3| ((center[axis] - low) * scale) as usize;
    (size > 0.0 && scale.is_finite()).then_some(move |center| bin(center).min(BINS - 1))
}

/// Moves what fulfils the condition to the front, in order, and says how much that is.
fn partition(items: &mut [usize], moved: &mut Vec<usize>, condition: impl Fn(usize) -> bool) -> usize {
    moved.clear();
    let mut count = 0;
    for at in 0..items.len() {
        let item = items[at];
        if condition(item) {
            items[count] = item;
            count += 1;
        } else {
            moved.push(item);
        }
    }
    items[count..].copy_from_slice(moved);
    count
}

/// Makes a node of an item that is alone.
pub(super) fn node_of_one(bounds: Aabb, item: usize, nodes: &mut Vec<Node>) -> Child {
    let mut node = Node::EMPTY;
    node.put(0, Child::item(item), bounds);
    nodes.push(node);
    Child::node(nodes.len() - 1)
}

/// Makes wide nodes of more than one item: from each, the largest piece is replaced by its halves while there is room.
fn collapse(halving: &mut Halving<'_>, first: usize, nodes: &mut Vec<Node>) -> Child {
    let all = halving.piece(0, halving.order.len());
    if all.end < 2 {
        return Child::item(first);
    }
    let root = Child::node(nodes.len());
    let mut open = vec![(all, nodes.len())];
    nodes.push(Node::EMPTY);
    let mut pieces = Vec::with_capacity(WIDTH);
    while let Some((piece, node)) = open.pop() {
        if piece.end - piece.start <= WIDTH {
            let items = &halving.order[piece.start..piece.end];
            let slots = items.iter().enumerate();
            slots.for_each(|(slot, item)| {
                nodes[node].put(slot, Child::item(first + item), halving.boxes[*item])
            });
            continue;
        }
        pieces.clear();
        pieces.push(piece);
        while pieces.len() < WIDTH {
            let length = |at: &usize| pieces[*at].end - pieces[*at].start;
            // What fits into one node as a whole stays one while there is anything else to open.
            let area = |at: &usize| if length(at) <= WIDTH { 0.0 } else { pieces[*at].bounds.surface_area() };
            let inner = (0..pieces.len()).filter(|at| length(at) > 1);
            let Some(largest) = inner.max_by(|a, b| area(a).total_cmp(&area(b))) else { break };
            let [left, right] = halving.halves(pieces[largest]);
            pieces[largest] = left;
            pieces.insert(largest + 1, right);
        }
        for (slot, piece) in pieces.iter().enumerate() {
            let target = if piece.end - piece.start < 2 {
                Child::item(first + halving.order[piece.start])
            } else {
                open.push((*piece, nodes.len()));
                nodes.push(Node::EMPTY);
                Child::node(nodes.len() - 1)
            };
            nodes[node].put(slot, target, piece.bounds);
        }
    }
    root
}

impl Node {
    const EMPTY: Self = Self {
        planes: [[0.0; WIDTH]; 6],
        children: [Child(0); WIDTH],
        count: 0,
        size: f32::INFINITY,
        slabs: u32::MAX,
        cover: u32::MAX,
    };

    /// The slots of its children, which are the first.
    #[inline(always)]
    pub(super) fn slots(&self) -> Range<usize> {
        0..WIDTH.min(self.count as usize)
    }

    /// The same as a set of bits.
    #[inline(always)]
    pub(super) fn all_slots(&self) -> u32 {
        (1 << self.count) - 1
    }

    /// For each axis, the planes where a ray comes in, given whether its coordinate falls.
    #[inline(always)]
    pub(super) fn near_planes(&self, falling: [bool; 3]) -> [&[f32; WIDTH]; 3] {
        let [x, y, z] = falling;
        [
            &self.planes[if x { 3 } else { 0 }],
            &self.planes[if y { 4 } else { 1 }],
            &self.planes[if z { 5 } else { 2 }],
        ]
    }

    /// And where it goes out.
    #[inline(always)]
    pub(super) fn far_planes(&self, falling: [bool; 3]) -> [&[f32; WIDTH]; 3] {
        self.near_planes([!falling[0], !falling[1], !falling[2]])
    }

    /// The box of a child in the frame of the unit ball.
    pub(super) fn bounds(&self, slot: usize) -> Aabb {
        let corner = |first: usize| {
            DVec3::from_array([0, 1, 2].map(|axis| f64::from(self.planes[first + axis][slot])))
        };
        Aabb { min: corner(0), max: corner(3) }
    }

    fn put(&mut self, slot: usize, child: Child, bounds: Aabb) {
        let padded = Aabb { min: bounds.min - PADDING, max: bounds.max + PADDING };
        let [min, max] = padded.to_f32_outward();
        for axis in 0..3 {
            self.planes[axis][slot] = min[axis];
            self.planes[axis + 3][slot] = max[axis];
        }
        self.children[slot] = child;
        self.count += 1;
    }
}
