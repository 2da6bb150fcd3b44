//! Shadow rays of many light samples at once, for texels, probes and sensors: in loops that are compiled for each
//! instruction set, with lights chosen step by step together, as a step depends on the sample's previous one alone.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::{Sampler, unit_double};
use halfdome_kernel::{Ray, Task};

use super::direct::sample_direct_from;
use crate::light::{LightChoice, Receiver, SkyPart, Weights};
use crate::settings::LightSampling;
use crate::world::{Surface, World};

/// The set of random numbers that chooses the light and a point on it.
const LIGHT_SET: u32 = 0;
/// The set that says at which of the surfaces.
const PLACE_SET: u32 = 2;

/// The shadow rays, and the memory of their choices.
#[derive(Default)]
pub(crate) struct LightRays {
    shadows: Vec<Ray>,
    /// Unit vectors to what they are sent to.
    directions: Vec<Vec3>,
    /// The irradiance that each causes if nothing is in between.
    irradiance: Vec<Vec3>,
    occluded: Vec<bool>,
    /// Those surfaces as receivers, with the weights of lights there, at which a sample was taken.
    receivers: Vec<Option<(Receiver, Weights)>>,
    samples: Vec<LightRaySample>,
    /// The numbers of samples whose lights are not chosen yet.
    choosing: Vec<u32>,
}

/// A sample on its way to a light.
struct LightRaySample {
    /// The number of its surface.
    place: usize,
    receiver: Receiver,
    choice: LightChoice,
    numbers: (f64, f32),
}

impl LightRays {
    /// Traces a light sample for each sampler, at its [place](place_of) among the surfaces, and passes on the unit vectors to
    /// the lights that are seen and the irradiance by them; gives the number of rays.
    pub(crate) fn trace(
        &mut self,
        world: &World,
        surfaces: &[Surface],
        how: (LightSampling, SkyPart),
        samplers: &[Sampler],
        mut found: impl FnMut(Vec3, Vec3),
    ) -> u64 {
        world.isa().run(MakeRays { world, surfaces, how, samplers, rays: self });
        self.occluded.resize(self.shadows.len(), false);
        world.occluded_many(&self.shadows, &mut self.occluded);
        for ((direction, irradiance), occluded) in self.directions.iter().zip(&self.irradiance).zip(&self.occluded) {
            if !occluded {
                found(*direction, *irradiance);
            }
        }
        self.shadows.len() as u64
    }

    /// Begins to choose lights, which are weighed once at each surface.
    #[inline(always)]
    fn begin(&mut self, world: &World, surfaces: &[Surface], part: SkyPart, samplers: &[Sampler]) {
        self.samples.clear();
        self.receivers.clear();
        self.receivers.resize_with(surfaces.len(), || None);
        for sampler in samplers {
            let place = place_of(sampler, surfaces.len());
            let [x, y, finer, _] = sampler.uniform4(LIGHT_SET);
            let numbers = (unit_double(Vec2::new(x, finer)), y);
            let known = &mut self.receivers[place];
            if known.is_none() {
                let receiver = surfaces[place].receiver();
                *known = Some((receiver, world.lights.weigh(&receiver, part)));
            }
            let Some((receiver, weights)) = known else { continue };
            let choice = world.lights.begin(receiver, weights, numbers.0);
            self.samples.push(LightRaySample { place, receiver: *receiver, choice, numbers });
        }
    }

    /// Chooses the lights of all samples, step by step.
    #[inline(always)]
    fn choose(&mut self, world: &World) {
        let Self { samples, choosing, .. } = self;
        choosing.clear();
        choosing.extend(0..samples.len() as u32);
        let mut count = choosing.len();
        while count > 0 {
            let mut left = 0;
            // A closure for `retain` would not be compiled for the instruction set.
            for k in 0..count {
                let number = choosing[k];
                choosing[left] = number;
                let sample = &mut samples[number as usize];
                left += usize::from(world.lights.descend(&sample.receiver, &mut sample.choice));
            }
            count = left;
        }
    }

