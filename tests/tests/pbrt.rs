//! A pbrt scene beside the same scene in another format: the pictures are equal.

use halfdome::film::Picture;
use halfdome::scene::{Overrides, open};
use halfdome::settings::Settings;
use halfdome_tests::render::render;
use tempfile::TempDir;

/// A floor, a wall, a lamp that faces down, a point light and a sky, seen through a lens by a right-handed camera.
const PBRT: &str = r#"
    Film "rgb" "integer xresolution" 48 "integer yresolution" 36
    Scale -1 1 1
    LookAt 1 2 6  0 1 0  0 1 0
    Camera "perspective" "float fov" 40 "float lensradius" 0.05 "float focaldistance" 5
    Sampler "zsobol" "integer pixelsamples" 4
    WorldBegin
    LightSource "infinite" "rgb L" [ 0.1 0.2 0.3 ]
    AttributeBegin
      Translate 1 3 2
      LightSource "point" "rgb I" [ 4 3 2 ] "float scale" 2
    AttributeEnd
    MakeNamedMaterial "floor" "string type" "diffuse" "rgb reflectance" [ 0.8 0.4 0.2 ]
    NamedMaterial "floor"
    Shape "trianglemesh" "point3 P" [ -3 0 3  3 0 3  3 0 -3  -3 0 -3 ] "integer indices" [ 0 1 2  0 2 3 ]
    AttributeBegin
      Translate 0 1.5 -2 Scale 2 1.5 1
      Material "diffuse" "rgb reflectance" [ 0.25 0.5 0.75 ]
      Shape "bilinearmesh" "point3 P" [ -1 -1 0  1 -1 0  -1 1 0  1 1 0 ]
    AttributeEnd
    AttributeBegin
      AreaLightSource "diffuse" "rgb L" [ 5 5 4 ]
      Material "diffuse" "rgb reflectance" [ 0 0 0 ]
      Shape "trianglemesh" "point3 P" [ -0.5 2.9 0.5  -0.5 2.9 -0.5  0.5 2.9 -0.5  0.5 2.9 0.5 ] "integer indices" [ 0 1 2  0 2 3 ]
    AttributeEnd
"#;

const OBJ: &str = "
    mtllib s.mtl
    v -3 0 3\nv 3 0 3\nv 3 0 -3\nv -3 0 -3
    v -2 0 -2\nv 2 0 -2\nv -2 3 -2\nv 2 3 -2
    v -0.5 2.9 0.5\nv -0.5 2.9 -0.5\nv 0.5 2.9 -0.5\nv 0.5 2.9 0.5
    usemtl floor\nf 1 2 3\nf 1 3 4
    usemtl wall\nf 5 6 8\nf 5 8 7
    usemtl lamp\nf 9 10 11\nf 9 11 12
";
const MTL: &str = "
    newmtl floor\nKd 0.8 0.4 0.2
    newmtl wall\nKd 0.25 0.5 0.75
    newmtl lamp\nKd 0 0 0\nKe 5 5 4
";
const TOML: &str = r#"
    [scene]
    file = "s.obj"
    [camera]
    eye = [1, 2, 6]
    target = [0, 1, 0]
    vfov = 40
    aperture = 100
    mm_per_unit = 1000
    focus = 5
    [sky]
    radiance = [0.1, 0.2, 0.3]
    [[light]]
    type = "point"
    position = [1, 3, 2]
    intensity = [8, 6, 4]
"#;

fn picture(folder: &TempDir, name: &str, overrides: &Overrides) -> Picture {
    let (mut scene, from_file) = open(&folder.path().join(name)).unwrap();
    let settings: Settings = overrides.clone().or(from_file).apply(&mut scene).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    render(&scene, &settings)
}

fn mean(picture: &Picture, channel: &str) -> f32 {
    let values = &picture.channel(channel).unwrap().values;
    values.iter().sum::<f32>() / values.len() as f32
}

#[test]
fn a_pbrt_scene_is_the_same_scene_in_another_format() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("s.pbrt", PBRT), ("s.obj", OBJ), ("s.mtl", MTL), ("s.toml", TOML)] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let spp = Overrides { spp: Some(16), ..Overrides::default() };
    let pbrt = picture(&folder, "s.pbrt", &spp);
    let toml = picture(&folder, "s.toml", &Overrides { width: Some(48), height: Some(36), ..spp.clone() });
    assert_eq!((pbrt.width, pbrt.height), (48, 36));
    for channel in ["R", "G", "B"] {
        let (a, b) = (&pbrt.channel(channel).unwrap().values, &toml.channel(channel).unwrap().values);
        let difference = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>() / a.len() as f32;
        assert!(difference < 0.01 * mean(&toml, channel), "{channel}: {difference} of {}", mean(&toml, channel));
    }
    // Without the mirror in front, left and right are exchanged.
    let mirrored = PBRT.replace("Scale -1 1 1\n", "");
    std::fs::write(folder.path().join("s.pbrt"), mirrored).unwrap();
    let mirrored = picture(&folder, "s.pbrt", &spp);
    let (whole, other) = (&pbrt.channel("R").unwrap().values, &mirrored.channel("R").unwrap().values);
    let flipped = |pixel: usize| pixel / 48 * 48 + 47 - pixel % 48;
    let difference = |to: &dyn Fn(usize) -> usize| -> f32 {
        (0..whole.len()).map(|pixel| (whole[pixel] - other[to(pixel)]).abs()).sum()
    };
    let (exchanged, straight) = (difference(&flipped), difference(&|pixel| pixel));
    assert!(exchanged < 0.5 * straight, "{exchanged}, {straight}");
}
