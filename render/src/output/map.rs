//! Lightmaps as pictures of three channels, for formats that hold less than 32-bit floats do.

use std::path::Path;

use glam::Vec3;

use super::OutputError;

/// A lightmap, or any picture of linear colours.
#[derive(Clone, Copy, Debug)]
pub struct Map<'a> {
    /// Texels across, at least 1.
    pub width: u32,
    /// Texels down, at least 1.
    pub height: u32,
    /// Row by row from the top, where the texture coordinate `v` is 0; `width * height` of them.
    pub texels: &'a [Vec3],
}

/// A map as the bytes of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EncodedMap {
    /// All of the file.
    pub bytes: Vec<u8>,
    /// How many texels the format cannot hold: too bright ones became as bright as it goes, and what is not a number,
    /// or negative where nothing may be, became 0. More than none deserves a warning.
    pub clamped: usize,
}

impl Map<'_> {
    /// Checks that the map has texels, and as many as its size says.
    pub(super) fn check(&self, path: &Path) -> Result<(), OutputError> {
        let Self { width, height, texels } = *self;
        if texels.is_empty() || texels.len() as u64 != u64::from(width) * u64::from(height) {
            let problem = format!("the map has {} texels, and is {width} wide and {height} high", texels.len());
            return Err(OutputError::new(path, problem, "give it one colour for each texel, and at least one"));
        }
        Ok(())
    }

    /// The texels within `min` to `max`, among which 0 is, and how many had to be changed for it.
    pub(super) fn within(&self, min: f32, max: f32) -> (impl Iterator<Item = Vec3>, usize) {
        let within = move |texel: Vec3| {
            texel.map(|value| match value {
                _ if value > min => value.min(max),
                _ if value.is_nan() => 0.0,
                _ => min,
            })
        };
        let clamped = self.texels.iter().filter(|&&texel| within(texel) != texel).count();
        (self.texels.iter().map(move |&texel| within(texel)), clamped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_format_cannot_hold_is_clamped_and_counted() {
        let texels =
            [Vec3::new(0.0, 1.0, 10.0), Vec3::new(-1.0, f32::NAN, 11.0), Vec3::splat(f32::INFINITY), Vec3::splat(-0.0)];
        let map = Map { width: 2, height: 2, texels: &texels };
        let (within, clamped) = map.within(0.0, 10.0);
        let expected = [texels[0], Vec3::new(0.0, 0.0, 10.0), Vec3::splat(10.0), Vec3::ZERO];
        assert_eq!((within.collect::<Vec<_>>().as_slice(), clamped), (expected.as_slice(), 2));
        let texels = [Vec3::new(-0.5, f32::NAN, -11.0), Vec3::new(-10.0, 10.0, 0.0)];
        let map = Map { width: 2, height: 1, texels: &texels };
        let (within, clamped) = map.within(-10.0, 10.0);
        let expected = [Vec3::new(-0.5, 0.0, -10.0), texels[1]];
        assert_eq!((within.collect::<Vec<_>>().as_slice(), clamped), (expected.as_slice(), 1));
    }

    #[test]
    fn a_map_has_as_many_texels_as_its_size_says() {
        let path = Path::new("a.hdr");
        let check = |width, height, texels: &[Vec3]| Map { width, height, texels }.check(path);
        assert_eq!(check(2, 1, &[Vec3::ONE; 2]), Ok(()));
        let problem = check(2, 2, &[Vec3::ONE; 2]).unwrap_err().problem;
        assert_eq!(problem, "the map has 2 texels, and is 2 wide and 2 high");
        assert!(check(0, 0, &[]).is_err());
    }
}
