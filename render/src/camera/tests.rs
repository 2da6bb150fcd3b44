//! Rays of cameras against the formulas of their kinds.

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

#[test]
fn a_panorama_has_the_view_in_its_middle_and_up_at_its_top() {
    let camera = of(Projection::Panorama { eye_distance: None }, 360, 180);
    for (x, y, direction) in [
        (180.0, 90.0, Vec3::NEG_Z),
        (270.0, 90.0, Vec3::X),
        (90.0, 90.0, Vec3::NEG_X),
        (0.0, 90.0, Vec3::Z),
        (360.0, 90.0, Vec3::Z),
        (33.0, 0.0, Vec3::Y),
        (33.0, 180.0, Vec3::NEG_Y),
        (225.0, 90.0, vec3(1.0, 0.0, -1.0)),
        (180.0, 45.0, vec3(0.0, 1.0, -1.0)),
        (225.0, 90.0 - 2f32.sqrt().recip().atan().to_degrees(), vec3(1.0, 1.0, -1.0)),
    ] {
        let ray = ray(&camera, x, y);
        near(ray.direction, direction);
        assert_eq!(ray.origin, FRONT.eye);
    }
}

/// The rays of omni-directional stereo are tangents of a circle whose diameter is the distance of the eyes.
#[test]
fn two_eyes_are_beside_each_other_wherever_one_looks() {
    let camera = of(Projection::Panorama { eye_distance: Some(0.064) }, 360, 360);
    for x in [0.5, 45.5, 100.5, 180.0, 300.5] {
        for (y, side) in [(90.5, -1.0), (30.5, -1.0), (270.5, 1.0), (350.5, 1.0)] {
            let ray = ray(&camera, x, y);
            let offset = ray.origin - FRONT.eye;
            assert!((offset.length() - 0.032).abs() < 1e-6);
            assert!(offset.dot(ray.direction).abs() < 1e-7 && offset.y.abs() < 1e-7);
            let azimuth = (x - 180.0).to_radians();
            let right = vec3(azimuth.cos(), 0.0, azimuth.sin());
            assert!((offset - side * 0.032 * right).length() < 1e-6, "{offset} {right}");
        }
    }
    // A point far to the front is a little to the right for the left eye, and to the left for the right one.
    let point = FRONT.eye + vec3(0.0, 0.0, -2.0);
    let [left, right] = [0, 1].map(|view| camera.sight(point, view).unwrap().film);
    let turned = (0.032f32 / 2.0).asin().to_degrees();
    assert!((left - Vec2::new(180.0 + turned, 90.0)).length() < 1e-3, "{left}");
    assert!((right - Vec2::new(180.0 - turned, 270.0)).length() < 1e-3, "{right}");
}

#[test]
fn fisheyes_map_angles_to_radii() {
    for (mapping, fov) in [(FisheyeMapping::Equidistant, 180.0), (FisheyeMapping::Equisolid, 360.0)] {
        let camera = fisheye(mapping, fov, 300, 200);
        near(ray(&camera, 150.0, 100.0).direction, Vec3::NEG_Z);
        for degrees in [10.0f32, 45.0, 80.0, 90.0] {
            let part = match mapping {
                FisheyeMapping::Equidistant => degrees / 90.0,
                FisheyeMapping::Equisolid => (0.5 * degrees.to_radians()).sin(),
            };
            let (sin, cos) = degrees.to_radians().sin_cos();
            // Some places on the border round outwards.
            let radius = 100.0 * part - 1e-5;
            near(ray(&camera, 150.0 + radius, 100.0).direction, vec3(sin, 0.0, -cos));
            near(ray(&camera, 150.0, 100.0 - radius).direction, vec3(0.0, sin, -cos));
            let diagonal = radius * 0.5f32.sqrt();
            let right_down = vec3(sin * 0.5f32.sqrt(), -sin * 0.5f32.sqrt(), -cos);
            near(ray(&camera, 150.0 + diagonal, 100.0 + diagonal).direction, right_down);
        }
    }
    // The whole sphere: its border is behind.
    near(ray(&fisheye(FisheyeMapping::Equidistant, 360.0, 200, 200), 0.0, 100.0).direction, Vec3::Z);
}

