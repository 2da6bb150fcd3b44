use std::f32::consts::{FRAC_PI_6, PI};

use super::*;
use crate::scene::{LightOverrides, LightUnits, Place, SceneFile};

/// An empty scene with the lights of a scene file in a folder with a model.
fn applied(text: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("room.obj"), "").unwrap();
    let path = folder.path().join("room.toml");
    let file = SceneFile::parse(&path, &format!("[scene]\nfile = \"room.obj\"\n{text}"))?;
    let mut scene = Scene::default();
    file.overrides.light.added.iter().for_each(|light| light.add_to(&mut scene));
    Ok(scene)
}

fn one(text: &str) -> PunctualLight {
    applied(&format!("[[light]]\n{text}")).unwrap().lights.remove(0)
}

/// Line, problem and remedy, lines counted from `type`.
fn told(text: &str) -> (usize, String, String) {
    let error = applied(&format!("[[light]]\n{text}\n")).unwrap_err();
    let Place::Line(line) = error.place else { panic!("{error}") };
    assert!(error.file.ends_with("room.toml"), "{error}");
    (line - 3, error.problem, error.remedy)
}

const POINT: &str = "type = \"point\"\nposition = [1, 2, 3]\n";
const SPOT: &str = "type = \"spot\"\nposition = [1, 2, 3]\ndirection = [0, -2, 0]\n";
const DISC: &str = "type = \"disc\"\nposition = [1, 2, 3]\ntarget = [1, 0, 3]\nradius = 2\n";
const RECTANGLE: &str = "type = \"rectangle\"\nposition = [1, 2, 3]\ndirection = [0, -1, 0]\n";

#[test]
fn points_and_suns_have_what_they_are_given() {
    let position = Vec3::new(1.0, 2.0, 3.0);
    let intensity = Vec3::new(2.0, 1.0, 0.0);
    assert_eq!(
        one(&format!("{POINT}intensity = 2\ncolor = [1, 0.5, 0]\nradius = 0.1\nname = \"bulb\"")),
        PunctualLight::Point { position, intensity, radius: 0.1 }
    );
    let PunctualLight::Point { intensity, radius, .. } = one(&format!("{POINT}power = [12, 24, 36]")) else { panic!() };
    assert!((intensity - Vec3::new(3.0, 6.0, 9.0) / PI).length() < 1e-6 && radius == 0.0);
    assert_eq!(
        one("type = \"directional\"\ndirection = [0, 0, -3]\nirradiance = [1, 2, 3]"),
        PunctualLight::Directional { direction: Vec3::NEG_Z, irradiance: Vec3::new(1.0, 2.0, 3.0), half_angle: 0.0 }
    );
    let sun = one("type = \"sun\"\ndirection = [0, 0, -1]\nirradiance = 1\nangle = 60");
    let PunctualLight::Directional { half_angle, .. } = sun else { panic!() };
    assert!((half_angle - FRAC_PI_6).abs() < 1e-6);
}

#[test]
fn spots_have_blenders_cone_or_gltfs() {
    let of = |text: &str| match one(&format!("{SPOT}{text}")) {
        PunctualLight::Spot { direction, intensity, cos_inner, cos_outer, edge, .. } => {
            assert_eq!(direction, Vec3::NEG_Y);
            (intensity.x, cos_inner, cos_outer, edge)
        }
        other => panic!("{other:?}"),
    };
    let (intensity, inner, outer, edge) = of("intensity = 3\ncone = 120\nblend = 0.5");
    assert_eq!((intensity, edge), (3.0, SpotEdge::Smooth));
    assert!((inner - 0.75).abs() < 1e-6 && (outer - 0.5).abs() < 1e-6);
    let (_, inner, outer, _) = of("intensity = 3\ncone = 180\nblend = 0");
    assert!((0.0..1e-6).contains(&outer) && outer < inner && inner < 2e-6);
    let (_, inner, outer, edge) = of("intensity = 3\ninner = 30\nouter = 60");
    assert_eq!(edge, SpotEdge::Square);
    assert!((inner - 0.75f32.sqrt()).abs() < 1e-6 && (outer - 0.5).abs() < 1e-6);
    // A smooth ramp has half of the intensity on average, and a square one a third.
    let (intensity, ..) = of("power = 10\ncone = 120\nblend = 0.5");
    assert!((intensity * 2.0 * PI * (0.25 + 0.125) - 10.0).abs() < 1e-5);
    let (intensity, ..) = of("power = 10\nouter = 90");
    assert!((intensity * 2.0 * PI / 3.0 - 10.0).abs() < 1e-5);
}

