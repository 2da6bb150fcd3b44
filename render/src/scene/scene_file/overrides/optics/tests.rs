use std::fs;

use super::*;
use crate::scene::{FisheyeMapping, Mesh};

const MODEL: CameraPose =
    CameraPose { eye: Vec3::new(0.0, 0.0, 5.0), target: Vec3::new(0.0, 0.0, 4.0), up: Vec3::Y, vfov: 40.0 };

/// A triangle with a camera, 300 by 200 pixels, after the options are applied.
fn applied(options: Overrides, camera: Option<CameraPose>) -> Result<Scene, String> {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], ..Default::default() };
    let mut scene = Scene { meshes: vec![mesh], materials: vec![Default::default()], camera, ..Scene::default() };
    let options = Overrides { width: options.width.or(Some(300)), height: options.height.or(Some(200)), ..options };
    options.apply(&mut scene).map_err(|conflict| conflict.to_string())?;
    Ok(scene)
}

fn of(camera: CameraOverrides) -> Overrides {
    Overrides { camera, ..Default::default() }
}

fn optics(camera: CameraOverrides) -> Optics {
    applied(of(camera), Some(MODEL)).unwrap().optics
}

fn refused(options: Overrides, parts: &[&str]) {
    let error = applied(options, Some(MODEL)).unwrap_err();
    assert!(parts.iter().all(|part| error.contains(part)), "{error}");
}

fn kind(kind: CameraKind) -> CameraOverrides {
    CameraOverrides { kind: Some(kind), ..Default::default() }
}

#[test]
fn without_options_the_camera_is_a_pinhole() {
    assert_eq!(optics(CameraOverrides::default()), Optics::default());
}

/// The vertical field of view of a focal length, by Blender's rules for the sensor's fit; the picture is 300 by 200.
#[test]
fn focal_length_and_sensor_make_a_field_of_view() {
    let vfov = |camera: CameraOverrides, size: (u32, u32)| {
        let options = Overrides { width: Some(size.0), height: Some(size.1), ..of(camera) };
        applied(options, Some(MODEL)).unwrap().camera.unwrap().vfov
    };
    let angle = |half_height: f32| 2.0 * half_height.atan().to_degrees();
    let focal = CameraOverrides { focal_length: Some(50.0), ..Default::default() };
    let near = |a: f32, b: f32| assert!((a - b).abs() < 1e-4, "{a} {b}");
    near(vfov(focal.clone(), (300, 200)), angle(12.0 / 50.0));
    // The longer side of a high picture is its height.
    near(vfov(focal.clone(), (200, 300)), angle(18.0 / 50.0));
    let fit = |sensor_fit: SensorFit| CameraOverrides { sensor_fit: Some(sensor_fit), ..focal.clone() };
    near(vfov(fit(SensorFit::Horizontal), (200, 300)), angle(27.0 / 50.0));
    near(vfov(fit(SensorFit::Vertical), (200, 300)), angle(12.0 / 50.0));
    let small = CameraOverrides { sensor: Some(Vec2::new(6.0, 3.0)), ..fit(SensorFit::Vertical) };
    near(vfov(small, (300, 200)), angle(1.5 / 50.0));
}

