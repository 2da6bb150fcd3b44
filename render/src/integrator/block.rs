//! Paths in lanes: what a few paths need to know of their surfaces, in columns, so that plain loops over them, compiled
//! for each instruction set, do as many at once as its registers hold.
//!
//! A loop here calls the functions that a single path would call, on surfaces put together from the columns; what they
//! do is inlined and has no branch. So results are equal bit for bit to those of one path at a time, on every
//! instruction set. All lanes are computed, those behind the last path for nothing.

mod columns;
mod lamps;

use glam::{Vec2, Vec3};
use halfdome_kernel::Ray;
use halfdome_kernel::sampling::Address;

use crate::estimator::shine;
use crate::scene::Material;
use crate::settings::LightSampling;
use crate::world::{Face, Surface};

pub(super) use columns::LANES;
use columns::{Column, Vectors};
use lamps::{Lamp, Lamps};
/// Points of surfaces, with what a ray that leaves or reaches one needs.
struct Places {
    position: Vectors,
    normal: Vectors,
    offset: Column,
}

/// Paths that have arrived at a surface each.
pub(super) struct Block {
    /// How many there are.
    pub len: usize,
    /// The place of each in its wavefront.
    pub source: [u32; LANES],
    pub addresses: [Address; LANES],
    pub on_light: [Vec2; LANES],
    pub onwards: [Vec2; LANES],
    /// The direction about the normal that `onwards` means by the cosine.
    pub cosine: [Vec3; LANES],
    pub chances: [Vec2; LANES],
    places: Places,
    shading_normal: Vectors,
    diffuse: Vectors,
    throughput: Vectors,
    /// The probability of scattering light, other than as a mirror or glass does.
    pub scatters: Column,
    /// The probability with which a path goes on.
    pub survival: Column,
    /// The triangle of each.
    pub prims: [u32; LANES],
    lamps: Lamps,
}

/// Shadow rays of a block, and the light that each lets through.
pub(super) struct Shadows {
    origin: Vectors,
    way: Vectors,
    light: Vectors,
    /// Whether there is any light.
    lit: [u32; LANES],
}

/// Rays by which the paths of a block go on.
pub(super) struct Bounces {
    origin: Vectors,
    direction: Vectors,
    throughput: Vectors,
    density: Column,
    /// Whether any light is reflected from there.
    reflects: [u32; LANES],
}

impl Places {
    const NONE: Self = Self { position: Vectors::ZERO, normal: Vectors::ZERO, offset: [0.0; LANES] };

    #[inline(always)]
    fn set(&mut self, i: usize, surface: &Surface) {
        self.position.set(i, surface.position);
        self.normal.set(i, surface.normal);
        self.offset[i] = surface.offset;
    }
}

impl Block {
    /// All zeros, which are quick to write.
    pub(super) const EMPTY: Self = Self {
        len: 0,
        source: [0; LANES],
        addresses: [Address { pixel: 0, sample: 0 }; LANES],
        on_light: [Vec2::ZERO; LANES],
        onwards: [Vec2::ZERO; LANES],
        cosine: [Vec3::ZERO; LANES],
        chances: [Vec2::ZERO; LANES],
        places: Places::NONE,
        shading_normal: Vectors::ZERO,
        diffuse: Vectors::ZERO,
        throughput: Vectors::ZERO,
        scatters: [0.0; LANES],
        survival: [0.0; LANES],
        prims: [0; LANES],
        lamps: Lamps::NONE,
    };

    /// Adds a path, which must have a lane left. `survival` is the probability with which chance lets it go on.
    #[inline(always)]
    pub(super) fn push(&mut self, source: usize, address: Address, surface: &Surface, throughput: Vec3, survival: f32) {
        let i = self.len % LANES;
        self.source[i] = source as u32;
        self.addresses[i] = address;
        self.places.set(i, surface);
        self.shading_normal.set(i, surface.shading_normal);
        self.diffuse.set(i, surface.diffuse);
        self.scatters[i] = 1.0 - surface.specular_probability();
        self.throughput.set(i, throughput);
        self.survival[i] = survival;
        self.prims[i] = surface.prim_id;
        self.lamps.is_there[i] = 0;
        self.len += 1;
    }

