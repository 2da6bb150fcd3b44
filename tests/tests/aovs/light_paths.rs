//! Light path expressions: their channels add up to the picture, and are what they are alone.

use super::*;

/// A room with every kind of light and lobe: a layered floor, a rough metal and a clear glass ball's worth of panes, a
/// lamp and a glowing panel with names, a point light, and a sky.
fn mixed() -> Scene {
    let gloss = Inputs { base_color: Vec3::new(0.7, 0.2, 0.1), specular_weight: 1.0, ..Inputs::default() };
    let coated = Inputs { coat_weight: 0.5, coat_roughness: 0.1, fuzz_weight: 0.3, specular_roughness: 0.4, ..gloss };
    let metal = Inputs { base_metalness: 1.0, specular_roughness: 0.5, base_color: Vec3::new(0.9, 0.6, 0.3), ..gloss };
    let glass = Inputs { transmission_weight: 1.0, specular_roughness: 0.0, thin_walled: true, ..gloss };
    let frosted = Inputs { transmission_weight: 0.7, specular_roughness: 0.3, ..gloss };
    let leaf = Inputs { diffuse_transmission_weight: 0.5, ..Inputs::default() };
    let named = |name: &str, inputs: Inputs| Material { name: name.to_owned(), inputs, ..Material::default() };
    let mut panel = named("panel", Inputs::default());
    (panel.emission, panel.emits_both_sides) = (Vec3::new(1.0, 2.0, 4.0), true);
    let mut lamp = Material { light_group: "key".to_owned(), ..panel.clone() };
    lamp.emission = Vec3::new(9.0, 6.0, 3.0);
    let materials = vec![
        named("floor", coated),
        named("metal", metal),
        named("glass", glass),
        named("frosted", frosted),
        named("leaf", leaf),
        panel,
        lamp,
    ];
    let place = |name: &str, material: usize, center: Vec3, side: f32, across: [Vec3; 2]| {
        let corner = |x: f32, y: f32| center + 0.5 * side * (x * across[0] + y * across[1]);
        let triangles = quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
        Mesh { name: name.to_owned(), ..mesh(&triangles, material) }
    };
    let (level, upright) = ([Vec3::X, Vec3::NEG_Z], [Vec3::X, Vec3::Y]);
    let mut lamp = place("lamp", 6, Vec3::new(-0.5, 1.8, 0.0), 0.4, level);
    lamp.is_added = true;
    let meshes = vec![
        place("floor", 0, Vec3::ZERO, 4.0, level),
        place("back", 1, Vec3::new(0.0, 1.0, -1.5), 3.0, upright),
        place("pane", 2, Vec3::new(-0.6, 0.6, 0.3), 0.7, upright),
        place("frosted", 3, Vec3::new(0.2, 0.5, 0.2), 0.6, upright),
        place("leaf", 4, Vec3::new(0.9, 0.5, 0.0), 0.6, upright),
        place("panel", 5, Vec3::new(0.25, 0.4, -0.8), 0.6, upright),
        lamp,
    ];
    let camera =
        CameraPose { eye: Vec3::new(0.2, 1.1, 3.2), target: Vec3::new(0.0, 0.6, 0.0), up: Vec3::Y, vfov: 50.0 };
    let sky = Sky { radiance: Vec3::new(0.1, 0.15, 0.3), picture: None };
    let mut scene = Scene { meshes, materials, sky, camera: Some(camera), ..Scene::default() };
    let intensity = Vec3::new(0.5, 1.0, 0.5);
    let point = |x: f32| PunctualLight::Point { position: Vec3::new(x, 1.5, 1.0), intensity, radius: 0.0 };
    scene.add_light(point(1.0), LightLabel { name: "left".to_owned(), group: "key".to_owned() });
    scene.lights.push(point(-1.0));
    scene
}

/// The scene in a box of matte walls with a window, through which paths look for the sky.
fn indoors(mut scene: Scene) -> Scene {
    let (x, z, top) = (2.5, 4.0, 3.0);
    let wall = |from: Vec3, right: Vec3, up: Vec3| quad([from, from + right, from + right + up, from + up]);
    let (across, along, up) = (Vec3::X * 2.0 * x, Vec3::Z * 2.0 * z, Vec3::Y * (top + 0.1));
    let low = Vec3::new(-x, -0.1, -z);
    let walls = [
        wall(low, across, along),
        wall(low + along, across, up),
        wall(low, across, up),
        wall(low, along, up),
        wall(low + across, along, 0.3 * up),
        wall(low + across, 0.4 * along, up),
        wall(low + across + 0.55 * along, 0.45 * along, up),
        wall(low + up, across, along),
    ];
    let number = scene.materials.len();
    scene.materials.push(Material { name: "wall".to_owned(), ..Material::matte(Vec3::splat(0.6)) });
    scene.meshes.push(mesh(&walls.concat(), number));
    scene
}

