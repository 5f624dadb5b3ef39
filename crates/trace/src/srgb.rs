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

/// The encoded value as a byte. Not a number is black.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "an encoded value is between 0 and 1, so that this is between 0 and 255; not a number becomes 0"
)]
pub(crate) fn encode_byte(linear: f64) -> u8 {
    (encode(linear) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

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
