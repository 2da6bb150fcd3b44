//! The radiance of a cube map: the sky alone, or the view from a point in a scene by path tracing.

use std::ops::Range;

use glam::{DVec3, Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{Pattern, Sampler};

use super::face::{Axes, Face};
use super::grid::TexelGrid;
use crate::estimator::mean_in_rounds;
use crate::integrator::{RayBatch, Wavefront, radiance_by_paths};
use crate::light::SkyLight;
use crate::scene::Sky;
use crate::settings::PathOptions;
use crate::world::{Hit, World};

/// The set of random numbers that places a ray in its texel.
const TEXEL_SET: u32 = 0;
/// Points of a texel across, at most, at which the sky is looked up.
const MAX_POINTS: u32 = 256;
/// Points of a texel across at which its solid angle is asked for.
const WEIGHTS: u32 = 8;
/// Paths for the mean radiance.
const MEAN_PATHS: u32 = 4096;
/// Keeps the numbers of these paths apart from those of texels.
const MEAN_NUMBER: u32 = u32::MAX;
/// Paths that are traced together, at most.
const BATCH: u32 = 4096;

/// The view in all directions.
pub struct Environment<'a>(Kind<'a>);

enum Kind<'a> {
    Sky { light: Box<SkyLight>, width: u32 },
    Point { world: &'a World, position: Vec3, paths: Paths, mean: f64, seed: u64 },
}

/// The number of paths of a texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paths {
    /// So many, at least 1.
    Count(u32),
    /// Until its standard error is this part of its radiance, or of the mean radiance around where that is more.
    Accuracy(f32),
}

/// The view in a texel.
pub(super) struct Seen {
    pub(super) radiance: Vec3,
    /// The square of its standard error, as a mean over the channels, if that is known.
    pub(super) variance: f64,
    /// Rays that it took.
    pub(super) rays: u64,
}

/// A viewer of a source, with its memory.
#[derive(Default)]
pub(super) struct Viewer {
    rays: Vec<Ray>,
    hits: Vec<Hit>,
    samplers: Vec<Sampler>,
    weights: Vec<f64>,
    radiance: Vec<Vec3>,
    wave: Wavefront,
}

impl<'a> Environment<'a> {
    /// The sky. Its sun, which daylight has besides, is a delta light and is not seen.
    pub fn sky(sky: Sky) -> Environment<'static> {
        let width = sky.picture.as_ref().map_or(0, |picture| picture.width);
        Environment(Kind::Sky { light: Box::new(SkyLight::new(sky)), width })
    }

    /// A point in a scene.
    pub fn point(world: &'a World, position: Vec3, paths: Paths, seed: u64) -> Self {
        let mean = match paths {
            Paths::Count(_) => 0.0,
            Paths::Accuracy(_) => mean_radiance(world, position, seed),
        };
        Self(Kind::Point { world, position, paths, mean, seed })
    }

    /// Mean radiance in a texel. `number` is the texel's.
    pub(super) fn texel(
        &self,
        viewer: &mut Viewer,
        (grid, axes): (&TexelGrid, Axes),
        number: u32,
        (face, x, y): (Face, u32, u32),
    ) -> Seen {
        let border = |place: u32| grid.place(f64::from(place));
        let (left, right, top, bottom) = (border(x), border(x + 1), border(y), border(y + 1));
        // A point of the texel, and the solid angle of its surroundings over their area.
        let aim = |u: f64, v: f64| {
            let point = face.point(left + (right - left) * u, top + (bottom - top) * v);
            (axes.swap(point).normalize().as_vec3(), point.length_squared().powf(-1.5))
        };
        match &self.0 {
            Kind::Sky { light, width } => {
                // Two points for each texel of the picture around the horizon; constant skies need no more than one.
                let points = (width.div_ceil(2 * grid.size)).clamp(u32::from(*width > 0) + 1, MAX_POINTS);
                let place = |i: u32| (f64::from(i) + 0.5) / f64::from(points);
                let all = (0..points).flat_map(|j| (0..points).map(move |i| (i, j)));
                let seen = all.map(|(i, j)| aim(place(i), place(j)));
                let mut mean = Mean::default();
                mean.extend(seen.map(|(direction, weight)| (light.radiance(&light.view(direction)), weight)));
                Seen { radiance: mean.value(), variance: 0.0, rays: 0 }
            }
            Kind::Point { world, position, paths, mean, seed } => {
                let mut rays = 0;
                let mut look = |seed, samples| {
                    let (seen, traced) = viewer.look(world, *position, (seed, number), samples, aim);
                    rays += traced;
                    seen
                };
                match *paths {
                    Paths::Count(spp) => Seen { radiance: look(*seed, 0..spp).value(), variance: 0.0, rays },
                    Paths::Accuracy(part) => {
                        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(WEIGHTS);
                        let all = (0..WEIGHTS).flat_map(|j| (0..WEIGHTS).map(move |i| (i, j)));
                        let weight =
                            all.map(|(i, j)| aim(place(i), place(j)).1).sum::<f64>() / f64::from(WEIGHTS * WEIGHTS);
                        let tolerance = |seen: DVec3| f64::from(part) * mean.max(seen.element_sum() / 3.0);
                        let found = mean_in_rounds(*seed, tolerance, |seed, samples| look(seed, samples).sum / weight);
                        Seen { radiance: found.mean.as_vec3(), variance: found.variance, rays }
                    }
                }
            }
        }
    }

    /// Samples of a texel that it reports to a watcher.
    pub(super) fn samples(&self) -> u64 {
        match self.0 {
            Kind::Sky { .. } => 1,
            Kind::Point { paths: Paths::Count(spp), .. } => spp.into(),
            Kind::Point { paths: Paths::Accuracy(_), .. } => 1,
        }
    }
}

