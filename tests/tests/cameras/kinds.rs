//! Pictures by the kinds of cameras.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{DVec3, Vec3};
use halfdome::cubemap::{self, Axes, Environment, Face, Filter, Mapping, Options, Seams};
use halfdome::driver;
use halfdome::film::Picture;
use halfdome::scene::{Clip, FisheyeMapping, Optics, Projection, RayTable, Scene, Sky, SkyPicture, cornell_box};
use halfdome::settings::{Integrator, Settings};
use halfdome::world::World;
use halfdome_tests::render::{NeverStops, material, mesh, pixels, quad, render};

use super::{FRONT, disc, glowing};

fn settings(width: u32, height: u32) -> Settings {
    Settings { width, height, spp: 16, ..Settings::default() }
}

fn of(projection: Projection) -> Optics {
    Optics { projection, ..Optics::default() }
}

fn sum(picture: &Picture) -> f64 {
    pixels(picture).iter().map(|pixel| pixel.x).sum()
}

fn every_kind() -> [(Projection, (u32, u32)); 8] {
    let rays = (0..24 * 24).map(|i| {
        let (x, y) = ((i % 24) as f32 / 24.0 - 0.5, 0.5 - (i / 24) as f32 / 24.0);
        [Vec3::new(0.278, 0.273, -0.8), Vec3::new(-x, y, 1.5).normalize()]
    });
    let table = RayTable { width: 24, height: 24, rays: rays.collect() };
    [
        (Projection::Perspective, (24, 24)),
        (Projection::Orthographic { height: 0.6 }, (24, 24)),
        (Projection::Panorama { eye_distance: None }, (64, 32)),
        (Projection::Panorama { eye_distance: Some(0.06) }, (64, 64)),
        (Projection::Fisheye { mapping: FisheyeMapping::Equidistant, field_of_view: 180.0 }, (32, 24)),
        (Projection::Fisheye { mapping: FisheyeMapping::Equisolid, field_of_view: 360.0 }, (24, 32)),
        (Projection::Cube, (96, 16)),
        (Projection::Rays(Arc::new(table)), (24, 24)),
    ]
}

/// A panorama of the sky is the sky's picture.
#[test]
fn a_panorama_of_a_sky_is_its_picture() {
    let (width, height) = (32, 16);
    let texels: Vec<Vec3> =
        (0..width * height).map(|i| Vec3::new(1.0 + (i % width) as f32, 1.0 + (i / width) as f32, 1.0)).collect();
    let sky = Sky { radiance: Vec3::ZERO, picture: Some(SkyPicture::new(width, height, texels.clone())) };
    let projection = Projection::Panorama { eye_distance: None };
    let scene = Scene { camera: Some(FRONT), optics: of(projection), sky, ..Scene::default() };
    for (pixel, texel) in pixels(&render(&scene, &settings(width, height))).iter().zip(texels) {
        // The middle of a pixel's sample lies within the texel; a bilinear sky reaches into the next.
        assert!((pixel.x - f64::from(texel.x)).abs() < 1.0 || texel.x < 2.0 || texel.x > 31.0, "{pixel} {texel}");
        assert!((pixel.y - f64::from(texel.y)).abs() < 1.0, "{pixel} {texel}");
    }
}

