//! Typed handles: a node and a parameter of a graph.
//!
//! Handles are made by a [`GraphBuilder`](crate::GraphBuilder) and validated once, when the graph is finished;
//! after that they index freely.

use std::fmt;

/// A node of a [`Graph`](crate::Graph).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(u32);

/// A parameter of a [`Graph`](crate::Graph).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ParamId(u32);

macro_rules! handle {
    ($name:ident, $letter:literal) => {
        impl $name {
            /// The handle of position `index` in its arena.
            ///
            /// # Panics
            /// If `index` does not fit 32 bits.
            pub fn from_index(index: usize) -> Self {
                Self(u32::try_from(index).expect("an arena of at most 2^32 entries"))
            }

            /// The position in its arena, from 0 without gaps.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!($letter, "{}"), self.0)
            }
        }
    };
}

handle!(NodeId, "n");
handle!(ParamId, "p");
