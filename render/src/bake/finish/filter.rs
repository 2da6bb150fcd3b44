//! How engines sample a map: the weights of the texels around a point.

use glam::DVec2;

use crate::bake::layout::atlas::Page;
use crate::bake::options::Sampling;

/// The texels that a sample mixes, as indices into a page, with weights that add up to 1.
pub(crate) type Footprint = Vec<(u32, f64)>;

/// The footprint of a sample at a place in texels. Coordinates beyond a page are clamped.
pub(crate) fn footprint(sampling: Sampling, page: Page, place: DVec2) -> Footprint {
    let corner = (place - 0.5).floor();
    let part = place - 0.5 - corner;
    let (first, [across, down]) = match sampling {
        Sampling::Bilinear => (0, part.to_array().map(|part| [1.0 - part, part, 0.0, 0.0])),
        Sampling::Bicubic => (-1, part.to_array().map(b_spline)),
    };
    let clamped =
        |start: f64, step: i32, length: u32| (start + f64::from(step)).clamp(0.0, f64::from(length) - 1.0) as u32;
    let mut footprint = Footprint::new();
    for (y, down) in (first..).zip(down).filter(|(_, weight)| *weight != 0.0) {
        for (x, across) in (first..).zip(across).filter(|(_, weight)| *weight != 0.0) {
            let texel = clamped(corner.y, y, page.height) * page.width + clamped(corner.x, x, page.width);
            match footprint.iter_mut().find(|(index, _)| *index == texel) {
                Some((_, weight)) => *weight += across * down,
                None => footprint.push((texel, across * down)),
            }
        }
    }
    footprint
}

/// The cubic B-spline's weights of the texels at -1, 0, 1 and 2 for a point between 0 and 1.
fn b_spline(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    let inner = |t: f64| (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0;
    [s * s * s / 6.0, inner(t), inner(s), t * t * t / 6.0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;

    const PAGE: Page = Page { width: 7, height: 5 };

    fn sample(sampling: Sampling, place: DVec2, value: impl Fn(f64, f64) -> f64) -> f64 {
        let centre = |texel: u32| (f64::from(texel % 7) + 0.5, f64::from(texel / 7) + 0.5);
        footprint(sampling, PAGE, place)
            .iter()
            .map(|&(texel, weight)| {
                let (x, y) = centre(texel);
                weight * value(x, y)
            })
            .sum()
    }

    #[test]
    fn weights_add_up_and_linear_maps_are_sampled_exactly() {
        for i in 0..200 {
            let place = dvec2(0.031 * f64::from(i), 0.027 * f64::from(i)) + 0.1;
            for sampling in Sampling::ALL {
                let footprint = footprint(sampling, PAGE, place);
                assert!((footprint.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
                assert!(footprint.len() <= 16);
                let inside = place.min_element() > 1.5 && place.x < 5.5 && place.y < 3.5;
                let found = sample(sampling, place, |x, y| 2.0 * x - 3.0 * y + 1.0);
                assert!(!inside || (found - (2.0 * place.x - 3.0 * place.y + 1.0)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_spline_adds_its_variance_to_a_parabola() {
        // The cubic B-spline has the variance 1/3.
        let found = sample(Sampling::Bicubic, dvec2(3.2, 2.5), |x, _| x * x);
        assert!((found - (3.2 * 3.2 + 1.0 / 3.0)).abs() < 1e-12);
        assert_eq!(footprint(Sampling::Bilinear, PAGE, dvec2(0.0, 0.0)), [(0, 1.0)]);
        assert_eq!(footprint(Sampling::Bilinear, PAGE, dvec2(3.5, 2.5)), [(17, 1.0)]);
    }
}
