//! Spectra as colours in linear sRGB.
//!
//! A spectrum has samples `[wavelength value ...]` in nanometres and is linear in between. A light's spectrum is
//! integrated with the CIE's colour matching functions (the fit by Wyman, Sloan and Shirley, "Simple Analytic
//! Approximations to the CIE XYZ Color Matching Functions", JCGT 2013) and, as in pbrt, scaled to a luminance of 1; a
//! reflectance is evaluated under illuminant D65, so that a constant one is grey. Negative components of colours
//! outside sRGB are clamped.

use std::path::Path;

use glam::{DMat3, DVec3, Vec3};

use super::parameters::{Parameter, Parameters, Values};
use super::tokens::At;
use crate::scene::{Files, SceneError};

/// The luminance of linear sRGB by its channels, with as many digits as pbrt has.
pub(super) const LUMINANCE: Vec3 = Vec3::new(0.2126729, 0.7151522, 0.072175);

/// A colour as a file has it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Spectrum {
    Rgb(Vec3),
    /// A black body's temperature, K.
    Blackbody(f64),
    /// Samples by wavelength in nm, in rising order.
    Samples(Vec<(f64, f64)>),
    /// One of pbrt's own.
    Named(String),
}

/// Complex refractive indices `[n, k]` in red, green and blue: those that have the metal's colour under D65 at 0° and
/// 82°, by the spectra of pbrt and Mitsuba (refractiveindex.info and Palik, "Handbook of Optical Constants of Solids");
/// of brass those at 650, 550 and 450 nm (Querry 1985).
const METALS: [(&str, [[f32; 3]; 2]); 7] = [
    ("Ag", [[0.1289, 0.1242, 0.1512], [4.0735, 3.3467, 2.4096]]),
    ("Al", [[1.4189, 0.9332, 0.5909], [7.7237, 6.6166, 5.3628]]),
    ("Au", [[0.0358, 0.4078, 1.5622], [7.0305, 2.3594, 1.7194]]),
    ("Cu", [[0.1552, 0.9714, 1.2091], [3.3571, 2.6238, 2.3632]]),
    ("CuZn", [[0.444, 0.527, 1.094], [3.695, 2.765, 1.829]]),
    ("MgO", [[1.7339, 1.7409, 1.7536], [0.0034, 0.0038, 0.0041]]),
    ("TiO2", [[2.8626, 2.9557, 3.1863], [0.0142, 0.0152, 0.0175]]),
];

/// Refractive indices of Schott's glasses at 587.6 nm, and their Abbe numbers.
const GLASSES: [(&str, f32, f32); 7] = [
    ("glass-BK7", 1.5168, 64.17),
    ("glass-BAF10", 1.6700, 47.11),
    ("glass-FK51A", 1.4866, 84.47),
    ("glass-LASF9", 1.8503, 32.17),
    ("glass-F5", 1.6727, 32.25),
    ("glass-F10", 1.7283, 28.53),
    ("glass-F11", 1.7847, 25.76),
];

/// Where Abbe's number compares refractive indices, in nm: Fraunhofer's lines F and C.
const ABBE_WAVELENGTHS: [f64; 2] = [486.1, 656.3];

/// The refractive index and the Abbe number of a glass.
fn glass(name: &str) -> Option<(f32, f32)> {
    let name = name.replace("glass-SF", "glass-F");
    GLASSES.iter().find(|(known, ..)| *known == name).map(|(_, index, abbe)| (*index, *abbe))
}

/// Standard illuminants by the temperature of a black body or daylight that looks like them.
const ILLUMINANTS: [(&str, f64); 3] = [("stdillum-A", 2856.0), ("stdillum-D50", 5003.0), ("illum-acesD60", 6000.0)];

/// Illuminant D65 from 380 nm in steps of 20 nm (ISO 11664-2).
const D65: [f64; 21] = [
    49.9755, 82.7549, 93.4318, 104.865, 117.812, 115.923, 109.354, 104.790, 104.405, 100.0, 95.788, 90.0062, 87.6987,
    83.6992, 80.2146, 78.2842, 71.6091, 61.604, 75.087, 46.4182, 63.3828,
];

/// Wavelengths that represent red, green and blue where a spectrum is not a colour.
const RGB_WAVELENGTHS: [f64; 3] = [630.0, 540.0, 465.0];

