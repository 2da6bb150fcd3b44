use glam::Vec2;

use super::*;
use crate::scene::{Channel, ColorSpace, Disk, Input, Texture};

/// The materials of a library in a folder with these pictures, and the warnings without the folder's name.
fn read_in(library: &str, pictures: &[(&str, [u8; 4])]) -> (Vec<Material>, Vec<Texture>, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    for (name, texel) in pictures {
        image::RgbaImage::from_raw(1, 1, texel.to_vec()).unwrap().save(folder.path().join(name)).unwrap();
    }
    let (mut materials, mut warnings) = (Vec::new(), Vec::new());
    let mut textures = TextureStore::new(&Disk, Vec::new());
    read(&folder.path().join("a.mtl"), library.as_bytes(), &mut materials, &mut textures, &mut warnings).unwrap();
    let here = format!("{}/", folder.path().display());
    (materials, textures.list, warnings.into_iter().map(|warning| warning.replace(&here, "")).collect())
}

fn read_only(library: &str) -> Vec<Material> {
    let (materials, _, warnings) = read_in(library, &[]);
    assert!(warnings.is_empty(), "{warnings:?}");
    materials
}

fn near(found: f32, expected: f32) {
    assert!((found - expected).abs() < 1e-4, "{found}, not {expected}");
}

/// Reflectance at normal incidence.
fn f0(material: &Material) -> f32 {
    let inputs = &material.inputs;
    let own = ((inputs.specular_ior - 1.0) / (inputs.specular_ior + 1.0)).powi(2);
    inputs.specular_weight * own * inputs.specular_color.x
}

#[test]
fn phong_s_exponents_become_roughness_and_ks_the_reflectance() {
    let library =
        "newmtl a\nKd 1 0 0\nKs 0.3 0.3 0.3\nNs 98\nNi 1.3\nillum 2\nnewmtl b\nKs 0.3 0.3 0.3\nNs 98\nillum 1\n";
    let [glossy, matte] = &read_only(library)[..] else { panic!() };
    // α = √(2 / 100), roughness its root.
    near(glossy.inputs.specular_roughness, 0.02_f32.sqrt().sqrt());
    near(f0(glossy), 0.3);
    assert_eq!(glossy.inputs.specular_ior, 1.3);
    assert_eq!(matte.inputs.specular_weight, 0.0, "illum 1 has no highlights");
}

#[test]
fn a_negative_exponent_is_told() {
    let (materials, _, warnings) = read_in("newmtl a\nNs -3\nKs 1 1 1\nillum 2\n", &[]);
    assert_eq!(warnings, ["a.mtl:2: `Ns` is -3, less than 0, and is taken for 0"]);
    near(materials[0].inputs.specular_roughness, 1.0);
}

#[test]
fn mirrors_glass_and_opacity() {
    let library = "newmtl metal\nKd 0 0 0\nKs 0.9 0.5 0.1\nillum 3\nnewmtl varnish\nKd 0.5 0.5 0.5\nKs 0.1 0.1 0.1\nillum 5\n\
                   newmtl glass\nillum 7\nTf 0.9 0.8 0.7\nd 0.5\nnewmtl veil\nd 0.25\n";
    let [metal, varnish, glass, veil] = &read_only(library)[..] else { panic!() };
    assert_eq!((metal.inputs.base_metalness, metal.inputs.specular_roughness), (1.0, 0.0));
    assert_eq!(metal.inputs.base_color, Vec3::new(0.9, 0.5, 0.1));
    near(f0(varnish), 0.1);
    assert_eq!((varnish.inputs.specular_roughness, varnish.inputs.base_color), (0.0, Vec3::splat(0.5)));
    assert_eq!((glass.inputs.transmission_weight, glass.inputs.thin_walled), (1.0, false));
    assert_eq!((glass.inputs.transmission_color, glass.inputs.specular_ior), (Vec3::new(0.9, 0.8, 0.7), 1.5));
    assert_eq!((glass.opacity.value, veil.opacity.value), (1.0, 0.25));
}

#[test]
fn physically_based_keys() {
    let library =
        "newmtl a\nKd 0.5 0.5 0.5\nPr 0.3\nPm 0.75\nPs 0.5\nPc 1\nPcr 0.1\naniso 0.4\nanisor 0.25\nNi 2\nKs 1 1 1\n";
    let [material] = &read_only(library)[..] else { panic!() };
    let inputs = &material.inputs;
    assert_eq!((inputs.specular_roughness, inputs.base_metalness, inputs.specular_ior), (0.3, 0.75, 2.0));
    assert_eq!((inputs.fuzz_weight, inputs.coat_weight, inputs.coat_roughness), (0.5, 1.0, 0.1));
    assert_eq!((inputs.specular_anisotropy, inputs.specular_color), (0.4, Vec3::ONE));
    near(material.tangent_rotation, core::f32::consts::FRAC_PI_2);
}

