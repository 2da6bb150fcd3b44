//! Dispersion: the refractive index of glass depends on the wavelength.
//!
//! The refractive index at the wavelength `λ` is Cauchy's, by the index `n` at 587.6 nm and Abbe's number `V`
//! (`KHR_materials_dispersion`):
//!
//! `n(λ) = n + (n - 1)/V (523655 nm²/λ² - 1.5168)`.
//!
//! At its first hit of such glass, a path keeps one channel of its colour, chosen in proportion, and represents one
//! wavelength of that channel from there on. The wavelength follows from its random numbers, the same at all faces, so
//! that a path need not store it.
//!
//! Deviation: a channel is a band of wavelengths about its primary, with a triangular profile; so spectra consist of
//! mixtures of three primaries.

use glam::Vec3;

use super::Advance;
use crate::integrator::path_block::PathBlock;
use crate::world::Surface;

/// The set of random numbers for channel and wavelength, far from those of surfaces.
const SET: u32 = u32::MAX;

/// The middle of each channel's band, and how far it reaches, in nm.
const BANDS: [(f32, f32); 3] = [(620.0, 70.0), (545.0, 65.0), (460.0, 60.0)];

impl Advance<'_, '_> {
    /// Lets path `i`, which has arrived at glass that disperses light, have one wavelength there.
    #[inline(never)]
    pub(super) fn disperse(&self, block: &mut PathBlock, i: usize, surface: &mut Surface) {
        let material = surface.material;
        if !material.is_glass() || material.inputs.thin_walled {
            return;
        }
        let Some(sampler) = self.batch.samplers.get(block.index(i)) else { return };
        let [choice, place] = sampler.uniform2(SET).to_array();
        let throughput = block.throughput(i);
        let Some((channel, probability)) = choose(throughput, choice) else { return };
        let mut kept = Vec3::ZERO;
        kept[channel] = probability.recip();
        block.dim(i, kept);
        surface.change.ior = index_shift(material.inputs.specular_ior, material.dispersion, wavelength(channel, place));
    }
}

/// A channel in proportion to what a path carries of it, by a number in [0, 1), and the probability of choosing it; `None` if it
/// carries nothing.
fn choose(throughput: Vec3, u: f32) -> Option<(usize, f32)> {
    let sum = throughput.element_sum();
    let mut place = u * sum;
    let mut chosen = None;
    for (channel, part) in throughput.to_array().into_iter().enumerate().filter(|(_, part)| *part > 0.0) {
        chosen = Some((channel, part / sum));
        if place < part {
            break;
        }
        place -= part;
    }
    chosen
}

