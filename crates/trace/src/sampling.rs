//! Where the samples of a pixel are: at fixed places, the same in every pixel and every run, and in an order of which any
//! beginning is spread over the pixel.

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

/// The same places in the order in which they are taken: first the one next to the centre, then always the one that is
/// repelled least by those before it and by their images in the neighbouring pixels. So the first samples make a picture
/// already, and what they say of a pixel is said of all of it.
///
/// Takes time in proportion to the square of `count`: a tenth of a second for the most that there are.
pub(crate) fn sequence(count: u32) -> Vec<DVec2> {
    let mut left: Vec<(DVec2, f64)> = places(count).map(|place| (place, 0.0)).collect();
    let mut taken = Vec::with_capacity(left.len());
    let mut next = left.len().saturating_sub(1) / 2;
    while !left.is_empty() {
        let (place, _) = left.remove(next);
        taken.push(place);
        let mut least = f64::INFINITY;
        for (index, (other, repulsion)) in left.iter_mut().enumerate() {
            let across = *other - place;
            *repulsion += 1.0 / (across - across.round()).length_squared();
            if *repulsion < least {
                (next, least) = (index, *repulsion);
            }
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_has_all_places_and_any_beginning_is_spread() {
        for count in (1..=40).chain([64, 100, 256, 500, 2000]) {
            let sequence = sequence(count);
            let mut sorted = sequence.clone();
            sorted.sort_by(|a, b| a.x.total_cmp(&b.x));
            assert_eq!(sorted, places(count).collect::<Vec<_>>());
            // Random places lean by 0.4 · n^(−1/2) on the average, and would soon fail.
            let mut sum = DVec2::ZERO;
            for (taken, place) in (1_u32..).zip(&sequence) {
                sum += *place - 0.5;
                let n = f64::from(taken);
                let lean = (sum / n).length();
                assert!(lean < 1.6 / libm::pow(n, 0.75), "{taken} of {count} lean by {lean}");
            }
        }
    }

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
