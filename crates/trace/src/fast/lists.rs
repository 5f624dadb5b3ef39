//! States written out as lists of instances, the largest by surface area opened first.
//!
//! A list ends where it is long enough. If all states are known, each where some list breaks off is opened likewise, once,
//! however many lists lead to it; this is the [whole](Lists::whole) of a graph. There, the instances of a state are opened
//! together if they can be: the fewer states lists break off at, the longer they may be. A [block](Lists::block) is one list
//! and those of the operands of its solids, and what it breaks off at is left for later.

use std::cmp::Ordering;
use std::collections::hash_map::Entry;
use std::collections::{BinaryHeap, VecDeque};
use std::mem;

use csg_graph::EvalError;
use csg_graph_bounds::Aabb;
use rustc_hash::{FxBuildHasher, FxHashMap};

use super::compiled::Solid;
use super::instance::Instance;
use super::states::{Kind, States};
use crate::narrow::index;

/// The least number of items that a list is opened to.
pub(super) const SHORTEST: usize = 8;

/// For so many items a list has room from the beginning.
const ROOM: usize = 64;

/// The lists of all super-nodes, the root's first.
pub(super) struct Lists {
    /// Each with the box that clips those of its instances.
    pub(super) lists: Vec<(Aabb, Vec<Instance>)>,
    /// The super-nodes of those states that have one.
    pub(super) supers: FxHashMap<u32, u32>,
    /// The solids of those states that have one.
    pub(super) numbers: FxHashMap<u32, u32>,
    pub(super) solids: Vec<Solid>,
    /// How many instances there are together.
    pub(super) total: usize,
    /// How many the lists that wait will have at least.
    due: usize,
    waiting: VecDeque<(Aabb, Vec<Instance>)>,
}

impl Lists {
    fn new(states: &States<'_>, root: &Instance) -> Self {
        let mut all = Self {
            lists: Vec::new(),
            supers: FxHashMap::default(),
            numbers: FxHashMap::default(),
            solids: Vec::new(),
            total: 0,
            due: 0,
            waiting: VecDeque::new(),
        };
        all.wait(states, Aabb::ALL, vec![root.clone()]);
        all
    }

    /// Opens all states that the root leads to into lists of that length, or gives up if they have more entries
    /// together than are affordable and could have fewer.
    pub(super) fn whole(
        states: &mut States<'_>,
        root: &Instance,
        length: usize,
        affordable: usize,
    ) -> Result<Option<Self>, EvalError> {
        let mut all = Self::new(states, root);
        while let Some((clip, start)) = all.go_on(states) {
            let list = open_alike(states, start, length)?;
            all.total += list.len();
            for instance in &list {
                match states.get(instance).kind {
                    Kind::Union(_) if !all.supers.contains_key(&instance.target) => {
                        all.supers.insert(instance.target, all.next());
                        all.wait(states, Aabb::ALL, vec![Instance::at(instance.target)]);
                    }
                    Kind::Solid(..) if !all.numbers.contains_key(&instance.target) => {
                        all.add_solid(states, instance.target)?;
                    }
                    _ => {}
                }
            }
            all.lists.push((clip, list));
            if all.total + all.due > affordable && length > SHORTEST {
                return Ok(None);
            }
        }
        Ok(Some(all))
    }

    /// Opens one state into a list of that length. The solids in it get lists for their operands while there are not more
    /// than twice as many instances together; if the state is one itself, in any case.
    pub(super) fn block(states: &mut States<'_>, root: &Instance, length: usize) -> Result<Self, EvalError> {
        let mut all = Self::new(states, root);
        while let Some((clip, start)) = all.go_on(states) {
            let list = open(states, start, if all.lists.is_empty() { length } else { length / 4 })?;
            all.total += list.len();
            for instance in &list {
                if states.is_primitive(instance) {
                    states.resolve(instance.target)?;
                } else if !states.is_union(instance)
                    && !all.numbers.contains_key(&instance.target)
                    && (all.total < 2 * length || instance.target == root.target)
                {
                    states.resolve(instance.target)?;
                    all.add_solid(states, instance.target)?;
                }
            }
            all.lists.push((clip, list));
        }
        Ok(all)
    }

