//! How a key is made of those below it, once the intervals of the varying parameters are known.

use std::borrow::Cow;
use std::ops::Range;

use csg_graph::{Interval, PrimitiveKind, Residual, TransformKind};

use super::{KeyNode, Keys, Kind};
use crate::envelope::assemble::Make;
use crate::envelope::primitive;
use crate::envelope::transform::MapRange;

/// How a key is made of those below it, where what varies is not put in yet.
#[derive(Clone, Copy)]
pub(in crate::envelope) enum Look<'a> {
    /// The union of any number of parts.
    Join,
    Meet,
    /// The left operand of a difference, which is the first part.
    Left,
    /// The number of a known solid, or of known maps.
    Solid(u32),
    Map(u32),
    /// Of measures and arguments that vary.
    Primitive(PrimitiveKind, &'a [Residual]),
    Transform(TransformKind, &'a [Residual]),
}

impl Keys {
    /// How a key is made, and of which of [those below](Self::below) it, by their positions. The intervals of the varying
    /// parameters become those that are seen below.
    pub(in crate::envelope) fn look(&self, key: u32, varying: &mut [Interval]) -> (Look<'_>, Range<usize>) {
        let KeyNode { kind, below, residuals } = &self.nodes[key as usize];
        let places = residuals.start as usize..residuals.end as usize;
        let residuals = &self.residuals[places.clone()];
        let below = 0..below.len();
        match *kind {
            Kind::Join => (Look::Join, below),
            Kind::Meet => (Look::Meet, below),
            Kind::Difference => (Look::Left, below),
            Kind::Solid(number) => (Look::Solid(number), below),
            Kind::Map(number) => (Look::Map(number), below),
            Kind::Choose => {
                let value = residuals.first().map_or(Interval::point(1.0), |value| value.range(varying));
                (Look::Join, rules(value, below.len()))
            }
            Kind::Calculate => {
                for (target, residual) in self.targets[places].iter().zip(residuals) {
                    varying[*target] = residual.range(varying);
                }
                (Look::Join, below)
            }
            Kind::Transform(kind) => (Look::Transform(kind, residuals), below),
            Kind::Primitive(kind) => (Look::Primitive(kind, residuals), below),
        }
    }

    /// As [`look`](Self::look), with what varies.
    pub(in crate::envelope) fn make(&self, key: u32, varying: &mut [Interval]) -> (Make<'_>, Range<usize>) {
        let (look, below) = self.look(key, varying);
        let ranges = |left: &[Residual]| left.iter().map(|left| left.range(varying)).collect::<Vec<_>>();
        let make = match look {
            Look::Join => Make::Join,
            Look::Meet => Make::Meet,
            Look::Left => Make::Left,
            Look::Solid(number) => Make::Solid(Cow::Borrowed(self.solid(number))),
            Look::Map(number) => Make::Map(Cow::Borrowed(self.map(number))),
            Look::Primitive(kind, args) => Make::Solid(Cow::Owned(primitive::body(kind, &ranges(args)))),
            Look::Transform(kind, args) => match MapRange::new(kind, &ranges(args)) {
                Some(maps) => Make::Map(Cow::Owned(maps)),
                None => return (Make::Join, 0..0),
            },
        };
        (make, below)
    }
}

/// The positions of the rules that a selection in an interval may name.
pub(super) fn rules(selection: Interval, count: usize) -> Range<usize> {
    let mut named = (1_u32..).take(count).map(|number| selection.contains(number.into()));
    named
        .position(|named| named)
        .map_or(0..0, |first| first..first + 1 + named.take_while(|named| *named).count())
}
