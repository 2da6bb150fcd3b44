//! The sky as a light.
//!
//! A constant sky is sampled by the cosine, a picture, whose [texels](texels) are interpolated, by its brightness (see [`Peaks`]).
//! From within rooms both are sampled through [`Openings`] besides.
//!
//! Cosine-distributed rays find the sky well, but a picture's sun only by chance. So the part of the sky that light
//! samples cover depends on the other techniques (see [`SkyPart`]): MIS compensation (Karlík et al. 2019) leaves to
//! bounces the part that they find well, and gathers see a picture without its *sun*, the part of texels above a few
//! times the mean, which is sampled like a lamp.

mod openings;
mod peaks;
mod sun;
mod texels;

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::Frame;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Warp};

pub(crate) use self::openings::Openings;
use self::peaks::Peaks;
use self::sun::PictureSun;
use self::texels::{Around, SkyTexels, TexelPlaces};
use super::distant::Patches;
use super::{Receiver, luminance_weight};
use crate::scene::{PunctualLight, Sky, SkyPicture};

/// The part of the sky for light samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SkyPart {
    /// All of it.
    All,
    /// The part that cosine-distributed bounces find less well: the excess over the mean. Bounces see the whole sky,
    /// and MIS weights apply.
    Bright,
    /// The part that gathers would rarely find: mainly the sun. Gathers do not see it.
    Sun,
}

/// A texel above this multiple of the mean counts as a part of the sun. A clear sky without its sun is below that.
const SUN: f64 = 8.0;
/// A constant sky that would weigh less than this part of its irradiance is left to bounces.
const LEAST_OPEN: f32 = 0.005;

/// The sky, ready to be sampled.
#[derive(Debug)]
pub(crate) struct SkyLight {
    constant: Vec3,
    mean: Vec3,
    picture: Option<SkyTexels>,
    /// The unoccluded fraction of each part, a factor on its weight.
    visibility: [f32; 3],
    /// Each part of a picture, with its patches.
    parts: Box<[Option<(Peaks, Patches)>; 3]>,
    /// Where it is seen from within rooms.
    openings: Option<Openings>,
    /// The sun of a picture that has one.
    sun: Option<PictureSun>,
}

/// A direction, with what a picture has there.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SkyView {
    /// Unit vector.
    direction: Vec3,
    around: Around,
}

/// Where to look for the sky.
pub(crate) struct SkySample {
    /// Unit vector.
    pub direction: Vec3,
    pub radiance: Vec3,
    /// Per solid angle.
    pub density: f32,
    /// The radiance of the [sun](SkyLight::sun) in it.
    pub of_sun: Vec3,
}

impl SkyLight {
    pub(crate) fn new(sky: Sky) -> Self {
        let mean = sky.mean();
        let Sky { radiance: constant, picture } = sky;
        let picture = picture.map(|mut picture| {
            picture.texels.iter_mut().for_each(|texel| *texel += constant);
            SkyTexels::new(picture)
        });
        let mut light =
            Self { constant, mean, picture, visibility: [1.0; 3], parts: Box::default(), openings: None, sun: None };
        light.forget_visibility();
        if let Some(picture) = light.picture.take_if(|_| mean != Vec3::ZERO) {
            // A sun may be most of the mean, so that the second time counts.
            let mean = clipped_mean(picture.picture(), f64::INFINITY);
            let limits = [0.0, mean, SUN * clipped_mean(picture.picture(), SUN * mean)];
            light.parts = Box::new(limits.map(|limit| {
                let peaks = Peaks::of(picture.picture(), limit)?;
                let patches = peaks.patches(&picture);
                Some((peaks, patches))
            }));
            light.sun = light.part(SkyPart::Sun).and_then(|(peaks, _)| PictureSun::of(&picture, peaks));
            light.picture = Some(picture);
        }
        light
    }

    fn part(&self, part: SkyPart) -> Option<&(Peaks, Patches)> {
        self.parts[part as usize].as_ref()
    }

    /// Knows of nothing that is in between.
    pub(crate) fn forget_visibility(&mut self) {
        self.openings = None;
        self.visibility = if self.picture.is_some() { [1.0; 3] } else { [1.0, 0.0, 0.0] };
    }

