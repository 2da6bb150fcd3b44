//! Triangles to texels: every texel whose square a triangle touches, and the part of it that the triangle covers.
//!
//! Coordinates are texels, texel `(x, y)` being the square from there to `(x + 1, y + 1)`. A triangle is clipped by a
//! row's two borders and then by each texel's (Sutherland and Hodgman 1974), so areas are exact but for rounding.

use glam::DVec2;

/// A convex polygon of seven corners at most: a triangle that four lines have clipped.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    corners: [DVec2; 7],
    length: usize,
}

impl Polygon {
    /// A triangle.
    pub(crate) fn triangle(corners: [DVec2; 3]) -> Self {
        let mut polygon = Self { corners: [DVec2::ZERO; 7], length: 3 };
        polygon.corners[..3].copy_from_slice(&corners);
        polygon
    }

    /// Its corners.
    pub(crate) fn corners(&self) -> &[DVec2] {
        &self.corners[..self.length]
    }

    /// The part where `normal·p >= offset`.
    fn clip(&self, normal: DVec2, offset: f64) -> Self {
        let mut clipped = Self { corners: [DVec2::ZERO; 7], length: 0 };
        let mut push = |corner| {
            // A polygon that has lost its shape to rounding may have more.
            if clipped.length < clipped.corners.len() {
                clipped.corners[clipped.length] = corner;
                clipped.length += 1;
            }
        };
        let corners = self.corners();
        for (i, &a) in corners.iter().enumerate() {
            let b = corners[(i + 1) % corners.len()];
            let (height_a, height_b) = (normal.dot(a) - offset, normal.dot(b) - offset);
            if height_a >= 0.0 {
                push(a);
            }
            if (height_a > 0.0 && height_b < 0.0) || (height_a < 0.0 && height_b > 0.0) {
                push(a + (b - a) * (height_a / (height_a - height_b)));
            }
        }
        clipped
    }

    /// The part in the square of a texel.
    pub(crate) fn in_texel(&self, x: u32, y: u32) -> Self {
        self.in_rows(y).in_columns(x)
    }

    fn in_rows(&self, y: u32) -> Self {
        self.clip(DVec2::Y, f64::from(y)).clip(DVec2::NEG_Y, -f64::from(y) - 1.0)
    }

    fn in_columns(&self, x: u32) -> Self {
        self.clip(DVec2::X, f64::from(x)).clip(DVec2::NEG_X, -f64::from(x) - 1.0)
    }

    /// The area; negative if the corners run clockwise where v points up.
    pub(crate) fn area(&self) -> f64 {
        let Some((&first, rest)) = self.corners().split_first() else { return 0.0 };
        rest.windows(2).map(|pair| 0.5 * (pair[0] - first).perp_dot(pair[1] - first)).sum()
    }

    /// The centre of gravity; the mean of the corners if there is no area.
    pub(crate) fn centroid(&self) -> DVec2 {
        let area = self.area();
        let corners = self.corners();
        if area == 0.0 {
            return corners.iter().sum::<DVec2>() / corners.len().max(1) as f64;
        }
        let first = corners[0];
        let moments = corners[1..].windows(2).map(|pair| {
            let (a, b) = (pair[0] - first, pair[1] - first);
            0.5 * a.perp_dot(b) * (a + b) / 3.0
        });
        first + moments.sum::<DVec2>() / area
    }

    /// The area that it shares with another polygon.
    pub(crate) fn overlap(&self, other: &Self) -> f64 {
        let turn = other.area().signum();
        let corners = other.corners();
        let mut common = *self;
        for (i, &a) in corners.iter().enumerate() {
            let inwards = (corners[(i + 1) % corners.len()] - a).perp() * turn;
            if inwards != DVec2::ZERO {
                common = common.clip(inwards, inwards.dot(a));
            }
        }
        common.area().abs()
    }

    fn bounds(&self) -> Option<(DVec2, DVec2)> {
        let corners = self.corners();
        let first = *corners.first()?;
        Some(corners.iter().fold((first, first), |(low, high), &corner| (low.min(corner), high.max(corner))))
    }
}