/// What Blender 5.0 writes for metal of roughness 0.15, for a plain surface of roughness 0.8, and with its physically
/// based keys for glass.
#[test]
fn blender_s_own_meaning() {
    let library = "# Blender 5.0.1 MTL File: 'None'\n# www.blender.org\n\n\
                   newmtl brass\nNs 722.5\nKa 1 1 1\nKd 0.9 0.65 0.3\nKs 0.5 0.5 0.5\nNi 1.5\nd 1\nillum 3\n\
                   newmtl wall\nNs 39.999996\nKa 1 1 1\nKd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nNi 1.5\nd 1\nillum 2\n\
                   newmtl glass\nKd 1 1 1\nKe 0 0 0\nNi 1.45\nd 1\nillum 2\nPr 0\nPm 0\nTf 1 1 1\n";
    let [brass, wall, glass] = &read_only(library)[..] else { panic!() };
    near(brass.inputs.specular_roughness, 0.15);
    assert_eq!((brass.inputs.base_metalness, brass.inputs.base_color), (1.0, Vec3::new(0.9, 0.65, 0.3)));
    near(wall.inputs.specular_roughness, 0.8);
    near(f0(wall), 0.04);
    assert_eq!((glass.inputs.transmission_weight, glass.inputs.specular_roughness), (1.0, 0.0));
    assert!(glass.base_color_tints_transmission);
}

#[test]
fn maps_vary_what_they_are_named_after() {
    let library = "newmtl a\nKs 1 1 1\nNs 98\nillum 2\nmap_Kd -s 2 3 1 -o 0.5 0.25 -clamp on a color.png\nmap_Ks color.png\n\
                   map_Ns number.png\nmap_d number.png\nmap_Ke color.png\nmap_Bump -bm 0.1 number.png\nnorm normal.png\n\
                   newmtl b\nbump -bm 2 normal.png\nmap_Pr -imfchan g color.png\nmap_Pm number.png\nmap_d leaf.png\n";
    let pictures = [
        ("a color.png", [188, 188, 188, 255]),
        ("color.png", [255, 51, 0, 255]),
        ("number.png", [128, 128, 128, 255]),
        ("normal.png", [128, 128, 255, 255]),
        ("leaf.png", [0, 255, 0, 51]),
    ];
    let (materials, textures, warnings) = read_in(library, &pictures);
    assert!(warnings.is_empty(), "{warnings:?}");
    let [a, b] = &materials[..] else { panic!() };
    // What is left out counts in full where there is a map.
    assert_eq!((a.inputs.base_color, a.emission), (Vec3::ONE, Vec3::ONE));
    let (map, target) = a.map_of(Input::BaseColor).unwrap();
    assert_eq!((target.channel, map.space), (Channel::Rgb, ColorSpace::Srgb));
    assert_eq!(map.wrap, [crate::scene::Wrap::Clamp; 2]);
    // v counts from above: the lower left corner (0, 1) goes to (0.5, 1 - 0.25).
    assert!(map.transform.transform_point2(Vec2::Y).distance(Vec2::new(0.5, 0.75)) < 1e-6);
    assert!(map.transform.transform_point2(Vec2::X).distance(Vec2::new(2.5, -2.25)) < 1e-6);
    let mean = a.mean_inputs(&textures);
    assert!((mean.base_color.x - 0.5).abs() < 0.01, "{mean:?}");
    near(mean.specular_roughness, (2.0_f32 / (98.0 * 128.0 / 255.0 + 2.0)).sqrt().sqrt());
    assert_eq!(a.opacity.map.as_ref().unwrap().1, Channel::R);
    let bump = a.bump_map.as_ref().unwrap();
    assert_eq!((bump.height, bump.texture.space), (0.1, ColorSpace::Linear));
    assert_eq!(a.normal_map.as_ref().unwrap().scale, Vec2::ONE);

    let normals = b.normal_map.as_ref().expect("the picture looks like normals");
    assert_eq!((normals.scale, b.bump_map.is_none()), (Vec2::splat(2.0), true));
    let mean = b.mean_inputs(&textures);
    near(mean.specular_roughness, 0.2);
    near(mean.base_metalness, 128.0 / 255.0);
    assert_eq!(b.opacity.map.as_ref().unwrap().1, Channel::A, "the picture has holes");
    assert_eq!(textures.len(), 6, "each file once, and the exponents' roughness");
}

#[test]
fn textures_of_other_machines_are_found_here_and_missing_ones_told() {
    let library = "newmtl a\nmap_Kd C:\\art\\color.png\nmap_Ks lost.png\nmap_Kd2 x.png\nbump\n";
    let (_, textures, warnings) = read_in(library.strip_suffix("bump\n").unwrap(), &[("color.png", [1; 4])]);
    assert_eq!(textures.len(), 1);
    assert_eq!(
        warnings,
        [
            "a.mtl: material \"a\": `map_ks` is left out: lost.png: no such file (check the path, which is relative to the \
             folder of the file that names it)",
            "a.mtl: material \"a\": `map_kd2` is not read",
        ]
    );
    let mut textures = TextureStore::new(&Disk, Vec::new());
    let error =
        read(Path::new("a.mtl"), library.as_bytes(), &mut Vec::new(), &mut textures, &mut Vec::new()).unwrap_err();
    assert_eq!(error.problem, "`bump` names no file");
}