/// A wavelength of a channel in nm, by a number in [0, 1).
fn wavelength(channel: usize, u: f32) -> f32 {
    let (middle, reach) = BANDS[channel];
    middle + reach * if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

/// The refractive index at a wavelength in nm, minus `ior`; `dispersion` is `20 / V`.
fn index_shift(ior: f32, dispersion: f32, wavelength: f32) -> f32 {
    (ior - 1.0) * (dispersion / 20.0) * (523_655.0 / (wavelength * wavelength) - 1.5168)
}

#[cfg(test)]
mod tests {
    use glam::vec3;

    use super::*;
    use crate::driver;
    use crate::material::Inputs;
    use crate::scene::{CameraPose, Material, Mesh, Scene, Sky};
    use crate::settings::Settings;
    use crate::watch::NeverStops;
    use crate::world::World;

    #[test]
    fn flint_has_its_indices_at_the_lines_of_fraunhofer() {
        // Schott's F2: n_d 1.62004, V_d 36.37, n_F 1.63208 at 486.1 nm, n_C 1.61503 at 656.3 nm.
        let index = |wavelength| 1.62004 + index_shift(1.62004, 20.0 / 36.37, wavelength);
        assert!((index(587.6) - 1.62004f32).abs() < 1e-5);
        assert!((index(486.1) - 1.63208f32).abs() < 1e-3 && (index(656.3) - 1.61503f32).abs() < 1e-3);
        assert!((index(486.1) - index(656.3) - 0.62004 / 36.37f32).abs() < 1e-4, "by its definition");
    }

    #[test]
    fn channels_are_chosen_in_proportion_and_what_is_kept_is_right_in_the_mean() {
        let throughput = vec3(0.5, 0.0, 1.5);
        let mut sum = Vec3::ZERO;
        for k in 0..1000 {
            let (channel, probability) = choose(throughput, (k as f32 + 0.5) / 1000.0).unwrap();
            sum[channel] += throughput[channel] / probability / 1000.0;
        }
        assert!((sum - throughput).abs().max_element() < 1e-4, "{sum}");
        assert_eq!(choose(Vec3::Y, 0.999), Some((1, 1.0)));
        assert_eq!(choose(Vec3::ZERO, 0.5), None);
        let mean = |channel| (0..1000).map(|k| wavelength(channel, (k as f32 + 0.5) / 1000.0)).sum::<f32>() / 1000.0;
        assert!((mean(0) - 620.0).abs() < 0.1 && (mean(2) - 460.0).abs() < 0.1);
    }

    /// A prism whose first face is across z, with its tip towards -x, before a wall whose upper part shines.
    fn prism(dispersion: f32, edge: f32) -> World {
        let slope = 0.3;
        let quad = |corners: [(f32, f32, f32); 4], material| Mesh {
            positions: corners.map(|(x, y, z)| vec3(x, y, z)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material,
            ..Mesh::default()
        };
        let back = |x: f32| -1.0 - slope * (x + 2.0);
        let inputs = Inputs {
            specular_weight: 1.0,
            specular_roughness: 0.0,
            specular_ior: 1.5,
            transmission_weight: 1.0,
            transmission_color: Vec3::ONE,
            ..Inputs::default()
        };
        World::new(Scene {
            meshes: vec![
                quad([(-2.0, -2.0, -1.0), (2.0, -2.0, -1.0), (2.0, 2.0, -1.0), (-2.0, 2.0, -1.0)], 0),
                quad(
                    [(-2.0, -2.0, back(-2.0)), (-2.0, 2.0, back(-2.0)), (2.0, 2.0, back(2.0)), (2.0, -2.0, back(2.0))],
                    0,
                ),
                quad([(edge, -50.0, -20.0), (50.0, -50.0, -20.0), (50.0, 50.0, -20.0), (edge, 50.0, -20.0)], 1),
            ],
            materials: vec![
                Material { inputs, dispersion, ..Material::default() },
                Material { emission: Vec3::ONE, ..Material::matte(Vec3::ZERO) },
            ],
            camera: Some(CameraPose { eye: Vec3::ZERO, target: -Vec3::Z, up: Vec3::Y, vfov: 0.01 }),
            ..Scene::default()
        })
        .unwrap()
    }

    fn color(world: &World, spp: u32) -> Vec3 {
        let settings = Settings { width: 2, height: 2, spp, ..Settings::default() };
        let picture = driver::render(world, &settings, &NeverStops).picture;
        let channel = |name: &str| picture.channel(name).unwrap().values.iter().sum::<f32>() / 4.0;
        vec3(channel("R"), channel("G"), channel("B"))
    }

    /// Where light that leaves the eye along -z arrives at the wall, by Snell's law.
    fn arrives(index: f32) -> f32 {
        let tilt = 0.3f32.atan();
        let bent = (index * tilt.sin()).asin() - tilt;
        let z = -1.0 - 0.3 * 2.0;
        bent.tan() * (20.0 + z)
    }

    #[test]
    fn a_prism_parts_the_colours_as_snells_law_says() {
        let dispersion = 2.0;
        let at = |wavelength: f32| arrives(1.5 + index_shift(1.5, dispersion, wavelength));
        let (red, blue) = (at(620.0), at(460.0));
        assert!(blue > red + 0.2, "{red}, {blue}");
        // The wall shines from an edge on: to both, to blue alone, to neither.
        let faces = 0.85;
        let both = color(&prism(dispersion, at(700.0) - 0.01), 256);
        assert!(both.min_element() > faces && both.max_element() < 1.0, "{both}");
        let one = color(&prism(dispersion, 0.5 * (at(535.0) + at(520.0))), 256);
        assert!(one.z > faces && one.x < 0.02 && one.y > 0.05 && one.y < 0.8, "{one}");
        let none = color(&prism(dispersion, at(399.0) + 0.01), 256);
        assert!(none.max_element() < 0.02, "{none}");
        // Half of red's band is on either side of its middle.
        let half = color(&prism(dispersion, red), 1024);
        assert!((half.x / both.x - 0.5).abs() < 0.05 && (half.z / both.z - 1.0).abs() < 0.05, "{half} of {both}");
    }

    /// What leaves nothing of a white furnace without dispersion leaves nothing of it with.
    #[test]
    fn glass_that_disperses_is_white_under_a_white_sky() {
        let mut world = Vec::new();
        for dispersion in [0.0, 1.0] {
            let inputs = Inputs { specular_weight: 1.0, transmission_weight: 1.0, ..Inputs::default() };
            let inputs = Inputs { specular_ior: 1.5, transmission_color: Vec3::ONE, ..inputs };
            let corner = |i: usize| vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) - 0.5;
            let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
            let cube = Mesh {
                positions: (0..8).map(corner).collect(),
                triangles: faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
                ..Mesh::default()
            };
            world.push(
                World::new(Scene {
                    meshes: vec![cube],
                    materials: vec![Material { inputs, dispersion, ..Material::default() }],
                    camera: Some(CameraPose { eye: vec3(1.0, 1.2, 3.0), target: Vec3::ZERO, up: Vec3::Y, vfov: 8.0 }),
                    sky: Sky::constant(Vec3::ONE),
                    ..Scene::default()
                })
                .unwrap(),
            );
        }
        let [plain, dispersed] = [color(&world[0], 4096), color(&world[1], 4096)];
        assert!(
            (plain - 1.0).abs().max_element() < 0.02 && (dispersed - 1.0).abs().max_element() < 0.06,
            "{plain}, {dispersed}"
        );
    }
}