/// The scene in a box with a pane in its window, through which paths go straight.
fn glazed(scene: Scene) -> Scene {
    let mut scene = indoors(scene);
    let corners = [[-0.8, 0.8], [0.4, 0.8], [0.4, 3.0], [-0.8, 3.0]].map(|[z, y]| Vec3::new(2.5, y, z));
    let inputs = Inputs {
        specular_weight: 1.0,
        specular_roughness: 0.0,
        transmission_weight: 1.0,
        thin_walled: true,
        ..Inputs::default()
    };
    scene.meshes.push(mesh(&quad(corners), scene.materials.len()));
    scene.materials.push(Material { name: "pane".to_owned(), inputs, ..Material::default() });
    scene
}

#[test]
fn light_through_a_window_is_the_skys() {
    // Through glass it comes as directly as without, but for what the pane reflects into the room.
    check_sky(indoors(mixed()), 700);
    check_sky(glazed(mixed()), 650);
}

fn check_sky(mut scene: Scene, least: usize) {
    scene.lights.clear();
    scene.light_labels.clear();
    scene.materials.iter_mut().for_each(|material| material.emission = Vec3::ZERO);
    // A lamp on the roof, which shines upwards.
    let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| Vec3::new(x, 5.0, z));
    scene.meshes.push(mesh(&quad(corners), scene.materials.len()));
    scene.materials.push(material(Vec3::ZERO, Vec3::ONE));
    let expressions = [("sky", "C.*B"), ("lamps", "C.*[LO]"), ("seen", "CB"), ("one", "C.B"), ("more", "C..+B")];
    let settings = Settings { width: 40, height: 36, spp: 8, aovs: aovs(&expressions), ..Settings::default() };
    let picture = render(&scene, &settings);
    assert_sum(&picture, &["sky"]);
    assert_sum(&picture, &["seen", "one", "more"]);
    assert!(values(&picture, "lamps.G").iter().all(|&value| value == 0.0));
    // Many pixels have light that came through the window: of bounces, few of eight find it.
    let lit = values(&picture, "one.G").iter().filter(|&&value| value > 0.0).count();
    assert!(lit > least, "{lit} pixels of 1440");
}

#[test]
fn disjoint_expressions_sum_to_the_picture() {
    for scene in [mixed(), indoors(mixed()), glazed(mixed())] {
        check_disjoint_expressions(&scene);
    }
}

fn check_disjoint_expressions(scene: &Scene) {
    let by_lobe = [("seen", "C[LB]"), ("d", "CD.*"), ("g", "CG.*"), ("s", "CS.*")];
    let by_length = [("none", "C."), ("one", "C.."), ("two", "C..."), ("more", "C.{4,}")];
    let by_side = [("r", "C(R.*)?[LB]"), ("t", "CT.*")];
    let by_light = [("o", "C.*O"), ("l", "C.*<[^OB]x>"), ("b", "C.*B")];
    let by_floor = [("on", "C.*<.[DGS]'floor'>.*"), ("off", "C<.[DGS][^'floor']>*[LB]")];
    let all = [&by_lobe[..], &by_length, &by_side, &by_light, &by_floor].concat();
    let base = Settings { width: 40, height: 36, spp: 8, ..Settings::default() };
    let path = |options: PathOptions| Integrator::Path(options);
    for integrator in [
        path(PathOptions::default()),
        path(PathOptions { lights: LightSampling::Naive, ..PathOptions::default() }),
        path(PathOptions { lights: LightSampling::Direct, clamp_indirect: Some(0.5), ..PathOptions::default() }),
        path(PathOptions {
            stop: Stop::Threshold { cutoff: 0.01, add_back: false },
            max_depth: 6,
            ..PathOptions::default()
        }),
    ] {
        let settings = Settings { integrator, ..base.clone() };
        let plain = render(scene, &settings);
        let picture = render(scene, &Settings { aovs: aovs(&all), light_groups: true, ..settings.clone() });
        for c in ["R", "G", "B"] {
            assert_eq!(values(&picture, c), values(&plain, c), "AOVs do not change the picture");
        }
        for group in [&by_lobe[..], &by_length, &by_side, &by_light, &by_floor] {
            let names: Vec<&str> = group.iter().map(|(name, _)| *name).collect();
            assert_sum(&picture, &names);
            for name in names {
                let is_there = values(&picture, &format!("{name}.G")).iter().any(|&value| value > 0.0);
                assert!(is_there, "{name} has light");
            }
        }
        assert_sum(&picture, &["Light_key", "Light_panel", "Light_rest", "Light_sky"]);
        let groups = picture.channels.iter().filter(|channel| channel.name.starts_with("Light_")).count();
        assert_eq!(groups, 4 * 3);
    }
}

