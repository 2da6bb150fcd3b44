//! From linear radiance to the 8 bits of a screen: exposure, tone curve, sRGB's transfer function, rounding.
//!
//! Colours are linear sRGB (Rec. 709 primaries) on both sides of a curve. Rounding is to the nearest code; nothing is
//! dithered, so that equal radiance gives equal bytes.
//!
//! Sources: IEC 61966-2-1 for sRGB; Reinhard et al., "Photographic Tone Reproduction for Digital Images", 2002; the
//! Khronos Group's "PBR Neutral Tone Mapper" specification, 2024.

use glam::Vec3;

use crate::film::LUMINANCE;

/// Above this, a channel is as good as infinite: every curve shows it at full strength, and its arithmetic stays
/// finite.
const BRIGHTEST: f32 = 1e30;

/// The mapping of radiance to brightness on a screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMapping {
    /// Exposure in stops: the picture is brightened by two to this power before the curve. Finite.
    pub exposure: f32,
    /// The treatment of values brighter than the screen.
    pub curve: ToneCurve,
}

/// The tone curves by their names on the command line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Cuts every channel off at 1.
    #[default]
    Linear,
    /// Scales luminance `L` to `L / (1 + L)` (equation 3 of Reinhard et al.), keeping the ratios of the channels, and
    /// cuts off channels of saturated colours that still exceed 1.
    Reinhard,
    /// Khronos PBR Neutral: leaves colours alone up to 0.8 save for a shift by a dielectric's reflection (0.04), then
    /// compresses their peak and takes saturation away.
    Neutral,
}

impl ToneCurve {
    /// The names that [`ToneCurve::from_name`] knows.
    pub const NAMES: [&'static str; 3] = ["linear", "reinhard", "neutral"];

    /// The curve called `name`, or `None` if it is not one of [`ToneCurve::NAMES`].
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "linear" => Some(Self::Linear),
            "reinhard" => Some(Self::Reinhard),
            "neutral" => Some(Self::Neutral),
            _ => None,
        }
    }

    /// The name that [`ToneCurve::from_name`] takes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Reinhard => "reinhard",
            Self::Neutral => "neutral",
        }
    }
}

impl ToneMapping {
    /// Maps linear radiance to linear brightness in 0..=1. NaN and negative channels count as 0, infinite ones as
    /// brighter than any screen.
    pub fn apply(&self, radiance: [f32; 3]) -> [f32; 3] {
        let gain = self.exposure.exp2();
        let rgb = radiance.map(|channel| {
            let bright = channel * gain;
            // NaN is not above 0 either.
            if bright > 0.0 { bright.min(BRIGHTEST) } else { 0.0 }
        });
        let mapped = match self.curve {
            ToneCurve::Linear => rgb,
            ToneCurve::Reinhard => reinhard(rgb),
            ToneCurve::Neutral => neutral(rgb),
        };
        mapped.map(|channel| channel.clamp(0.0, 1.0))
    }

    /// Maps linear radiance to sRGB codes.
    pub fn to_srgb8(&self, radiance: [f32; 3]) -> [u8; 3] {
        self.apply(radiance).map(|linear| (255.0 * srgb_oetf(f64::from(linear))).round() as u8)
    }
}

