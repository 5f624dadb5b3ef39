//! Envelopes of keys that lead back to themselves: guessed, and verified.
//!
//! Let F take envelopes of such keys to those of what the keys are made of, once round. F is monotone, and F(X) ⊆ X says
//! that whatever is unfolded to any depth stays in X: by induction from nothing. If all of F(X) is strictly within X, so is
//! the attractor of a recursion that never ends [HUTC81]: its maps take X into the inside of X, so that they contract in the
//! norm that X is the unit ball of.
//!
//! A good X is a little larger than the least fixed point. That is found from below, by rounds of F from nothing; where
//! nothing comes of nothing, since no way leads out of the recursion, from a point. Then *ε-inflation* [RUMP99]: enlarge a
//! little, apply F, and see whether the image lies within; if not, go on from the image. Whenever maps shrink at their
//! extremes this ends. What is found is tightened by some more rounds of F.

use super::assemble::assemble;
use super::body::Body;
use super::general::{Failure, Known, Recipe};
use super::keys::Keys;
use crate::{Round, Slabs, Volume};

/// Rounds from below, of inflation, and of tightening.
const ROUNDS: [usize; 3] = [200, 60, 200];

/// Changes of less than this share of the extent are none.
const SETTLED: f64 = 1e-9;

/// By which share of its extent a guess is enlarged.
const INFLATION: f64 = 0.02;

/// Finds the envelopes of a component of keys, in the order of their numbers, from those below it.
pub(super) fn solve(keys: &Keys, component: &[u32], recipes: &[Recipe<'_>], known: &mut [Known]) {
    let look = |key: u32| {
        let (make, below) = &recipes[key as usize];
        Some((make, &keys.below(key)[below.clone()]))
    };
    let round = |known: &mut [Known]| -> Result<(), Failure> {
        for key in component {
            let Some((make, parts)) = look(*key) else { continue };
            known[*key as usize] = Ok(assemble(make, parts, look, |part| known[part as usize].as_ref())?);
        }
        Ok(())
    };
    let inside = |key: &u32| component.binary_search(key).is_ok();
    let recursive = component.iter().any(|key| keys.parts(*key).iter().any(inside));
    let solved = if recursive { fixed_point(component, known, round) } else { round(known) };
    let solved = solved.map_err(|failure| match failure.cycle {
        cycle if cycle.is_empty() => Failure { cycle: cycle_of(keys, component), ..failure },
        cycle => Failure { cycle, ..failure },
    });
    if let Err(failure) = solved {
        component.iter().for_each(|key| known[*key as usize] = Err(failure.clone()));
    }
}

/// Iterates; what is left in `known` for the component is verified.
fn fixed_point(
    component: &[u32],
    known: &mut [Known],
    round: impl Fn(&mut [Known]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let get = |known: &[Known]| -> Vec<Body> {
        component.iter().map(|key| known[*key as usize].clone().unwrap_or(Body::ALL)).collect()
    };
    let put = |known: &mut [Known], bodies: &[Body]| {
        component.iter().zip(bodies).for_each(|(key, body)| known[*key as usize] = Ok(*body));
    };
    let [rising, inflating, tightening] = ROUNDS;
    let mut growth = 1.0;
    let mut last = get(known);
    for count in 0..rising {
        round(known)?;
        let mut next = get(known);
        if count == 0 && next.iter().all(Body::is_empty) {
            next = vec![Body::POINT; component.len()];
        }
        next.iter_mut().zip(&last).for_each(|(next, last)| *next = next.join(*last));
        growth = largest(&next) / largest(&last).max(f64::MIN_POSITIVE);
        let settled = next.iter().zip(&last).all(|(next, last)| moved(next, last) <= SETTLED * extent(next));
        put(known, &next);
        last = next;
        if settled {
            break;
        }
    }
    for _ in 0..inflating {
        let guess: Vec<_> = last.iter().map(inflated).collect();
        put(known, &guess);
        round(known)?;
        let image = get(known);
        if image.iter().zip(&guess).all(|(image, guess)| within(image, guess)) {
            let mut last = image;
            for _ in 0..tightening {
                round(known)?;
                let next: Vec<_> =
                    get(known).into_iter().zip(&last).map(|(next, last)| next.intersect(*last)).collect();
                put(known, &next);
                let settled =
                    next.iter().zip(&last).all(|(next, last)| moved(last, next) <= SETTLED * extent(next));
                last = next;
                if settled {
                    break;
                }
            }
            return Ok(());
        }
        last = image.iter().zip(&last).map(|(image, last)| image.join(*last)).collect();
    }
    Err(Failure { cycle: Vec::new(), round: Round::Unbounded(growth) })
}

/// The largest extent along an axis.
fn extent(body: &Body) -> f64 {
    body.slabs.aabb().size().max_element()
}

fn largest(bodies: &[Body]) -> f64 {
    bodies.iter().map(extent).fold(0.0, f64::max)
}

/// By how much planes of one are further out than those of the other; what is infinite in both did not move.
fn moved(outer: &Body, inner: &Body) -> f64 {
    let planes = outer.slabs.max.iter().zip(&inner.slabs.max).map(|(outer, inner)| outer - inner);
    let planes =
        planes.chain(outer.slabs.min.iter().zip(&inner.slabs.min).map(|(outer, inner)| inner - outer));
    planes.chain([outer.radius - inner.radius]).filter(|by| !by.is_nan()).fold(0.0, f64::max)
}

/// A little larger on all sides.
fn inflated(body: &Body) -> Body {
    if body.is_empty() {
        return *body;
    }
    let planes = body.slabs.max.iter().chain(&body.slabs.min).filter(|plane| plane.is_finite());
    let magnitude = planes.fold(0.0_f64, |far, plane| far.max(plane.abs()));
    let size = extent(body);
    let by =
        INFLATION * if size.is_finite() { size } else { magnitude } + SETTLED * magnitude + f64::MIN_POSITIVE;
    let mut inflated = Body { radius: body.radius + by, ..*body };
    for (i, direction) in Slabs::<13>::DIRECTIONS.into_iter().enumerate() {
        inflated.slabs.max[i] += by * direction.length();
        inflated.slabs.min[i] -= by * direction.length();
    }
    inflated
}

/// Whether all planes that have an end, and the ball, are strictly further in.
fn within(inner: &Body, outer: &Body) -> bool {
    let less = |inner: f64, outer: f64| inner < outer || outer == f64::INFINITY;
    let above = inner.slabs.max.iter().zip(&outer.slabs.max).all(|(inner, outer)| less(*inner, *outer));
    let below = inner.slabs.min.iter().zip(&outer.slabs.min).all(|(inner, outer)| less(-inner, -outer));
    inner.is_empty() || above && below && less(inner.radius, outer.radius)
}

/// Some cycle in a component, from its key with the highest number.
fn cycle_of(keys: &Keys, component: &[u32]) -> Vec<u32> {
    let place = |key: u32| component.binary_search(&key).ok();
    let mut path: Vec<u32> = Vec::new();
    // Where on the path each key of the component is.
    let mut entered: Vec<Option<usize>> = vec![None; component.len()];
    let mut next = component.len().checked_sub(1);
    while let Some(number) = next {
        if let Some(from) = entered[number].replace(path.len()) {
            path.drain(..from);
            break;
        }
        path.push(component[number]);
        next = keys.parts(component[number]).iter().find_map(|part| place(*part));
    }
    path
}
