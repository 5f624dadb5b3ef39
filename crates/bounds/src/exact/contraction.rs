//! The certificate that a recursion which never ends is bounded: norms and radii.
//!
//! The solids of a component that leads back to itself satisfy equations Xₛ = ∪ (Mₑ Xₜ + tₑ) ∪ Kₛ, one *edge* e for each
//! part that is in the component, with Kₛ all the other parts. [HUTC81] shows for one equation, and [MAUL88] for graphs of
//! them, that maps which shrink make all bounded sets converge to one solution, the *attractor*, and that the
//! attractor is in every family of closed sets that the right-hand sides map into itself. Balls of radius rₛ about the
//! origin, each in the [norm](super::norm) of its frame, are such a family if
//!
//! > ρₑ rₜ + bₑ ≤ rₛ for all edges, and cₛ ≤ rₛ,
//!
//! with ρₑ what Mₑ enlarges at most in these norms, bₑ > 0 at least the length of tₑ, and cₛ > 0 at least that of the
//! points of Kₛ. It follows that ρₑ rₜ/rₛ < 1: in the norms divided by the radii every single edge shrinks, so that any
//! solution of these inequalities *is* the proof of contraction too, whether single ρₑ are above 1 or not.
//!
//! **The least radii** are those of the largest of many sums, one for each way to choose one edge out of each solid. A
//! choice has either a cycle with ∏ ρₑ ≥ 1, and then there are no radii; or radii that are found in one pass. Howard's
//! policy iteration [HOWA60] starts with any choice and takes a better edge wherever there is one, until there is none.
//!
//! Where a cycle does not shrink, the product of its maps says whether it ever will: if its spectral radius is below 1,
//! the norms are to blame, and others are [tried](super::norm).

use glam::DMat3;

use super::norm::{Norm, growth};
use crate::Aabb;
use crate::limits::Round;

/// A part in the component, of a solid in the component.
pub(super) struct Edge {
    /// The solids, numbered within the component.
    pub(super) above: usize,
    pub(super) below: usize,
    pub(super) map: DMat3,
    /// How far the origin is moved, at most, and by how much `map` may be off in what it does to distances.
    pub(super) offset: f64,
    pub(super) drift: f64,
    /// The state that the part is.
    pub(super) state: u32,
}

/// The edges of a component in norms where all its cycles shrink.
pub(super) struct Contraction {
    edges: Vec<Edge>,
    norms: Vec<Norm>,
    /// ρ of each edge.
    factors: Vec<f64>,
    /// The edges out of each solid, as a range of the edges.
    out: Vec<[usize; 2]>,
    /// At most how much is left of distances once round any cycle: less than 1.
    pub(super) factor: f64,
}

/// A cycle for which there is no certificate: its edges, and what they do.
pub(super) struct Failure {
    pub(super) cycle: Vec<Edge>,
    pub(super) round: Round,
}

/// By how much all maps are to shrink, in the norms that are searched for one after the other.
const TARGETS: [f64; 8] = [0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.999, 0.9999];

/// How often the search for norms goes round all edges.
const PASSES: usize = 100;

/// A spectral radius this close to 1 counts as 1: rounding, and powers of shears.
const NEITHER: f64 = 1e-6;

/// The part of the largest constant that each bₑ and cₛ is at least. That of bₑ, of which a slow cycle adds up many, is also
/// at most what the cycle takes away.
const LEAST: f64 = 1e-3;

/// What that must be more than, for the certificate to be above rounding.
const LEAST_OFFSET: f64 = 1e-9;

