//! The way down of a question: which keys are visited, and with which intervals.
//!
//! Keys that several ways lead to are visited each after all that lead into them: the intervals of its parameters are their
//! join. Whatever is between two of these is a tree, where nothing has to be joined or looked up: a visit takes all of it
//! at once and lists its *parts*, where the tree ends, each with the chain of maps on its way.
//!
//! Where keys lead back to themselves, each time round is a round of its own: (key, round) takes the place of the key. There
//! is no way from one round to another but the next.

use std::ops::Range;

use csg_graph::{Interval, PrimitiveKind};

use crate::envelope::keys::{Keys, Look};
use crate::envelope::transform::{Chain, MapRange};
use crate::narrow::index;

/// The most keys that a question visits, some ten nanoseconds each.
pub(super) const KEYS: usize = 4096;

/// The most times that it goes round.
const ROUNDS: u32 = 64;

/// All visits of a question. What it has allocated serves the next question.
#[derive(Default)]
pub(super) struct Plan {
    visits: Vec<Visit>,
    /// The intervals of the varying parameters of all visits.
    intervals: Vec<Interval>,
    /// The visits in the order in which they were made, each before those of its parts.
    made: Vec<u32>,
    parts: Vec<Part>,
    links: Vec<Link>,
    maps: Vec<MapRange>,
    measures: Vec<Interval>,
    /// Visits of keys that no other way leads to, which may be made at once.
    waiting: Vec<u32>,
    /// Those of this round, and those of the next.
    rounds: [Round; 2],
    tree: Tree,
    keys: usize,
}

/// A visit of a key.
struct Visit {
    key: u32,
    round: u32,
    meets: bool,
    parts: Range<usize>,
}

/// Where a tree ends.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub(super) source: Source,
    /// The innermost map of its chain.
    pub(super) link: Option<u32>,
}

/// Where the envelope of a part comes from.
#[derive(Clone, Copy)]
pub(super) enum Source {
    /// What is known of that key in general.
    General(u32),
    /// The visit of that number.
    Visit(u32),
    /// The known solid of that number.
    Solid(u32),
    /// So many measures from there on.
    Primitive(PrimitiveKind, usize, usize),
}

/// A map, and what is above it in its chain.
#[derive(Clone, Copy)]
struct Link {
    map: Number,
    above: Option<u32>,
    /// The number of maps down to this, and that of directions that they make of one.
    sizes: [usize; 2],
    /// Whether boxes stay boxes under all of them.
    straight: bool,
}

/// The number of maps that were known before, or are of this question.
#[derive(Clone, Copy)]
enum Number {
    Known(u32),
    Made(u32),
}

/// The part of a tree that is still to be looked at, and the values there.
#[derive(Default)]
struct Tree {
    open: Vec<Branch>,
    /// The intervals of the varying parameters, frame by frame.
    frames: Vec<Interval>,
    /// The number of these parameters.
    size: usize,
}

#[derive(Clone, Copy)]
struct Branch {
    key: u32,
    link: Option<u32>,
    frame: usize,
    /// Whether nobody else will look at the values.
    last: bool,
}

/// Visits that wait for other ways into their keys.
#[derive(Default)]
struct Round {
    /// A bit for each key.
    waiting: Vec<u64>,
    /// No word behind this one has any bits.
    highest: usize,
    /// By key.
    visits: Vec<u32>,
}

impl Plan {
    /// Plans the question for a key whose varying parameters are in these intervals: visit 0.
    pub(super) fn make(&mut self, keys: &Keys, key: u32, varying: impl Iterator<Item = Interval>) {
        self.visits.clear();
        self.intervals.clear();
        self.made.clear();
        self.parts.clear();
        self.links.clear();
        self.maps.clear();
        self.measures.clear();
        self.rounds.iter_mut().for_each(|round| round.prepare(keys.len()));
        self.keys = 1;
        self.intervals.extend(varying);
        let mut next = Some(self.add(0, key));
        while let Some(visit) = next {
            self.visit(keys, visit);
            next = self.waiting.pop().or_else(|| self.rounds[0].pop()).or_else(|| {
                self.rounds.swap(0, 1);
                self.rounds[0].pop()
            });
        }
    }

