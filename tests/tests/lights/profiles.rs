//! Lights with photometric profiles, against closed forms.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use halfdome::scene::{PunctualLight, open};

use super::sizes::close;
use super::tables::{gltf, irradiance, irradiance_in, scene};

/// 683 cd everywhere.
const EVEN: &str = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 10\n0 180\n0\n683 683\n";

/// 683 cd times the cosine down, nothing up, with an angle every degree.
fn cosine() -> String {
    let angles: Vec<String> = (0..=90).map(|degrees| degrees.to_string()).collect();
    let candela = (0..=90).map(|degrees| (683.0 * f64::from(degrees).to_radians().cos().max(0.0)).to_string());
    let candela: Vec<String> = candela.collect();
    format!("IESNA91\nTILT=NONE\n1 1000 1 91 1 1 2 0 0 0\n1 1 10\n{}\n0\n{}\n", angles.join(" "), candela.join("\n"))
}

/// Irradiance by a light with this profile and these keys.
fn lit(profile: &str, text: &str) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lamp.ies"), profile).unwrap();
    irradiance_in(folder.path(), &format!("profile = \"lamp.ies\"\n{text}"))
}

#[test]
fn an_even_profile_is_a_point_light() {
    let place = "type = \"point\"\nposition = [1, 2, 0.5]\n";
    for more in ["", "radius = 0.3\n"] {
        let point = irradiance(&format!("{place}intensity = 1\n{more}"));
        close(lit(EVEN, &format!("{place}{more}")), point, 1e-4, "an even profile");
        close(lit(EVEN, &format!("{place}scale = 3\n{more}")), 3.0 * point, 1e-4, "three times as bright");
        close(lit(EVEN, &format!("{place}power = {}\n{more}", 4.0 * PI)), point, 1e-4, "by its power");
        close(lit(EVEN, &format!("{place}direction = [1, 2, 3]\ncolor = 0.5\n{more}")), 0.5 * point, 1e-4, "turned");
    }
}

/// `I cos α cos β / d²`, with `α` at the light and `β` at the receiver.
#[test]
fn a_cosine_profile_is_a_small_lambertian_light() {
    let above = "type = \"point\"\nposition = [0, 2, 0]\n";
    close(lit(&cosine(), above), 0.25, 1e-4, "down");
    // At 45 degrees both cosines are √½, and the square of the distance is 8.
    let aside = "position = [2, 2, 0]\n";
    close(lit(&cosine(), &format!("type = \"point\"\n{aside}")), 0.5 / 8.0, 1e-3, "aside");
    let aimed = lit(&cosine(), &format!("type = \"spot\"\n{aside}target = [0, 0, 0]\n"));
    close(aimed, FRAC_1_SQRT_2 / 8.0, 1e-3, "aimed");
    // Its power is π times the intensity on its axis.
    close(lit(&cosine(), &format!("{above}power = {PI}")), 0.25, 1e-3, "by its power");
    assert_eq!(lit(&cosine(), &format!("{above}direction = [0, 1, 0]")), 0.0, "turned away");
}

/// Twice as bright towards the zero as a quarter turn from there.
#[test]
fn profiles_turn_about_their_axis() {
    let text = "IESNA91\nTILT=NONE\n1 1 683 2 2 1 2 0 0 0\n1 1 1\n0 90\n0 90\n2 2 1 1\n";
    let above = "type = \"point\"\nposition = [-2, 2, 0]\n";
    // The receiver lies towards +x of the light, which is the zero.
    let full = 2.0 * FRAC_1_SQRT_2 / 8.0;
    close(lit(text, above), full, 1e-3, "towards the zero");
    close(lit(text, &format!("{above}profile_rotation = 90")), 0.5 * full, 1e-3, "a quarter turn away");
    close(lit(text, &format!("{above}profile_rotation = 225")), 0.75 * full, 1e-3, "between");
}