impl Contraction {
    /// Finds norms for the edges of `count` solids, sorted by the solid above.
    pub(super) fn new(count: usize, edges: Vec<Edge>) -> Result<Self, Failure> {
        let mut out = vec![[0; 2]; count];
        for (number, edge) in edges.iter().enumerate().rev() {
            let [start, end] = &mut out[edge.above];
            (*start, *end) = (number, (*end).max(number + 1));
        }
        let mut found =
            Self { norms: vec![Norm::EUCLIDEAN; count], factors: Vec::new(), edges, out, factor: 1.0 };
        let mut tried = found.certify();
        // First a norm for each slow cycle by itself, and then for all edges together.
        let mut is_even = vec![false; count];
        while let Err((cycle, Round::Unproven(growth))) = &tried
            && found.even_out(cycle, *growth, &mut is_even)
        {
            tried = found.certify();
        }
        for target in TARGETS {
            if !matches!(tried, Err((_, Round::Unproven(_)))) {
                break;
            }
            // Norms that are still growing may do, but make ellipsoids like needles.
            if found.search(target) || TARGETS.last() == Some(&target) {
                tried = found.certify();
            }
        }
        match tried {
            Ok(()) => Ok(found),
            Err((cycle, round)) => {
                let mut edges: Vec<Option<Edge>> = found.edges.into_iter().map(Some).collect();
                let cycle = cycle.into_iter().filter_map(|edge| edges[edge].take()).collect();
                Err(Failure { cycle, round })
            }
        }
    }

    /// Finds out how much is left of distances once round any cycle, in the norms as they are; or a cycle of edges that does
    /// not shrink in these, and what it does in the long run.
    fn certify(&mut self) -> Result<(), (Vec<usize>, Round)> {
        self.measure();
        match self.fixed_point(&vec![1.0; self.edges.len()], &vec![1.0; self.norms.len()]) {
            Ok(radii) => {
                self.factor = self.once_round(&radii);
                Ok(())
            }
            Err(cycle) => {
                let round = self.round(&cycle);
                Err((cycle, round))
            }
        }
    }

    /// Gives the solids of a cycle that shrinks in the long run norms in which each of its edges does, unless one of them has
    /// such a norm for another cycle.
    fn even_out(&mut self, cycle: &[usize], growth: f64, is_even: &mut [bool]) -> bool {
        /// What is less is hard to tell from nothing.
        const LEAST_GROWTH: f64 = 1e-4;
        let edges = || cycle.iter().map(|edge| &self.edges[*edge]);
        let solids: Vec<usize> = edges().map(|edge| edge.above).collect();
        if solids.iter().any(|solid| is_even[*solid]) {
            return false;
        }
        // Half way between what is left in the long run and all, the same for each edge.
        let factor = libm::pow(growth.max(LEAST_GROWTH), 0.5 / cycle.len() as f64);
        let maps: Vec<DMat3> = edges().map(|edge| edge.map).collect();
        let Some(norms) = Norm::of_round(&maps, factor) else { return false };
        for (solid, norm) in solids.into_iter().zip(norms) {
            (self.norms[solid], is_even[solid]) = (norm, true);
        }
        true
    }

    /// Enlarges norms until all maps that change anything shrink by a factor. Whether they do.
    fn search(&mut self, factor: f64) -> bool {
        self.norms.fill(Norm::EUCLIDEAN);
        let mut mended = true;
        for _ in 0..PASSES {
            mended = false;
            for edge in &self.edges {
                let factor = if edge.map == DMat3::IDENTITY { 1.0 } else { factor };
                let (above, below) = (self.norms[edge.above], &mut self.norms[edge.below]);
                if let Some(better) = below.mended(&edge.map, &above, factor) {
                    mended = true;
                    *below = better;
                }
            }
            if !mended {
                break;
            }
        }
        for norm in &mut self.norms {
            *norm = norm.checked();
        }
        !mended
    }

    fn measure(&mut self) {
        let Self { edges, norms, factors, .. } = self;
        factors.clear();
        factors.extend(edges.iter().map(|edge| {
            let (above, below) = (&norms[edge.above], &norms[edge.below]);
            let drift =
                if edge.drift > 0.0 { above.of_euclidean() * edge.drift * below.euclidean() } else { 0.0 };
            above.enlargement(&edge.map, below) + drift
        }));
    }