#[test]
fn lamps_are_meshes_with_a_material_of_their_own() {
    let text = format!(
        "[[light]]\n{DISC}power = 8\ntwo_sided = true\nname = \"plate\"\n[[light]]\n{RECTANGLE}size = [2, 1]\n\
         up = [1, 1, 0]\nradiance = [1, 2, 3]\n[[light]]\ntype = \"sphere\"\nposition = [0, 0, 0]\nradius = 1\nradiance = 0"
    );
    let scene = applied(&text).unwrap();
    let names: Vec<&str> = scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect();
    assert_eq!(names, ["plate", "light 2", "light 3"]);
    assert!(scene.meshes.iter().all(|mesh| mesh.is_added));
    let [plate, panel, _] = &scene.materials[..] else { panic!() };
    assert!((plate.emission - Vec3::splat(8.0 / (PI * 2.0 * PI * 4.0))).length() < 1e-6 && plate.emits_both_sides);
    assert_eq!((panel.emission, panel.inputs.base_color), (Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO));
    // As wide as along z, as up = x.
    let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
    scene.meshes[1].positions.iter().for_each(|&p| (low, high) = (low.min(p), high.max(p)));
    assert!((high - low - Vec3::new(1.0, 0.0, 2.0)).length() < 1e-6);
    assert_eq!(across(Vec3::Y, Vec3::NEG_Y), None);
}

#[test]
fn lights_without_light_are_told() {
    for (text, name) in [
        (format!("{POINT}power = 0\nname = \"bulb\""), "point light \"bulb\""),
        (format!("{DISC}radiance = 1\ncolor = 0"), "disc light"),
        ("type = \"directional\"\ndirection = [0, 0, -1]\nirradiance = 0".to_owned(), "directional light"),
    ] {
        let warnings = applied(&format!("[[light]]\n{text}")).unwrap().warnings;
        let [warning] = &warnings[..] else { panic!("{text}: {warnings:?}") };
        let expected = format!("room.toml:3: this {name} has a strength of 0: it emits nothing");
        assert!(warning.ends_with(&expected), "{warning}");
    }
    assert_eq!(applied(&format!("[[light]]\n{POINT}power = 1e-9")).unwrap().warnings, [""; 0]);
}