    /// Takes estimates of the part of the scene that each part of the sky reaches; `open` is the part of scattered rays that
    /// see the sky.
    pub(crate) fn set_visibility(&mut self, parts: [f32; 3], open: f32) {
        self.visibility = match self.picture {
            Some(_) => parts,
            None => {
                // Bounces follow the cosine as light samples would. Where most of them find the sky that is enough; where few do,
                // as in a room with a window, each one more counts.
                let bright = open * (1.0 - open).powi(4);
                [parts[0], if bright > LEAST_OPEN { bright } else { 0.0 }, 0.0]
            }
        };
    }

    /// Takes the openings through which surfaces see the sky. Where it is constant no other light samples look for it.
    pub(crate) fn set_openings(&mut self, openings: Openings) {
        if self.picture.is_none() {
            self.visibility[SkyPart::Bright as usize] = 0.0;
        }
        self.openings = Some(openings);
    }

    /// The openings through which surfaces see the sky, if they are few.
    #[inline(always)]
    pub(crate) fn openings(&self) -> Option<&Openings> {
        self.openings.as_ref()
    }

    /// The view in the direction of a unit vector.
    #[inline]
    pub(crate) fn view(&self, direction: Vec3) -> SkyView {
        let around = self.picture.as_ref().map(|picture| picture.around(direction)).unwrap_or_default();
        SkyView { direction, around }
    }

    /// The views in many directions. Texels of a large picture are far away in memory, and so all are asked for before any is
    /// needed.
    #[inline(always)]
    pub(crate) fn views<const N: usize>(&self, directions: &[Vec3; N]) -> [SkyView; N] {
        let mut views = [SkyView::default(); N];
        let mut places = [TexelPlaces::default(); N];
        if let Some(picture) = &self.picture {
            for (places, direction) in places.iter_mut().zip(directions) {
                *places = picture.places(*direction);
            }
            for (view, places) in views.iter_mut().zip(&places) {
                view.around = picture.fetch(places);
            }
        }
        for (view, direction) in views.iter_mut().zip(directions) {
            view.direction = *direction;
        }
        views
    }

    /// Radiance of a view.
    pub(crate) fn radiance(&self, view: &SkyView) -> Vec3 {
        if self.picture.is_some() { view.around.mean(|texel| texel) } else { self.constant }
    }

    /// Radiance of a view without the sun.
    pub(crate) fn ambient(&self, view: &SkyView) -> Vec3 {
        match self.part(SkyPart::Sun) {
            Some((sun, _)) => view.around.mean(|texel| sun.split(texel).0),
            None => self.radiance(view),
        }
    }

    /// The sun of a picture, as a light that glass refracts and mirrors show to surfaces.
    pub(crate) fn sun(&self) -> Option<&PunctualLight> {
        self.sun.as_ref().map(|sun| &sun.light)
    }

    /// Lets paths alone find the sun there: nothing refracts or mirrors it.
    pub(crate) fn forget_sun(&mut self) {
        self.sun = None;
    }

    /// Radiance of a view without the sun that [`sun`](Self::sun) stands for.
    pub(crate) fn beside_sun(&self, view: &SkyView) -> Vec3 {
        match &self.sun {
            Some(sun) if sun.contains(view.direction) => self.ambient(view),
            _ => self.radiance(view),
        }
    }

    /// A point of that sun as a directional light without a size, whose mean is the sun; `None` where the numbers in [0, 1)
    /// mean another bright part of the sky.
    pub(crate) fn point_of_sun(&self, u: Vec2) -> Option<PunctualLight> {
        let (sun, (peaks, _), picture) = (self.sun.as_ref()?, self.part(SkyPart::Sun)?, self.picture.as_ref()?);
        let direction = peaks.sample(picture, u);
        let around = picture.around(direction);
        let irradiance = around.mean(|texel| peaks.split(texel).1) / peaks.density(&around);
        let light = PunctualLight::Directional { direction: -direction, irradiance, half_angle: 0.0 };
        (sun.contains(direction) && irradiance.is_finite()).then_some(light)
    }

