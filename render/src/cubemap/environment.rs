//! Where a cube map's light comes from: the sky alone, or a point in a scene, where it is found by path tracing.

use glam::{DVec3, Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::{Pattern, Sampler};

use super::face::{Axes, Face};
use super::grid::TexelGrid;
use crate::integrator::{RayBatch, Wavefront, radiance_by_paths};
use crate::light::SkyLight;
use crate::scene::Sky;
use crate::settings::PathOptions;
use crate::world::{Hit, World};

/// The set of random numbers that places a ray in its texel.
const TEXEL_SET: u32 = 0;
/// Points of a texel across, at most, at which the sky is looked up.
const MAX_POINTS: u32 = 256;
/// Paths that are traced together, at most.
const BATCH: u32 = 4096;

/// What is seen in all directions.
pub struct Environment<'a>(Kind<'a>);

enum Kind<'a> {
    Sky { light: Box<SkyLight>, width: u32 },
    Point { world: &'a World, position: Vec3, spp: u32, seed: u64 },
}

/// What looks at a source, and its memory.
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

    /// A point in a scene, with `spp` paths for each texel, at least 1.
    pub fn point(world: &'a World, position: Vec3, spp: u32, seed: u64) -> Self {
        Self(Kind::Point { world, position, spp, seed })
    }

    /// Mean radiance in a texel, and the number of rays. `number` is the texel's.
    pub(super) fn texel(
        &self,
        viewer: &mut Viewer,
        (grid, axes): (&TexelGrid, Axes),
        number: u32,
        (face, x, y): (Face, u32, u32),
    ) -> (Vec3, u64) {
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
                mean.extend(seen.map(|(direction, weight)| (light.radiance(direction), weight)));
                (mean.value(), 0)
            }
            Kind::Point { world, position, spp, seed } => viewer.look(world, *position, (*seed, number), *spp, aim),
        }
    }

    /// Samples of a texel.
    pub(super) fn samples(&self) -> u64 {
        match self.0 {
            Kind::Sky { .. } => 1,
            Kind::Point { spp, .. } => spp.into(),
        }
    }
}

impl Viewer {
    /// The mean of `spp` paths from a point, towards random points of what `aim` maps the unit square to.
    fn look(
        &mut self,
        world: &World,
        position: Vec3,
        (seed, number): (u64, u32),
        spp: u32,
        aim: impl Fn(f64, f64) -> (Vec3, f64),
    ) -> (Vec3, u64) {
        let (mut mean, mut traced) = (Mean::default(), 0);
        for first in (0..spp).step_by(BATCH as usize) {
            self.rays.clear();
            self.weights.clear();
            self.samplers.clear();
            let samples = first..spp.min(first.saturating_add(BATCH));
            self.samplers.extend(samples.map(|sample| Sampler::new(Pattern::Sobol, seed, number, sample)));
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
        (mean.value(), traced)
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
