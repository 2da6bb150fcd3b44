//! Fresnel's equations for smooth glass and light without polarisation.

/// The part of light that is reflected where a ray meets the border of two media under `cosine` (0 to 1), and the
/// cosine under which the rest goes on. `ratio` is the refractive index of the ray's medium over that of the one
/// beyond. All is reflected beyond the critical angle, where the second number is 0.
pub(super) fn fresnel(cosine: f32, ratio: f32) -> (f32, f32) {
    let cosine = cosine.clamp(0.0, 1.0);
    // Snell's law.
    let sine_squared_beyond = ratio * ratio * (1.0 - cosine * cosine);
    if sine_squared_beyond >= 1.0 {
        return (1.0, 0.0);
    }
    let beyond = (1.0 - sine_squared_beyond).sqrt();
    let across = (ratio * cosine - beyond) / (ratio * cosine + beyond);
    let along = (cosine - ratio * beyond) / (cosine + ratio * beyond);
    (0.5 * (across * across + along * along), beyond)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_reflects_what_the_textbook_says() {
        // ((n - 1)/(n + 1))² = 0.04 for n = 1.5, from both sides.
        for ratio in [1.5, 1.0 / 1.5] {
            let (reflected, beyond) = fresnel(1.0, ratio);
            assert!((reflected - 0.04).abs() < 1e-7 && beyond == 1.0, "{ratio}: {reflected}");
        }
        assert_eq!(fresnel(0.0, 1.0 / 1.5).0, 1.0, "grazing light is reflected");
        let (reflected, beyond) = fresnel(0.3, 1.0);
        assert!(reflected < 1e-12 && (beyond - 0.3).abs() < 1e-6, "equal media are no border: {reflected}, {beyond}");
    }

    #[test]
    fn no_light_of_one_polarisation_is_reflected_at_brewsters_angle() {
        // tan θ = n: what is reflected is across alone, ((n² - 1)/(n² + 1))² / 2.
        let n = 1.5f32;
        let (reflected, _) = fresnel(1.0 / (1.0 + n * n).sqrt(), 1.0 / n);
        let expected = 0.5 * ((n * n - 1.0) / (n * n + 1.0)).powi(2);
        assert!((reflected - expected).abs() < 1e-7, "{reflected}, not {expected}");
    }

    #[test]
    fn beyond_the_critical_angle_all_is_reflected() {
        // sin θ = 1/n at the critical angle.
        let critical = (1.0 - 1.0 / 2.25f32).sqrt();
        assert_eq!(fresnel(critical - 1e-4, 1.5), (1.0, 0.0));
        assert!(fresnel(critical + 1e-4, 1.5).0 < 1.0);
    }

    #[test]
    fn the_way_back_reflects_as_much() {
        // Not for grazing rays, whose cosine is the root of a small difference.
        for i in 10..100 {
            let cosine = i as f32 / 100.0;
            let (there, beyond) = fresnel(cosine, 1.0 / 1.5);
            let (back, before) = fresnel(beyond, 1.5);
            assert!((there - back).abs() < 1e-5 && (cosine - before).abs() < 1e-5, "{cosine}: {there}, {back}");
        }
    }
}