#[test]
fn an_f_number_is_the_focal_length_over_the_aperture() {
    let by_number =
        CameraOverrides { focal_length: Some(50.0), f_number: Some(2.0), focus: Some(3.0), ..Default::default() };
    let lens = optics(by_number.clone()).lens.unwrap();
    assert!((lens.radius - 0.0125).abs() < 1e-7, "25 mm across, in metres");
    assert_eq!((lens.focus, lens.blades, lens.ratio), (3.0, 0, 1.0));
    // From the field of view: half of 24 mm over the tangent of its half.
    let by_vfov = CameraOverrides { focal_length: None, ..by_number.clone() };
    let expected = 0.5 * (12.0 / 20f32.to_radians().tan() / 2.0) / 1000.0;
    assert!((optics(by_vfov).lens.unwrap().radius - expected).abs() < 1e-7);
    // In a model in centimetres ten millimetres are a unit.
    let centimetres = CameraOverrides { mm_per_unit: Some(10.0), ..by_number };
    assert!((optics(centimetres).lens.unwrap().radius - 1.25).abs() < 1e-6);
    let lens = CameraOverrides {
        aperture: Some(8.0),
        focus_at: Some(Vec3::new(9.0, 9.0, 2.0)),
        blades: Some(6),
        blade_rotation: Some(15.0),
        anamorphic: Some(2.0),
        ..Default::default()
    };
    let expected = Lens { radius: 0.004, focus: 3.0, blades: 6, rotation: 15.0, ratio: 2.0 };
    assert_eq!(optics(lens).lens, Some(expected));
    let pinhole = CameraOverrides { aperture: Some(0.0), focus: Some(1.0), ..Default::default() };
    assert_eq!(optics(pinhole), Optics::default());
}

#[test]
fn a_target_that_is_given_is_what_a_lens_and_parallel_rays_are_made_for() {
    let new = |camera: CameraOverrides| Overrides {
        eye: Some(Vec3::ZERO),
        target: Some(Vec3::new(0.0, 0.0, -7.0)),
        camera,
        ..Default::default()
    };
    let lens = CameraOverrides { aperture: Some(8.0), ..Default::default() };
    assert_eq!(applied(new(lens.clone()), None).unwrap().optics.lens.unwrap().focus, 7.0);
    let parallel = applied(new(kind(CameraKind::Orthographic)), None).unwrap().optics.projection;
    let Projection::Orthographic { height } = parallel else { panic!("{parallel:?}") };
    assert!((height - 14.0 * 20f32.to_radians().tan()).abs() < 1e-5);
    // The target of a model's camera is anywhere along its view.
    refused(of(lens), &["the lens has no focus distance", "give focus"]);
    refused(of(kind(CameraKind::Orthographic)), &["the orthographic camera has no height", "give ortho_height"]);
    // What is made up shows all of the model.
    assert!(applied(of(kind(CameraKind::Orthographic)), None).is_ok());
}

#[test]
fn kinds_have_their_numbers() {
    let projection = |camera: CameraOverrides| optics(camera).projection;
    let high = CameraOverrides { ortho_height: Some(4.0), ..kind(CameraKind::Orthographic) };
    assert_eq!(projection(high), Projection::Orthographic { height: 4.0 });
    let wide = CameraOverrides { ortho_width: Some(6.0), ..kind(CameraKind::Orthographic) };
    assert_eq!(projection(wide), Projection::Orthographic { height: 4.0 });
    let panorama = Projection::Panorama { eye_distance: None };
    assert_eq!(projection(kind(CameraKind::Panorama)), panorama);
    let eyes = CameraOverrides { ipd: Some(64.0), ..kind(CameraKind::Panorama) };
    assert_eq!(projection(eyes), Projection::Panorama { eye_distance: Some(0.064) });
    let fisheye = Projection::Fisheye { mapping: FisheyeMapping::Equidistant, field_of_view: 180.0 };
    assert_eq!(projection(kind(CameraKind::Fisheye)), fisheye);
    let (mapping, field_of_view) = (FisheyeMapping::Equisolid, 360.0);
    let all = CameraOverrides { fisheye: Some(mapping), fov: Some(360.0), ..kind(CameraKind::Fisheye) };
    assert_eq!(projection(all), Projection::Fisheye { mapping, field_of_view });
}

