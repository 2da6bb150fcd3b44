use glam::Vec2;

use super::*;
use crate::material::Inputs;
use crate::scene::{
    BumpMap, Channel, CoatNormal, ColorSpace, Material, Mesh, NormalMap, Opacity, Place, Scene, SceneFile, TextureMap,
    Wrap,
};

/// A scene of two meshes and a material, after a scene file in a folder with a picture.
fn applied(text: &str) -> Result<Scene, SceneError> {
    applied_to(Material { name: "oak".to_owned(), ..Material::default() }, text)
}

fn applied_to(material: Material, text: &str) -> Result<Scene, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("room.obj"), "").unwrap();
    image::RgbImage::from_raw(1, 1, vec![255, 51, 128]).unwrap().save(folder.path().join("a.png")).unwrap();
    let path = folder.path().join("room.toml");
    let file = SceneFile::parse(&path, &format!("[scene]\nfile = \"room.obj\"\n{text}"))?;
    let mesh = |name: &str| Mesh { name: name.to_owned(), ..Mesh::default() };
    let meshes = vec![mesh("floor"), mesh("wall"), mesh("floor")];
    let mut scene = Scene { meshes, materials: vec![material], ..Scene::default() };
    apply(&file.materials, &[], &path, &mut scene)?;
    Ok(scene)
}

/// Line, problem and remedy, lines counted in `text`.
fn told(text: &str) -> (usize, String, String) {
    let error = applied(text).unwrap_err();
    let Place::Line(line) = error.place else { panic!("{error}") };
    assert!(error.file.ends_with("room.toml"), "{error}");
    (line - 2, error.problem, error.remedy)
}

#[test]
fn a_table_changes_what_it_names_and_nothing_else() {
    let scene = applied(
        "[[material]]\nname = \"oak\"\nspecular_weight = 1\nspecular_roughness = 0.25\nbase_color = 0.5\n\
         geometry_opacity = 0.5\nemission_color = [1, 0.5, 0]\nemission_luminance = 4\ntransmission_color = [0.5, 1, 1]\n\
         transmission_depth = 2\nspecular_roughness_map = { file = \"a.png\", channel = \"g\", set = 1, wrap = \"clamp\" }\n\
         geometry_normal_map = { file = \"a.png\", strength = 0.5, green = \"down\" }\nbase_color_map = \"a.png\"\n",
    )
    .unwrap();
    let [oak] = &scene.materials[..] else { panic!() };
    let expected = Inputs {
        specular_weight: 1.0,
        specular_roughness: 0.25,
        absorption: Vec3::new(2.0_f32.ln() / 2.0, 0.0, 0.0),
        ..Inputs::default()
    };
    assert!((oak.inputs.absorption - expected.absorption).abs().max_element() < 1e-6);
    assert_eq!(Inputs { absorption: expected.absorption, ..oak.inputs }, expected);
    assert_eq!((oak.opacity.value, oak.emission), (0.5, Vec3::new(4.0, 2.0, 0.0)));
    let (map, target) = oak.map_of(Input::SpecularRoughness).unwrap();
    assert_eq!((map.set, map.wrap, map.space), (1, [Wrap::Clamp; 2], ColorSpace::Linear));
    assert_eq!(target.channel, Channel::G);
    assert_eq!(oak.map_of(Input::BaseColor).unwrap().0.space, ColorSpace::Srgb);
    assert_eq!(oak.normal_map.as_ref().unwrap().scale, Vec2::new(0.5, -0.5));
    assert_eq!(scene.textures.len(), 1);
    assert!(scene.meshes.iter().all(|mesh| mesh.material == 0));
}

#[test]
fn a_new_material_goes_to_the_meshes_it_names() {
    let scene = applied("[[material]]\nname = \"brass\"\nmeshes = [\"floor\"]\nbase_metalness = 1\n").unwrap();
    let meshes: Vec<usize> = scene.meshes.iter().map(|mesh| mesh.material).collect();
    assert_eq!((meshes, scene.materials[1].inputs.base_metalness), (vec![1, 0, 1], 1.0));
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let of = |line: &str| told(&format!("[[material]]\nname = \"oak\"\n{line}\n"));
    let missing = told("[[material]]\nname = \"oka\"\n");
    assert_eq!(
        missing,
        (1, "the model has no material \"oka\"".into(), {
            "a new one names its meshes = [\"…\"]; did you mean `oak`?".into()
        })
    );
    assert_eq!(told("[[material]]\nbase_color = 1\n").1, "this material has no name");
    let (line, problem, remedy) = of("specular_roughness = nan");
    assert_eq!((line, problem.as_str()), (3, "material.specular_roughness is nan"));
    assert_eq!(remedy, "expected a number from 0 to 1");
    assert_eq!(of("specular_roughness = 1.5").2, "expected a number from 0 to 1");
    assert_eq!(of("specular_ior = 0").2, "expected a number from 1 to 100");
    assert_eq!(of("base_color = [1, 2, 0]").2, "expected one number, or three for red, green and blue, from 0 to 1");
    assert_eq!(of("specular_rougness = 0.5").2, "did you mean `specular_roughness`?");
    assert_eq!(of("geometry_thin_walled = 1").2, "expected true or false");
    assert_eq!(of("meshes = [\"flor\"]").1, "material \"oak\": the model has no mesh \"flor\"");
    assert_eq!(of("base_color_map = { file = \"a.png\", chanel = \"r\" }").2, "did you mean `channel`?");
    assert_eq!(of("base_color_map = { set = 1 }").2, "expected { file = \"…\", … }");
    let (line, problem, _) = of("base_color_map = \"lost.png\"");
    assert!(line == 3 && problem.ends_with("lost.png: no such file"), "{problem}");
}