/// The yellow line of helium, at which refractive indices are given.
const INDEX_WAVELENGTH: f64 = 587.6;

impl Spectrum {
    /// The parameter of this name; spectra in files are read relative to `folder`.
    pub(super) fn read(
        parameters: &Parameters,
        name: &str,
        files: &dyn Files,
        folder: &Path,
    ) -> Result<Option<Self>, SceneError> {
        let Some(found) = parameters.get(name) else { return Ok(None) };
        let spectrum = match (&found.values, found.kind) {
            (Values::Numbers(numbers), "float") if numbers.len() == 1 => Self::Rgb(Vec3::splat(numbers[0])),
            (Values::Numbers(numbers), "rgb" | "color") if numbers.len() == 3 => Self::Rgb(Vec3::from_slice(numbers)),
            (Values::Numbers(numbers), "blackbody") if numbers.len() == 1 && numbers[0] > 0.0 => {
                Self::Blackbody(numbers[0].into())
            }
            (Values::Numbers(numbers), "spectrum") => Self::Samples(samples(numbers, found)?),
            (Values::Words(words), "spectrum") if words.len() == 1 => named(&words[0], &found.at, files, folder)?,
            _ => {
                let problem = format!("`{name}` of {} is no colour", parameters.of);
                let remedy = format!("write `\"rgb {name}\" [ r g b ]`, a blackbody in kelvin, or a spectrum");
                return Err(found.at.error(problem, remedy));
            }
        };
        if let Self::Rgb(rgb) = spectrum
            && rgb.min_element() < 0.0
        {
            return Err(found.at.error(format!("`{name}` of {} is negative", parameters.of), "write 0 or more"));
        }
        Ok(Some(spectrum))
    }

    /// The colour of a light: of all but colours its luminance is 1. `None` if the name is not known.
    pub(super) fn light(&self) -> Option<Vec3> {
        match self {
            Self::Rgb(rgb) => Some(*rgb),
            Self::Blackbody(kelvin) => Some(of_luminance_1(|nm| planck(nm, *kelvin))),
            Self::Samples(samples) => Some(of_luminance_1(|nm| interpolate(samples, nm))),
            Self::Named(name) if name == "stdillum-D65" => Some(Vec3::ONE),
            Self::Named(name) => {
                let (_, kelvin) = ILLUMINANTS.iter().find(|(known, _)| known == name)?;
                Some(of_luminance_1(|nm| planck(nm, *kelvin)))
            }
        }
    }

    /// The colour of a surface, 0 to 1 if the spectrum is.
    pub(super) fn reflectance(&self) -> Option<Vec3> {
        match self {
            Self::Rgb(rgb) => Some(*rgb),
            Self::Samples(samples) => {
                let under_d65 = |reflectance: &dyn Fn(f64) -> f64| to_rgb(|nm| d65(nm) * reflectance(nm));
                let color = under_d65(&|nm| interpolate(samples, nm)) / under_d65(&|_| 1.0);
                Some(color.max(DVec3::ZERO).as_vec3())
            }
            Self::Blackbody(_) | Self::Named(_) => None,
        }
    }

    /// A dielectric's refractive index.
    pub(super) fn refractive_index(&self) -> Option<f32> {
        match self {
            Self::Rgb(rgb) => Some(rgb.element_sum() / 3.0),
            Self::Samples(samples) => Some(interpolate(samples, INDEX_WAVELENGTH) as f32),
            Self::Named(name) => glass(name).map(|(index, _)| index),
            Self::Blackbody(_) => None,
        }
    }

    /// 20 by a dielectric's Abbe number; 0 if it is not known or there is no dispersion.
    pub(super) fn dispersion(&self) -> f32 {
        match self {
            Self::Samples(samples) => {
                let ends = [samples.first(), samples.last()].map(|end| end.map_or(0.0, |(wavelength, _)| *wavelength));
                let [f, c] = ABBE_WAVELENGTHS.map(|nm| interpolate(samples, nm.clamp(ends[0], ends[1])));
                let index = interpolate(samples, INDEX_WAVELENGTH);
                if index > 1.0 { (20.0 * (f - c) / (index - 1.0)).max(0.0) as f32 } else { 0.0 }
            }
            Self::Named(name) => glass(name).map_or(0.0, |(_, abbe)| 20.0 / abbe),
            Self::Rgb(_) | Self::Blackbody(_) => 0.0,
        }
    }

