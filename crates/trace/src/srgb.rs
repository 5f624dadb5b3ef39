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

/// Light in single precision as bytes, all at hand.
pub(crate) struct Bytes {
    /// The least light that is each byte, and none for one more.
    least: [f32; 257],
    /// The byte at which each step begins. From one step to the next, it changes by no more than one.
    at_step: [u8; Self::STEPS],
}

impl Bytes {
    /// What is below is black.
    const DARKEST: f32 = 1.0 / 65536.0;

    /// What is above is white.
    const BRIGHTEST: f32 = 1.0 - f32::EPSILON / 2.0;

    /// The last bits of a number that make no other step. So there are 128 steps from each light to the double of it.
    const BITS: u32 = f32::MANTISSA_DIGITS - 1 - 7;

    const STEPS: usize = 16 * 128;

    #[expect(clippy::cast_possible_truncation, reason = "rounding is meant")]
    pub(crate) fn new() -> Self {
        let (mut least, mut at_step) = ([f32::NAN; 257], [0; Self::STEPS]);
        least[0] = f32::NEG_INFINITY;
        for (byte, least) in (1..=u8::MAX).zip(&mut least[1..]) {
            let light = decode((f64::from(byte) - 0.5) / 255.0);
            let near = light as f32;
            *least = if f64::from(near) < light { near.next_up() } else { near };
        }
        let mut byte = 0;
        for (step, at_step) in (0..).zip(&mut at_step) {
            while f32::from_bits(Self::DARKEST.to_bits() + (step << Self::BITS))
                >= least[usize::from(byte) + 1]
            {
                byte += 1;
            }
            *at_step = byte;
        }
        Self { least, at_step }
    }

    /// The [encoded](encode) value, from 0 to 255 and rounded. Not a number is black.
    #[inline]
    pub(crate) fn encode(&self, linear: f32) -> u8 {
        // In this order, what is not a number is black.
        let light = if linear > Self::DARKEST { linear } else { Self::DARKEST };
        let light = if light < Self::BRIGHTEST { light } else { Self::BRIGHTEST };
        let step = (light.to_bits() - Self::DARKEST.to_bits()) >> Self::BITS;
        let byte = self.at_step[step as usize % Self::STEPS];
        byte + u8::from(linear >= self.least[usize::from(byte) + 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The slow way to it.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "an encoded value is between 0 and 1; not a number becomes 0"
    )]
    fn encode_byte(linear: f64) -> u8 {
        (encode(linear) * 255.0).round() as u8
    }

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
