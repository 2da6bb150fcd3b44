//! The results of a bake so far, so that a stopped bake can resume: values of blocks of texels, and irradiance records.
//!
//! Everything has a key and a value of 32-bit words, and does not depend on when it was computed. A resumed bake looks
//! up the checkpoint before it traces rays; as everything else follows from these values, it ends with the same bytes
//! as an uninterrupted one.
//!
//! The file: magic bytes, a version, the hash of what is baked, the number of entries, the entries by their keys (key,
//! number of words, words), and the FNV-1a hash of all that, everything little-endian. It is replaced in one step.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::manifest::Hash;
use crate::cache::Record;
use crate::film::Bytes;
use crate::integrator;
use crate::output::{OutputError, OutputFile};
use crate::settings::{Invalid, Shard};

const MAGIC: [u8; 8] = *b"halfdBAK";
const VERSION: u32 = 8;
const HEADER: usize = 8 + 4 + 8 + 8;
const CHECKSUM: usize = 8;

/// The kind of a key; the least significant bits are an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Blocks of texels with light that needs no cache.
    Texels = 1,
    /// Blocks of texels with light that no cache provides.
    Missing = 2,
    /// Irradiance records of the final cache.
    Records = 3,
    /// Blocks of records with what is kept of where light comes from.
    Moments = 4,
    /// Irradiance records of the rough cache.
    Rough = 5,
    /// The index of the shard whose texels these are, and how many shards there are.
    Shard = 6,
}

/// The extension of a checkpoint's file.
pub const STATE_EXTENSION: &str = "state";

/// Values by stage and number.
type Entries = BTreeMap<(u8, u64), Vec<u32>>;

/// The checkpoint of a bake.
#[derive(Debug)]
pub struct Checkpoint {
    hash: u64,
    state: Mutex<State>,
    file: Option<(OutputFile, Duration)>,
}

#[derive(Debug)]
struct State {
    entries: Entries,
    saved: Instant,
    /// The error when it was written; the bake continues.
    failure: Option<OutputError>,
}

impl Checkpoint {
    /// An empty checkpoint of what has this hash, which is kept in memory alone.
    pub fn new(hash: u64) -> Self {
        let state = State { entries: BTreeMap::new(), saved: Instant::now(), failure: None };
        Self { hash, state: Mutex::new(state), file: None }
    }

    /// Writes the checkpoint to a file from now on, whenever `interval` has passed since the last time.
    pub fn keep(self, file: OutputFile, interval: Duration) -> Self {
        Self { file: Some((file, interval)), ..self }
    }

