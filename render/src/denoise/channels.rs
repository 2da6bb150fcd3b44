//! A denoiser's input channels, found by name in a picture.

use super::DenoiseError;
use crate::film::{COLORS, Picture};

/// Three planes.
pub(super) type Rgb = [Vec<f32>; 3];

/// The channels of a picture that denoisers read. All values are finite.
#[derive(Clone, Debug)]
pub(super) struct Channels {
    pub(super) width: u32,
    pub(super) height: u32,
    /// `Noisy` if there is, else `R`, `G`, `B`.
    pub(super) color: Rgb,
    /// `HalfA` and `HalfB`.
    pub(super) halves: Option<[Rgb; 2]>,
    /// `Variance`.
    pub(super) variance: Option<Rgb>,
    /// `Albedo`.
    pub(super) albedo: Option<Rgb>,
    /// `Ns`, or else `N`.
    pub(super) normal: Option<Rgb>,
    /// `P`.
    pub(super) position: Option<Rgb>,
    /// Colours that were not numbers, and are black.
    pub(super) replaced: usize,
}

impl Channels {
    pub(super) fn of(picture: &Picture) -> Result<Self, DenoiseError> {
        let expected = picture.width as usize * picture.height as usize;
        if expected == 0 || picture.channels.iter().any(|channel| channel.values.len() != expected) {
            return Err(DenoiseError::Shape);
        }
        let three = |names: [&str; 3]| -> Option<Rgb> {
            let [a, b, c] = names.map(|name| picture.channel(name).map(|channel| channel.values.clone()));
            Some([a?, b?, c?])
        };
        let group = |name: &str, ends: [&str; 3]| {
            let names = ends.map(|end| format!("{name}.{end}"));
            three(names.each_ref().map(String::as_str))
        };
        const AXES: [&str; 3] = ["X", "Y", "Z"];
        let color = group("Noisy", COLORS).or_else(|| three(COLORS)).ok_or_else(|| DenoiseError::Missing {
            channels: vec!["R", "G", "B"],
            remedy: "give a picture with colours",
        })?;
        let halves = group("HalfA", COLORS).zip(group("HalfB", COLORS)).map(|(a, b)| [a, b]);
        let mut channels = Self {
            width: picture.width,
            height: picture.height,
            color,
            halves,
            variance: group("Variance", COLORS),
            albedo: group("Albedo", COLORS),
            normal: group("Ns", AXES).or_else(|| group("N", AXES)),
            position: group("P", AXES),
            replaced: 0,
        };
        channels.replace();
        Ok(channels)
    }

    /// Makes black what is not a number or infinite.
    fn replace(&mut self) {
        let mut replaced = 0;
        let guides = [&mut self.variance, &mut self.albedo, &mut self.normal, &mut self.position];
        let halves = self.halves.iter_mut().flatten();
        for plane in guides.into_iter().flatten().chain(halves).flatten() {
            plane.iter_mut().filter(|value| !value.is_finite()).for_each(|value| *value = 0.0);
        }
        for value in self.color.iter_mut().flatten().filter(|value| !value.is_finite()) {
            *value = 0.0;
            replaced += 1;
        }
        self.replaced = replaced;
    }
}
