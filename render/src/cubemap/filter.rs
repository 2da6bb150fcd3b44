//! Filters a cube map by a lobe: the mean of all texels' radiance, each weighted by the lobe in its direction and by
//! its exact solid angle,
//!
//! `L̄(r) = Σ L_i w(θ_i) Ω_i / Σ w(θ_i) Ω_i`,
//!
//! without random numbers and so without noise. As Barnes and Hut (1986) do for distant stars, texels far from the
//! lobe's axis are taken together in squares of 2, 4, 8 … across, as long as the weight changes little over a square.
//! Where the lobe is narrower than a texel, the texel is divided instead. So a lobe costs a number of squares that
//! grows with the logarithm of its narrowness alone, and light from a small sun is never missed.

use glam::{DVec3, Vec3};

use super::face::Face;
use super::grid::{TexelGrid, solid_angle};
use super::lobe::Lobe;

/// How large a square may be, as a part of the lobe's width or of its own distance from the axis, whichever is more.
/// The error goes with the square of this; the tests hold it to a quarter of a percent.
const FINENESS: f64 = 0.2;
/// How large it may be at most, radians: light too changes over a square, and with the weight.
const MAX_EXTENT: f64 = 0.12;
/// Texels are divided this often at most.
const DIVISIONS: u32 = 6;

/// A cube map with its squares of 1, 2, 4 … texels.
#[derive(Debug)]
pub(super) struct Pyramid {
    grid: TexelGrid,
    /// From whole faces down to texels: squares of all faces, by faces, then by rows.
    levels: Vec<Vec<Square>>,
}

/// A square of texels.
#[derive(Clone, Copy, Debug, Default)]
struct Square {
    /// Unit vector to its middle.
    middle: Vec3,
    /// Its diameter as seen from the middle of the cube, radians.
    extent: f32,
    solid_angle: f32,
    /// Mean by solid angle.
    radiance: Vec3,
}

impl Square {
    /// The square in this column and row of `side` by `side`.
    fn new(grid: &TexelGrid, face: Face, x: u32, y: u32, side: u32) -> Self {
        let step = f64::from(grid.size) / f64::from(side);
        let border = |place: u32| grid.place(f64::from(place) * step);
        let (u, v) = ([border(x), border(x + 1)], [border(y), border(y + 1)]);
        let middle = face.point(0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1]));
        let diagonal = (u[1] - u[0]).hypot(v[1] - v[0]);
        Self {
            middle: middle.normalize().as_vec3(),
            extent: (diagonal / middle.length()) as f32,
            solid_angle: solid_angle(u, v) as f32,
            radiance: Vec3::ZERO,
        }
    }
}

impl Pyramid {
    /// The pyramid of the texels of a grid whose side is a power of two.
    pub(super) fn new(grid: TexelGrid, texels: &[Vec3]) -> Self {
        let mut levels: Vec<Vec<Square>> = Vec::new();
        let mut side = grid.size;
        while side > 0 {
            let places = TexelGrid { size: side, ..grid }.places();
            let mut squares: Vec<Square> = places.map(|(face, x, y)| Square::new(&grid, face, x, y, side)).collect();
            for (number, square) in squares.iter_mut().enumerate() {
                square.radiance = match levels.last() {
                    None => texels[number],
                    Some(finer) => {
                        let parts = children(number, side).map(|part| finer[part]);
                        let sum: DVec3 =
                            parts.iter().map(|part| part.radiance.as_dvec3() * f64::from(part.solid_angle)).sum();
                        (sum / parts.iter().map(|part| f64::from(part.solid_angle)).sum::<f64>()).as_vec3()
                    }
                };
            }
            levels.push(squares);
            side /= 2;
        }
        levels.reverse();
        Self { grid, levels }
    }

    /// The mean that a lobe about a unit vector sees.
    pub(super) fn filtered(&self, axis: DVec3, lobe: &Lobe) -> Vec3 {
        let mut sums = Sums { axis, lobe, width: lobe.width(), reach: lobe.reach(), light: DVec3::ZERO, weight: 0.0 };
        for face in 0..Face::ALL.len() {
            self.add(0, face, &mut sums);
        }
        if sums.weight > 0.0 { (sums.light / sums.weight).as_vec3() } else { Vec3::ZERO }
    }

