//! Whole scenes: transforms, cameras, shapes and objects.

mod looks;
mod reading;

use std::f32::consts::PI;
use std::path::Path;

use glam::{Vec2, Vec3};

use super::*;
use crate::scene::{Disk, Overrides, Projection};
use crate::settings::Settings;

/// A triangle, counter-clockwise in its own coordinates, so that its normal is +z.
const TRIANGLE: &str = r#"Shape "trianglemesh" "point3 P" [ 0 0 0  1 0 0  0 1 0 ]"#;

fn parse(text: &str) -> Result<Scene, SceneError> {
    read(&Disk, Path::new("a.pbrt"), text.as_bytes(), Sharing::Always)
}

fn scene(text: &str) -> Scene {
    parse(text).unwrap()
}

fn close(found: Vec3, expected: [f32; 3]) {
    assert!((found - Vec3::from(expected)).abs().max_element() < 1e-5, "{found} is not {expected:?}");
}

#[test]
fn transforms_follow_one_another_and_attributes_end() {
    let scene = scene(&format!(
        "Scale -1 1 1\nLookAt 0 0 5  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin
        AttributeBegin\nTranslate 10 0 0\nRotate 90 0 0 1\nScale 2 2 2\n{TRIANGLE}\nAttributeEnd
        TransformBegin\nTransform [ 1 0 0 0  0 1 0 0  0 0 1 0  0 0 7 1 ]\nCoordinateSystem \"up\"\nTransformEnd
        CoordSysTransform \"up\"\nConcatTransform [ 0 1 0 0  -1 0 0 0  0 0 1 0  0 0 0 1 ]\n{TRIANGLE}"
    ));
    let corners = |mesh: usize| scene.meshes[mesh].positions.clone();
    // Scaled first, turned then, moved last.
    for (found, expected) in corners(0).into_iter().zip([[10.0, 0.0, 0.0], [10.0, 2.0, 0.0], [8.0, 0.0, 0.0]]) {
        close(found, expected);
    }
    for (found, expected) in corners(1).into_iter().zip([[0.0, 0.0, 7.0], [0.0, 1.0, 7.0], [-1.0, 0.0, 7.0]]) {
        close(found, expected);
    }
    let camera = scene.camera.unwrap();
    close(camera.eye, [0.0, 0.0, 5.0]);
    close((camera.target - camera.eye).normalize(), [0.0, 0.0, -1.0]);
}

#[test]
fn left_handed_worlds_are_mirrored_and_fronts_stay_fronts() {
    let scene = scene(&format!("LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\"\nWorldBegin\n{TRIANGLE}"));
    let [a, b, c] = scene.meshes[0].corners(0);
    close((b - a).cross(c - a), [0.0, 0.0, 1.0]);
    let camera = scene.camera.unwrap();
    let right = (camera.target - camera.eye).cross(camera.up).normalize();
    // pbrt's camera has +x on the right, and a corner of the triangle is at x = 1.
    assert!(scene.meshes[0].positions.iter().any(|position| (position.dot(right) - 1.0).abs() < 1e-6));
    assert!(scene.meshes[0].positions.iter().all(|position| position.dot(right) > -1e-6));
}