    /// What a cycle does in the long run.
    fn round(&self, cycle: &[usize]) -> Round {
        let product = cycle.iter().fold(DMat3::IDENTITY, |map, edge| map * self.edges[*edge].map);
        let growth = growth(&product);
        if product == DMat3::IDENTITY && cycle.iter().all(|edge| self.edges[*edge].offset == 0.0) {
            Round::Unchanged
        } else if growth > 1.0 + NEITHER {
            Round::Grows(growth)
        } else if growth < 1.0 - NEITHER {
            Round::Unproven(growth)
        } else {
            Round::Turns
        }
    }

    /// At most how much is left of distances once round any cycle.
    ///
    /// All cycles go through the solids that some edge leads up to, in the order of the numbers. Between two of them the
    /// edges lead down only, and one pass finds the largest product. It may be above 1 if there are several such solids,
    /// but not so what is left of the radii after a single edge.
    fn once_round(&self, radii: &[f64]) -> f64 {
        let up = |edge: &Edge| edge.below >= edge.above;
        let mut met_again = vec![false; self.out.len()];
        self.edges.iter().filter(|edge| up(edge)).for_each(|edge| met_again[edge.below] = true);
        let mut products = vec![0.0_f64; self.out.len()];
        let mut largest = 0.0_f64;
        for (solid, [start, end]) in self.out.iter().enumerate() {
            for number in *start..*end {
                let below = self.edges[number].below;
                let rest = if met_again[below] { 1.0 } else { products[below] };
                products[solid] = products[solid].max(self.factors[number] * rest);
            }
            if met_again[solid] {
                largest = largest.max(products[solid]);
            }
        }
        let left = |(edge, factor): (&Edge, &f64)| factor * radii[edge.below] / radii[edge.above];
        largest.min(self.edges.iter().zip(&self.factors).map(left).fold(0.0, f64::max))
    }

    /// Boxes that hold all solids, if `reach` is, for each, the largest distance from the origin of its parts outside the
    /// component. `None` if there are no finite ones.
    pub(super) fn boxes(&self, reach: &[f64]) -> Option<Vec<Aabb>> {
        let norms = || self.norms.iter();
        let offsets = self.edges.iter().map(|edge| self.norms[edge.above].of_euclidean() * edge.offset);
        let mut offsets: Vec<f64> = offsets.collect();
        let mut reach: Vec<f64> =
            norms().zip(reach).map(|(norm, reach)| norm.of_euclidean() * reach).collect();
        let all = || offsets.iter().chain(&reach);
        let largest = all().fold(1e-100, |largest: f64, length| largest.max(*length));
        if largest >= 1e280 {
            return None;
        }
        let least = LEAST.min(1.0 - self.factor).max(LEAST_OFFSET);
        offsets.iter_mut().for_each(|length| *length = length.max(least * largest));
        reach.iter_mut().for_each(|length| *length = length.max(LEAST * largest));
        let mut radii = self.fixed_point(&offsets, &reach).ok()?;
        radii.iter_mut().for_each(|radius| *radius *= 1.0 + 1.0 / 16.0);
        let holds_rest = radii.iter().zip(&reach).all(|(radius, reach)| reach <= radius);
        let certified = holds_rest
            && self.edges.iter().zip(&self.factors).zip(&offsets).all(|((edge, factor), offset)| {
                (factor * radii[edge.below] + offset) * (1.0 + 8.0 * f64::EPSILON) <= radii[edge.above]
            });
        let extents = norms().zip(&radii).map(|(norm, radius)| norm.extents() * *radius);
        certified.then(|| extents.map(|extents| Aabb { min: -extents, max: extents }).collect())
    }

