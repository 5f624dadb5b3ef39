//! Wide trees over the boxes of items: what a ray descends inside of a super-node.
//!
//! Built top-down by the surface area heuristic in bins \[WALD07\], two children at a time, and then collapsed to
//! [`WIDTH`] by opening the largest. Each leaf is one item: items are transformations with a tree or a curved surface
//! behind them, so that a box test more costs less than an item too many.
//!
//! Boxes are single precision, in a frame where the super-node is a unit ball about the origin, and padded by
//! [`PADDING`]; see [`packet`](super::packet) for what the padding covers.

use csg_graph_bounds::Aabb;
use glam::DVec3;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// How far boxes are padded, in units of the super-node's radius.
const PADDING: f64 = 1.0 / (1 << 20) as f64;

/// Bins of the surface area heuristic.
const BINS: usize = 16;

/// Where a tree goes on: at a node, or at an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child(u32);

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
}

impl Child {
    const ITEM: u32 = 1 << 31;

    fn node(index: usize) -> Self {
        Self(
            u32::try_from(index)
                .ok()
                .filter(|index| index & Self::ITEM == 0)
                .expect("2³¹ nodes outgrow memory"),
        )
    }

    pub(super) fn item(index: usize) -> Self {
        let index = u32::try_from(index).ok().filter(|index| index & Self::ITEM == 0);
        Self(index.expect("2³¹ items outgrow memory") | Self::ITEM)
    }

    /// The index of the item, or that of the node as an error.
    pub(super) fn get(self) -> Result<usize, usize> {
        if self.0 & Self::ITEM == 0 { Err(self.0 as usize) } else { Ok((self.0 ^ Self::ITEM) as usize) }
    }
}

/// Adds the tree over `boxes` to `nodes`. Box i belongs to the item `first + i`.
///
/// # Panics
/// If there are no boxes.
pub(super) fn build(boxes: &[Aabb], first: usize, nodes: &mut Vec<Node>) -> Child {
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
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    let binary = binary(boxes, &mut order);
    collapse(&binary, &order, boxes, first, nodes)
}

/// A binary tree over a range of the order, its children behind it.
struct Pair {
    bounds: Aabb,
    start: usize,
    end: usize,
    /// Indices of both halves; of a leaf, none.
    halves: Option<[usize; 2]>,
}

fn binary(boxes: &[Aabb], order: &mut [usize]) -> Vec<Pair> {
    let bounds = |items: &[usize]| items.iter().fold(Aabb::EMPTY, |all, item| all.join(boxes[*item]));
    let mut pairs = vec![Pair { bounds: bounds(order), start: 0, end: order.len(), halves: None }];
    let mut open = vec![0];
    while let Some(at) = open.pop() {
        let Pair { start, end, .. } = pairs[at];
        if end - start < 2 {
            continue;
        }
        let middle = start + split(boxes, &mut order[start..end]);
        let first = pairs.len();
        for (start, end) in [(start, middle), (middle, end)] {
            pairs.push(Pair { bounds: bounds(&order[start..end]), start, end, halves: None });
        }
        pairs[at].halves = Some([first, first + 1]);
        open.extend([first, first + 1]);
    }
    pairs
}

/// Partitions items in two and says how many come first: where the surface area heuristic is least, or in the middle if
/// all are in one place. Unbounded ones are apart from the others.
fn split(boxes: &[Aabb], items: &mut [usize]) -> usize {
    // Unbounded boxes have no area to compare.
    if items.iter().any(|item| !boxes[*item].is_bounded()) {
        let unbounded = partition(items, |item| !boxes[item].is_bounded());
        return if unbounded == items.len() { unbounded / 2 } else { unbounded };
    }
    let centers = items.iter().map(|item| boxes[*item].center());
    let spread = Aabb::from_points(centers);
    let mut best = (f64::INFINITY, 0, 0);
    for axis in 0..3 {
        let Some(bin) = binning(&spread, axis) else { continue };
        let mut bins = [(Aabb::EMPTY, 0_usize); BINS];
        for item in items.iter() {
            let (bounds, count) = &mut bins[bin(boxes[*item].center())];
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
    let count = bin.map_or(0, |bin| partition(items, |item| bin(boxes[item].center()) <= last));
    if count == 0 || count == items.len() { items.len() / 2 } else { count }
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
fn partition(items: &mut [usize], condition: impl Fn(usize) -> bool) -> usize {
    let (front, back): (Vec<usize>, Vec<usize>) = items.iter().partition(|item| condition(**item));
    items[..front.len()].copy_from_slice(&front);
    items[front.len()..].copy_from_slice(&back);
    front.len()
}

/// Turns pairs into wide nodes: from each, the largest pair is replaced by its halves while there is room.
fn collapse(pairs: &[Pair], order: &[usize], boxes: &[Aabb], first: usize, nodes: &mut Vec<Node>) -> Child {
    let item = |pair: &Pair| Child::item(first + order[pair.start]);
    if pairs[0].halves.is_none() {
        return item(&pairs[0]);
    }
    let root = Child::node(nodes.len());
    let mut open = vec![(0, nodes.len())];
    nodes.push(Node::EMPTY);
    while let Some((at, node)) = open.pop() {
        let mut children = vec![at];
        while children.len() < WIDTH {
            let inner = |index: &usize| pairs[children[*index]].halves.is_some();
            // What fits into one node as a whole stays one, unless this is it.
            let area = |index: &usize| {
                let pair = &pairs[children[*index]];
                let fits = pair.end - pair.start <= WIDTH && pairs[at].end - pairs[at].start > WIDTH;
                if fits { 0.0 } else { pair.bounds.surface_area() }
            };
            let largest = (0..children.len()).filter(inner).max_by(|a, b| area(a).total_cmp(&area(b)));
            let Some(largest) = largest else { break };
            let [left, right] = pairs[children[largest]].halves.expect("only inner pairs are opened");
            children[largest] = left;
            children.insert(largest + 1, right);
        }
        for (slot, child) in children.into_iter().enumerate() {
            let pair = &pairs[child];
            let (target, bounds) = match pair.halves {
                None => (item(pair), boxes[order[pair.start]]),
                Some(_) => {
                    open.push((child, nodes.len()));
                    nodes.push(Node::EMPTY);
                    (Child::node(nodes.len() - 1), pair.bounds)
                }
            };
            nodes[node].put(slot, target, bounds);
        }
    }
    root
}

impl Node {
    const EMPTY: Self =
        Self { planes: [[0.0; WIDTH]; 6], children: [Child(0); WIDTH], count: 0, size: f32::INFINITY };

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
