//! Chance as a function: numbers that look random and depend on their arguments alone.
//!
//! There is no generator with a state that rays would have to share. Each number is a hash of a few numbers: of a *seed*,
//! which comes with the state like any other parameter, and of the *site* where it is drawn. The bits of the numbers pass
//! the finaliser of SplitMix64 \[STEE14\], once each and once more at the end. That is integer arithmetic and a few
//! operations that IEEE 754 rounds exactly, so that every machine draws the same; only [`normal`] needs `libm`.

use crate::angle;

/// No [`Function::Normal`](crate::Function::Normal) is more deviations away from its mean than this: the smallest number
/// that Box and Muller's root is taken of is 2^−53.
pub const NORMAL_REACH: f64 = 8.58;

/// What a hash is for. Equal arguments give unrelated numbers for different purposes.
#[derive(Clone, Copy)]
enum Purpose {
    Derive = 1,
    Draw = 2,
    Hash = 3,
    Noise = 4,
}

/// A hash under way.
#[derive(Clone, Copy)]
struct Hasher(u64);

impl Hasher {
    fn new(purpose: Purpose) -> Self {
        Self(GOLDEN.wrapping_mul(purpose as u64))
    }

    /// Takes in a number; both zeros are one.
    fn number(self, value: f64) -> Self {
        Self(mix(self.0 ^ (value + 0.0).to_bits()))
    }

    fn numbers(self, values: &[f64]) -> Self {
        values.iter().fold(self, |hasher, value| hasher.number(*value))
    }

    /// 64 bits, each of which depends on all that was taken in.
    fn finish(self) -> u64 {
        mix(self.0.wrapping_add(GOLDEN))
    }
}

/// 2^64 divided by the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// The finaliser of SplitMix64, a permutation of all words.
fn mix(word: u64) -> u64 {
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

/// 2^−53
const STEP: f64 = f64::EPSILON / 2.0;

/// The upper 53 bits, which a number holds exactly.
#[expect(clippy::cast_precision_loss, reason = "53 bits fit")]
fn integer(word: u64) -> f64 {
    (word >> 11) as f64
}

/// A number in [0, 1), one of 2^53.
fn unit(word: u64) -> f64 {
    integer(word) * STEP
}

/// The seed that the reference at `position` hands down: an integer below 2^53.
pub(crate) fn derive(seed: f64, position: f64) -> f64 {
    integer(Hasher::new(Purpose::Derive).number(seed).number(position).finish())
}

/// Uniform in [0, 1).
pub(crate) fn hash(values: &[f64]) -> f64 {
    unit(Hasher::new(Purpose::Hash).numbers(values).finish())
}

fn draw(seed: f64, site: f64) -> u64 {
    Hasher::new(Purpose::Draw).number(seed).number(site).finish()
}

/// Uniform in [low, high), or in (high, low] where they are the wrong way round. Not a number where their difference is
/// infinite.
pub(crate) fn uniform(seed: f64, site: f64, low: f64, high: f64) -> f64 {
    let length = high - low;
    if !length.is_finite() {
        return f64::NAN;
    }
    let value = low + length * unit(draw(seed, site));
    // The sum may be rounded up to the end that does not belong.
    if low < high {
        value.min(high.next_down())
    } else if low > high {
        value.max(high.next_up())
    } else {
        low
    }
}

/// Normally distributed about `mean` (\[BOXM58\]), no further from it than [`NORMAL_REACH`] deviations.
pub(crate) fn normal(seed: f64, site: f64, mean: f64, deviation: f64) -> f64 {
    let word = draw(seed, site);
    let radius = (-2.0 * libm::log((integer(word) + 1.0) * STEP)).sqrt();
    let angle = 360.0 * unit(mix(word.wrapping_add(GOLDEN)));
    mean + deviation * radius * angle::sin_cos(angle).1
}

/// The number of one of the weights, from 1, with a probability in proportion to it. Not a number where a weight is
/// negative, none is positive, or their sum is infinite.
pub(crate) fn pick(seed: f64, site: f64, weights: &[f64]) -> f64 {
    let total: f64 = weights.iter().sum();
    if weights.iter().any(|weight| *weight < 0.0) || total <= 0.0 || !total.is_finite() {
        return f64::NAN;
    }
    let at = total * unit(draw(seed, site));
    let mut end = 0.0;
    let mut picked = f64::NAN;
    for (number, weight) in (1_u32..).zip(weights) {
        end += weight;
        // Rounding may put the point at the very end, which belongs to the last weight that is not 0.
        if *weight > 0.0 {
            picked = f64::from(number);
            if at < end {
                break;
            }
        }
    }
    picked
}

/// The largest value of gradient noise before it is scaled to 1; slightly outside the middle of a cell.
const NOISE_PEAK: f64 = 1.0364;

/// Gradient noise \[PERL02\]: smooth, in [−1, 1], 0 at all points with integer coordinates.
///
/// The corners of a cell are hashed by their coordinates as numbers, so that nothing repeats, and coordinates that are
/// negative or large are like any others.
pub(crate) fn noise(point: [f64; 3]) -> f64 {
    let cell = point.map(f64::floor);
    let [x, y, z] = [0, 1, 2].map(|axis| point[axis] - cell[axis]);
    let [u, v, w] = [x, y, z].map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let start = Hasher::new(Purpose::Noise);
    let along_x = |hasher: Hasher, y, z| {
        let corner = |side: f64| slope(hasher.number(cell[0] + side).finish(), [x - side, y, z]);
        lerp(corner(0.0), corner(1.0), u)
    };
    let along_y = |hasher: Hasher, z| {
        let edge = |side: f64| along_x(hasher.number(cell[1] + side), y - side, z);
        lerp(edge(0.0), edge(1.0), v)
    };
    let face = |side: f64| along_y(start.number(cell[2] + side), z - side);
    lerp(face(0.0), face(1.0), w) / NOISE_PEAK
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// The product of an offset with one of the twelve directions to the middles of a cube's edges.
fn slope(word: u64, [x, y, z]: [f64; 3]) -> f64 {
    let (a, b) = match ((word >> 32) * 3) >> 32 {
        0 => (x, y),
        1 => (y, z),
        _ => (z, x),
    };
    let sign = |bit: u64| if word & bit == 0 { 1.0 } else { -1.0 };
    sign(1) * a + sign(2) * b
}
