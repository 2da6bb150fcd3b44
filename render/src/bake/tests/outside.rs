//! Surfaces that cannot be seen from inside.

use super::*;

/// A house of 5 x 3 x 4 with walls half a unit thick; the side of least x is of glass, with a frame about it.
fn house() -> Scene {
    let mut inner = hollow("inner", Vec3::ZERO, vec3(5.0, 3.0, 4.0), true);
    let mut outer = hollow("outer", Vec3::splat(-0.5), vec3(5.5, 3.5, 4.5), false);
    // The first side of both is that of least x.
    let mut pane = inner.clone();
    (pane.name, pane.material, pane.triangles) = ("pane".to_owned(), 1, inner.triangles.drain(..2).collect());
    outer.triangles.drain(..2);
    let (near, far) =
        ([(0.0, 0.0), (3.0, 0.0), (3.0, 4.0), (0.0, 4.0)], [(-0.5, -0.5), (3.5, -0.5), (3.5, 4.5), (-0.5, 4.5)]);
    let corner = |x: f32| move |(y, z)| vec3(x, y, z);
    let frame = Mesh {
        name: "frame".to_owned(),
        positions: near.map(corner(0.0)).into_iter().chain(far.map(corner(-0.5))).collect(),
        triangles: (0..4).flat_map(|i| [[i, (i + 1) % 4, 4 + i], [(i + 1) % 4, 4 + (i + 1) % 4, 4 + i]]).collect(),
        ..Mesh::default()
    };
    let ground = Mesh {
        name: "ground".to_owned(),
        positions: [(-20.0, -20.0), (-20.0, 20.0), (20.0, 20.0), (20.0, -20.0)].map(|(x, z)| vec3(x, -0.6, z)).into(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    // In front of the glass, and behind the house.
    let [tree, hut] = [(-6.0, "tree"), (12.0, "hut")]
        .map(|(x, name)| hollow(name, vec3(x, -0.6, 1.0), vec3(x + 1.0, 2.0, 2.0), false));
    let mut glass = Material::matte(Vec3::ZERO);
    glass.inputs.transmission_weight = 1.0;
    // Smaller than what rays in all directions find.
    let crumb = Mesh {
        name: "crumb".to_owned(),
        positions: vec![vec3(1.0, 0.01, 1.0), vec3(1.0, 0.01, 1.0001), vec3(1.0001, 0.01, 1.0)],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    scene(vec![inner, outer, ground, pane, tree, hut, frame, crumb], vec![glowing(0.0, 0.5), glass])
}

fn left_out(scene: &Scene, places: &[Vec3]) -> Result<LeftOut, Invalid> {
    LeftOut::outside(scene, &World::for_light_query(scene.clone(), LightQuery::Surfaces).unwrap(), places)
}

/// The number of triangles of each mesh that are left out.
fn counts(scene: &Scene, left_out: &LeftOut) -> Vec<usize> {
    let of_mesh =
        |mesh: usize| (0..scene.meshes[mesh].triangles.len()).filter(|&face| left_out.has(mesh, face)).count();
    (0..scene.meshes.len()).map(of_mesh).collect()
}

#[test]
fn outer_walls_are_left_out_and_what_the_window_shows_is_not() {
    let house = house();
    for places in [&[][..], &[vec3(2.0, 1.0, 2.0)], &[vec3(2.0, 1.0, 2.0), vec3(4.9, 2.9, 3.9)]] {
        let left_out = left_out(&house, places).unwrap();
        let [inner, outer, ground, pane, tree, hut, frame, crumb] = counts(&house, &left_out)[..] else { panic!() };
        assert_eq!((inner, outer, ground, hut, crumb), (0, 10, 0, 12, 0), "{places:?}");
        assert!(tree < 12 && frame < 8 && pane == 0, "the glass and what is behind it are seen: {tree} {frame} {pane}");
        let (triangles, part) = left_out.extent(&house);
        assert!(triangles >= 22 && (0.05..0.5).contains(&part), "{triangles} {part}");
    }
}

#[test]
fn places_in_walls_and_levels_without_an_inside_are_refused() {
    let house = house();
    // Whoever is asked to look from outside sees the walls and the roof.
    let above = left_out(&house, &[vec3(2.0, 1.0, 2.0), vec3(2.0, 30.0, 2.0)]).unwrap();
    assert!((1..10).contains(&counts(&house, &above)[1]), "{:?}", counts(&house, &above));
    let nowhere = left_out(&house, &[vec3(2.0, 1.0, f32::MAX)]).unwrap_err();
    assert!(nowhere.problem.contains("is not inside a room"), "{nowhere}");
    let wall = left_out(&house, &[vec3(5.25, 1.0, 2.0)]).unwrap_err();
    assert!(wall.problem.contains("back faces"), "{wall}");
    let yard = Scene { meshes: house.meshes[2..3].to_vec(), ..house };
    assert!(left_out(&yard, &[]).unwrap_err().problem.contains("no place is inside"));
}

#[test]
fn what_is_left_out_takes_no_room_and_gets_no_light() {
    let house = house();
    let options = BakeOptions { size: 64, mode: Mode::Ao, spp: 4, ..BakeOptions::default() };
    let left_out = left_out(&house, &[]).unwrap();
    let [whole, part] = [&LeftOut::default(), &left_out].map(|it| Atlas::without(&house, it, &options).unwrap());
    let density = |atlas: &Atlas| atlas.charts[0].density();
    assert!(density(&part) > 1.1 * density(&whole), "{} {}", density(&part), density(&whole));
    assert!(part.check(&house, &options).passes());
    // The model's own coordinates stay as they are, with all triangles.
    let mut own = house.clone();
    for mesh in whole.parts.iter().map(|part| part.mesh) {
        let part = &whole.parts[mesh];
        let mesh = &mut own.meshes[part.mesh];
        let old = mesh.clone();
        mesh.positions = part.vertices.iter().map(|vertex| old.positions[vertex.source as usize]).collect();
        mesh.lightmap_texcoords = part.vertices.iter().map(|vertex| vertex.uv).collect();
        mesh.triangles = part.triangles.clone();
    }
    let kept = Atlas::without(&own, &left_out, &options).unwrap();
    assert!(kept.parts.iter().all(|part| part.layout == atlas::Layout::Kept));
    let triangles = |atlas: &Atlas| atlas.parts.iter().map(|part| part.triangles.len()).sum::<usize>();
    assert_eq!(triangles(&kept), triangles(&whole));
    assert!(kept.check(&own, &options).passes());
    let all_kept = Atlas::new(&own, &options).unwrap();
    let [lit, all] = [&kept, &all_kept].map(|atlas| Surfaces::new(&own, atlas).texels().len());
    assert!(lit < all, "{lit} of {all}");
    let world = World::for_light_query(own.clone(), LightQuery::Surfaces).unwrap();
    let bake = bake(&own, &world, kept, &options, &Checkpoint::new(0), &NeverStops).unwrap();
    let outer = bake.atlas.parts.iter().find(|part| part.mesh == 1).unwrap();
    assert!(outer.charts.iter().all(|&chart| chart == NO_CHART));
}