/// A picture's shape follows from the kind.
#[test]
fn pictures_have_the_shape_of_their_kind() {
    let size = |camera: CameraOverrides, width: Option<u32>, height: Option<u32>| {
        let mut scene = Scene { camera: Some(MODEL), ..Scene::default() };
        let settings = Overrides { width, height, ..of(camera) }.apply(&mut scene).unwrap();
        (settings.width, settings.height)
    };
    assert_eq!(size(kind(CameraKind::Panorama), None, None), (1024, 512));
    assert_eq!(size(kind(CameraKind::Cube), Some(600), None), (600, 100));
    assert_eq!(size(kind(CameraKind::Fisheye), None, Some(99)), (99, 99));
    let eyes = CameraOverrides { ipd: Some(64.0), ..kind(CameraKind::Panorama) };
    assert_eq!(size(eyes, Some(800), None), (800, 800));
    assert_eq!(size(CameraOverrides::default(), None, None), (512, 512));
}

#[test]
fn a_shift_is_in_parts_of_the_side_that_the_sensor_fits() {
    let shift = |sensor_fit: Option<SensorFit>| {
        optics(CameraOverrides { shift: Some(Vec2::new(0.3, -0.6)), sensor_fit, ..Default::default() }).shift
    };
    assert_eq!(shift(None), Vec2::new(0.3, -0.6));
    assert_eq!(shift(Some(SensorFit::Horizontal)), Vec2::new(0.3, -0.6));
    assert!((shift(Some(SensorFit::Vertical)) - Vec2::new(0.2, -0.4)).length() < 1e-6, "of 200 pixels, not of 300");
}

#[test]
fn options_that_do_not_go_together_are_refused() {
    let two = |camera: CameraOverrides, one: &str, other: &str| {
        refused(of(camera), &[&format!("both `{one}` and `{other}` are given"), "leave one of them out"]);
    };
    let lens = CameraOverrides { aperture: Some(8.0), focus: Some(1.0), ..Default::default() };
    two(CameraOverrides { f_number: Some(2.0), ..lens.clone() }, "aperture", "f_number");
    two(CameraOverrides { focus_at: Some(Vec3::ZERO), ..lens.clone() }, "focus", "focus_at");
    let both = Overrides { vfov: Some(40.0), ..of(CameraOverrides { focal_length: Some(35.0), ..Default::default() }) };
    refused(both, &["both `vfov` and `focal_length` are given"]);
    let behind = CameraOverrides { focus: None, focus_at: Some(Vec3::new(0.0, 0.0, 6.0)), ..lens };
    refused(of(behind), &["`focus_at` [0, 0, 6] is not in front of the camera at [0, 0, 5]"]);
    let blades = CameraOverrides { blades: Some(5), ..Default::default() };
    refused(of(blades), &["there is no lens that `blades` could be of", "give aperture in mm or f_number"]);
    let sensor = CameraOverrides { sensor: Some(Vec2::ONE), ..Default::default() };
    refused(of(sensor), &["`sensor` changes nothing by itself", "give focal_length or f_number too"]);
    let planes = CameraOverrides { near: Some(3.0), far: Some(3.0), ..Default::default() };
    refused(of(planes), &["`near` is 3 and `far` is 3", "give a near that is less than far"]);
    let of_model = CameraOverrides { model_clip: Some(true), ..Default::default() };
    refused(of(of_model), &["the camera is not one of a glTF file"]);
    let number = CameraOverrides { f_number: Some(2.0), focus: Some(1.0), ..kind(CameraKind::Orthographic) };
    refused(of(number), &["the orthographic camera does not use `f_number`", "choose perspective", "used are eye, "]);
    refused(Overrides { vfov: Some(20.0), ..of(kind(CameraKind::Fisheye)) }, &["fisheye camera does not use `vfov`"]);
    let lens = CameraOverrides { aperture: Some(8.0), ..kind(CameraKind::Panorama) };
    refused(of(lens), &["the panorama camera does not use `aperture`", "choose perspective or orthographic"]);
    let fov = CameraOverrides { fov: Some(100.0), ..Default::default() };
    refused(of(fov), &["the perspective camera does not use `fov`", "choose fisheye by --camera or type in [camera]"]);
    refused(of(kind(CameraKind::Cube)), &["a picture of 300x200 does not hold the six faces of a cube"]);
    refused(of(kind(CameraKind::Rays)), &["the rays camera has no rays", "name a file by --camera-rays"]);
    let odd = CameraOverrides { ipd: Some(64.0), ..kind(CameraKind::Panorama) };
    refused(Overrides { height: Some(201), ..of(odd) }, &["201 rows has no two halves"]);
}

