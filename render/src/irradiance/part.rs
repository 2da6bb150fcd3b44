//! Sensors' irradiance from several processes: each writes the lines of its shard, and these are joined.
//!
//! The file is text: a header line, then the lines of the sensors. Numbers are written so that they are read back
//! exactly, and lines are copied unchanged, so the parts give the bytes of a single run.

use std::fmt::Write as _;

use glam::Vec3;
use xxhash_rust::xxh3::{Xxh3, xxh3_64};

use super::{Request, Sensor};
use crate::settings::{Invalid, Shard};

/// The beginning of the first line.
const TITLE: &str = "# irradiance by halfdome";
/// The form of the file.
const VERSION: u32 = 1;

/// The lines of a shard's sensors.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SensorPart {
    shard: Shard,
    /// All sensors, those of others included.
    sensors: usize,
    /// The hash of all inputs of the values; see [`key`].
    key: u64,
    lines: String,
}

/// A hash of what irradiance at sensors depends on: the world's hash, the sensors, the request, and what else has a hash or
/// a name.
pub fn key(world: u64, sensors: &[Sensor], request: &Request, others: &str) -> u64 {
    let mut hash = Xxh3::new();
    let Request { spp, seed, part } = request;
    hash.update(format!("{} {world} {spp} {seed} {part:?} {others}", env!("CARGO_PKG_VERSION")).as_bytes());
    let numbers = sensors.iter().flat_map(|sensor| [sensor.position, sensor.normal]).flat_map(|it| it.to_array());
    numbers.for_each(|number| hash.update(&number.to_bits().to_le_bytes()));
    hash.digest()
}

/// A line for each value, with as many digits as tell 32-bit floats apart.
pub fn lines<'a>(values: impl IntoIterator<Item = &'a Vec3>) -> String {
    values.into_iter().fold(String::new(), |mut text, Vec3 { x, y, z }| {
        let _ = writeln!(text, "{x} {y} {z}");
        text
    })
}

impl SensorPart {
    /// The part of `values`, which are those of all sensors, that is a shard.
    pub fn new(shard: Shard, key: u64, values: &[Vec3]) -> Self {
        let own = values.iter().enumerate().filter(|(sensor, _)| shard.has(*sensor)).map(|(_, value)| value);
        Self { shard, sensors: values.len(), key, lines: lines(own) }
    }

    /// Whether a file is one, whole or not.
    pub fn is_part(bytes: &[u8]) -> bool {
        bytes.starts_with(TITLE.as_bytes())
    }