/// The mean radiance around a point, about, over all channels.
fn mean_radiance(world: &World, position: Vec3, seed: u64) -> f64 {
    let aim = |u: f64, v: f64| {
        let (height, turn) = (2.0 * u - 1.0, std::f64::consts::TAU * v);
        let radius = (1.0 - height * height).max(0.0).sqrt();
        (DVec3::new(radius * turn.cos(), radius * turn.sin(), height).as_vec3(), 1.0)
    };
    let (mean, _) = Viewer::default().look(world, position, (seed, MEAN_NUMBER), 0..MEAN_PATHS, aim);
    f64::from(mean.value().element_sum()) / 3.0
}

impl Viewer {
    /// The mean of the paths of these indices from a point, towards random points of what `aim` maps the unit square
    /// to, and the number of rays.
    fn look(
        &mut self,
        world: &World,
        position: Vec3,
        (seed, number): (u64, u32),
        samples: Range<u32>,
        aim: impl Fn(f64, f64) -> (Vec3, f64),
    ) -> (Mean, u64) {
        let (mut mean, mut traced) = (Mean::default(), 0);
        for first in samples.clone().step_by(BATCH as usize) {
            self.rays.clear();
            self.weights.clear();
            self.samplers.clear();
            let some = first..samples.end.min(first.saturating_add(BATCH));
            self.samplers.extend(some.map(|sample| Sampler::new(Pattern::Sobol, seed, number, sample)));
            for sampler in &self.samplers {
                let Vec2 { x, y } = sampler.uniform2(TEXEL_SET);
                let (direction, weight) = aim(x.into(), y.into());
                self.rays.push(Ray::new(position, direction));
                self.weights.push(weight);
            }
            self.hits.resize(self.rays.len(), Hit::MISS);
            self.radiance.resize(self.rays.len(), Vec3::ZERO);
            world.intersect_many(&self.rays, &mut self.hits);
            let batch = RayBatch {
                rays: &self.rays,
                hits: &self.hits,
                samplers: &self.samplers,
                times: &[],
                first_set: TEXEL_SET + 1,
                density: f32::INFINITY,
            };
            let options = PathOptions::default();
            traced += radiance_by_paths(world, &options, &batch, &mut self.wave, &mut self.radiance);
            traced += self.rays.len() as u64;
            let finite = self.radiance.iter().map(|seen| if seen.is_finite() { *seen } else { Vec3::ZERO });
            mean.extend(finite.zip(self.weights.iter().copied()));
        }
        (mean, traced)
    }
}

/// A weighted mean.
#[derive(Default)]
struct Mean {
    sum: DVec3,
    weights: f64,
}

impl Mean {
    fn value(&self) -> Vec3 {
        (self.sum / self.weights).as_vec3()
    }
}

impl Extend<(Vec3, f64)> for Mean {
    fn extend<I: IntoIterator<Item = (Vec3, f64)>>(&mut self, values: I) {
        for (value, weight) in values {
            self.sum += value.as_dvec3() * weight;
            self.weights += weight;
        }
    }
}
