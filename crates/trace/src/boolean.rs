//! Boolean operators on the spans of a ray.
//!
//! Below ∩ and \ a nearest hit is not enough: each operand gives all boundaries on the whole line, and the operator merges
//! the two lists. A list alternates between entering and leaving, at strictly increasing t, and starts outside.
//!
//! Coincident faces need no tolerance. All boundaries at one t are taken together, and the result has a boundary there only
//! if being inside before and being inside after differ: A \ A is empty, A ∩ A is A, and a hole that ends in a face of the
//! solid leaves no skin over it. Where both operands have a fitting boundary at one t, the left one is shown.

use csg_graph::{NodeId, Operator};
use glam::DVec3;

use crate::Surface;

/// A boundary of a solid on a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    pub(crate) t: f64,
    /// Outward from the resulting solid, in the world, of any positive length.
    pub(crate) normal: DVec3,
    pub(crate) surface: Surface,
    pub(crate) node: NodeId,
    pub(crate) depth: u32,
    /// The number of the last S-node's state, if the walk numbers them.
    pub(crate) symbol: Option<u32>,
}

/// Lists of edges, the operands that wait for their operators, one behind the other in one buffer.
#[derive(Debug, Default)]
pub(crate) struct SpanStack {
    edges: Vec<Edge>,
    /// Where each list starts.
    starts: Vec<usize>,
    merged: Vec<Edge>,
}

impl SpanStack {
    /// Forgets all lists.
    pub(crate) fn clear(&mut self) {
        self.edges.clear();
        self.starts.clear();
    }

    /// Starts a list on top of the others, empty so far.
    pub(crate) fn open(&mut self) {
        self.starts.push(self.edges.len());
    }

    /// Adds an edge to the top list.
    pub(crate) fn push(&mut self, edge: Edge) {
        self.edges.push(edge);
    }

    /// The top list.
    pub(crate) fn top(&self) -> &[Edge] {
        self.starts.last().map_or(&[], |start| &self.edges[*start..])
    }

    /// Drops the top list.
    pub(crate) fn pop(&mut self) {
        if let Some(start) = self.starts.pop() {
            self.edges.truncate(start);
        }
    }

    /// Replaces the two top lists, the right operand's above the left one's, by the operator's result.
    pub(crate) fn combine(&mut self, operator: Operator) {
        let middle = self.starts.pop().expect("an operator comes after its right operand");
        let start = *self.starts.last().expect("an operator comes after its left operand");
        let (left, right) = self.edges[start..].split_at(middle - start);
        merge(operator, left, right, &mut self.merged);
        self.edges.truncate(start);
        self.edges.append(&mut self.merged);
    }
}

/// Whether a point is inside of the result, from whether it is inside of the operands.
pub(crate) fn inside(operator: Operator, left: bool, right: bool) -> bool {
    match operator {
        Operator::Union => left || right,
        Operator::Intersection => left && right,
        Operator::Difference => left && !right,
    }
}

