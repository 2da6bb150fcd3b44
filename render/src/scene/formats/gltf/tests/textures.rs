//! Textures and holes.

use std::io::Cursor;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::Vec2;
use image::{ImageFormat, RgbaImage};
use serde_json::{Value, json};

use super::*;
use crate::scene::{CoatNormal, Input, TextureFilter, TextureMap, Wrap};

/// A picture of two texels: black and transparent, and white.
fn image(format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let image = RgbaImage::from_vec(2, 1, vec![0, 0, 0, 0, 255, 255, 255, 255]).unwrap();
    match format {
        ImageFormat::Jpeg => image::DynamicImage::from(image).into_rgb8().write_to(&mut bytes, format).unwrap(),
        _ => image.write_to(&mut bytes, format).unwrap(),
    }
    bytes.into_inner()
}

fn uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// The triangle with this material and the PNG as texture 0.
fn textured(material: Value) -> Value {
    let mut document = with("/meshes/0/primitives/0/material", json!(0));
    document["materials"] = json!([material]);
    document["images"] = json!([{"uri": uri("image/png", &image(ImageFormat::Png))}]);
    document["textures"] = json!([{"source": 0}]);
    document
}

fn base(info: Value) -> Value {
    json!({"pbrMetallicRoughness": {"baseColorTexture": info, "roughnessFactor": 1}})
}

fn map_of(scene: &Scene) -> &TextureMap {
    scene.materials[0].map_of(Input::BaseColor).unwrap().0
}

