//! Sun extraction: the part of a sky's picture that gathers would find too seldom.

use glam::{DVec3, Vec2, Vec3};
use halfdome_kernel::sampling::{AliasEntry, AliasTable};

use super::{brightness, direction_in};
use crate::scene::SkyPicture;

/// A texel may be so many times as bright as the mean before it counts as a part of the sun. A clear sky without its sun is below that.
const LIMIT: f64 = 8.0;

/// The sun: the texels of a picture that are far brighter than the mean, as far as they are.
#[derive(Debug)]
pub(super) struct SunTexels {
    /// The brightness beyond which it is the sun's.
    limit: f64,
    /// Their numbers, in ascending order.
    texels: Vec<u32>,
    /// Chooses among them, by brightness beyond the limit times solid angle.
    table: AliasTable<Vec<AliasEntry>>,
    mean: Vec3,
}

impl SunTexels {
    /// `None` if no texel is bright enough.
    pub(super) fn of(picture: &SkyPicture) -> Option<Self> {
        let rows = || (0..).zip(picture.texels.chunks_exact(picture.width as usize));
        let mean = |limit: f64| -> f64 {
            let row = |(row, texels): (u32, &[Vec3])| -> f64 {
                texels.iter().map(|texel| brightness(*texel).min(limit)).sum::<f64>() * picture.solid_angle(row)
            };
            rows().map(row).sum::<f64>() / (4.0 * std::f64::consts::PI)
        };
        // A sun may be most of the mean, so that the second time counts.
        let limit = LIMIT * mean(LIMIT * mean(f64::INFINITY));
        let (mut texels, mut powers, mut sum) = (Vec::new(), Vec::new(), DVec3::ZERO);
        for (row, colors) in rows() {
            let solid_angle = picture.solid_angle(row);
            for (column, color) in (0..).zip(colors).filter(|(_, color)| brightness(**color) > limit) {
                let (_, excess) = split(*color, limit);
                texels.push(row * picture.width + column);
                powers.push(brightness(excess) * solid_angle);
                sum += excess.as_dvec3() * solid_angle;
            }
        }
        let greatest = powers.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let weights: Vec<f32> = powers.iter().map(|power| (power / greatest) as f32).collect();
        let table = AliasTable::build(&weights, vec![AliasEntry::default(); weights.len()]).ok()?;
        Some(Self { limit, texels, table, mean: (sum / (4.0 * std::f64::consts::PI)).as_vec3() })
    }

    /// What of a radiance is for gathers, and what is the sun's.
    pub(super) fn split(&self, radiance: Vec3) -> (Vec3, Vec3) {
        split(radiance, self.limit)
    }

    /// Mean radiance of all directions.
    pub(super) fn mean(&self) -> Vec3 {
        self.mean
    }

    /// A direction, and the sun's radiance there over the density per solid angle.
    pub(super) fn sample(&self, picture: &SkyPicture, u: Vec2) -> (Vec3, Vec3) {
        let (index, probability, across) = self.table.sample(u.x.into());
        let texel = self.texels[index];
        let (column, row) = (texel % picture.width, texel / picture.width);
        let direction = direction_in(picture, (column as usize, row as usize), (across as f32, u.y));
        let density = f64::from(probability) / picture.solid_angle(row);
        (direction, self.split(picture.texels[texel as usize]).1 / density as f32)
    }
}

fn split(radiance: Vec3, limit: f64) -> (Vec3, Vec3) {
    let brightness = brightness(radiance);
    if brightness <= limit {
        return (radiance, Vec3::ZERO);
    }
    let dim = radiance * (limit / brightness) as f32;
    (dim, radiance - dim)
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::sampling::Stream;

    use super::*;
    use crate::light::SkyLight;
    use crate::scene::Sky;

    /// A sky of 32 x 16 texels, grey but for two suns.
    fn picture(suns: [Vec3; 2]) -> SkyPicture {
        let mut texels = vec![Vec3::ONE; 32 * 16];
        [texels[3 * 32 + 20], texels[9 * 32 + 5]] = suns;
        SkyPicture { rotation: 1.0, ..SkyPicture::new(32, 16, texels) }
    }

    #[test]
    fn a_sky_is_its_sun_and_the_rest() {
        let suns = [Vec3::new(4000.0, 3000.0, 2000.0), Vec3::splat(400.0)];
        let sky = SkyLight::new(Sky { radiance: Vec3::ZERO, picture: Some(picture(suns)) });
        let whole = picture(suns);
        let (mut sum, mut weight) = (DVec3::ZERO, 0.0);
        for row in 0..16 {
            for column in 0..32 {
                let direction = direction_in(&whole, (column, row), (0.5, 0.5));
                let dim = sky.ambient(direction);
                assert!(dim.max_element() < 40.0 && (dim == Vec3::ONE || column == 20 || column == 5), "{dim}");
                sum += dim.as_dvec3() * whole.solid_angle(row as u32);
                weight += whole.solid_angle(row as u32);
            }
        }
        assert!((weight / (4.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12);
        let mean = (sum / weight).as_vec3() + sky.mean_sun();
        assert!((mean / sky.mean() - 1.0).abs().max_element() < 1e-5, "{mean}, not {}", sky.mean());
    }

    #[test]
    fn samples_of_the_sun_have_its_mean_and_lead_to_it() {
        let suns = [Vec3::splat(2000.0), Vec3::splat(1000.0)];
        let whole = picture(suns);
        let sun = SunTexels::of(&whole).unwrap();
        assert_eq!(sun.texels, [3 * 32 + 20, 9 * 32 + 5]);
        let sky = SkyLight::new(Sky { radiance: Vec3::ZERO, picture: Some(whole) });
        for i in 0..1000 {
            let (direction, estimate) = sky.sample_sun(Stream::new(7, 0, i).uniform2(0)).unwrap();
            assert!(direction.is_normalized() && sky.radiance(direction).x >= 1000.0, "{direction}");
            let expected = 4.0 * std::f32::consts::PI * sky.mean_sun();
            assert!((estimate / expected - 1.0).abs().max_element() < 1e-4, "{estimate}, not {expected}");
        }
    }

    #[test]
    fn an_overcast_sky_has_no_sun() {
        assert!(SunTexels::of(&picture([Vec3::splat(7.0), Vec3::splat(3.0)])).is_none());
        assert!(SunTexels::of(&picture([Vec3::ONE; 2])).is_none());
        let sky = SkyLight::new(Sky::constant(Vec3::ONE));
        assert_eq!((sky.ambient(Vec3::Y), sky.mean_sun()), (Vec3::ONE, Vec3::ZERO));
        assert!(sky.sample_sun(Vec2::ZERO).is_none());
    }
}
