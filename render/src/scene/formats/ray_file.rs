//! Rays from a file, one for each pixel: lines of `ox oy oz dx dy dz`, or an EXR picture with channels of these names.
//!
//! Rows from the top left pixel on. Numbers are separated by blanks, commas or semicolons; blank lines and `#` comments
//! are skipped. Directions may have any length.

use std::fs;
use std::path::Path;

use glam::Vec3;
use halfdome_kernel::MAX_COORDINATE;

use crate::output;
use crate::scene::description::unit;
use crate::scene::{Place, RayTable, SceneError};

/// The numbers of a ray, by their channels' names.
const NAMES: [&str; 6] = ["ox", "oy", "oz", "dx", "dy", "dz"];
const RIGHT: &str = "write six numbers: ox oy oz dx dy dz";

impl RayTable {
    /// Reads the rays of a picture of `width` by `height` pixels.
    ///
    /// # Errors
    /// If the file cannot be read, has more or fewer rays than the picture has pixels, or one that goes nowhere.
    pub fn read(path: &Path, width: u32, height: u32) -> Result<Self, SceneError> {
        let is_exr = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
        let rays = if is_exr { read_exr(path, width, height)? } else { read_text(path, width, height)? };
        Ok(Self { width, height, rays })
    }
}

fn read_text(path: &Path, width: u32, height: u32) -> Result<Vec<[Vec3; 2]>, SceneError> {
    let bytes = fs::read(path).map_err(|error| SceneError::unreadable(path, &error))?;
    let pixels = width as usize * height as usize;
    let (mut rays, mut last) = (Vec::new(), 1);
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        let error =
            |problem: String, remedy: &str| SceneError::new(path, Place::Line(line), problem, remedy.to_owned());
        let text = str::from_utf8(text).map_err(|_| error("this is not UTF-8".to_owned(), "give plain text"))?;
        let text = text.trim();
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        if rays.len() == pixels {
            let problem = format!("there are more rays than the {pixels} pixels of a picture of {width}x{height}");
            return Err(error(problem, "give one line for each pixel, or the picture the size of the file"));
        }
        let words = text.split([',', ';', ' ', '\t']).filter(|word| !word.is_empty());
        let mut numbers = Vec::with_capacity(NAMES.len());
        for word in words {
            numbers.push(word.parse().map_err(|_| error(format!("`{word}` is not a number"), RIGHT))?);
        }
        let count = numbers.len();
        let numbers: [f32; 6] =
            numbers.try_into().map_err(|_| error(format!("this line has {count} numbers"), RIGHT))?;
        rays.push(ray(numbers).map_err(|problem| error(problem, &remedy()))?);
        last = line;
    }
    if rays.len() < pixels {
        let problem =
            format!("the file ends after {} rays, and a picture of {width}x{height} has {pixels} pixels", rays.len());
        let remedy = "give one line for each pixel, or the picture the size of the file";
        return Err(SceneError::new(path, Place::Line(last), problem, remedy));
    }
    Ok(rays)
}

fn read_exr(path: &Path, width: u32, height: u32) -> Result<Vec<[Vec3; 2]>, SceneError> {
    let picture = output::read_exr(path)
        .map_err(|error| SceneError::new(path, Place::File, error.problem.clone(), error.remedy.clone()))?;
    if (picture.width, picture.height) != (width, height) {
        let problem =
            format!("it has {}x{} rays, and the picture {width}x{height} pixels", picture.width, picture.height);
        return Err(SceneError::new(path, Place::File, problem, "give the picture the size of the file"));
    }
    let mut planes = Vec::with_capacity(NAMES.len());
    for name in NAMES {
        let channel = picture.channel(name).ok_or_else(|| {
            let remedy = format!("give it channels called {}", NAMES.join(", "));
            SceneError::new(path, Place::File, format!("it has no channel `{name}`"), remedy)
        })?;
        planes.push(&channel.values);
    }
    let pixel = |i: usize| {
        ray(core::array::from_fn(|plane| planes[plane][i])).map_err(|problem| {
            let place = format!("pixel {}, {}", i % width as usize, i / width as usize);
            SceneError::new(path, Place::Part(place), problem, remedy())
        })
    };
    (0..planes[0].len()).map(pixel).collect()
}

/// Origin and unit direction, or what is wrong with them.
fn ray([ox, oy, oz, dx, dy, dz]: [f32; 6]) -> Result<[Vec3; 2], String> {
    let (origin, direction) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
    if !origin.is_finite() || !direction.is_finite() {
        return Err("this ray has a number that is not finite".to_owned());
    }
    if origin.abs().max_element() > MAX_COORDINATE {
        return Err(format!("the origin {origin} is too far away"));
    }
    let direction = unit(direction).ok_or("the direction of this ray is zero")?;
    Ok([origin, direction])
}

fn remedy() -> String {
    format!("write finite numbers, origins up to {MAX_COORDINATE:e}, and a direction that is not zero")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, size: (u32, u32)) -> Result<RayTable, SceneError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rays.csv");
        fs::write(&path, text).unwrap();
        RayTable::read(&path, size.0, size.1)
    }

    #[test]
    fn lines_are_rays() {
        let text = "# two\n1,2,3,0,0,-2\r\n\n 4 5 6  0\t3;4\n";
        let table = read(text, (2, 1)).unwrap();
        let expected = [[Vec3::new(1.0, 2.0, 3.0), Vec3::NEG_Z], [Vec3::new(4.0, 5.0, 6.0), Vec3::new(0.0, 0.6, 0.8)]];
        assert_eq!(table, RayTable { width: 2, height: 1, rays: expected.to_vec() });
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, line, problem) in [
            ("0 0 0 0 0 1\n0 0 0 0 0 0\n", 2, "the direction of this ray is zero"),
            ("0 0 0 0 0 1\n\n0 nan 0 0 0 1", 3, "this ray has a number that is not finite"),
            ("0 0 0 0 inf 1\n", 1, "this ray has a number that is not finite"),
            ("0 0 1e30 0 0 1\n", 1, "the origin [0, 0, 1000000000000000000000000000000] is too far away"),
            ("0 0 0 0 1\n", 1, "this line has 5 numbers"),
            ("0 0 0 0 1 2 3\n", 1, "this line has 7 numbers"),
            ("0 0 0 0 1 x\n", 1, "`x` is not a number"),
            ("0 0 0 0 0 1\n", 1, "the file ends after 1 rays, and a picture of 2x1 has 2 pixels"),
            ("", 1, "the file ends after 0 rays, and a picture of 2x1 has 2 pixels"),
            (
                "0 0 0 0 0 1\n0 0 0 0 0 1\n#\n0 0 0 0 0 1\n",
                4,
                "there are more rays than the 2 pixels of a picture of 2x1",
            ),
        ] {
            let error = read(text, (2, 1)).unwrap_err();
            assert_eq!((&error.place, error.problem.as_str()), (&Place::Line(line), problem), "{text}");
        }
    }
}
