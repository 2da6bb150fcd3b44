//! Merges caches of one scene. Records are sorted by their keys, so the order of the caches does not matter.

use super::file::CacheFileError;
use super::record::Record;
use super::{Cache, ErrorEstimate};

impl Cache {
    /// This cache with the records of another. Records that both have are there once.
    ///
    /// # Errors
    /// If the caches are of different scenes, or were made with different options.
    pub fn merge(mut self, mut other: Self) -> Result<Self, CacheFileError> {
        self.check_like(&other)?;
        let (options, scene) = (other.options, other.scene);
        // The points of both are not known any more; the light that errors are relative to is that of the first.
        let estimate = self.estimate.zip(other.estimate).map(|(ours, theirs)| ErrorEstimate {
            root_mean_square: ours.root_mean_square.max(theirs.root_mean_square),
            ..ours
        });
        let mut records: Vec<Record> = self.take_original().chain(other.take_original()).collect();
        records.sort_by_cached_key(|record| (record.key, record.words()));
        records.dedup_by_key(|record| (record.key, record.words()));
        let mut merged = Self { estimate, ..Self::new(options, scene) };
        merged.commit(records);
        Ok(merged)
    }
}
