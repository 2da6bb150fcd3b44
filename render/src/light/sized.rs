//! Punctual lights with a size, for rays that hit them: the spheres of points and spots, and suns with an angle.
//!
//! They have no triangles, do not block rays, and are invisible to the camera itself. Many spheres are in a tree of the
//! kernel; a few are tested one by one. Spheres of moving lights enclose their whole motion, so a hit must be tested
//! against the light's actual position.

use halfdome_kernel::geometry::Sphere;
use halfdome_kernel::{BuildOptions, Ray, RoundBvh};

use super::Light;
use crate::scene::PunctualLight;

/// The most spheres that are tested without a tree.
const FEW: usize = 16;

/// All lights of a size.
#[derive(Debug, Default)]
pub(crate) struct SizedLights {
    tree: Option<RoundBvh>,
    spheres: Vec<Sphere>,
    /// The numbers of lights with their spheres, which may be the same, sorted by these.
    numbers: Vec<(u32, u32)>,
    /// The numbers of suns.
    suns: Vec<u32>,
}

impl SizedLights {
    /// The lights with a size among `lights`; moving ones enclose their whole motion.
    pub(super) fn new(lights: &[Light]) -> Self {
        let (mut placed, mut suns) = (Vec::new(), Vec::new());
        for (number, light) in (0..).zip(lights) {
            match light {
                Light::Punctual(PunctualLight::Directional { half_angle, .. }) if *half_angle > 0.0 => {
                    suns.push(number)
                }
                Light::Punctual(light) => placed.extend(sphere(light).map(|sphere| (sphere, number))),
                _ => {}
            }
        }
        let key = |sphere: &Sphere| (sphere.center.to_array().map(f32::to_bits), sphere.radius.to_bits());
        placed.sort_by_key(|(sphere, number)| (key(sphere), *number));
        let (mut spheres, mut numbers) = (Vec::<Sphere>::new(), Vec::new());
        for (sphere, number) in placed {
            if spheres.last() != Some(&sphere) {
                spheres.push(sphere);
            }
            numbers.push((spheres.len() as u32 - 1, number));
        }
        let build = || RoundBvh::build(&spheres, &BuildOptions::default());
        let tree = if spheres.len() <= FEW { None } else { build().ok().map(|(tree, _)| tree) };
        Self { tree, spheres, numbers, suns }
    }

    /// Whether there are none.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.numbers.is_empty() && self.suns.is_empty()
    }

    /// The numbers of the suns.
    pub(crate) fn suns(&self) -> &[u32] {
        &self.suns
    }

    /// Calls `meet` with the index of each light whose sphere a ray of unit direction hits, at any distance; of many
    /// spheres that end at the same `f32` only with those of the first.
    pub(crate) fn along(&self, ray: &Ray, mut meet: impl FnMut(u32)) {
        let Some(tree) = &self.tree else {
            let is_near = |sphere: u32| is_near(ray, &self.spheres[sphere as usize]);
            return self.numbers.iter().filter(|(sphere, _)| is_near(*sphere)).for_each(|(_, number)| meet(*number));
        };
        let mut rest = Ray { t_max: f32::INFINITY, ..*ray };
        while let Some(hit) = tree.view().intersect(&rest) {
            let outward = ray.origin + hit.t * ray.direction - self.spheres[hit.prim_id as usize].center;
            // Where it leaves the sphere, which it does once, wherever it begins.
            if outward.dot(ray.direction) >= 0.0 {
                let first = self.numbers.partition_point(|(sphere, _)| *sphere < hit.prim_id);
                let same = self.numbers[first..].iter().take_while(|(sphere, _)| *sphere == hit.prim_id);
                same.for_each(|(_, number)| meet(*number));
            }
            rest.t_min = hit.t.next_up();
        }
    }
}

/// Whether a ray may meet a sphere.
fn is_near(ray: &Ray, sphere: &Sphere) -> bool {
    let way = sphere.center - ray.origin;
    let along = way.dot(ray.direction);
    // More, for what is rounded.
    let radius = 1.001 * sphere.radius;
    (way - along * ray.direction).length_squared() < radius * radius && along > -radius
}

/// The sphere of a light, if it has a place and a size.
fn sphere(light: &PunctualLight) -> Option<Sphere> {
    let (position, _, radius) = light.place()?;
    (radius > 0.0).then(|| Sphere::new(position, radius))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn point(x: f32, radius: f32) -> Light {
        Light::Punctual(PunctualLight::Point { position: Vec3::X * x, intensity: Vec3::ONE, radius })
    }

    fn met(lights: &SizedLights, origin: Vec3, direction: Vec3) -> Vec<u32> {
        let mut met = Vec::new();
        lights.along(&Ray::new(origin, direction), |number| met.push(number));
        met.sort();
        met
    }

    #[test]
    fn each_sphere_on_the_way_is_met_once() {
        let mut lights = vec![point(1.0, 0.1), point(2.0, 0.0), Light::Sky, point(3.0, 0.5), point(3.0, 0.5)];
        lights.extend((0..100).map(|i| point(3.2 + 0.1 * i as f32, 0.123)));
        let few = SizedLights::new(&lights[..5]);
        assert_eq!(met(&few, Vec3::ZERO, Vec3::X), [0, 3, 4]);
        assert_eq!(met(&few, Vec3::X * 1.05, Vec3::X), [0, 3, 4], "from inside the first");
        assert_eq!(met(&few, Vec3::X * 2.0, Vec3::NEG_X), [0]);
        assert!(met(&few, Vec3::ZERO, Vec3::Y).is_empty());
        let lights = SizedLights::new(&lights);
        let all: Vec<u32> = [0, 3, 4].into_iter().chain(5..105).collect();
        assert_eq!(met(&lights, Vec3::ZERO, Vec3::X), all);
        assert_eq!(met(&lights, Vec3::X * 1.05, Vec3::X), all, "from inside the first");
        assert_eq!(met(&lights, Vec3::X * 2.0, Vec3::NEG_X), [0]);
        assert!(met(&lights, Vec3::ZERO, Vec3::Y).is_empty());
        assert_eq!(met(&lights, Vec3::new(3.0, -5.0, 0.0), Vec3::Y), [3, 4]);
    }
}
