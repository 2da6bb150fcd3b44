//! The sky: constant radiance, or a picture of all directions.
//!
//! A picture is equirectangular: its top row is around +y, its middle column towards -z, which is where glTF's cameras
//! look, and its right half towards +x. Rendering interpolates between texels.

use std::f64::consts::PI;
use std::io::BufReader;
use std::path::Path;

use exr::prelude::{MetaData, Vec2, read_first_rgba_layer_from_file};
use glam::{DVec3, Vec3};
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder as _};

use crate::film::MAX_SAMPLE;
use crate::scene::{Place, SceneError};

/// The light from outside the scene; black by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sky {
    /// Radiance from everywhere, W/(m² sr).
    pub radiance: Vec3,
    /// The part added to it, by direction.
    pub picture: Option<SkyPicture>,
}

/// Radiance from all directions.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyPicture {
    /// Texels around.
    pub(crate) width: u32,
    /// Texels from top to bottom.
    pub(crate) height: u32,
    /// Row by row from the top, finite and not negative, W/(m² sr).
    pub(crate) texels: Vec<Vec3>,
    /// The rotation of the picture about +y in radians, counter-clockwise as seen from above.
    pub(crate) rotation: f32,
}

/// The most texels: more than any camera has, and few enough for a computer's memory.
const MAX_TEXELS: u64 = 1 << 28;

impl Sky {
    /// The same radiance from everywhere.
    pub fn constant(radiance: Vec3) -> Self {
        Self { radiance, picture: None }
    }

    /// Mean radiance of all directions.
    pub fn mean(&self) -> Vec3 {
        self.radiance + self.picture.as_ref().map_or(Vec3::ZERO, SkyPicture::mean)
    }
}

impl SkyPicture {
    /// A picture of these texels, row by row from the top, finite and not negative, W/(m² sr).
    ///
    /// # Panics
    /// If there are none, or not as many as the size says.
    pub fn new(width: u32, height: u32, texels: Vec<Vec3>) -> Self {
        assert!(!texels.is_empty() && texels.len() as u64 == u64::from(width) * u64::from(height), "texels of all");
        Self { width, height, texels, rotation: 0.0 }
    }

    /// Reads a Radiance picture (`.hdr`) or the first layer of an OpenEXR file (`.exr`), and multiplies it by `scale`.
    /// Negative numbers become 0.
    ///
    /// # Errors
    /// If the file cannot be read, is of another kind or damaged, or holds what is not finite.
    pub fn read(path: &Path, scale: f32) -> Result<Self, SceneError> {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let file = std::fs::File::open(path).map_err(|error| SceneError::unreadable(path, &error))?;
        let damaged = |error: &dyn std::fmt::Display| {
            let problem = format!("the picture is damaged: {error}");
            SceneError::new(path, Place::File, problem, "copy it again, or give a .hdr or .exr file")
        };
        let (width, height, texels) = match extension.to_str() {
            Some("hdr") => read_radiance(BufReader::new(file)).map_err(|error| damaged(&error))?,
            Some("exr") => read_exr(path).map_err(|error| damaged(&error))?,
            _ => {
                let remedy = "convert it to a Radiance (.hdr) or OpenEXR (.exr) picture";
                return Err(SceneError::new(path, Place::File, "this is no picture that serves as a sky", remedy));
            }
        };
        let texels: Vec<Vec3> = texels.into_iter().map(|texel| texel * scale).collect();
        if let Some(wrong) = texels.iter().position(|texel| !texel.is_finite()) {
            let (x, y) = (wrong % width as usize, wrong / width as usize);
            let place = Place::Part(format!("texel {x}, {y}"));
            return Err(SceneError::new(path, place, "it is not finite", "repair the picture, or scale it down"));
        }
        if texels.is_empty() {
            return Err(damaged(&"it has no texels"));
        }
        let texels = texels.into_iter().map(|texel| texel.max(Vec3::ZERO)).collect();
        Ok(Self::new(width, height, texels))
    }

    /// How many texels are brighter than what a sample of a picture holds, and the first of them: its column, row and
    /// radiance.
    pub(crate) fn beyond_samples(&self) -> Option<(usize, [usize; 2], f32)> {
        let is_beyond = |texel: &&Vec3| f64::from(texel.max_element()) > MAX_SAMPLE;
        let first = self.texels.iter().position(|texel| is_beyond(&texel))?;
        let (width, radiance) = (self.width as usize, self.texels[first].max_element());
        Some((self.texels.iter().filter(is_beyond).count(), [first % width, first / width], radiance))
    }

    /// The picture, turned about +y by an angle in degrees, counter-clockwise as seen from above.
    pub fn turned(self, degrees: f32) -> Self {
        Self { rotation: self.rotation + degrees.to_radians(), ..self }
    }

    /// The solid angle that a texel in this row stands for, as light between texels is interpolated.
    pub(crate) fn solid_angle(&self, row: u32) -> f64 {
        self.row_solid_angles(row).iter().sum()
    }

    /// How much of it is in the rows above, of the texel and below: a tent has three quarters of its weight in its own
    /// row. What is beyond a pole is folded back.
    pub(crate) fn row_solid_angles(&self, row: u32) -> [f64; 3] {
        let border = |row: u32| (PI * f64::from(row) / f64::from(self.height)).cos();
        let texel = |row: u32| 2.0 * PI / f64::from(self.width) * (border(row) - border(row + 1));
        let [above, below] = [row.saturating_sub(1), (row + 1).min(self.height - 1)];
        [texel(above) / 8.0, texel(row) * 0.75, texel(below) / 8.0]
    }

