//! Caches on disk.
//!
//! All numbers are little-endian. A file is the magic bytes, a version, a mark that tells the order of bytes, the hash
//! of the scene, the options, the number of records, the records by their keys (the key and [`Record::WORDS`] words
//! each, with the radii as they were made) and the FNV-1a hash of all that. A file that is cut off, changed or of
//! another kind is refused; so is one of another scene or other options, and the message says which. Files are replaced
//! in one step, as pictures are.

use std::fs;
use std::path::Path;

use super::record::Record;
use super::{Cache, ErrorEstimate};
use crate::film::Bytes;
use crate::output::{OutputError, OutputFile};
use crate::scene::fnv;
use crate::settings::{CachedOptions, GatherLayout, Gradients, Invalid, Metric};

const MAGIC: [u8; 8] = *b"halfdIRC";
const VERSION: u32 = 5;
/// Reads as another number on a machine with the other order of bytes.
const ORDER: u32 = 0x0102_0304;
const HEADER: usize = 8 + 4 + 4 + 8 + (OPTIONS + 2) * 4 + 8;
/// Words of the options.
const OPTIONS: usize = 7;
const RECORD: usize = 8 + 4 * Record::WORDS;
const CHECKSUM: usize = 8;

/// Why a cache cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CacheFileError(Invalid);

impl CacheFileError {
    fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self(Invalid::new(problem, remedy))
    }

    /// The error with the name of the file that it is about.
    pub fn naming(self, path: &Path) -> Self {
        Self::new(format!("{}: {}", path.display(), self.0.problem), self.0.remedy)
    }
}

impl Cache {
    /// Reads a cache of the scene with this hash, made with these options; without them, of any scene, made with any.
    ///
    /// # Errors
    /// If the file cannot be read, is no cache or damaged, or a cache of something else.
    pub fn read(path: &Path, expected: Option<(&CachedOptions, u64)>) -> Result<Self, CacheFileError> {
        let bytes = fs::read(path).map_err(|error| {
            CacheFileError::new(
                format!("{}: cannot be read: {error}", path.display()),
                "name a file that `halfdome cache build` has made",
            )
        })?;
        let cache = Self::decode(&bytes).map_err(|error| error.naming(path))?;
        if let Some((options, scene)) = expected {
            cache.check(options, scene).map_err(|error| error.naming(path))?;
        }
        Ok(cache)
    }