/// A far disc covers as much of each picture as its formula says.
#[test]
fn a_disc_has_its_solid_angle_in_every_picture() {
    // A cone of half angle a around the view sees 2π (1 - cos a).
    let half_angle: f64 = 0.2;
    let disc = disc(Vec3::new(0.0, 0.0, -4.0), 4.0 * half_angle.tan() as f32, 256);
    let area = |projection: Projection, width: u32, height: u32| {
        sum(&render(&glowing(&disc, of(projection)), &settings(width, height)))
    };
    let near = |found: f64, expected: f64, what: &str| {
        assert!((found / expected - 1.0).abs() < 0.01, "{what}: {found} {expected}");
    };
    near(area(Projection::Perspective, 100, 100), PI * (50.0 * half_angle.tan()).powi(2), "perspective");
    near(area(Projection::Cube, 600, 100), PI * (50.0 * half_angle.tan()).powi(2), "cube");
    let parallel = Projection::Orthographic { height: 4.0 };
    near(area(parallel, 100, 100), PI * (25.0 * 4.0 * half_angle.tan()).powi(2), "orthographic");
    let fisheye = |mapping, field_of_view| Projection::Fisheye { mapping, field_of_view };
    let equidistant = fisheye(FisheyeMapping::Equidistant, 180.0);
    near(area(equidistant, 120, 100), PI * (50.0 * half_angle / FRAC_PI_2).powi(2), "equidistant");
    // Of π 50² pixels, as many as the cone has of the sphere.
    let equisolid = fisheye(FisheyeMapping::Equisolid, 360.0);
    near(area(equisolid, 200, 200), PI * 100.0f64.powi(2) * 0.5 * (1.0 - half_angle.cos()), "equisolid");
    // Pixels at the elevation e have the solid angle of cos e; near the horizon of about 1.
    let panorama: f64 = area(Projection::Panorama { eye_distance: None }, 360, 180);
    let steps = 10_000;
    let expected: f64 = (0..steps)
        .map(|i| {
            let elevation = ((f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0) * half_angle;
            // cos a = cos e cos φ on the cone's border.
            2.0 * (half_angle.cos() / elevation.cos()).min(1.0).acos() * 2.0 * half_angle / f64::from(steps)
        })
        .sum();
    near(panorama, expected * (360.0 / (2.0 * PI)).powi(2), "panorama");
}

/// Beyond the disc alpha is 0 and there is no light; on its border alpha is the part that is covered.
#[test]
fn a_fisheye_has_alpha() {
    let projection = Projection::Fisheye { mapping: FisheyeMapping::Equidistant, field_of_view: 120.0 };
    let sky = Sky { radiance: Vec3::splat(0.5), picture: None };
    let scene = Scene { camera: Some(FRONT), optics: of(projection), sky, ..Scene::default() };
    let settings = Settings { spp: 64, aov: true, ..settings(60, 40) };
    let picture = render(&scene, &settings);
    let alpha = &picture.channel("A").expect("the film has a border").values;
    let sum: f64 = alpha.iter().map(|&alpha| f64::from(alpha)).sum();
    assert!((sum / (PI * 400.0) - 1.0).abs() < 2e-3, "{sum}");
    for (i, (&alpha, pixel)) in alpha.iter().zip(pixels(&picture)).enumerate() {
        let (x, y) = ((i % 60) as f32 + 0.5 - 30.0, (i / 60) as f32 + 0.5 - 20.0);
        assert!((pixel.x - 0.5 * f64::from(alpha)).abs() < 1e-6);
        assert!(x.hypot(y) < 20.8 || alpha == 0.0);
        assert!(x.hypot(y) > 19.2 || alpha == 1.0);
    }
    let all: u64 = 60 * 40;
    // With an integrator that traces camera rays alone.
    let world = World::new(scene.clone()).unwrap();
    let normals = Settings { integrator: Integrator::named("normals").unwrap(), ..settings };
    let rays = driver::render(&world, &normals, &NeverStops).rays;
    assert!(((rays as f64) / 64.0 - sum).abs() < 1.0 && rays < 64 * all, "no rays beyond the disc");
    let flat = Scene { optics: Optics::default(), ..scene };
    assert!(render(&flat, &Settings { width: 4, height: 4, spp: 1, ..Settings::default() }).channel("A").is_none());
}

/// What lies beyond the planes is not seen.
#[test]
fn planes_cut_off() {
    let wall = |z: f32| {
        let at = |x: f32, y: f32| Vec3::new(100.0 * x, 100.0 * y, z);
        quad([at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)])
    };
    let seen = |projection: Projection, near: f32, far: f32, size: (u32, u32)| {
        let optics = Optics { clip: Clip { near, far }, ..of(projection) };
        pixels(&render(&glowing(&wall(-2.0), optics), &settings(size.0, size.1)))
    };
    // Along the view all of the wall is at the distance 2 ...
    for projection in [Projection::Perspective, Projection::Orthographic { height: 3.0 }] {
        let lit =
            |near, far| seen(projection.clone(), near, far, (16, 16)).iter().filter(|pixel| pixel.x > 0.0).count();
        assert_eq!([lit(0.0, f32::INFINITY), lit(1.99, 2.01), lit(2.01, 9.0), lit(0.0, 1.99)], [256, 256, 0, 0]);
    }
    // ... and from the eye 2 / cos of the angle: a far plane of 4 leaves 60 degrees of a fisheye's 90.
    let projection = Projection::Fisheye { mapping: FisheyeMapping::Equidistant, field_of_view: 180.0 };
    let lit: f64 = seen(projection, 0.0, 4.0, (90, 90)).iter().map(|pixel| pixel.x).sum();
    assert!((lit / (PI * 30.0f64.powi(2)) - 1.0).abs() < 0.01, "{lit}");
}

/// A picture of the middle of a larger one's right half, by a shift.
#[test]
fn a_shifted_picture_is_a_crop() {
    let mut scene = cornell_box();
    let camera = scene.camera.as_mut().unwrap();
    let half = (0.5 * camera.vfov.to_radians()).tan();
    let settings = |width, height| Settings {
        integrator: Integrator::named("albedo").unwrap(),
        spp: 1,
        ..settings(width, height)
    };
    let large = pixels(&render(&scene, &settings(80, 80)));
    scene.camera.as_mut().unwrap().vfov = 2.0 * (0.5 * half).atan().to_degrees();
    // 40 of 80 pixels, from 30 to 70 across and 10 to 50 down: by 10 to the right, 10 up.
    scene.optics.shift = glam::Vec2::new(0.25, 0.25);
    let small = pixels(&render(&scene, &settings(40, 40)));
    let differing = (0..1600).filter(|i| {
        let (x, y) = (i % 40, i / 40);
        small[*i] != large[(y + 10) * 80 + x + 30]
    });
    // The place in a pixel is another random number, which edges show.
    assert!(differing.count() < 120);
}

