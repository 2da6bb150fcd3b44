//! `[[light]]` tables of scene files: irradiance on the axis of each lamp in closed form, and the same light by glTF.

use std::f64::consts::PI;
use std::path::Path;

use glam::Vec3;
use halfdome::irradiance::{Part, Request, Sensor, by_paths};
use halfdome::scene::{Scene, open};
use halfdome::world::World;
use halfdome_tests::render::NeverStops;

use super::sizes::close;

/// A triangle that no light of these tests reaches.
const MODEL: &str = "v 0 -9 0\nv 1 -9 0\nv 0 -9 1\nf 1 2 3\n";

pub(super) fn scene(folder: &Path, text: &str) -> Scene {
    std::fs::write(folder.join("model.obj"), MODEL).unwrap();
    let path = folder.join("scene.toml");
    std::fs::write(&path, format!("[scene]\nfile = \"model.obj\"\n{text}")).unwrap();
    let (mut scene, overrides) = open(&path).unwrap();
    overrides.apply(&mut scene).unwrap();
    scene
}

/// Irradiance at a sensor at the origin that faces up, of a light with these keys.
pub(super) fn irradiance(text: &str) -> f64 {
    let folder = tempfile::tempdir().unwrap();
    irradiance_in(folder.path(), text)
}

pub(super) fn irradiance_in(folder: &Path, text: &str) -> f64 {
    let world = World::new(scene(folder, &format!("[[light]]\n{text}\n"))).unwrap();
    let sensors = [Sensor { position: Vec3::ZERO, normal: Vec3::Y }];
    let request = Request { spp: 1 << 14, seed: 3, part: Part::Total };
    f64::from(by_paths(&world, &sensors, &request, &NeverStops).values[0].x)
}

#[test]
fn discs_light_their_axis() {
    let (radiance, radius, height) = (3.0, 0.5, 1.5);
    let disc = |more: &str| irradiance(&format!("type = \"disc\"\nposition = [0, 1.5, 0]\nradius = 0.5\n{more}"));
    let expected = PI * radiance * radius * radius / (radius * radius + height * height);
    close(disc("direction = [0, -1, 0]\nradiance = 3"), expected, 2e-3, "a disc");
    let power = PI * radiance * PI * radius * radius;
    close(disc(&format!("target = [0, 0, 0]\npower = {power}")), expected, 2e-3, "by its power");
    let both = format!("direction = [0, 1, 0]\ntwo_sided = true\npower = {}", 2.0 * power);
    close(disc(&both), expected, 2e-3, "of two sides");
    assert_eq!(disc("direction = [0, 1, 0]\nradiance = 3"), 0.0, "turned away");
}

#[test]
fn spheres_light_as_their_solid_angle() {
    let sphere = |more: &str| irradiance(&format!("type = \"sphere\"\nposition = [0, 2, 0]\nradius = 0.8\n{more}"));
    let expected = PI * 3.0 * (0.8f64 / 2.0).powi(2);
    close(sphere("radiance = 3"), expected, 5e-3, "a sphere");
    close(sphere(&format!("power = {}", PI * 3.0 * 4.0 * PI * 0.64)), expected, 5e-3, "by its power");
}

/// Of a rectangle's quarter, with its corner on the axis, sides `a` and `b` times the height.
#[test]
fn rectangles_light_as_their_form_factor() {
    let (a, b) = (0.5 * 1.2 / 1.5, 0.5 * 0.4 / 1.5);
    let part = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
    let expected = 3.0 * PI * 2.0 / PI * (part(a, b) + part(b, a));
    let rectangle =
        |more: &str| irradiance(&format!("type = \"rectangle\"\nposition = [0, 1.5, 0]\nsize = [1.2, 0.4]\n{more}"));
    close(rectangle("direction = [0, -1, 0]\nradiance = 3"), expected, 2e-3, "a rectangle");
    let power = PI * 3.0 * 1.2 * 0.4;
    close(rectangle(&format!("target = [0, 0, 0]\nup = [1, 0, 1]\npower = {power}")), expected, 2e-3, "by its power");
}

#[test]
fn points_spots_and_suns_light_by_their_intensity() {
    let at = "position = [0, 2, 0]\n";
    close(irradiance(&format!("type = \"point\"\n{at}intensity = 8\ncolor = [0.5, 1, 1]")), 1.0, 1e-5, "a point");
    close(irradiance(&format!("type = \"point\"\n{at}power = {}", 16.0 * PI)), 1.0, 1e-5, "by its power");
    let spot = format!("type = \"spot\"\n{at}target = [0, 0, 0]\n");
    close(irradiance(&format!("{spot}intensity = 8\ncone = 50\nblend = 0.3")), 2.0, 1e-5, "a spot");
    // All of it within a hemisphere, by a ramp whose square has a mean of a third.
    close(irradiance(&format!("{spot}power = {}\nouter = 90", 16.0 * PI / 3.0)), 2.0, 1e-5, "by its power");
    let sun = "type = \"directional\"\ndirection = [3, -4, 0]\nirradiance = 5\nangle = 2";
    close(irradiance(sun), 4.0, 1e-3, "a sun");
}

/// A glTF file of a triangle and such nodes and extensions.
pub(super) fn gltf(nodes: &str, extensions: &str) -> String {
    const POSITIONS: &str = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let numbers: Vec<usize> = (0..=nodes.matches("\"extensions\"").count()).collect();
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": {numbers:?}}}],
        "nodes": [{{"mesh": 0}}, {nodes}], {extensions},
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}}}]}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [0, 0, 0], "max": [1, 0, 0]}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
        "buffers": [{{"byteLength": 36, "uri": "data:application/octet-stream;base64,{POSITIONS}"}}]}}"#
    )
}

/// Lights of a glTF file, and the tables that say the same.
#[test]
fn tables_say_the_same_as_gltf() {
    let folder = tempfile::tempdir().unwrap();
    let gltf = gltf(
        r#"{"translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"translation": [0, 4, 0], "rotation": [-0.7071068, 0, 0, 0.7071068],
                "extensions": {"KHR_lights_punctual": {"light": 1}}},
            {"extensions": {"KHR_lights_punctual": {"light": 2}}}"#,
        r#""extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "intensity": 8, "color": [1, 0.5, 0.25], "extras": {"radius": 0.25}},
            {"type": "spot", "intensity": 5, "spot": {"innerConeAngle": 0.5235988, "outerConeAngle": 0.7853982}},
            {"type": "directional", "intensity": 2}]}}"#,
    );
    let path = folder.path().join("model.gltf");
    std::fs::write(&path, gltf).unwrap();
    let (by_gltf, _) = open(&path).unwrap();
    let text = "[[light]]\ntype = \"point\"\nposition = [1, 2, 3]\nintensity = 8\ncolor = [1, 0.5, 0.25]\nradius = 0.25\n\
        [[light]]\ntype = \"spot\"\nposition = [0, 4, 0]\ndirection = [0, -1, 0]\nintensity = 5\ninner = 30\nouter = 45\n\
        [[light]]\ntype = \"directional\"\ndirection = [0, 0, -1]\nirradiance = 2\n";
    let by_tables = scene(folder.path(), text);
    let [ours, theirs] =
        [&by_tables, &by_gltf].map(|scene| format!("{:.4?}", scene.lights).replace("-0.0000", "0.0000"));
    assert_eq!(ours, theirs);
    assert_eq!(by_tables.lights.len(), 3);
}
