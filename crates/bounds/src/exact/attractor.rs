//! The boxes of states that lead back to themselves.
//!
//! A recursion that never ends, but shrinks, has a limit: the *attractor* [HUTC81] of the maps on its way, which is what
//! [HART91] ray traces. With shapes in it, it is the limit together with all that the recursion leaves behind. Its
//! points are infinitely many levels down, so that no pass from the leaves up can find its box. But a box that is known to
//! hold it, however loose, comes back smaller once round the cycle:
//!
//! 1. [`contraction`](super::contraction) proves that the recursion shrinks, and gives the first boxes.
//! 2. Each face is asked for by a support query that goes down some levels, to where the boxes that it ends at are a
//!    fraction of what they were, and so is their looseness. Rounds of such queries end when every gap is as small as the
//!    limits want it.
//! 3. Where a cycle shrinks so slowly that this does not end, boxes are [guessed](super::guess).
//!
//! Each round asks for no more than it can get: an eighth of the gap that is left. A query that wants everything at once
//! would look at every copy that a loose box lets come near the face, and with ties these are as many as there are copies.
//!
//! **Gaps.** An attractor has points, in each box at least one, which is all that the gaps of the first round need. Those of
//! later rounds include rounding: it is enlarged by the looseness of the first boxes, and would otherwise pass for what is
//! certain.
//!
//! **∩ and \\.** A difference is its left operand. An intersection is bounded by its operands from outside the recursion
//! if there are any with an end, and so ends it; otherwise by those inside.

use super::bottom_up::{BottomUp, EMPTY, mapped};
use super::contraction::{Contraction, Edge, Failure};
use super::guess::Guess;
use super::query::Search;
use super::solids::{Image, Part};
use super::states::Term;
use super::{Endless, StateBox};
use crate::{Aabb, BoundsError, Limits, Scene};
use glam::DVec3;

/// The share of its gap that the next query for a face is to leave.
const SHARE: f64 = 0.125;

/// How many expansions a query has in the first round. It doubles when a round gains less than half.
const FIRST: usize = 32;

/// How many times the rounding errors of its support a gap is at least worth a query. An attractor may be flat.
pub(super) const ERRORS: f64 = 16.0;

/// How many times the most expansions of a query all rounds together may take, for each solid, and all guesses.
const BUDGET: u64 = 16;

/// The smallest share of a box that a guess is larger by than what is inside, as a power of ½.
const HALVINGS: i32 = 52;

/// A union or an intersection that is a part of itself.
struct Vertex {
    state: u32,
    solid: u32,
    intersection: bool,
    /// What an intersection has in common with its operands from outside.
    clip: Aabb,
    /// What is asked for its faces: all of it, or each operand that is a part of it.
    asked: Vec<Part>,
    /// The gaps of the faces.
    gaps: [f64; 6],
    /// How far the parts from outside reach, and what a query in them may err.
    reach: f64,
    error: f64,
}

/// Directions of the faces: those at the upper side, then those at the lower.
pub(super) const FACES: [DVec3; 6] = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];

impl<S: Scene> BottomUp<S> {
    /// Bounds the states of a component.
    pub(super) fn attractor(
        &mut self,
        scene: &S,
        limits: &Limits,
        component: &[u32],
    ) -> Result<(), BoundsError<S::Error>> {
        let (mut vertices, followers) = self.declare(component);
        let edges = self.define(&mut vertices);
        let parts: Vec<Part> = edges.iter().map(|(part, _)| *part).collect();
        let edges = edges.into_iter().map(|(_, edge)| edge).collect();
        let contraction = Contraction::new(vertices.len(), edges)
            .map_err(|failure| self.endless(scene, &vertices, failure))?;
        let endless = self.endless.get_or_insert(Endless { states: 0, contraction: 0.0 });
        endless.states += component.len();
        endless.contraction = endless.contraction.max(contraction.factor);
        let reach: Vec<f64> = vertices.iter().map(|vertex| vertex.reach).collect();
        if let Some(boxes) = contraction.boxes(&reach) {
            for (vertex, aabb) in vertices.iter().zip(boxes) {
                let aabb = aabb.intersect(vertex.clip);
                self.solids.confine(vertex.solid, aabb, aabb.size().max_element());
            }
            if !self.refine(limits, &mut vertices, &contraction, &parts) {
                self.set_errors(&vertices, &contraction, &parts);
                self.guess(limits, &mut vertices);
            }
        }
        for vertex in &vertices {
            let solid = self.solids.solid(vertex.solid);
            let gap = if solid.bounds.is_bounded() { solid.gap } else { 0.0 };
            self.boxes[vertex.state as usize] = StateBox { aabb: solid.bounds, gap };
        }
        for state in followers {
            let found = match self.states.terms[state as usize] {
                Term::Map(map, below) => {
                    let (image, below) = (self.images[state as usize], self.boxes[below as usize]);
                    mapped(&self.solids, &mut self.search, image, &self.states.maps[map as usize], below)
                }
                _ => self.boxes[self.states.below(state)[0] as usize],
            };
            self.boxes[state as usize] = found;
        }
        Ok(())
    }