#[test]
fn what_is_wrong_with_a_profile_names_its_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("model.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    std::fs::write(folder.path().join("lamp.ies"), EVEN.replace("683 683", "683 -1")).unwrap();
    let told = |keys: &str| {
        let path = folder.path().join("scene.toml");
        let light = "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]";
        std::fs::write(&path, format!("[scene]\nfile = \"model.obj\"\n{light}\n{keys}\n")).unwrap();
        open(&path).unwrap_err().to_string()
    };
    let wrong = told("profile = \"lamp.ies\"");
    assert!(wrong.contains("lamp.ies:7: candela value 2 of 2 at 0 degrees is -1\n  help: write a number"), "{wrong}");
    let missing = told("profile = \"lam.ies\"");
    assert!(missing.contains("scene.toml:6: there is no file ") && missing.contains("photometric"), "{missing}");
    std::fs::write(folder.path().join("lamp.ies"), EVEN).unwrap();
    let both = told("profile = \"lamp.ies\"\nintensity = 2");
    assert!(both.contains("scene.toml:7: unknown key \"intensity\" of a point light with a profile"), "{both}");
    let alone = told("intensity = 2\nscale = 2");
    assert!(alone.contains("scene.toml:7: unknown key \"scale\"") && alone.contains("too"), "{alone}");
    std::fs::write(folder.path().join("lamp.ies"), EVEN.replace("683 683", "0 0")).unwrap();
    assert!(told("profile = \"lamp.ies\"\npower = 2").contains("a profile without light has no power"));
}

/// `EXT_lights_ies`: the axis is -z of the node, and the zero x.
#[test]
fn profiles_of_gltf_are_those_of_tables() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a lamp.ies"), cosine()).unwrap();
    let gltf = gltf(
        r#"{"translation": [1, 2, 3], "rotation": [-0.7071068, 0, 0, 0.7071068],
            "extensions": {"EXT_lights_ies": {"light": 0, "multiplier": 2, "color": [1, 0.5, 0]}}}"#,
        r#""extensionsUsed": ["EXT_lights_ies"], "extensionsRequired": ["EXT_lights_ies"],
        "extensions": {"EXT_lights_ies": {"lights": [{"uri": "a%20lamp.ies"}]}}"#,
    );
    let path = folder.path().join("model.gltf");
    std::fs::write(&path, &gltf).unwrap();
    let (by_gltf, _) = open(&path).unwrap();
    assert!(by_gltf.warnings.is_empty(), "{:?}", by_gltf.warnings);
    let [PunctualLight::Profiled { position, frame, intensity, profile, .. }] = &by_gltf.lights[..] else { panic!() };
    // The model's lights are in its own units, which are taken for W/sr.
    let text = "[[light]]\ntype = \"point\"\nposition = [1, 2, 3]\nprofile = \"a lamp.ies\"\nscale = 1366\ncolor = [1, 0.5, 0]";
    let by_table = scene(folder.path(), text);
    let [PunctualLight::Profiled { position: p, frame: f, intensity: i, profile: q, .. }] = &by_table.lights[..] else {
        panic!()
    };
    assert_eq!((position, profile), (p, q));
    assert!((frame.axis - f.axis).length() < 1e-6 && (frame.zero - f.zero).length() < 1e-6, "{frame:?}, not {f:?}");
    assert!((*intensity - *i).length() < 1e-6, "{intensity}, not {i}");
    assert!(by_table.files.iter().any(|file| file.ends_with("a lamp.ies")));

    // In the file itself, with an error: `IES 1 2`.
    std::fs::write(&path, gltf.replace("a%20lamp.ies", "data:application/x-ies-lm-63;base64,SUVTIDEgMg==")).unwrap();
    let error = open(&path).unwrap_err().to_string();
    assert!(error.contains("light profile 0: line 1: its version is \"IES 1 2\""), "{error}");
    std::fs::write(&path, gltf.replace("\"light\": 0", "\"light\": 1")).unwrap();
    assert!(open(&path).unwrap_err().problem.contains("light profile 1, which does not exist"));
    std::fs::write(folder.path().join("a lamp.ies"), "IESNA91\nTILT=NONE\n1 2").unwrap();
    std::fs::write(&path, &gltf).unwrap();
    let error = open(&path).unwrap_err().to_string();
    assert!(error.contains("lamp.ies:3: the file ends before the multiplier of candela"), "{error}");
}