/// Calls `touch` with each texel of a page of this size that the triangle covers a part of, row by row, and with that
/// part.
pub(crate) fn rasterize(corners: [DVec2; 3], width: u32, height: u32, mut touch: impl FnMut(u32, u32, &Polygon)) {
    let triangle = Polygon::triangle(corners);
    let span = |low: f64, high: f64, end: u32| {
        let low = low.floor().clamp(0.0, f64::from(end)) as u32;
        low..(high.ceil().clamp(0.0, f64::from(end)) as u32)
    };
    let Some((low, high)) = triangle.bounds().filter(|(low, high)| low.is_finite() && high.is_finite()) else { return };
    for y in span(low.y, high.y, height) {
        let row = triangle.in_rows(y);
        let Some((low, high)) = row.bounds() else { continue };
        for x in span(low.x, high.x, width) {
            let part = row.in_columns(x);
            if part.area() != 0.0 {
                touch(x, y, &part);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;
    use halfdome_kernel::sampling::Stream;

    fn random_triangle(number: u32) -> [DVec2; 3] {
        let [a, b, c, d] = Stream::new(5, number, 0).uniform4(0).map(f64::from);
        let [e, f, ..] = Stream::new(5, number, 0).uniform4(1).map(f64::from);
        [dvec2(a, b), dvec2(c, d), dvec2(e, f)].map(|p| p * 12.0 - 1.0)
    }

    #[test]
    fn parts_add_up_to_the_triangle_and_lie_in_their_texels() {
        for number in 0..200 {
            // All inside of the page.
            let corners = random_triangle(number).map(|p| p + 1.0);
            let whole = Polygon::triangle(corners);
            let (mut area, mut moment) = (0.0, DVec2::ZERO);
            rasterize(corners, 12, 12, |x, y, part| {
                let centroid = part.centroid();
                let low = dvec2(x.into(), y.into());
                assert!((centroid - low).min_element() > -1e-9 && (centroid - low).max_element() < 1.0 + 1e-9);
                area += part.area();
                moment += part.area() * centroid;
            });
            assert!((area - whole.area()).abs() < 1e-9);
            assert!((moment - whole.area() * whole.centroid()).length() < 1e-8);
        }
    }

    #[test]
    fn what_is_off_the_page_is_left_out() {
        let mut touched = Vec::new();
        rasterize([dvec2(-5.0, -5.0), dvec2(9.0, -5.0), dvec2(-5.0, 9.0)], 3, 2, |x, y, part| {
            touched.push((x, y));
            assert!(part.area() > 0.0);
        });
        assert_eq!(touched, [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)]);
        rasterize([dvec2(f64::NAN, 0.0), dvec2(1.0, 0.0), dvec2(0.0, 1.0)], 3, 2, |_, _, _| panic!("nothing is there"));
    }

    #[test]
    fn slivers_are_not_missed() {
        let mut texels = 0;
        rasterize([dvec2(0.1, 0.5), dvec2(7.9, 0.5), dvec2(7.9, 0.500_001)], 8, 8, |_, y, _| {
            assert_eq!(y, 0);
            texels += 1;
        });
        assert_eq!(texels, 8);
    }

    #[test]
    fn overlaps_are_exact() {
        let square = |x: f64, y: f64| {
            let corner = dvec2(x, y);
            [
                Polygon::triangle([corner, corner + DVec2::X, corner + DVec2::ONE]),
                Polygon::triangle([corner, corner + DVec2::ONE, corner + DVec2::Y]),
            ]
        };
        let overlap =
            |a: [Polygon; 2], b: [Polygon; 2]| a.iter().flat_map(|a| b.iter().map(|b| a.overlap(b))).sum::<f64>();
        assert!((overlap(square(0.0, 0.0), square(0.25, 0.5)) - 0.375).abs() < 1e-12);
        assert_eq!(overlap(square(0.0, 0.0), square(1.0, 0.0)), 0.0);
        let [a, b] = square(0.0, 0.0);
        assert!(a.overlap(&b) < 1e-12 && (a.overlap(&a) - 0.5).abs() < 1e-12);
        // The other way round.
        let turned = Polygon::triangle([DVec2::ZERO, DVec2::ONE, DVec2::X]);
        assert!((turned.overlap(&a) - 0.5).abs() < 1e-12 && (a.overlap(&turned) - 0.5).abs() < 1e-12);
    }
}