    /// Declares a solid for each union and intersection, or for any state if there are none, and makes all other states
    /// images of them. Returns these after those that they are images of.
    fn declare(&mut self, component: &[u32]) -> (Vec<Vertex>, Vec<u32>) {
        let branches = |state: &&u32| {
            matches!(self.states.terms[**state as usize], Term::Union(_) | Term::Intersection(_))
        };
        let mut own: Vec<u32> = component.iter().filter(branches).copied().collect();
        if own.is_empty() {
            own.push(component[0]);
        }
        let mut vertices = Vec::with_capacity(own.len());
        for state in own {
            let image = self.solids.declare();
            self.images[state as usize] = image;
            vertices.push(Vertex {
                state,
                solid: image.solid(),
                intersection: matches!(self.states.terms[state as usize], Term::Intersection(_)),
                clip: Aabb::ALL,
                asked: Vec::new(),
                gaps: [f64::INFINITY; 6],
                reach: 0.0,
                error: 0.0,
            });
        }
        let (mut followers, mut path) = (Vec::new(), Vec::new());
        for state in component {
            let mut state = *state;
            while self.images[state as usize].is_none() {
                path.push(state);
                state = self.states.below(state)[0];
            }
            while let Some(above) = path.pop() {
                self.images[above as usize] = self.image_above(above);
                followers.push(above);
            }
        }
        (vertices, followers)
    }

    /// A state as an image, given that of the state below it.
    fn image_above(&mut self, state: u32) -> Image {
        let below = self.images[self.states.below(state)[0] as usize];
        match self.states.terms[state as usize] {
            Term::Map(map, _) => self.solids.map(self.states.maps[map as usize], below),
            _ => below,
        }
    }

    /// Gives the declared solids their parts. Returns those that are declared solids too.
    fn define(&mut self, vertices: &mut [Vertex]) -> Vec<(Part, Edge)> {
        let first = vertices[0].solid;
        let mut edges = Vec::new();
        for (above, vertex) in vertices.iter_mut().enumerate() {
            let mut operands: Vec<(u32, Image)> = match self.states.terms[vertex.state as usize] {
                Term::Union(_) | Term::Intersection(_) => {
                    let below = self.states.below(vertex.state).iter();
                    below.map(|state| (*state, self.images[*state as usize])).collect()
                }
                _ => vec![(self.states.below(vertex.state)[0], self.image_above(vertex.state))],
            };
            let inside = |image: Image| image.solid() >= first;
            if vertex.intersection {
                for (state, image) in &operands {
                    if inside(*image) {
                        vertex.asked.push(self.solids.part(*image));
                    } else {
                        vertex.clip = vertex.clip.intersect(self.boxes[*state as usize].aabb);
                    }
                }
                let ends = |(state, image): &(u32, Image)| {
                    !inside(*image) && self.boxes[*state as usize].aabb.is_bounded()
                };
                let any = operands.iter().any(ends);
                operands.retain(|operand| if any { ends(operand) } else { inside(operand.1) });
            } else {
                vertex.asked.push(self.solids.itself(vertex.solid));
                operands
                    .retain(|(state, image)| inside(*image) || !self.boxes[*state as usize].aabb.is_empty());
            }
            self.solids.define(vertex.solid, vertex.intersection, operands.iter().map(|(_, image)| *image));
            for (state, image) in operands {
                let part = self.solids.part(image);
                if !inside(image) {
                    let corners = self.boxes[state as usize].aabb.corners();
                    let reach = corners.iter().map(|corner| corner.length()).fold(0.0, f64::max);
                    vertex.reach = vertex.reach.max(reach * (1.0 + 1e-9));
                    vertex.error = vertex.error.max(self.solids.error(&part));
                    continue;
                }
                let [drift, offset_drift] = part.chain.rounding.drift();
                let map = part.chain.parent_from_child;
                edges.push((
                    part,
                    Edge {
                        above,
                        below: (part.solid - first) as usize,
                        map: map.matrix3,
                        offset: map.translation.length() * (1.0 + 1e-9) + offset_drift,
                        drift,
                        state,
                    },
                ));
            }
        }
        edges
    }

