//! Scene files: every key, and what overrides what.

mod errors;

use glam::{Vec2, Vec3};
use halfdome_kernel::Quality;
use halfdome_kernel::sampling::Pattern;

use super::*;
use crate::scene::{
    CachedOverrides, CameraKind, CameraOverrides, CameraPose, Daylight, FisheyeMapping, IntegratorOverrides,
    LightOverrides, LightUnits, MomentOverrides, SensorFit, Shutter, SkyOverrides,
};
use crate::settings::Filter;
use crate::settings::{
    AoWeighting, GatherLayout, Gradients, HemisphereSampling, Integrator, LightSampling, Metric, Settings, Stop,
    Survival,
};

/// Parses `text` as the scene file `room.toml` beside a model `room.obj`.
fn parse(text: &str) -> Result<SceneFile, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("room.obj"), "").unwrap();
    SceneFile::parse(&folder.path().join("room.toml"), text)
}

/// What is wrong with `text` after a section that names the model, which takes two lines.
fn error(text: &str) -> (usize, String, String) {
    let error = parse(&format!("[scene]\nfile = \"room.obj\"\n{text}")).unwrap_err();
    let Place::Line(line) = error.place else { panic!("no line: {error}") };
    assert!(error.file.ends_with("room.toml"));
    (line, error.problem, error.remedy)
}

fn overrides(text: &str) -> Overrides {
    parse(&format!("[scene]\nfile = \"room.obj\"\n{text}")).unwrap().overrides
}

#[test]
fn every_key_sets_its_option() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("models")).unwrap();
    std::fs::write(folder.path().join("models/room.obj"), "").unwrap();
    let text = r#"
        [scene]
        file = "models/room.obj"
        emission = "both"
        lights = "photometric"
        light_radius = 0.25
        sun_angle = 0.5
        variant = "oak"
        point_radius = 0.5
        instances = "never"
        frame = 12.5
        fps = 30
        animation = ["Walk", "Camera"]
        [camera]
        model_camera = "Top"
        eye = [0, 1, 2.5]
        target = [0.0, -1.0, 0.0]
        up = [0, 0, 1]
        vfov = 45
        shutter = [-0.25, 0.25]
        shutter_ramp = 0.1
        shutter_keys = 9
        [film]
        width = 320
        height = 200
        filter = "mitchell"
        filter_width = 3
        sharpness = 0.5
        [render]
        spp = 9
        sampler = "r2"
        integrator = "heat"
        max_depth = 3
        lights = "naive"
        stop = "threshold"
        cutoff = 0.25
        add_back = true
        roulette_after = 0
        clamp_indirect = 8
        filter_glossy = 0.3
        guide = 4096
        survival = 0.8
        bounces = 2
        rays = 5
        sampling = "uniform"
        ao_weighting = "hit-length"
        ao_distance = 1.5
        cache_error = 0.75
        gradients = "rotation"
        metric = "split-sphere"
        layout = "stratified"
        record_rays = 12
        cache_bounces = 1
        seed = 18446744073709551615
        build = "fast"
        [sky]
        radiance = [0.1, 0.2, 0.3]
        picture = "models/room.obj"
        rotation = 45
        scale = 0.5
        daylight = [30, -90.5]
    "#;
    let path = folder.path().join("room.toml");
    let file = SceneFile::parse(&path, text).unwrap();
    assert_eq!(file.model, Some(folder.path().join("models/room.obj")));
    let expected = Overrides {
        eye: Some(Vec3::new(0.0, 1.0, 2.5)),
        target: Some(Vec3::new(0.0, -1.0, 0.0)),
        up: Some(Vec3::Z),
        vfov: Some(45.0),
        camera: CameraOverrides::default(),
        width: Some(320),
        height: Some(200),
        filter: Some("mitchell".into()),
        filter_width: Some(3.0),
        sharpness: Some(0.5),
        integrator: IntegratorOverrides {
            integrator: Integrator::named("heat"),
            max_depth: Some(3),
            lights: Some(LightSampling::Naive),
            stop: Stop::named("threshold"),
            cutoff: Some(0.25),
            add_back: Some(true),
            roulette_after: Some(0),
            survival: Some(Survival::Constant(0.8)),
            clamp_indirect: Some(8.0),
            filter_glossy: Some(0.3),
            guide: Some(4096),
            bounces: Some(2),
            rays: Some(5),
            sampling: Some(HemisphereSampling::Uniform),
            ao_weighting: Some(AoWeighting::HitLength),
            ao_distance: Some(1.5),
            cached: CachedOverrides {
                cache_error: Some(0.75),
                gradients: Some(Gradients::Rotation),
                metric: Some(Metric::SplitSphere),
                layout: Some(GatherLayout::Stratified),
                record_rays: Some(12),
                cache_bounces: Some(1),
                accuracy: None,
            },
        },
        spp: Some(9),
        sampler: Some(Pattern::R2),
        seed: Some(u64::MAX),
        build: Some(Quality::Fast),
        aov: None,
        aov_through: None,
        cryptomatte: None,
        cryptomatte_levels: None,
        aovs: Vec::new(),
        light_groups: None,
        light: LightOverrides {
            added: Vec::new(),
            sky: Some(Vec3::new(0.1, 0.2, 0.3)),
            sky_light: SkyOverrides {
                picture: Some(folder.path().join("models/room.obj")),
                rotation: Some(45.0),
                scale: Some(0.5),
                daylight: Some(Daylight { elevation: 30.0, azimuth: -90.5, turbidity: 3.0 }),
                daylight_model: None,
                daylight_albedo: None,
            },
            emits_both_sides: Some(true),
            light_units: Some(LightUnits::Photometric),
            light_radius: Some(0.25),
            sun_angle: Some(0.5),
        },
        variant: Some("oak".into()),
        model_camera: Some("Top".into()),
        point_radius: Some(0.5),
        instances: Some(Sharing::Never),
        moment: MomentOverrides {
            frame: Some(12.5),
            fps: Some(30.0),
            animations: Some(vec!["Walk".into(), "Camera".into()]),
            shutter: Some(Shutter { open: -0.25, close: 0.25, in_seconds: false }),
            shutter_ramp: Some(0.1),
            shutter_keys: Some(9),
        },
    };
    assert_eq!(file.overrides, expected);
}

