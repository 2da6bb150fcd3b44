//! Whole cube maps.

use glam::{DVec3, Vec3};

use super::*;
use crate::scene::{CameraPose, Material, Mesh, Scene, Sky, SkyPicture};
use crate::world::World;

/// A watcher that says stop after some steps.
struct StopsAfter(std::sync::atomic::AtomicU64);

impl Watch for StopsAfter {
    fn advance(&self, samples: u64, _: u64) {
        let left = &self.0;
        left.fetch_sub(
            samples.min(left.load(std::sync::atomic::Ordering::Relaxed)),
            std::sync::atomic::Ordering::Relaxed,
        );
    }

    fn stop(&self) -> bool {
        self.0.load(std::sync::atomic::Ordering::Relaxed) == 0
    }
}

fn never_stops() -> StopsAfter {
    StopsAfter(u64::MAX.into())
}

fn options(size: u32, seams: Seams) -> Options {
    Options {
        size,
        levels: Options::max_levels(size),
        seams,
        filter: Filter::Ggx,
        mapping: Mapping::Linear,
        axes: Axes::Bevy,
        diffuse: Some(8),
        seed: 0,
    }
}

/// A room whose six walls have colours of their own, seen from its middle.
fn colored_room() -> World {
    let mut scene = Scene {
        camera: Some(CameraPose { eye: Vec3::ZERO, target: Vec3::X, up: Vec3::Y, vfov: 90.0 }),
        ..Scene::default()
    };
    for (wall, middle) in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].into_iter().enumerate() {
        let right = if middle.y == 0.0 { Vec3::Y } else { Vec3::X };
        let down = middle.cross(right);
        let positions =
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| middle + right * a + down * b);
        let mut emission = Vec3::ZERO;
        emission[wall / 2] = if wall % 2 == 0 { 1.0 } else { 0.25 };
        scene.meshes.push(Mesh {
            positions: positions.to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: wall,
            ..Mesh::default()
        });
        let material = Material { emission, emits_both_sides: true, ..Material::matte(Vec3::ZERO) };
        scene.materials.push(material);
    }
    World::new(scene).unwrap()
}

#[test]
fn faces_show_the_walls_that_engines_look_for_there() {
    let world = colored_room();
    let source = Environment::point(&world, Vec3::ZERO, Paths::Count(2), 0);
    let (red, dark_red) = (Vec3::X, Vec3::X * 0.25);
    let (blue, dark_blue) = (Vec3::Z, Vec3::Z * 0.25);
    // +x, -x, +z, -z of the cube map. Bevy looks up -z at the face +z, three.js +x at the face -x.
    for (axes, expected) in [
        (Axes::World, [red, dark_red, blue, dark_blue]),
        (Axes::Bevy, [red, dark_red, dark_blue, blue]),
        (Axes::Three, [dark_red, red, blue, dark_blue]),
    ] {
        let options = Options { axes, levels: 1, diffuse: None, ..options(8, Seams::None) };
        let map = make(&source, &options, &never_stops()).unwrap();
        let all = |face: Face, color: Vec3| map.levels[0].face(face).iter().all(|texel| *texel == color);
        assert!(all(Face::PositiveX, expected[0]) && all(Face::NegativeX, expected[1]), "{axes:?}");
        assert!(all(Face::PositiveY, Vec3::Y) && all(Face::NegativeY, Vec3::Y * 0.25), "{axes:?}");
        assert!(all(Face::PositiveZ, expected[2]) && all(Face::NegativeZ, expected[3]), "{axes:?}");
    }
}

/// A picture that is brighter on the right is so on the face in front.
#[test]
fn a_picture_of_the_sky_is_not_mirrored() {
    let texels: Vec<Vec3> = (0..64 * 32).map(|i| Vec3::splat((i % 64) as f32)).collect();
    let sky = Sky { radiance: Vec3::ZERO, picture: Some(SkyPicture::new(64, 32, texels)) };
    let map = make(&Environment::sky(sky), &Options { levels: 1, ..options(16, Seams::None) }, &never_stops()).unwrap();
    let front = &map.levels[0].face(Face::PositiveZ);
    let row = &front[7 * 16..8 * 16];
    assert!(row.is_sorted_by(|a, b| a.x < b.x), "{row:?}");
    // The picture's middle is in front, between its columns 31 and 32.
    assert!((row[7].x - 31.0).abs() < 0.5 && (row[8].x - 32.0).abs() < 0.5, "{row:?}");
    // The face on the right is brighter still, where it meets.
    assert!(map.levels[0].face(Face::PositiveX)[7 * 16].x > row[15].x);
}

#[test]
fn a_constant_sky_is_constant_in_all_levels() {
    let radiance = Vec3::new(0.3, 1.0, 2.5);
    for seams in Seams::ALL {
        for (filter, mapping) in [(Filter::Ggx, Mapping::Sqrt), (Filter::Phong, Mapping::Linear)] {
            let options = Options { filter, mapping, ..options(16, seams) };
            let map = make(&Environment::sky(Sky::constant(radiance)), &options, &never_stops()).unwrap();
            let sizes: Vec<u32> = map.levels.iter().map(|level| level.grid.size).collect();
            assert_eq!(sizes, [16, 8, 4, 2, 1]);
            for level in map.levels.iter().chain(&map.diffuse) {
                assert!(level.texels.iter().all(|texel| *texel == radiance), "{seams:?} {:?}", level.lobe);
            }
        }
    }
}