/// Units, sizes and sides are those of the model's lights alone.
#[test]
fn options_of_the_models_lights_leave_these_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("room.obj"), "").unwrap();
    let text =
        format!("[scene]\nfile = \"room.obj\"\n[[light]]\n{POINT}intensity = 2\n[[light]]\n{DISC}radiance = 1\n");
    let file = SceneFile::parse(&folder.path().join("room.toml"), &text).unwrap();
    let options = LightOverrides {
        light_units: Some(LightUnits::Photometric),
        light_radius: Some(1.0),
        emits_both_sides: Some(true),
        ..Default::default()
    };
    let overrides = crate::scene::Overrides { light: options, ..Default::default() }.or(file.overrides);
    let mut scene = Scene::default();
    overrides.apply(&mut scene).unwrap();
    let position = Vec3::new(1.0, 2.0, 3.0);
    assert_eq!(scene.lights, [PunctualLight::Point { position, intensity: Vec3::splat(2.0), radius: 0.0 }]);
    assert!(!scene.materials[0].emits_both_sides);
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    const KINDS: &str = "one of point, spot, directional, sun, sphere, disc, rectangle";
    let check = |text: &str, line: usize, problem: &str, remedy: &str| {
        assert_eq!(told(text), (line, problem.to_owned(), remedy.to_owned()), "{text}");
    };
    check("power = 1", 0, "this light has no type", &format!("write type = \"…\" with {KINDS}"));
    check("type = \"pont\"", 1, "light.type is \"pont\"", &format!("expected {KINDS}; did you mean `point`?"));
    check("type = \"point\"\nintensity = 1", 0, "this point light has no position", "write position = [x, y, z]");
    let sun = "type = \"directional\"\nirradiance = 1\n";
    check(sun, 0, "this directional light has no direction", "write direction = [x, y, z]");
    let not_zero = "expected three numbers x, y, z, of 1e38 at most, that are not all zero";
    check(&format!("{sun}direction = [0, 0, 0]"), 3, "light.direction is [0, 0, 0]", not_zero);
    let angle = format!("{sun}direction = [0, 0, 1]\nangle = 180");
    check(&angle, 4, "light.angle is 180", "expected a number from 0 to 179");
    let place = "expected three numbers x, y, z, of 2.1990233e12 at most";
    check("type = \"point\"\nposition = [0, 0]", 2, "light.position is [0, 0]", place);
    for (text, said, remedy) in [
        ("intensity = 1\nradius = -0.1", "light.radius is -0.1", "expected a number from 0 to 1000000000000000"),
        ("power = -1", "light.power is -1", "expected one number, or three for red, green and blue, of 0 or more"),
        ("power = nan", "light.power is nan", "expected one number, or three for red, green and blue, of 0 or more"),
        ("power = 1\nintensity = 1", "this point light has both intensity and power", "leave one of them out"),
        ("pover = 1", "unknown key \"pover\" of a point light", "did you mean `power`?"),
        (
            "cone = 1",
            "unknown key \"cone\" of a point light",
            "known are position, intensity, power, radius, type, name, group, color, profile, profile_rotation, scale",
        ),
        ("intensity = 1\nname = 3", "light.name is 3", "expected text"),
    ] {
        check(&format!("{POINT}{text}"), 2 + text.lines().count(), said, remedy);
    }
    let strength = "write intensity = … (W/sr), or power = … (W)";
    check(POINT, 0, "this point light has no intensity and no power", strength);
    for (key, said, remedy) in [
        ("cone = 181", "light.cone is 181", "expected a number that is more than 0, up to 180"),
        ("cone = 0", "light.cone is 0", "expected a number that is more than 0, up to 180"),
        ("blend = 1.5", "light.blend is 1.5", "expected a number from 0 to 1"),
        ("outer = 91", "light.outer is 91", "expected a number that is more than 0, up to 90"),
        ("outer = 20\ninner = 30", "light.inner is 30", "expected a number from 0 to 20"),
        (
            "outer = 20\ncone = 30",
            "this spot light has both cone and outer",
            "write cone and blend, or inner and outer",
        ),
        ("target = [0, 0, 0]", "this spot light has both direction and target", "leave one of them out"),
    ] {
        check(&format!("{SPOT}intensity = 1\n{key}"), 4 + key.lines().count(), said, remedy);
    }
    let remedy = "write outer = …, half the angle of the cone, degrees";
    check(&format!("{SPOT}inner = 3"), 0, "this spot light has no outer", remedy);
    for (key, said, remedy) in [
        ("radiance = 1\npower = 2", "this disc light has both radiance and power", "leave one of them out"),
        ("radiance = 1\ntwo_sided = 1", "light.two_sided is 1", "expected true or false"),
        ("direction = [0, 1, 0]", "this disc light has both direction and target", "leave one of them out"),
    ] {
        check(&format!("{DISC}{key}"), 4 + key.lines().count(), said, remedy);
    }
    let more = "expected a number that is more than 0, up to 1099511600000";
    check("type = \"sphere\"\nradius = 0", 2, "light.radius is 0", more);
    check("type = \"sphere\"\nradius = -2", 2, "light.radius is -2", more);
    let here = "type = \"disc\"\nradius = 1\nposition = [1, 2, 3]\ntarget = [1, 2, 3]";
    check(here, 4, "light.target is [1, 2, 3]", "expected another point than the position");
    let small = "type = \"sphere\"\nposition = [0, 0, 0]\nradius = 1e-25\npower = 1";
    check(small, 4, "light.power is 1", "expected less light, or a larger lamp");
    let size = "expected a width and a height, each more than 0";
    check(&format!("{RECTANGLE}size = [1, 0]"), 4, "light.size is [1, 0]", size);
    let parallel = "expected a vector that is not parallel to the direction";
    check(&format!("{RECTANGLE}size = [1, 1]\nup = [0, 2, 0]"), 5, "light.up is [0, 2, 0]", parallel);
    let all = applied("[light]\ntype = 3").unwrap_err();
    assert_eq!(
        (all.problem.as_str(), all.remedy.as_str()),
        ("`light` is not a list of tables", "write [[light]] on a line")
    );
}