    /// Mean radiance of all directions.
    pub(crate) fn mean(&self) -> Vec3 {
        let rows = (0..).zip(self.texels.chunks_exact(self.width as usize));
        let row = |(row, texels): (u32, &[Vec3])| {
            texels.iter().map(|texel| texel.as_dvec3()).sum::<DVec3>() * self.solid_angle(row)
        };
        (rows.map(row).sum::<DVec3>() / (4.0 * PI)).as_vec3()
    }
}

type Texels = (u32, u32, Vec<Vec3>);

fn read_radiance(file: BufReader<std::fs::File>) -> image::ImageResult<Texels> {
    let decoder = HdrDecoder::new(file)?;
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into())
        .map_err(|problem| image::ImageError::IoError(std::io::Error::new(std::io::ErrorKind::InvalidData, problem)))?;
    let image = DynamicImage::from_decoder(decoder)?.into_rgb32f();
    Ok((width, height, image.pixels().map(|pixel| Vec3::from(pixel.0)).collect()))
}

fn read_exr(path: &Path) -> Result<Texels, exr::error::Error> {
    // Before anything of this size is allocated.
    for header in MetaData::read_from_file(path, false)?.headers {
        let Vec2(width, height) = header.layer_size;
        check_size(width as u64, height as u64).map_err(|problem| exr::error::Error::Invalid(problem.into()))?;
    }
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| (size.0, vec![Vec3::ZERO; size.area()]),
        |(width, texels), place, (r, g, b, _): (f32, f32, f32, f32)| {
            texels[place.y() * *width + place.x()] = Vec3::new(r, g, b);
        },
    )?;
    let Vec2(width, height) = image.layer_data.size;
    Ok((width as u32, height as u32, image.layer_data.channel_data.pixels.1))
}

fn check_size(width: u64, height: u64) -> Result<(), String> {
    match width.checked_mul(height) {
        Some(texels) if texels <= MAX_TEXELS => Ok(()),
        _ => Err(format!("it is {width} wide and {height} high, and at most {MAX_TEXELS} texels are read")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Channel, Metadata, Picture};
    use crate::output::{Map, ToneMapping, encode_hdr, write};

    #[test]
    fn both_formats_give_the_same_sky() {
        let folder = tempfile::tempdir().unwrap();
        let texels: Vec<Vec3> = (0..32).map(|i| Vec3::new(0.5, i as f32 / 64.0, 0.25)).collect();
        let hdr = folder.path().join("a.HDR");
        let map = Map { width: 8, height: 4, texels: &texels };
        std::fs::write(&hdr, encode_hdr(&hdr, &map).unwrap().bytes).unwrap();
        let exr = folder.path().join("a.exr");
        let channel = |(i, name): (usize, &str)| Channel {
            name: name.to_owned(),
            values: texels.iter().map(|texel| texel[i]).collect(),
        };
        let channels = ["R", "G", "B"].into_iter().enumerate().map(channel).collect();
        let picture = Picture { width: 8, height: 4, channels, metadata: Metadata::default() };
        write(&exr, &picture, &ToneMapping::default()).unwrap();
        let read = SkyPicture::read(&exr, 2.0).unwrap();
        assert_eq!(read, SkyPicture::read(&hdr, 2.0).unwrap());
        assert_eq!((read.width, read.height, read.texels[9]), (8, 4, texels[9] * 2.0));
    }

    #[test]
    fn rows_near_the_poles_count_less() {
        let mut texels = vec![Vec3::ZERO; 8];
        texels[..2].fill(Vec3::ONE);
        let picture = SkyPicture { width: 2, height: 4, texels, rotation: 0.0 };
        // The cap of 45 degrees is (1 - cos 45°) / 2 of the sphere, and the row below has the rest of its half.
        let [cap, below] = [(1.0 - 0.5_f32.sqrt()) / 2.0, 0.5_f32.sqrt() / 2.0];
        assert!((picture.mean().x - (0.875 * cap + 0.125 * below)).abs() < 1e-6);
        let sphere: f64 = (0..4).map(|row| 2.0 * picture.solid_angle(row)).sum();
        assert!((sphere - 4.0 * PI).abs() < 1e-12);
    }

    #[test]
    fn pictures_that_are_none_are_errors() {
        let folder = tempfile::tempdir().unwrap();
        let problem = |name: &str, bytes: &[u8]| {
            let path = folder.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            SkyPicture::read(&path, 1.0).unwrap_err().problem
        };
        assert_eq!(problem("a.png", b""), "this is no picture that serves as a sky");
        assert!(problem("a.hdr", b"#?RADIANCE\n").starts_with("the picture is damaged: "));
        assert!(problem("a.exr", b"").starts_with("the picture is damaged: "));
        let huge = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 99999 +X 99999\n";
        assert!(problem("b.hdr", huge).contains("at most"), "{}", problem("b.hdr", huge));
        assert_eq!(SkyPicture::read(Path::new("no.hdr"), 1.0).unwrap_err().problem, "no such file");
    }
}