    /// A visit whose intervals are the last.
    fn add(&mut self, round: u32, key: u32) -> u32 {
        self.visits.push(Visit { key, round, meets: false, parts: 0..0 });
        index(self.visits.len() - 1)
    }

    /// Lists the parts of a visit.
    fn visit(&mut self, keys: &Keys, number: u32) {
        let Visit { key, round, .. } = self.visits[number as usize];
        let size = keys.control().varying().len();
        self.tree.size = size;
        self.tree.frames.clear();
        self.tree.frames.extend_from_slice(&self.intervals[number as usize * size..][..size]);
        let start = self.parts.len();
        self.tree.open.push(Branch { key, link: None, frame: 0, last: true });
        while let Some(mut branch) = self.tree.open.pop() {
            self.tree.frames.truncate((branch.frame + 1) * size);
            if keys.changes(branch.key) && !branch.last {
                self.tree.frames.extend_from_within(branch.frame * size..);
                branch = Branch { frame: branch.frame + 1, last: true, ..branch };
            }
            let values = &mut self.tree.frames[branch.frame * size..];
            let (look, below) = keys.look(branch.key, values);
            let below = &keys.below(branch.key)[below];
            match look {
                // Below many directions it is cheaper to have all parts in one.
                Look::Join if below.len() > 1 && self.sizes(branch.link)[1] > 1 => {
                    self.alone(keys, round, branch);
                }
                Look::Join => self.follow(keys, round, branch, below),
                Look::Left => self.follow(keys, round, branch, &below[..1]),
                Look::Meet if branch.key == key && branch.link.is_none() => {
                    self.visits[number as usize].meets = true;
                    for operand in below {
                        let operand = Branch { key: *operand, ..branch };
                        if !self.outside(keys, round, key, operand) {
                            self.keys += 1;
                            self.alone(keys, round, operand);
                        }
                    }
                }
                Look::Meet => self.alone(keys, round, branch),
                Look::Solid(solid) => self.end(Source::Solid(solid), branch.link),
                Look::Primitive(kind, args) => {
                    let from = self.measures.len();
                    let values = self.tree.values(branch.frame);
                    self.measures.extend(args.iter().map(|arg| arg.range(values)));
                    self.end(Source::Primitive(kind, from, args.len()), branch.link);
                }
                Look::Map(map) => match self.link(branch.link, Number::Known(map), keys.map(map)) {
                    link @ Some(_) => self.follow(keys, round, Branch { link, ..branch }, below),
                    None => self.alone(keys, round, branch),
                },
                Look::Transform(kind, args) => {
                    let values = self.tree.values(branch.frame);
                    let args: Vec<Interval> = args.iter().map(|arg| arg.range(values)).collect();
                    let Some(map) = MapRange::new(kind, &args) else { continue };
                    match self.link(branch.link, Number::Made(index(self.maps.len())), &map) {
                        link @ Some(_) => {
                            self.maps.push(map);
                            self.follow(keys, round, Branch { link, ..branch }, below);
                        }
                        None => self.alone(keys, round, branch),
                    }
                }
            }
        }
        self.visits[number as usize].parts = start..self.parts.len();
        self.made.push(number);
    }

    /// Goes on to keys below a key, whose values the branch has.
    fn follow(&mut self, keys: &Keys, round: u32, branch: Branch, below: &[u32]) {
        for (position, part) in below.iter().enumerate() {
            // The first is looked at last.
            let part = Branch { key: *part, last: branch.last && position == 0, ..branch };
            if !self.outside(keys, round, branch.key, part) {
                self.keys += 1;
                self.tree.open.push(part);
            }
        }
    }

    /// Ends the tree before a key, if it is no part of it.
    fn outside(
        &mut self,
        keys: &Keys,
        round: u32,
        above: u32,
        Branch { key, link, frame, .. }: Branch,
    ) -> bool {
        let again = key >= above;
        let planned = keys.is_shared(key).then(|| self.rounds[usize::from(again)].get(key));
        let round = if again { round + 1 } else { round };
        let source = match planned {
            _ if !keys.varies(key) || round == ROUNDS => Source::General(key),
            Some(Some(visit)) => {
                let size = keys.control().varying().len();
                let known = &mut self.intervals[visit as usize * size..][..size];
                let new = keys.varying(key, self.tree.values(frame));
                known.iter_mut().zip(new).for_each(|(known, new)| *known = known.join(new));
                Source::Visit(visit)
            }
            _ if self.keys >= KEYS => Source::General(key),
            Some(None) => {
                self.keys += 1;
                self.intervals.extend(keys.varying(key, self.tree.values(frame)));
                let visit = self.add(round, key);
                self.rounds[usize::from(again)].insert(key, visit);
                Source::Visit(visit)
            }
            None => return false,
        };
        self.end(source, link);
        true
    }

