//! Trigonometry in degrees, the same on every machine and exact at multiples of 90°.

use std::f64::consts::PI;

/// Sine and cosine of an angle in degrees.
///
/// The angle is reduced before it is turned into radians, which is exact, so that a quarter turn is a permutation of
/// axes and not one within rounding.
pub(crate) fn sin_cos(degrees: f64) -> (f64, f64) {
    let turn = degrees % 360.0;
    let quarter = (turn / 90.0).round();
    let rest = (turn - quarter * 90.0) * (PI / 180.0);
    let (sin, cos) = (libm::sin(rest), libm::cos(rest));
    match quarter.rem_euclid(4.0) {
        1.0 => (cos, -sin),
        2.0 => (-sin, -cos),
        3.0 => (-cos, sin),
        _ => (sin, cos),
    }
}

#[cfg(test)]
mod tests {
    use super::sin_cos;

    #[test]
    fn quarter_turns_are_exact() {
        let quarters = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)];
        for turns in -9_i32..=9 {
            let expected = quarters[turns.rem_euclid(4) as usize];
            assert_eq!(sin_cos(f64::from(turns) * 90.0), expected, "{turns} quarter turns");
        }
    }

    #[test]
    fn agrees_with_radians() {
        for degrees in -1000..1000 {
            let degrees = f64::from(degrees) * 0.73;
            let (sin, cos) = sin_cos(degrees);
            assert!((sin - libm::sin(degrees.to_radians())).abs() < 1e-13, "sin {degrees}");
            assert!((cos - libm::cos(degrees.to_radians())).abs() < 1e-13, "cos {degrees}");
        }
    }
}
