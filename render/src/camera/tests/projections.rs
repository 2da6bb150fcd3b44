//! Panoramas, fisheyes, cubes, parallel rays and tables of rays.

use super::*;

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
