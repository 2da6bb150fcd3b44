//! Sensors as text: `x y z nx ny nz` on a line, as Radiance's `rtrace -I` takes them. Blank lines and lines that begin
//! with `#` are skipped and have no line in the output.

use std::io::{BufRead, Read as _};

use glam::Vec3;
use halfdome_kernel::MAX_COORDINATE;

use crate::world::{Surface, World};

/// A point that measures what arrives on the side of a normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// The position. Rays start in front of it by a bound of rounding, so that it may lie on a surface.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
}

/// A line that is no sensor, or that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("line {line}: {problem}\n  help: {remedy}")]
pub struct PointsError {
    /// The number of the line, from 1.
    pub line: usize,
    /// The problem.
    pub problem: String,
    /// The remedy.
    pub remedy: String,
}

impl Sensor {
    /// A white surface there.
    pub(super) fn surface<'w>(&self, world: &'w World) -> Surface<'w> {
        world.sensor(self.position, self.normal)
    }

    /// The sensor of a line.
    fn parse(text: &str) -> Result<Self, Wrong> {
        let [x, y, z, nx, ny, nz] = numbers(text, "six", "give six numbers: a position x y z and a normal nx ny nz")?;
        let position = position([x, y, z])?;
        let normal = glam::dvec3(nx, ny, nz);
        if normal.is_nan() {
            return Err((
                format!("the normal {nx} {ny} {nz} is not a number in all its parts"),
                "give three finite numbers that are not all zero".to_owned(),
            ));
        }
        match normal.is_finite().then(|| normal.try_normalize()).flatten() {
            Some(normal) => Ok(Self { position, normal: normal.as_vec3() }),
            None => Err((
                format!("the normal {nx} {ny} {nz} has no direction"),
                "give three finite numbers that are not all zero; the length does not matter".to_owned(),
            )),
        }
    }
}

/// The problem with a line, and the remedy.
type Wrong = (String, String);

/// The numbers of a line, which has `count` of them.
fn numbers<const N: usize>(text: &str, count: &str, remedy: &str) -> Result<[f64; N], Wrong> {
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.len() != N {
        let plural = if words.len() == 1 { "" } else { "s" };
        return Err((format!("has {} value{plural} instead of {count}", words.len()), remedy.to_owned()));
    }
    let mut numbers = [0.0; N];
    for (number, word) in numbers.iter_mut().zip(words) {
        *number = word.parse().map_err(|_| (format!("{word:?} is not a number"), remedy.to_owned()))?;
    }
    Ok(numbers)
}

/// A point that rays can start from.
fn position([x, y, z]: [f64; 3]) -> Result<Vec3, Wrong> {
    let position = glam::dvec3(x, y, z);
    if !position.is_finite() || position.abs().max_element() > f64::from(MAX_COORDINATE) {
        return Err((
            format!("the position {x} {y} {z} is not in reach"),
            format!("give finite coordinates of at most {MAX_COORDINATE:e}, in the scene's units"),
        ));
    }
    Ok(position.as_vec3())
}

/// Reads sensors.
///
/// # Errors
/// The first line that is no sensor, or what the system says about reading.
pub fn read_points(reader: impl BufRead) -> Result<Vec<Sensor>, PointsError> {
    read_lines(reader, Sensor::parse)
}

/// Reads points without a normal, `x y z` on a line.
///
/// # Errors
/// The first line that is no point, or what the system says about reading.
pub fn read_positions(reader: impl BufRead) -> Result<Vec<Vec3>, PointsError> {
    read_lines(reader, |text| position(numbers(text, "three", "give three numbers: a position x y z")?))
}

/// The most bytes of a line, with its end: enough for any numbers and a comment.
const MAX_LINE: u64 = 4096;