    /// Rounds of queries, until all gaps are small or no longer get smaller. Whether they are small.
    fn refine(
        &mut self,
        limits: &Limits,
        vertices: &mut [Vertex],
        contraction: &Contraction,
        parts: &[Part],
    ) -> bool {
        let mut search = Search::new(limits);
        search.limit = FIRST.min(limits.expansions);
        let budget = (limits.expansions as u64).saturating_mul(BUDGET * vertices.len() as u64);
        let settled = loop {
            self.set_errors(vertices, contraction, parts);
            let mut slowest = 0.0_f64;
            for vertex in vertices.iter_mut() {
                slowest = slowest.max(self.ask_for_faces(&mut search, vertex));
            }
            self.drop_empty(vertices);
            let stuck = slowest > 0.999 && search.limit >= limits.expansions;
            if slowest <= 0.0 || stuck || search.expansions >= budget {
                break slowest <= 0.0;
            }
            if slowest > 0.5 {
                search.limit = (2 * search.limit).min(limits.expansions);
            }
        };
        self.search.queries += search.queries;
        self.search.expansions += search.expansions;
        settled
    }

    /// Guesses boxes as close as can be to what is inside: all faces at once, because they may depend on each other, and
    /// then those in each direction alone, because some may be as far as they seem.
    fn guess(&mut self, limits: &Limits, vertices: &mut [Vertex]) {
        let budget = (limits.expansions as u64).saturating_mul(BUDGET * vertices.len() as u64);
        let mut spent = 0;
        for chosen in std::iter::once(None).chain((0..FACES.len()).map(Some)) {
            // The most halvings that hold, by bisection.
            let (mut least, mut most, mut best) = (0, HALVINGS + 1, None);
            while most - least > 1 && spent < budget {
                let halvings = least.midpoint(most);
                let boxes: Vec<Aabb> =
                    vertices.iter().map(|vertex| self.closer(vertex, chosen, halvings).0).collect();
                let (solids, first) = (&self.solids, vertices[0].solid);
                let limit = limits.expansions;
                let mut guess = Guess { solids, first, boxes: &boxes, limit, expansions: 0 };
                if guess.holds() {
                    (least, best) = (halvings, Some(halvings));
                } else {
                    most = halvings;
                }
                spent += guess.expansions;
            }
            let Some(halvings) = best else { continue };
            for vertex in vertices.iter_mut() {
                let (aabb, gaps) = self.closer(vertex, chosen, halvings);
                vertex.gaps = gaps;
                self.solids.confine(vertex.solid, aabb, gaps.into_iter().fold(0.0, f64::max));
            }
        }
        self.search.expansions += spent;
    }

    /// A box between that of a solid and what is known to be inside, with its gaps: larger by so many halvings of its size,
    /// in the chosen direction if there is one.
    fn closer(&self, vertex: &Vertex, chosen: Option<usize>, halvings: i32) -> (Aabb, [f64; 6]) {
        let bounds = self.solids.solid(vertex.solid).bounds;
        let margin = libm::ldexp(bounds.magnitude(), -halvings);
        let (mut faces, mut gaps) = (FACES.map(|direction| bounds.support(direction)), vertex.gaps);
        for at in (0..FACES.len()).filter(|at| chosen.is_none_or(|chosen| chosen == *at)) {
            let (face, gap) = (&mut faces[at], &mut gaps[at]);
            if gap.is_finite() && margin < *gap {
                *face -= *gap - margin;
                *gap = margin;
            }
        }
        (box_of(faces), gaps)
    }