    /// A metal's `n` (0) or `k` (1).
    pub(super) fn metal_index(&self) -> Option<Vec3> {
        match self {
            Self::Rgb(rgb) => Some(*rgb),
            Self::Samples(samples) => Some(Vec3::from_array(RGB_WAVELENGTHS.map(|nm| interpolate(samples, nm) as f32))),
            Self::Named(name) => {
                let (name, part) = name.strip_prefix("metal-")?.rsplit_once('-')?;
                let part = ["eta", "k"].iter().position(|known| *known == part)?;
                METALS.iter().find(|(known, _)| *known == name).map(|(_, index)| Vec3::from_array(index[part]))
            }
            Self::Blackbody(_) => None,
        }
    }
}

/// One of pbrt's names, or that of a file.
fn named(name: &str, at: &At, files: &dyn Files, folder: &Path) -> Result<Spectrum, SceneError> {
    let path = folder.join(name);
    if !files.contains(&path) {
        return Ok(Spectrum::Named(name.to_owned()));
    }
    let bytes = files.read(&path).map_err(|error| SceneError::unreadable(&path, &error))?;
    let text = String::from_utf8_lossy(&bytes);
    let words = text.lines().flat_map(|line| line.split('#').next().unwrap_or_default().split_ascii_whitespace());
    let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok().filter(|it: &f64| it.is_finite())).collect();
    let problem = || at.error(format!("{} is no spectrum", path.display()), "write lines of a wavelength and a value");
    pairs(&numbers.ok_or_else(problem)?).map(Spectrum::Samples).ok_or_else(problem)
}

fn samples(numbers: &[f32], found: &Parameter) -> Result<Vec<(f64, f64)>, SceneError> {
    let numbers: Vec<f64> = numbers.iter().copied().map(f64::from).collect();
    pairs(&numbers).ok_or_else(|| {
        let problem = format!("`{}` is no list of wavelengths and values", found.name);
        found.at.error(problem, "write `[ 400 0.1 700 0.5 ]`, with wavelengths in rising order")
    })
}

/// Wavelengths in rising order with their values.
fn pairs(numbers: &[f64]) -> Option<Vec<(f64, f64)>> {
    let pairs: Vec<(f64, f64)> = numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
    let rises = pairs.windows(2).all(|pair| pair[0].0 < pair[1].0);
    (numbers.len().is_multiple_of(2) && !pairs.is_empty() && rises).then_some(pairs)
}

/// Linear between the samples, and 0 beyond them; a single one counts everywhere.
fn interpolate(samples: &[(f64, f64)], nm: f64) -> f64 {
    let above = samples.partition_point(|(wavelength, _)| *wavelength <= nm);
    match (above.checked_sub(1).map(|below| samples[below]), samples.get(above)) {
        _ if samples.len() == 1 => samples[0].1,
        (Some((x0, y0)), Some((x1, y1))) => y0 + (y1 - y0) * (nm - x0) / (x1 - x0),
        (Some((wavelength, value)), None) if wavelength == nm => value,
        _ => 0.0,
    }
}

fn d65(nm: f64) -> f64 {
    let place = ((nm - 380.0) / 20.0).clamp(0.0, 19.999);
    let (index, part) = (place as usize, place.fract());
    D65[index] * (1.0 - part) + D65[index + 1] * part
}

/// Planck's law, in any unit.
fn planck(nm: f64, kelvin: f64) -> f64 {
    // The second radiation constant, nm K.
    const C2: f64 = 1.438_776_877e7;
    (nm / 560.0).powi(-5) / (C2 / (nm * kelvin)).exp_m1()
}

/// `x`, `y` and `z` of the CIE's 1931 observer.
fn matching(nm: f64) -> DVec3 {
    let lobe = |mean: f64, below: f64, above: f64| {
        let t = (nm - mean) * if nm < mean { below } else { above };
        (-0.5 * t * t).exp()
    };
    DVec3::new(
        0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323) - 0.065 * lobe(501.1, 0.0490, 0.0382),
        0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322),
        1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725),
    )
}

fn to_xyz(spectrum: impl Fn(f64) -> f64) -> DVec3 {
    (380..=780).map(|nm| matching(nm.into()) * spectrum(nm.into())).sum()
}