#[test]
fn images_come_from_anywhere_and_once() {
    let mut document = textured(base(json!({"index": 0})));
    document["materials"][0]["emissiveTexture"] = json!({"index": 1});
    document["materials"][0]["emissiveFactor"] = json!([2, 1, 0]);
    document["textures"] = json!([{"source": 0}, {"source": 0, "sampler": 0}]);
    document["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
    let scene = parse(document.clone()).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(scene.textures.len(), 1);
    assert_eq!(scene.textures[0].mean().to_array(), [0.5; 4]);
    let map = map_of(&scene);
    assert_eq!((map.texture, map.set, map.wrap, map.filter), (0, 0, [Wrap::Repeat; 2], TextureFilter::Bilinear));
    let map = scene.materials[0].emission_map.as_ref().unwrap();
    assert_eq!((map.wrap, map.filter), ([Wrap::Clamp, Wrap::Mirror], TextureFilter::Nearest));
    assert_eq!(scene.textures[0].sample(map, Vec2::new(0.9, 0.5)).to_array(), [1.0; 4]);

    // In the buffer, and in a file whose name is escaped.
    let png = image(ImageFormat::Png);
    let bytes = [triangle_bytes(), png.clone()].concat();
    let mut in_buffer = changed(document.clone(), "/images/0", json!({"bufferView": 4, "mimeType": "image/png"}));
    let view = json!({"buffer": 0, "byteOffset": triangle_bytes().len(), "byteLength": png.len()});
    in_buffer["bufferViews"].as_array_mut().unwrap().push(view);
    assert_eq!(parse_with(in_buffer, &bytes).unwrap().textures, scene.textures);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.png"), png).unwrap();
    let mut in_file = changed(document, "/images/0", json!({"uri": "a%20b.png"}));
    in_file["buffers"] = json!([{"byteLength": 104, "uri": uri("application/octet-stream", &triangle_bytes())}]);
    let found =
        read_json(&Disk, &folder.path().join("a.gltf"), in_file.to_string().as_bytes(), &LoadOptions::default())
            .unwrap();
    assert_eq!(found.textures, scene.textures);
}

#[test]
fn jpeg_is_read() {
    let document = textured(base(json!({"index": 0})));
    let jpeg = uri("image/jpeg", &image(ImageFormat::Jpeg));
    let scene = parse(changed(document, "/images/0/uri", json!(jpeg))).unwrap();
    let mean = scene.textures[0].mean();
    assert!((mean.x - 0.5).abs() < 0.1 && mean.w == 1.0, "{mean}");
}

#[test]
fn coordinates_are_transformed_as_the_extension_says() {
    let quarter = std::f32::consts::FRAC_PI_2;
    let transform = json!({"offset": [0.5, 0.25], "rotation": quarter, "scale": [2, 4], "texCoord": 1});
    let info = json!({"index": 0, "extensions": {"KHR_texture_transform": transform}});
    let mut document = textured(base(info));
    document["extensionsRequired"] = json!(["KHR_texture_transform"]);
    let scene = parse(document).unwrap();
    let map = map_of(&scene);
    assert_eq!((map.set, scene.warnings.len()), (1, 0));
    // With v downwards, u turns counter-clockwise to -v, and v to u.
    for (from, to) in [(Vec2::ZERO, [0.5, 0.25]), (Vec2::X, [0.5, -1.75]), (Vec2::Y, [4.5, 0.25])] {
        let found = map.transform.transform_point2(from);
        assert!(found.distance(Vec2::from(to)) < 1e-5, "{from} to {found}");
    }
    let scene = parse(textured(base(json!({"index": 0, "texCoord": 2})))).unwrap();
    let expected = "model.gltf: TEXCOORD_2 is not read, so a texture's mean is used: material 0, baseColorTexture";
    assert_eq!(scene.warnings, [expected]);
}

#[test]
fn holes() {
    let material = |mode: &str, more: Value| {
        let mut material = base(json!({"index": 0}));
        material["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0.75]);
        material["alphaMode"] = json!(mode);
        material["alphaCutoff"] = more;
        let scene = parse(textured(material)).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let opacity = &scene.materials[0].opacity;
        assert_eq!(opacity.map.is_some(), mode != "OPAQUE");
        (opacity.value, opacity.cutoff)
    };
    assert_eq!(material("OPAQUE", Value::Null), (1.0, None));
    assert_eq!(material("MASK", Value::Null), (0.75, Some(0.5)));
    assert_eq!(material("MASK", json!(0.25)), (0.75, Some(0.25)));
    assert_eq!(material("BLEND", Value::Null), (0.75, None));
}

#[test]
fn an_unknown_alpha_mode_is_told() {
    let mut material = base(json!({"index": 0}));
    material["alphaMode"] = json!("CLIP");
    let scene = parse(textured(material)).unwrap();
    let expected = "model.gltf: alphaMode is none of OPAQUE, MASK and BLEND, and is taken for OPAQUE: material 0";
    assert_eq!(scene.warnings, [expected]);
    assert_eq!(scene.materials[0].opacity.value, 1.0);
}

#[test]
fn what_cannot_be_read_is_told() {
    let document = || textured(base(json!({"index": 0})));
    let missing = changed(document(), "/images/0/uri", json!("no such file.png"));
    let error = parse(missing).unwrap_err();
    assert_eq!((error.file.as_path(), error.problem.as_str()), (Path::new("no such file.png"), "no such file"));
    let damaged = uri("image/png", &image(ImageFormat::Png)[..40]);
    let told = problem(changed(document(), "/images/0/uri", json!(damaged)));
    assert!(told.starts_with("image 0: it is damaged: "), "{told}");
    let texture = changed(document(), "/materials/0/pbrMetallicRoughness/baseColorTexture/index", json!(1));
    assert_eq!(problem(texture), "material 0, baseColorTexture: it refers to texture 1, which does not exist");
    assert_eq!(
        problem(changed(document(), "/textures/0/source", json!(1))),
        "texture 0: it refers to image 1, which does not exist"
    );
    assert_eq!(problem(changed(document(), "/images/0", json!({}))), "image 0: it has no data");

    let error = parse(changed(document(), "/images/0/uri", json!(uri("image/png", b"")))).unwrap_err();
    assert_eq!((error.problem.as_str(), error.remedy.as_str()), {
        ("it is empty", "export it again; it is used by material 0, baseColorTexture")
    });

    // Another kind, with no substitute or as the only one.
    let gif = changed(document(), "/images/0/uri", json!(uri("image/gif", b"GIF89a")));
    let mut other = changed(document(), "/textures/0", json!({"extensions": {"KHR_texture_basisu": {"source": 0}}}));
    other["images"][0]["uri"] = json!(uri("image/gif", b"GIF89a"));
    for document in [gif, other] {
        let scene = parse(document).unwrap();
        assert_eq!((scene.textures.len(), scene.materials[0].maps.len()), (0, 0));
        let expected = "model.gltf: image 0: it is Gif, which is not read, so the material's factor is used alone: \
                        material 0, baseColorTexture";
        assert_eq!(scene.warnings, [expected]);
    }
}

#[test]
fn an_image_of_an_extension_goes_before_the_texture_s_own() {
    let mut document = textured(base(json!({"index": 0})));
    let mut webp = Cursor::new(Vec::new());
    RgbaImage::from_vec(1, 1, vec![51, 51, 51, 255]).unwrap().write_to(&mut webp, ImageFormat::WebP).unwrap();
    let webp = json!({"uri": uri("image/webp", &webp.into_inner())});
    document["images"].as_array_mut().unwrap().push(webp);
    document["textures"] = json!([{"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}}]);
    document["extensionsRequired"] = json!(["EXT_texture_webp"]);
    let scene = parse(document.clone()).unwrap();
    assert_eq!((scene.textures.len(), scene.textures[0].size()), (1, (1, 1)));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    // What cannot be read falls back.
    document["images"][1] = json!({"uri": uri("image/gif", b"GIF89a")});
    let scene = parse(document).unwrap();
    assert_eq!((scene.textures.len(), scene.textures[0].size()), (1, (2, 1)));
}

#[cfg(feature = "ktx2")]
#[test]
fn basis_universal_goes_before_the_texture_s_own_image_and_may_be_damaged() {
    const FILE: &[u8] = include_bytes!("../../../texture/ktx2/etc1s.ktx2");
    let document = |file: &[u8]| {
        let mut document = textured(base(json!({"index": 0})));
        document["images"].as_array_mut().unwrap().push(json!({"uri": uri("image/ktx2", file)}));
        document["textures"] = json!([{"source": 0, "extensions": {"KHR_texture_basisu": {"source": 1}}}]);
        document["extensionsRequired"] = json!(["KHR_texture_basisu"]);
        document
    };
    let scene = parse(document(FILE)).unwrap();
    assert_eq!((scene.textures.len(), scene.textures[0].size(), scene.textures[0].channels()), (1, (18, 10), 4));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let told = problem(document(&FILE[..FILE.len() / 2]));
    assert!(told.starts_with("image 1: it is damaged: "), "{told}");
}

#[test]
fn a_coat_has_its_own_normals_unless_its_map_is_that_of_the_base() {
    let read = |base: Option<Value>, coat: Option<Value>| {
        let mut clearcoat = json!({"clearcoatFactor": 1});
        if let Some(coat) = coat {
            clearcoat["clearcoatNormalTexture"] = coat;
        }
        let mut material = json!({"extensions": {"KHR_materials_clearcoat": clearcoat}});
        if let Some(base) = base {
            material["normalTexture"] = base;
        }
        let scene = parse(textured(material)).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        scene.materials[0].coat_normal.clone()
    };
    let map = |scale: f32| json!({"index": 0, "scale": scale});
    assert_eq!(read(None, None), CoatNormal::OfBase);
    assert_eq!(read(Some(map(1.0)), None), CoatNormal::OfVertices);
    assert_eq!(read(Some(map(1.0)), Some(map(1.0))), CoatNormal::OfBase);
    for base in [None, Some(map(1.0))] {
        assert!(matches!(read(base, Some(map(0.5))), CoatNormal::Map(map) if map.scale == Vec2::splat(0.5)));
    }
}