/// The transfer function of sRGB, from linear light in 0..=1 to a signal in 0..=1.
fn srgb_oetf(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

fn reinhard(rgb: [f32; 3]) -> [f32; 3] {
    let luminance = Vec3::from_array(rgb).dot(LUMINANCE.as_vec3());
    rgb.map(|channel| channel / (1.0 + luminance))
}

/// The symbols are the specification's.
fn neutral(rgb: [f32; 3]) -> [f32; 3] {
    const F90: f32 = 0.04;
    const K_S: f32 = 0.8 - F90;
    const K_D: f32 = 0.15;
    let x = rgb[0].min(rgb[1]).min(rgb[2]);
    let f = if x <= 2.0 * F90 { x - x * x / (4.0 * F90) } else { F90 };
    let shifted = rgb.map(|channel| channel - f);
    let p = shifted[0].max(shifted[1]).max(shifted[2]);
    if p <= K_S {
        return shifted;
    }
    let p_n = 1.0 - (1.0 - K_S).powi(2) / (p + 1.0 - 2.0 * K_S);
    let g = 1.0 / (K_D * (p - p_n) + 1.0);
    shifted.map(|channel| channel * (p_n / p) * g + p_n * (1.0 - g))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(curve: ToneCurve) -> ToneMapping {
        ToneMapping { exposure: 0.0, curve }
    }

    fn assert_close(actual: [f32; 3], expected: [f32; 3]) {
        let close = actual.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-6);
        assert!(close, "{actual:?} instead of {expected:?}");
    }

    #[test]
    fn srgb_codes_invert_the_published_decoding() {
        // Every code, decoded by the standard's inverse, leads back to itself.
        for code in 0..=255_u8 {
            let signal = f64::from(code) / 255.0;
            let linear = if signal <= 0.04045 { signal / 12.92 } else { ((signal + 0.055) / 1.055).powf(2.4) };
            assert_eq!(with(ToneCurve::Linear).to_srgb8([linear as f32; 3]), [code; 3]);
        }
    }

    #[test]
    fn linear_values_have_their_known_codes() {
        let linear = with(ToneCurve::Linear);
        assert_eq!(linear.to_srgb8([0.18, 1.0, 0.5]), [118, 255, 188]);
        assert_eq!(linear.to_srgb8([0.0, 0.0031308, 2.0]), [0, 10, 255]);
    }

    #[test]
    fn a_stop_doubles() {
        let brighter = ToneMapping { exposure: 2.0, curve: ToneCurve::Linear };
        assert_eq!(brighter.apply([0.125, 0.25, 0.0625]), [0.5, 1.0, 0.25]);
        let darker = ToneMapping { exposure: -1.0, curve: ToneCurve::Linear };
        assert_eq!(darker.apply([0.5, 1.0, 4.0]), [0.25, 0.5, 1.0]);
    }

    #[test]
    fn what_is_no_colour_is_black_or_white() {
        for curve in ToneCurve::NAMES.map(|name| ToneCurve::from_name(name).unwrap()) {
            let mapping = with(curve);
            assert_eq!(mapping.to_srgb8([f32::NAN, -1.0, f32::NEG_INFINITY]), [0, 0, 0], "{curve:?}");
            assert_eq!(mapping.to_srgb8([f32::INFINITY; 3]), [255; 3], "{curve:?}");
            assert_eq!(mapping.to_srgb8([f32::MAX; 3]), [255; 3], "{curve:?}");
            assert_eq!(mapping.to_srgb8([f32::INFINITY, f32::NAN, 0.0])[0], 255, "{curve:?}");
        }
        assert_eq!(with(ToneCurve::Linear).to_srgb8([f32::INFINITY, 0.0, f32::NAN]), [255, 0, 0]);
    }

    #[test]
    fn reinhard_halves_a_luminance_of_one_and_keeps_hues() {
        let reinhard = with(ToneCurve::Reinhard);
        assert_close(reinhard.apply([1.0; 3]), [0.5; 3]);
        assert_close(reinhard.apply([3.0; 3]), [0.75; 3]);
        // L = 0.2126 + 0.7152/2 + 0.0722/4 = 0.58825.
        assert_close(reinhard.apply([1.0, 0.5, 0.25]), [1.0 / 1.58825, 0.5 / 1.58825, 0.25 / 1.58825]);
        assert_close(reinhard.apply([0.0, 0.0, 100.0]), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn neutral_has_the_values_of_its_specification() {
        let neutral = with(ToneCurve::Neutral);
        // Below 0.08 grey goes to x²/0.16; from there up to 0.8 it is shifted by 0.04.
        assert_close(neutral.apply([0.04; 3]), [0.01; 3]);
        assert_close(neutral.apply([0.08; 3]), [0.04; 3]);
        assert_close(neutral.apply([0.5; 3]), [0.46; 3]);
        assert_close(neutral.apply([0.8; 3]), [0.76; 3]);
        // Without a smallest channel there is no shift.
        assert_close(neutral.apply([0.7, 0.3, 0.0]), [0.7, 0.3, 0.0]);
        // Worked by hand in fractions: p = 1.96, p_n = 1 - 0.0576/1.44 = 0.96 for grey of 2.
        assert_close(neutral.apply([2.0; 3]), [0.96; 3]);
        // A red of 1.96 has the same p and p_n, and g = 1/(0.15 + 1): what is missing from 1 goes to all channels.
        assert_close(neutral.apply([1.96, 0.0, 0.0]), [0.96, 0.96 * 3.0 / 23.0, 0.96 * 3.0 / 23.0]);
    }

    #[test]
    fn names_lead_to_curves_and_back() {
        for name in ToneCurve::NAMES {
            assert_eq!(ToneCurve::from_name(name).map(ToneCurve::name), Some(name));
        }
        assert_eq!(ToneCurve::from_name("Linear"), None);
    }
}