/// What `parse` makes of all lines that are neither blank nor comments.
fn read_lines<T>(mut reader: impl BufRead, parse: impl Fn(&str) -> Result<T, Wrong>) -> Result<Vec<T>, PointsError> {
    let (mut found, mut bytes) = (Vec::new(), Vec::new());
    for number in 1.. {
        let error = |problem: String, remedy: &str| PointsError { line: number, problem, remedy: remedy.to_owned() };
        bytes.clear();
        // A binary file may be a single endless line.
        let read = reader.by_ref().take(MAX_LINE + 1).read_until(b'\n', &mut bytes);
        let read =
            read.map_err(|failure| error(format!("cannot be read: {failure}"), "give a file or a stream of text"))?;
        if read == 0 {
            break;
        }
        if read as u64 > MAX_LINE {
            return Err(error(format!("is longer than {MAX_LINE} bytes"), "give plain text, a point on each line"));
        }
        let line = str::from_utf8(&bytes).map_err(|_| error("is not UTF-8".to_owned(), "give plain text"))?;
        // Some editors begin UTF-8 with the mark of an order of bytes.
        let line = if number == 1 { line.trim_start_matches('\u{feff}') } else { line };
        let text = line.trim();
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        found.push(parse(text).map_err(|(problem, remedy)| error(problem, &remedy))?);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec3;

    #[test]
    fn lines_are_sensors_and_the_rest_is_passed_over() {
        let text = "# sensors\n1 2 3 0 0 2\n\n  -1.5e-1\t0 .25   0 -1 0  \r\n#4 5 6\n";
        let expected = [
            Sensor { position: vec3(1.0, 2.0, 3.0), normal: Vec3::Z },
            Sensor { position: vec3(-0.15, 0.0, 0.25), normal: Vec3::NEG_Y },
        ];
        assert_eq!(read_points(text.as_bytes()).unwrap(), expected);
        assert!(read_points(&b""[..]).unwrap().is_empty());
        for first in ["1 2 3 0 0 2\n", "# sensors\n1 2 3 0 0 2\n"] {
            assert_eq!(read_points(format!("\u{feff}{first}").as_bytes()).unwrap(), expected[..1]);
        }
        assert!(read_points("1 2 3 0 0 2\n\u{feff}1 2 3 0 0 2\n".as_bytes()).is_err());
    }

    #[test]
    fn positions_have_three_numbers() {
        assert_eq!(
            read_positions(&b"1 2 3\n# no\n-4 5e-1 6\n"[..]).unwrap(),
            [vec3(1.0, 2.0, 3.0), vec3(-4.0, 0.5, 6.0)]
        );
        let error = |text: &str| read_positions(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(error("1 2"), "line 1: has 2 values instead of three\n  help: give three numbers: a position x y z");
        assert!(error("1 2 3\n\n1 inf 3").starts_with("line 3: the position 1 inf 3 is not in reach"));
    }

    #[test]
    fn wrong_lines_are_named() {
        for (line, problem) in [
            ("1 2 3", "has 3 values instead of six"),
            ("1", "has 1 value instead of six"),
            ("1 2 3 0 0 1 7", "has 7 values instead of six"),
            ("1 2 x 0 0 1", "\"x\" is not a number"),
            ("1,2,3,0,0,1", "has 1 value instead of six"),
            ("nan 2 3 0 0 1", "the position NaN 2 3 is not in reach"),
            ("1 1e30 3 0 0 1", "is not in reach"),
            ("1 2 3 0 0 0", "the normal 0 0 0 has no direction"),
            ("1 2 3 0 inf 0", "the normal 0 inf 0 has no direction"),
            ("1 2 3 0 nan 0", "the normal 0 NaN 0 is not a number"),
        ] {
            let error = read_points(format!("# first\n0 0 0 0 0 1\n{line}\n").as_bytes()).unwrap_err().to_string();
            assert!(
                error.starts_with("line 3: ") && error.contains(problem) && error.contains("\n  help: "),
                "{error}"
            );
        }
        let long = |length: usize| read_points(format!("1 2 3 0 0 1{}\n", " ".repeat(length - 12)).as_bytes());
        assert_eq!(long(MAX_LINE as usize).unwrap().len(), 1);
        assert!(long(MAX_LINE as usize + 1).unwrap_err().to_string().starts_with("line 1: is longer than 4096 bytes"));
        let endless = std::io::BufReader::new(std::io::repeat(0));
        assert!(read_points(endless).unwrap_err().to_string().starts_with("line 1: is longer"));
        let far = |x: f32| read_positions(format!("{x} 0 0").as_bytes());
        assert!(far(MAX_COORDINATE).is_ok());
        assert!(far(MAX_COORDINATE.next_up()).unwrap_err().to_string().contains("at most 4.398"));
        assert!(read_points(&b"\xff\n"[..]).unwrap_err().to_string().contains("is not UTF-8"));
    }
}
