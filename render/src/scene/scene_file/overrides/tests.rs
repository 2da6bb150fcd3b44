use std::path::Path;

use clap::{CommandFactory as _, Parser};

use super::*;
use crate::scene::cornell_box;
use crate::scene::{CameraPose, LightUnits, Mesh, PunctualLight, Variant};

/// A scene of one triangle with `camera` after `overrides` are applied, and the settings.
fn applied(overrides: &Overrides, camera: Option<CameraPose>) -> Result<(Scene, Settings), Conflict> {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], ..Default::default() };
    let mut scene = Scene { meshes: vec![mesh], materials: vec![Default::default()], camera, ..Scene::default() };
    let settings = overrides.apply(&mut scene)?;
    Ok((scene, settings))
}

#[test]
fn one_option_changes_the_models_camera_and_two_points_make_a_new_one() {
    let model = CameraPose { eye: Vec3::ONE, target: Vec3::ZERO, up: Vec3::Z, vfov: 70.0 };
    let aside = Vec3::new(3.0, 0.0, 0.0);
    let eye = Some(aside);
    let camera = |overrides: Overrides| applied(&overrides, Some(model)).unwrap().0.camera.unwrap();
    assert_eq!(camera(Overrides::default()), model);
    assert_eq!(camera(Overrides { eye, ..Default::default() }), CameraPose { eye: aside, ..model });
    let new = camera(Overrides { eye, target: Some(Vec3::Y), ..Default::default() });
    assert_eq!(new, CameraPose { eye: aside, target: Vec3::Y, up: Vec3::Y, vfov: 40.0 });
    let long = camera(Overrides { up: Some(Vec3::new(0.0, 1e30, 0.0)), ..Default::default() });
    assert_eq!(long.up, Vec3::Y, "has unit length");
}

#[test]
fn a_model_without_a_camera_is_framed_and_the_user_told() {
    let (scene, _) = applied(&Overrides { vfov: Some(20.0), width: Some(1024), ..Default::default() }, None).unwrap();
    let framed = crate::scene::frame((Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)), Vec3::Y, 20.0, 2.0);
    assert_eq!(scene.camera, Some(framed));
    assert_eq!(scene.warnings.len(), 1);
}

#[test]
fn combinations_that_cannot_be_rendered_are_refused() {
    let model = Some(CameraPose { eye: Vec3::ONE, target: Vec3::ZERO, up: Vec3::Y, vfov: 70.0 });
    for wrong in [
        Overrides { eye: Some(Vec3::ZERO), ..Default::default() },
        Overrides { up: Some(Vec3::splat(-2.0)), ..Default::default() },
        Overrides { eye: Some(Vec3::splat(1e19)), ..Default::default() },
        Overrides { eye: Some(Vec3::splat(1e-30)), ..Default::default() },
        Overrides { width: Some(65_536), height: Some(4_097), ..Default::default() },
    ] {
        assert!(applied(&wrong, model).is_err(), "{wrong:?}");
    }
    assert!(applied(&Overrides { width: Some(65_536), height: Some(4_096), ..Default::default() }, model).is_ok());
}

#[test]
fn a_conflict_names_the_scene_file_that_has_a_part_in_it() {
    let shown = |arguments: Overrides, file: Overrides| {
        let error = applied(&arguments.or(file.clone()), None).unwrap_err();
        error.naming(Path::new("s.toml"), &file).to_string()
    };
    let eye = Overrides { eye: Some(Vec3::ONE), ..Default::default() };
    let target = Overrides { target: Some(Vec3::ONE), ..Default::default() };
    assert!(shown(eye.clone(), target.clone()).starts_with("s.toml: the camera's eye"));
    let wide = Overrides { width: Some(65_536), ..Default::default() };
    let high = Overrides { height: Some(65_536), ..Default::default() };
    assert!(shown(wide.clone(), high).starts_with("s.toml: 65536x65536 are"));
    let sharp = Overrides { sharpness: Some(0.5), ..Default::default() };
    assert!(
        shown(Overrides::default(), sharp.clone()).starts_with("s.toml: the box filter has no sharpness\n  help: ")
    );
    // What the file sets has nothing to do with these.
    let both = Overrides { height: Some(65_536), ..wide.clone() };
    assert!(shown(both, eye.clone()).starts_with("65536x65536 are"));
    assert!(shown(Overrides { target: eye.eye, ..eye }, wide).starts_with("the camera's eye"));
    assert!(shown(sharp, target).starts_with("the box filter"));
}

#[test]
fn a_filter_comes_without_the_width_and_sharpness_of_the_one_it_replaces() {
    let file = Overrides {
        filter: Some("mitchell".into()),
        filter_width: Some(3.0),
        sharpness: Some(0.5),
        ..Default::default()
    };
    let filter = |arguments: Overrides| applied(&arguments.or(file.clone()), None).unwrap().1.filter;
    assert_eq!(filter(Overrides { filter: Some("box".into()), ..Default::default() }), Filter::Box { width: 1.0 });
    let wider = Overrides { filter_width: Some(6.0), ..Default::default() };
    assert_eq!(filter(wider), Filter::Mitchell { width: 6.0, sharpness: 0.5 });
}