    /// Writes the cache, in place of a file that is there.
    ///
    /// # Errors
    /// What the operating system says; then the file is as it was.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        OutputFile::check(path)?.write(&self.encode())
    }

    /// A hash of all that it has: equal caches have equal ones.
    pub fn hash(&self) -> u64 {
        fnv(&self.encode())
    }

    /// Refuses options or a scene that are not this cache's.
    pub(super) fn check(&self, options: &CachedOptions, scene: u64) -> Result<(), CacheFileError> {
        if scene != self.scene {
            return Err(CacheFileError::new(
                format!("the cache is of another scene (hash {:016x}, not {scene:016x})", self.scene),
                "build it again; all but the camera counts: geometry, materials, lights and sky",
            ));
        }
        match self.differing(options) {
            None => Ok(()),
            Some((name, ours, theirs)) => Err(CacheFileError::new(
                format!("the cache was built with --{name} {ours}, not {theirs}"),
                "give the options with which it was built, or build it again",
            )),
        }
    }

    /// Refuses a cache that is not of this one's scene, or was built with other options.
    pub(super) fn check_like(&self, other: &Self) -> Result<(), CacheFileError> {
        let remedy = "merge caches of one scene that were built with the same options";
        if other.scene != self.scene {
            let problem = format!("the cache is of another scene (hash {:016x}) than", other.scene);
            return Err(CacheFileError::new(format!("{problem} those before it ({:016x})", self.scene), remedy));
        }
        match other.differing(&self.options) {
            None => Ok(()),
            Some((name, theirs, ours)) => Err(CacheFileError::new(
                format!("the cache was built with --{name} {theirs}, those before it with {ours}"),
                remedy,
            )),
        }
    }

    /// The name of the first option that is not the same, and its values in this cache and in `options`. Where these
    /// ask for an accuracy, what follows from it is the cache's own.
    fn differing(&self, options: &CachedOptions) -> Option<(&'static str, String, String)> {
        let mut pairs = named(&self.options).into_iter().zip(named(options));
        let is_free = |name: &str| options.accuracy.is_some() && ["cache-error", "record-rays"].contains(&name);
        pairs
            .find(|((name, ours), (_, theirs))| ours != theirs && !is_free(name))
            .map(|((name, ours), (_, theirs))| (name, ours, theirs))
    }

    /// The bytes of a file of this cache.
    pub fn encode(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(HEADER + self.records.len() * RECORD + CHECKSUM);
        bytes.extend(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(ORDER.to_le_bytes());
        bytes.extend(self.scene.to_le_bytes());
        let ErrorEstimate { light, root_mean_square } = self.estimate.unwrap_or_default();
        for word in words(&self.options).into_iter().chain([light, root_mean_square].map(f32::to_bits)) {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend((self.records.len() as u64).to_le_bytes());
        let original = self.records.iter().zip(&self.original_radii);
        let mut records: Vec<_> =
            original.map(|(record, &radii)| (record.key, Record { radii, ..*record }.words())).collect();
        records.sort_unstable();
        for (key, words) in records {
            bytes.extend(key.to_le_bytes());
            bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
        }
        bytes.extend(fnv(&bytes).to_le_bytes());
        bytes
    }

    /// The cache of a file's bytes.
    ///
    /// # Errors
    /// If they are no cache's, or damaged.
    pub fn decode(bytes: &[u8]) -> Result<Self, CacheFileError> {
        let again = "build it again with `halfdome cache build`";
        if !bytes.starts_with(&MAGIC) {
            return Err(CacheFileError::new(
                "is no irradiance cache",
                "name a file that `halfdome cache build` has made",
            ));
        }
        let mut rest = Bytes(&bytes[MAGIC.len()..]);
        let cut = || CacheFileError::new(format!("is cut off after {} bytes", bytes.len()), again);
        let version = rest.word().ok_or_else(cut)?;
        let order = rest.word().ok_or_else(cut)?;
        if order != ORDER {
            return Err(CacheFileError::new("has the order of bytes of another machine, or is damaged", again));
        }
        if version != VERSION {
            let problem = format!("has version {version} of the format; this program reads version {VERSION}");
            return Err(CacheFileError::new(problem, again));
        }
        let scene = rest.long().ok_or_else(cut)?;
        let (mut options, mut estimate) = ([0; OPTIONS], [0; 2]);
        for word in options.iter_mut().chain(&mut estimate) {
            *word = rest.word().ok_or_else(cut)?;
        }
        let count = rest.long().ok_or_else(cut)?;
        let expected = usize::try_from(count).ok().and_then(|count| count.checked_mul(RECORD));
        match expected.and_then(|expected| expected.checked_add(CHECKSUM)) {
            Some(expected) if expected == rest.0.len() => {}
            Some(expected) if expected < rest.0.len() => {
                return Err(CacheFileError::new("has bytes after its end", again));
            }
            _ => return Err(cut()),
        }
        let (contents, checksum) = bytes.split_at(bytes.len() - CHECKSUM);
        if Bytes(checksum).long() != Some(fnv(contents)) {
            return Err(CacheFileError::new("is damaged: its checksum is wrong", again));
        }
        let options = from_words(options)
            .ok_or_else(|| CacheFileError::new("has options that this version does not know", again))?;
        let mut records = Vec::with_capacity(count as usize);
        for _ in 0..count {
            let key = rest.long().ok_or_else(cut)?;
            let mut words = [0; Record::WORDS];
            for word in &mut words {
                *word = rest.word().ok_or_else(cut)?;
            }
            records.push(Record::from_words(key, &words));
        }
        if !records.iter().all(Record::is_valid) {
            return Err(CacheFileError::new("has an invalid record: a number is not finite or out of range", again));
        }
        let [light, root_mean_square] = estimate.map(f32::from_bits);
        let is_valid = |number: f32| (0.0..f32::INFINITY).contains(&number);
        if !is_valid(light) || !is_valid(root_mean_square) {
            return Err(CacheFileError::new("has an error estimate that is no number", again));
        }
        let estimate = options.accuracy.map(|_| ErrorEstimate { light, root_mean_square });
        let mut cache = Self { estimate, ..Self::new(options, scene) };
        cache.commit(records);
        Ok(cache)
    }
}

/// The options as words: the error's bits, gradients, metric, layout, rays, bounces, the accuracy's bits or 0.
fn words(options: &CachedOptions) -> [u32; OPTIONS] {
    let CachedOptions { error, gradients, metric, layout, rays, bounces, accuracy } = *options;
    let (bounces, accuracy) = (bounces.unwrap_or(u32::MAX), accuracy.map_or(0, f32::to_bits));
    [error.to_bits(), gradients as u32, metric as u32, layout as u32, rays, bounces, accuracy]
}

/// The options of these words, if there are such.
fn from_words([error, gradients, metric, layout, rays, bounces, accuracy]: [u32; OPTIONS]) -> Option<CachedOptions> {
    let error = f32::from_bits(error);
    (error > 0.0 && error <= CachedOptions::MAX_ERROR).then_some(())?;
    let accuracy = (accuracy != 0).then_some(f32::from_bits(accuracy));
    accuracy.is_none_or(|accuracy| accuracy > 0.0 && accuracy <= CachedOptions::MAX_ACCURACY).then_some(())?;
    Some(CachedOptions {
        error,
        gradients: *Gradients::ALL.get(gradients as usize)?,
        metric: *Metric::ALL.get(metric as usize)?,
        layout: *GatherLayout::ALL.get(layout as usize)?,
        rays,
        bounces: (bounces != u32::MAX).then_some(bounces),
        accuracy,
    })
}

/// The options by their names on the command line.
pub(crate) fn named(options: &CachedOptions) -> [(&'static str, String); 7] {
    let CachedOptions { error, gradients, metric, layout, rays, bounces, accuracy } = *options;
    [
        ("cache-error", error.to_string()),
        ("gradients", gradients.name().to_owned()),
        ("metric", metric.name().to_owned()),
        ("layout", layout.name().to_owned()),
        ("record-rays", rays.to_string()),
        ("cache-bounces", bounces.map_or("unlimited".to_owned(), |bounces| bounces.to_string())),
        ("accuracy", accuracy.map_or("none".to_owned(), |accuracy| format!("{}%", 100.0 * accuracy))),
    ]
}
