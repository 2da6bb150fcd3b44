//! Cryptomattes: coverage, and the names of what is seen.

use super::*;

#[test]
fn coverage_is_what_does_not_show_the_sky() {
    let scene = slats();
    for filter in [Filter::default(), Filter::from_name("gaussian", None, None).unwrap()] {
        let cryptomatte = Cryptomatte { kinds: MatteKind::ALL.to_vec(), levels: 6 };
        let settings = Settings { width: 48, height: 40, spp: 16, filter, cryptomatte, ..Settings::default() };
        let plain = render(&scene, &Settings { cryptomatte: Cryptomatte::default(), ..settings.clone() });
        let picture = render(&scene, &settings);
        let radiance = values(&picture, "R");
        assert_eq!(radiance, values(&plain, "R"), "the picture is the same");
        let mut partly = 0;
        for kind in MatteKind::ALL {
            let channel = |pair: usize, c: &str| values(&picture, &format!("{}{pair:02}.{c}", kind.layer()));
            for (pixel, radiance) in radiance.iter().enumerate() {
                let covers: Vec<f32> = (0..3).flat_map(|pair| ["G", "A"].map(|c| channel(pair, c)[pixel])).collect();
                let sum: f32 = covers.iter().sum();
                assert!((sum - (1.0 - radiance)).abs() < 1e-6, "{kind:?}, {pixel}: {sum} and {radiance}");
                assert!(covers.is_sorted_by(|a, b| a >= b), "{covers:?}");
                partly += usize::from(covers[1] > 0.0);
                for (pair, [id, cover]) in (0..3).flat_map(|pair| [(pair, ["R", "G"]), (pair, ["B", "A"])]) {
                    let id = channel(pair, id)[pixel];
                    assert_eq!(id == 0.0, channel(pair, cover)[pixel] == 0.0);
                }
            }
        }
        assert!(partly > 100, "{partly} pixels have more than one name");
        let ids = |layer: &str| {
            let mut ids: Vec<u32> =
                values(&picture, layer).iter().map(|id| id.to_bits()).filter(|&id| id != 0).collect();
            ids.sort_unstable();
            ids.dedup();
            ids.len()
        };
        assert_eq!((ids("CryptoObject00.R"), ids("CryptoMaterial00.R")), (3, 2));
    }
}

#[test]
fn an_instance_has_the_name_of_its_object_also_where_it_emits() {
    let glowing = || {
        let mut scene = slats();
        scene.materials[1].emission = Vec3::splat(0.5);
        scene
    };
    // Five slats of an object, and one of an object without a name, which keeps its own.
    let mut instanced = glowing();
    instanced.objects = vec![Object { name: "fan".to_owned() }, Object::default()];
    for (number, mesh) in instanced.meshes[..6].iter_mut().enumerate() {
        mesh.object = Some(usize::from(number == 5));
    }
    let ups = [(0, 0.0), (0, 0.25), (1, 0.0)];
    let instance = |(object, up)| Instance { object, to_world: Affine3A::from_translation(Vec3::Y * up) };
    instanced.instances = ups.map(instance).into();
    // The same as meshes of their own.
    let mut copied = glowing();
    copied.meshes[..5].iter_mut().for_each(|mesh| mesh.name = "fan".to_owned());
    let mut higher = copied.meshes[..5].to_vec();
    higher.iter_mut().flat_map(|mesh| &mut mesh.positions).for_each(|position| position.y += 0.25);
    copied.meshes.append(&mut higher);
    let cryptomatte = Cryptomatte { kinds: vec![MatteKind::Object], levels: 6 };
    let aovs = aovs(&[("fan", "C.*<O.'fan'>"), ("rest", "C.*<[OB].[^'fan']>")]);
    let settings = Settings { width: 48, height: 40, spp: 8, cryptomatte, aovs, ..Settings::default() };
    let [instanced, copied] = [instanced, copied].map(|scene| render(&scene, &settings));
    let covered = |picture: &Picture| {
        let mut covered = BTreeMap::new();
        for (id, cover) in [("00.R", "00.G"), ("00.B", "00.A"), ("01.R", "01.G"), ("01.B", "01.A")] {
            let [id, cover] = [id, cover].map(|channel| values(picture, &format!("CryptoObject{channel}")));
            for (id, cover) in id.iter().zip(cover).filter(|(id, _)| **id != 0.0) {
                *covered.entry(id.to_bits()).or_insert(0.0) += f64::from(*cover);
            }
        }
        covered
    };
    let (found, expected) = (covered(&instanced), covered(&copied));
    assert_eq!(expected.len(), 4, "fan and three of slats");
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (id, expected) in expected {
        assert!((found[&id] - expected).abs() < 0.5, "{id:x}: {} and {expected}", found[&id]);
    }
    for picture in [&instanced, &copied] {
        assert_sum(picture, &["fan", "rest"]);
    }
    let [found, expected] = [&instanced, &copied].map(|picture| mean(picture, "fan")[0]);
    assert!(expected > 0.01 && (found - expected).abs() < 0.01 * expected, "{found}, {expected}");
}

/// Groups of an OBJ file are objects, in masks and by their names in light path expressions.
#[test]
fn groups_of_obj_are_objects() {
    let folder = tempfile::tempdir().unwrap();
    let program = Program { executable: env!("CARGO_BIN_EXE_halfdome-under-test"), folder: folder.path() };
    let square = |left: f32| format!("v {left} 0 0\nv {} 0 0\nv {} 1 0\nv {left} 1 0\n", left + 1.0, left + 1.0);
    let faces = "o chair\nf 1 2 3 4\ng seat\nf 5 6 7 8\ng\nf 9 10 11 12\n";
    program.put("room.obj", [square(0.0), square(2.0), square(4.0), faces.to_owned()].concat());
    let line = "render room.obj --eye 2.5,0.5,5 --target 2.5,0.5,0 --sky 1 --size 32x16 --spp 4 --aov --cryptomatte object \
                --lpe seat=C<..'seat'>.* --progress none -o room.exr";
    let outcome = program.run_line(line);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let picture = read_exr(&folder.path().join("room.exr")).unwrap();
    let manifest = picture.metadata.attributes.iter().find(|(name, _)| name.ends_with("/manifest")).unwrap().1;
    let names: BTreeSet<&str> = manifest.split('"').filter(|word| ["chair", "seat"].contains(word)).collect();
    assert_eq!(names, BTreeSet::from(["chair", "seat"]), "{manifest}");
    // The light of the seat is there where its object is, and nowhere else.
    let objects = values(&picture, "Id.Object");
    let seat = values(&picture, "seat.R");
    let middle = |x: usize| 8 * 32 + x;
    assert!(
        seat[middle(16)] > 0.0 && seat[middle(6)] == 0.0 && seat[middle(25)] == 0.0,
        "{:?}",
        &seat[middle(0)..middle(32)]
    );
    assert!(objects[middle(16)] == 2.0 && objects[middle(6)] == 1.0 && objects[middle(25)] == 3.0);
}
