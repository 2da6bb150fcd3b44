//! Refuses work that exceeds the machine's memory, before it starts.

use super::error::CliError;
use crate::denoise::Method;
use crate::settings::Settings;

/// An error if the picture needs more than the machine's memory.
pub(super) fn check(settings: &Settings) -> Result<(), CliError> {
    check_denoised(settings, None)
}

/// The same of a picture that is denoised, if it is.
pub(super) fn check_denoised(settings: &Settings, method: Option<&Method>) -> Result<(), CliError> {
    let what = format!("a picture of {}x{}", settings.width, settings.height);
    // The noisy picture's sums are still there while it is denoised.
    let denoising = method.map_or(0, |method| method.bytes(settings.width, settings.height));
    require(&what, settings.picture_bytes() + denoising, "give a smaller --size")
}

/// An error if `what` needs more bytes than the machine's memory has. Where that is not known, everything passes.
pub(super) fn require(what: &str, bytes: u64, remedy: &str) -> Result<(), CliError> {
    match machine_bytes() {
        Some(machine) if bytes > machine => Err(CliError::Input(format!(
            "{what} needs about {}, and this machine has {}\n  help: {remedy}",
            size(bytes),
            size(machine),
        ))),
        _ => Ok(()),
    }
}

/// The machine's memory as reported by Linux.
fn machine_bytes() -> Option<u64> {
    total_bytes(&std::fs::read_to_string("/proc/meminfo").ok()?)
}

/// `MemTotal` of a `/proc/meminfo`.
fn total_bytes(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// `bytes` for people.
pub(super) fn size(bytes: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let unit = (bytes.max(1).ilog2() / 10).min(4);
    if unit == 0 {
        return format!("{bytes} B");
    }
    format!("{:.1} {}", bytes as f64 / f64::from(unit * 10).exp2(), units[unit as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_found_among_the_other_lines() {
        let text = "MemFree:  1 kB\nMemTotal:       24608920 kB\nMemAvailable: 3 kB\n";
        assert_eq!(total_bytes(text), Some(24_608_920 * 1024));
        assert_eq!(total_bytes("MemTotal: many kB"), None);
        assert_eq!(total_bytes(""), None);
    }

    #[test]
    fn sizes_have_binary_units() {
        assert_eq!(size(0), "0 B");
        assert_eq!(size(1023), "1023 B");
        assert_eq!(size(1024), "1.0 KiB");
        assert_eq!(size(3 << 29), "1.5 GiB");
    }
}
