//! Rays of cameras against the formulas of their kinds.

mod lens;
mod projections;

use std::sync::Arc;

use glam::{DVec3, vec3};
use halfdome_kernel::Level;

use super::*;
use crate::scene::{FisheyeMapping, Lens, RayTable};

const POSE: CameraPose = CameraPose { eye: vec3(1.0, 2.0, 3.0), target: vec3(4.0, 6.0, 3.5), up: Vec3::Z, vfov: 30.0 };

/// Looks along -z with +x to the right.
const FRONT: CameraPose =
    CameraPose { eye: vec3(1.0, 2.0, 3.0), target: vec3(1.0, 2.0, -7.0), up: Vec3::Y, vfov: 90.0 };

fn pinhole(pose: &CameraPose, width: u32, height: u32) -> Camera {
    Camera::new(pose, &Optics::default(), width, height)
}

fn of(projection: Projection, width: u32, height: u32) -> Camera {
    Camera::new(&FRONT, &Optics { projection, ..Optics::default() }, width, height)
}

fn fisheye(mapping: FisheyeMapping, field_of_view: f32, width: u32, height: u32) -> Camera {
    of(Projection::Fisheye { mapping, field_of_view }, width, height)
}

fn ray(camera: &Camera, x: f32, y: f32) -> Ray {
    camera.central_ray(&FilmPoint::within(Vec2::new(x, y))).expect("the film sees something")
}

fn near(a: Vec3, b: Vec3) {
    assert!((a - b.normalize()).length() < 1e-6, "{a} {b}");
}

fn samples(count: usize) -> impl Iterator<Item = FilmSample> {
    (0..count).map(|i| {
        let point = Vec2::new(0.3 * i as f32, 20.0 - 0.17 * i as f32);
        let lens = Vec2::new((0.618 * i as f32).fract(), (0.414 * i as f32).fract());
        FilmSample { film: FilmPoint { pixel: (i as u32 % 30, i as u32 / 30), point }, lens }
    })
}

#[test]
fn corners_and_middle_of_the_film_are_where_the_field_of_view_puts_them() {
    let camera = pinhole(&FRONT, 200, 100);
    near(ray(&camera, 100.0, 50.0).direction, vec3(0.0, 0.0, -1.0));
    near(ray(&camera, 0.0, 0.0).direction, vec3(-2.0, 1.0, -1.0));
    near(ray(&camera, 200.0, 100.0).direction, vec3(2.0, -1.0, -1.0));
    assert_eq!(ray(&camera, 3.0, 4.0).origin, FRONT.eye);
}

#[test]
fn rays_in_lanes_are_those_one_by_one() {
    let lens = Lens { radius: 0.1, focus: 3.0, blades: 5, rotation: 10.0, ratio: 1.5 };
    for lens in [None, Some(lens)] {
        let camera = Camera::new(&POSE, &Optics { lens, ..Optics::default() }, 30, 20);
        let samples: Vec<FilmSample> = samples(150).collect();
        for isa in Level::ALL.into_iter().filter_map(Isa::new) {
            let mut rays = vec![Ray::new(Vec3::ZERO, Vec3::ZERO); samples.len()];
            camera.rays(isa, &samples, &mut rays);
            let one_by_one: Vec<Ray> = samples.iter().map(|sample| camera.ray(sample)).collect();
            assert_eq!(rays, one_by_one, "{isa:?}");
        }
    }
}

#[test]
fn the_matrix_takes_the_target_to_the_negative_z_axis() {
    let pose = CameraPose { target: vec3(4.0, 6.0, 3.0), ..POSE };
    let rows = pinhole(&pose, 10, 10).world_to_camera().unwrap();
    let point = [4.0, 6.0, 3.0, 1.0];
    let seen = rows.map(|row| (0..4).map(|i| row[i] * point[i]).sum::<f32>());
    for (value, expected) in seen.iter().zip([0.0, 0.0, -5.0, 1.0]) {
        assert!((value - expected).abs() < 1e-5, "{seen:?}");
    }
}

