//! Steps at seams.

use glam::Quat;

use super::*;

/// Half of a ring with a square section, its walls in `segments` flat pieces; light comes from one end.
fn corridor(segments: u32) -> Scene {
    let turned = |step: u32, radius: f32, height: f32| {
        let angle = PI * step as f32 / segments as f32;
        Quat::from_rotation_y(angle) * vec3(radius, height, 0.0)
    };
    let section = [(2.0, 0.0), (3.0, 0.0), (3.0, 1.0), (2.0, 1.0)];
    let mut walls = Mesh { name: "walls".to_owned(), ..Mesh::default() };
    for side in 0..4 {
        let (a, b) = (section[side], section[(side + 1) % 4]);
        let first = walls.positions.len() as u32;
        for step in 0..=segments {
            walls.positions.extend([turned(step, a.0, a.1), turned(step, b.0, b.1)]);
        }
        for step in 0..segments {
            let i = first + 2 * step;
            walls.triangles.extend([[i, i + 1, i + 3], [i, i + 3, i + 2]]);
        }
    }
    let end = |step: u32, name: &str, material: usize| {
        let positions = section.map(|(radius, height)| turned(step, radius, height)).to_vec();
        Mesh { name: name.to_owned(), positions, triangles: vec![[0, 1, 2], [0, 2, 3]], material, ..Mesh::default() }
    };
    let mut scene =
        scene(vec![walls, end(0, "lamp", 1), end(segments, "end", 0)], vec![glowing(0.0, 0.7), glowing(1.0, 0.0)]);
    scene.materials[1].emits_both_sides = true;
    // All fronts look inwards: towards the ring that runs through the middle.
    for mesh in &mut scene.meshes {
        for i in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(i);
            let middle = (a + b + c) / 3.0;
            let inside = (middle * vec3(1.0, 0.0, 1.0)).normalize() * 2.5 + Vec3::Y * 0.5;
            let inside = match mesh.name.as_str() {
                "lamp" => inside + Vec3::NEG_Z * 0.1,
                "end" => inside + Vec3::NEG_Z * 0.1,
                _ => inside,
            };
            if (b - a).cross(c - a).dot(inside - middle) < 0.0 {
                mesh.triangles[i].swap(1, 2);
            }
        }
    }
    scene
}

#[test]
fn a_curved_corridor_has_no_steps() {
    let corridor = corridor(24);
    for sampling in Sampling::ALL {
        let bake = baked(&corridor, &BakeOptions { sampling, size: 128, ..quick() });
        assert!(lit(&bake).iter().all(|value| value.is_finite() && value.min_element() >= 0.0));
        for by in Sampling::ALL {
            let (step, pairs) = greatest_step(&corridor, &bake, by, false);
            assert!(by == Sampling::Bicubic && sampling == Sampling::Bilinear || step < 0.005, "{sampling:?}: {step}");
            assert!(pairs > 50);
        }
    }
}

/// A floor of a large piece and three small ones beside it, whose corners lie in the middle of its side, turned so that
/// no coordinate is exact; a lamp stands over the small ones.
#[test]
fn pieces_of_different_sizes_have_no_steps() {
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
    let piece = |name: &str, [x0, x1]: [f32; 2], [z0, z1]: [f32; 2], y: f32| Mesh {
        name: name.to_owned(),
        positions: [vec3(x0, y, z1), vec3(x1, y, z1), vec3(x1, y, z0), vec3(x0, y, z0)].map(|p| turn * p).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    let mut pieces = vec![piece("large", [-1.0, 0.0], [-1.0, 1.0], 0.0)];
    for z in [[-1.0, -0.4], [-0.4, 0.5], [0.5, 1.0]] {
        pieces.push(piece("small", [0.0, 0.7], z, 0.0));
    }
    let mut lamp = Mesh { material: 1, ..piece("lamp", [0.1, 0.5], [-0.3, 0.3], 0.6) };
    lamp.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    pieces.push(lamp);
    let floor = scene(pieces, vec![glowing(0.0, 0.5), glowing(2.0, 0.0)]);
    for sampling in Sampling::ALL {
        let bake = baked(&floor, &BakeOptions { sampling, size: 128, ..quick() });
        let (step, pairs) = greatest_step(&floor, &bake, sampling, false);
        assert!(step < 0.005 && pairs > 300, "{sampling:?}: {step} at {pairs} pairs");
    }
}

/// How many equations there are at the crease of a floor, `length` deep, and a wall, `height` high, for what texels in
/// turn have.
fn equations([width, length, height]: [f32; 3], floor: [f32; 2], wall: [f32; 2]) -> usize {
    let mut corner = Mesh { name: "corner".to_owned(), ..Mesh::default() };
    corner.positions =
        [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0)]
            .map(|(x, y, z)| vec3(width * x, height * y, length * z))
            .to_vec();
    corner.triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 5], [0, 5, 4]];
    let scene = scene(vec![corner], vec![glowing(0.0, 0.5)]);
    let atlas = Atlas::new(&scene, &BakeOptions { density: Some(20.0), ..quick() }).unwrap();
    let world = World::for_light_query(scene.clone(), LightQuery::Surfaces).unwrap();
    let (lit, covered, _) = free_texels(&world, &Surfaces::new(&scene, &atlas));
    let mut page_texels = page_texels(&atlas, &lit, &covered);
    page_texels.iter_mut().for_each(|grid| grid.add_gutters(quick().padding()));
    let cuts = cuts(&atlas, 1, &shared_edges(&scene));
    let owners = &page_texels[0].owners;
    let of_floor = owners[lit.iter().find(|texel| texel.point.prim_id < 2).unwrap().index as usize];
    let of = |(i, owner): (usize, &u32)| if *owner == of_floor { floor[i % 2] } else { wall[i % 2] };
    let brightness: Vec<f32> = owners.iter().enumerate().map(of).collect();
    Seams::new(&atlas, &cuts, &page_texels, &[brightness], Sampling::Bilinear).len()
}

#[test]
fn steps_along_creases_go_as_far_as_noise_explains_them() {
    let room = [1.0, 1.0, 1.0];
    assert!(equations(room, [1.0, 1.0], [1.02, 1.02]) > 50, "steps that nobody sees are taken away");
    assert_eq!(equations(room, [1.0, 1.0], [0.7, 0.7]), 0, "what differs by more is light");
    assert!(equations(room, [0.96, 1.04], [1.11, 1.19]) > 50, "as far as noise is no reason");
    // What lies in something has rounding alone, whose steps are all there is.
    assert_eq!(equations(room, [1.0, 1.0], [0.0, 1e-9]), 0, "the dark takes no light from what is lit beside it");
    // Some four texels.
    let sill = [0.2, 1.0, 0.1];
    assert_eq!(equations(sill, [1.0, 1.0], [1.12, 1.28]), 0, "a few texels do not know their noise");
    assert!(equations(sill, [1.0, 1.0], [1.02, 1.02]) > 0);
}
