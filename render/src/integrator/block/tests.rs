//! Lanes equal paths one by one.

use halfdome_kernel::sampling::Stream;
use halfdome_kernel::sampling::warp::{CosineHemisphere, Triangle as TriangleWarp, UniformSphere, Warp};
use halfdome_kernel::{Isa, Level, Task};

use super::*;
use crate::estimator::prospect;
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