    /// Mean radiance of all directions.
    pub(crate) fn mean(&self) -> Vec3 {
        self.mean
    }

    /// Whether light samples are to find any of this part.
    pub(crate) fn has(&self, part: SkyPart) -> bool {
        match self.picture {
            Some(_) => self.part(part).is_some(),
            None => self.visibility[part as usize] > 0.0 && self.mean != Vec3::ZERO,
        }
    }

    /// An estimate of the irradiance by this part of the sky if nothing is in between, as luminance.
    #[inline(always)]
    pub(crate) fn weight(&self, receiver: &Receiver, part: SkyPart) -> f32 {
        if !self.has(part) {
            return 0.0;
        }
        let visibility = self.visibility[part as usize];
        match self.part(part) {
            Some((_, patches)) => patches.rows(receiver).map(|row| super::tree::sum(&row)).sum::<f32>() * visibility,
            None => luminance_weight(self.constant) * PI * (1.0 + receiver.behind) * visibility,
        }
    }

    /// A sampled direction of light from this part; with [`SkyPart::Sun`] only the sun counts.
    pub(crate) fn sample(&self, receiver: &Receiver, part: SkyPart, u: Vec2) -> SkySample {
        let direction = match (self.part(part), &self.picture) {
            (Some((peaks, _)), Some(picture)) => peaks.sample(picture, u),
            _ => cosine(receiver, u),
        };
        let view = self.view(direction);
        match part {
            SkyPart::Sun => self.look(receiver, part, &view, |sun, texel| sun.split(texel).1),
            _ => self.seen(receiver, part, &view),
        }
    }

    /// What [`sample`](Self::sample) finds if it gives the direction of a view; the whole sky counts.
    #[inline]
    pub(crate) fn seen(&self, receiver: &Receiver, part: SkyPart, view: &SkyView) -> SkySample {
        self.look(receiver, part, view, |_, texel| texel)
    }

    /// The density of a view, and its radiance, of which so much counts of each texel of a picture.
    #[inline(always)]
    fn look(
        &self,
        receiver: &Receiver,
        part: SkyPart,
        view: &SkyView,
        counted: impl Fn(&Peaks, Vec3) -> Vec3,
    ) -> SkySample {
        let SkyView { direction, around } = view;
        let direction = *direction;
        if let Some((peaks, _)) = self.part(part) {
            let radiance = around.mean(|texel| counted(peaks, texel));
            let of_sun = match (&self.sun, self.part(SkyPart::Sun)) {
                (Some(sun), Some((peaks, _))) if sun.contains(direction) => around.mean(|texel| peaks.split(texel).1),
                _ => Vec3::ZERO,
            };
            return SkySample { direction, radiance, density: peaks.density(around), of_sun };
        }
        let cosine = receiver.normal.dot(direction);
        let all = if receiver.behind > 0.0 { 0.5 * cosine.abs() } else { cosine.max(0.0) };
        let density = if self.has(part) { all * FRAC_1_PI } else { 0.0 };
        SkySample { direction, radiance: self.radiance(view), density, of_sun: Vec3::ZERO }
    }
}

/// A direction that follows the cosine, on either side if light counts on both.
fn cosine(receiver: &Receiver, mut u: Vec2) -> Vec3 {
    let mut side = 1.0;
    if receiver.behind > 0.0 {
        side = if u.x < 0.5 { 1.0 } else { -1.0 };
        u.x = (2.0 * u.x).fract();
    }
    Frame::from_normal(receiver.normal * side).to_world(CosineHemisphere.map(u))
}

/// The mean brightness of all directions, clamped to the limit.
fn clipped_mean(picture: &SkyPicture, limit: f64) -> f64 {
    let rows = (0..).zip(picture.texels.chunks_exact(picture.width as usize));
    let row = |(row, texels): (u32, &[Vec3])| -> f64 {
        texels.iter().map(|texel| f64::from(luminance_weight(*texel)).min(limit)).sum::<f64>()
            * picture.solid_angle(row)
    };
    rows.map(row).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

#[cfg(test)]
mod tests;
