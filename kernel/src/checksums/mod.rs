//! Checksums of the kernel's results, kept in the repository: hits, trees and numbers are equal bit for bit on every
//! instruction set of this machine, and on every target that runs these tests (`tests/targets.sh`).
//!
//! After an intended change, `HALFDOME_CHECKSUMS=write cargo test -p halfdome-kernel --lib checksums` rewrites them;
//! the diff shows the differences.

mod hits;
mod numbers;
mod scenes;

/// The 64-bit FNV-1a hash of the bytes of little-endian words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Checksum(u64);

impl Checksum {
    /// Of no words.
    pub(crate) fn new() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }

    /// Goes on with these words.
    fn add_words(&mut self, words: impl IntoIterator<Item = u32>) {
        for byte in words.into_iter().flat_map(u32::to_le_bytes) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3);
        }
    }

    /// Goes on with the bits of these floats.
    pub(crate) fn add(&mut self, floats: impl IntoIterator<Item = f32>) {
        self.add_words(floats.into_iter().map(f32::to_bits));
    }

    fn of(words: impl IntoIterator<Item = u32>) -> Self {
        let mut sum = Self::new();
        sum.add_words(words);
        sum
    }

    fn of_floats(floats: impl IntoIterator<Item = f32>) -> Self {
        Self::of(floats.into_iter().map(f32::to_bits))
    }

    /// The hash.
    pub(crate) fn value(&self) -> u64 {
        self.0
    }
}

impl std::fmt::Display for Checksum {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

/// Compares lines with those that are kept in `tests/checksums/{name}.txt`, or writes them there.
pub(crate) fn compare(name: &str, kept: &str, lines: &[String]) {
    let found: String = lines.iter().map(|line| format!("{line}\n")).collect();
    if std::env::var("HALFDOME_CHECKSUMS").is_ok_and(|what| what == "write") {
        let path = format!("{}/../tests/checksums/{name}.txt", env!("CARGO_MANIFEST_DIR"));
        std::fs::write(path, found).unwrap();
        return;
    }
    for (kept, found) in kept.lines().zip(found.lines()) {
        assert_eq!(kept, found, "tests/checksums/{name}.txt (left) keeps something else");
    }
    assert_eq!(kept.lines().count(), lines.len(), "tests/checksums/{name}.txt has lines of its own");
}