    /// Lets path `i` sample a lamp, of which `u` says where; `area_density` is that of its points, if all were alike.
    #[inline(always)]
    pub(super) fn set_lamp(&mut self, i: usize, face: &Face, material: &Material, area_density: f32, u: Vec2) {
        let is_behind =
            material.emits_both_sides && face.normal.dot(face.corners[0] - self.places.position.get(i)) > 0.0;
        let normal = if is_behind { -face.normal } else { face.normal };
        let Face { corners, offset, .. } = *face;
        self.lamps.set(i, &Lamp { corners, normal, offset, emission: material.emission, area_density }, u);
    }

    /// The surface of path `i`, as far as light is scattered by it.
    #[inline(always)]
    pub(super) fn surface<'w>(&self, i: usize, matte: &'w Material) -> Surface<'w> {
        Surface {
            position: self.places.position.get(i),
            normal: self.places.normal.get(i),
            shading_normal: self.shading_normal.get(i),
            diffuse: self.diffuse.get(i),
            emission: Vec3::ZERO,
            offset: self.places.offset[i],
            prim_id: 0,
            is_back: false,
            material: matte,
        }
    }

    /// Light from the lamps.
    #[inline(always)]
    pub(super) fn connect(&self, lights: LightSampling, matte: &Material, shadows: &mut Shadows) {
        // A loop each, which knows its weights.
        match lights {
            LightSampling::Naive => shadows.lit = [0; LANES],
            LightSampling::Direct => self.connect_by(LightSampling::Direct, matte, shadows),
            LightSampling::Mis => self.connect_by(LightSampling::Mis, matte, shadows),
        }
    }

    #[inline(always)]
    fn connect_by(&self, lights: LightSampling, matte: &Material, shadows: &mut Shadows) {
        for i in 0..LANES {
            let surface = self.surface(i, matte);
            let (lamp, area_density) = self.lamps.point(i, &surface);
            let (light, arrives) = shine(&surface, &lamp, area_density);
            let lambert = surface.lambert(light.direction);
            let weight = lights.of_light(light.per_density, self.scatters[i] * lambert);
            let radiance = (surface.diffuse * lambert) * light.radiance * weight;
            shadows.origin.set(i, light.shadow.origin);
            shadows.way.set(i, light.shadow.direction);
            shadows.light.set(i, self.throughput.get(i) * radiance);
            shadows.lit[i] = u32::from(arrives & (radiance.max_element() > 0.0)) & self.lamps.is_there[i];
        }
    }

    /// Scattered light.
    #[inline(always)]
    pub(super) fn bounce(&self, matte: &Material, bounces: &mut Bounces) {
        for i in 0..LANES {
            let surface = self.surface(i, matte);
            let (bounce, reflects) = surface.scatter(self.cosine[i], surface.diffuse, 1.0);
            bounces.origin.set(i, surface.origin_towards(bounce.direction));
            bounces.direction.set(i, bounce.direction);
            bounces.throughput.set(i, (self.throughput.get(i) / self.survival[i]) * bounce.weight);
            bounces.density[i] = bounce.density;
            bounces.reflects[i] = u32::from(reflects);
        }
    }
}

impl Shadows {
    pub(super) const NONE: Self =
        Self { origin: Vectors::ZERO, way: Vectors::ZERO, light: Vectors::ZERO, lit: [0; LANES] };

    /// The shadow ray of path `i`, its light, and whether there is any.
    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> (Ray, Vec3, bool) {
        let ray = Ray { origin: self.origin.get(i), t_min: 0.0, direction: self.way.get(i), t_max: 1.0 };
        (ray, self.light.get(i), self.lit[i] != 0)
    }
}

impl Bounces {
    pub(super) const NONE: Self = Self {
        origin: Vectors::ZERO,
        direction: Vectors::ZERO,
        throughput: Vectors::ZERO,
        density: [0.0; LANES],
        reflects: [0; LANES],
    };

    /// The ray by which path `i` goes on, its throughput and density per solid angle, and whether there is any light.
    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> (Ray, Vec3, f32, bool) {
        let ray = Ray::new(self.origin.get(i), self.direction.get(i));
        (ray, self.throughput.get(i), self.density[i], self.reflects[i] != 0)
    }
}

#[cfg(test)]
mod tests;
