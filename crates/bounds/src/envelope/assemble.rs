//! How the envelope of a key comes from those below it.

use std::borrow::Cow;

use super::body::Body;
use super::general::{Failure, Known};
use super::transform::{Chain, MapRange};

/// How the solid of a key is made of its parts.
#[derive(Clone, Debug)]
pub(super) enum Make<'a> {
    /// It has no parts.
    Solid(Cow<'a, Body>),
    Map(Cow<'a, MapRange>),
    /// The union of any number of parts.
    Join,
    Meet,
    /// The left operand of a difference, which is the first part.
    Left,
}

/// How many nodes a chain of transformations may pass.
const CHAIN: usize = 32;

/// The envelope of what is made like this of such parts.
///
/// `look` says how a part is made itself, if that is known; `known` is its envelope. A part without an envelope bounds
/// nothing, but an intersection with it may be bounded.
pub(super) fn assemble<'a, 'k, P: Copy + 'a>(
    make: &'a Make<'a>,
    parts: &'a [P],
    look: impl Fn(P) -> Option<(&'a Make<'a>, &'a [P])>,
    known: impl Fn(P) -> Result<&'k Body, &'k Failure>,
) -> Known {
    match (make, parts) {
        (Make::Solid(solid), _) => Ok(**solid),
        (Make::Map(map), [part, ..]) => {
            let (chain, part) = chain(map, *part, look);
            known(part).map(|below| chain.image(below)).map_err(Failure::clone)
        }
        (Make::Left, [left, ..]) => known(*left).copied().map_err(Failure::clone),
        (Make::Meet, [left, right, ..]) => match (known(*left), known(*right)) {
            (Ok(left), Ok(right)) => Ok(left.intersect(*right)),
            (Ok(one), Err(_)) | (Err(_), Ok(one)) => Ok(*one),
            (Err(failure), Err(_)) => Err(failure.clone()),
        },
        (Make::Join, parts) => {
            let all = parts.iter().try_fold(Body::EMPTY, |all, part| Ok(all.join(*known(*part)?)));
            all.map_err(Failure::clone)
        }
        // What has no parts is nothing.
        _ => Ok(Body::EMPTY),
    }
}

/// All transformations from a map down to what is none, and that.
fn chain<'a, P: Copy + 'a>(
    map: &'a MapRange,
    mut part: P,
    look: impl Fn(P) -> Option<(&'a Make<'a>, &'a [P])>,
) -> (Chain<'a>, P) {
    let mut chain = Chain::default();
    chain.push(map);
    for _ in 0..CHAIN {
        match look(part) {
            Some((Make::Map(map), [below, ..])) if chain.push(map) => part = *below,
            Some((Make::Join, [only])) => part = *only,
            _ => break,
        }
    }
    (chain, part)
}
