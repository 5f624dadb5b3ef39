//! Which states lead back to themselves: the strongly connected components of the state graph, each after those that
//! it leads to.
//!
//! Tarjan's algorithm [TARJ72], with an explicit path. Which states are below one is for the caller to say. For boxes, what
//! is subtracted does not count: the box of a difference is that of its left operand, so that a solid may lose smaller
//! copies of itself without being a part of itself.

use crate::narrow::index;

/// The components, as lists of states.
pub(crate) struct Components {
    states: Vec<u32>,
    ends: Vec<u32>,
}

impl Components {
    /// Of so many states, from those that each is made from.
    pub(crate) fn new<'a>(count: usize, below: impl Fn(u32) -> &'a [u32]) -> Self {
        const NEW: u32 = u32::MAX;
        const DONE: u32 = u32::MAX - 1;
        // When each state was entered, and the first entered of those that it is known to lead to.
        let (mut entered, mut lowest) = (vec![NEW; count], vec![NEW; count]);
        let mut found = Self { states: Vec::with_capacity(count), ends: Vec::new() };
        let mut clock = 0;
        // Those entered whose component is not complete, and the path with how many below each were looked at.
        let mut open: Vec<u32> = Vec::new();
        let mut path: Vec<(u32, usize)> = Vec::new();
        for start in 0..index(count) {
            let mut enter = (entered[start as usize] == NEW).then_some(start);
            loop {
                if let Some(state) = enter.take() {
                    (entered[state as usize], lowest[state as usize]) = (clock, clock);
                    clock += 1;
                    open.push(state);
                    path.push((state, 0));
                }
                let Some((state, looked_at)) = path.last_mut() else { break };
                let state = *state;
                if let Some(next) = below(state).get(*looked_at) {
                    *looked_at += 1;
                    match entered[*next as usize] {
                        NEW => enter = Some(*next),
                        DONE => {}
                        time => lowest[state as usize] = lowest[state as usize].min(time),
                    }
                    continue;
                }
                path.pop();
                let low = lowest[state as usize];
                if low == entered[state as usize] {
                    let first = open.iter().rposition(|member| *member == state).expect("it is open");
                    found.states.extend(open.drain(first..));
                    let start = found.ends.last().map_or(0, |end| *end as usize);
                    let component = &mut found.states[start..];
                    component.sort_unstable();
                    component.iter().for_each(|member| entered[*member as usize] = DONE);
                    found.ends.push(index(found.states.len()));
                }
                if let Some((above, _)) = path.last() {
                    lowest[*above as usize] = lowest[*above as usize].min(low);
                }
            }
        }
        found
    }

    /// Those that are a cycle and nothing else: one way round, and none out of it.
    pub(crate) fn single_ways<'a>(&self, below: impl Fn(u32) -> &'a [u32]) -> impl Iterator<Item = &[u32]> {
        self.iter().filter(move |component| {
            let stays = |below: &u32| component.binary_search(below).is_ok();
            let count = component.iter().map(|state| below(*state).len()).sum::<usize>();
            // As many ways as states, all of them back.
            count == component.len() && component.iter().flat_map(|state| below(*state)).all(stays)
        })
    }

    /// Each component, its states in the order of their numbers.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| &self.states[start as usize..*end as usize])
    }
}
