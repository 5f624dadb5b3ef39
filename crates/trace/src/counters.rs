//! What tracing cost, in counts that do not depend on the machine.

use std::ops::AddAssign;

/// Counts over some rays. Those of a whole picture are sums over its tiles, the same for any number of threads. The compiled
/// engine counts rays and tests, and its boxes are those of its own trees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Rays asked for their nearest hit.
    pub rays: u64,
    /// Rays asked whether anything is in the way.
    pub shadow_rays: u64,
    /// Nodes that a ray came to; each has its box tested first, if there are boxes.
    pub nodes_visited: u64,
    /// Rays tested against boxes.
    pub box_tests: u64,
    /// Those tests that ended a branch.
    pub boxes_missed: u64,
    /// Rays tested against primitives.
    pub primitive_tests: u64,
    /// The most S-nodes on a path that a ray went down.
    pub deepest_recursion: u32,
}

impl Counters {
    /// Tests of boxes and primitives: the bulk of the work.
    pub fn tests(&self) -> u64 {
        self.box_tests + self.primitive_tests
    }
}

impl AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
        self.nodes_visited += other.nodes_visited;
        self.box_tests += other.box_tests;
        self.boxes_missed += other.boxes_missed;
        self.primitive_tests += other.primitive_tests;
        self.deepest_recursion = self.deepest_recursion.max(other.deepest_recursion);
    }
}