#[test]
fn lobes_are_the_same_whether_light_is_sampled_or_found() {
    // What light samples split among lobes, paths choose by chance: in expectation that is the same, in each channel.
    let mut scene = mixed();
    scene.lights.clear();
    scene.light_labels.clear();
    let all = [
        ("rd", "C<RD>[LB]"),
        ("rg", "C<RG>[LB]"),
        ("td", "C<TD>[LB]"),
        ("tg", "C<TG>[LB]"),
        ("dd", "CDD[LB]"),
        ("gd", "CGD[LB]"),
        ("dg", "CDG[LB]"),
    ];
    let by = |lights: LightSampling, spp: u32| {
        let integrator = Integrator::Path(PathOptions { lights, max_depth: 4, ..PathOptions::default() });
        render(&scene, &Settings { width: 24, height: 20, spp, integrator, aovs: aovs(&all), ..Settings::default() })
    };
    let (sampled, found) = (by(LightSampling::Mis, 512), by(LightSampling::Naive, 8192));
    for (name, _) in all {
        let (sampled, found) = (mean(&sampled, name), mean(&found, name));
        for (a, b) in sampled.into_iter().zip(found) {
            assert!(b > 0.0 && (a - b).abs() < 0.03 * b, "{name}: {sampled:?}, {found:?}");
        }
    }
}

#[test]
fn a_mirror_and_a_diffuse_floor_are_what_they_are_alone() {
    // A matte scene has no glossy light; a light seen directly has no surface.
    let picture = render(
        &halfdome::scene::cornell_box(),
        &Settings {
            width: 32,
            height: 32,
            spp: 4,
            aovs: aovs(&[
                ("g", "C.*G.*"),
                ("t", "C.*T.*"),
                ("seen", "CO"),
                ("direct", "CDL"),
                ("red", "CD<RD'left wall'>.*"),
                ("one", "C.*<L.'light'>"),
            ]),
            ..Settings::default()
        },
    );
    for name in ["g", "t"] {
        assert_eq!(mean(&picture, name), [0.0; 3], "{name}");
    }
    assert_eq!(values(&picture, "one.R"), values(&picture, "R"));
    let [red, green, _] = mean(&picture, "red");
    assert!(red > 4.0 * green && green > 0.0, "light by way of the red wall is red: {red}, {green}");
    assert!(mean(&picture, "direct")[0] > 0.0 && mean(&picture, "seen")[0] > 0.0);
}

#[test]
fn expressions_that_cannot_be_followed_are_refused() {
    let with = |integrator: Integrator| Settings { integrator, aovs: aovs(&[("d", "CDL")]), ..Settings::default() };
    assert!(with(Integrator::Path(PathOptions::default())).check_light_paths().is_ok());
    let problem = |settings: &Settings| settings.check_light_paths().unwrap_err().to_string();
    assert!(problem(&with(Integrator::named("cached").unwrap())).contains("cached follows no light paths"));
    let stop = Stop::Threshold { cutoff: 0.1, add_back: true };
    assert!(problem(&with(Integrator::Path(PathOptions { stop, ..PathOptions::default() }))).contains("--add-back"));
    let twice = Settings { aovs: aovs(&[("d", "CDL"), ("d", "CGL")]), ..Settings::default() };
    assert!(problem(&twice).contains("two AOVs are called"));
    for name in ["", "a.b", "R", "Noisy", "CryptoObject", "Light_x", "ä"] {
        assert!(Aov::new(name, "C.*").is_err(), "{name}");
    }
}