/// Every kind gives every integrator rays, and the light that it sees does not depend on the integrator.
#[test]
fn every_integrator_takes_every_kind() {
    for (projection, (width, height)) in every_kind() {
        let scene = Scene { optics: of(projection.clone()), ..cornell_box() };
        let mean = |name: &str, spp: u32| {
            let integrator = Integrator::named(name).unwrap();
            let picture = render(&scene, &Settings { integrator, spp, ..settings(width, height) });
            pixels(&picture).iter().sum::<DVec3>() / f64::from(width * height)
        };
        for name in ["direct", "montecarlo", "ao", "heat", "heat-lights", "normals", "albedo", "flat"] {
            assert!(mean(name, 1).is_finite() && mean(name, 1) != DVec3::ZERO, "{projection:?} {name}");
        }
        let (path, cached) = (mean("path", 64), mean("cached", 64));
        assert!(((cached - path) / path).abs().max_element() < 0.05, "{} {path} {cached}", projection.name());
    }
}

/// A file of rays of a pinhole camera gives its picture, but for the places within the pixels.
#[test]
fn a_table_of_a_pinholes_rays_gives_its_picture() {
    let scene = cornell_box();
    let pose = scene.camera.unwrap();
    let rays = (0..400).map(|i| {
        let (x, y) = (f64::from(i % 20) + 0.5, f64::from(i / 20) + 0.5);
        [pose.eye, halfdome_tests::render::view(&pose, (20, 20), x, y).as_vec3()]
    });
    let rays = RayTable { width: 20, height: 20, rays: rays.collect() };
    let table = Scene { optics: of(Projection::Rays(Arc::new(rays))), ..scene.clone() };
    let settings = Settings { integrator: Integrator::named("albedo").unwrap(), spp: 1, ..settings(20, 20) };
    let [one, other] = [&scene, &table].map(|scene| render(scene, &settings));
    assert!(one.metadata.world_to_camera.is_some() && other.metadata.world_to_camera.is_none());
    assert!(one.metadata.scene_hash != other.metadata.scene_hash);
    let differing = pixels(&one).iter().zip(pixels(&other)).filter(|(a, b)| *a != b).count();
    assert!(differing < 60, "{differing}");
    // Samples of a pixel differ in nothing but their light.
    let twice = render(&table, &Settings { spp: 8, ..settings });
    assert_eq!(pixels(&twice), pixels(&other));
}

/// The faces of a cube picture are those of a cube map from the same point with Bevy's axes.
#[test]
fn a_cube_has_the_faces_of_a_cube_map() {
    const SIDE: usize = 16;
    // A wall of another colour on each side, a triangle, so that turned and mirrored faces differ.
    let wall = |number: usize| {
        let (axis, side) = (number / 2, if number.is_multiple_of(2) { 1.0 } else { -1.0 });
        let corner = |(a, b): (f32, f32)| {
            let mut corner = [0.0; 3];
            (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (side, a, b);
            Vec3::from_array(corner)
        };
        mesh(&[[(-1.0, -1.0), (1.0, -1.0), (1.0, 0.5)].map(corner)], number)
    };
    let colors = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE - Vec3::X, Vec3::ONE - Vec3::Y, Vec3::ONE - Vec3::Z];
    let glow = |color: &Vec3| {
        let mut glow = material(Vec3::ZERO, *color);
        glow.emits_both_sides = true;
        glow
    };
    let scene = Scene {
        meshes: (0..6).map(wall).collect(),
        materials: colors.iter().map(glow).collect(),
        camera: Some(FRONT),
        optics: of(Projection::Cube),
        ..Scene::default()
    };
    let strip = pixels(&render(&scene, &settings(6 * SIDE as u32, SIDE as u32)));
    let world = World::new(scene).unwrap();
    let options = Options {
        size: SIDE as u32,
        levels: 1,
        seams: Seams::None,
        filter: Filter::Ggx,
        mapping: Mapping::Linear,
        axes: Axes::Bevy,
        diffuse: None,
        seed: 0,
    };
    let map =
        cubemap::make(&Environment::point(&world, Vec3::ZERO, cubemap::Paths::Count(16), 0), &options, &NeverStops)
            .unwrap();
    for (number, face) in Face::ALL.into_iter().enumerate() {
        let differing = map.levels[0].face(face).iter().enumerate().filter(|(i, texel)| {
            let pixel = strip[i / SIDE * 6 * SIDE + number * SIDE + i % SIDE];
            (pixel - texel.as_dvec3()).abs().max_element() > 0.4
        });
        // Those on the triangle's border.
        assert!(differing.count() < 12, "{face:?}");
    }
}