/// For every kind, turned and shifted: what a ray comes to is seen at the ray's point of the film, by that very ray.
#[test]
fn sights_undo_rays() {
    let fisheye = |mapping, field_of_view| Projection::Fisheye { mapping, field_of_view };
    for (projection, (width, height)) in [
        (Projection::Perspective, (30, 20)),
        (Projection::Orthographic { height: 5.0 }, (30, 20)),
        (Projection::Panorama { eye_distance: None }, (600, 300)),
        (Projection::Panorama { eye_distance: Some(0.5) }, (600, 600)),
        (fisheye(FisheyeMapping::Equidistant, 360.0), (300, 200)),
        (fisheye(FisheyeMapping::Equidistant, 120.0), (300, 200)),
        (fisheye(FisheyeMapping::Equisolid, 300.0), (200, 300)),
        (Projection::Cube, (600, 100)),
    ] {
        let has_shift = matches!(projection, Projection::Perspective | Projection::Orthographic { .. });
        let shift = if has_shift { Vec2::new(0.2, -0.4) } else { Vec2::ZERO };
        let clip = Clip { near: 0.5, far: 100.0 };
        let camera = Camera::new(&POSE, &Optics { projection, shift, clip, lens: None }, width, height);
        let mut seen = 0;
        for (x, y) in (0..height).step_by(7).flat_map(|y| (0..width).step_by(7).map(move |x| (x, y))) {
            let film = FilmPoint { pixel: (x, y), point: Vec2::new(x as f32 + 0.3, y as f32 + 0.6) };
            let Some(ray) = camera.central_ray(&film) else { continue };
            // The border of a whole sphere is a single direction.
            if matches!(camera.kind, Kind::Fisheye(_))
                && ray.direction.dot((POSE.target - POSE.eye).normalize()) < -0.9999
            {
                continue;
            }
            let view = u32::from(camera.views() == 2 && 2 * y >= height);
            let sight = camera.sight(ray.at(7.0), view).expect("it is before the camera");
            assert!((sight.film - film.point).length() < 1e-3, "{:?}: {} {}", camera.kind, sight.film, film.point);
            assert!((sight.ray.origin - ray.origin).length() < 1e-5);
            near(sight.ray.direction.normalize(), ray.direction);
            assert!((sight.ray.direction.length() - 7.0).abs() < 1e-4);
            assert!((sight.ray.t_min * 7.0 - ray.t_min).abs() < 1e-5, "the near plane is the same");
            assert!(camera.sight(ray.at(0.4), view).is_none(), "before the near plane");
            assert!(camera.sight(ray.at(300.0), view).is_none(), "beyond the far plane");
            seen += 1;
        }
        assert!(seen > 8);
        if has_shift {
            assert_eq!(camera.sight(ray(&camera, 15.0, 10.0).at(-7.0), 0), None, "behind");
        }
    }
}

/// Equal areas of an equisolid picture see equal solid angles; the root of a pixel's is what it is taken for.
#[test]
fn a_pixels_width_is_the_root_of_its_solid_angle() {
    let cube = of(Projection::Cube, 600, 100);
    let equisolid = fisheye(FisheyeMapping::Equisolid, 360.0, 200, 200);
    for (camera, (x, y)) in [(&cube, (350, 20)), (&cube, (450, 50)), (&cube, (99, 99)), (&equisolid, (30, 60))] {
        let direction = |dx: f32, dy: f32| {
            let point = Vec2::new(x as f32 + dx, y as f32 + dy);
            camera.central_ray(&FilmPoint { pixel: (x, y), point }).unwrap().direction
        };
        let (across, down) = (direction(1.0, 0.5) - direction(0.0, 0.5), direction(0.5, 1.0) - direction(0.5, 0.0));
        let expected = across.cross(down).length().sqrt();
        let width = camera.pixel_width(&FilmPoint::middle(x, y), 3.0) / 3.0;
        assert!((width / expected - 1.0).abs() < 1e-2, "{width} {expected}");
    }
    let orthographic = of(Projection::Orthographic { height: 5.0 }, 30, 20);
    assert_eq!([1.0, 9.0].map(|far| orthographic.pixel_width(&FilmPoint::middle(3, 4), far)), [0.25; 2]);
}

