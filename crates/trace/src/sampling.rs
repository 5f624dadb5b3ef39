//! Where the samples of a pixel are: at fixed places, the same in every pixel and every run.

use glam::DVec2;

/// 1/φ. Its multiples stay farther from each other, modulo 1, than those of any other number.
const INVERSE_GOLDEN: f64 = 0.618_033_988_749_894_9;

/// `count` places in the unit square, spread evenly, with the centre as their mean. A single one is the centre.
///
/// A lattice: the abscissae are evenly spaced and the ordinates are multiples of 1/φ modulo 1, counted from the middle, so
/// that the places lie symmetrically about the centre and a pixel does not shift with the number of its samples.
pub(crate) fn places(count: u32) -> impl Iterator<Item = DVec2> + Clone {
    let n = f64::from(count);
    (0..count).map(move |index| {
        let step = f64::from(index) - 0.5 * (n - 1.0);
        let ordinate = step * INVERSE_GOLDEN;
        DVec2::new(0.5 + step / n, 0.5 + ordinate - ordinate.round())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sample_is_the_centre() {
        assert_eq!(places(1).collect::<Vec<_>>(), [DVec2::splat(0.5)]);
    }

    #[test]
    fn samples_are_centred_and_apart() {
        for count in 2..=100_u32 {
            let places: Vec<_> = places(count).collect();
            let n = f64::from(count);
            let mean = places.iter().sum::<DVec2>() / n;
            assert!(mean.distance(DVec2::splat(0.5)) < 1e-12, "{count} samples lean to {mean}");
            for (index, place) in places.iter().enumerate() {
                assert!(place.cmpgt(DVec2::ZERO).all() && place.cmplt(DVec2::ONE).all());
                for other in &places[..index] {
                    assert!(place.distance(*other) > 0.6 / n.sqrt(), "{count} samples, two are close");
                }
            }
        }
    }
}