#[test]
fn what_is_left_out_stays_unset() {
    assert_eq!(overrides(""), Overrides::default());
    assert_eq!(overrides("[sky]\nradiance = 2").light.sky, Some(Vec3::splat(2.0)));
    assert_eq!(overrides("[render]\nseed = 0x1_F").seed, Some(31));
}

#[test]
fn the_command_line_wins_and_the_rest_is_combined() {
    let file = overrides("[film]\nwidth = 100\nheight = 50\n[camera]\neye = [0, 0, 9]\ntarget = [0, 0, 0]");
    let arguments = Overrides { width: Some(200), filter: Some("tent".into()), vfov: Some(50.0), ..Default::default() };
    let mut scene = Scene::default();
    let settings = arguments.or(file).apply(&mut scene).unwrap();
    assert_eq!((settings.width, settings.height), (200, 50));
    assert!(matches!(settings.filter, Filter::Tent { .. }));
    assert_eq!(settings.spp, Settings::default().spp);
    let pose = CameraPose { eye: Vec3::new(0.0, 0.0, 9.0), target: Vec3::ZERO, up: Vec3::Y, vfov: 50.0 };
    assert_eq!(scene.camera, Some(pose));
    assert_eq!(scene.warnings, [""; 0], "nothing was made up");
}

#[test]
fn every_key_of_the_camera_sets_its_option() {
    let camera = overrides(
        r#"
        [camera]
        type = "fisheye"
        focal_length = 35
        sensor = [23.6, 15.6]
        sensor_fit = "vertical"
        shift = [0.1, -0.2]
        aperture = 8
        f_number = 2.8
        focus = 1.5
        focus_at = [1, 2, 3]
        blades = 7
        blade_rotation = -10
        anamorphic = 2
        mm_per_unit = 10
        ortho_height = 3
        ortho_width = 4
        ipd = 64
        fisheye = "equisolid"
        fov = 360
        near = 0
        far = 100
        model_clip = true
        rays = "room.obj"
        "#,
    )
    .camera;
    let rays = camera.rays.clone();
    assert!(rays.as_ref().is_some_and(|path| path.ends_with("room.obj")), "relative to the folder of the file");
    let expected = CameraOverrides {
        kind: Some(CameraKind::Fisheye),
        focal_length: Some(35.0),
        sensor: Some(Vec2::new(23.6, 15.6)),
        sensor_fit: Some(SensorFit::Vertical),
        shift: Some(Vec2::new(0.1, -0.2)),
        aperture: Some(8.0),
        f_number: Some(2.8),
        focus: Some(1.5),
        focus_at: Some(Vec3::new(1.0, 2.0, 3.0)),
        blades: Some(7),
        blade_rotation: Some(-10.0),
        anamorphic: Some(2.0),
        mm_per_unit: Some(10.0),
        ortho_height: Some(3.0),
        ortho_width: Some(4.0),
        ipd: Some(64.0),
        fisheye: Some(FisheyeMapping::Equisolid),
        fov: Some(360.0),
        near: Some(0.0),
        far: Some(100.0),
        model_clip: Some(true),
        rays,
    };
    assert_eq!(camera, expected);
}