    /// Which lists the root leads to through unions alone.
    pub(super) fn in_unions(&self) -> Vec<bool> {
        let mut found = vec![false; self.lists.len()];
        let mut open = vec![0];
        while let Some(number) = open.pop() {
            if !mem::replace(&mut found[number], true) {
                let (_, list) = &self.lists[number];
                let below = list.iter().filter_map(|instance| self.supers.get(&instance.target));
                open.extend(below.map(|number| *number as usize));
            }
        }
        found
    }

    /// Has instances opened later.
    fn wait(&mut self, states: &States<'_>, clip: Aabb, start: Vec<Instance>) {
        self.due += least(states, &start);
        self.waiting.push_back((clip, start));
    }

    /// The instances that have waited longest.
    fn go_on(&mut self, states: &States<'_>) -> Option<(Aabb, Vec<Instance>)> {
        let (clip, start) = self.waiting.pop_front()?;
        self.due -= least(states, &start);
        Some((clip, start))
    }

    /// The number of the next list that waits. The one in the making is not among the lists yet.
    fn next(&self) -> u32 {
        index(self.lists.len() + 1 + self.waiting.len())
    }

    /// Gives a solid a number, and its operands lists.
    fn add_solid(&mut self, states: &States<'_>, target: u32) -> Result<(), EvalError> {
        let solid = states.get(&Instance::at(target));
        let Kind::Solid(operator, operands) = &solid.kind else { unreachable!("a solid that is resolved") };
        self.numbers.insert(target, index(self.solids.len()));
        let first = self.next();
        self.solids.push(Solid { operator: *operator, operands: [first, first + 1] });
        let bounds = states.aabb(target)?;
        operands.iter().for_each(|parts| self.wait(states, bounds, parts.clone()));
        Ok(())
    }
}

/// How many instances there are at least when these are opened. One union alone is, and has two parts or more.
fn least(states: &States<'_>, start: &[Instance]) -> usize {
    match start {
        [instance] if states.is_union(instance) => 2,
        _ => start.len(),
    }
}

/// Opens the first union, and then others, the largest first, into a list of at most `length` instances.
fn open(states: &mut States<'_>, start: Vec<Instance>, length: usize) -> Result<Vec<Instance>, EvalError> {
    let (mut list, slots) = List::begin(states, start, length)?;
    let mut queue = BinaryHeap::new();
    for slot in slots {
        queue.extend(list.union_at(states, slot, length)?);
    }
    while list.count < length
        && let Some(Largest { at: slot, .. }) = queue.pop()
    {
        if list.count - 1 + states.part_count(list.instance(slot)) > length {
            continue;
        }
        for slot in list.open(states, slot)? {
            queue.extend(list.union_at(states, slot, length)?);
        }
    }
    Ok(list.in_order())
}

/// The same, but all instances of a state are opened with the largest of them, or none any more, once the list is half as long
/// as it may be. So lists break off at fewer states, each of which has one, and there is memory for longer ones.
fn open_alike(
    states: &mut States<'_>,
    start: Vec<Instance>,
    length: usize,
) -> Result<Vec<Instance>, EvalError> {
    let (mut list, mut slots) = List::begin(states, start, length)?;
    // The instances of each state; none of one at which the list breaks off.
    let mut alike: FxHashMap<u32, Option<Vec<Largest>>> = FxHashMap::default();
    let mut queue = BinaryHeap::new();
    loop {
        for slot in slots.drain(..) {
            let Some(union) = list.union_at(states, slot, length)? else { continue };
            let target = list.instance(slot).target;
            if let Some(unions) = alike.entry(target).or_insert_with(|| Some(Vec::new())) {
                unions.push(union);
                queue.push((union, target));
            }
        }
        if list.count >= length {
            break;
        }
        let Some((_, target)) = queue.pop() else { break };
        let Some(mut unions) = alike.get_mut(&target).and_then(Option::take) else { continue };
        let room = (length - list.count) / (states.part_count(&Instance::at(target)) - 1);
        if unions.len() <= room {
            alike.remove(&target);
        } else if 2 * list.count < length {
            unions.sort_unstable_by(|a, b| b.cmp(a));
            unions.truncate(room);
        } else {
            continue;
        }
        for union in unions {
            slots.extend(list.open(states, union.at)?);
        }
    }
    Ok(list.in_order())
}

/// A list in the making.
struct List {
    /// Each with the slot of the next one in the order of the graph. A slot is empty if all parts of what was there were known.
    slots: Vec<(Option<Instance>, Option<usize>)>,
    /// How many instances there are.
    count: usize,
    /// The slots of instances, by their fingerprints. One that coincides with another is left out: where recursion leads to
    /// the same place in several ways, rays would meet some times as many with each level.
    known: FxHashMap<u64, usize>,
}

