//! Photometric profiles: the intensity of a measured light over angles, as in IES files.
//!
//! Directions are those of type C photometry: the *vertical* angle is measured from the light's axis, which points down
//! for a ceiling light; the *horizontal* angle is measured about it, from the zero half plane, counter-clockwise as
//! seen from behind the light. In between, intensity is bilinear in both angles; beyond the vertical angles of the
//! table there is no light.

use glam::Vec3;

/// Intensity over angles.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Degrees from the axis, in order: two at least.
    vertical: Vec<f32>,
    /// Degrees about it, in order, from 0 to 360; or 0 alone, for a light that is the same all around.
    horizontal: Vec<f32>,
    /// Intensities in candela: all vertical angles of each horizontal angle.
    candela: Vec<f32>,
}

/// The half plane of a light's profile: a right angle apart, unit vectors along its axis and towards the horizontal
/// angle 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileFrame {
    /// The direction of the vertical angle 0.
    pub axis: Vec3,
    /// Where the horizontal angle is 0, and the vertical one 90 degrees.
    pub zero: Vec3,
}

impl Profile {
    /// A table whose angles are in order; `rows` has one for each horizontal angle. A part of the circle, a quarter (0
    /// to 90 degrees) or a half (0 to 180, 90 to 270), is mirrored to the others.
    pub(crate) fn new(vertical: Vec<f32>, horizontal: Vec<f32>, mut rows: Vec<Vec<f32>>) -> Self {
        let mut angles = horizontal;
        // Mirrored about an angle, its own row left out.
        let mut mirror = |angles: &mut Vec<f32>, about: f32| {
            let mirrored: Vec<(f32, Vec<f32>)> =
                angles.iter().map(|angle| 2.0 * about - angle).zip(rows.clone()).rev().skip(1).collect();
            for (angle, row) in mirrored {
                angles.push(angle);
                rows.push(row);
            }
        };
        let (first, last) = (angles[0], angles[angles.len() - 1]);
        if angles.len() > 1 && last == 90.0 {
            mirror(&mut angles, 90.0);
            mirror(&mut angles, 180.0);
        } else if first == 90.0 {
            mirror(&mut angles, 270.0);
        } else if last == 180.0 {
            mirror(&mut angles, 180.0);
        }
        Self { vertical, horizontal: angles, candela: rows.concat() }
    }

    /// Candela in a unit vector.
    pub(crate) fn candela(&self, frame: &ProfileFrame, direction: Vec3) -> f32 {
        let ProfileFrame { axis, zero } = *frame;
        let (x, y) = (direction.dot(zero), direction.dot(zero.cross(axis)));
        let vertical = x.hypot(y).atan2(direction.dot(axis)).to_degrees();
        // A little beyond the ends counts as the end, for what was rounded.
        const SLACK: f32 = 1e-4;
        let (first, last) = (self.vertical[0], self.vertical[self.vertical.len() - 1]);
        if vertical < first - SLACK || vertical > last + SLACK {
            return 0.0;
        }
        let (i, u) = place(&self.vertical, vertical);
        let at = |row: usize| {
            let row = &self.candela[row * self.vertical.len()..];
            row[i] + u * (row[i + 1] - row[i])
        };
        if self.horizontal.len() == 1 {
            return at(0);
        }
        let turn = y.atan2(x).to_degrees();
        let turn = if turn < self.horizontal[0] { turn + 360.0 } else { turn };
        let (j, v) = place(&self.horizontal, turn);
        let (a, b) = (at(j), at(j + 1));
        a + v * (b - a)
    }

    /// The greatest intensity, candela.
    pub(crate) fn greatest(&self) -> f32 {
        self.candela.iter().copied().fold(0.0, f32::max)
    }

    /// The cosine from the axis beyond which there is no light.
    pub(crate) fn cos_outer(&self) -> f32 {
        let is_lit =
            |&i: &usize| self.candela.iter().skip(i).step_by(self.vertical.len()).any(|&candela| candela > 0.0);
        let last = (0..self.vertical.len()).rev().find(is_lit).unwrap_or(0);
        self.vertical[(last + 1).min(self.vertical.len() - 1)].to_radians().cos()
    }