#[test]
fn the_command_line_wins_over_the_scene_file() {
    let file = of(CameraOverrides {
        focal_length: Some(50.0),
        aperture: Some(8.0),
        focus: Some(2.0),
        near: Some(0.1),
        ..kind(CameraKind::Perspective)
    });
    let with = |camera: CameraOverrides| of(camera).or(file.clone()).camera;
    let number = with(CameraOverrides { f_number: Some(4.0), focus_at: Some(Vec3::ZERO), ..Default::default() });
    assert_eq!((number.aperture, number.focus, number.focal_length), (None, None, Some(50.0)));
    // Another kind leaves what it does not use, and keeps what it does.
    let panorama = with(kind(CameraKind::Panorama));
    assert_eq!(panorama, CameraOverrides { near: Some(0.1), ..kind(CameraKind::Panorama) });
    let rays = with(CameraOverrides { rays: Some("a.csv".into()), ..Default::default() });
    assert_eq!((rays.kind, rays.near, rays.focus), (None, Some(0.1), None));
    let vfov = Overrides { vfov: Some(30.0), ..Default::default() }.or(file);
    assert_eq!((vfov.vfov, vfov.camera.focal_length), (Some(30.0), None));
}

#[test]
fn a_file_of_rays_needs_no_pose_and_is_one_that_the_scene_is_read_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rays.txt");
    fs::write(&path, "0 0 1 0 0 -1\n0 0 1 0 1 -1\n").unwrap();
    let options = Overrides {
        width: Some(2),
        height: Some(1),
        ..of(CameraOverrides { rays: Some(path.clone()), ..Default::default() })
    };
    let scene = applied(options.clone(), None).unwrap();
    assert!(scene.warnings.is_empty() && scene.files == [path], "{:?}", scene.warnings);
    let Projection::Rays(table) = &scene.optics.projection else { panic!("{:?}", scene.optics) };
    assert_eq!((table.width, table.height, table.rays[0]), (2, 1, [Vec3::Z, Vec3::NEG_Z]));
    refused(Overrides { height: Some(2), ..options.clone() }, &["rays.txt:2: the file ends after 2 rays"]);
    refused(Overrides { eye: Some(Vec3::ONE), ..options }, &["the rays camera does not use `eye`"]);
}

/// Options change the camera that is there as far as they go.
#[test]
fn the_models_own_camera_is_kept() {
    let clip = Some(Clip { near: 0.1, far: 100.0 });
    let optics = Optics { projection: Projection::Orthographic { height: 3.0 }, ..Optics::default() };
    let with = |options: Overrides| {
        let mut scene = Scene { camera: Some(MODEL), camera_clip: clip, optics: optics.clone(), ..Scene::default() };
        options.apply(&mut scene).map(|_| scene.optics).map_err(|conflict| conflict.to_string())
    };
    assert_eq!(with(Overrides::default()).unwrap(), optics);
    let clipped = with(of(CameraOverrides { model_clip: Some(true), far: Some(9.0), ..Default::default() })).unwrap();
    assert_eq!(clipped.clip, Clip { near: 0.1, far: 9.0 });
    assert_eq!(clipped.projection, optics.projection);
    assert_eq!(with(of(kind(CameraKind::Perspective))).unwrap(), Optics::default());
    let new = Overrides { eye: Some(Vec3::ONE), target: Some(Vec3::ZERO), ..Default::default() };
    assert_eq!(with(new).unwrap(), Optics::default());
    let vfov = with(Overrides { vfov: Some(40.0), ..Default::default() }).unwrap_err();
    assert!(vfov.contains("the orthographic camera does not use `vfov`"), "{vfov}");
}
