//! A look ahead: closer boxes for gates.
//!
//! The envelope of a state by chance holds whatever its random numbers may turn out to be, and rays pass it in vain more often
//! than a box of what is there. But the numbers of a state are drawn as soon as somebody looks, and the envelopes of its
//! parts, joined where these are, are much closer. So the state behind a gate is opened a little for the sake of its box,
//! the largest part first, and forgotten again: what is kept of it is as much as before. Nothing but boxes comes of it,
//! so that neither the maps back nor the paint are followed, and no state gets a number.

use std::collections::BinaryHeap;

use csg_graph::{EvalError, Node, Operator, State, Step};
use csg_graph_bounds::Aabb;
use glam::DAffine3;

use super::instance::Instance;
use super::lists::Largest;
use super::states::States;

/// The most nodes from one part to the next. One that is farther is not looked for.
const FARTHEST: usize = 1 << 10;

/// An instance of a state behind a gate, seen from above the gate.
struct Behind {
    state: State,
    above_from_state: DAffine3,
    bounds: Aabb,
}

/// The instances that are known, and those that can be opened.
struct Ahead<'a> {
    states: &'a States<'a>,
    instances: Vec<Behind>,
    open: BinaryHeap<Largest>,
    /// About all that cannot be opened.
    closed: Aabb,
}

impl States<'_> {
    /// A box of a union in the frame above, that of what it is when it is opened to `length` parts: all of space if
    /// it has more, and none if something is wrong with it, which is said when a ray comes to it.
    pub(super) fn box_ahead(&self, instance: &Instance, length: usize) -> Option<Aabb> {
        let root = Behind {
            state: self.get(instance).state.clone(),
            above_from_state: instance.above_from_target,
            bounds: Aabb::ALL,
        };
        let mut ahead =
            Ahead { states: self, instances: Vec::new(), open: BinaryHeap::new(), closed: Aabb::EMPTY };
        ahead.add(root);
        let (mut all, mut count) = (Aabb::EMPTY, 1);
        while let Some(Largest { at, .. }) = ahead.open.pop() {
            let more = self.unions.parts(ahead.instances[at].state.node()) - 1;
            if count + more > length {
                all = all.join(ahead.instances[at].bounds);
            } else {
                count += more;
                ahead.take_apart(at).ok()??;
            }
        }
        Some(all.join(ahead.closed))
    }
}

impl Ahead<'_> {
    fn add(&mut self, instance: Behind) {
        if self.states.is_operator_at(&instance.state, Operator::Union) {
            self.open.push(Largest { area: instance.bounds.surface_area(), at: self.instances.len() });
            self.instances.push(instance);
        } else {
            self.closed = self.closed.join(instance.bounds);
        }
    }

    /// Adds the parts of a union, those of unions in the same rule among them, unless one is too far.
    fn take_apart(&mut self, at: usize) -> Result<Option<()>, EvalError> {
        let States { graph, unions, bounds, .. } = self.states;
        let Behind { state, above_from_state, .. } = &self.instances[at];
        let mut below = vec![(*above_from_state, state.clone(), false)];
        let mut is_first = true;
        while let Some((mut above_from_state, mut state, mut is_in_other_rule)) = below.pop() {
            let mut steps = 0;
            loop {
                let node = state.node();
                let is_written_out = is_first || !is_in_other_rule && unions.is_written_out(node);
                if matches!(graph.node(node), Node::Operator(_))
                    && !(self.states.is_operator_at(&state, Operator::Union) && is_written_out)
                {
                    let extent = bounds.of(&state)?;
                    let bounds = bounds.image(&state, &extent, None, &above_from_state);
                    self.add(Behind { state, above_from_state, bounds });
                    break;
                }
                state = match graph.step(&state)? {
                    _ if steps == FARTHEST => return Ok(None),
                    Step::Select(state) => {
                        is_in_other_rule = true;
                        state
                    }
                    Step::Calculate(state) | Step::Attribute(_, state) => state,
                    Step::Transform(parent_from_child, state) => {
                        above_from_state *= parent_from_child.to_affine();
                        state
                    }
                    Step::Operator(_, [left, right]) => {
                        below.push((above_from_state, right, is_in_other_rule));
                        left
                    }
                    Step::Primitive(primitive) => {
                        let extent = bounds.of(&state)?;
                        let found = bounds.image(&state, &extent, Some(&primitive), &above_from_state);
                        self.closed = self.closed.join(found);
                        break;
                    }
                    other => unreachable!("{other:?} was followed"),
                };
                is_first = false;
                steps += 1;
            }
        }
        Ok(Some(()))
    }
}