    /// The file.
    pub fn encode(&self) -> String {
        let Self { shard, sensors, key, lines } = self;
        let (number, count) = (shard.number() + 1, shard.count());
        let sum = xxh3_64(lines.as_bytes());
        format!("{TITLE} {VERSION}: shard {number}/{count} of {sensors} sensors, {key:016x} {sum:016x}\n{lines}")
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it is none, cut off or damaged, or of another version.
    pub fn decode(bytes: &[u8]) -> Result<Self, Invalid> {
        const REMEDY: &str = "find this part again: `halfdome irradiance --shard`";
        let damaged = || Invalid::new("is cut off or damaged", REMEDY);
        let text = str::from_utf8(bytes).map_err(|_| damaged())?;
        let (title, lines) = text.split_once('\n').ok_or_else(damaged)?;
        let words = title.strip_prefix(TITLE).and_then(|rest| rest.trim_start().split_once(": "));
        let (version, words) = words.ok_or_else(damaged)?;
        if version != VERSION.to_string() {
            let problem = format!("is of format {version}, and this program reads format {VERSION}");
            return Err(Invalid::new(problem, "use the version of halfdome that wrote it"));
        }
        let part = Self::of_words(words, lines).ok_or_else(damaged)?;
        // The last part of the title is the sum of the lines.
        if part.encode().lines().next() != Some(title) || lines.lines().count() != part.shard.items(part.sensors) {
            return Err(damaged());
        }
        Ok(part)
    }

    fn of_words(words: &str, lines: &str) -> Option<Self> {
        let [_, shard, _, sensors, _, key, _] = words.split(' ').collect::<Vec<_>>().try_into().ok()?;
        let (number, count) = shard.split_once('/')?;
        let (number, count): (u32, u32) = (number.parse().ok()?, count.parse().ok()?);
        let shard = Shard::new(number.checked_sub(1)?, count)?;
        let key = u64::from_str_radix(key, 16).ok()?;
        Some(Self { shard, sensors: sensors.parse().ok()?, key, lines: lines.to_owned() })
    }
}

/// The lines of all sensors, of parts that have these names.
///
/// # Errors
/// If parts are of different scenes, sensors or options, or if they are not all shards, each once.
pub fn join(parts: &[(String, SensorPart)]) -> Result<String, Invalid> {
    let Some((first, SensorPart { key, sensors, .. })) = parts.first() else { return Ok(String::new()) };
    if let Some((other, _)) = parts.iter().find(|(_, part)| (part.key, part.sensors) != (*key, *sensors)) {
        let problem = format!("{other} is of another scene than {first}, or of other sensors or options");
        return Err(Invalid::new(problem, "put parts together that differ in their shard alone"));
    }
    let shards: Vec<_> = parts.iter().map(|(name, part)| (name.clone(), part.shard)).collect();
    Shard::check_all(&shards)?;
    let mut in_order: Vec<_> = parts.iter().map(|(_, part)| (part.shard.number(), part.lines.lines())).collect();
    in_order.sort_by_key(|(number, _)| *number);
    let mut text = String::new();
    for sensor in 0..*sensors {
        let count = in_order.len();
        text.extend(in_order[sensor % count].1.next());
        text.push('\n');
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values() -> Vec<Vec3> {
        (0..10_u8).map(|i| Vec3::new(f32::from(i), 1.0 / 3.0, 1e-20)).collect()
    }

    fn part(number: u32, count: u32) -> (String, SensorPart) {
        (format!("{number}.txt"), SensorPart::new(Shard::new(number - 1, count).unwrap(), 7, &values()))
    }

    #[test]
    fn parts_join_to_the_lines_of_all() {
        for count in [1, 2, 3, 16] {
            let parts: Vec<_> = (1..=count).rev().map(|number| part(number, count)).collect();
            let again = parts.iter().map(|(name, part)| (name.clone(), SensorPart::decode(part.encode().as_bytes())));
            let again: Vec<_> = again.map(|(name, part)| (name, part.unwrap())).collect();
            assert_eq!(again, parts);
            assert_eq!(join(&parts).unwrap(), lines(&values()), "{count}");
        }
    }

    #[test]
    fn what_does_not_belong_together_is_named() {
        let problem = |parts: &[(String, SensorPart)]| join(parts).unwrap_err().problem;
        let mut foreign = part(2, 2);
        foreign.1.key += 1;
        let told = problem(&[part(1, 2), foreign]);
        assert_eq!(told, "2.txt is of another scene than 1.txt, or of other sensors or options");
        assert_eq!(problem(&[part(1, 2)]), "the shard 2/2 is missing");
        assert_eq!(problem(&[part(1, 2), part(1, 2)]), "1.txt and 1.txt both are shard 1/2");
    }

    #[test]
    fn damage_is_seen() {
        let text = part(1, 3).1.encode();
        assert!(SensorPart::is_part(text.as_bytes()));
        for end in 0..text.len() {
            assert!(SensorPart::decode(&text.as_bytes()[..end]).is_err(), "{end}");
        }
        let other = text.replacen("halfdome 1", "halfdome 9", 1);
        let told = SensorPart::decode(other.as_bytes()).unwrap_err().problem;
        assert_eq!(told, "is of format 9, and this program reads format 1");
        let changed = text.replacen("0 0.33333334", "0 0.33333335", 1);
        assert_eq!(SensorPart::decode(changed.as_bytes()).unwrap_err().problem, "is cut off or damaged");
    }
}