#[test]
fn sky_and_emission_reach_the_scene() {
    let overrides = Overrides {
        light: LightOverrides { sky: Some(Vec3::X), emits_both_sides: Some(true), ..Default::default() },
        ..Default::default()
    };
    let (scene, _) = applied(&overrides, None).unwrap();
    assert_eq!(scene.sky.radiance, Vec3::X);
    assert!(scene.materials[0].emits_both_sides);
    let (scene, _) = applied(&Overrides::default(), None).unwrap();
    assert!(!scene.materials[0].emits_both_sides);
}

#[test]
fn the_model_s_aspect_shapes_the_picture_unless_the_user_does() {
    let model = CameraPose { eye: Vec3::ONE, target: Vec3::ZERO, up: Vec3::Y, vfov: 70.0 };
    let size = |overrides: Overrides, camera| {
        let mut scene = Scene { camera, camera_aspect: Some(1.6), ..Scene::default() };
        let settings = overrides.apply(&mut scene).unwrap();
        (settings.width, settings.height)
    };
    let (width, height) = (Some(320), Some(100));
    assert_eq!(size(Overrides::default(), Some(model)), (819, 512));
    assert_eq!(size(Overrides { width, ..Default::default() }, Some(model)), (320, 200));
    assert_eq!(size(Overrides { height, ..Default::default() }, Some(model)), (160, 100));
    assert_eq!(size(Overrides { width, height, ..Default::default() }, Some(model)), (320, 100));
    // Another camera has another picture.
    let (eye, target) = (Some(Vec3::ONE), Some(Vec3::ZERO));
    assert_eq!(size(Overrides { eye, target, ..Default::default() }, Some(model)), (512, 512));
}

#[test]
fn variants_and_light_units_change_the_scene() {
    let scene = || {
        let light = PunctualLight::Point { position: Vec3::ZERO, intensity: Vec3::splat(683.0), radius: 0.0 };
        let variants = ["oak", "steel"].map(|name| Variant { name: name.to_owned(), materials: vec![(0, 1)] }).to_vec();
        let mesh = Mesh { positions: vec![Vec3::ZERO; 3], triangles: vec![[0, 1, 2]], ..Default::default() };
        Scene {
            meshes: vec![mesh],
            materials: vec![Default::default(); 2],
            lights: vec![light],
            variants,
            ..Scene::default()
        }
    };
    let mut changed = scene();
    let light_units = Some(LightUnits::Photometric);
    let light = LightOverrides { light_units, ..Default::default() };
    Overrides { light, variant: Some("oak".into()), ..Default::default() }.apply(&mut changed).unwrap();
    assert_eq!(changed.meshes[0].material, 1);
    assert_eq!(changed.lights[0], PunctualLight::Point { position: Vec3::ZERO, intensity: Vec3::ONE, radius: 0.0 });
    let error = Overrides { variant: Some("steal".into()), ..Default::default() }.apply(&mut scene()).unwrap_err();
    assert_eq!(error.to_string(), "the model has no variant \"steal\"\n  help: did you mean `steel`?");
}

/// What help calls a default is one: where an option is used, giving it changes nothing.
#[test]
fn defaults_in_help_are_true() {
    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        overrides: Overrides,
    }
    let result = |words: &[&str]| {
        let line = Line::try_parse_from(["halfdome"].iter().chain(words)).ok()?;
        let mut scene = cornell_box();
        let settings = line.overrides.apply(&mut scene).ok()?;
        Some(format!("{settings:?} {:?} {:?} {:?}", scene.camera, scene.optics, scene.sky.radiance))
    };
    let places: &[&[&str]] = &[
        &["--integrator", "path"],
        &["--integrator", "path", "--stop", "threshold"],
        &["--integrator", "montecarlo"],
        &["--integrator", "direct"],
        &["--integrator", "ao"],
        &["--integrator", "cached"],
        &["--filter", "mitchell"],
        &["--camera", "fisheye"],
        &["--camera", "perspective", "--f-number", "8", "--focus", "3"],
        &["--camera", "panorama", "--ipd", "64"],
        &["--daylight", "45,0", "--daylight-model", "hosek"],
    ];
    let mut compared = 0;
    for option in Line::command().get_arguments() {
        let (Some(name), Some(help)) = (option.get_long(), option.get_help()) else { continue };
        let help = help.to_string();
        let defaults = help.split("[default: ").skip(1).filter_map(|rest| rest.split(']').next());
        for default in defaults.filter(|default| !default.contains(' ')) {
            let given = format!("--{name}={default}");
            let used =
                places.iter().filter_map(|place| Some((result(place)?, result(&[place, &[&*given][..]].concat())?)));
            let used: Vec<_> = used.collect();
            // What is chosen once cannot be given again, as the integrator.
            if used.is_empty() {
                continue;
            }
            assert!(used.iter().any(|(without, with)| without == with), "{given}: {used:#?}");
            compared += 1;
        }
    }
    assert!(compared >= 25, "{compared} were compared");
}