fn merge(operator: Operator, mut left: &[Edge], mut right: &[Edge], merged: &mut Vec<Edge>) {
    let (mut in_left, mut in_right, mut in_result) = (false, false, false);
    let first_t = |edges: &[Edge]| edges.first().map_or(f64::INFINITY, |edge| edge.t);
    while !(left.is_empty() && right.is_empty()) {
        let (left_t, right_t) = (first_t(left), first_t(right));
        let from_left = if left_t <= right_t { left.split_off_first() } else { None };
        let from_right = if right_t <= left_t { right.split_off_first() } else { None };
        in_left ^= from_left.is_some();
        in_right ^= from_right.is_some();
        let in_before = std::mem::replace(&mut in_result, inside(operator, in_left, in_right));
        if in_before == in_result {
            continue;
        }
        // The edge that changes the result in this direction. A boundary of what is subtracted has its outside where the
        // result has its inside.
        let fitting = from_left.filter(|_| in_left == in_result).copied();
        let turned = |edge: &Edge| match operator {
            Operator::Difference => Edge { normal: -edge.normal, ..*edge },
            Operator::Union | Operator::Intersection => *edge,
        };
        merged.extend(fitting.or_else(|| from_right.map(turned)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPERATORS: [Operator; 3] = [Operator::Union, Operator::Intersection, Operator::Difference];

    /// Edges at those t, of a solid whose primitive is `node`; the normals point against or along the line.
    fn list(node: usize, ts: &[f64]) -> Vec<Edge> {
        let edge = |(index, t): (usize, &f64)| Edge {
            t: *t,
            normal: DVec3::X * if index % 2 == 0 { -1.0 } else { 1.0 },
            surface: Surface::default(),
            node: NodeId::from_index(node),
            depth: 0,
            symbol: None,
        };
        ts.iter().enumerate().map(edge).collect()
    }

    fn combined(operator: Operator, left: &[f64], right: &[f64]) -> Vec<(f64, usize)> {
        let mut stack = SpanStack::default();
        for edges in [list(7, &[-1.0, 1.0]), list(0, left), list(1, right)] {
            stack.open();
            edges.into_iter().for_each(|edge| stack.push(edge));
        }
        stack.combine(operator);
        for (index, edge) in stack.top().iter().enumerate() {
            let outward = if index % 2 == 0 { -DVec3::X } else { DVec3::X };
            assert_eq!(edge.normal, outward);
        }
        let result = stack.top().iter().map(|edge| (edge.t, edge.node.index())).collect();
        stack.pop();
        assert_eq!(stack.top(), list(7, &[-1.0, 1.0]), "lists below are left alone");
        result
    }

    #[test]
    fn a_solid_with_itself() {
        let a = [1.0, 2.0, 4.0, 8.0];
        let all: Vec<_> = a.map(|t| (t, 0)).to_vec();
        assert_eq!(combined(Operator::Union, &a, &a), all);
        assert_eq!(combined(Operator::Intersection, &a, &a), all);
        assert_eq!(combined(Operator::Difference, &a, &a), []);
    }

    #[test]
    fn shared_faces_leave_no_skin() {
        assert_eq!(combined(Operator::Difference, &[0.0, 2.0], &[0.0, 1.0]), [(1.0, 1), (2.0, 0)]);
        assert_eq!(combined(Operator::Difference, &[0.0, 2.0], &[1.0, 2.0]), [(0.0, 0), (1.0, 1)]);
        assert_eq!(combined(Operator::Difference, &[0.0, 2.0], &[2.0, 3.0]), [(0.0, 0), (2.0, 0)]);
        assert_eq!(combined(Operator::Union, &[0.0, 1.0], &[1.0, 2.0]), [(0.0, 0), (2.0, 1)]);
        assert_eq!(combined(Operator::Intersection, &[0.0, 1.0], &[1.0, 2.0]), []);
    }

    #[test]
    fn unbounded_spans() {
        let below = [f64::NEG_INFINITY, 0.0];
        let all = [f64::NEG_INFINITY, f64::INFINITY];
        assert_eq!(combined(Operator::Difference, &[-1.0, 1.0], &below), [(0.0, 1), (1.0, 0)]);
        assert_eq!(combined(Operator::Intersection, &[-1.0, 1.0], &below), [(-1.0, 0), (0.0, 1)]);
        assert_eq!(combined(Operator::Intersection, &[-1.0, 1.0], &all), [(-1.0, 0), (1.0, 0)]);
        assert_eq!(combined(Operator::Difference, &[-1.0, 1.0], &all), []);
    }

    #[test]
    fn agrees_with_membership_of_points_for_all_small_lists() {
        // Every list of edges at 0, 1, … 5 is a subset of even size: all pairs of them, and all operators.
        let lists: Vec<Vec<f64>> = (0_u32..64)
            .filter(|set| set.count_ones() % 2 == 0)
            .map(|set| (0..6).filter(|t| set >> t & 1 == 1).map(f64::from).collect())
            .collect();
        let contains = |list: &[f64], x: f64| list.iter().filter(|t| **t < x).count() % 2 == 1;
        for operator in OPERATORS {
            for (left, right) in lists.iter().flat_map(|left| lists.iter().map(move |right| (left, right))) {
                let result: Vec<f64> = combined(operator, left, right).into_iter().map(|(t, _)| t).collect();
                for x in (0..6).map(|t| f64::from(t) + 0.5) {
                    let expected = inside(operator, contains(left, x), contains(right, x));
                    assert_eq!(contains(&result, x), expected, "{left:?} {operator:?} {right:?} at {x}");
                }
            }
        }
    }
}
