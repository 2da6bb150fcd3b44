//! Files that include others, errors of invalid ones, and warnings about skipped content.

use std::io::Write as _;

use super::*;
use crate::scene::Place;

#[test]
fn files_are_found_beside_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(ply.as_bytes()).unwrap();
    std::fs::write(place("m.ply.gz"), packed.finish().unwrap()).unwrap();
    std::fs::create_dir(place("parts")).unwrap();
    std::fs::write(place("parts/b.pbrt"), "Translate 0 0 1\nShape \"plymesh\" \"string filename\" \"m.ply.gz\"")
        .unwrap();
    let read = |text: &str| {
        std::fs::write(place("a.pbrt"), text).unwrap();
        crate::scene::load(&place("a.pbrt"))
    };
    let scene = read(&format!("WorldBegin\nInclude \"parts/b.pbrt\"\n{TRIANGLE}")).unwrap();
    // An include leaves its transform behind, an import does not.
    assert_eq!(scene.meshes[1].positions[0].z, 1.0);
    assert_eq!(scene.files.len(), 3);
    let scene = read(&format!("WorldBegin\nImport \"parts/b.pbrt\"\n{TRIANGLE}")).unwrap();
    assert_eq!(scene.meshes[1].positions[0].z, 0.0);
    let error = read("WorldBegin\nInclude \"a.pbrt\"").unwrap_err();
    assert_eq!(error.place, Place::Line(2));
    assert!(error.problem.contains("includes itself"), "{error}");
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    for (text, line, problem) in [
        ("LookAt 0 0 0  0 0 0  0 1 0", 1, "`LookAt` has no direction"),
        ("WorldBegin\nScale 1 0 1", 2, "the transform is singular"),
        ("WorldBegin\nTranslate 1 2", 2, "`Translate` needs 3 numbers, but has 2"),
        ("WorldBegin\nTranslate 1 nan 2", 2, "needs 3 numbers"),
        ("AttributeBegin\nWorldBegin", 1, "has no `AttributeEnd`"),
        ("WorldBegin\nAttributeEnd", 2, "`AttributeEnd` has no `AttributeBegin`"),
        ("WorldBegin\nAttributeBegin\nObjectEnd", 3, "ends a `AttributeBegin`, of line 2"),
        ("WorldBegin\nShape \"spher\"", 2, "there is no shape \"spher\""),
        ("WorldBegin\nShape \"sphere\" \"float radius\" -1", 2, "`radius` of Shape \"sphere\" is -1"),
        ("WorldBegin\nShape \"sphere\" \"float radius\" [ 1 2 ]", 2, "has 2 values"),
        (
            "WorldBegin\nShape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ]\n\"integer indices\" [ 0 1 3 ]",
            3,
            "has the index 3, and 3 positions",
        ),
        ("WorldBegin\nShape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 ]", 2, "which is no multiple of 3"),
        ("WorldBegin\nMaterial \"plastic\"", 2, "pbrt-v3"),
        ("WorldBegin\nMaterial \"difuse\"", 2, "there is no material of type \"difuse\""),
        ("WorldBegin\nNamedMaterial \"x\"\nShape \"disk\"", 2, "there is no material \"x\""),
        ("WorldBegin\nObjectInstance \"x\"", 2, "there is no object \"x\""),
        ("WorldBegin\nObjectBegin \"a\"\nObjectInstance \"a\"", 3, "is shown in another object"),
        ("WorldBegin\nMaterial \"diffuse\" \"texture reflectance\" \"t\"", 2, "which is not defined"),
        ("Camera \"perspective\" \"float fov\" 180", 1, "`fov` of Camera \"perspective\" is 180"),
        ("WorldBegin\nLightSource \"infinite\" \"string filename\" \"no.exr\"", 2, "no.exr"),
        ("WorldBegin\nShape \"plymesh\" \"string filename\" \"no.ply\"", 2, "no.ply"),
        ("WorldBegin\nInclude \"no.pbrt\"", 2, "no.pbrt"),
        ("Sampler \"halton\"\n\"integer pixelsamples\" 0", 1, "takes 0 samples a pixel"),
        ("WorldBegin\nMaterial \"mix\" \"string materials\" \"a\"", 2, "does not name two materials"),
        (
            "WorldBegin\nMaterial \"mix\"\n\"string materials\" [ \"a\" \"b\" ]",
            3,
            "there is no material \"a\" to be mixed",
        ),
        ("WorldBegin\n7", 2, "stands where a directive should"),
    ] {
        let error = parse(text).expect_err(text);
        assert_eq!(error.place, Place::Line(line), "{text}: {error}");
        assert!(error.problem.contains(problem), "{text}: {error}");
        assert!(!error.remedy.is_empty());
    }
}

#[test]
fn what_is_not_read_is_counted_by_its_lines() {
    let scene = scene(&format!(
        "Sampler \"halton\" \"integer pixelsamples\" 8\nIntegrator \"volpath\"\nWorldBegin\nTranslat 1 2 3\nShapes \"x\"\nMakeNamedMedium \"m\" \"float g\" 0
        Shape \"curve\"\nLightSource \"projection\" \"string filename\" \"x\"\nMaterial \"hair\" \"float beta\" 1\n{TRIANGLE} \"float wavy\" 3"
    ));
    for part in [
        "`Integrator \"volpath\"` is not read; `--integrator` sets it: line 2",
        "`Translat` is not known and left out (did you mean `Translate`?): line 4",
        "`Shapes`",
        "media are not read: line 6",
        "a shape \"curve\" is not read: line 7",
        "a light \"projection\" is not read",
        "a material \"hair\" is not read; grey instead: line 9",
        "`wavy` of Shape \"trianglemesh\" is not read: line 10",
    ] {
        assert!(scene.warnings.iter().any(|warning| warning.contains(part)), "{part}: {:#?}", scene.warnings);
    }
    assert_eq!(scene.meshes.len(), 1);
}

/// Whatever is cut off or changed, there is no panic.
#[test]
fn damaged_scenes_do_not_panic() {
    let text = format!(
        "LookAt 0 0 -5 0 0 0 0 1 0\nCamera \"perspective\" \"float fov\" [ 40 ]\nWorldBegin\nTexture \"c\" \"spectrum\" \"checkerboard\"
        Material \"coateddiffuse\" \"texture reflectance\" \"c\"\nObjectBegin \"o\"\nShape \"sphere\" \"float radius\" 2\nObjectEnd
        ObjectInstance \"o\"\nAreaLightSource \"diffuse\" \"blackbody L\" [ 3000 ]\n{TRIANGLE}\n"
    );
    assert!(parse(&text).is_ok());
    for end in 0..text.len() {
        drop(parse(&text[..end]));
        let mut changed = text.clone().into_bytes();
        for byte in [b'"', b'[', b'0', b'-', 0xff] {
            changed[end] = byte;
            drop(read(&Disk, Path::new("a.pbrt"), &changed, Sharing::Auto));
        }
    }
}
