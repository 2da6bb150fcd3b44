//! Denoising of rendered pictures, guided by AOVs of the surfaces.
//!
//! Two methods: the built-in [`Method::Nlm`], and with the feature `oidn` `Method::Oidn`, by Intel's Open Image
//! Denoise. They read a picture's channels by name and put the result into `R`, `G` and `B`; the noisy colours stay as
//! `Noisy.R`, `G` and `B`, from which a picture can be denoised again.

mod channels;
mod nlm;
#[cfg(feature = "oidn")]
mod oidn;

use std::fmt;

use self::channels::{Channels, Rgb};
use crate::film::{COLORS, Channel, Picture};
use crate::watch::Watch;

#[cfg(feature = "oidn")]
pub use self::oidn::Oidn;

/// Options of denoising.
#[derive(Clone)]
pub enum Method {
    /// Regression on features with weights of non-local means. Needs halves.
    Nlm,
    /// Open Image Denoise.
    #[cfg(feature = "oidn")]
    Oidn(Oidn),
}

/// Why there is no result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DenoiseError {
    /// Channels that the method needs.
    #[error("lacks the channels {}\n  help: {remedy}", .channels.join(", "))]
    Missing {
        /// Their names.
        channels: Vec<&'static str>,
        /// How to make them.
        remedy: &'static str,
    },
    /// A half without samples.
    #[error("one half of its samples is empty, so nothing tells noise from detail\n  help: {0}")]
    EmptyHalf(&'static str),
    /// There are no pixels, or not as many in a channel as in the picture.
    #[error("has channels that do not fit its size")]
    Shape,
    /// Whoever watched has stopped it.
    #[error("stopped")]
    Stopped,
    /// The error of Open Image Denoise.
    #[error("{0}")]
    Failed(String),
}

/// The least number of samples a pixel with which no half is empty.
pub const MIN_SAMPLES: u32 = 5;

impl Method {
    /// Its name as an option.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Nlm => "nlm",
            #[cfg(feature = "oidn")]
            Self::Oidn(_) => "oidn",
        }
    }

    /// How much there is to [`watch`](Watch::advance) of a picture of this size.
    pub fn work(&self, width: u32, height: u32) -> u64 {
        match self {
            Self::Nlm => nlm::work(width, height),
            #[cfg(feature = "oidn")]
            Self::Oidn(_) => oidn::WORK,
        }
    }

    /// An estimate of the bytes that denoising takes, beyond the picture's own channels.
    pub fn bytes(&self, width: u32, height: u32) -> u64 {
        let pixel = CHANNEL_BYTES
            + match self {
                Self::Nlm => nlm::BYTES_PER_PIXEL,
                #[cfg(feature = "oidn")]
                Self::Oidn(_) => oidn::BYTES_PER_PIXEL,
            };
        u64::from(width) * u64::from(height) * pixel
    }

    /// Checks that `picture` has what the method needs; gives warnings about what would help.
    ///
    /// # Errors
    /// If it lacks channels.
    pub fn check(&self, picture: &Picture) -> Result<Vec<String>, DenoiseError> {
        let has = |names: &[&str]| names.iter().all(|name| picture.channel(name).is_some());
        if !has(&COLORS) && !has(&NOISY) {
            return Err(DenoiseError::Missing { channels: COLORS.to_vec(), remedy: "give a picture with colours" });
        }
        let guides = [("Albedo", ["Albedo.R", "Albedo.G", "Albedo.B"]), ("Ns", ["Ns.X", "Ns.Y", "Ns.Z"])];
        let lacks: Vec<&str> = guides.iter().filter(|(_, names)| !has(names)).map(|(name, _)| *name).collect();
        if matches!(self, Self::Nlm) {
            let missing: Vec<&str> = HALVES.into_iter().filter(|name| picture.channel(name).is_none()).collect();
            if !missing.is_empty() {
                let remedy = "render with --aov, which writes them, or use oidn, which needs colours alone";
                return Err(DenoiseError::Missing { channels: missing, remedy });
            }
            let samples = picture.metadata.samples_per_pixel;
            let is_black = |names: &[&str]| {
                let values = names.iter().filter_map(|name| picture.channel(name)).flat_map(|channel| &channel.values);
                values.into_iter().all(|&value| value == 0.0)
            };
            let is_empty = |half: &[&str]| is_black(half) && !is_black(&COLORS);
            if (1..MIN_SAMPLES).contains(&samples) || is_empty(&HALVES[..3]) || is_empty(&HALVES[3..]) {
                return Err(DenoiseError::EmptyHalf("take at least 5 samples a pixel (--spp), better 8 or 16"));
            }
        }
        Ok(match lacks.as_slice() {
            [] => Vec::new(),
            lacks => vec![format!(
                "the picture has no channels {}: edges and textures are kept better with them (render with --aov)",
                lacks.join(" and ")
            )],
        })
    }

    /// The picture with `R`, `G` and `B` denoised, and the noisy ones as `Noisy.R`, `Noisy.G` and `Noisy.B`; other
    /// channels stay as they are. Works on the threads of the current rayon pool. Gives how many values of colours were
    /// not numbers besides, which count as black.
    ///
    /// # Errors
    /// The errors of [`check`](Self::check), if `watch` stops it, or Open Image Denoise fails.
    pub fn denoise(&self, picture: Picture, watch: &dyn Watch) -> Result<(Picture, usize), DenoiseError> {
        self.check(&picture)?;
        let channels = Channels::of(&picture)?;
        let denoised = match self {
            Self::Nlm => nlm::denoise(&channels, watch)?,
            #[cfg(feature = "oidn")]
            Self::Oidn(oidn) => oidn.denoise(&channels, watch)?,
        };
        let replaced = channels.replaced;
        Ok((with_colors(picture, denoised), replaced))
    }
}

/// Bytes of a pixel in [`Channels`].
const CHANNEL_BYTES: u64 = 4 * (3 + 6 + 3 + 9);

const NOISY: [&str; 3] = ["Noisy.R", "Noisy.G", "Noisy.B"];
const HALVES: [&str; 6] = ["HalfA.R", "HalfA.G", "HalfA.B", "HalfB.R", "HalfB.G", "HalfB.B"];

/// The picture with these colours; those that it has become its noisy ones, unless it has such.
fn with_colors(mut picture: Picture, colors: Rgb) -> Picture {
    for ((name, noisy), values) in COLORS.into_iter().zip(NOISY).zip(colors) {
        let old = match picture.channels.iter_mut().find(|channel| channel.name == name) {
            Some(channel) => std::mem::replace(&mut channel.values, values),
            None => {
                picture.channels.push(Channel { name: name.to_owned(), values });
                continue;
            }
        };
        if picture.channel(noisy).is_none() {
            picture.channels.push(Channel { name: noisy.to_owned(), values: old });
        }
    }
    picture
}

impl fmt::Debug for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl fmt::Display for Method {
    /// What does it, for messages: with Open Image Denoise its version and where it is.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nlm => f.write_str("nlm"),
            #[cfg(feature = "oidn")]
            Self::Oidn(oidn) => oidn.fmt(f),
        }
    }
}
