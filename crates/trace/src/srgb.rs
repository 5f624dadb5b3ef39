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
    /// The least light that is each byte.
    least: [f32; 256],
    /// The byte at each step from 0 to 1.
    at_step: [u8; Self::STEPS + 1],
}

impl Bytes {
    const STEPS: usize = 1024;

    pub(crate) fn new() -> Self {
        let (mut least, mut at_step) = ([0.0; 256], [0; Self::STEPS + 1]);
        for (byte, least) in (0..=u8::MAX).zip(&mut least) {
            // The bits of positive numbers are in their order.
            let (mut below, mut found) = (0, 1.0_f32.to_bits());
            while byte > 0 && found - below > 1 {
                let middle = below.midpoint(found);
                let reaches = encode_byte(f64::from(f32::from_bits(middle))) >= byte;
                if reaches { found = middle } else { below = middle }
            }
            *least = if byte > 0 { f32::from_bits(found) } else { f32::NEG_INFINITY };
        }
        for (step, byte) in at_step.iter_mut().enumerate() {
            *byte = encode_byte(step as f64 / Self::STEPS as f64);
        }
        Self { least, at_step }
    }

    /// As [`encode_byte`].
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a step from 0 to STEPS")]
    pub(crate) fn encode(&self, linear: f32) -> u8 {
        let step = (linear.clamp(0.0, 1.0) * Self::STEPS as f32) as usize;
        let mut byte = self.at_step[step];
        while byte < u8::MAX && linear >= self.least[usize::from(byte) + 1] {
            byte += 1;
        }
        byte
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