#[test]
fn beyond_a_fisheyes_disc_there_is_nothing() {
    let camera = fisheye(FisheyeMapping::Equidistant, 90.0, 300, 200);
    assert!(camera.has_border() && !pinhole(&FRONT, 2, 2).has_border());
    let at = |x, y| camera.central_ray(&FilmPoint::within(Vec2::new(x, y)));
    assert!(at(50.0, 100.0).is_some() && at(49.9, 100.0).is_none() && at(1.0, 1.0).is_none());
    assert!(camera.sight(FRONT.eye + vec3(1.0, 0.0, -0.9), 0).is_none());
    assert!(camera.sight(FRONT.eye + vec3(0.9, 0.0, -1.0), 0).is_some());
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

/// Faces are in the order and orientation of `halfdome cubemap`, whose default axes take -z for the front.
#[test]
fn a_cube_is_a_strip_of_the_cube_maps_faces() {
    let camera = of(Projection::Cube, 60, 10);
    for (face, middle, right, down) in [
        (0, Vec3::X, Vec3::Z, Vec3::NEG_Y),
        (1, Vec3::NEG_X, Vec3::NEG_Z, Vec3::NEG_Y),
        (2, Vec3::Y, Vec3::X, Vec3::NEG_Z),
        (3, Vec3::NEG_Y, Vec3::X, Vec3::Z),
        (4, Vec3::NEG_Z, Vec3::X, Vec3::NEG_Y),
        (5, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y),
    ] {
        let at = |x: f32, y: f32| {
            let point = Vec2::new(10.0 * face as f32 + x, y);
            camera.central_ray(&FilmPoint { pixel: (10 * face + 5, 5), point }).unwrap().direction
        };
        near(at(5.0, 5.0), middle);
        near(at(10.0, 5.0), middle + right);
        near(at(7.5, 10.0), middle + 0.5 * right + down);
        // A filter may reach beyond the face, and sees what is there.
        near(at(11.0, 5.0), middle + 1.2 * right);
    }
}

#[test]
fn parallel_rays_start_in_the_plane_of_the_eye() {
    let camera = of(Projection::Orthographic { height: 4.0 }, 200, 100);
    for (x, y, aside) in
        [(100.0, 50.0, Vec3::ZERO), (0.0, 0.0, vec3(-4.0, 2.0, 0.0)), (150.0, 100.0, vec3(2.0, -2.0, 0.0))]
    {
        let ray = ray(&camera, x, y);
        assert_eq!(ray.direction, Vec3::NEG_Z);
        assert!((ray.origin - FRONT.eye - aside).length() < 1e-6, "{}", ray.origin);
    }
}

/// A shifted picture is part of a larger one: 100x50 of 300x150, whose field of view is three times as high in the plane.
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

/// The points of the film whose rays hit a small thing at depth `z` are those whose rays through some point of the lens
/// pass it: a disc of the diameter `A f / s · |z - s| / z`, with the focal length `f` in the units of the film.
#[test]
fn the_circle_of_confusion_has_the_size_of_a_thin_lens() {
    const SIDE: u32 = 1000;
    let (focus, aperture) = (4.0, 0.5);
    let point_at = |depth: f32| FRONT.eye + vec3(0.0, 0.0, -depth);
    for (is_parallel, depth) in [(false, 2.0), (false, 3.0), (false, 8.0), (false, 40.0), (true, 2.0), (true, 10.0)] {
        let height = 8.0;
        let projection = if is_parallel { Projection::Orthographic { height } } else { Projection::Perspective };
        let lens = Lens { radius: 0.5 * aperture, focus, blades: 0, rotation: 0.0, ratio: 1.0 };
        let camera = Camera::new(&FRONT, &Optics { projection, lens: Some(lens), ..Optics::default() }, SIDE, SIDE);
        // In parts of the film's height the focal length is 1 / (2 tan(v/2)), here 1/2. Parallel rays make a disc of
        // A |z - s| / s, of the height that is seen.
        let blur: f32 = (depth - focus) / focus;
        let expected = if is_parallel { aperture * blur.abs() / height } else { 0.5 * aperture * blur.abs() / depth };
        let (mut hits, mut reach, steps) = (0, 0.0f32, 600);
        let extent = 1.5 * expected * SIDE as f32;
        // From every point of the film around, whether some ray passes: where the lens would have to be crossed.
        for (i, j) in (0..steps).flat_map(|j| (0..steps).map(move |i| (i, j))) {
            let at = |k: i32| ((k as f32 + 0.5) / steps as f32 - 0.5) * extent;
            let film = FilmPoint::within(Vec2::new(500.0 + at(i), 500.0 + at(j)));
            // Rays of a point of the film meet in the plane that is sharp.
            let sharp = {
                let central = camera.central_ray(&film).unwrap();
                central.at(focus / -central.direction.z)
            };
            let way = point_at(depth) - sharp;
            let crossing = sharp + way * ((FRONT.eye.z - sharp.z) / way.z);
            let middle = if is_parallel { camera.central_ray(&film).unwrap().origin } else { FRONT.eye };
            if (crossing - middle).length() <= 0.5 * aperture {
                hits += 1;
                reach = reach.max(at(i).hypot(at(j)));
            }
        }
        let area = hits as f32 * (extent / steps as f32).powi(2);
        let diameter = 2.0 * (area / std::f32::consts::PI).sqrt() / SIDE as f32;
        assert!((diameter / expected - 1.0).abs() < 0.01, "{depth}: {diameter} {expected}");
        assert!((2.0 * reach / SIDE as f32 / expected - 1.0).abs() < 0.01);
    }
}

/// The rays of a sample do go from the lens to where its central ray meets the sharp plane, and fill the lens evenly.
#[test]
fn the_rays_of_a_lens_meet_in_the_sharp_plane() {
    let lens = Lens { radius: 0.25, focus: 4.0, blades: 0, rotation: 0.0, ratio: 1.0 };
    for projection in [Projection::Perspective, Projection::Orthographic { height: 3.0 }] {
        let camera = Camera::new(&POSE, &Optics { projection, lens: Some(lens), ..Optics::default() }, 30, 20);
        let forward = (POSE.target - POSE.eye).normalize();
        let film = FilmPoint::within(Vec2::new(22.2, 3.4));
        let central = camera.central_ray(&film).unwrap();
        let sharp = central.at(4.0 / central.direction.dot(forward));
        let mut squares = 0.0;
        for i in 0..1024 {
            let u = Vec2::new((i % 32) as f32 + 0.5, (i / 32) as f32 + 0.5) / 32.0;
            let ray = camera.ray(&FilmSample { film, lens: u });
            let offset = ray.origin - central.origin;
            assert!(offset.dot(forward).abs() < 1e-6 && offset.length() <= 0.25);
            squares += offset.length_squared() / 1024.0;
            assert!((ray.direction.length() - 1.0).abs() < 1e-6);
            assert!((sharp - ray.origin).normalize().cross(ray.direction).length() < 1e-6);
        }
        // Over a disc of radius R the mean square of the distance is R²/2.
        assert!((squares / (0.5 * 0.25 * 0.25) - 1.0).abs() < 0.02, "{squares}");
    }
}

#[test]
fn a_table_gives_each_pixel_its_ray() {
    let rays: Vec<[Vec3; 2]> = (0..6).map(|i| [vec3(i as f32, 0.0, 0.0), Vec3::Y]).collect();
    let table = |width, height| {
        let rays = Arc::new(RayTable { width: 3, height: 2, rays: rays.clone() });
        of(Projection::Rays(rays), width, height)
    };
    let camera = table(3, 2);
    for (x, y) in [(0, 0), (2, 0), (1, 1)] {
        // A filter may place samples beyond the pixel.
        let film = FilmPoint { pixel: (x, y), point: Vec2::new(-5.0, 9.0) };
        assert_eq!(camera.central_ray(&film), Some(Ray::new(vec3((3 * y + x) as f32, 0.0, 0.0), Vec3::Y)));
    }
    assert_eq!(camera.pixel_width(&FilmPoint::middle(0, 0), 1.0), 3f32.sqrt(), "one beside, three below");
    assert_eq!(camera.world_to_camera(), None);
    assert_eq!(camera.sight(Vec3::ZERO, 0), None);
    // A smaller film takes those in the middles of its pixels.
    assert_eq!(table(1, 1).central_ray(&FilmPoint::middle(0, 0)).unwrap().origin.x, 4.0);
    assert_eq!(table(6, 4).central_ray(&FilmPoint::middle(5, 3)).unwrap().origin.x, 5.0);
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

/// A point on the seam of a cube is on one face, and directions straight up are on the face above.
#[test]
fn every_direction_is_on_some_face() {
    let cube = of(Projection::Cube, 60, 10);
    for i in 0..200 {
        let turn = 0.7 * f64::from(i);
        let direction = DVec3::new(turn.cos(), (0.37 * turn).sin(), turn.sin()).as_vec3();
        let film = cube.sight(FRONT.eye + 3.0 * direction, 0).unwrap().film;
        assert!((0.0..=60.0).contains(&film.x) && (0.0..=10.0).contains(&film.y), "{film}");
    }
    assert_eq!(cube.sight(FRONT.eye + Vec3::Y, 0).unwrap().film, Vec2::new(25.0, 5.0));
}