    /// Bounds of the intensity at angles from the axis, as parts of the greatest: bin `i` of `N` is for sines of half
    /// the angle from `i / N` to `(i + 1) / N`.
    pub(crate) fn envelope<const N: usize>(&self) -> [f32; N] {
        let per_greatest = self.greatest().max(f32::MIN_POSITIVE).recip();
        let greatest_at = |vertical: usize| {
            self.candela.iter().skip(vertical).step_by(self.vertical.len()).copied().fold(0.0, f32::max)
        };
        let angle = |bin: usize| 2.0 * (bin as f32 / N as f32).min(1.0).asin().to_degrees();
        // A little more than its own angles, for what is rounded.
        const SLACK: f32 = 0.1;
        core::array::from_fn(|bin| {
            let (from, to) = (angle(bin) - SLACK, angle(bin + 1) + SLACK);
            let pairs = self.vertical.windows(2).enumerate();
            let near = pairs.filter(|(_, pair)| pair[0] <= to && pair[1] >= from);
            let bounds = near.map(|(i, pair)| {
                let [a, b] = [greatest_at(i), greatest_at(i + 1)];
                let at = |angle: f32| a + (b - a) * ((angle - pair[0]) / (pair[1] - pair[0])).clamp(0.0, 1.0);
                at(from).max(at(to))
            });
            bounds.fold(0.0, f32::max) * per_greatest
        })
    }

    /// The integral over all directions, lumens.
    pub(crate) fn lumens(&self) -> f64 {
        self.moments()[0] * 4.0 * std::f64::consts::PI
    }

    /// Candela about the axis in zonal harmonics: `m₀ + m₁ x + m₂ (3x² - 1)/2`, with `x` the cosine from the axis.
    pub(crate) fn moments(&self) -> [f64; 3] {
        let mut moments = [0.0; 3];
        for (i, pair) in self.vertical.windows(2).enumerate() {
            let [a, b] = [self.mean(i), self.mean(i + 1)];
            let [from, to] = [pair[0], pair[1]].map(|degrees| f64::from(degrees).to_radians());
            // Gauss and Legendre's three points: exact enough for what is linear in the angle, in parts of a degree or
            // so.
            let parts = ((to - from).to_degrees().ceil() as u32).max(1);
            for part in 0..parts {
                let half = 0.5 * (to - from) / f64::from(parts);
                let middle = from + half * (2.0 * f64::from(part) + 1.0);
                for (offset, weight) in [(-0.6f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)] {
                    let angle = middle + half * offset;
                    let candela = a + (b - a) * (angle - from) / (to - from);
                    let (x, power) = (angle.cos(), candela * angle.sin() * weight * half);
                    let harmonics = [0.5, 1.5 * x, 2.5 * (1.5 * x * x - 0.5)];
                    moments.iter_mut().zip(harmonics).for_each(|(moment, harmonic)| *moment += power * harmonic);
                }
            }
        }
        moments
    }

    /// The mean over horizontal angles at a vertical one, by its index.
    fn mean(&self, vertical: usize) -> f64 {
        let at = |row: usize| f64::from(self.candela[row * self.vertical.len() + vertical]);
        let pairs = self.horizontal.windows(2).enumerate();
        let sum: f64 = pairs.map(|(j, pair)| 0.5 * f64::from(pair[1] - pair[0]) * (at(j) + at(j + 1))).sum();
        if self.horizontal.len() == 1 { at(0) } else { sum / 360.0 }
    }

    /// All numbers of which it is made.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f32> {
        [&self.vertical, &self.horizontal, &self.candela].into_iter().flatten().copied()
    }
}

impl ProfileFrame {
    /// A frame about this unit vector, whose zero is nearest to +x, or +z along x, and turned from there by an angle,
    /// degrees.
    pub(crate) fn new(axis: Vec3, degrees: f32) -> Self {
        let across = |to: Vec3| (to - axis * axis.dot(to)).try_normalize().filter(|_| axis.dot(to).abs() < 0.9999);
        let zero = across(Vec3::X).or_else(|| across(Vec3::Z)).unwrap_or(Vec3::Y);
        let (sin, cos) = degrees.to_radians().sin_cos();
        Self { axis, zero: (zero * cos + zero.cross(axis) * sin).normalize() }
    }
}

