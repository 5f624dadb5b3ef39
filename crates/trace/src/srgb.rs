//! The transfer curve of sRGB (IEC 61966-2-1), with the same bits on every machine.

/// The linear light that an encoded value from 0 to 1 stands for.
pub(crate) fn decode(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// The encoded value, from 0 to 1, of linear light. What a screen cannot show is clamped.
pub(crate) fn encode(linear: f64) -> f64 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

/// The encoded value as a byte. Not a number is black. Takes a power; for whole pictures there are [`Bytes`].
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "an encoded value is between 0 and 1, so that this is between 0 and 255; not a number becomes 0"
)]
pub(crate) fn encode_byte(linear: f64) -> u8 {
    (encode(linear) * 255.0).round() as u8
}

/// Light in single precision as bytes, all at hand.
pub(crate) struct Bytes {
    /// The least light that is each byte, and none for one more.
    least: [f32; 257],
    /// The byte at each step from 0 to 1. From one step to the next, it changes by no more than one.
    at_step: [u8; Self::STEPS + 1],
}

impl Bytes {
    const STEPS: usize = 4096;

    #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
    pub(crate) fn new() -> Self {
        let (mut least, mut at_step) = ([f32::NAN; 257], [0; Self::STEPS + 1]);
        least[0] = f32::NEG_INFINITY;
        for (byte, least) in (1..=u8::MAX).zip(&mut least[1..]) {
            let reaches = |light: f32| encode_byte(f64::from(light)) >= byte;
            *least = decode((f64::from(byte) - 0.5) / 255.0) as f32;
            while !reaches(*least) {
                *least = least.next_up();
            }
            while reaches(least.next_down()) {
                *least = least.next_down();
            }
        }
        let mut byte = 0;
        for (step, at_step) in at_step.iter_mut().enumerate() {
            while step as f32 / Self::STEPS as f32 >= least[usize::from(byte) + 1] {
                byte += 1;
            }
            *at_step = byte;
        }
        Self { least, at_step }
    }

    /// As [`encode_byte`].
    #[inline]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a step from 0 to STEPS")]
    pub(crate) fn encode(&self, linear: f32) -> u8 {
        let step = (linear.clamp(0.0, 1.0) * Self::STEPS as f32) as usize;
        let byte = self.at_step[step];
        byte + u8::from(linear >= self.least[usize::from(byte) + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_at_hand_are_those_of_the_curve() {
        let bytes = Bytes::new();
        let close = bytes.least[1..]
            .iter()
            .flat_map(|least| (-3..=3).map(|ulps| f32::from_bits(least.to_bits().wrapping_add_signed(ulps))));
        let even = (-10..200_000).map(|step| step as f32 / 180_000.0);
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, f32::MIN_POSITIVE];
        for light in close.chain(even).chain(odd) {
            assert_eq!(bytes.encode(light), encode_byte(f64::from(light)), "{light:e}");
        }
    }

    #[test]
    fn bytes_survive_decoding_and_encoding() {
        for byte in 0..=255 {
            assert_eq!(encode_byte(decode(f64::from(byte) / 255.0)), byte);
        }
    }

    #[test]
    fn known_values() {
        assert_eq!([0.0, 0.2, 0.55, 0.7, 0.9, 1.0].map(encode_byte), [0, 124, 196, 218, 243, 255]);
    }

    #[test]
    fn what_no_screen_can_show() {
        assert_eq!([-1.0, f64::NAN, f64::NEG_INFINITY].map(encode_byte), [0; 3]);
        assert_eq!([1.1, f64::INFINITY].map(encode_byte), [255; 2]);
    }
}