/// A shifted picture is part of a larger one: 100x50 of 300x150, whose field of view is three times as high in the
/// plane.
#[test]
fn a_shifted_picture_is_a_crop_of_a_larger_one() {
    for projection in [Projection::Perspective, Projection::Orthographic { height: 4.0 }] {
        let is_perspective = projection == Projection::Perspective;
        let large = if is_perspective { Projection::Perspective } else { Projection::Orthographic { height: 12.0 } };
        let wide = CameraPose { vfov: 2.0 * 3f32.atan().to_degrees(), ..FRONT };
        let large = Camera::new(&wide, &Optics { projection: large, ..Optics::default() }, 300, 150);
        // To the right by 0.7 of the longer side, 70 pixels, and up by 30.
        let optics = Optics { projection, shift: Vec2::new(0.7, 0.3), ..Optics::default() };
        let small = Camera::new(&FRONT, &optics, 100, 50);
        for (x, y) in [(0.0, 0.0), (12.5, 40.25), (100.0, 50.0)] {
            let (one, other) = (ray(&small, x, y), ray(&large, x + 100.0 + 70.0, y + 50.0 - 30.0));
            assert!((one.origin - other.origin).length() < 1e-5, "{one:?} {other:?}");
            assert!((one.direction - other.direction).length() < 1e-6, "{one:?} {other:?}");
        }
    }
}

#[test]
fn planes_clip_along_the_view_of_flat_pictures_and_from_the_eye_of_others() {
    let clip = Clip { near: 2.0, far: 5.0 };
    let with = |projection: Projection, lens: Option<Lens>, (x, y): (f32, f32)| {
        let camera = Camera::new(&FRONT, &Optics { projection, clip, lens, ..Optics::default() }, 200, 100);
        let film = FilmPoint::within(Vec2::new(x, y));
        (camera.ray(&FilmSample { film, lens: Vec2::new(0.9, 0.2) }), camera.central_ray(&film).unwrap())
    };
    let lens = Some(Lens { radius: 0.3, focus: 3.0, blades: 0, rotation: 0.0, ratio: 1.0 });
    for projection in [Projection::Perspective, Projection::Orthographic { height: 3.0 }] {
        for lens in [None, lens] {
            let (ray, central) = with(projection.clone(), lens, (20.0, 30.0));
            for ray in [ray, central] {
                for (t, plane) in [(ray.t_min, 2.0), (ray.t_max, 5.0)] {
                    let depth = FRONT.eye.z - ray.at(t).z;
                    assert!((depth - plane).abs() < 1e-5, "{depth}");
                }
            }
        }
    }
    for projection in [Projection::Panorama { eye_distance: None }, Projection::Cube] {
        let (ray, _) = with(projection, None, (20.0, 30.0));
        assert_eq!((ray.t_min, ray.t_max), (2.0, 5.0));
    }
}

/// Lines that are drawn over a picture do not cross borders that space does not have.
#[test]
fn lines_stay_within_what_belongs_together() {
    let cube = of(Projection::Cube, 60, 10);
    assert!(cube.joins(Vec2::new(1.0, 1.0), Vec2::new(9.0, 9.0)));
    assert!(!cube.joins(Vec2::new(9.0, 1.0), Vec2::new(11.0, 1.0)));
    let panorama = of(Projection::Panorama { eye_distance: None }, 60, 30);
    assert!(panorama.joins(Vec2::new(9.0, 1.0), Vec2::new(11.0, 1.0)));
    assert!(!panorama.joins(Vec2::new(1.0, 1.0), Vec2::new(59.0, 1.0)));
    assert!(pinhole(&FRONT, 60, 30).joins(Vec2::new(-99.0, 1.0), Vec2::new(99.0, 1.0)));
}