/// CIE XYZ to linear sRGB (IEC 61966-2-1).
fn from_xyz(xyz: DVec3) -> DVec3 {
    let columns =
        [[3.2404542, -0.9692660, 0.0556434], [-1.5371385, 1.8760108, -0.2040259], [-0.4985314, 0.0415560, 1.0572252]];
    DMat3::from_cols_array_2d(&columns) * xyz
}

fn to_rgb(spectrum: impl Fn(f64) -> f64) -> DVec3 {
    from_xyz(to_xyz(spectrum))
}

fn of_luminance_1(spectrum: impl Fn(f64) -> f64) -> Vec3 {
    let xyz = to_xyz(spectrum);
    if xyz.y <= 0.0 { Vec3::ZERO } else { from_xyz(xyz / xyz.y).max(DVec3::ZERO).as_vec3() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::fresnel::complex_index_colors;

    #[test]
    fn black_bodies_have_their_published_chromaticities() {
        // CIE 1931 x and y of the Planckian locus (Wyszecki and Stiles).
        for (kelvin, x, y) in [(2000.0, 0.5267, 0.4133), (2856.0, 0.4476, 0.4074), (6500.0, 0.3135, 0.3237)] {
            let xyz = to_xyz(|nm| planck(nm, kelvin));
            let found = xyz / xyz.element_sum();
            assert!((found.x - x).abs() < 0.004 && (found.y - y).abs() < 0.004, "{kelvin} K: {found}");
        }
        let lamp = Spectrum::Blackbody(3000.0).light().unwrap();
        assert!((lamp.dot(LUMINANCE) - 1.0).abs() < 1e-3 && lamp.x > lamp.y && lamp.y > lamp.z, "{lamp}");
        let daylight = to_xyz(d65);
        let found = daylight / daylight.element_sum();
        assert!((found.x - 0.3127).abs() < 0.003 && (found.y - 0.3290).abs() < 0.003, "{found}");
    }

    #[test]
    fn grey_is_grey_and_samples_are_scaled_to_a_luminance_of_1() {
        let grey = Spectrum::Samples(vec![(300.0, 0.25), (900.0, 0.25)]);
        assert!((grey.reflectance().unwrap() - 0.25).abs().max_element() < 1e-6);
        let red =
            Spectrum::Samples(vec![(300.0, 0.0), (590.0, 0.0), (600.0, 0.8), (900.0, 0.8)]).reflectance().unwrap();
        assert!(red.x > 0.7 && red.y < 0.1 && red.z < 0.05, "{red}");
        assert!((grey.light().unwrap().dot(LUMINANCE) - 1.0).abs() < 1e-3);
        assert_eq!(Spectrum::Rgb(Vec3::X).light(), Some(Vec3::X));
    }

    #[test]
    fn metals_have_their_colours() {
        let color = |metal: &str| {
            let index = |part: &str| Spectrum::Named(format!("metal-{metal}-{part}")).metal_index().unwrap();
            complex_index_colors(index("eta"), index("k"))[0]
        };
        // Lagarde 2011 and Hoffman, "Real-Time Rendering": reflectance at normal incidence, linear.
        for (metal, expected) in
            [("Ag", [0.972, 0.960, 0.915]), ("Al", [0.913, 0.922, 0.924]), ("Au", [1.0, 0.782, 0.344])]
        {
            assert!((color(metal) - Vec3::from(expected)).abs().max_element() < 0.01, "{metal}: {}", color(metal));
        }
        assert!((color("Cu") - Vec3::new(0.955, 0.638, 0.538)).abs().max_element() < 0.01);
        assert_eq!(Spectrum::Named("metal-Xx-eta".to_owned()).metal_index(), None);
        assert_eq!(Spectrum::Named("glass-BK7".to_owned()).refractive_index(), Some(1.5168));
    }

    #[test]
    fn samples_are_linear_in_between() {
        let samples = [(400.0, 1.0), (500.0, 3.0)];
        let found = [399.0, 400.0, 450.0, 500.0, 501.0].map(|nm| interpolate(&samples, nm));
        assert_eq!(found, [0.0, 1.0, 2.0, 3.0, 0.0]);
        assert_eq!(interpolate(&[(1.0, 7.0)], 555.0), 7.0);
    }
}
