//! Lights, materials and textures.

use super::*;
use crate::scene::{Material, Opacity, PunctualLight};

/// The one material of a triangle that a material directive gives.
fn material(directive: &str) -> Material {
    let mut scene = scene(&format!("WorldBegin\n{directive}\n{TRIANGLE}"));
    assert_eq!(scene.materials.len(), 1);
    scene.materials.remove(0)
}

#[test]
fn lights_have_their_power() {
    let lights = |text: &str| scene(&format!("WorldBegin\n{text}\n{TRIANGLE}"));
    let point = lights(r#"Translate 1 2 3 LightSource "point" "rgb I" [ 1 2 3 ] "float scale" 10"#);
    let PunctualLight::Point { position, intensity, .. } = point.lights[0] else { panic!() };
    close(intensity, [10.0, 20.0, 30.0]);
    close(position, [-1.0, 2.0, 3.0]);
    let lamp = lights(r#"LightSource "point" "float power" 100"#);
    let PunctualLight::Point { intensity, .. } = lamp.lights[0] else { panic!() };
    close(intensity * 4.0 * PI / 100.0, [1.0; 3]);
    let sun = lights(r#"LightSource "distant" "rgb L" [ 2 3 4 ] "point3 from" [ 0 5 0 ] "point3 to" [ 0 0 0 ]"#);
    let PunctualLight::Directional { direction, irradiance, .. } = sun.lights[0] else { panic!() };
    close(direction, [0.0, -1.0, 0.0]);
    close(irradiance, [2.0, 3.0, 4.0]);
    let spot = lights(r#"LightSource "spot" "point3 to" [ 0 0 1 ] "float coneangle" 40 "float conedeltaangle" 10"#);
    let PunctualLight::Spot { cos_inner, cos_outer, .. } = spot.lights[0] else { panic!() };
    assert!((cos_outer - 40.0_f32.to_radians().cos()).abs() < 1e-6);
    assert!((cos_inner - 30.0_f32.to_radians().cos()).abs() < 1e-6);
    // 2π (1 - cos of the inner cone), and half of what is between the cones, as the edge is a symmetric step.
    let lamp = lights(r#"LightSource "spot" "float power" 50 "float coneangle" 40 "float conedeltaangle" 10"#);
    let PunctualLight::Spot { intensity, .. } = lamp.lights[0] else { panic!() };
    let [inner, outer] = [30.0_f32, 40.0].map(|degrees| degrees.to_radians().cos());
    close(intensity / 50.0 * 2.0 * PI * (1.0 - 0.5 * (inner + outer)), [1.0; 3]);
    let sky = lights(r#"LightSource "infinite" "rgb L" [ 0.5 1 2 ]"#);
    assert_eq!(sky.sky.radiance, Vec3::new(0.5, 1.0, 2.0));
    // A diffuse emitter of power Φ and area A has the radiance Φ / (π A).
    let text = r#"AreaLightSource "diffuse" "rgb L" [ 1 1 1 ] "float power" 12 Shape "sphere" "float radius" 2"#;
    let scene = scene(&format!("WorldBegin\n{text}"));
    let expected = 12.0 / (PI * 16.0 * PI);
    assert!((scene.materials[0].emission.x / expected - 1.0).abs() < 1e-3, "{}", scene.materials[0].emission);
    // Each triangle and each patch has the whole power; all together have an area of 2 here.
    let quads = "\"point3 P\" [ 0 0 0  1 0 0  0 1 0  1 1 0  0 2 0  1 2 0 ]";
    for (shape, lights) in [
        (format!("\"trianglemesh\" {quads} \"integer indices\" [ 0 1 2  1 3 2  2 3 4  3 5 4 ]"), 4.0),
        (format!("\"bilinearmesh\" {quads} \"integer indices\" [ 0 1 2 3  2 3 4 5 ]"), 2.0),
    ] {
        let light = "AreaLightSource \"diffuse\" \"float power\" 3";
        let scene = super::scene(&format!("WorldBegin\n{light}\nShape {shape}"));
        close(scene.materials[0].emission * PI * 2.0 / 3.0, [lights; 3]);
    }
}

#[test]
fn materials_become_closures_of_their_kind() {
    close(material(r#"Material "diffuse" "rgb reflectance" [ 0.2 0.4 0.6 ]"#).inputs.base_color, [0.2, 0.4, 0.6]);
    let glass = material(r#"Material "dielectric" "spectrum eta" "glass-BK7" "float roughness" 0"#);
    assert!((glass.dispersion - 20.0 / 64.17).abs() < 1e-6);
    let glass = glass.inputs;
    let flint = r#"Material "dielectric" "spectrum eta" [ 486.1 1.63208 587.6 1.62004 656.3 1.61503 ]"#;
    let dispersion = material(flint).dispersion;
    assert!((dispersion - 20.0 / 36.37).abs() < 1e-3, "{dispersion}");
    assert_eq!(material(r#"Material "dielectric" "float eta" 1.5"#).dispersion, 0.0);
    assert_eq!((glass.transmission_weight, glass.specular_ior, glass.thin_walled), (1.0, 1.5168, false));
    assert!(material(r#"Material "thindielectric""#).inputs.thin_walled);
    let gold = material(
        r#"Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k" "float roughness" 0.0625"#,
    );
    assert_eq!((gold.inputs.base_metalness, gold.inputs.specular_roughness), (1.0, 0.5));
    assert!(gold.inputs.base_color.x > 0.95 && gold.inputs.base_color.z < 0.4, "{}", gold.inputs.base_color);
    let plastic =
        material(r#"Material "coateddiffuse" "rgb reflectance" [ 0.5 0.5 0.5 ] "float roughness" 0.01"#).inputs;
    assert!(plastic.specular_weight == 1.0 && plastic.base_color.x < 0.4, "{plastic:?}");
    assert_eq!(material(r#"Material "coatedconductor""#).inputs.coat_weight, 1.0);
    let leaf = material(
        r#"Material "diffusetransmission" "rgb reflectance" [ 0.3 0.3 0.3 ] "rgb transmittance" [ 0.1 0.1 0.1 ]"#,
    )
    .inputs;
    assert!((leaf.diffuse_transmission_weight - 0.25).abs() < 1e-6);
    close(leaf.base_color * 0.75, [0.3; 3]);
    close(leaf.diffuse_transmission_color * 0.25, [0.1; 3]);
    let named = material(
        "MakeNamedMaterial \"red\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 1 0 0 ]\nNamedMaterial \"red\"",
    );
    assert_eq!((named.name.as_str(), named.inputs.base_color), ("red", Vec3::X));
    // An interface is not seen.
    let scene = scene(&format!("WorldBegin\nMaterial \"interface\"\n{TRIANGLE}\nMaterial \"diffuse\"\n{TRIANGLE}"));
    assert_eq!(scene.meshes.len(), 1);
}

#[test]
fn textures_scale_and_vary() {
    let checks = "Texture \"c\" \"spectrum\" \"checkerboard\" \"rgb tex1\" [ 1 0 0 ] \"rgb tex2\" [ 0 0 1 ] \"float uscale\" 2 \"float vscale\" 2";
    let scene = scene(&format!(
        "WorldBegin\n{checks}\nTexture \"dark\" \"spectrum\" \"scale\" \"texture tex\" \"c\" \"float scale\" 0.5
        Material \"diffuse\" \"texture reflectance\" \"dark\"\n{TRIANGLE}"
    ));
    let (map, texture) = (scene.materials[0].texture_maps().next().unwrap().clone(), &scene.textures[0]);
    // In pbrt's coordinates, from the lower edge; ours count from the upper one.
    let at = |u: f32, v: f32| {
        let place = map.transform.transform_point2(Vec2::new(u, 1.0 - v));
        texture.sample(&map, place).truncate()
    };
    assert_eq!([at(0.1, 0.1), at(0.6, 0.1), at(0.1, 0.6), at(0.6, 0.6)], [Vec3::X, Vec3::Z, Vec3::Z, Vec3::X]);
    assert_eq!(scene.materials[0].inputs.base_color, Vec3::splat(0.5));
    let holes = super::scene("WorldBegin\nShape \"disk\" \"float alpha\" 0.25");
    assert_eq!(holes.materials[0].opacity, Opacity { value: 0.25, ..Opacity::default() });
}

#[test]
fn mixes_lie_between_their_materials() {
    let mix = |amount: &str| {
        material(&format!(
            "MakeNamedMaterial \"red\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 0.8 0 0 ]
            MakeNamedMaterial \"blue\" \"string type\" \"diffuse\" \"rgb reflectance\" [ 0 0 0.4 ]
            Material \"mix\" \"string materials\" [ \"red\" \"blue\" ] {amount}"
        ))
    };
    close(mix("").inputs.base_color, [0.4, 0.0, 0.2]);
    // The amount is that of the second.
    close(mix("\"float amount\" 0.25").inputs.base_color, [0.6, 0.0, 0.1]);
    assert_eq!([0, 1].map(|amount| mix(&format!("\"float amount\" {amount}")).name), ["red", "blue"]);
    let note = |second: &str| {
        let first = "MakeNamedMaterial \"a\" \"string type\" \"diffuse\"";
        let second = format!("MakeNamedMaterial \"b\" \"string type\" \"{second}\"");
        let mix = "Material \"mix\" \"string materials\" [ \"a\" \"b\" ]";
        scene(&format!("WorldBegin\n{first}\n{second}\n{mix}\n{TRIANGLE}")).warnings.join("\n")
    };
    assert_eq!(note("diffuse"), "");
    assert!(note("conductor").contains("a mix of materials is one material in between"));
    assert!(note("interface").contains("line 4"));
}
