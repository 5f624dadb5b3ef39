//! Random numbers without a state: points of a Sobol sequence, shuffled and scrambled by hashes \[BURL20\].
//!
//! A number is a function of the pixel, the sample and the dimension, so that pictures do not depend on who asks when. The
//! samples of a pixel share a sequence: in each dimension they are spread evenly over the square, any first so many of
//! them as well. Between dimensions and between pixels the sequences are shuffled, as if independent. Scrambling leaves
//! each point uniformly distributed, and so every mean without bias \[OWEN95\].

use glam::DVec2;

/// The numbers of one sample of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sampler {
    pixel: u32,
    sample: u32,
}

impl Sampler {
    pub(crate) fn new((x, y): (u32, u32), sample: u32) -> Self {
        Self { pixel: hash(x ^ hash(y)), sample }
    }

    /// A point in the unit square, without its right and upper border.
    pub(crate) fn square(&self, dimension: u32) -> DVec2 {
        let seed = hash(self.pixel ^ hash(dimension));
        let index = scramble(self.sample, seed);
        let [x, y] = sobol(index);
        DVec2::new(unit(scramble(x, hash(seed ^ 1))), unit(scramble(y, hash(seed ^ 2))))
    }
}

/// The first two dimensions of the sequence, as binary fractions.
fn sobol(index: u32) -> [u32; 2] {
    let mut direction = 1 << 31;
    let mut second = 0;
    for bit in 0..32 {
        if index >> bit & 1 == 1 {
            second ^= direction;
        }
        direction ^= direction >> 1;
    }
    [index.reverse_bits(), second]
}

/// Owen's scrambling: each bit is flipped by a random function of the bits above it.
fn scramble(fraction: u32, seed: u32) -> u32 {
    // In a product, a bit depends on those below it.
    let mut bits = fraction.reverse_bits().wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        bits ^= bits.wrapping_mul(factor);
    }
    bits.reverse_bits()
}

/// Scatters numbers; one to one.
fn hash(mut bits: u32) -> u32 {
    bits = (bits ^ 0x9e37_79b9 ^ bits >> 16).wrapping_mul(0x7feb_352d);
    bits = (bits ^ bits >> 15).wrapping_mul(0x846c_a68b);
    bits ^ bits >> 16
}

fn unit(fraction: u32) -> f64 {
    f64::from(fraction) / 4_294_967_296.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first 2ᵏ points have one point in each of 2ᵏ rectangles, whatever these are long and wide.
    #[test]
    fn samples_of_a_pixel_are_spread_evenly() {
        for (pixel, dimension) in [((0, 0), 0), ((3, 200), 1), ((640, 480), 7)] {
            for columns in [1, 2, 4, 8, 16, 32, 64] {
                let rows = 64 / columns;
                let mut taken = [false; 64];
                for sample in 0..64 {
                    let point = Sampler::new(pixel, sample).square(dimension);
                    let part = |value: f64, parts: u32| {
                        (1..=parts).find(|part| value * f64::from(parts) < f64::from(*part)).unwrap() - 1
                    };
                    let place = part(point.y, rows) * columns + part(point.x, columns);
                    assert!(!std::mem::replace(&mut taken[place as usize], true), "{columns} by {rows}");
                }
            }
        }
    }

    #[test]
    fn pixels_and_dimensions_are_as_if_independent() {
        let pairs: Vec<[f64; 2]> = (0..10_000)
            .map(|pixel| {
                [((pixel, 5), 3), ((pixel + 1, 5), 3)].map(|(pixel, d)| Sampler::new(pixel, 0).square(d).x)
            })
            .chain((0..10_000).map(|pixel| [0, 1].map(|d| Sampler::new((pixel, 9), 0).square(d).x)))
            .collect();
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / pairs.len() as f64;
        assert!((mean(&mut pairs.iter().map(|pair| pair[0])) - 0.5).abs() < 0.01);
        let covariance = mean(&mut pairs.iter().map(|[a, b]| (a - 0.5) * (b - 0.5)));
        assert!(covariance.abs() < 0.003, "{covariance}");
    }
}