    /// Reads a checkpoint of what has this hash; `None` if there is no file.
    ///
    /// # Errors
    /// If the file cannot be read, is not a checkpoint, is damaged, or belongs to another bake.
    pub fn read(path: &Path, hash: u64) -> Result<Option<Self>, Invalid> {
        let error = |problem: &str| {
            let remedy = "leave --resume out to start again";
            Invalid::new(format!("{}: {problem}", path.display()), remedy)
        };
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(failure) if failure.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(failure) => return Err(error(&format!("cannot be read: {failure}"))),
        };
        let (found, entries) = decode(&bytes).ok_or_else(|| error("is not the state of a bake, or is damaged"))?;
        if found != hash {
            return Err(error("belongs to another level or to other options"));
        }
        let checkpoint = Self::new(hash);
        checkpoint.state().entries = entries;
        Ok(Some(checkpoint))
    }

    /// The path of the state of a bake to `output`.
    pub fn path(output: &Path) -> PathBuf {
        let mut name = output.as_os_str().to_owned();
        name.push(".");
        name.push(STATE_EXTENSION);
        name.into()
    }

    /// Whether a file's bytes begin as a checkpoint's do.
    pub fn is_checkpoint(bytes: &[u8]) -> bool {
        bytes.starts_with(&MAGIC)
    }

    /// The file of a checkpoint with all that shards of a bake have found, of whose files these are the names and
    /// bytes.
    ///
    /// # Errors
    /// If one is no shard's checkpoint or damaged, or of another level or other options than the first; if they are not
    /// all shards, each once.
    pub fn merge(files: &[(String, Vec<u8>)]) -> Result<Vec<u8>, Invalid> {
        const AGAIN: &str = "find this part again: `halfdome bake --shard`";
        let (mut shards, mut all, mut hash) = (Vec::new(), Entries::new(), None);
        for (name, bytes) in files {
            let damaged = || Invalid::new(format!("{name} is not the state of a bake, or is damaged"), AGAIN);
            let (found, mut entries) = decode(bytes).ok_or_else(damaged)?;
            if *hash.get_or_insert(found) != found {
                let problem = format!("{name} belongs to another level or to other options than {}", files[0].0);
                return Err(Invalid::new(problem, "put parts together that differ in their shard alone"));
            }
            let shard = entries.remove(&(Stage::Shard as u8, 0)).ok_or_else(|| {
                Invalid::new(format!("{name} is the state of a whole bake, not of a shard"), "leave it out")
            })?;
            let (&[number, count], &[is_whole]) =
                (shard.first_chunk().ok_or_else(damaged)?, shard.last_chunk().ok_or_else(damaged)?);
            if is_whole == 0 {
                let problem = format!("{name} was stopped before its end");
                return Err(Invalid::new(problem, "continue it: the same command with --resume"));
            }
            shards.push((name.clone(), Shard::new(number, count).ok_or_else(damaged)?));
            all.append(&mut entries);
        }
        Shard::check_all(&shards)?;
        Ok(encode(hash.unwrap_or_default(), &all))
    }

    /// The shard that it is of, if it is of one.
    pub fn shard(&self) -> Option<Shard> {
        let words = self.get(Stage::Shard, 0)?;
        words.first_chunk().and_then(|&[number, count]| Shard::new(number, count))
    }

    /// Takes note of which shard it is of, and whether all of that is there.
    pub(crate) fn put_shard(&self, shard: Shard, is_whole: bool) {
        self.put(Stage::Shard, 0, vec![shard.number(), shard.count(), is_whole.into()]);
    }

    /// Writes the file now.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn save(&self) -> Result<(), OutputError> {
        let Some((file, _)) = &self.file else { return Ok(()) };
        let bytes = encode(self.hash, &self.state().entries);
        file.write(&bytes)
    }

    /// Removes the file, now that everything is done.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn remove(&self) -> Result<(), OutputError> {
        self.file.as_ref().map_or(Ok(()), |(file, _)| file.remove())
    }

    /// The error of the last write of the file.
    pub fn failure(&self) -> Option<OutputError> {
        self.state().failure.clone()
    }

    /// The value of a key.
    pub(crate) fn get(&self, stage: Stage, number: u64) -> Option<Vec<u32>> {
        self.state().entries.get(&(stage as u8, number)).cloned()
    }

    /// Takes note of a value.
    pub(crate) fn put(&self, stage: Stage, number: u64, words: Vec<u32>) {
        let mut state = self.state();
        state.entries.insert((stage as u8, number), words);
        let Some((file, interval)) = &self.file else { return };
        if state.saved.elapsed() >= *interval {
            let bytes = encode(self.hash, &state.entries);
            state.failure = file.write(&bytes).err();
            state.saved = Instant::now();
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Entries are put in whole, whatever happened to a thread.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Irradiance records in a checkpoint.
pub(crate) struct CheckpointedRecords<'a> {
    pub(crate) checkpoint: &'a Checkpoint,
    /// The cache that they belong to.
    pub(crate) stage: Stage,
}

impl integrator::RecordLog for CheckpointedRecords<'_> {
    fn get(&self, key: u64) -> Option<Record> {
        self.checkpoint
            .get(self.stage, key)
            .and_then(|words| Some(Record::from_words(key, words.as_slice().try_into().ok()?)))
    }

    fn put(&self, record: &Record) {
        self.checkpoint.put(self.stage, record.key, record.words().to_vec());
    }
}

fn encode(hash: u64, entries: &Entries) -> Vec<u8> {
    let mut bytes =
        Vec::with_capacity(HEADER + CHECKSUM + entries.values().map(|words| 13 + 4 * words.len()).sum::<usize>());
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(hash.to_le_bytes());
    bytes.extend((entries.len() as u64).to_le_bytes());
    for ((stage, number), words) in entries {
        bytes.push(*stage);
        bytes.extend(number.to_le_bytes());
        bytes.extend((words.len() as u32).to_le_bytes());
        words.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
    }
    bytes.extend(Hash::of(&bytes).0.to_le_bytes());
    bytes
}

/// The hash and the entries of a file.
fn decode(bytes: &[u8]) -> Option<(u64, Entries)> {
    let (contents, checksum) = bytes.split_last_chunk::<CHECKSUM>()?;
    let mut rest = Bytes(contents);
    let is_ours = rest.array()? == MAGIC && rest.word()? == VERSION;
    if !is_ours || u64::from_le_bytes(*checksum) != Hash::of(contents).0 {
        return None;
    }
    let (hash, count) = (rest.long()?, rest.long()?);
    let mut entries = BTreeMap::new();
    for _ in 0..count {
        let ([stage], number, length) = (rest.array()?, rest.long()?, rest.word()?);
        let words = rest.slice((length as usize).checked_mul(4)?)?.chunks_exact(4);
        let words = words.map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]));
        entries.insert((stage, number), words.collect());
    }
    rest.0.is_empty().then_some((hash, entries))
}
