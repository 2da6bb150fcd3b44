//! The resources used by this process so far, as counted by the system.

/// Processor time and memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Usage {
    /// Seconds of all threads, in the program and in the system for it.
    pub(super) processor: f64,
    /// The most bytes of memory at one time.
    pub(super) peak_bytes: u64,
}

/// `None` where the system does not count.
#[cfg(unix)]
pub(super) fn of_process() -> Option<Usage> {
    use nix::sys::resource::{UsageWho, getrusage};
    use nix::sys::time::TimeValLike as _;

    let usage = getrusage(UsageWho::RUSAGE_SELF).ok()?;
    let microseconds = usage.user_time().num_microseconds() + usage.system_time().num_microseconds();
    // macOS counts bytes, all others kibibytes.
    let unit = if cfg!(target_vendor = "apple") { 1 } else { 1024 };
    Some(Usage { processor: microseconds as f64 * 1e-6, peak_bytes: u64::try_from(usage.max_rss()).ok()? * unit })
}

/// `None` where the system does not count.
#[cfg(not(unix))]
pub(super) fn of_process() -> Option<Usage> {
    None
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn memory_in_use_is_counted() {
        let before = of_process().unwrap();
        let block = vec![1_u8; 64 << 20];
        let after = of_process().unwrap();
        assert!(block.iter().all(|&byte| byte == 1));
        assert!(after.peak_bytes >= 64 << 20 && after.peak_bytes < 64 << 30, "{after:?}");
        assert!(after.processor >= before.processor && before.processor > 0.0, "{before:?} {after:?}");
    }
}
