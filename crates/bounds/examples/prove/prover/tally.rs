//! What trials found, as a table and as reports that say how to find it again.

use std::fmt;

use glam::DVec3;

use super::enclosure::{Enclosure, KINDS, Kind};

/// What the trials of a run found.
#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) graphs: u64,
    pub(crate) states: u64,
    /// The most T-nodes on a path.
    pub(crate) height: usize,
    /// Points on surfaces.
    pub(crate) points: u64,
    /// Of each kind of volume, how many there were, and how many points were checked against them.
    pub(crate) volumes: [u64; KINDS.len()],
    pub(crate) checks: [u64; KINDS.len()],
    pub(crate) escapes: Vec<Escape>,
}

/// A point of a solid outside of its volume.
pub(crate) struct Escape {
    pub(crate) seed: u64,
    pub(crate) graph: u64,
    pub(crate) kind: Kind,
    pub(crate) state: String,
    pub(crate) point: DVec3,
    /// By at least how much it is outside.
    pub(crate) excess: f64,
    pub(crate) enclosure: Enclosure,
}

impl Tally {
    pub(crate) fn add(&mut self, other: Self) {
        self.graphs += other.graphs;
        self.states += other.states;
        self.height = self.height.max(other.height);
        self.points += other.points;
        for kind in 0..KINDS.len() {
            self.volumes[kind] += other.volumes[kind];
            self.checks[kind] += other.checks[kind];
        }
        self.escapes.extend(other.escapes);
    }

    /// How many points escaped from a kind of volume.
    pub(crate) fn escapes_of(&self, kind: usize) -> usize {
        self.escapes.iter().filter(|escape| escape.kind.0 == kind).count()
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { graphs, states, height, points, .. } = self;
        writeln!(
            f,
            "{graphs} graphs, {states} states, up to {height} T-nodes deep, {points} surface points"
        )?;
        writeln!(f, "{:<28} {:>10} {:>14} {:>8}", "", "volumes", "checks", "escapes")?;
        for (kind, name) in KINDS.iter().enumerate() {
            let (volumes, checks, escapes) = (self.volumes[kind], self.checks[kind], self.escapes_of(kind));
            writeln!(f, "{name:<28} {volumes:>10} {checks:>14} {escapes:>8}")?;
        }
        let [volumes, checks] = [&self.volumes, &self.checks].map(|counts| counts.iter().sum::<u64>());
        write!(f, "{:<28} {volumes:>10} {checks:>14} {:>8}", "all", self.escapes.len())
    }
}

impl fmt::Display for Escape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { seed, graph, kind, state, point, excess, enclosure } = self;
        writeln!(
            f,
            "--seed {seed} --graph {graph}: {state}: {} cuts off {point:?} by {excess:e}",
            KINDS[kind.0]
        )?;
        write!(f, "{enclosure:?}")
    }
}