    /// Ends the tree before a key that becomes the root of another one.
    fn alone(&mut self, keys: &Keys, round: u32, Branch { key, link, frame, .. }: Branch) {
        self.intervals.extend(keys.varying(key, self.tree.values(frame)));
        let visit = self.add(round, key);
        self.waiting.push(visit);
        self.end(Source::Visit(visit), link);
    }

    fn end(&mut self, source: Source, link: Option<u32>) {
        self.parts.push(Part { source, link });
    }

    /// Appends a map to a chain, unless it becomes too expensive.
    fn link(&mut self, above: Option<u32>, map: Number, maps: &MapRange) -> Option<u32> {
        let sizes = Chain::longer(self.sizes(above), maps)?;
        let straight = maps.is_straight() && self.is_straight(above);
        self.links.push(Link { map, above, sizes, straight });
        Some(index(self.links.len() - 1))
    }

    /// The number of maps in a chain, and that of directions that they make of one.
    fn sizes(&self, link: Option<u32>) -> [usize; 2] {
        link.map_or([0, 1], |link| self.links[link as usize].sizes)
    }

    /// Whether boxes stay boxes under a chain.
    pub(super) fn is_straight(&self, link: Option<u32>) -> bool {
        link.is_none_or(|link| self.links[link as usize].straight)
    }

    /// The maps of a chain, the innermost first.
    pub(super) fn maps<'a>(
        &'a self,
        keys: &'a Keys,
        link: Option<u32>,
    ) -> impl Iterator<Item = &'a MapRange> {
        let links = std::iter::successors(link, |link| self.links[*link as usize].above);
        links.map(|link| match self.links[link as usize].map {
            Number::Known(map) => keys.map(map),
            Number::Made(map) => &self.maps[map as usize],
        })
    }

    /// The maps of a chain, the outermost first.
    pub(super) fn chain<'a>(&'a self, keys: &'a Keys, link: Option<u32>) -> Vec<&'a MapRange> {
        let mut maps: Vec<_> = self.maps(keys, link).collect();
        maps.reverse();
        maps
    }

    /// The visits in the order in which they were made, each before those of its parts.
    pub(super) fn made(&self) -> &[u32] {
        &self.made
    }

    /// The parts of a visit, and whether its envelope is what they have in common.
    pub(super) fn parts(&self, visit: u32) -> (&[Part], bool) {
        let Visit { parts, meets, .. } = &self.visits[visit as usize];
        (&self.parts[parts.clone()], *meets)
    }

    pub(super) fn measures(&self, from: usize, count: usize) -> &[Interval] {
        &self.measures[from..from + count]
    }
}

impl Tree {
    fn values(&self, frame: usize) -> &[Interval] {
        &self.frames[frame * self.size..][..self.size]
    }
}

impl Round {
    fn prepare(&mut self, keys: usize) {
        if self.visits.len() < keys {
            self.visits.resize(keys, 0);
            self.waiting.resize(keys.div_ceil(64), 0);
        }
    }

    /// The visit of a key that waits.
    fn get(&self, key: u32) -> Option<u32> {
        let waits = self.waiting[key as usize / 64] >> (key % 64) & 1 == 1;
        waits.then(|| self.visits[key as usize])
    }

    fn insert(&mut self, key: u32, visit: u32) {
        let word = key as usize / 64;
        self.waiting[word] |= 1 << (key % 64);
        self.highest = self.highest.max(word);
        self.visits[key as usize] = visit;
    }

    /// The visit with the highest key.
    fn pop(&mut self) -> Option<u32> {
        loop {
            let word = &mut self.waiting[self.highest];
            if let Some(bit) = word.checked_ilog2() {
                *word ^= 1 << bit;
                return Some(self.visits[64 * self.highest + bit as usize]);
            }
            self.highest = self.highest.checked_sub(1)?;
        }
    }
}