    fn set_errors(&mut self, vertices: &[Vertex], contraction: &Contraction, parts: &[Part]) {
        let edges = parts.iter().map(|part| {
            let magnitude = self.solids.solid(part.solid).bounds.magnitude();
            part.chain.rounding.error_above(magnitude, 0.0)
        });
        let outside: Vec<f64> = vertices.iter().map(|vertex| vertex.error).collect();
        let errors = contraction.errors(&edges.collect::<Vec<_>>(), &outside);
        for (vertex, error) in vertices.iter().zip(errors) {
            self.solids.set_error(vertex.solid, error);
        }
    }

    /// Asks for those faces of a solid that are not certain enough. Returns what is left of the gap that got least
    /// smaller, as a share; nothing if all are.
    fn ask_for_faces(&mut self, search: &mut Search, vertex: &mut Vertex) -> f64 {
        let solid = self.solids.solid(vertex.solid);
        let (bounds, size, error) = (solid.bounds, solid.bounds.size(), solid.error);
        if bounds.is_empty() {
            return 0.0;
        }
        let mut faces = FACES.map(|direction| bounds.support(direction));
        let mut slowest = 0.0_f64;
        for (at, direction) in FACES.into_iter().enumerate() {
            let known = vertex.gaps[at].min(size[at % 3]);
            let enough = (search.gap * size[at % 3]).max(ERRORS * error);
            if known <= 2.0 * enough {
                vertex.gaps[at] = known;
                continue;
            }
            let tolerance = enough.max(SHARE * known);
            // Of the operands of an intersection, the least decides.
            let (mut least, mut gap) = (f64::INFINITY, known);
            for part in &vertex.asked {
                let found = search.support(&self.solids, part, direction, faces[at], tolerance);
                let error = self.solids.error(part);
                let upper = (found.upper + error).next_up();
                if upper < least {
                    // With the errors, which are larger as long as the boxes are.
                    (least, gap) = (upper, known.min(found.upper - found.lower + 2.0 * error));
                }
            }
            faces[at] = faces[at].min(least);
            slowest = slowest.max(gap / known);
            vertex.gaps[at] = gap;
        }
        let aabb = box_of(faces);
        let gap = vertex.gaps.iter().fold(0.0, |gap: f64, face| gap.max(*face));
        self.solids.confine(vertex.solid, aabb, if aabb.is_empty() { 0.0 } else { gap });
        slowest
    }

    /// Where ∩ left nothing, nothing is left of what is made of it.
    fn drop_empty(&mut self, vertices: &[Vertex]) {
        loop {
            let mut changed = false;
            for vertex in vertices {
                if self.solids.solid(vertex.solid).bounds.is_empty() {
                    continue;
                }
                let without = |part: &Part| self.solids.solid(part.solid).bounds.is_empty();
                let nothing = if vertex.intersection {
                    vertex.asked.iter().any(without)
                } else {
                    self.solids.keep_parts_with_points(vertex.solid) == 0
                };
                if nothing {
                    changed = true;
                    self.solids.confine(vertex.solid, Aabb::EMPTY, EMPTY.gap);
                }
            }
            if !changed {
                break;
            }
        }
    }

    /// The error that names the cycle.
    fn endless(&self, scene: &S, vertices: &[Vertex], failure: Failure) -> BoundsError<S::Error> {
        let mut cycle: Vec<u32> = Vec::new();
        for edge in &failure.cycle {
            cycle.push(vertices[edge.above].state);
            let mut state = edge.state;
            while state != vertices[edge.below].state {
                cycle.push(state);
                state = self.states.below(state)[0];
            }
        }
        self.states.endless(scene, cycle, failure.round)
    }
}

/// The box with these faces.
fn box_of([max_x, max_y, max_z, min_x, min_y, min_z]: [f64; 6]) -> Aabb {
    Aabb::new(DVec3::ZERO - DVec3::new(min_x, min_y, min_z), DVec3::new(max_x, max_y, max_z))
}
