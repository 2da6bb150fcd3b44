//! Denoising in commands: the method is set up before a long render starts, and its progress is shown.

use std::time::Instant;

use super::error::{CliError, invalid};
use super::messages::{Style, print_text};
use super::progress::Progress;
use crate::denoise::{DenoiseError, MIN_SAMPLES, Method};
use crate::film::Picture;
use crate::settings::{Integrator, Settings};

/// A denoiser, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Denoiser {
    /// Open Image Denoise.
    Oidn,
    /// Our own.
    Nlm,
}

impl Denoiser {
    pub(super) const ALL: [Self; 2] = [Self::Oidn, Self::Nlm];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Oidn => "oidn",
            Self::Nlm => "nlm",
        }
    }

    /// The method, ready to work.
    pub(super) fn method(self) -> Result<Method, CliError> {
        match self {
            Self::Nlm => Ok(Method::Nlm),
            Self::Oidn => oidn(),
        }
    }

    /// The method for a render, if its settings leave something to denoise.
    pub(super) fn for_render(self, settings: &Settings) -> Result<Method, CliError> {
        if matches!(settings.integrator, Integrator::Heat(_)) {
            return Err(invalid("the integrator heat counts, and counts are not denoised", "leave --denoise out"));
        }
        if self == Self::Nlm && settings.spp < MIN_SAMPLES {
            let problem = format!("--denoise nlm compares two halves of the samples, and --spp is {}", settings.spp);
            return Err(invalid(problem, format!("give --spp {MIN_SAMPLES} or more, better 8 or 16")));
        }
        self.method()
    }
}

#[cfg(feature = "oidn")]
fn oidn() -> Result<Method, CliError> {
    crate::denoise::Oidn::find().map(Method::Oidn).map_err(CliError::Input)
}

#[cfg(not(feature = "oidn"))]
fn oidn() -> Result<Method, CliError> {
    Err(invalid("this program was built without Open Image Denoise", "use nlm, or build with the feature `oidn`"))
}

/// Adds to a render's settings what denoising needs: AOVs of visible surfaces, and halves.
pub(super) fn prepare(settings: Settings) -> Settings {
    Settings { aov: true, aov_through: true, halves: true, ..settings }
}

/// The denoised picture; prints the method and the time. Runs on the threads of `pool`.
pub(super) fn denoise(
    method: &Method,
    picture: Picture,
    pool: &rayon::ThreadPool,
    style: Style,
) -> Result<Picture, DenoiseError> {
    let start = Instant::now();
    let progress = Progress::of_denoising(style, method.work(picture.width, picture.height));
    let denoised = pool.install(|| method.denoise(picture, &progress));
    drop(progress);
    let (picture, replaced) = denoised?;
    if replaced > 0 {
        let text =
            format!("{replaced} values of the noisy picture are infinite or not numbers, and were taken as black");
        super::messages::print_warning(style, &text);
    }
    print_text(style, &format!("denoised by {method} in {:.2} s", start.elapsed().as_secs_f64()));
    Ok(picture)
}
