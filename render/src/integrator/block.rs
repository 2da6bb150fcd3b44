//! Paths in lanes: what a few paths need to know of their surfaces, in columns, so that plain loops over them, compiled
//! for each instruction set, do as many at once as its registers hold.
//!
//! A loop here calls the functions that a single path would call, on surfaces put together from the columns; what they
//! do is inlined and has no branch. So results are equal bit for bit to those of one path at a time, on every
//! instruction set. All lanes are computed, those behind the last path for nothing.

use glam::{Vec2, Vec3};
use halfdome_kernel::sampling::Address;
use halfdome_kernel::sampling::warp::{Triangle as TriangleWarp, Warp};
use halfdome_kernel::{Ray, Triangle};

use crate::estimator::{prospect, shine};
use crate::scene::Material;
use crate::settings::LightSampling;
use crate::world::{Face, Surface, interpolate};

/// Paths in a block: few enough for the first-level cache.
pub(super) const LANES: usize = 64;

/// A number of each path.
type Column = [f32; LANES];

/// A vector of each path.
#[derive(Clone, Copy)]
pub(super) struct Vectors {
    x: Column,
    y: Column,
    z: Column,
}

/// Points of surfaces, with what a ray that leaves or reaches one needs.
struct Places {
    position: Vectors,
    normal: Vectors,
    offset: Column,
}

/// A triangle that emits light to the side of its normal.
struct Lamp {
    corners: Triangle,
    normal: Vec3,
    offset: f32,
    emission: Vec3,
    /// The density per area of its points, if those were all alike.
    area_density: f32,
}

/// Such triangles, with numbers that say where on each.
struct Lamps {
    corners: [Vectors; 3],
    normal: Vectors,
    offset: Column,
    emission: Vectors,
    /// The density per area of their points, if those were all alike.
    area_density: Column,
    on_lamp: [Column; 2],
    /// Whether there is one.
    is_there: [u32; LANES],
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

impl Vectors {
    const ZERO: Self = Self { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES] };

    #[inline(always)]
    fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    #[inline(always)]
    fn set(&mut self, i: usize, vector: Vec3) {
        (self.x[i], self.y[i], self.z[i]) = (vector.x, vector.y, vector.z);
    }
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

impl Lamps {
    const NONE: Self = Self {
        corners: [Vectors::ZERO; 3],
        normal: Vectors::ZERO,
        offset: [0.0; LANES],
        emission: Vectors::ZERO,
        area_density: [0.0; LANES],
        on_lamp: [[0.0; LANES]; 2],
        is_there: [0; LANES],
    };

    #[inline(always)]
    fn set(&mut self, i: usize, lamp: &Lamp, u: Vec2) {
        for (corners, corner) in self.corners.iter_mut().zip(lamp.corners) {
            corners.set(i, corner);
        }
        self.normal.set(i, lamp.normal);
        self.offset[i] = lamp.offset;
        self.emission.set(i, lamp.emission);
        self.area_density[i] = lamp.area_density;
        (self.on_lamp[0][i], self.on_lamp[1][i]) = (u.x, u.y);
        self.is_there[i] = 1;
    }

    /// The point of lamp `i` that is sampled from `surface`, and its density per area.
    #[inline(always)]
    fn point<'w>(&self, i: usize, surface: &Surface<'w>) -> (Surface<'w>, f32) {
        let corners = [self.corners[0].get(i), self.corners[1].get(i), self.corners[2].get(i)];
        let prospect = prospect(surface.position, surface.normal, &corners);
        let u = prospect.map(Vec2::new(self.on_lamp[0][i], self.on_lamp[1][i]));
        let point = TriangleWarp.map(u);
        let normal = self.normal.get(i);
        let lamp = Surface {
            position: interpolate(corners, [1.0 - point.x - point.y, point.x, point.y]),
            normal,
            shading_normal: normal,
            diffuse: Vec3::ZERO,
            emission: self.emission.get(i),
            offset: self.offset[i],
            prim_id: 0,
            is_back: false,
            material: surface.material,
        };
        (lamp, self.area_density[i] * prospect.density(u))
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
mod tests {
    use halfdome_kernel::sampling::Stream;
    use halfdome_kernel::sampling::warp::{CosineHemisphere, UniformSphere};
    use halfdome_kernel::{Isa, Level, Task};

    use super::*;
    use crate::world::WHITE;

    /// Light and bounces of a block, compiled for an instruction set.
    struct Shade<'a>(&'a Block, LightSampling, &'a mut Shadows, &'a mut Bounces);

    impl Task for Shade<'_> {
        type Output = ();

        #[inline(always)]
        fn run(self) {
            self.0.connect(self.1, &WHITE, self.2);
            self.0.bounce(&WHITE, self.3);
        }
    }

