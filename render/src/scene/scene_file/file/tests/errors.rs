//! Scene files that are refused, and what the errors say.

use super::*;

#[test]
fn unknown_names_are_errors_with_the_nearest_known_one() {
    let (line, problem, remedy) = error("\n[film]\nwidht = 100\n");
    assert_eq!((line, problem.as_str()), (5, "unknown key \"widht\" in [film]"));
    assert_eq!(remedy, "did you mean `width`?");
    let (line, problem, remedy) = error("[cammera]\nvfov = 100\n");
    assert_eq!((line, problem.as_str()), (3, "unknown section \"cammera\""));
    assert_eq!(remedy, "did you mean `camera`?");
    assert_eq!(
        error("[lens]\n").2,
        "known are scene, camera, film, render, sky, light, material, object, instance, aov"
    );
    assert_eq!(
        error("[sky]\ncolour = 3").2,
        "known are radiance, rotation, scale, daylight, daylight_model, daylight_albedo, picture"
    );
    // A key is no section.
    let model = (
        "the key \"model\" is in no section",
        "name the model in its section: [scene] on a line, then file = \"a.glb\"",
    );
    let of = |text: &str| {
        let SceneError { problem, remedy, .. } = SceneFile::parse(Path::new("room.toml"), text).unwrap_err();
        (problem, remedy)
    };
    assert_eq!(of("model = \"a.glb\""), (model.0.to_owned(), model.1.to_owned()));
    assert_eq!(of("[scene]\nmodel = \"a.glb\"").1, "did you mean `file`?");
    assert_eq!(of("spp = 3").1, "write it in its section: below [render]");
    assert!(of("nothing = 3").1.starts_with("every key is in a section: [scene], [camera]"));
    assert_eq!(of("scene = \"a.glb\"").1, "write [scene] on a line, then file = \"a.glb\"");
    // A key of another section is unknown in this one.
    assert_eq!(error("[sky]\nspp = 3").1, "unknown key \"spp\" in [sky]");
    let (line, problem, _) = error("[render]\nintegrator = \"pathh\"");
    assert_eq!((line, problem.as_str()), (4, "render.integrator is \"pathh\""));
}

#[test]
fn wrong_values_are_errors_with_their_line() {
    for (line, text) in [
        (5, "[camera]\neye = [0, 0, 0]\nvfov = 180"),
        (4, "[camera]\nvfov = nan"),
        (4, "[camera]\nvfov = \"wide\""),
        (4, "[camera]\neye = [0, 0]"),
        (4, "[camera]\neye = [0, 0, inf]"),
        (4, "[camera]\neye = [0, 0, \"1\"]"),
        (4, "[camera]\nup = [0, 0, 0]"),
        (4, "[film]\nwidth = 0"),
        (4, "[film]\nwidth = 512.0"),
        (4, "[film]\nheight = 65537"),
        (4, "[film]\nheight = -1"),
        (4, "[film]\nfilter_width = 0"),
        (4, "[film]\nsharpness = 2"),
        (4, "[film]\nfilter = 3"),
        (4, "[render]\nspp = 0"),
        (4, "[render]\nmax_depth = 0"),
        (4, "[render]\nseed = -1"),
        (4, "[render]\nspp = true"),
        (4, "[render]\nlights = \"all\""),
        (4, "[render]\ncutoff = 1.5"),
        (4, "[render]\nsurvival = 0"),
        (4, "[render]\nsurvival = \"half\""),
        (4, "[render]\nrays = 0"),
        (4, "[render]\nao_distance = 0"),
        (4, "[sky]\nradiance = -0.1"),
        (4, "[sky]\npicture = \"no.hdr\""),
        (4, "[sky]\nrotation = \"west\""),
        (4, "[sky]\nscale = -1"),
        (4, "[sky]\ndaylight = [91, 0]"),
        (4, "[sky]\ndaylight_model = \"hosec\""),
        (4, "[sky]\ndaylight_albedo = 1.5"),
        (4, "[sky]\nradiance = [1, 1, -1]"),
        (4, "[sky]\nradiance = [1, 1]"),
        (4, "[sky]\nradiance = 2026-01-01"),
        (4, "[film]\nfilter_width = 65"),
        (4, "[film]\nfilter = \"lens\""),
    ] {
        let (found, problem, remedy) = error(text);
        assert_eq!(found, line, "{text}: {problem}");
        assert!(!remedy.is_empty());
    }
    let bx = error("[film]\nfilter = \"bx\"");
    assert_eq!((bx.0, bx.1.as_str()), (4, "film.filter is \"bx\""));
    assert_eq!(bx.2, "expected one of box, tent, gaussian, mitchell; did you mean `box`?");
    assert_eq!(error("[camera]\nvfov = 200").1, "camera.vfov is 200");
    assert_eq!(error("[camera]\nvfov = 200").2, "expected degrees, more than 0 and less than 180");
}

/// The command line may still change one of them.
#[test]
fn options_that_do_not_go_together_are_read() {
    for text in [
        "[camera]\neye = [1, 2, 3]\ntarget = [1, 2, 3]",
        "[camera]\neye = [0, 5, 0]\ntarget = [0, 0, 0]",
        "[film]\nwidth = 65536\nheight = 65536",
        "[film]\nfilter = \"box\"\nsharpness = 0.5",
        "[render]\nintegrator = \"ao\"\nbounces = 2",
        "[render]\nintegrator = \"montecarlo\"\nbounces = 4\nrays = 256",
    ] {
        assert!(overrides(text).apply(&mut Scene::default()).is_err(), "{text}");
    }
    let file = overrides("[film]\nwidth = 65536\nheight = 65536");
    let arguments = Overrides { height: Some(4), ..Default::default() };
    assert_eq!(arguments.or(file).apply(&mut Scene::default()).unwrap().height, 4);
}

#[test]
fn broken_toml_is_an_error_with_its_line() {
    assert_eq!(error("[film]\nwidth = \n").0, 4);
    assert_eq!(error("[film]\nwidth = 1\nwidth = 2\n").0, 5);
    assert_eq!(error("[film]\nwidth = 1\n[film\n").0, 5);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("latin1.toml");
    std::fs::write(&path, b"[scene]\n# caf\xe9\n").unwrap();
    assert_eq!(SceneFile::read(&path).unwrap_err().place, Place::Line(2));
}

#[test]
fn the_model_must_be_named_and_exist() {
    assert_eq!(parse("").unwrap_err().place, Place::File);
    assert_eq!(parse("[scene]\n").unwrap_err().problem, "no model is named");
    let missing = parse("[scene]\n\nfile = \"hall.glb\"").unwrap_err();
    assert_eq!(missing.place, Place::Line(3));
    assert!(missing.problem.ends_with("hall.glb"));
    assert_eq!(parse("scene = 3").unwrap_err().problem, "`scene` is not a section");
    let none = SceneFile::read(Path::new("/nonexistent/none.toml")).unwrap_err();
    assert_eq!(none.problem, "no such file");
}

#[test]
fn numbers_that_begin_or_end_with_a_point_are_explained() {
    for number in [".5", "5."] {
        let error =
            SceneFile::parse(Path::new("room.toml"), &format!("[sky]\nradiance = [1, {number}, 1]\n")).unwrap_err();
        assert_eq!(
            (error.place, error.remedy.as_str()),
            (Place::Line(2), "numbers have digits before and after the point: 0.5, 1.0")
        );
    }
}