    /// Makes the rays to the chosen lights.
    #[inline(always)]
    fn aim(&mut self, world: &World, surfaces: &[Surface], how: (LightSampling, SkyPart)) {
        self.shadows.clear();
        self.directions.clear();
        self.irradiance.clear();
        for LightRaySample { place, choice, numbers, .. } in &self.samples {
            let (surface, light) = (&surfaces[*place], world.lights.end(choice));
            let white = surface.white();
            for light in sample_direct_from(world, surface, |towards| white.eval(towards), how, (light, *numbers)) {
                self.shadows.push(light.ray);
                self.directions.push(light.direction);
                self.irradiance.push(light.radiance * PI);
            }
        }
    }
}

/// The number of the surface, of so many, at which a sampler's sample is taken.
#[inline(always)]
pub(super) fn place_of(sampler: &Sampler, surfaces: usize) -> usize {
    if surfaces == 1 {
        return 0;
    }
    let place = sampler.uniform2(PLACE_SET).x * surfaces as f32;
    (place as usize).min(surfaces - 1)
}

/// The rays of samples, as a task that is compiled for each instruction set.
struct MakeRays<'a> {
    world: &'a World,
    surfaces: &'a [Surface<'a>],
    how: (LightSampling, SkyPart),
    samplers: &'a [Sampler],
    rays: &'a mut LightRays,
}

impl Task for MakeRays<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { world, surfaces, how, samplers, rays } = self;
        rays.begin(world, surfaces, how.1, samplers);
        rays.choose(world);
        rays.aim(world, surfaces, how);
    }
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;
    use crate::estimator::sample_direct;
    use crate::fixtures::{ball, square, sun};
    use crate::scene::{CameraPose, Material, Mesh, PunctualLight, Scene};
    use halfdome_kernel::sampling::Pattern;

    /// Lights chosen step by step, in loops for the instruction set, are those that are chosen one by one, bit for bit.
    #[test]
    fn samples_of_many_are_those_of_one_after_the_other() {
        let glowing = Material { emission: vec3(3.0, 2.0, 1.0), ..Material::matte(Vec3::ZERO) };
        let point = |x| PunctualLight::Point { position: vec3(x, 4.0, 1.0), intensity: Vec3::splat(5.0), radius: 0.1 };
        let scene = Scene {
            meshes: vec![square(-2.0, true, 0), Mesh { material: 1, ..ball([12, 16]) }],
            materials: vec![Material::matte(Vec3::ONE), glowing],
            lights: (0..40).map(|i| point(i as f32 * 0.1)).chain([sun(Vec3::Z)]).collect(),
            camera: Some(CameraPose { eye: Vec3::Y, target: Vec3::ZERO, up: Vec3::Z, vfov: 60.0 }),
            ..Scene::default()
        };
        let world = World::new(scene).unwrap();
        let mut rays = LightRays::default();
        for count in [1, 3] {
            let places = [[0.2, 0.3], [0.4, 0.1], [0.1, 0.8]];
            let surfaces: Vec<Surface> = places[..count].iter().map(|place| world.receiver(0, *place)).collect();
            let samplers: Vec<Sampler> = (0..500).map(|i| Sampler::new(Pattern::Sobol, 3, 7, i)).collect();
            for how in [(LightSampling::Mis, SkyPart::Sun), (LightSampling::Direct, SkyPart::Sun)] {
                let mut found = Vec::new();
                let traced = rays.trace(&world, &surfaces, how, &samplers, |direction, irradiance| {
                    found.push((direction, irradiance));
                });
                let (mut expected, mut expected_rays, mut used) = (Vec::new(), 0, [0_usize; 3]);
                for sampler in &samplers {
                    let place = place_of(sampler, count);
                    used[place] += 1;
                    let [x, y, finer, _] = sampler.uniform4(LIGHT_SET);
                    let (surface, numbers) = (&surfaces[place], (unit_double(Vec2::new(x, finer)), y));
                    for light in sample_direct(&world, surface, &surface.white(), how, numbers) {
                        expected_rays += 1;
                        if !world.occluded(&light.ray) {
                            expected.push((light.direction, light.radiance * PI));
                        }
                    }
                }
                assert_eq!((found, traced), (expected, expected_rays), "{how:?} at {count} surfaces");
                assert!((100..=500).contains(&expected_rays), "{expected_rays} rays");
                let even = 500 / count;
                assert!(used[..count].iter().all(|used| used.abs_diff(even) <= 2), "{used:?} samples at the surfaces");
            }
        }
    }
}