#[test]
fn a_map_of_none_removes_the_models() {
    let map = NormalMap { texture: TextureMap::default(), scale: Vec2::ONE };
    let mut oak = Material { name: "oak".to_owned(), ..Material::default() };
    oak.add_map(TextureMap::default(), Input::BaseColor, Channel::Rgb, 0.0);
    oak.add_map(TextureMap::default(), Input::SpecularRoughness, Channel::G, 0.0);
    oak.bump_map = Some(BumpMap { texture: TextureMap::default(), channel: Channel::R, height: 1.0 });
    (oak.normal_map, oak.emission_map) = (Some(map), Some(TextureMap::default()));
    oak.opacity = Opacity { map: Some((TextureMap::default(), Channel::A)), ..oak.opacity.clone() };
    let keys =
        ["base_color_map", "geometry_bump_map", "geometry_normal_map", "emission_color_map", "geometry_opacity_map"];
    let text = keys.map(|key| format!("{key} = \"none\"\n")).concat();
    let scene = applied_to(oak, &format!("[[material]]\nname = \"oak\"\n{text}")).unwrap();
    let oak = &scene.materials[0];
    assert_eq!((oak.map_of(Input::BaseColor), &oak.normal_map, &oak.emission_map), (None, &None, &None));
    assert_eq!((&oak.bump_map, &oak.opacity.map), (&None, &None));
    assert!(oak.map_of(Input::SpecularRoughness).is_some());
}

/// What a material says of itself makes the same inputs again.
#[test]
fn a_material_printed_and_read_is_the_same() {
    let inputs = Inputs {
        base_color: Vec3::new(0.125, 0.3, 1.0),
        specular_weight: 1.0,
        specular_roughness: 0.1,
        coat_weight: 0.75,
        transmission_weight: 1.0,
        thin_walled: true,
        ..Inputs::default()
    };
    let emission = Vec3::new(3.0, 1.5, 0.0);
    let oak = Material { name: "oak".to_owned(), inputs, emission, tangent_rotation: 0.5, ..Material::default() };
    let read = applied(&oak.to_toml(&[])).unwrap().materials.remove(0);
    assert_eq!((read.inputs, read.emission), (inputs, emission));
    assert!((read.tangent_rotation - 0.5).abs() < 1e-6);
    // OpenPBR's roughness is that of plain diffuse reflection, too, but means gloss here.
    let glossy = Inputs { specular_weight: 1.0, specular_roughness: 0.3, ..Inputs::default() };
    let lines = Material { inputs: glossy, ..Material::default() }.to_toml(&[]);
    assert!(lines.contains("specular_roughness = 0.3\n") && lines.contains("base_metalness = 0.0\n"), "{lines}");
    assert!(!Material::default().to_toml(&[]).contains("roughness"));
    // A coat is smooth over bumps where the file says so, and has a map of its own.
    let map = NormalMap { texture: TextureMap::default(), scale: Vec2::ONE };
    let smooth = Material { normal_map: Some(map), coat_normal: CoatNormal::OfVertices, ..oak };
    let text = smooth.to_toml(&[crate::scene::Texture::new(1, 1, vec![[1; 4]])]);
    assert_eq!(applied(&text).unwrap().materials[0].coat_normal, CoatNormal::OfVertices, "{text}");
    let coated =
        applied("[[material]]\nname = \"oak\"\ngeometry_coat_normal_map = { file = \"a.png\", strength = 0.5 }\n")
            .unwrap();
    assert_eq!(coated.materials[0].coat_normal.map().unwrap().scale, Vec2::splat(0.5));
    assert_eq!(coated.materials[0].normal_map, None);
    let odd = Material { name: "a \"b\"\\\n".to_owned(), ..Material::default() };
    assert!(odd.to_toml(&[]).contains(r#"name = "a \"b\"\\\u000A""#), "{}", odd.to_toml(&[]));
}