    /// The errors of all solids, as [`Solid::error`](super::solids::Solid::error), if those of the edges themselves and
    /// those of the parts outside the component are these.
    ///
    /// What a query errs in a direction d is measured in the dual norms, |Vᵀd|, which Mᵀ enlarges as M does the others.
    pub(super) fn errors(&self, edges: &[f64], outside: &[f64]) -> Vec<f64> {
        let own = |solid: usize, error: f64| self.norms[solid].of_euclidean() * error;
        let edges: Vec<f64> =
            self.edges.iter().zip(edges).map(|(edge, error)| own(edge.above, *error)).collect();
        let outside: Vec<f64> = outside.iter().enumerate().map(|(solid, error)| own(solid, *error)).collect();
        match self.fixed_point(&edges, &outside) {
            Ok(errors) => {
                let errors = errors.iter().zip(&self.norms);
                errors.map(|(error, norm)| 1.001 * norm.euclidean() * error).collect()
            }
            Err(_) => vec![f64::INFINITY; self.norms.len()],
        }
    }

    /// The least x with xₛ ≥ ρₑ xₜ + bₑ and xₛ ≥ cₛ, rounded to nearest; or a cycle with ∏ ρₑ ≥ 1.
    fn fixed_point(&self, offsets: &[f64], constants: &[f64]) -> Result<Vec<f64>, Vec<usize>> {
        // Of each solid the edge that decides; none where the constant does.
        let widest = |[start, end]: &[usize; 2]| {
            (*start..*end).max_by(|a, b| self.factors[*a].total_cmp(&self.factors[*b]).then(b.cmp(a)))
        };
        let mut choice: Vec<Option<usize>> = self.out.iter().map(widest).collect();
        loop {
            let found = self.evaluate(&choice, offsets, constants)?;
            let mut better = false;
            for (solid, choice) in choice.iter_mut().enumerate() {
                let mut most = found[solid] * (1.0 + 1e-12);
                if constants[solid] > most {
                    (most, *choice, better) = (constants[solid], None, true);
                }
                for edge in self.out[solid][0]..self.out[solid][1] {
                    let value = self.factors[edge] * found[self.edges[edge].below] + offsets[edge];
                    if value > most {
                        (most, *choice, better) = (value, Some(edge), true);
                    }
                }
            }
            if !better {
                return Ok(found);
            }
        }
    }

    /// The solution of xₛ = ρₑ xₜ + bₑ for the chosen edges and xₛ = cₛ without, or a cycle that has none.
    fn evaluate(
        &self,
        choice: &[Option<usize>],
        offsets: &[f64],
        constants: &[f64],
    ) -> Result<Vec<f64>, Vec<usize>> {
        const UNKNOWN: f64 = -1.0;
        const ON_PATH: f64 = -2.0;
        let mut found = vec![UNKNOWN; choice.len()];
        let mut path: Vec<usize> = Vec::new();
        for start in 0..choice.len() {
            let mut solid = start;
            // Down the chosen edges, to what is known, or round a cycle.
            while found[solid] < 0.0 {
                match choice[solid] {
                    None => found[solid] = constants[solid],
                    Some(edge) if found[solid] > ON_PATH => {
                        found[solid] = ON_PATH;
                        path.push(edge);
                        solid = self.edges[edge].below;
                    }
                    Some(first) => {
                        let from = path.iter().position(|edge| *edge == first).expect("it is on the path");
                        let (mut factor, mut sum) = (1.0, 0.0);
                        for edge in &path[from..] {
                            sum += factor * offsets[*edge];
                            factor *= self.factors[*edge];
                        }
                        if factor.is_nan() || factor >= 1.0 {
                            return Err(path.split_off(from));
                        }
                        found[solid] = sum / (1.0 - factor);
                    }
                }
            }
            // And up again.
            while let Some(edge) = path.pop() {
                let Edge { above, below, .. } = self.edges[edge];
                if found[above] < 0.0 {
                    found[above] = self.factors[edge] * found[below] + offsets[edge];
                }
            }
        }
        Ok(found)
    }
}