/// The interval of ordered numbers in which `x` lies, and how far into it from 0 to 1.
fn place(numbers: &[f32], x: f32) -> (usize, f32) {
    let i = numbers.partition_point(|&number| number <= x).clamp(1, numbers.len() - 1) - 1;
    (i, ((x - numbers[i]) / (numbers[i + 1] - numbers[i])).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A light that looks along -z, with x to its zero and so y to 90 degrees.
    const FRAME: ProfileFrame = ProfileFrame { axis: Vec3::NEG_Z, zero: Vec3::X };

    fn at(profile: &Profile, vertical: f32, horizontal: f32) -> f32 {
        let ((sin, cos), (y, x)) = (vertical.to_radians().sin_cos(), horizontal.to_radians().sin_cos());
        profile.candela(&FRAME, Vec3::new(sin * x, sin * y, -cos))
    }

    #[test]
    fn intensities_are_bilinear_in_the_angles_and_mirrored() {
        let rows = |values: &[f32]| values.iter().map(|&value| vec![10.0, value, 0.0]).collect::<Vec<_>>();
        let vertical = vec![0.0, 60.0, 90.0];
        let quarter = Profile::new(vertical.clone(), vec![0.0, 90.0], rows(&[40.0, 70.0]));
        for (horizontal, expected) in
            [(0.0, 40.0), (45.0, 55.0), (90.0, 70.0), (180.0, 40.0), (-90.0, 70.0), (330.0, 50.0)]
        {
            let found = at(&quarter, 60.0, horizontal);
            assert!((found - expected).abs() < 1e-3, "{horizontal}: {found}, not {expected}");
        }
        assert!((at(&quarter, 30.0, 0.0) - 25.0).abs() < 1e-3 && (at(&quarter, 75.0, 90.0) - 35.0).abs() < 1e-3);
        assert_eq!(at(&quarter, 91.0, 0.0), 0.0);
        let half = Profile::new(vertical.clone(), vec![0.0, 90.0, 180.0], rows(&[10.0, 20.0, 50.0]));
        assert!((at(&half, 60.0, 270.0) - 20.0).abs() < 1e-3 && (at(&half, 60.0, 181.0) - 50.0).abs() < 0.4);
        let other = Profile::new(vertical.clone(), vec![90.0, 180.0, 270.0], rows(&[10.0, 20.0, 50.0]));
        for (horizontal, expected) in [(90.0, 10.0), (180.0, 20.0), (270.0, 50.0), (0.0, 20.0), (45.0, 15.0)] {
            let found = at(&other, 60.0, horizontal);
            assert!((found - expected).abs() < 1e-3, "{horizontal}: {found}, not {expected}");
        }
        let whole = Profile::new(vertical, vec![0.0, 90.0, 180.0, 270.0, 360.0], rows(&[1.0, 2.0, 3.0, 4.0, 1.0]));
        assert!((at(&whole, 60.0, 270.0) - 4.0).abs() < 1e-3 && (at(&whole, 60.0, 315.0) - 2.5).abs() < 1e-3);
        assert!((quarter.mean(1) - 55.0).abs() < 1e-9 && (other.mean(1) - 25.0).abs() < 1e-9);
        assert_eq!(quarter.greatest(), 70.0);
        assert!(quarter.cos_outer().abs() < 1e-6);
    }

    #[test]
    fn envelopes_are_bounds_and_close() {
        let rows = vec![vec![10.0, 8.0, 0.0, 0.0, 3.0], vec![10.0, 2.0, 1.0, 0.0, 0.0]];
        let profile = Profile::new(vec![0.0, 12.0, 40.0, 90.0, 180.0], vec![0.0, 180.0], rows);
        let envelope: [f32; 32] = profile.envelope();
        for i in 0..=1800 {
            let degrees = i as f32 / 10.0;
            let bin = (((0.5 * degrees.to_radians()).sin() * 32.0) as usize).min(31);
            for horizontal in [0.0, 50.0, 180.0, 300.0] {
                let part = at(&profile, degrees, horizontal) / 10.0;
                assert!(part <= envelope[bin] + 1e-6, "{degrees}: {part}, above {}", envelope[bin]);
            }
        }
        assert!(envelope[31] < 0.31 && (0.09..0.2).contains(&envelope[11]) && envelope[21] < 0.05, "{envelope:?}");
    }

    #[test]
    fn lumens_are_the_integral_over_directions() {
        let all = Profile::new(vec![0.0, 180.0], vec![0.0], vec![vec![5.0, 5.0]]);
        assert!((all.lumens() / (20.0 * std::f64::consts::PI) - 1.0).abs() < 1e-9);
        assert!(all.moments()[1].abs() < 1e-9 && all.moments()[2].abs() < 1e-9);
        let angles: Vec<f32> = (0..=90).map(|degree| degree as f32).collect();
        let cosine: Vec<f32> = angles.iter().map(|degree| 100.0 * degree.to_radians().cos()).collect();
        let lambertian = Profile::new(angles, vec![0.0], vec![cosine]);
        assert!((lambertian.lumens() / (100.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4);
        // Of max(0, x): 1/4, 1/2 and 5/16.
        for (moment, expected) in lambertian.moments().into_iter().zip([25.0, 50.0, 31.25]) {
            assert!((moment / expected - 1.0).abs() < 1e-3, "{moment}, not {expected}");
        }
    }

    #[test]
    fn frames_look_along_their_axis() {
        for axis in [Vec3::NEG_Y, Vec3::X, Vec3::new(0.6, 0.0, 0.8)] {
            for degrees in [0.0, 40.0] {
                let frame = ProfileFrame::new(axis, degrees);
                assert!(frame.zero.is_normalized() && frame.zero.dot(axis).abs() < 1e-6);
            }
        }
        let turned = ProfileFrame::new(Vec3::NEG_Y, 90.0);
        assert!((turned.zero - Vec3::NEG_Z).length() < 1e-6, "{turned:?}");
    }
}