    /// Adds the square of this number, or its parts.
    fn add(&self, level: usize, number: usize, sums: &mut Sums) {
        let square = &self.levels[level][number];
        match sums.verdict(square) {
            Verdict::Nothing => {}
            Verdict::Whole => sums.take(square),
            Verdict::Parts if level + 1 < self.levels.len() => {
                children(number, 1 << level).into_iter().for_each(|part| self.add(level + 1, part, sums));
            }
            Verdict::Parts => {
                let size = self.grid.size as usize;
                let (face, x, y) = (number / (size * size), number % size, number / size % size);
                self.divide(Face::ALL[face], [x as u32, y as u32], size as u32, DIVISIONS, square.radiance, sums);
            }
        }
    }

    /// Adds the quarters of a texel, or of a part of one.
    fn divide(&self, face: Face, place: [u32; 2], side: u32, further: u32, radiance: Vec3, sums: &mut Sums) {
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let [x, y] = [2 * place[0] + dx, 2 * place[1] + dy];
            let quarter = Square { radiance, ..Square::new(&self.grid, face, x, y, 2 * side) };
            match sums.verdict(&quarter) {
                Verdict::Nothing => {}
                Verdict::Parts if further > 1 => self.divide(face, [x, y], 2 * side, further - 1, radiance, sums),
                Verdict::Parts | Verdict::Whole => sums.take(&quarter),
            }
        }
    }
}

/// The numbers of a square's quarters, `side` being that of the square's own level.
fn children(number: usize, side: u32) -> [usize; 4] {
    let side = side as usize;
    let (face, x, y) = (number / (side * side), number % side, number / side % side);
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| ((2 * side * face) + 2 * y + dy) * 2 * side + 2 * x + dx)
}

/// The treatment of a square.
enum Verdict {
    Nothing,
    Whole,
    Parts,
}

/// The mean of a lobe, so far.
struct Sums<'a> {
    axis: DVec3,
    lobe: &'a Lobe,
    width: f64,
    reach: f64,
    light: DVec3,
    weight: f64,
}