/// Irradiance of a sky `1 + y` is `π (1 + 2/3 n·y)`.
#[test]
fn the_diffuse_map_is_irradiance_over_pi() {
    let texels = (0..128 * 256).map(|i| {
        let theta = std::f64::consts::PI * (f64::from(i / 256) + 0.5) / 128.0;
        Vec3::splat((1.0 + theta.cos()) as f32)
    });
    let sky = Sky { radiance: Vec3::ZERO, picture: Some(SkyPicture::new(256, 128, texels.collect())) };
    let map =
        make(&Environment::sky(sky), &Options { levels: 1, ..options(64, Seams::Lookup) }, &never_stops()).unwrap();
    let diffuse = map.diffuse.unwrap();
    for ((face, x, y), texel) in diffuse.grid.places().zip(&diffuse.texels) {
        let normal = diffuse.grid.point(face, x, y).normalize();
        let expected = 1.0 + normal.dot(DVec3::Y) * 2.0 / 3.0;
        assert!((f64::from(texel.x) - expected).abs() < 3e-3, "{normal}: {texel}, not {expected}");
    }
}

/// Of a picture with a sun, which is not smooth at all.
#[test]
fn treated_maps_have_no_seams() {
    let texels = (0..32 * 64).map(|i| if i == 700 { Vec3::splat(500.0) } else { Vec3::new(1.0, (i % 7) as f32, 0.5) });
    let sky = Sky { radiance: Vec3::ZERO, picture: Some(SkyPicture::new(64, 32, texels.collect())) };
    let seams = |seams: Seams| {
        let map = make(&Environment::sky(sky.clone()), &options(16, seams), &never_stops()).unwrap();
        map.levels.iter().map(measure::seam).collect::<Vec<_>>()
    };
    let untreated = seams(Seams::None);
    assert!(untreated.iter().all(|seam| *seam > 0.02), "{untreated:?}");
    for treatment in [Seams::Stretch, Seams::Warp, Seams::Lookup] {
        let treated = seams(treatment);
        assert!(treated.iter().zip(&untreated).all(|(a, b)| *a < 1e-5 * b), "{treatment:?}: {treated:?}");
    }
}

#[test]
fn threads_and_interruptions_leave_no_trace() {
    let world = World::new(crate::scene::cornell_box()).unwrap();
    let source = Environment::point(&world, Vec3::new(0.278, 0.3, 0.279), Paths::Count(4), 7);
    let options = options(8, Seams::Warp);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| make(&source, &options, &never_stops())).unwrap()
    };
    let one = on(1);
    assert!(one == on(3));
    assert!(one.levels[0].texels.iter().all(|texel| texel.is_finite() && texel.min_element() >= 0.0));
    assert!(one.rays > 6 * 64 * 4);
    let work = work(&source, &options);
    for steps in [1, work / 2, work - 6 * 64] {
        assert_eq!(make(&source, &options, &StopsAfter(steps.into())), None, "{steps} of {work}");
    }
}

/// Paths are traced until texels are as right as asked, and what is said of their error is true: against two
/// independent means of many paths, whose noise the mean of the products does not have.
#[test]
fn texels_have_the_error_that_is_said() {
    let world = World::new(crate::scene::cornell_box()).unwrap();
    let options = Options { levels: 1, ..options(8, Seams::None) };
    let map = |paths, seed| {
        let source = Environment::point(&world, Vec3::new(0.278, 0.3, 0.279), paths, seed);
        make(&source, &options, &never_stops()).unwrap()
    };
    let [a, b] = [1, 2].map(|seed| map(Paths::Count(4096), seed).levels.remove(0));
    let a_mean = a.mean();
    let rays = [0.1, 0.03].map(|accuracy| {
        let found = map(Paths::Accuracy(accuracy), 3);
        let texels = found.levels[0].texels.iter().zip(&a.texels).zip(&b.texels);
        let squares = texels.map(|((x, a), b)| f64::from((*x - *a).dot(*x - *b)) / 3.0).sum::<f64>() / 384.0;
        let error = squares.max(0.0).sqrt() / a_mean;
        println!("{accuracy}: error {error:.4}, said to be {:.4}, {} rays", found.error, found.rays);
        // What is asked for is relative to each texel's own radiance, where that is more than the mean.
        let texels = found.levels[0].texels.iter().zip(&a.texels).zip(&b.texels);
        let own = texels.map(|((x, a), b)| {
            let radiance = f64::from(a.element_sum() / 3.0).max(a_mean);
            f64::from((*x - *a).dot(*x - *b)) / (3.0 * radiance * radiance)
        });
        let own = (own.sum::<f64>() / 384.0).max(0.0).sqrt();
        assert!(own < 1.5 * f64::from(accuracy), "{own}");
        assert!((1.0 / 1.5..1.5).contains(&(f64::from(found.error) / error)), "{error}, said to be {}", found.error);
        found.rays
    });
    assert!(rays[1] > 2 * rays[0], "{rays:?}");
}

#[test]
fn shaders_shrink_only_what_was_made_for_it() {
    let map = |seams| {
        let options = Options { levels: 3, mapping: Mapping::Sqrt, ..options(16, seams) };
        make(&Environment::sky(Sky::constant(Vec3::ONE)), &options, &never_stops()).unwrap()
    };
    for language in Language::ALL {
        let text = lookup(&map(Seams::Lookup), language);
        for part in ["1.0 - exp2(level) / 16.0", "sqrt(roughness) * 2.0", "v.x, v.y, -v.z", "min(low + 1.0, 2.0)"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        for seams in [Seams::None, Seams::Stretch, Seams::Warp] {
            assert!(!lookup(&map(seams), language).contains("exp2"), "{seams:?}");
        }
    }
    let phong = CubeMap { options: Options { filter: Filter::Phong, ..map(Seams::None).options }, ..map(Seams::None) };
    assert!(lookup(&phong, Language::Glsl).contains("clamp(2.0 - 0.5 * log2(power), 0.0, 2.0)"));
}
