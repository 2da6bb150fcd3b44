//! Denoising by Intel's Open Image Denoise, on the CPU: the filter `RT` for HDR colours, guided by albedo and normal.
//!
//! The guides are filtered first, each alone, and are then said to be clean, as the manual recommends for final
//! pictures.
//!
//! Source: the manual of Open Image Denoise 2, "Recommended usage" and "Prefiltering".

use std::fmt;
use std::sync::Mutex;

use halfdome_oidn::{FilterError, Image, Library, Role};

use super::DenoiseError;
use super::channels::{Channels, Rgb};
use crate::watch::Watch;

/// Steps of progress.
const STEPS: u64 = 1000;
/// The work of three filters: albedo, normal, colour.
pub(super) const WORK: u64 = 3 * STEPS;

/// Bytes that a pixel takes: four images of three numbers and their copies, and what the library takes, about.
pub(super) const BYTES_PER_PIXEL: u64 = 4 * 3 * 8 + 200;

/// The open library.
#[derive(Clone)]
pub struct Oidn(Library);

impl Oidn {
    /// Finds the library: where the environment variable `OIDN_LIB` says, or else where it usually is.
    ///
    /// # Errors
    /// The library that was not found, the places, and the remedy.
    pub fn find() -> Result<Self, String> {
        Library::find().map(Self).map_err(|error| {
            format!(
                "Open Image Denoise 2 is needed: {error}\n  help: set {}=/path/{}, or use nlm, which needs no library",
                halfdome_oidn::VARIABLE,
                halfdome_oidn::FILE
            )
        })
    }

    /// The colours without noise.
    pub(super) fn denoise(&self, channels: &Channels, watch: &dyn Watch) -> Result<Rgb, DenoiseError> {
        let failed = |error: FilterError| match error {
            FilterError::Stopped => DenoiseError::Stopped,
            error => DenoiseError::Failed(error.to_string()),
        };
        let threads = rayon::current_num_threads().try_into().unwrap_or(0);
        let device = self.0.device(threads).map_err(failed)?;
        let size = (channels.width as usize, channels.height as usize);
        let guides = [
            (Role::Albedo, channels.albedo.as_ref(), 0.0, 1.0),
            (Role::Normal, channels.normal.as_ref().filter(|_| channels.albedo.is_some()), -1.0, 1.0),
        ];
        let mut filtered = Vec::new();
        for (role, guide, least, most) in guides {
            let progress = Progress::new(watch);
            if let Some(guide) = guide {
                let pixels = interleaved(guide, |value| value.clamp(least, most));
                let images = [Image { role, pixels: &pixels }];
                let clean = device.run(size, &images, false, &|done| progress.reach(done)).map_err(failed)?;
                filtered.push((role, clean));
            }
            progress.reach(1.0);
        }
        let color = interleaved(&channels.color, |value| value.max(0.0));
        let mut images = vec![Image { role: Role::Color, pixels: &color }];
        images.extend(filtered.iter().map(|(role, pixels)| Image { role: *role, pixels }));
        let progress = Progress::new(watch);
        let output = device.run(size, &images, true, &|done| progress.reach(done)).map_err(failed)?;
        progress.reach(1.0);
        Ok([0, 1, 2].map(|c| output.iter().map(|pixel| pixel[c]).collect()))
    }
}

impl fmt::Display for Oidn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Open Image Denoise {} (CPU, {})", self.0.version(), self.0.path().display())
    }
}

/// One number of each plane a pixel.
fn interleaved(planes: &Rgb, map: impl Fn(f32) -> f32) -> Vec<[f32; 3]> {
    let [a, b, c] = planes;
    a.iter().zip(b).zip(c).map(|((&a, &b), &c)| [map(a), map(b), map(c)]).collect()
}

/// One filter's part of the progress, in steps; from any thread.
struct Progress<'a> {
    watch: &'a dyn Watch,
    told: Mutex<u64>,
}

impl<'a> Progress<'a> {
    fn new(watch: &'a dyn Watch) -> Self {
        Self { watch, told: Mutex::new(0) }
    }

    /// Reports the finished fraction, 0 to 1; returns whether to continue.
    fn reach(&self, done: f64) -> bool {
        let steps = (done.clamp(0.0, 1.0) * STEPS as f64) as u64;
        if let Ok(mut told) = self.told.lock()
            && steps > *told
        {
            self.watch.advance(steps - *told, 0);
            *told = steps;
        }
        !self.watch.stop()
    }
}
