//! The parts of a sky picture above a limit, as a distribution of directions.
//!
//! A row is chosen by the excess of all of it, then a texel of the row, each by inverting the sums of those before it, so
//! that numbers which are spread evenly make directions that are; and a direction in the tent about the texel by which it is
//! interpolated. So the density of a direction is the interpolated excess there over all of it, exactly.

use glam::{DVec3, Vec2, Vec3};

use super::texels::{Around, SkyTexels};
use crate::light::distant::Patches;
use crate::light::luminance_weight;
use crate::scene::SkyPicture;

/// The part of a picture above a limit.
#[derive(Debug)]
pub(super) struct Peaks {
    limit: f32,
    /// Sums of the excess over solid angle up to each row; one more than there are rows.
    sums: Vec<f64>,
    /// Where the texels of each row begin in the lists below; one more than there are rows.
    first: Vec<u32>,
    columns: Vec<u32>,
    /// The part of its row's excess that a texel and those before it have.
    parts: Vec<f32>,
    /// The reciprocal of the sum of all.
    per_total: f32,
}

/// Patches in a picture, from top to bottom and around.
const PATCHES: [u32; 2] = [6, 12];

impl Peaks {
    /// `None` if nothing is brighter than the limit.
    pub(super) fn of(picture: &SkyPicture, limit: f64) -> Option<Self> {
        let limit = limit as f32;
        let mut peaks =
            Self { limit, sums: vec![0.0], first: vec![0], columns: Vec::new(), parts: Vec::new(), per_total: 0.0 };
        let mut sum = 0.0;
        for (row, texels) in (0..).zip(picture.texels.chunks_exact(picture.width as usize)) {
            let (start, mut along) = (peaks.parts.len(), 0.0);
            let mut ends = Vec::new();
            for (column, texel) in (0..).zip(texels) {
                let excess = f64::from(peaks.excess(*texel));
                if excess > 0.0 {
                    along += excess;
                    peaks.columns.push(column);
                    ends.push(along);
                }
            }
            peaks.parts.extend(ends.into_iter().map(|end| (end / along) as f32));
            // If little of a row is left, the whole row is used.
            if let Some(last) = peaks.parts[start..].last_mut() {
                *last = 1.0;
            }
            sum += along * picture.solid_angle(row);
            peaks.sums.push(sum);
            peaks.first.push(peaks.parts.len() as u32);
        }
        peaks.per_total = sum.recip() as f32;
        (sum > 0.0).then_some(peaks)
    }

    #[inline(always)]
    fn excess(&self, radiance: Vec3) -> f32 {
        (luminance_weight(radiance) - self.limit).max(0.0)
    }

    /// The excess of all directions, times solid angle.
    pub(super) fn total(&self) -> f64 {
        self.sums[self.sums.len() - 1]
    }

    /// A direction.
    pub(super) fn sample(&self, texels: &SkyTexels, u: Vec2) -> Vec3 {
        let place = f64::from(u.y) * self.total();
        // The last row whose sum before it is no more, among those that have any.
        let row = self.sums.partition_point(|&sum| sum <= place).clamp(1, self.sums.len() - 1) - 1;
        let [start, end] = [self.first[row] as usize, self.first[row + 1] as usize];
        let parts = &self.parts[start..end];
        let Some(last) = parts.len().checked_sub(1) else { return Vec3::Y };
        let index = parts.partition_point(|&part| part <= u.x).min(last);
        let before = if index == 0 { 0.0 } else { parts[index - 1] };
        let across = (u.x - before) / (parts[index] - before);
        let down = (place - self.sums[row]) / (self.sums[row + 1] - self.sums[row]);
        let u = Vec2::new(across, down as f32);
        texels.direction_to(texels.place_in_tent((self.columns[start + index], row as u32), u))
    }

    /// The density per solid angle of the direction to what is between these texels.
    pub(super) fn density(&self, around: &Around) -> f32 {
        around.mean_number(|texel| self.excess(texel)) * self.per_total
    }

    /// The parts below and above the limit.
    pub(super) fn split(&self, radiance: Vec3) -> (Vec3, Vec3) {
        let brightness = luminance_weight(radiance);
        if brightness <= self.limit {
            return (radiance, Vec3::ZERO);
        }
        let dim = radiance * (self.limit / brightness);
        (dim, radiance - dim)
    }

    /// Calls `see` with row, column and colour of each texel that is brighter than the limit.
    pub(super) fn each(&self, picture: &SkyPicture, mut see: impl FnMut(u32, u32, Vec3)) {
        for row in 0..picture.height {
            let [start, end] = [self.first[row as usize] as usize, self.first[row as usize + 1] as usize];
            for &column in &self.columns[start..end] {
                see(row, column, picture.texels[(row * picture.width + column) as usize]);
            }
        }
    }

    /// The same in patches.
    pub(super) fn patches(&self, texels: &SkyTexels) -> Patches {
        self.patches_by(texels, 1.001 * texels.texel_angle())
    }

    /// The same if no tent is wider than `reach`.
    pub(super) fn patches_by(&self, texels: &SkyTexels, reach: f32) -> Patches {
        let picture = texels.picture();
        let patch_of = |row: u32, column: u32| {
            let place = |i: u32, size: u32, count: u32| u64::from(i) * u64::from(count) / u64::from(size);
            (place(row, picture.height, PATCHES[0]) * u64::from(PATCHES[1]) + place(column, picture.width, PATCHES[1]))
                as usize
        };
        let count = (PATCHES[0] * PATCHES[1]) as usize;
        let mut fluxes = vec![(0.0, DVec3::ZERO); count];
        let middles = texels.middles();
        self.each(picture, |row, column, texel| {
            let flux = f64::from(self.excess(texel)) * picture.solid_angle(row);
            let (sum, vector) = &mut fluxes[patch_of(row, column)];
            *sum += flux;
            *vector += flux * middles.of(column, row).as_dvec3();
        });
        let means: Vec<Vec3> = fluxes.iter().map(|(sum, vector)| (*vector / sum).as_vec3()).collect();
        let mut radii = vec![0.0_f32; count];
        self.each(picture, |row, column, _| {
            let patch = patch_of(row, column);
            let (mean, radius) = (means[patch], &mut radii[patch]);
            // Its tent ends in the middles of its neighbours: of most texels none of them is farther than what is known.
            if middles.of(column, row).distance(mean) + reach > *radius {
                *radius = middles.around(column, row).map(|place| place.distance(mean)).fold(*radius, f32::max);
            }
        });
        let mut patches = Patches::default();
        for ((mean, radius), (flux, _)) in means.into_iter().zip(radii).zip(fluxes) {
            if flux > 0.0 {
                // A little more, as borders between those points bend outwards.
                patches.push(mean, 1.02 * radius + 1e-6, flux as f32);
            }
        }
        patches
    }
}
