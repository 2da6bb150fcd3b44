//! Several caches of one scene made one. Records are sorted by their keys, so the order of the caches does not matter.

use super::Cache;
use super::file::CacheFileError;
use super::record::Record;

impl Cache {
    /// This cache with the records of another. Records that both have are there once.
    ///
    /// # Errors
    /// If the caches are of different scenes, or were made with different options.
    pub fn merge(self, other: Self) -> Result<Self, CacheFileError> {
        self.check(&other.options, other.scene)?;
        let mut merged = Self::new(other.options, other.scene);
        let mut records: Vec<Record> = self.into_original().chain(other.into_original()).collect();
        records.sort_by_cached_key(|record| (record.key, record.words()));
        records.dedup_by_key(|record| (record.key, record.words()));
        merged.commit(records);
        Ok(merged)
    }
}