impl List {
    /// The list of some instances, and their slots. One instance alone is opened in any case, or the list would lead to itself,
    /// and however large it is.
    fn begin(
        states: &mut States<'_>,
        start: Vec<Instance>,
        length: usize,
    ) -> Result<(Self, Vec<usize>), EvalError> {
        let room = start.len().max(length.min(ROOM));
        let known = FxHashMap::with_capacity_and_hasher(room, FxBuildHasher);
        let mut list = Self { slots: Vec::with_capacity(room), count: 0, known };
        for instance in start {
            if list.is_new(&instance, list.count) {
                list.slots.push((Some(instance), None));
                list.count += 1;
            }
        }
        let count = list.count;
        for (next, (_, link)) in (1..count).zip(&mut list.slots) {
            *link = Some(next);
        }
        let slots = match &list.slots[..] {
            [(Some(instance), _)] if states.is_union(instance) => list.open(states, 0)?.collect(),
            _ => (0..count).collect(),
        };
        Ok((list, slots))
    }

    /// Whether an instance coincides with none that is there. It is to be put into that slot then.
    fn is_new(&mut self, instance: &Instance, slot: usize) -> bool {
        match self.known.entry(instance.fingerprint()) {
            Entry::Vacant(entry) => {
                entry.insert(slot);
                true
            }
            Entry::Occupied(mut entry) => {
                let (known, _) = &self.slots[*entry.get()];
                let is_new = !known.as_ref().is_some_and(|known| known.coincides(instance));
                if is_new {
                    entry.insert(slot);
                }
                is_new
            }
        }
    }

    fn instance(&self, slot: usize) -> &Instance {
        self.slots[slot].0.as_ref().expect("a slot in use")
    }

    /// The instance in a slot, if it is a union of no more parts than a list may have.
    fn union_at(
        &self,
        states: &States<'_>,
        slot: usize,
        length: usize,
    ) -> Result<Option<Largest>, EvalError> {
        let instance = self.instance(slot);
        if !states.is_union(instance) || states.part_count(instance) > length {
            return Ok(None);
        }
        let bounds = states.aabb(instance.target)?.image(&instance.above_from_target);
        Ok(Some(Largest { area: bounds.surface_area(), at: slot }))
    }

    /// Replaces a union by those of its parts that are not there, and says in which slots they are. The first is in that of the
    /// union.
    fn open(
        &mut self,
        states: &mut States<'_>,
        slot: usize,
    ) -> Result<impl Iterator<Item = usize> + use<>, EvalError> {
        let (Some(instance), mut next) = mem::take(&mut self.slots[slot]) else {
            unreachable!("a slot in use")
        };
        let Kind::Union(parts) = states.resolve(instance.target)? else {
            unreachable!("only unions are opened")
        };
        let [first, others @ ..] = &parts[..] else { unreachable!("a union has parts") };
        let free = self.slots.len();
        for part in others.iter().rev().map(|part| instance.then(part)) {
            if self.is_new(&part, self.slots.len()) {
                self.slots.push((Some(part), next));
                next = Some(self.slots.len() - 1);
            }
        }
        let first = instance.then(first);
        let has_first = self.is_new(&first, slot);
        self.slots[slot] = (has_first.then_some(first), next);
        let others = free..self.slots.len();
        self.count = self.count - 1 + usize::from(has_first) + others.len();
        Ok(has_first.then_some(slot).into_iter().chain(others))
    }

    /// Its instances in the order of the graph.
    fn in_order(mut self) -> Vec<Instance> {
        let mut ordered = Vec::with_capacity(self.count);
        let mut at = (!self.slots.is_empty()).then_some(0);
        while let Some(slot) = at {
            let (instance, next) = mem::take(&mut self.slots[slot]);
            ordered.extend(instance);
            at = next;
        }
        ordered
    }
}

/// A union that can be opened, by its surface area.
#[derive(Clone, Copy)]
pub(super) struct Largest {
    pub(super) area: f64,
    pub(super) at: usize,
}

impl Ord for Largest {
    fn cmp(&self, other: &Self) -> Ordering {
        self.area.total_cmp(&other.area).then(other.at.cmp(&self.at))
    }
}

impl PartialOrd for Largest {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Largest {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Largest {}