#[test]
fn cameras_have_the_shorter_side_s_angle_windows_and_lenses() {
    let camera = |film: &str, camera: &str| {
        scene(&format!("Film \"rgb\" {film}\nLookAt 0 0 -5 0 0 0 0 1 0\n{camera}\nWorldBegin\n{TRIANGLE}"))
    };
    let wide =
        camera(r#""integer xresolution" 400 "integer yresolution" 200"#, r#"Camera "perspective" "float fov" 60"#);
    assert!((wide.camera.unwrap().vfov - 60.0).abs() < 1e-4);
    assert_eq!((wide.film_size, wide.camera_aspect), (Some((400, 200)), Some(2.0)));
    let high =
        camera(r#""integer xresolution" 200 "integer yresolution" 400"#, r#"Camera "perspective" "float fov" 60"#);
    let expected = 2.0 * (2.0 * 30.0_f32.to_radians().tan()).atan().to_degrees();
    assert!((high.camera.unwrap().vfov - expected).abs() < 1e-3);
    let lens =
        camera("", r#"Camera "perspective" "float lensradius" 0.5 "float focaldistance" 4"#).optics.lens.unwrap();
    assert!((lens.radius - 0.5).abs() < 1e-6 && (lens.focus - 4.0).abs() < 1e-5, "{lens:?}");
    let window = camera("", r#"Camera "orthographic" "float screenwindow" [ -1 3 -2 2 ]"#);
    assert!(matches!(window.optics.projection, Projection::Orthographic { height } if (height - 4.0).abs() < 1e-5));
    assert_eq!(window.optics.shift, Vec2::new(0.25, 0.0));
}

#[test]
fn shapes_have_their_areas_and_fronts() {
    let area = |shape: &str| {
        let scene = scene(&format!("WorldBegin\n{shape}"));
        let mesh = &scene.meshes[0];
        let outwards = (0..mesh.triangles.len()).all(|face| {
            let [a, b, c] = mesh.corners(face);
            (b - a).cross(c - a).dot(a + b + c) >= -1e-4
        });
        (round::area(mesh) as f32, outwards)
    };
    for (shape, expected) in [
        (r#"Shape "sphere" "float radius" 2"#, 16.0 * PI),
        (r#"Shape "sphere" "float radius" 1 "float zmin" 0"#, 2.0 * PI),
        (r#"Shape "disk" "float radius" 2 "float innerradius" 1 "float height" 1"#, 3.0 * PI),
        (r#"Shape "cylinder" "float radius" 1 "float zmin" 0 "float zmax" 3"#, 6.0 * PI),
        (r#"Shape "bilinearmesh" "point3 P" [ 0 0 1  2 0 1  0 3 1  2 3 1 ]"#, 6.0),
    ] {
        let (found, outwards) = area(shape);
        assert!((found / expected - 1.0).abs() < 1e-4, "{shape}: {found}, not {expected}");
        assert!(outwards, "{shape}");
    }
    let turned = scene(&format!("WorldBegin\nReverseOrientation\n{TRIANGLE}"));
    let [a, b, c] = turned.meshes[0].corners(0);
    close((b - a).cross(c - a), [0.0, 0.0, -1.0]);
}

#[test]
fn objects_are_instances_and_keep_their_own_coordinates() {
    let scene = scene(&format!(
        "LookAt 0 0 -5 0 0 0 0 1 0\nCamera \"perspective\"\nWorldBegin
        ObjectBegin \"leaf\"\nTranslate 1 0 0\nAreaLightSource \"diffuse\"\n{TRIANGLE}\nObjectEnd
        ObjectInstance \"leaf\"\nAttributeBegin\nTranslate 0 5 0\nObjectInstance \"leaf\"\nAttributeEnd\n{TRIANGLE}"
    ));
    assert_eq!((scene.objects.len(), scene.instances.len(), scene.meshes.len()), (1, 2, 2));
    let leaf = scene.meshes.iter().find(|mesh| mesh.object == Some(0)).unwrap();
    close(leaf.positions[0], [1.0, 0.0, 0.0]);
    // The world is mirrored, so both instances mirror.
    close(scene.instances[1].to_world.transform_point3(leaf.positions[0]), [-1.0, 5.0, 0.0]);
    assert!(scene.warnings.iter().any(|warning| warning.contains("area lights in objects do not emit")));
    let copies = read(
        &Disk,
        Path::new("a.pbrt"),
        b"WorldBegin\nObjectBegin \"o\"\nShape \"sphere\"\nObjectEnd\nObjectInstance \"o\"\nObjectInstance \"o\"",
        Sharing::Never,
    );
    assert_eq!(copies.unwrap().meshes.len(), 2);
}

#[test]
fn the_sampler_says_how_many_samples_unless_an_option_does() {
    let spp = |sampler: &str| {
        let mut scene = scene(&format!("{sampler}\nWorldBegin\n{TRIANGLE}"));
        let [file, option] = [None, Some(3)].map(|spp| Overrides { spp, ..Overrides::default() });
        [file, option].map(|overrides| overrides.apply(&mut scene).unwrap().spp)
    };
    assert_eq!(spp("Sampler \"zsobol\" \"integer pixelsamples\" 8 \"string randomization\" \"owen\""), [8, 3]);
    assert_eq!(spp("Sampler \"stratified\" \"integer xsamples\" 5"), [20, 3]);
    assert_eq!(spp("Sampler \"halton\""), [16, 3]);
    assert_eq!(spp(""), [Settings::default().spp, 3]);
}

#[test]
fn defaults_of_attributes_hold_in_the_world_and_transforms_do_not() {
    let scene = scene("Attribute \"shape\" \"float radius\" 3\nScale 5 5 5\nWorldBegin\nShape \"disk\"");
    let radius = scene.meshes[0].positions.iter().map(|position| position.length()).fold(0.0, f32::max);
    assert!((radius - 3.0).abs() < 0.01, "{radius}");
}