impl Sums<'_> {
    fn verdict(&self, square: &Square) -> Verdict {
        // A little less than the angle.
        let distance = square.middle.as_dvec3().distance(self.axis);
        let extent = f64::from(square.extent);
        if distance - 0.5 * extent > self.reach {
            Verdict::Nothing
        } else if extent <= (FINENESS * self.width.max(distance)).min(MAX_EXTENT) {
            Verdict::Whole
        } else {
            Verdict::Parts
        }
    }

    fn take(&mut self, square: &Square) {
        let sin2 = 0.25 * square.middle.as_dvec3().distance_squared(self.axis);
        let weight = self.lobe.weight(sin2) * f64::from(square.solid_angle);
        self.light += square.radiance.as_dvec3() * weight;
        self.weight += weight;
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::grid::Seams;
    use super::*;

    const LOBES: [Lobe; 6] = [
        Lobe::Ggx { roughness: 0.05 },
        Lobe::Ggx { roughness: 0.25 },
        Lobe::Ggx { roughness: 0.6 },
        Lobe::Ggx { roughness: 1.0 },
        Lobe::Phong { power: 1.0 },
        Lobe::Phong { power: 64.0 },
    ];

    /// A cube map of a function of the direction.
    fn pyramid(size: u32, seams: Seams, radiance: impl Fn(DVec3) -> Vec3) -> Pyramid {
        let grid = TexelGrid { size, seams };
        let texels: Vec<Vec3> =
            grid.places().map(|(face, x, y)| radiance(grid.point(face, x, y).normalize())).collect();
        Pyramid::new(grid, &texels)
    }

    fn axes() -> impl Iterator<Item = DVec3> {
        [[1.0, 0.0, 0.0], [1.0, 1.0, 1.0], [-0.2, 0.9, 0.4], [0.0, -1.0, 1.0], [0.3, -0.2, -1.0]]
            .into_iter()
            .map(|axis| DVec3::from(axis).normalize())
    }

    #[test]
    fn what_is_the_same_everywhere_stays_the_same() {
        let radiance = Vec3::new(0.7, 1.3, 1e-4);
        for seams in Seams::ALL {
            let pyramid = pyramid(16, seams, |_| radiance);
            for (axis, lobe) in axes().flat_map(|axis| LOBES.map(|lobe| (axis, lobe))) {
                assert_eq!(pyramid.filtered(axis, &lobe), radiance, "{seams:?} {lobe:?}");
            }
        }
    }

    /// Light that depends on the angle to the lobe's own axis alone leaves an integral of one variable,
    /// `∫ L w sin θ dθ`, which Simpson's rule finds.
    #[test]
    fn light_about_the_axis_has_the_integral_of_one_variable() {
        let light = |cosine: f64| 1.0 + cosine + 3.0 * cosine.max(0.0).powi(3);
        for lobe in LOBES {
            let weight = |theta: f64| lobe.weight((0.5 * theta).sin().powi(2)) * theta.sin();
            // Finer towards the axis.
            let simpson = |f: &dyn Fn(f64) -> f64| -> f64 {
                let steps = 4000;
                let at = |i: i32| {
                    let x = f64::from(i) / f64::from(steps);
                    f(0.5 * PI * x.powi(3)) * 1.5 * PI * x * x
                };
                (0..=steps)
                    .map(|i| {
                        at(i)
                            * if i % 2 == 1 {
                                4.0
                            } else if i % steps == 0 {
                                1.0
                            } else {
                                2.0
                            }
                    })
                    .sum()
            };
            let expected = simpson(&|theta| weight(theta) * light(theta.cos())) / simpson(&weight);
            for axis in axes() {
                let pyramid = pyramid(64, Seams::None, |direction| Vec3::splat(light(direction.dot(axis)) as f32));
                let found = f64::from(pyramid.filtered(axis, &lobe).x);
                assert!((found / expected - 1.0).abs() < 2.5e-3, "{lobe:?} about {axis}: {found}, not {expected}");
            }
        }
    }

    /// Each direction sends as much light as it gets, so that the mean over the sphere stays: of a small sun too.
    #[test]
    fn the_mean_over_the_sphere_stays() {
        let sun = DVec3::new(0.4, 0.7, -0.59).normalize();
        let sky = |d: DVec3| Vec3::new(if d.dot(sun) > 0.99 { 100.0 } else { 0.0 }, d.y.max(0.0) as f32, 1.0);
        let pyramid = pyramid(16, Seams::None, sky);
        let mean = |texels: &dyn Fn(Face, u32, u32) -> Vec3| {
            let grid = pyramid.grid;
            let side = |x: u32| [grid.place(f64::from(x)), grid.place(f64::from(x) + 1.0)];
            let sum: DVec3 =
                grid.places().map(|(face, x, y)| texels(face, x, y).as_dvec3() * solid_angle(side(x), side(y))).sum();
            sum / (4.0 * PI)
        };
        let before = mean(&|face, x, y| sky(pyramid.grid.point(face, x, y).normalize()));
        for lobe in LOBES {
            let after = mean(&|face, x, y| pyramid.filtered(pyramid.grid.point(face, x, y).normalize(), &lobe));
            assert!((after / before - 1.0).abs().max_element() < 1e-2, "{lobe:?}: {before} became {after}");
        }
    }

    #[test]
    fn a_square_has_four_parts_below_it() {
        let pyramid = pyramid(8, Seams::Warp, |_| Vec3::ONE);
        for level in 0..3 {
            for (number, square) in pyramid.levels[level].iter().enumerate() {
                let parts = children(number, 1 << level).map(|part| pyramid.levels[level + 1][part]);
                let sum: f32 = parts.iter().map(|part| part.solid_angle).sum();
                assert!((sum / square.solid_angle - 1.0).abs() < 1e-5);
                assert!(parts.iter().all(|part| part.middle.distance(square.middle) < 0.5 * square.extent));
            }
        }
    }
}