    /// A surface somewhere, in some direction, some with vertex normals, and numbers for a direction from it.
    fn surface(number: u32) -> (Surface<'static>, Vec2) {
        let stream = Stream::new(1, number, 0);
        let normal = UniformSphere.map(stream.uniform2(0));
        let smooth = if number.is_multiple_of(3) { 0.5 * UniformSphere.map(stream.uniform2(1)) } else { Vec3::ZERO };
        let [x, y, z, offset] = stream.uniform4(2);
        let [red, green, blue, _] = stream.uniform4(3);
        let surface = Surface {
            position: Vec3::new(x, y, z),
            normal,
            shading_normal: (normal + smooth).normalize(),
            diffuse: Vec3::new(red, green, blue),
            emission: Vec3::new(blue, red, green),
            offset: 1e-6 * offset,
            prim_id: 0,
            is_back: false,
            material: &WHITE,
        };
        (surface, stream.uniform2(4))
    }

    /// Corners of a lamp somewhere.
    fn corners(number: u32) -> [Vec3; 3] {
        [2000, 3000, 4000].map(|which| surface(which + number).0.position * 2.0)
    }

    #[test]
    fn lanes_equal_paths_one_by_one_on_every_instruction_set() {
        // One lane less than there are: what is behind the last path must not count.
        let count = LANES - 1;
        let (throughput, survival) = (Vec3::new(0.3, 0.7, 0.9), 0.6);
        let (mut block, mut shadows, mut bounces) = (Block::EMPTY, Shadows::NONE, Bounces::NONE);
        for i in 0..count {
            let (surface, u) = surface(i as u32);
            block.push(i, Address::default(), &surface, throughput, survival);
            block.cosine[i] = CosineHemisphere.map(u);
            // Not all have a lamp.
            if i % 5 != 0 {
                let (lamp, u) = self::surface(1000 + i as u32);
                let Surface { normal, offset, emission, .. } = lamp;
                let corners = corners(i as u32);
                block.lamps.set(i, &Lamp { corners, normal, offset, emission, area_density: 2.5 }, u);
            }
        }
        let mut lit = 0;
        for isa in Level::ALL.into_iter().filter_map(Isa::new) {
            for lights in [LightSampling::Naive, LightSampling::Direct, LightSampling::Mis] {
                isa.run(Shade(&block, lights, &mut shadows, &mut bounces));
                for i in 0..count {
                    let (surface, u) = surface(i as u32);
                    let (lamp, place) = self::surface(1000 + i as u32);
                    let [a, b, c] = corners(i as u32);
                    let prospect = prospect(surface.position, surface.normal, &[a, b, c]);
                    let place = prospect.map(place);
                    let Vec2 { x, y } = TriangleWarp.map(place);
                    let lamp = Surface { position: a * (1.0 - x - y) + b * x + c * y, ..lamp };
                    let (light, arrives) = shine(&surface, &lamp, 2.5 * prospect.density(place));
                    let (reflected, density) = surface.evaluate(light.direction);
                    let radiance = reflected * light.radiance * lights.of_light(light.per_density, density);
                    let expected = arrives && i % 5 != 0 && radiance.max_element() > 0.0;
                    let (shadow, light_found, is_lit) = shadows.get(i);
                    assert_eq!(is_lit, expected, "{isa:?}, {lights:?}, {i}");
                    if is_lit {
                        assert_eq!((shadow, light_found), (light.shadow, throughput * radiance), "{isa:?}, {i}");
                        lit += 1;
                    }
                    let (ray, weight, density, reflects) = bounces.get(i);
                    match surface.sample(Vec3::NEG_Z, u) {
                        Some(bounce) => {
                            let origin = surface.origin_towards(bounce.direction);
                            assert_eq!(ray, Ray::new(origin, bounce.direction), "{isa:?}, {i}");
                            assert_eq!((weight, density), (throughput / survival * bounce.weight, bounce.density));
                            assert!(reflects);
                        }
                        None => assert!(!reflects),
                    }
                }
            }
        }
        assert!(lit > 20, "{lit}");
    }
}