#[cfg(test)]
mod tests {
    use csg_graph_bounds::{Envelopes, Limits, exact};

    use super::super::bounds::Bounds;
    use super::super::unions::Unions;
    use super::*;

    /// A tree that is seen from aside, with a solid in it and a union that is in a definition of its own.
    const TREE: &str = "{ n = 6; } ASIDE
        ASIDE -> rotx(20) rotz(30) (TREE | move(0, 0, 0.5) uscale(0.05) (cube \\ sphere))
        TREE if(n > 0, 2, 1)
        1: TREE -> sphere
        2: TREE -> scale(0.1, 0.1, 1) (cylinder | cone) | {n = n - 1} move(0, 0, 1) uscale(rand(0.5, 0.9))
                   (rotx(rand(10, 60)) TREE | rotx(rand(-60, -10)) TREE)";

    #[test]
    fn boxes_come_closer_and_cut_nothing_off() {
        for seed in 0..20 {
            let graph =
                csg_graph_grammar::load(&TREE.replace("n = 6;", &format!("n = 6; seed = {seed};")), &[])
                    .expect("a scene")
                    .scene
                    .graph;
            let (unions, limits) = (Unions::new(&graph), Limits::default());
            let least = exact(&graph, &limits).expect("boxes").root;
            let size = least.min.abs().max(least.max.abs()).max_element();
            let envelopes = Envelopes::new(graph.clone(), &limits);
            let mut states = States::new(&graph, &unions, Bounds::Envelopes(&envelopes), 0);
            let root = states.instance(graph.root_state()).expect("a root");
            let outer = states.exact_box(&root).expect("a box");
            for length in [2, 16, 10_000] {
                let found = states.box_ahead(&root, length).expect("parts");
                let grown = Aabb::new(found.min - 1e-9 * size, found.max + 1e-9 * size);
                assert!(grown.encloses(least), "{length}: {found:?} {least:?}");
                if length > 2 {
                    assert!(
                        found.surface_area() < 0.9 * outer.surface_area(),
                        "{length}: {found:?} {outer:?}"
                    );
                }
                if length == 10_000 {
                    let off = (found.min - least.min).abs().max((found.max - least.max).abs());
                    assert!(off.max_element() <= 1e-9 * size, "{found:?} {least:?}");
                }
            }
            assert_eq!(states.box_ahead(&root, 1), Some(Aabb::ALL));
        }
    }

    #[test]
    fn what_is_wrong_behind_a_gate_is_not_said_by_its_box() {
        let source = "{ n = 3; } BAD
            BAD if(n > 0, 2, 1)
            1: BAD -> uscale(0 * rand(0, 1)) sphere
            2: BAD -> {n = n - 1} (move(rand(0, 1), 0, 0) BAD | sphere)";
        let graph = csg_graph_grammar::load(source, &[]).expect("a scene").scene.graph;
        let (unions, limits) = (Unions::new(&graph), Limits::default());
        let envelopes = Envelopes::new(graph.clone(), &limits);
        let mut states = States::new(&graph, &unions, Bounds::Envelopes(&envelopes), 0);
        let root = states.instance(graph.root_state()).expect("a root");
        assert!(states.box_ahead(&root, 2).is_some());
        assert!(states.box_ahead(&root, 100).is_none());
    }
}
